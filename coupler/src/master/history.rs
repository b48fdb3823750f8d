//! Inputs over a communication step, from their means over the last ones.
//!
//! A component is given the mean of its input over each of its own steps. What crosses the
//! interface is one mean a communication step. Between them stands the polynomial of degree d whose
//! means over the last d + 1 communication steps are those values, so that the impulse of a load
//! and the change of a velocity are kept, whatever the number of steps on either side.

use super::settings::Extrapolation;
use serde::{Deserialize, Serialize};

/// A stretch of a communication step: 0 is its start and 1 its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Span {
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Span {
    /// Step `number`, from 0, of `count` equal ones.
    pub(super) fn of(number: u32, count: u32) -> Self {
        let (number, count) = (f64::from(number), f64::from(count));
        Self { from: number / count, to: (number + 1.0) / count }
    }

    /// The same stretch later by `shift`.
    pub(super) fn shifted(self, shift: f64) -> Self {
        Self { from: self.from + shift, to: self.to + shift }
    }
}

/// Means of a quantity over the last communication steps, newest first.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct History {
    means: Vec<Vec<f64>>,
}

impl History {
    /// Adds the mean over the step that ended now.
    pub(super) fn push(&mut self, mean: &[f64]) {
        self.means.insert(0, mean.to_vec());
        self.means.truncate(Extrapolation::Quadratic.values());
    }

    /// Mean over a stretch of the coming step; `None` where there is no step before it. The degree
    /// is lower at first, while there are few steps before.
    pub(super) fn extrapolate(&self, degree: Extrapolation, span: Span) -> Option<Vec<f64>> {
        if self.means.is_empty() {
            return None;
        }
        let means: Vec<&[f64]> = self.means.iter().map(Vec::as_slice).collect();
        Some(mean(&means[..means.len().min(degree.values())], span))
    }

    /// Mean over a stretch of the coming step, whose mean as a whole is `newest`.
    pub(super) fn interpolate(
        &self,
        newest: &[f64],
        degree: Extrapolation,
        span: Span,
    ) -> Vec<f64> {
        let older = self.means.iter().map(Vec::as_slice).take(degree.values() - 1);
        let means: Vec<&[f64]> = std::iter::once(newest).chain(older).collect();
        mean(&means, span.shifted(-1.0))
    }
}

/// Mean over `span` of the polynomial with the means `means` (newest first, one to three) over the
/// unit stretches that end at 0, −1 and −2.
///
/// Its integral from 0 is interpolated at the ends of the stretches with Newton's backward
/// differences: s ∇ + s (s + 1)/2 ∇² + s (s + 1)(s + 2)/6 ∇³.
fn mean(means: &[&[f64]], span: Span) -> Vec<f64> {
    let basis = |s: f64| [s, s * (s + 1.0) / 2.0, s * (s + 1.0) * (s + 2.0) / 6.0];
    let (low, high, length) = (basis(span.from), basis(span.to), span.to - span.from);
    let weight = |order: usize| (high[order] - low[order]) / length;
    (0..means[0].len())
        .map(|place| {
            let value = |age: usize| means[age][place];
            let mut sum = weight(0) * value(0);
            if means.len() > 1 {
                sum += weight(1) * (value(0) - value(1));
            }
            if means.len() > 2 {
                sum += weight(2) * (value(0) - 2.0 * value(1) + value(2));
            }
            sum
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{History, Span};
    use crate::Extrapolation::{self, Hold, Linear, Quadratic};

    /// Mean of 2 − 3 s + 5 s² up to a degree, between two points.
    fn exact(degree: Extrapolation, from: f64, to: f64) -> f64 {
        let terms = [2.0, -3.0, 5.0];
        let power = |k: usize, s: f64| s.powi(k as i32 + 1) / (k as f64 + 1.0);
        let integral = |s: f64| (0..degree.values()).map(|k| terms[k] * power(k, s)).sum::<f64>();
        (integral(to) - integral(from)) / (to - from)
    }

    #[test]
    fn polynomials_are_continued_exactly() {
        for degree in [Hold, Linear, Quadratic] {
            let mut history = History::default();
            for step in [-3.0, -2.0, -1.0] {
                history.push(&[exact(degree, step, step + 1.0)]);
            }
            let newest = [exact(degree, 0.0, 1.0)];
            for (number, count) in [(0, 1), (0, 2), (1, 2), (3, 5), (9, 10)] {
                let span = Span::of(number, count);
                let wanted = exact(degree, span.from, span.to);
                let ahead = history.extrapolate(degree, span).expect("there is a past")[0];
                let within = history.interpolate(&newest, degree, span)[0];
                assert!((ahead - wanted).abs() < 1e-13, "{degree:?} {span:?}: {ahead}, {wanted}");
                assert!((within - wanted).abs() < 1e-13, "{degree:?} {span:?}: {within}, {wanted}");
            }
        }
    }

    /// Whatever the values, the parts of a step have the mean of the whole.
    #[test]
    fn means_are_kept() {
        let mut history = History::default();
        history.push(&[7.0]);
        history.push(&[-4.0]);
        for degree in [Hold, Linear, Quadratic] {
            let parts = (0..6).map(|i| history.interpolate(&[1.5], degree, Span::of(i, 6))[0]);
            assert!((parts.sum::<f64>() / 6.0 - 1.5).abs() < 1e-14, "{degree:?}");
            assert_eq!(history.interpolate(&[1.5], degree, Span::of(0, 1)), [1.5], "{degree:?}");
        }
    }

    #[test]
    fn a_short_past_lowers_the_degree() {
        let mut history = History::default();
        assert_eq!(history.extrapolate(Quadratic, Span::of(0, 1)), None);
        history.push(&[3.0]);
        assert_eq!(history.extrapolate(Quadratic, Span::of(0, 1)), Some(vec![3.0]));
        history.push(&[5.0]);
        assert_eq!(history.extrapolate(Quadratic, Span::of(0, 1)), Some(vec![7.0]));
    }
}
