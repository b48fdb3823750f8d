//! What measures in a scene.

use nalgebra::{Point2, Rotation2};
use seakeep_coupler::interface::BoundaryKinematics;

/// A wave gauge.
#[derive(Clone, Debug, PartialEq)]
pub struct Gauge {
    /// Name in the table.
    pub name: String,
    /// Where it stands, m.
    pub x: f64,
}

/// A pressure probe.
#[derive(Clone, Debug, PartialEq)]
pub struct Probe {
    /// Name in the table.
    pub name: String,
    /// The body that it is fastened to, by its index; without one it stands still.
    pub body: Option<usize>,
    /// Where it measures, m: in the tank, or from the centre of mass of its body at angle 0.
    pub point: Point2<f64>,
}

impl Probe {
    /// Where it is when the bodies are at `motion`, m.
    #[must_use]
    pub fn place(&self, motion: &[BoundaryKinematics]) -> Point2<f64> {
        match self.body.and_then(|index| motion.get(index)) {
            Some(body) => body.position + Rotation2::new(body.angle) * self.point.coords,
            None => self.point,
        }
    }
}
