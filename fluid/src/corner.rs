//! Corners that stand out into the water, where flow and pressure are singular.
//!
//! At a corner with the fluid over an angle β > π potential flow goes as ∇(r^λ cos λθ), λ = π/β, with r the
//! distance and θ the angle from one face: its velocity grows as r^(λ−1), at a right angle as
//! r^(−1/3), and no polynomial follows it. Fits near a corner take this function with a free
//! strength beside the quadratic ones. It is harmonic and has no flux through either face, so that
//! neither the Laplacian nor the divergence nor the walls' rows see it; they gain as the rest of the fit is
//! no longer bent to follow it.

use nalgebra::{Point2, Vector2};

/// Distance in spacings over which a corner is felt by fits.
pub(crate) const REACH: f64 = 3.0;
/// What holds the strength back, in parts of what speaks for it: next to the corner little, and ever
/// more towards [`REACH`], so that a corner comes and goes smoothly.
const LEAST_RESTRAINT: f64 = 0.01;

/// A corner of a rigid boundary, where it stands now.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    /// Where it is, m.
    pub(crate) position: Point2<f64>,
    /// Unit vector along the face from which θ is measured, clockwise through the fluid.
    pub(crate) along: Vector2<f64>,
    /// Angle β over which the fluid lies around it, rad.
    pub(crate) open: f64,
    /// The first wall particle of each face.
    pub(crate) faces: [u32; 2],
    /// From 0 for a corner that stands on the tank's bed or side to 1 for one that is clear of them.
    pub(crate) room: f64,
}

impl Corner {
    /// λ.
    fn exponent(&self) -> f64 {
        std::f64::consts::PI / self.open
    }

    /// Distance in spacings and θ of a point at offset `d` (spacings) from the corner. Inside the
    /// body θ goes on beyond either face up to the middle between them.
    fn polar(&self, d: Vector2<f64>) -> (f64, f64) {
        let (sine, cosine) = (self.along.y * d.x - self.along.x * d.y, self.along.dot(&d));
        let full = std::f64::consts::TAU;
        let angle = sine.atan2(cosine).rem_euclid(full);
        let angle = if angle > 0.5 * (full + self.open) { angle - full } else { angle };
        (d.norm(), angle)
    }

    /// r^λ cos λθ at offset `d` (spacings) from the corner.
    pub(crate) fn potential(&self, d: Vector2<f64>) -> f64 {
        let (r, angle) = self.polar(d);
        r.powf(self.exponent()) * (self.exponent() * angle).cos()
    }

    /// Gradient of the potential at offset `d`, per spacing.
    pub(crate) fn gradient(&self, d: Vector2<f64>) -> Vector2<f64> {
        let (r, angle) = self.polar(d);
        let exponent = self.exponent();
        // The corner itself has none.
        let r = r.max(1e-3);
        let size = exponent * r.powf(exponent - 1.0);
        let outward = d / r;
        let onward = Vector2::new(outward.y, -outward.x);
        let (sine, cosine) = (exponent * angle).sin_cos();
        size * (cosine * outward - sine * onward)
    }

    /// What holds its strength back in a fit at distance `r` (spacings), where the faces are wetted
    /// in this `part`; `None` where the corner is not felt.
    pub(crate) fn restraint(&self, r: f64, part: f64) -> Option<f64> {
        let near = r / REACH;
        (near < 1.0 && part > 0.0)
            .then(|| (LEAST_RESTRAINT + near.powi(4) / (1.0 - near)) / part)
            .filter(|restraint| *restraint < 1e3)
    }
}
