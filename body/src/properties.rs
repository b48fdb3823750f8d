//! What a rigid body is.

use crate::BodyError;
use nalgebra::{Point2, Vector2};
use seakeep_coupler::interface::BoundaryKinematics;
use serde::{Deserialize, Serialize};

/// Which degrees of freedom of a body are free. The others are held: their velocity and
/// acceleration are exactly zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct FreeDegrees {
    /// Translation along x.
    pub sway: bool,
    /// Translation along y.
    pub heave: bool,
    /// Rotation.
    pub roll: bool,
}

impl FreeDegrees {
    /// Sway, heave and roll are free.
    pub const ALL: Self = Self { sway: true, heave: true, roll: true };
    /// Nothing is free: a fixed boundary.
    pub const NONE: Self = Self { sway: false, heave: false, roll: false };

    /// Free or not, in the order sway, heave, roll.
    #[must_use]
    pub fn as_array(self) -> [bool; 3] {
        [self.sway, self.heave, self.roll]
    }
}

/// A rigid body and where it starts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct BodyProperties {
    /// Name, the prefix of its variables.
    pub name: String,
    /// Mass, kg/m.
    pub mass: f64,
    /// Moment of inertia about the centre of mass, kg m²/m.
    pub inertia: f64,
    /// Position of the centre of mass at the start, m.
    pub position: Point2<f64>,
    /// Angle at the start, counter-clockwise, rad.
    pub angle: f64,
    /// Velocity of the centre of mass at the start, m/s; zero where held.
    pub velocity: Vector2<f64>,
    /// Angular velocity at the start, rad/s; zero where held.
    pub angular_velocity: f64,
    /// Position of the centre of mass from which sway and heave are counted, m.
    pub equilibrium: Point2<f64>,
    /// The free degrees of freedom.
    pub free: FreeDegrees,
    /// Corners of a simple polygon relative to the centre of mass at angle 0, counter-clockwise,
    /// m: what touches other bodies and the tank. Empty for a body that touches nothing.
    pub outline: Vec<Vector2<f64>>,
}

impl BodyProperties {
    /// A free body at rest, upright, in its equilibrium at `position` (m), with `mass` (kg/m)
    /// and `inertia` (kg m²/m). Change the public fields for anything else.
    #[must_use]
    pub fn new(name: impl Into<String>, mass: f64, inertia: f64, position: Point2<f64>) -> Self {
        Self {
            name: name.into(),
            mass,
            inertia,
            position,
            angle: 0.0,
            velocity: Vector2::zeros(),
            angular_velocity: 0.0,
            equilibrium: position,
            free: FreeDegrees::ALL,
            outline: Vec::new(),
        }
    }

    /// Kinematics at the start, without acceleration.
    #[must_use]
    pub fn kinematics(&self) -> BoundaryKinematics {
        BoundaryKinematics {
            velocity: self.velocity,
            angular_velocity: self.angular_velocity,
            ..BoundaryKinematics::at_rest(self.position, self.angle)
        }
    }

    /// Mass, mass and inertia, the diagonal of the mass matrix: kg/m, kg/m, kg m²/m.
    #[must_use]
    pub fn diagonal_mass(&self) -> [f64; 3] {
        [self.mass, self.mass, self.inertia]
    }

    /// Checks every property.
    ///
    /// # Errors
    /// [`BodyError::Name`], [`BodyError::Property`] or [`BodyError::HeldVelocity`].
    pub fn validate(&self) -> Result<(), BodyError> {
        if self.name.is_empty() {
            return Err(BodyError::Name { name: self.name.clone() });
        }
        let refused = |property, value, allowed| {
            Err(BodyError::Property { body: self.name.clone(), property, value, allowed })
        };
        for (property, value) in [("mass (kg/m)", self.mass), ("inertia (kg m2/m)", self.inertia)] {
            if !(value.is_finite() && value > 0.0) {
                return refused(property, value, "positive and finite");
            }
        }
        for (property, value) in [
            ("position x (m)", self.position.x),
            ("position y (m)", self.position.y),
            ("angle (rad)", self.angle),
            ("velocity x (m/s)", self.velocity.x),
            ("velocity y (m/s)", self.velocity.y),
            ("angular velocity (rad/s)", self.angular_velocity),
            ("equilibrium x (m)", self.equilibrium.x),
            ("equilibrium y (m)", self.equilibrium.y),
        ] {
            if !value.is_finite() {
                return refused(property, value, "finite");
            }
        }
        for corner in &self.outline {
            for value in [corner.x, corner.y] {
                if !value.is_finite() {
                    return refused("corner of the outline (m)", value, "finite");
                }
            }
        }
        let velocities = [self.velocity.x, self.velocity.y, self.angular_velocity];
        let degrees = ["sway", "heave", "roll"];
        for ((free, value), degree) in self.free.as_array().into_iter().zip(velocities).zip(degrees)
        {
            if !free && value != 0.0 {
                return Err(BodyError::HeldVelocity { body: self.name.clone(), degree, value });
            }
        }
        Ok(())
    }
}

/// Checks each body and that the names differ.
pub(crate) fn validate_all(bodies: &[BodyProperties]) -> Result<(), BodyError> {
    for (index, body) in bodies.iter().enumerate() {
        body.validate()?;
        if bodies[..index].iter().any(|other| other.name == body.name) {
            return Err(BodyError::Name { name: body.name.clone() });
        }
    }
    Ok(())
}
