//! The stroke of a paddle as a function of time, and the ramp that starts it.

use super::Board;
use crate::waves::spline::Spline;
use crate::waves::{StillWater, WaveError};
use nalgebra::Complex;
use std::f64::consts::FRAC_PI_2;

/// Displacement at the still-water level, and its rates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StrokeMotion {
    /// X, m.
    pub displacement: f64,
    /// dX/dt, m/s.
    pub velocity: f64,
    /// d²X/dt², m/s².
    pub acceleration: f64,
}

impl std::ops::Add for StrokeMotion {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self {
            displacement: self.displacement + other.displacement,
            velocity: self.velocity + other.velocity,
            acceleration: self.acceleration + other.acceleration,
        }
    }
}

/// One term X sin(ω t + φ) of a stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Harmonic {
    /// Amplitude X, m.
    pub(super) amplitude: f64,
    /// Angular frequency ω, rad/s.
    pub(super) frequency: f64,
    /// Phase φ, rad.
    pub(super) phase: f64,
    /// Elevation of the evanescent waves at the board over its displacement.
    near_field: f64,
}

impl Harmonic {
    pub(super) fn new(
        board: Board,
        water: StillWater,
        amplitude: f64,
        frequency: f64,
        phase: f64,
    ) -> Self {
        let near_field = board.near_field(water, frequency);
        Self { amplitude, frequency, phase, near_field }
    }

    /// With the motion Re{`amplitude` exp(−iωt)} added, m.
    pub(super) fn plus(self, amplitude: Complex<f64>) -> Self {
        // X sin(ωt + φ) = Re{X exp(i (π/2 − φ)) exp(−iωt)}.
        let own = Complex::from_polar(self.amplitude, FRAC_PI_2 - self.phase);
        let (size, angle) = (own + amplitude).to_polar();
        Self { amplitude: size, phase: FRAC_PI_2 - angle, ..self }
    }

    fn at(&self, time: f64) -> StrokeMotion {
        let w = self.frequency;
        let (sin, cos) = (w * time + self.phase).sin_cos();
        StrokeMotion {
            displacement: self.amplitude * sin,
            velocity: self.amplitude * w * cos,
            acceleration: -self.amplitude * w * w * sin,
        }
    }
}

/// A stroke before its ramp.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Stroke {
    Harmonics(Vec<Harmonic>),
    Series(Spline),
}

impl Stroke {
    pub(super) fn at(&self, time: f64) -> StrokeMotion {
        match self {
            Self::Harmonics(terms) => terms
                .iter()
                .map(|term| term.at(time))
                .fold(StrokeMotion::default(), |sum, motion| sum + motion),
            Self::Series(spline) => {
                let [displacement, velocity, acceleration] = spline.at(time);
                StrokeMotion { displacement, velocity, acceleration }
            }
        }
    }
}

impl Stroke {
    /// Elevation of the evanescent waves at the board, m; none is known for a series.
    pub(super) fn near_field(&self, time: f64) -> f64 {
        match self {
            Self::Harmonics(terms) => {
                terms.iter().map(|term| term.near_field * term.at(time).displacement).sum()
            }
            Self::Series(_) => 0.0,
        }
    }
}

/// A start from rest: a factor that rises from 0 to 1 with two continuous derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ramp {
    duration: f64,
}

impl Ramp {
    /// A ramp of `duration` (s); 0 for none.
    ///
    /// # Errors
    /// A negative duration.
    pub(super) fn new(duration: f64) -> Result<Self, WaveError> {
        let allowed = "a finite number, 0 or above";
        crate::waves::require(duration >= 0.0, "ramp (s)", duration, allowed)?;
        Ok(Self { duration })
    }

    /// Factor and its first two derivatives: s³ (10 − 15 s + 6 s²).
    pub(super) fn at(&self, time: f64) -> [f64; 3] {
        if time >= self.duration {
            return [1.0, 0.0, 0.0];
        }
        if time <= 0.0 {
            return [0.0; 3];
        }
        let (s, d) = (time / self.duration, self.duration);
        [
            s.powi(3) * (10.0 - 15.0 * s + 6.0 * s * s),
            30.0 * s * s * (1.0 - s).powi(2) / d,
            60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (d * d),
        ]
    }

    /// The product of the ramp and a motion.
    pub(super) fn apply(&self, time: f64, motion: StrokeMotion) -> StrokeMotion {
        let [r, r1, r2] = self.at(time);
        let StrokeMotion { displacement: x, velocity: v, acceleration: a } = motion;
        StrokeMotion {
            displacement: r * x,
            velocity: r * v + r1 * x,
            acceleration: r * a + 2.0 * r1 * v + r2 * x,
        }
    }
}
