//! Waves of a record between zero up-crossings, and their statistics.

use super::signal::refine;

/// One wave: from an up-crossing to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// When it begins, s.
    pub start: f64,
    /// Time between the crossings, s.
    pub period: f64,
    /// Highest elevation above the level, m.
    pub crest: f64,
    /// Lowest elevation, m, below 0.
    pub trough: f64,
}

impl Wave {
    /// Height from trough to crest, m.
    #[must_use]
    pub fn height(&self) -> f64 {
        self.crest - self.trough
    }
}

/// The waves of a record about `level`. A crossing counts once the record has been `threshold`
/// below the level before and is as much above it afterwards, so that noise makes no waves.
#[must_use]
pub fn waves(times: &[f64], values: &[f64], level: f64, threshold: f64) -> Vec<Wave> {
    let mut begins: Vec<(usize, f64)> = Vec::new();
    let (mut has_been_below, mut rising) = (false, None);
    for i in 1..times.len().min(values.len()) {
        let (before, now) = (values[i - 1] - level, values[i] - level);
        if before < 0.0 && now >= 0.0 {
            let time = times[i - 1] + (times[i] - times[i - 1]) * before / (before - now);
            rising = Some((i, time));
        }
        if before < -threshold || now < -threshold {
            has_been_below = true;
        }
        if now >= threshold && has_been_below {
            begins.extend(rising.take());
            has_been_below = false;
        }
    }
    let wave = |pair: &[(usize, f64)]| {
        let [(from, start), (to, end)] = pair else { return None };
        let by_value = |a: &usize, b: &usize| values[*a].total_cmp(&values[*b]);
        let highest = (*from..*to).max_by(by_value)?;
        let lowest = (*from..*to).min_by(by_value)?;
        Some(Wave {
            start: *start,
            period: end - start,
            crest: refine(times, values, highest).1 - level,
            trough: refine(times, values, lowest).1 - level,
        })
    };
    begins.windows(2).filter_map(wave).collect()
}

/// Statistics of waves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaveStatistics {
    /// Number of waves.
    pub count: usize,
    /// Mean height, m.
    pub mean_height: f64,
    /// Mean period, s.
    pub mean_period: f64,
    /// Mean height of the highest third, H_1/3, m.
    pub significant_height: f64,
    /// Mean period of the highest third, T_1/3, s.
    pub significant_period: f64,
    /// Greatest height, m.
    pub highest: f64,
}

/// The statistics of `waves`; `None` without any.
#[must_use]
pub fn statistics(waves: &[Wave]) -> Option<WaveStatistics> {
    let mut sorted: Vec<&Wave> = waves.iter().collect();
    sorted.sort_by(|a, b| b.height().total_cmp(&a.height()));
    let highest = sorted.first()?.height();
    let third = &sorted[..sorted.len().div_ceil(3)];
    let mean = |of: &[&Wave], what: fn(&Wave) -> f64| {
        of.iter().map(|wave| what(wave)).sum::<f64>() / of.len() as f64
    };
    Some(WaveStatistics {
        count: sorted.len(),
        mean_height: mean(&sorted, Wave::height),
        mean_period: mean(&sorted, |wave| wave.period),
        significant_height: mean(third, Wave::height),
        significant_period: mean(third, |wave| wave.period),
        highest,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::irregular::irregular_sea;
    use crate::waves::spectrum::{Spectrum, SpectrumForm};
    use crate::waves::{StillWater, WaveTheory};
    use std::f64::consts::TAU;

    /// A little noise that is the same every time.
    fn noise(i: u32) -> f64 {
        f64::from(i.wrapping_mul(2_654_435_761) >> 16) / 65536.0 - 0.5
    }

    #[test]
    fn waves_of_two_heights_in_noise() {
        let times: Vec<f64> = (0..4000).map(|i| f64::from(i) * 0.005).collect();
        let height = |t: f64| if t < 10.0 { 0.1 } else { 0.2 };
        let values: Vec<f64> = times
            .iter()
            .zip(0..)
            .map(|(t, i)| 0.5 * height(*t) * (TAU * t).sin() + 0.3 + 0.002 * noise(i))
            .collect();
        let found = waves(&times, &values, 0.3, 0.01);
        assert!((18..=20).contains(&found.len()), "{}", found.len());
        assert!(found.iter().all(|wave| (wave.period - 1.0).abs() < 0.02));
        let statistics = statistics(&found).unwrap();
        assert!((statistics.significant_height - 0.2).abs() < 0.003, "{statistics:?}");
        assert!((statistics.mean_height - 0.15).abs() < 0.006, "{statistics:?}");
        assert!((statistics.mean_period - 1.0).abs() < 1e-3, "{statistics:?}");
        // Without a threshold the noise makes waves of its own.
        assert!(waves(&times, &values, 0.3, 0.0).len() > found.len());
    }

    #[test]
    fn heights_in_a_sea_are_nearly_rayleigh_distributed() {
        let water = StillWater { depth: 0.6, gravity: 9.81 };
        let form = SpectrumForm::Jonswap { peak_enhancement: 3.3 };
        let spectrum = Spectrum::new(form, 0.06, 1.4, 3.0).unwrap();
        let sea = irregular_sea(water, &spectrum, 400, 11).unwrap();
        let times: Vec<f64> = (0..50_000).map(|i| f64::from(i) * 0.04).collect();
        let values: Vec<f64> = times.iter().map(|t| sea.elevation(0.0, *t)).collect();
        let statistics = statistics(&waves(&times, &values, 0.0, 0.0)).unwrap();
        // H_1/3 is 0.92 to 0.96 of 4 √m0 and the mean height 0.63 of it (Goda 2010, ch. 2).
        let ratio = statistics.significant_height / 0.06;
        assert!((0.91..0.98).contains(&ratio), "{statistics:?}");
        let ratio = statistics.mean_height / statistics.significant_height;
        assert!((ratio - 0.63).abs() < 0.03, "{statistics:?}");
    }

    #[test]
    fn no_waves() {
        assert_eq!(statistics(&[]), None);
        assert!(waves(&[0.0, 1.0], &[1.0, 1.0], 0.0, 0.0).is_empty());
        assert!(waves(&[], &[], 0.0, 0.0).is_empty());
    }
}
