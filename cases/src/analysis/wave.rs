//! Linear waves, and how a standing wave keeps its period and amplitude.

use super::signal::{crossings, first_harmonic, period};
use std::f64::consts::{PI, TAU};

/// Period (s) of a linear wave of wave number `wave_number` (1/m) on water of depth `depth` (m):
/// ω² = g k tanh(k D).
#[must_use]
pub fn linear_period(wave_number: f64, depth: f64, gravity: f64) -> f64 {
    TAU / (gravity * wave_number * (wave_number * depth).tanh()).sqrt()
}

/// Wave number k = π n / L (1/m) of a standing wave of `half_waves` in a tank of `length` (m).
#[must_use]
pub fn standing_wave_number(half_waves: u32, length: f64) -> f64 {
    PI * f64::from(half_waves) / length
}

/// What became of a standing wave at one gauge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandingWave {
    /// Period from zero crossings, s.
    pub period: f64,
    /// Periods in the record.
    pub periods: f64,
    /// First-harmonic amplitude over the first two periods, m.
    pub first_amplitude: f64,
    /// First-harmonic amplitude over the last two periods, m.
    pub last_amplitude: f64,
}

impl StandingWave {
    /// Amplitude lost from the first to the last two periods, as a fraction.
    #[must_use]
    pub fn amplitude_loss(&self) -> f64 {
        1.0 - self.last_amplitude / self.first_amplitude
    }
}

/// The standing wave in an elevation series; `None` with less than four periods.
#[must_use]
pub fn standing_wave(times: &[f64], elevation: &[f64]) -> Option<StandingWave> {
    let period = period(&crossings(times, elevation, 0.0))?;
    let (start, end) = (*times.first()?, *times.last()?);
    let periods = (end - start) / period;
    if periods < 4.0 {
        return None;
    }
    let span = 2.0 * period;
    Some(StandingWave {
        period,
        periods,
        first_amplitude: first_harmonic(times, elevation, period, (start, start + span))?,
        last_amplitude: first_harmonic(times, elevation, period, (end - span, end))?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dispersion_in_deep_and_shallow_water() {
        let shallow = linear_period(0.01, 0.1, 9.81);
        assert!((shallow - TAU / (0.01 * (0.981f64).sqrt())).abs() / shallow < 1e-6);
        let deep = linear_period(10.0, 10.0, 9.81);
        assert!((deep - TAU / 98.1f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn a_wave_that_loses_a_tenth() {
        let k = standing_wave_number(2, 2.0);
        let exact = linear_period(k, 0.5, 9.81);
        let times: Vec<f64> = (0..2370).map(|i| f64::from(i) * 0.01).collect();
        let rate = -(0.9f64.ln()) / 20.0 / exact;
        let values: Vec<f64> =
            times.iter().map(|t| -0.02 * (-rate * t).exp() * (TAU * t / exact).cos()).collect();
        let found = standing_wave(&times, &values).unwrap();
        assert!((found.period / exact - 1.0).abs() < 1e-4);
        assert!((found.amplitude_loss() - 0.0905).abs() < 2e-3, "{}", found.amplitude_loss());
    }
}
