//! Oscillation by a formula.

use super::{Course, PrescribedMotion, about};
use crate::BodyError;
use nalgebra::Point2;
use seakeep_coupler::interface::BoundaryKinematics;
use std::f64::consts::TAU;

/// x(t) = `amplitude` sin(2π t / `period` + `phase`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Oscillation {
    /// Amplitude, m or rad.
    pub amplitude: f64,
    /// Period, s.
    pub period: f64,
    /// Phase, rad.
    pub phase: f64,
}

impl Oscillation {
    fn at(&self, time: f64) -> Course {
        let omega = TAU / self.period;
        let (sin, cos) = (omega * time + self.phase).sin_cos();
        let amplitude = self.amplitude;
        [amplitude * sin, amplitude * omega * cos, -amplitude * omega * omega * sin]
    }
}

/// Harmonic motion about a pose of rest, started smoothly: each degree of freedom oscillates,
/// multiplied by a ramp that rises from 0 at time 0 to 1 at `ramp` with two continuous
/// derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Harmonic {
    rest: BoundaryKinematics,
    degrees: [Option<Oscillation>; 3],
    ramp: f64,
}

impl Harmonic {
    /// Oscillates in sway, heave and roll, those that are given, about `position` (m) and `angle`
    /// (rad); `ramp` (s) may be 0.
    ///
    /// # Errors
    /// [`BodyError::Motion`]: an amplitude or a phase that is not finite, a period that is not
    /// positive, a ramp that is negative.
    pub fn new(
        position: Point2<f64>,
        angle: f64,
        degrees: [Option<Oscillation>; 3],
        ramp: f64,
    ) -> Result<Self, BodyError> {
        let refused = |reason: String| Err(BodyError::Motion { reason });
        for Oscillation { amplitude, period, phase } in degrees.iter().flatten() {
            if !(amplitude.is_finite() && phase.is_finite()) {
                return refused(format!("amplitude {amplitude} and phase {phase} must be finite"));
            }
            if !(period.is_finite() && *period > 0.0) {
                return refused(format!("period {period} s must be positive and finite"));
            }
        }
        if !(ramp.is_finite() && ramp >= 0.0) {
            return refused(format!("ramp {ramp} s must be finite and not negative"));
        }
        Ok(Self { rest: BoundaryKinematics::at_rest(position, angle), degrees, ramp })
    }

    /// The ramp s³ (10 − 15 s + 6 s²), s = t / `ramp`, with its derivatives.
    fn ramp_at(&self, time: f64) -> Course {
        if time >= self.ramp {
            return [1.0, 0.0, 0.0];
        }
        let s = (time / self.ramp).max(0.0);
        [
            s * s * s * (10.0 - 15.0 * s + 6.0 * s * s),
            30.0 * s * s * (1.0 - s) * (1.0 - s) / self.ramp,
            60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (self.ramp * self.ramp),
        ]
    }
}

impl PrescribedMotion for Harmonic {
    fn kinematics(&self, time: f64) -> Result<BoundaryKinematics, BodyError> {
        let [r, r1, r2] = self.ramp_at(time);
        let course = |degree: Option<Oscillation>| {
            let [x, x1, x2] = degree.map_or([0.0; 3], |oscillation| oscillation.at(time));
            [r * x, r1 * x + r * x1, r2 * x + 2.0 * r1 * x1 + r * x2]
        };
        Ok(about(&self.rest, self.degrees.map(course)))
    }
}
