//! The smallest engine: Newton's and Euler's equations of free bodies, without contacts.

use crate::engine::{check_length, entry, free_mass_matrix, kicked};
use crate::{BodyError, BodyProperties, RigidBodyEngine};
use nalgebra::DMatrix;
use seakeep_coupler::interface::BoundaryKinematics;

const NAME: &str = "newton_euler";

/// Free bodies without contacts or joints. Its drift is exact, the angle's too.
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

    fn drift(&mut self, duration: f64) -> Result<(), BodyError> {
        for body in &mut self.kinematics {
            *body = body.drifted(duration);
        }
        Ok(())
    }

    fn kick(&mut self, accelerations: &[f64], duration: f64) -> Result<(), BodyError> {
        check_length("accelerations", accelerations.len(), 3 * self.kinematics.len())?;
        for (body, acceleration) in self.kinematics.iter_mut().zip(accelerations.chunks_exact(3)) {
            *body = kicked(body, acceleration, duration);
        }
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
