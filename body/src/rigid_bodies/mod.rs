//! The motion component.

mod component;
mod prescription;

use crate::balance::Balance;
use crate::properties::validate_all;
use crate::{BodyError, BodyProperties, Forcing, OwnLoad, RigidBodyEngine, variables};
use nalgebra::DMatrix;
use prescription::Prescription;
use seakeep_coupler::interface::{BoundaryKinematics, Description, Load, LoadResponse};
use serde::{Deserialize, Serialize};

const NAME: &str = "rigid_bodies";

/// Rigid bodies under hydrodynamic load, weight and loads of their own.
///
/// Inputs are the hydrodynamic loads, outputs the motion; see its
/// [`description`](seakeep_coupler::interface::Component::description). A
/// saved state holds the motion and the load set, not the bodies' properties, the number of
/// substeps or the own loads: those are the set-up.
pub struct RigidBodies {
    description: Description,
    bodies: Vec<BodyProperties>,
    /// Free or held, three a body.
    free: Vec<bool>,
    /// Weight, three a body: N/m, N/m, N m/m.
    weight: Vec<f64>,
    own_loads: Vec<(usize, Box<dyn OwnLoad>)>,
    prescriptions: Vec<Prescription>,
    substeps: usize,
    engine: Box<dyn RigidBodyEngine>,
    phase: Phase,
    motion: Motion,
}

/// What changes from step to step, besides the engine's state.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Motion {
    time: f64,
    steps: u64,
    /// Length of the last step, s; 0 before the first.
    last_step: f64,
    response: LoadResponse,
    kinematics: Vec<BoundaryKinematics>,
    mean_accelerations: Vec<f64>,
}

/// Where the component stands in its life cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Instantiated,
    Initialization,
    Stepping,
    Terminated,
}

impl Phase {
    fn in_words(self) -> &'static str {
        match self {
            Self::Instantiated => "before initialization",
            Self::Initialization => "during initialization",
            Self::Stepping => "after initialization",
            Self::Terminated => "after termination",
        }
    }
}

impl RigidBodies {
    /// Bodies under `gravity` (m/s², downwards if positive), moved by `engine`.
    ///
    /// # Errors
    /// A property out of its range, a name used twice, or a body that the engine cannot hold.
    pub fn new(
        bodies: Vec<BodyProperties>,
        gravity: f64,
        mut engine: Box<dyn RigidBodyEngine>,
    ) -> Result<Self, BodyError> {
        validate_all(&bodies)?;
        if !gravity.is_finite() {
            return Err(BodyError::Gravity { value: gravity });
        }
        engine.set_bodies(&bodies)?;
        let motion = Motion {
            time: 0.0,
            steps: 0,
            last_step: 0.0,
            response: LoadResponse::zero(bodies.len()),
            kinematics: engine.kinematics().to_vec(),
            mean_accelerations: vec![0.0; 3 * bodies.len()],
        };
        Ok(Self {
            description: variables::describe(NAME, &bodies),
            free: bodies.iter().flat_map(|body| body.free.as_array()).collect(),
            weight: bodies.iter().flat_map(|body| [0.0, -body.mass * gravity, 0.0]).collect(),
            bodies,
            own_loads: Vec::new(),
            prescriptions: Vec::new(),
            substeps: 1,
            engine,
            phase: Phase::Instantiated,
            motion,
        })
    }

    /// Divides each communication step into `substeps` steps of the bodies' own. The load set is
    /// held over the step; weight and own loads are evaluated in each substep.
    ///
    /// # Errors
    /// [`BodyError::NoSubsteps`] for zero.
    pub fn with_substeps(mut self, substeps: usize) -> Result<Self, BodyError> {
        if substeps == 0 {
            return Err(BodyError::NoSubsteps);
        }
        self.substeps = substeps;
        Ok(self)
    }

    /// Lets `load` act on the body number `body`, from 0.
    ///
    /// # Errors
    /// [`BodyError::UnknownBody`].
    pub fn add_own_load(&mut self, body: usize, load: Box<dyn OwnLoad>) -> Result<(), BodyError> {
        if body >= self.bodies.len() {
            return Err(BodyError::UnknownBody { index: body, count: self.bodies.len() });
        }
        self.own_loads.push((body, load));
        Ok(())
    }

    /// The bodies as they were set up.
    #[must_use]
    pub fn bodies(&self) -> &[BodyProperties] {
        &self.bodies
    }

    /// Mass matrix M, square with three rows a body: kg/m, kg, kg m²/m.
    #[must_use]
    pub fn mass_matrix(&self) -> &DMatrix<f64> {
        self.engine.mass_matrix()
    }

    /// The load set must fit the bodies and be finite, or the motion would be lost silently.
    fn check_response(&self) -> Result<(), BodyError> {
        let LoadResponse { at_zero_acceleration: loads, added_mass } = &self.motion.response;
        let rows = 3 * self.bodies.len();
        if loads.len() != self.bodies.len() || added_mass.shape() != (rows, rows) {
            return Err(BodyError::ResponseSize {
                loads: loads.len(),
                rows: added_mass.nrows(),
                columns: added_mass.ncols(),
                bodies: self.bodies.len(),
            });
        }
        for (body, load) in self.bodies.iter().zip(loads) {
            check_finite(body, "load", &[load.force.x, load.force.y, load.torque])?;
        }
        for (row, body) in (0..rows).map(|row| (row, &self.bodies[row / 3])) {
            for column in 0..rows {
                check_finite(body, "added mass", &[added_mass[(row, column)]])?;
            }
        }
        Ok(())
    }

    /// Steps by `duration` (s) from `time` (s). Before anything moves, all that was given is
    /// checked.
    fn step(&mut self, time: f64, duration: f64) -> Result<(), BodyError> {
        if !(duration.is_finite() && duration > 0.0) {
            return Err(BodyError::StepLength { value: duration });
        }
        self.check_response()?;
        // What acts on the bodies all over the step.
        let mut held = self.prescribed_reaction(time, duration)?;
        held.iter_mut().zip(&self.weight).for_each(|(sum, weight)| *sum += weight);
        for (sum, load) in held.chunks_exact_mut(3).zip(&self.motion.response.at_zero_acceleration)
        {
            add(sum, load);
        }
        let Self { engine, own_loads, prescriptions, bodies, motion, .. } = self;
        let balance = Balance::new(engine.mass_matrix(), &motion.response.added_mass, &self.free)?;
        let mut loads = Loads { held: &held, sum: held.clone(), own_loads, bodies, balance };
        let substep = duration / self.substeps as f64;
        for number in 0..self.substeps {
            let start = time + number as f64 * substep;
            for known in prescriptions.iter() {
                engine.steer(known.body, &known.chord(start, substep)?)?;
            }
            engine.advance(start, substep, &mut loads)?;
        }
        for known in prescriptions.iter_mut() {
            known.motion.advance(time, duration)?;
            engine.steer(known.body, &known.motion.kinematics(time + duration)?)?;
        }
        self.note_motion(time + duration, duration)
    }

    /// Reads the motion from the engine after a step of `duration` (s) that ends at `time` (s).
    fn note_motion(&mut self, time: f64, duration: f64) -> Result<(), BodyError> {
        let motion = &mut self.motion;
        for (((body, old), new), mean) in self
            .bodies
            .iter()
            .zip(&mut motion.kinematics)
            .zip(self.engine.kinematics())
            .zip(motion.mean_accelerations.chunks_exact_mut(3))
        {
            let acceleration = (new.velocity - old.velocity) / duration;
            let angular_acceleration = (new.angular_velocity - old.angular_velocity) / duration;
            mean.copy_from_slice(&[acceleration.x, acceleration.y, angular_acceleration]);
            check_finite(body, "acceleration", mean)?;
            check_finite(body, "pose", &[new.position.x, new.position.y, new.angle])?;
            *old = BoundaryKinematics { acceleration, angular_acceleration, ..*new };
        }
        motion.time = time;
        motion.steps += 1;
        motion.last_step = duration;
        self.note_prescribed()
    }
}

/// All loads on the bodies over a step.
struct Loads<'a> {
    /// Those held over the step, three values a body.
    held: &'a [f64],
    /// Room for all of them.
    sum: Vec<f64>,
    own_loads: &'a [(usize, Box<dyn OwnLoad>)],
    bodies: &'a [BodyProperties],
    balance: Balance,
}

impl Forcing for Loads<'_> {
    fn accelerations(
        &mut self,
        time: f64,
        kinematics: &[BoundaryKinematics],
        accelerations: &mut [f64],
    ) -> Result<(), BodyError> {
        self.sum.copy_from_slice(self.held);
        for (body, own) in self.own_loads {
            let load = own.load(time, &kinematics[*body]);
            let values = [load.force.x, load.force.y, load.torque];
            check_finite(&self.bodies[*body], "own load", &values)?;
            add(&mut self.sum[3 * body..3 * body + 3], &load);
        }
        self.balance.solve(&self.sum, accelerations)
    }

    fn depends_on_velocity(&self) -> bool {
        self.own_loads.iter().any(|(_, load)| load.depends_on_velocity())
    }
}

fn add(sum: &mut [f64], load: &Load) {
    for (value, term) in sum.iter_mut().zip([load.force.x, load.force.y, load.torque]) {
        *value += term;
    }
}

fn check_finite(
    body: &BodyProperties,
    quantity: &'static str,
    values: &[f64],
) -> Result<(), BodyError> {
    match values.iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(value) => {
            Err(BodyError::NotFinite { body: body.name.clone(), quantity, value: *value })
        }
    }
}
