//! The engine interface: what moves a set of rigid bodies.

use crate::{BodyError, BodyProperties};
use nalgebra::DMatrix;
use seakeep_coupler::interface::BoundaryKinematics;

/// What accelerates a set of rigid bodies: the loads on them, over their masses with added mass.
///
/// Accelerations are laid out as `[x (m/s²), y (m/s²), angle (rad/s²)]` a body.
pub trait Forcing {
    /// Writes the accelerations of all bodies at `time` (s) for their kinematics.
    ///
    /// # Errors
    /// A load that is not finite, or masses that cannot be solved for.
    fn accelerations(
        &mut self,
        time: f64,
        kinematics: &[BoundaryKinematics],
        accelerations: &mut [f64],
    ) -> Result<(), BodyError>;

    /// Whether they depend on velocities.
    fn depends_on_velocity(&self) -> bool;
}

/// Moves one set of rigid bodies. It knows inertia, constraints and contacts; loads reach it as
/// accelerations only, because with added mass only the caller can turn one into the other.
pub trait RigidBodyEngine: Send {
    /// Name, such as `rapier2d`.
    fn name(&self) -> &'static str;

    /// Replaces the engine's bodies by these, at their start.
    ///
    /// # Errors
    /// When the engine cannot hold such a body.
    fn set_bodies(&mut self, bodies: &[BodyProperties]) -> Result<(), BodyError>;

    /// Mass matrix M, square with three rows a body: kg/m, kg, kg m²/m.
    fn mass_matrix(&self) -> &DMatrix<f64>;

    /// Kinematics of every body; the acceleration is the mean over the last step.
    fn kinematics(&self) -> &[BoundaryKinematics];

    /// Sets the kinematics of every body.
    ///
    /// # Errors
    /// [`BodyError::Length`].
    fn set_kinematics(&mut self, kinematics: &[BoundaryKinematics]) -> Result<(), BodyError>;

    /// Puts the body number `body` into this pose and lets it go on with this velocity until it is
    /// told otherwise: neither kicks nor contacts move it from now on.
    ///
    /// # Errors
    /// [`BodyError::UnknownBody`].
    fn steer(&mut self, body: usize, kinematics: &BoundaryKinematics) -> Result<(), BodyError>;

    /// Moves every body from `time` (s) for `duration` (s) as `forcing` asks it to. Contacts and
    /// joints of the engine act here too.
    ///
    /// # Errors
    /// Those of `forcing`, or when a body leaves the range of finite numbers.
    fn advance(
        &mut self,
        time: f64,
        duration: f64,
        forcing: &mut dyn Forcing,
    ) -> Result<(), BodyError>;

    /// The whole state; [`restore`](Self::restore) with it repeats a step to the bit.
    ///
    /// # Errors
    /// When it cannot be serialized.
    fn save(&self) -> Result<Vec<u8>, BodyError>;

    /// Restores what [`save`](Self::save) of an equal engine returned.
    ///
    /// # Errors
    /// When it is not such a state. The engine is then unchanged.
    fn restore(&mut self, state: &[u8]) -> Result<(), BodyError>;
}

/// The mass matrix of bodies that nothing joins.
pub(crate) fn free_mass_matrix(bodies: &[BodyProperties]) -> DMatrix<f64> {
    let diagonal: Vec<f64> = bodies.iter().flat_map(BodyProperties::diagonal_mass).collect();
    DMatrix::from_diagonal(&diagonal.into())
}

/// The entry of the body number `body`.
pub(crate) fn entry<T>(list: &mut [T], body: usize) -> Result<&mut T, BodyError> {
    let count = list.len();
    list.get_mut(body).ok_or(BodyError::UnknownBody { index: body, count })
}

/// Checks a number of values against the number the engine needs.
pub(crate) fn check_length(
    quantity: &'static str,
    actual: usize,
    expected: usize,
) -> Result<(), BodyError> {
    if actual == expected { Ok(()) } else { Err(BodyError::Length { quantity, actual, expected }) }
}

/// V ← V + a `duration` (s), with the acceleration noted.
pub(crate) fn kicked(
    body: &BoundaryKinematics,
    acceleration: &[f64],
    duration: f64,
) -> BoundaryKinematics {
    let mut new = *body;
    new.acceleration.copy_from_slice(&acceleration[..2]);
    new.angular_acceleration = acceleration[2];
    new.velocity += new.acceleration * duration;
    new.angular_velocity += new.angular_acceleration * duration;
    new
}
