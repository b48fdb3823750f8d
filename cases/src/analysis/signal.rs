//! Series sampled in time: zero crossings, extrema, the first harmonic.

use super::harmonics::harmonics;
use std::f64::consts::TAU;

/// A zero crossing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// When, s.
    pub time: f64,
    /// Whether the signal rises.
    pub rising: bool,
}

/// Crossings of `level`, by linear interpolation between samples.
#[must_use]
pub fn crossings(times: &[f64], values: &[f64], level: f64) -> Vec<Crossing> {
    let samples = times.windows(2).zip(values.windows(2));
    samples
        .filter_map(|(t, v)| {
            let (a, b) = (v[0] - level, v[1] - level);
            let crosses = (a < 0.0 && b >= 0.0) || (a > 0.0 && b <= 0.0);
            crosses.then(|| Crossing { time: t[0] + (t[1] - t[0]) * a / (a - b), rising: b > a })
        })
        .collect()
}

/// Mean time between crossings in the same direction, s: the period. Taking each direction by
/// itself keeps an asymmetric wave (sharper crests than troughs) from spoiling it.
///
/// `None` with fewer than three crossings.
#[must_use]
pub fn period(crossings: &[Crossing]) -> Option<f64> {
    let mut spans = Vec::new();
    for rising in [true, false] {
        let times: Vec<f64> =
            crossings.iter().filter(|c| c.rising == rising).map(|c| c.time).collect();
        if let [first, .., last] = times[..] {
            let count = (times.len() - 1) as f64;
            spans.push((count, last - first));
        }
    }
    let (count, time) = spans.iter().fold((0.0, 0.0), |sum, s| (sum.0 + s.0, sum.1 + s.1));
    (count > 0.0).then(|| time / count)
}

/// The largest departure from `level` between each two crossings, before the first and after the
/// last, with the sample's neighbours refined by a parabola.
#[must_use]
pub fn extrema(times: &[f64], values: &[f64], level: f64) -> Vec<(f64, f64)> {
    let mut bounds = vec![f64::NEG_INFINITY];
    bounds.extend(crossings(times, values, level).iter().map(|c| c.time));
    bounds.push(f64::INFINITY);
    bounds
        .windows(2)
        .filter_map(|span| {
            let inside = (0..times.len()).filter(|i| times[*i] > span[0] && times[*i] <= span[1]);
            let distance = |i: &usize| (values[*i] - level).abs();
            let peak = inside.max_by(|a, b| distance(a).total_cmp(&distance(b)))?;
            Some(refine(times, values, peak))
        })
        .collect()
}

/// Time and value of the vertex of the parabola through a sample and its neighbours.
pub(super) fn refine(times: &[f64], values: &[f64], peak: usize) -> (f64, f64) {
    if peak == 0 || peak + 1 == times.len() {
        return (times[peak], values[peak]);
    }
    let (before, at, after) = (values[peak - 1], values[peak], values[peak + 1]);
    let curvature = before - 2.0 * at + after;
    if curvature == 0.0 {
        return (times[peak], at);
    }
    let offset = 0.5 * (before - after) / curvature;
    let step = 0.5 * (times[peak + 1] - times[peak - 1]);
    (times[peak] + offset * step, at - 0.25 * (before - after) * offset)
}

/// Amplitude of the first harmonic of a wave of period `period` (s) over the samples in
/// `from..=to` (s): least squares with a mean and a second harmonic.
///
/// `None` with fewer than eight samples in the span.
#[must_use]
pub fn first_harmonic(
    times: &[f64],
    values: &[f64],
    period: f64,
    (from, to): (f64, f64),
) -> Option<f64> {
    let inside = |time: &f64| *time >= from && *time <= to;
    let (times, values): (Vec<f64>, Vec<f64>) =
        times.iter().zip(values).filter(|(time, _)| inside(time)).unzip();
    Some(harmonics(&times, &values, TAU / period, 2)?.amplitudes[0].norm())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampled(f: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        let times: Vec<f64> = (0..2001).map(|i| f64::from(i) * 0.01).collect();
        let values = times.iter().map(|t| f(*t)).collect();
        (times, values)
    }

    #[test]
    fn period_and_amplitude_of_a_wave_with_a_second_harmonic() {
        let omega = TAU / 1.2345;
        let (times, values) =
            sampled(|t| 0.3 + 2.0 * (omega * t + 0.4).cos() + 0.2 * (2.0 * omega * t + 0.8).cos());
        let found = period(&crossings(&times, &values, 0.0)).unwrap();
        assert!((found - 1.2345).abs() < 1e-4, "{found}");
        let amplitude = first_harmonic(&times, &values, found, (0.0, 2.5)).unwrap();
        assert!((amplitude - 2.0).abs() < 1e-3, "{amplitude}");
    }

    #[test]
    fn extrema_are_found_between_samples() {
        let (times, values) = sampled(|t| (TAU * (t - 0.003)).cos());
        let found = extrema(&times, &values, 0.0);
        assert!((found[2].0 - 1.003).abs() < 1e-5 && (found[2].1 - 1.0).abs() < 1e-6);
        assert!((found[1].0 - 0.503).abs() < 1e-5 && (found[1].1 + 1.0).abs() < 1e-6);
    }

    #[test]
    fn a_constant_has_no_period() {
        let (times, values) = sampled(|_| 1.0);
        assert_eq!(period(&crossings(&times, &values, 0.0)), None);
    }
}
