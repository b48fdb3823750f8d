//! Prescribed motion: a body that moves as it is told, whatever the loads on it.

mod harmonic;
mod time_series;

pub use harmonic::{Harmonic, Oscillation};
pub use time_series::TimeSeries;

use crate::BodyError;
use seakeep_coupler::interface::BoundaryKinematics;

/// The motion of one body as a function of time: a formula, a record, or a machine that is
/// steered while it moves, such as a wavemaker that absorbs waves.
///
/// Any closure `Fn(time) -> BoundaryKinematics` is one, without a state.
///
/// A motion with a state decides in [`advance`](Self::advance), once a step, how it goes on from
/// what it was told in [`observe`](Self::observe). Between two calls its kinematics are a function
/// of time alone, and neither call makes a pose or a velocity jump.
pub trait PrescribedMotion: Send {
    /// Pose, velocity and acceleration at `time` (s), which is not before the last
    /// [`advance`](Self::advance). Velocity and acceleration are the derivatives of the pose.
    ///
    /// # Errors
    /// [`BodyError::OutsideMotion`] at a time for which no motion is known.
    fn kinematics(&self, time: f64) -> Result<BoundaryKinematics, BodyError>;

    /// Is told the elevation of the water surface above still water (m) at the body, measured at
    /// the current communication point. May change the acceleration from now on.
    fn observe(&mut self, _elevation: f64) {}

    /// Takes the step of `duration` (s) that begins at `time` (s).
    ///
    /// # Errors
    /// When the motion cannot go on.
    fn advance(&mut self, _time: f64, _duration: f64) -> Result<(), BodyError> {
        Ok(())
    }

    /// The state; [`restore`](Self::restore) with it repeats a motion to the bit. Empty without a
    /// state.
    ///
    /// # Errors
    /// When it cannot be serialized.
    fn save(&self) -> Result<Vec<u8>, BodyError> {
        Ok(Vec::new())
    }

    /// Restores what [`save`](Self::save) of an equal motion returned.
    ///
    /// # Errors
    /// When it is no such state. The motion is then unchanged.
    fn restore(&mut self, state: &[u8]) -> Result<(), BodyError> {
        if state.is_empty() { Ok(()) } else { Err(BodyError::MotionState) }
    }
}

impl<F: Fn(f64) -> BoundaryKinematics + Send> PrescribedMotion for F {
    fn kinematics(&self, time: f64) -> Result<BoundaryKinematics, BodyError> {
        Ok(self(time))
    }
}

/// A degree of freedom over time: value with its first and second derivative.
type Course = [f64; 3];

/// Kinematics of sway, heave and roll about a pose of rest.
fn about(rest: &BoundaryKinematics, [sway, heave, roll]: [Course; 3]) -> BoundaryKinematics {
    let mut now = *rest;
    now.position.x += sway[0];
    now.position.y += heave[0];
    now.angle += roll[0];
    now.velocity = [sway[1], heave[1]].into();
    now.angular_velocity = roll[1];
    now.acceleration = [sway[2], heave[2]].into();
    now.angular_acceleration = roll[2];
    now
}
