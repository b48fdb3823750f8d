//! Mooring lines: from a fairlead on a body to a fixed anchor, without mass or drag of their own.

mod catenary;
mod equilibrium;
mod spring;

pub use catenary::Catenary;
pub use equilibrium::{UnknownTension, static_tensions};
pub use spring::Spring;

use crate::{BodyError, OwnLoad};
use nalgebra::{Point2, Rotation2, Vector2};
use seakeep_coupler::interface::{BoundaryKinematics, Load};

/// What a line answers to the distance of its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LineLaw {
    /// A light spring.
    Spring(Spring),
    /// A heavy elastic line at rest.
    Catenary(Catenary),
}

/// A mooring line. Per metre of width, as everything.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MooringLine {
    /// Where it is fastened to the body: relative to the centre of mass at angle 0, m.
    pub fairlead: Vector2<f64>,
    /// Where it is fastened to the ground, m.
    pub anchor: Point2<f64>,
    /// What it answers.
    pub law: LineLaw,
}

/// A mooring line at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineState {
    /// Place of the fairlead, m.
    pub fairlead: Point2<f64>,
    /// Force on the body at the fairlead, N/m.
    pub force: Vector2<f64>,
    /// Tension at the fairlead, the magnitude of the force, N/m.
    pub tension: f64,
    /// Length, m: from end to end of a spring, along a catenary.
    pub length: f64,
}

impl MooringLine {
    /// Place of the fairlead of a body with these kinematics, m.
    #[must_use]
    pub fn fairlead_of(&self, body: &BoundaryKinematics) -> Point2<f64> {
        body.position + Rotation2::new(body.angle) * self.fairlead
    }

    /// The line on a body with these kinematics.
    #[must_use]
    pub fn at(&self, body: &BoundaryKinematics) -> LineState {
        let fairlead = self.fairlead_of(body);
        let (force, length) = match &self.law {
            LineLaw::Spring(spring) => {
                spring.pull(fairlead - self.anchor, body.velocity_at(fairlead))
            }
            LineLaw::Catenary(catenary) => catenary.pull(fairlead - self.anchor),
        };
        LineState { fairlead, force, tension: force.norm(), length }
    }

    /// Load about the centre of mass of a body with these kinematics: the force, and the torque
    /// (r_m − r_G) × F_m of Eq. (33).
    #[must_use]
    pub fn load_on(&self, body: &BoundaryKinematics) -> Load {
        let LineState { fairlead, force, .. } = self.at(body);
        Load { force, torque: (fairlead - body.position).perp(&force) }
    }

    /// Damping of the line, N s/m².
    #[must_use]
    pub fn damping(&self) -> f64 {
        match &self.law {
            LineLaw::Spring(spring) => spring.damping,
            LineLaw::Catenary(_) => 0.0,
        }
    }

    /// Largest stiffness that the line can have, N/m²: what a substep has to resolve.
    #[must_use]
    pub fn stiffness(&self) -> f64 {
        match &self.law {
            LineLaw::Spring(spring) => spring.stiffness,
            LineLaw::Catenary(catenary) => catenary.axial_stiffness / catenary.unstretched_length,
        }
    }
}

impl OwnLoad for MooringLine {
    fn load(&self, _time: f64, kinematics: &BoundaryKinematics) -> Load {
        self.load_on(kinematics)
    }

    fn depends_on_velocity(&self) -> bool {
        self.damping() > 0.0
    }
}

/// Checks a property of a line.
fn require(
    holds: bool,
    property: &'static str,
    value: f64,
    allowed: &'static str,
) -> Result<(), BodyError> {
    if holds && value.is_finite() {
        return Ok(());
    }
    Err(BodyError::Line { property, value, allowed })
}
