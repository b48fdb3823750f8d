//! The light spring.

use super::require;
use crate::BodyError;
use nalgebra::Vector2;

/// A light spring with slack, Eq. (32), and damping: its tension is
/// k (l − l₀) + c dl/dt while it is longer than its unstretched length l₀, and never negative.
///
/// Eq. (32) gives the pretension F_m0 at the initial length l_m0 instead of l₀ = l_m0 − F_m0/k.
/// Its second branch, no tension, is for |F_m0| ≤ k (l_m0 − l_m): both branches are printed with
/// the same condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// k: tension for each metre of elongation, N/m².
    pub stiffness: f64,
    /// l₀: length without tension, m.
    pub unstretched_length: f64,
    /// c: tension for each metre a second of lengthening, N s/m².
    pub damping: f64,
}

impl Spring {
    /// A spring of this stiffness (N/m²), unstretched length (m) and damping (N s/m²).
    ///
    /// # Errors
    /// [`BodyError::Line`]: stiffness and length must be positive, damping not negative.
    pub fn new(stiffness: f64, unstretched_length: f64, damping: f64) -> Result<Self, BodyError> {
        let positive = "positive and finite";
        require(stiffness > 0.0, "stiffness (N/m2)", stiffness, positive)?;
        require(unstretched_length > 0.0, "unstretched length (m)", unstretched_length, positive)?;
        require(damping >= 0.0, "damping (N s/m2)", damping, "finite and not negative")?;
        Ok(Self { stiffness, unstretched_length, damping })
    }

    /// A spring that has the tension `pretension` (N/m) at `length` (m): F_m0 and l_m0 of
    /// Eq. (32).
    ///
    /// # Errors
    /// As [`new`](Self::new), or [`BodyError::Line`] for a negative pretension.
    pub fn pretensioned(
        stiffness: f64,
        length: f64,
        pretension: f64,
        damping: f64,
    ) -> Result<Self, BodyError> {
        require(pretension >= 0.0, "pretension (N/m)", pretension, "finite and not negative")?;
        Self::new(stiffness, length - pretension / stiffness, damping)
    }

    /// Force (N/m) on the end that lies at `span` (m) from the other, which is fixed, and moves
    /// at `velocity` (m/s); and the length (m).
    pub(super) fn pull(&self, span: Vector2<f64>, velocity: Vector2<f64>) -> (Vector2<f64>, f64) {
        let length = span.norm();
        let elongation = length - self.unstretched_length;
        if elongation <= 0.0 {
            return (Vector2::zeros(), length);
        }
        let outwards = span / length;
        let lengthening = velocity.dot(&outwards);
        let tension = (self.stiffness * elongation + self.damping * lengthening).max(0.0);
        (-outwards * tension, length)
    }
}
