//! Focused wave groups: linear waves whose crests meet at one place and time.

use super::linear::{Component, LinearWaves};
use super::spectrum::Spectrum;
use super::{StillWater, WaveError, require, require_positive};
use std::f64::consts::TAU;

/// How the amplitude of a group is shared out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GroupForm {
    /// NewWave (Tromans et al. 1991): in proportion to a spectrum, the most probable shape of the
    /// highest crest in its sea.
    NewWave(Spectrum),
    /// Every component as steep as the others (a ∝ 1/k) between two frequencies, Hz.
    EqualSteepness {
        /// Lowest frequency, Hz.
        lowest: f64,
        /// Highest frequency, Hz.
        highest: f64,
    },
}

/// Where and how high the crests meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Focus {
    /// Place, m.
    pub x: f64,
    /// Time, s.
    pub time: f64,
    /// Crest elevation to first order, m.
    pub amplitude: f64,
}

/// A group of `count` components (10 to 10 000) at equal intervals of frequency. It comes again
/// after count/(highest − lowest) seconds: see [`repeat_period`].
///
/// # Errors
/// Parameters out of range.
pub fn focused_group(
    water: StillWater,
    form: GroupForm,
    focus: Focus,
    count: usize,
) -> Result<LinearWaves, WaveError> {
    water.validate()?;
    require_positive("amplitude at the focus (m)", focus.amplitude)?;
    require(focus.x.is_finite(), "place of the focus (m)", focus.x, "a finite number")?;
    require(focus.time.is_finite(), "time of the focus (s)", focus.time, "a finite number")?;
    let sound = (10..=10_000).contains(&count);
    require(sound, "number of wave components", count as f64, "10 to 10000")?;
    let (low, high) = band(form);
    require_positive("lowest frequency (Hz)", low)?;
    require(high > low, "highest frequency (Hz)", high, "above the lowest")?;
    let width = (high - low) / count as f64;
    let shares: Vec<(f64, f64)> = (0..count)
        .map(|index| {
            let start = low + width * index as f64;
            let frequency = TAU * (start + 0.5 * width);
            let share = match form {
                GroupForm::NewWave(spectrum) => spectrum.energy(start, start + width),
                GroupForm::EqualSteepness { .. } => water.wave_number(frequency).recip(),
            };
            (frequency, share)
        })
        .collect();
    let total: f64 = shares.iter().map(|(_, share)| share).sum();
    let components = shares
        .into_iter()
        .map(|(frequency, share)| {
            let wave = Component::in_water(water, focus.amplitude * share / total, frequency, 0.0);
            let phase = frequency * focus.time - wave.wave_number * focus.x;
            Component { phase, ..wave }
        })
        .collect();
    LinearWaves::new(water, components)
}

/// Lowest and highest frequency of a group, Hz.
fn band(form: GroupForm) -> (f64, f64) {
    match form {
        GroupForm::NewWave(spectrum) => spectrum.band(),
        GroupForm::EqualSteepness { lowest, highest } => (lowest, highest),
    }
}

/// Time (s) after which a group of `count` components comes again.
#[must_use]
pub fn repeat_period(form: GroupForm, count: usize) -> f64 {
    let (low, high) = band(form);
    count as f64 / (high - low)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::WaveTheory;
    use crate::waves::spectrum::SpectrumForm;

    const WATER: StillWater = StillWater { depth: 0.6, gravity: 9.81 };
    const FOCUS: Focus = Focus { x: 4.0, time: 12.0, amplitude: 0.05 };

    #[test]
    fn crests_meet_at_the_focus_and_nowhere_else() {
        let spectrum = Spectrum::new(SpectrumForm::PiersonMoskowitz, 0.05, 1.4, 3.0).unwrap();
        let steep = GroupForm::EqualSteepness { lowest: 0.4, highest: 1.2 };
        for form in [GroupForm::NewWave(spectrum), steep] {
            let group = focused_group(WATER, form, FOCUS, 100).unwrap();
            assert!((group.elevation(4.0, 12.0) - 0.05).abs() < 1e-12);
            for i in 0..2400 {
                let time = f64::from(i) * 0.01;
                assert!(group.elevation(4.0, time) <= 0.05 + 1e-12);
                if (time - 12.0).abs() > 5.0 {
                    assert!(group.elevation(4.0, time).abs() < 0.02, "t = {time}");
                }
            }
            let again = 12.0 + repeat_period(form, 100);
            let (low, high) = band(form);
            // It comes again with the phase of the middle of the lowest interval.
            let shift = TAU * (low + 0.5 * (high - low) / 100.0) * (again - 12.0);
            assert!((group.elevation(4.0, again) - 0.05 * shift.cos()).abs() < 1e-9);
        }
    }

    #[test]
    fn new_wave_is_the_autocorrelation_of_its_sea() {
        let form = SpectrumForm::Jonswap { peak_enhancement: 3.3 };
        let spectrum = Spectrum::new(form, 0.08, 1.4, 3.0).unwrap();
        let group = focused_group(WATER, GroupForm::NewWave(spectrum), FOCUS, 400).unwrap();
        let (low, high) = spectrum.band();
        let lag = 0.9;
        let correlation: f64 = (0..20_000)
            .map(|i| low + (high - low) * (f64::from(i) + 0.5) / 2e4)
            .map(|f| spectrum.density(f) * (TAU * f * lag).cos() * (high - low) / 2e4)
            .sum();
        let expected = 0.05 * correlation / 0.02f64.powi(2);
        assert!((group.elevation(4.0, 12.9) - expected).abs() < 1e-5);
    }
}
