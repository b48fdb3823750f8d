//! Free decay: period and damping ratio of an oscillation that dies out.
//!
//! Model: x(t) = c + A exp(−ζ ω t) cos(ω √(1 − ζ²) t + φ). Successive extrema then lie half a
//! damped period apart and the distance between them shrinks by exp(−ζ π / √(1 − ζ²)) each time;
//! using distances between extrema, not extrema, leaves the level c out of the damping.

use super::signal::{crossings, extrema, period};
use std::f64::consts::PI;

/// Extrema that have fallen below this part of the first are left out: by then, waves that the
/// body made and the ends of the tank sent back move it as much as its own decay.
const SMALLEST_EXTREMUM: f64 = 0.2;

/// A decay as it was found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decay {
    /// Level about which it oscillates, in the unit of the signal.
    pub level: f64,
    /// Damped period, s: the mean time between crossings of the level in the same direction.
    pub damped_period: f64,
    /// Damping ratio ζ from the logarithmic decrement of successive extrema.
    pub damping_ratio: f64,
    /// Number of extrema used.
    pub extrema: usize,
}

impl Decay {
    /// The period without damping, s.
    #[must_use]
    pub fn natural_period(&self) -> f64 {
        self.damped_period * (1.0 - self.damping_ratio.powi(2)).sqrt()
    }
}

/// The decay in a series; `None` if it does not oscillate for at least a period.
#[must_use]
pub fn decay(times: &[f64], values: &[f64]) -> Option<Decay> {
    // The mean is a first guess of the level; three successive extrema of it give a better one.
    let mut level = values.iter().sum::<f64>() / values.len().max(1) as f64;
    for _ in 0..3 {
        let found = significant_extrema(times, values, level);
        let guesses: Vec<f64> = found.windows(3).filter_map(geometric_limit).collect();
        level = median(guesses)?;
    }
    let found = significant_extrema(times, values, level);
    let end = found.last()?.0;
    let within: Vec<_> =
        crossings(times, values, level).into_iter().filter(|c| c.time <= end).collect();
    let distances: Vec<f64> = found.windows(2).map(|pair| (pair[1].1 - pair[0].1).abs()).collect();
    Some(Decay {
        level,
        damped_period: period(&within)?,
        damping_ratio: damping_ratio(&distances)?,
        extrema: found.len(),
    })
}

/// The extrema up to the first that is lost in noise, and not the end of the record.
fn significant_extrema(times: &[f64], values: &[f64], level: f64) -> Vec<(f64, f64)> {
    let mut found = extrema(times, values, level);
    if found.last().is_some_and(|(time, _)| Some(time) == times.last()) {
        found.pop();
    }
    let smallest =
        found.first().map_or(0.0, |(_, value)| SMALLEST_EXTREMUM * (value - level).abs());
    found.into_iter().take_while(|(_, value)| (value - level).abs() >= smallest).collect()
}

/// The level about which three successive extrema shrink by a constant factor.
fn geometric_limit(extrema: &[(f64, f64)]) -> Option<f64> {
    let [(_, a), (_, b), (_, c)] = extrema else { return None };
    let curvature = a - 2.0 * b + c;
    (curvature != 0.0).then(|| (a * c - b * b) / curvature)
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Damping ratio from distances between successive extrema: the slope of their logarithm.
fn damping_ratio(distances: &[f64]) -> Option<f64> {
    if distances.len() < 2 {
        return None;
    }
    let count = distances.len() as f64;
    let middle = (count - 1.0) / 2.0;
    let (mut slope, mut weight) = (0.0, 0.0);
    for (index, distance) in distances.iter().enumerate() {
        slope += (index as f64 - middle) * distance.ln();
        weight += (index as f64 - middle).powi(2);
    }
    let decrement = -slope / weight;
    decrement.is_finite().then(|| decrement / decrement.hypot(PI))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn damped(period: f64, ratio: f64, level: f64, end: f64) -> (Vec<f64>, Vec<f64>) {
        let omega = TAU / period;
        let damped = omega * (1.0 - ratio * ratio).sqrt();
        let times: Vec<f64> = (0..=(end / 0.01) as usize).map(|i| i as f64 * 0.01).collect();
        let values = times
            .iter()
            .map(|t| {
                let phase = damped * t;
                let shape = phase.cos() + ratio * omega / damped * phase.sin();
                level + 0.01 * (-ratio * omega * t).exp() * shape
            })
            .collect();
        (times, values)
    }

    #[test]
    fn strong_damping_about_a_level_that_is_not_zero() {
        let (times, values) = damped(0.93, 0.146, 0.002, 4.0);
        let found = decay(&times, &values).unwrap();
        assert!((found.natural_period() - 0.93).abs() < 1e-3, "{found:?}");
        assert!((found.damping_ratio - 0.146).abs() < 1e-3, "{found:?}");
        assert!((found.level - 0.002).abs() < 1e-5, "{found:?}");
    }

    #[test]
    fn hardly_any_damping_and_a_record_that_ends_within_a_swing() {
        let (times, values) = damped(1.548, 0.001, 0.0, 6.0);
        let found = decay(&times, &values).unwrap();
        assert!((found.damped_period - 1.548).abs() < 1e-3, "{found:?}");
        assert!((found.damping_ratio - 0.001).abs() < 1e-4, "{found:?}");
    }

    #[test]
    fn no_oscillation_no_decay() {
        let times: Vec<f64> = (0..100).map(f64::from).collect();
        assert_eq!(decay(&times, &vec![1.0; 100]), None);
        assert_eq!(decay(&times, &times), None);
        assert_eq!(decay(&[], &[]), None);
    }
}
