//! The master with a fixed communication step.
//!
//! An incompressible fluid answers a body's acceleration at once with its added mass A, so a
//! scheme that exchanges loads and accelerations one after the other diverges when A exceeds the
//! body's mass, however small the step (Causin, Gerbeau and Nobile, Comput. Methods Appl. Mech.
//! Eng. 194, 2005). In the default scheme the load component therefore hands over its load as
//! F = F₀ − A a, the motion component solves (M + A) a = F₀ + F_own, and the load component steps
//! with that a: one evaluation a step, no iteration. The other schemes need no derivative: see
//! [`Scheme`].
//!
//! The master owns no component. Each call is given the same two again, so that the caller can
//! read them between steps with their own types. A boundary that is held or prescribed is a
//! body without free degrees of freedom; a fluid without boundaries has no motion component.

mod acceleration;
mod capabilities;
mod clock;
mod history;
mod schemes;
mod settings;
mod sides;

pub use schemes::SchemeMemory;
pub use settings::{Acceleration, Coupling, Extrapolation, Implicit, Scheme};

use crate::CouplerError;
use crate::interface::{Component, ComponentError, ComponentState, LoadComponent, MotionComponent};
use capabilities::{check_combination, check_state_saving};
use clock::Clock;
use schemes::Exchange;
use serde::{Deserialize, Serialize};

/// Couples a load component and a motion component with a fixed communication step.
#[derive(Clone, Debug)]
pub struct FixedStepMaster {
    clock: Clock,
    coupling: Coupling,
    memory: SchemeMemory,
    /// Residual of every evaluation of the last step.
    residuals: Vec<f64>,
}

/// What a master reports of a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepReport {
    /// Number of the step, from 1.
    pub step: u64,
    /// Time at the end of the step, s.
    pub time: f64,
    /// Evaluations of the load: how often the load over the step was asked for with new
    /// accelerations.
    pub load_evaluations: u32,
    /// By how much the mean accelerations that the bodies made differ from those that the load
    /// component was told, relative to the larger of them (Euclidean norms of the values in SI
    /// units).
    pub residual: f64,
    /// Work of the load on all bodies over the step, as the bodies felt it, J/m.
    pub interface_work: f64,
    /// Energy that the coupling made in the step, J/m: `interface_work` less the work of the load
    /// that the load component reports on the displacement that it was told of. Zero, but for
    /// rounding, if both sides saw the same load and the same displacement (power-bond residual,
    /// Sadjina, Kyllingstad, Skjong and Pedersen, Eng. Comput. 33, 2017).
    pub power_bond_residual: f64,
}

/// The state of a whole co-simulation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SavedState {
    /// Start time, s.
    pub start_time: f64,
    /// Communication step, s.
    pub communication_step: f64,
    /// Scheme and rates.
    pub coupling: Coupling,
    /// Steps done.
    pub step: u64,
    /// What the scheme remembers of them.
    pub memory: SchemeMemory,
    /// State of the load component.
    pub load: ComponentState,
    /// State of the motion component, if there is one.
    pub motion: Option<ComponentState>,
}

impl FixedStepMaster {
    /// Initializes the components at `start_time` (s), for steps of `communication_step` (s) with
    /// the default [`Coupling`].
    ///
    /// # Errors
    /// As [`start_with`](Self::start_with).
    pub fn start(
        start_time: f64,
        communication_step: f64,
        load: &mut dyn LoadComponent,
        motion: Option<&mut dyn MotionComponent>,
    ) -> Result<Self, CouplerError> {
        Self::start_with(Coupling::default(), start_time, communication_step, load, motion)
    }

    /// Initializes the components at `start_time` (s), for steps of `communication_step` (s).
    ///
    /// # Errors
    /// A combination that cannot work, before anything is initialized: impossible times, a
    /// parameter of the coupling out of its range, numbers of boundaries that differ, an algebraic
    /// loop that the scheme cannot close, or a step that would have to be repeated by a component
    /// that cannot. Otherwise [`CouplerError::Component`].
    pub fn start_with(
        coupling: Coupling,
        start_time: f64,
        communication_step: f64,
        load: &mut dyn LoadComponent,
        motion: Option<&mut dyn MotionComponent>,
    ) -> Result<Self, CouplerError> {
        let clock = Clock::start(start_time, communication_step)?;
        coupling.validate()?;
        check_combination(&coupling, load, motion.as_deref())?;
        initialize(start_time, load, motion).map_err(|source| CouplerError::Component {
            time: start_time,
            step: 0,
            source,
        })?;
        Ok(Self { clock, coupling, memory: SchemeMemory::default(), residuals: Vec::new() })
    }

    /// Time reached, s: start + steps × communication step, without the rounding of a sum.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.clock.time()
    }

    /// Steps done.
    #[must_use]
    pub fn step_count(&self) -> u64 {
        self.clock.step
    }

    /// The communication step, s.
    #[must_use]
    pub fn communication_step(&self) -> f64 {
        self.clock.communication_step
    }

    /// Scheme and rates.
    #[must_use]
    pub fn coupling(&self) -> &Coupling {
        &self.coupling
    }

    /// The iteration log of the last step: [`StepReport::residual`] of each evaluation. Also
    /// after a step that did not converge.
    #[must_use]
    pub fn residuals(&self) -> &[f64] {
        &self.residuals
    }

    /// Takes one communication step.
    ///
    /// # Errors
    /// [`CouplerError::Component`], [`CouplerError::Length`] or [`CouplerError::NotConverged`],
    /// with time and step. The components may then stand at different times: restore a saved
    /// state or end.
    pub fn step(
        &mut self,
        load: &mut dyn LoadComponent,
        motion: Option<&mut dyn MotionComponent>,
    ) -> Result<StepReport, CouplerError> {
        self.residuals.clear();
        let Exchange { told_work, felt_work } = match motion {
            Some(motion) => self.step_coupled(load, motion)?,
            None => self.step_alone(load)?,
        };
        self.clock.step += 1;
        Ok(StepReport {
            step: self.clock.step,
            time: self.time(),
            load_evaluations: self.residuals.len() as u32,
            residual: self.residuals.last().copied().unwrap_or_default(),
            interface_work: felt_work,
            power_bond_residual: felt_work - told_work,
        })
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
            component.get_state().map_err(|source| self.clock.failed(source))
        };
        Ok(SavedState {
            start_time: self.clock.start_time,
            communication_step: self.clock.communication_step,
            coupling: self.coupling,
            step: self.clock.step,
            memory: self.memory.clone(),
            load: save(load)?,
            motion: motion.map(|motion| save(motion)).transpose()?,
        })
    }

    /// Goes back, or ahead, to a saved state of the same co-simulation: from now on every step
    /// repeats to the bit what followed the save. In a new process,
    /// [`start_with`](Self::start_with) with components set up alike comes first.
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
            (self.clock.start_time, self.clock.communication_step),
            (saved.start_time, saved.communication_step),
        );
        if mine != other {
            return unfit(format!("{}, not {}", clock(other.0, other.1), clock(mine.0, mine.1)));
        }
        if self.coupling != saved.coupling {
            return unfit(format!("{:?}, not {:?}", saved.coupling, self.coupling));
        }
        check_state_saving(load)?;
        match (motion, &saved.motion) {
            (None, None) => {}
            (Some(motion), Some(state)) => {
                check_state_saving(motion)?;
                motion.set_state(state).map_err(|source| self.clock.failed(source))?;
            }
            (Some(_), None) => return unfit("it has no motion component".to_owned()),
            (None, Some(state)) => return unfit(format!("it has {}", state.component)),
        }
        load.set_state(&saved.load).map_err(|source| self.clock.failed(source))?;
        self.clock.step = saved.step;
        self.memory.clone_from(&saved.memory);
        Ok(())
    }

    /// Ends the co-simulation. Outputs of the components stay readable.
    pub fn finish(&self, load: &mut dyn LoadComponent, motion: Option<&mut dyn MotionComponent>) {
        load.terminate();
        if let Some(motion) = motion {
            motion.terminate();
        }
    }
}

fn initialize(
    start_time: f64,
    load: &mut dyn LoadComponent,
    motion: Option<&mut dyn MotionComponent>,
) -> Result<(), ComponentError> {
    load.enter_initialization_mode(start_time)?;
    if let Some(motion) = motion {
        motion.enter_initialization_mode(start_time)?;
        motion.exit_initialization_mode()?;
        load.set_kinematics(motion.kinematics());
    }
    load.exit_initialization_mode()
}
