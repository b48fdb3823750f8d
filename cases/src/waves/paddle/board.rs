//! The board of a paddle: its shape, and the waves a small motion of it makes.

use super::StrokeMotion;
use crate::waves::dispersion::cosh_over_cosh;
use crate::waves::quadrature::simpson;
use crate::waves::{StillWater, WaveError, require};
use nalgebra::{Point2, Vector2};
use seakeep_coupler::interface::BoundaryKinematics;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Evanescent modes that are summed; their amplitudes fall with the third power of the number.
const EVANESCENT_MODES: usize = 100;

/// The board of a paddle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Board {
    /// An upright wall that moves horizontally.
    Piston,
    /// A wall that turns about a hinge. Below a hinge above the bed the wall is fixed.
    Flap {
        /// Height of the hinge above the bed, m; below the bed where negative.
        hinge: f64,
    },
}

impl Board {
    /// Refuses a hinge that is not below the still-water level.
    ///
    /// # Errors
    /// [`WaveError::Parameter`].
    pub fn validate(&self, water: StillWater) -> Result<(), WaveError> {
        match self {
            Self::Piston => Ok(()),
            Self::Flap { hinge } => {
                let allowed = format!("below the still-water level at {} m", water.depth);
                require(*hinge < water.depth, "height of the hinge (m)", *hinge, &allowed)
            }
        }
    }

    /// Displacement at height `y` (m) over that at the still-water level.
    #[must_use]
    pub fn shape(&self, water: StillWater, y: f64) -> f64 {
        match self {
            Self::Piston => 1.0,
            Self::Flap { hinge } => ((y - hinge) / (water.depth - hinge)).max(0.0),
        }
    }

    /// Derivative of [`Self::shape`] with respect to y, 1/m.
    pub(super) fn slope(&self, water: StillWater, y: f64) -> f64 {
        match self {
            Self::Flap { hinge } if y > *hinge => (water.depth - hinge).recip(),
            _ => 0.0,
        }
    }

    /// Lowest point of the moving part, m.
    pub(super) fn foot(&self) -> f64 {
        match self {
            Self::Piston => 0.0,
            Self::Flap { hinge } => hinge.max(0.0),
        }
    }

    /// ∫ `f`(y) cosh ky / cosh kD over the depth, m times the unit of `f`, which may have a kink
    /// at the foot of the moving part.
    pub(super) fn project(
        &self,
        water: StillWater,
        wave_number: f64,
        f: impl Fn(f64) -> f64,
    ) -> f64 {
        let kd = wave_number * water.depth;
        let panels = 40 + (8.0 * kd) as usize;
        let over =
            |low, high| simpson(low, high, panels, |y| f(y) * cosh_over_cosh(wave_number * y, kd));
        let foot = self.foot();
        let fixed = if foot > 0.0 { over(0.0, foot) } else { 0.0 };
        fixed + over(foot, water.depth)
    }

    /// Amplitude of the progressive wave over that of the stroke, by linear theory (Biésel 1951;
    /// Dean & Dalrymple 1984, section 6.3): sinh kD ∫ shape cosh ky dy / ∫ cosh² ky dy. For a
    /// piston this is 2 sinh² kD / (sinh kD cosh kD + kD).
    #[must_use]
    pub fn transfer(&self, water: StillWater, wave_number: f64) -> f64 {
        let kd = wave_number * water.depth;
        let along = self.project(water, wave_number, |y| self.shape(water, y));
        // ∫ cosh² ky dy / cosh² kD = (D / cosh² kD + tanh kD / k) / 2.
        let cosh_squared = 1.0 - kd.tanh().powi(2);
        let norm = 0.5 * (water.depth * cosh_squared + kd.tanh() / wave_number);
        kd.tanh() * along / norm
    }

    /// The evanescent modes of a small motion of angular frequency `frequency` (rad/s): decay rate
    /// k_j (1/m), k_j tan k_j D = −ω²/g, and amplitude over that of the stroke. Their elevation is
    /// in phase with the stroke: with X sin ωt it is Σ e_j X sin ωt exp(−k_j x).
    pub(super) fn evanescent_modes(
        &self,
        water: StillWater,
        frequency: f64,
    ) -> impl Iterator<Item = (f64, f64)> {
        let (depth, board) = (water.depth, *self);
        let deep = frequency * frequency * depth / water.gravity;
        (1..=EVANESCENT_MODES).map(move |j| {
            // x tan x = −deep has one root between (j − 1/2) π and j π.
            let (mut low, mut high) = ((j as f64 - 0.5) * PI, j as f64 * PI);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let positive = middle * middle.sin() + deep * middle.cos() > 0.0;
                if positive == (j % 2 == 1) {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            let x = 0.5 * (low + high);
            let k = x / depth;
            let along = match board {
                Self::Piston => x.sin() / k,
                Self::Flap { hinge } => {
                    let foot = board.foot();
                    let at = |y: f64| (y - hinge) * (k * y).sin() / k + (k * y).cos() / (k * k);
                    (at(depth) - at(foot)) / (depth - hinge)
                }
            };
            let norm = 0.5 * depth + (2.0 * x).sin() / (4.0 * k);
            (k, -frequency * frequency / water.gravity * x.cos() * along / (k * norm))
        })
    }

    /// Elevation at the board, in phase with the stroke and over its amplitude, that stays with
    /// the board: the evanescent waves of a small motion of angular `frequency` (rad/s).
    #[must_use]
    pub fn near_field(&self, water: StillWater, frequency: f64) -> f64 {
        self.evanescent_modes(water, frequency).map(|(_, amplitude)| amplitude).sum()
    }

    /// Kinematics of the board as a rigid body that stands upright at x = 0 when at rest. The
    /// reference point is the foot of a piston and the hinge of a flap.
    #[must_use]
    pub fn kinematics(&self, water: StillWater, stroke: StrokeMotion) -> BoundaryKinematics {
        let StrokeMotion { displacement, velocity, acceleration } = stroke;
        match self {
            Self::Piston => BoundaryKinematics {
                velocity: Vector2::new(velocity, 0.0),
                acceleration: Vector2::new(acceleration, 0.0),
                ..BoundaryKinematics::at_rest(Point2::new(displacement, 0.0), 0.0)
            },
            Self::Flap { hinge } => {
                // tan(−angle) = X / arm: forward is clockwise.
                let arm = water.depth - hinge;
                let tan = displacement / arm;
                let square = 1.0 + tan * tan;
                let rate = velocity / arm / square;
                let growth = acceleration / arm / square - 2.0 * tan * rate * rate;
                BoundaryKinematics {
                    angular_velocity: -rate,
                    angular_acceleration: -growth,
                    ..BoundaryKinematics::at_rest(Point2::new(0.0, *hinge), -tan.atan())
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WATER: StillWater = StillWater { depth: 0.4, gravity: 9.81 };

    #[test]
    fn piston_has_its_closed_form() {
        for kd in [0.05f64, 0.5, 1.298, 4.0, 15.0] {
            let exact = 2.0 * kd.sinh().powi(2) / (kd.sinh() * kd.cosh() + kd);
            let found = Board::Piston.transfer(WATER, kd / 0.4);
            assert!((found / exact - 1.0).abs() < 1e-6, "kD = {kd}: {found} {exact}");
        }
        // Section 3 of the reference: H/S of a wave of 1.2 s.
        assert!((Board::Piston.transfer(WATER, 3.245_031) - 1.239_747).abs() < 1e-6);
    }

    #[test]
    fn flap_hinged_at_the_bed_has_its_closed_form() {
        // Dean & Dalrymple (6.26): H/S = 4 (sinh/x) (x sinh − cosh + 1) / (sinh 2x + 2x).
        for kd in [0.1f64, 0.5, 1.298, 4.0, 15.0] {
            let exact = 4.0 * kd.sinh() / kd * (kd * kd.sinh() - kd.cosh() + 1.0)
                / ((2.0 * kd).sinh() + 2.0 * kd);
            let found = Board::Flap { hinge: 0.0 }.transfer(WATER, kd / 0.4);
            assert!((found / exact - 1.0).abs() < 1e-6, "kD = {kd}: {found} {exact}");
        }
    }

    #[test]
    fn hinge_far_below_is_a_piston_and_hinge_above_the_bed_makes_less() {
        let piston = Board::Piston.transfer(WATER, 3.0);
        let deep = Board::Flap { hinge: -1e5 }.transfer(WATER, 3.0);
        assert!((deep / piston - 1.0).abs() < 1e-5);
        let bed = Board::Flap { hinge: 0.0 }.transfer(WATER, 3.0);
        let above = Board::Flap { hinge: 0.1 }.transfer(WATER, 3.0);
        assert!(above < bed && bed < piston);
        assert!(Board::Flap { hinge: 0.4 }.validate(WATER).is_err());
    }

    #[test]
    fn progressive_and_evanescent_waves_together_conserve_mass() {
        // The volume that the board pushes is that of the waves: ∫ shape dy = T/k + Σ e_j/k_j.
        let boards = [
            (Board::Piston, 0.4),
            (Board::Flap { hinge: 0.0 }, 0.2),
            (Board::Flap { hinge: -0.4 }, 0.3),
            (Board::Flap { hinge: 0.2 }, 0.1),
        ];
        for (board, area) in boards {
            for period in [0.6, 1.2, 3.0] {
                let frequency = std::f64::consts::TAU / period;
                let k = WATER.wave_number(frequency);
                let near: f64 = board.evanescent_modes(WATER, frequency).map(|(k, e)| e / k).sum();
                let volume = board.transfer(WATER, k) / k + near;
                assert!((volume / area - 1.0).abs() < 1e-5, "{board:?}, T = {period}: {volume}");
            }
        }
    }

    #[test]
    fn flap_is_where_its_stroke_says_it_is() {
        let board = Board::Flap { hinge: -0.1 };
        let stroke = |t: f64| StrokeMotion {
            displacement: 0.1 * t.sin(),
            velocity: 0.1 * t.cos(),
            acceleration: -0.1 * t.sin(),
        };
        let at = |t: f64| board.kinematics(WATER, stroke(t));
        let (now, h) = (at(0.7), 1e-4);
        let (before, after) = (at(0.7 - h), at(0.7 + h));
        let rate = (after.angle - before.angle) / (2.0 * h);
        let growth = (after.angular_velocity - before.angular_velocity) / (2.0 * h);
        assert!((now.angular_velocity - rate).abs() < 1e-8);
        assert!((now.angular_acceleration - growth).abs() < 1e-8);
        // The board's line, which is upright at rest, crosses the still-water level at X.
        let crossing = -0.5 * now.angle.tan();
        assert!((crossing - 0.1 * 0.7f64.sin()).abs() < 1e-14);
    }
}
