//! The smallest engine: Newton's and Euler's equations of free bodies, without contacts.
//!
//! The classical Runge-Kutta method of fourth order (Kutta 1901), for any load. On an oscillator
//! of angular frequency ω it takes (ω h)⁶/144 of the amplitude in a step h, 4e-7 a cycle at 63
//! steps a cycle.

use crate::engine::{check_length, entry, free_mass_matrix, kicked};
use crate::{BodyError, BodyProperties, Forcing, RigidBodyEngine};
use nalgebra::{DMatrix, Vector2};
use seakeep_coupler::interface::BoundaryKinematics;

const NAME: &str = "newton_euler";

/// Time of each stage and weight of its slopes, over the step.
const STAGES: [(f64, f64); 4] =
    [(0.0, 1.0 / 6.0), (0.5, 1.0 / 3.0), (0.5, 1.0 / 3.0), (1.0, 1.0 / 6.0)];

/// Free bodies without contacts or joints, moved with fourth order.
#[derive(Clone, Debug)]
pub struct NewtonEulerEngine {
    mass_matrix: DMatrix<f64>,
    kinematics: Vec<BoundaryKinematics>,
}

impl NewtonEulerEngine {
    /// An engine without bodies.
    #[must_use]
    pub fn new() -> Self {
        Self { mass_matrix: DMatrix::zeros(0, 0), kinematics: Vec::new() }
    }
}

impl Default for NewtonEulerEngine {
    fn default() -> Self {
        Self::new()
    }
}

/// Writes where the bodies of `start` are after `duration` (s) at these velocities and
/// accelerations.
fn move_all(
    start: &[BoundaryKinematics],
    velocities: &[f64],
    accelerations: &[f64],
    duration: f64,
    end: &mut [BoundaryKinematics],
) {
    for (((end, start), velocity), acceleration) in
        end.iter_mut().zip(start).zip(velocities.chunks_exact(3)).zip(accelerations.chunks_exact(3))
    {
        *end = kicked(start, acceleration, duration);
        end.position += Vector2::new(velocity[0], velocity[1]) * duration;
        end.angle += velocity[2] * duration;
    }
}

fn add(sum: &mut [f64], values: &[f64], weight: f64) {
    sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += weight * value);
}

impl RigidBodyEngine for NewtonEulerEngine {
    fn name(&self) -> &'static str {
        NAME
    }

    fn set_bodies(&mut self, bodies: &[BodyProperties]) -> Result<(), BodyError> {
        self.mass_matrix = free_mass_matrix(bodies);
        self.kinematics = bodies.iter().map(BodyProperties::kinematics).collect();
        Ok(())
    }

    fn mass_matrix(&self) -> &DMatrix<f64> {
        &self.mass_matrix
    }

    fn kinematics(&self) -> &[BoundaryKinematics] {
        &self.kinematics
    }

    fn set_kinematics(&mut self, kinematics: &[BoundaryKinematics]) -> Result<(), BodyError> {
        check_length("kinematics", kinematics.len(), self.kinematics.len())?;
        self.kinematics.copy_from_slice(kinematics);
        Ok(())
    }

    fn steer(&mut self, body: usize, kinematics: &BoundaryKinematics) -> Result<(), BodyError> {
        *entry(&mut self.kinematics, body)? = *kinematics;
        Ok(())
    }

    fn advance(
        &mut self,
        time: f64,
        duration: f64,
        forcing: &mut dyn Forcing,
    ) -> Result<(), BodyError> {
        let size = 3 * self.kinematics.len();
        let mut stage = self.kinematics.clone();
        let (mut velocities, mut accelerations) = (vec![0.0; size], vec![0.0; size]);
        let (mut mean_velocities, mut mean_accelerations) = (vec![0.0; size], vec![0.0; size]);
        for (offset, weight) in STAGES {
            let offset = offset * duration;
            // From the start with the slopes of the last stage.
            move_all(&self.kinematics, &velocities, &accelerations, offset, &mut stage);
            for (slopes, body) in velocities.chunks_exact_mut(3).zip(&stage) {
                let (velocity, rate) = (body.velocity, body.angular_velocity);
                slopes.copy_from_slice(&[velocity.x, velocity.y, rate]);
            }
            forcing.accelerations(time + offset, &stage, &mut accelerations)?;
            add(&mut mean_velocities, &velocities, weight);
            add(&mut mean_accelerations, &accelerations, weight);
        }
        move_all(&self.kinematics, &mean_velocities, &mean_accelerations, duration, &mut stage);
        self.kinematics = stage;
        Ok(())
    }

    fn save(&self) -> Result<Vec<u8>, BodyError> {
        postcard::to_stdvec(&self.kinematics)
            .map_err(|error| BodyError::Engine { engine: NAME, reason: error.to_string() })
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), BodyError> {
        let kinematics: Vec<BoundaryKinematics> = postcard::from_bytes(state)
            .map_err(|error| BodyError::Engine { engine: NAME, reason: error.to_string() })?;
        self.set_kinematics(&kinematics)
    }
}
