//! The spectrum of a record, by Welch's (1967) method.

use realfft::RealFftPlanner;
use std::f64::consts::PI;

/// A one-sided spectrum at equal intervals of frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordSpectrum {
    /// Interval between frequencies, Hz; the first is 0.
    pub resolution: f64,
    /// Density, unit² / Hz.
    pub density: Vec<f64>,
}

impl RecordSpectrum {
    /// Frequencies, Hz.
    pub fn frequencies(&self) -> impl Iterator<Item = f64> {
        (0..self.density.len()).map(|index| self.resolution * index as f64)
    }

    /// ∫ fⁿ S df over the frequencies of `band` (Hz).
    #[must_use]
    pub fn moment(&self, order: i32, band: (f64, f64)) -> f64 {
        self.frequencies()
            .zip(&self.density)
            .filter(|(f, _)| *f >= band.0 && *f <= band.1)
            .map(|(f, density)| f.powi(order) * density * self.resolution)
            .sum()
    }

    /// 4 √m₀ over `band` (Hz): the significant height of an elevation.
    #[must_use]
    pub fn significant_height(&self, band: (f64, f64)) -> f64 {
        4.0 * self.moment(0, band).sqrt()
    }

    /// Frequency of the highest density, Hz, by a parabola through the three highest values.
    #[must_use]
    pub fn peak_frequency(&self) -> Option<f64> {
        let last = self.density.len().checked_sub(1)?;
        let peak = (1..last).max_by(|a, b| self.density[*a].total_cmp(&self.density[*b]))?;
        let [before, at, after] = [-1, 0, 1].map(|n| self.density[peak.wrapping_add_signed(n)]);
        let curvature = before - 2.0 * at + after;
        let offset = if curvature < 0.0 { 0.5 * (before - after) / curvature } else { 0.0 };
        Some(self.resolution * (peak as f64 + offset))
    }
}

/// The spectrum of `values` sampled every `interval` (s), averaged over segments of `length`
/// samples that overlap by half, each less its mean and under a Hann window. `None` when the
/// record is shorter than a segment or a segment than 8 samples.
#[must_use]
pub fn welch(interval: f64, values: &[f64], length: usize) -> Option<RecordSpectrum> {
    if length < 8 || values.len() < length {
        return None;
    }
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(length);
    let window: Vec<f64> =
        (0..length).map(|i| (PI * (i as f64 + 0.5) / length as f64).sin().powi(2)).collect();
    let power: f64 = window.iter().map(|w| w * w).sum();
    let mut density = vec![0.0; length / 2 + 1];
    let mut output = transform.make_output_vec();
    let mut segments = 0u32;
    for start in (0..=values.len() - length).step_by(length / 2) {
        let segment = &values[start..start + length];
        let mean = segment.iter().sum::<f64>() / length as f64;
        let mut input: Vec<f64> =
            segment.iter().zip(&window).map(|(value, w)| (value - mean) * w).collect();
        transform.process(&mut input, &mut output).ok()?;
        for (sum, amplitude) in density.iter_mut().zip(&output) {
            *sum += amplitude.norm_sqr();
        }
        segments += 1;
    }
    let scale = 2.0 * interval / (power * f64::from(segments));
    let last = density.len() - 1;
    for (index, value) in density.iter_mut().enumerate() {
        // No energy of negative frequencies is folded onto the ends.
        let ends = index == 0 || (index == last && length.is_multiple_of(2));
        *value *= if ends { 0.5 * scale } else { scale };
    }
    Some(RecordSpectrum { resolution: 1.0 / (interval * length as f64), density })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::irregular::irregular_sea;
    use crate::waves::spectrum::{Spectrum, SpectrumForm};
    use crate::waves::{StillWater, WaveTheory};
    use std::f64::consts::TAU;

    #[test]
    fn energy_and_place_of_a_sine() {
        let values: Vec<f64> =
            (0..8192).map(|i| 3.0 + 0.5 * (TAU * 0.83 * f64::from(i) * 0.02).sin()).collect();
        let found = welch(0.02, &values, 1024).unwrap();
        assert!((found.moment(0, (0.0, 25.0)) - 0.125).abs() < 1e-3);
        assert!((found.peak_frequency().unwrap() - 0.83).abs() < 0.005);
        assert_eq!(welch(0.02, &values[..100], 1024), None);
    }

    #[test]
    fn spectrum_of_a_sea_is_that_it_was_made_of() {
        let water = StillWater { depth: 0.6, gravity: 9.81 };
        let form = SpectrumForm::Jonswap { peak_enhancement: 3.3 };
        let spectrum = Spectrum::new(form, 0.06, 1.4, 3.0).unwrap();
        let sea = irregular_sea(water, &spectrum, 500, 11).unwrap();
        let values: Vec<f64> =
            (0..40_000).map(|i| sea.elevation(0.0, f64::from(i) * 0.1)).collect();
        let found = welch(0.1, &values, 512).unwrap();
        let height = found.significant_height((0.0, 5.0));
        assert!((height / 0.06 - 1.0).abs() < 0.01, "{height}");
        assert!((found.peak_frequency().unwrap() * 1.4 - 1.0).abs() < 0.03);
        let (mut difference, mut size) = (0.0, 0.0);
        for (f, density) in found.frequencies().zip(&found.density) {
            difference += (density - spectrum.density(f)).abs();
            size += spectrum.density(f);
        }
        assert!(difference / size < 0.1, "{}", difference / size);
    }
}
