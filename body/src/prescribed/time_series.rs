//! A motion that was recorded.

use super::{PrescribedMotion, about};
use crate::BodyError;
use crate::spline::CubicSpline;
use nalgebra::Point2;
use seakeep_coupler::interface::BoundaryKinematics;

/// Fewest samples of a series: a cubic spline has to be determined.
const FEWEST: usize = 4;

/// Sway, heave and roll at given times, evenly spaced or not, with a cubic spline between: the
/// acceleration is continuous.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeSeries {
    rest: BoundaryKinematics,
    times: Vec<f64>,
    degrees: [CubicSpline; 3],
}

impl TimeSeries {
    /// Through `samples` of sway (m), heave (m) and roll (rad) at `times` (s): sway and heave
    /// relative to `rest` (m), roll from the upright.
    ///
    /// # Errors
    /// [`BodyError::Motion`]: fewer than four samples, not one for each time, a gap (a value that
    /// is not finite), or times that do not rise. The sample is named by its number from 1.
    pub fn new(
        rest: Point2<f64>,
        times: Vec<f64>,
        samples: &[[f64; 3]],
    ) -> Result<Self, BodyError> {
        let refused = |reason: String| Err(BodyError::Motion { reason });
        if times.len() != samples.len() {
            return refused(format!("{} samples at {} times", samples.len(), times.len()));
        }
        if times.len() < FEWEST {
            return refused(format!("{} samples, at least {FEWEST} are needed", times.len()));
        }
        for (number, (time, sample)) in (1..).zip(times.iter().zip(samples)) {
            let names = ["time", "sway", "heave", "roll"];
            let values = [&[*time], &sample[..]].concat();
            for (name, value) in names.iter().zip(&values) {
                if !value.is_finite() {
                    return refused(format!(
                        "a gap: {name} of sample {number} (t = {time} s) is {value}"
                    ));
                }
            }
        }
        for (number, pair) in (2..).zip(times.windows(2)) {
            if pair[1] <= pair[0] {
                return refused(format!(
                    "times must rise, but sample {number} at {} s follows one at {} s",
                    pair[1], pair[0]
                ));
            }
        }
        let spline = |degree: usize| {
            CubicSpline::new(&times, samples.iter().map(|sample| sample[degree]).collect())
        };
        let degrees = [spline(0), spline(1), spline(2)];
        Ok(Self { rest: BoundaryKinematics::at_rest(rest, 0.0), times, degrees })
    }

    /// First and last time, s.
    #[must_use]
    pub fn span(&self) -> [f64; 2] {
        [self.times[0], self.times[self.times.len() - 1]]
    }
}

impl PrescribedMotion for TimeSeries {
    fn kinematics(&self, time: f64) -> Result<BoundaryKinematics, BodyError> {
        let [start, end] = self.span();
        // Sums of steps may miss the ends by their rounding.
        let tolerance = 1e-9 * (end - start);
        if !(time >= start - tolerance && time <= end + tolerance) {
            return Err(BodyError::OutsideMotion { time, start, end });
        }
        let after = self.times.partition_point(|known| *known <= time);
        let left = after.clamp(1, self.times.len() - 1) - 1;
        let [sway, heave, roll] = &self.degrees;
        let courses = [sway, heave, roll].map(|degree| degree.at(&self.times, left, time));
        Ok(about(&self.rest, courses))
    }
}
