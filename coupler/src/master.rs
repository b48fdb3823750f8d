//! The master with a fixed communication step and the added-mass scheme.
//!
//! An incompressible fluid answers a body's acceleration at once with its added mass A, so a
//! scheme that exchanges loads and accelerations one after the other diverges when A exceeds the
//! body's mass, however small the step (Causin, Gerbeau and Nobile, Comput. Methods Appl. Mech.
//! Eng. 194, 2005). Here the load component hands over its load as F = F₀ − A a, the motion
//! component solves (M + A) a = F₀ + F_own, and the load component steps with that a: one
//! evaluation a step, no iteration.
//!
//! The master owns no component. Each call is given the same two again, so that the caller can
//! read them between steps with their own types. A boundary that is held or prescribed is a
//! body without free degrees of freedom; a fluid without boundaries has no motion component.

use crate::CouplerError;
use crate::interface::{
    BoundaryKinematics, Component, ComponentError, ComponentState, Load, LoadComponent,
    LoadResponse, MotionComponent,
};
use nalgebra::Point2;
use serde::{Deserialize, Serialize};

/// Couples a load component and a motion component with a fixed communication step.
#[derive(Clone, Debug)]
pub struct FixedStepMaster {
    start_time: f64,
    communication_step: f64,
    step: u64,
    /// Kinematics at the start of the step.
    before: Vec<BoundaryKinematics>,
    /// Load that the motion component felt.
    felt: Vec<Load>,
}

/// What a master reports of a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// Number of the step, from 1.
    pub step: u64,
    /// Time at the end of the step, s.
    pub time: f64,
    /// Work of the load on all bodies over the step, as the bodies felt it, J/m.
    pub interface_work: f64,
    /// Energy that the coupling made in the step, J/m: the work of the load that the load
    /// component reports on the displacement that it was told of, less `interface_work`. Zero,
    /// but for rounding, if the load was the affine function it was said to be and the bodies
    /// took the step at one go (power-bond residual, Sadjina et al., Eng. Comput. 33, 2017).
    pub power_bond_residual: f64,
}

/// The state of a whole co-simulation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedState {
    /// Start time, s.
    pub start_time: f64,
    /// Communication step, s.
    pub communication_step: f64,
    /// Steps done.
    pub step: u64,
    /// State of the load component.
    pub load: ComponentState,
    /// State of the motion component, if there is one.
    pub motion: Option<ComponentState>,
}

impl FixedStepMaster {
    /// Initializes the components at `start_time` (s), for steps of `communication_step` (s).
    ///
    /// # Errors
    /// A combination that cannot work, before anything is initialized: impossible times, numbers
    /// of boundaries that differ, or an algebraic loop that this scheme cannot close. Otherwise
    /// [`CouplerError::Component`].
    pub fn start(
        start_time: f64,
        communication_step: f64,
        load: &mut dyn LoadComponent,
        motion: Option<&mut dyn MotionComponent>,
    ) -> Result<Self, CouplerError> {
        if !(start_time.is_finite() && communication_step.is_finite() && communication_step > 0.0) {
            return Err(CouplerError::Time { start_time, communication_step });
        }
        check_combination(load, motion.as_deref())?;
        let boundaries = load.boundary_count();
        let master = Self {
            start_time,
            communication_step,
            step: 0,
            before: vec![BoundaryKinematics::at_rest(Point2::origin(), 0.0); boundaries],
            felt: vec![Load::zero(); boundaries],
        };
        master.initialize(load, motion).map_err(|source| CouplerError::Component {
            time: start_time,
            step: 0,
            source,
        })?;
        Ok(master)
    }

    fn initialize(
        &self,
        load: &mut dyn LoadComponent,
        motion: Option<&mut dyn MotionComponent>,
    ) -> Result<(), ComponentError> {
        load.enter_initialization_mode(self.start_time)?;
        if let Some(motion) = motion {
            motion.enter_initialization_mode(self.start_time)?;
            motion.exit_initialization_mode()?;
            load.set_kinematics(motion.kinematics());
        }
        load.exit_initialization_mode()
    }

    /// Time reached, s: start + steps × communication step, without the rounding of a sum.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.start_time + self.step as f64 * self.communication_step
    }

    /// Steps done.
    #[must_use]
    pub fn step_count(&self) -> u64 {
        self.step
    }

    /// The communication step, s.
    #[must_use]
    pub fn communication_step(&self) -> f64 {
        self.communication_step
    }

    /// Takes one communication step.
    ///
    /// # Errors
    /// [`CouplerError::Component`] or [`CouplerError::Length`], with time and step. The
    /// components may then stand at different times: restore a saved state or end.
    pub fn step(
        &mut self,
        load: &mut dyn LoadComponent,
        motion: Option<&mut dyn MotionComponent>,
    ) -> Result<StepReport, CouplerError> {
        let (interface_work, power_bond_residual) = match motion {
            Some(motion) => self.step_coupled(load, motion)?,
            None => self.step_alone(load)?,
        };
        self.step += 1;
        Ok(StepReport { step: self.step, time: self.time(), interface_work, power_bond_residual })
    }

    /// A step without boundaries: there is no work.
    fn step_alone(&self, load: &mut dyn LoadComponent) -> Result<(f64, f64), CouplerError> {
        let (now, h) = (self.time(), self.communication_step);
        let failed = |source| self.failed(source);
        load.set_kinematics(&[]);
        load.solve_load(now, h).map_err(failed)?;
        load.set_accelerations(&[]);
        load.do_step(now, h).map_err(failed)?;
        Ok((0.0, 0.0))
    }

    /// A step with bodies: work of the load on them and power-bond residual, J/m.
    fn step_coupled(
        &mut self,
        load: &mut dyn LoadComponent,
        motion: &mut dyn MotionComponent,
    ) -> Result<(f64, f64), CouplerError> {
        let (now, h, boundaries) = (self.time(), self.communication_step, self.before.len());
        self.check(motion, "kinematics", motion.kinematics().len(), boundaries)?;
        self.before.copy_from_slice(motion.kinematics());
        load.set_kinematics(&self.before);

        let response = load.solve_load(now, h).map_err(|source| self.failed(source))?;
        if let Some((quantity, actual, expected)) = misfit(response, boundaries) {
            return Err(self.length_error(load, quantity, actual, expected));
        }
        motion.set_load(response);
        motion.do_step(now, h).map_err(|source| self.failed(source))?;
        let accelerations = motion.mean_accelerations();
        self.check(motion, "accelerations", accelerations.len(), 3 * boundaries)?;
        response.at(accelerations, &mut self.felt);

        load.set_accelerations(accelerations);
        load.do_step(now, h).map_err(|source| self.failed(source))?;
        self.check(motion, "kinematics", motion.kinematics().len(), boundaries)?;
        self.check(load, "loads", load.loads().len(), boundaries)?;
        Ok(self.energies(load.loads(), motion.kinematics(), accelerations))
    }

    /// Work of the load felt on the displacement made, and by how much the work of the load
    /// reported on the displacement told (V h + a h²/2) exceeds it, J/m.
    fn energies(
        &self,
        reported: &[Load],
        after: &[BoundaryKinematics],
        accelerations: &[f64],
    ) -> (f64, f64) {
        let h = self.communication_step;
        let (mut felt_work, mut residual) = (0.0, 0.0);
        for (body, (before, after)) in self.before.iter().zip(after).enumerate() {
            let made = [
                after.position.x - before.position.x,
                after.position.y - before.position.y,
                after.angle - before.angle,
            ];
            let velocity = [before.velocity.x, before.velocity.y, before.angular_velocity];
            let (felt, reported) = (degrees(&self.felt[body]), degrees(&reported[body]));
            for degree in 0..3 {
                let told = velocity[degree] * h + 0.5 * accelerations[3 * body + degree] * h * h;
                let work = felt[degree] * made[degree];
                felt_work += work;
                residual += reported[degree] * told - work;
            }
        }
        (felt_work, residual)
    }

    /// Saves the whole co-simulation between two steps.
    ///
    /// # Errors
    /// [`CouplerError::NoStateSaving`], or [`CouplerError::Component`].
    pub fn save(
        &self,
        load: &dyn LoadComponent,
        motion: Option<&dyn MotionComponent>,
    ) -> Result<SavedState, CouplerError> {
        let save = |component: &dyn Component| {
            check_state_saving(component)?;
            component.get_state().map_err(|source| self.failed(source))
        };
        Ok(SavedState {
            start_time: self.start_time,
            communication_step: self.communication_step,
            step: self.step,
            load: save(load)?,
            motion: motion.map(|motion| save(motion)).transpose()?,
        })
    }

    /// Goes back, or ahead, to a saved state of the same co-simulation: from now on every step
    /// repeats to the bit what followed the save. In a new process, [`start`](Self::start) with
    /// components set up alike comes first.
    ///
    /// # Errors
    /// [`CouplerError::SavedState`] for a state of another co-simulation, or
    /// [`CouplerError::Component`]: one component may then be restored and the other not.
    pub fn restore(
        &mut self,
        load: &mut dyn LoadComponent,
        motion: Option<&mut dyn MotionComponent>,
        saved: &SavedState,
    ) -> Result<(), CouplerError> {
        let unfit = |reason: String| Err(CouplerError::SavedState { reason });
        let clock = |start: f64, step: f64| format!("start {start} s, communication step {step} s");
        let (mine, other) = (
            (self.start_time, self.communication_step),
            (saved.start_time, saved.communication_step),
        );
        if mine != other {
            return unfit(format!("{}, not {}", clock(other.0, other.1), clock(mine.0, mine.1)));
        }
        check_state_saving(load)?;
        match (motion, &saved.motion) {
            (None, None) => {}
            (Some(motion), Some(state)) => {
                check_state_saving(motion)?;
                motion.set_state(state).map_err(|source| self.failed(source))?;
            }
            (Some(_), None) => return unfit("it has no motion component".to_owned()),
            (None, Some(state)) => return unfit(format!("it has {}", state.component)),
        }
        load.set_state(&saved.load).map_err(|source| self.failed(source))?;
        self.step = saved.step;
        Ok(())
    }

    /// Ends the co-simulation. Outputs of the components stay readable.
    pub fn finish(&self, load: &mut dyn LoadComponent, motion: Option<&mut dyn MotionComponent>) {
        load.terminate();
        if let Some(motion) = motion {
            motion.terminate();
        }
    }

    fn failed(&self, source: ComponentError) -> CouplerError {
        CouplerError::Component { time: self.time(), step: self.step + 1, source }
    }

    fn length_error(
        &self,
        component: &dyn Component,
        quantity: &'static str,
        actual: usize,
        expected: usize,
    ) -> CouplerError {
        let component = component.description().name.clone();
        let (time, step) = (self.time(), self.step + 1);
        CouplerError::Length { component, quantity, actual, expected, time, step }
    }

    fn check(
        &self,
        component: &dyn Component,
        quantity: &'static str,
        actual: usize,
        expected: usize,
    ) -> Result<(), CouplerError> {
        if actual == expected {
            return Ok(());
        }
        Err(self.length_error(component, quantity, actual, expected))
    }
}

/// Refuses components that cannot work together in this scheme.
fn check_combination(
    load: &dyn LoadComponent,
    motion: Option<&dyn MotionComponent>,
) -> Result<(), CouplerError> {
    let (load_boundaries, motion_bodies) =
        (load.boundary_count(), motion.map_or(0, |motion| motion.body_count()));
    if load_boundaries != motion_bodies {
        return Err(CouplerError::BoundaryCount {
            load: load.description().name.clone(),
            load_boundaries,
            motion: motion.map_or("no component".to_owned(), |m| m.description().name.clone()),
            motion_bodies,
        });
    }
    let Some(motion) = motion else { return Ok(()) };
    let capabilities = load.description().capabilities;
    if capabilities.has_direct_feedthrough && !capabilities.provides_directional_derivative {
        let component = load.description().name.clone();
        return Err(CouplerError::FeedthroughWithoutDerivative { component });
    }
    if motion.description().capabilities.has_direct_feedthrough {
        let component = motion.description().name.clone();
        return Err(CouplerError::MotionFeedthrough { component });
    }
    Ok(())
}

fn check_state_saving(component: &dyn Component) -> Result<(), CouplerError> {
    let description = component.description();
    if description.capabilities.can_get_and_set_state {
        return Ok(());
    }
    Err(CouplerError::NoStateSaving { component: description.name.clone() })
}

/// What of a response does not fit `boundaries`: quantity, actual and expected number.
fn misfit(response: &LoadResponse, boundaries: usize) -> Option<(&'static str, usize, usize)> {
    let added_mass = &response.added_mass;
    [
        ("loads", response.at_zero_acceleration.len(), boundaries),
        ("rows of added mass", added_mass.nrows(), 3 * boundaries),
        ("columns of added mass", added_mass.ncols(), 3 * boundaries),
    ]
    .into_iter()
    .find(|(_, actual, expected)| actual != expected)
}

fn degrees(load: &Load) -> [f64; 3] {
    [load.force.x, load.force.y, load.torque]
}
