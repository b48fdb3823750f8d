//! Irregular seas: a superposition of linear waves with random phases.
//!
//! The band is cut into intervals of equal width. Each has one component, with the energy of the
//! interval and a frequency drawn within it, so that the sea does not repeat itself.

use super::linear::{Component, LinearWaves};
use super::spectrum::Spectrum;
use super::{StillWater, WaveError, require};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::f64::consts::TAU;

/// A sea of `count` components (10 to 10 000) of `spectrum`. The same `seed` gives the same sea on
/// every machine.
///
/// # Errors
/// A number of components out of range; water without depth.
pub fn irregular_sea(
    water: StillWater,
    spectrum: &Spectrum,
    count: usize,
    seed: u64,
) -> Result<LinearWaves, WaveError> {
    let sound = (10..=10_000).contains(&count);
    require(sound, "number of wave components", count as f64, "10 to 10000")?;
    water.validate()?;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (low, high) = spectrum.band();
    let width = (high - low) / count as f64;
    let components = (0..count)
        .map(|index| {
            let start = low + width * index as f64;
            let energy = spectrum.energy(start, start + width);
            let frequency = start + width * uniform(&mut random);
            let phase = TAU * uniform(&mut random);
            Component::in_water(water, (2.0 * energy).sqrt(), TAU * frequency, phase)
        })
        .collect();
    LinearWaves::new(water, components)
}

/// A number from 0 to 1, 1 excluded: the 53 highest bits.
fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::WaveTheory;
    use crate::waves::spectrum::SpectrumForm;

    const WATER: StillWater = StillWater { depth: 0.6, gravity: 9.81 };

    fn sea(seed: u64) -> LinearWaves {
        let form = SpectrumForm::Jonswap { peak_enhancement: 3.3 };
        let spectrum = Spectrum::new(form, 0.06, 1.4, 3.0).unwrap();
        irregular_sea(WATER, &spectrum, 200, seed).unwrap()
    }

    #[test]
    fn a_long_record_has_the_significant_height() {
        let sea = sea(7);
        let times: Vec<f64> = (0..60_000).map(|i| f64::from(i) * 0.05).collect();
        let mean_square =
            times.iter().map(|t| sea.elevation(2.0, *t).powi(2)).sum::<f64>() / 60_000.0;
        let height = 4.0 * mean_square.sqrt();
        assert!((height / 0.06 - 1.0).abs() < 0.01, "{height}");
        let m0: f64 = sea.components().iter().map(|c| 0.5 * c.amplitude.powi(2)).sum();
        assert!((4.0 * m0.sqrt() - 0.06).abs() < 1e-6);
    }

    #[test]
    fn the_seed_makes_the_sea() {
        assert_eq!(sea(3), sea(3));
        assert_ne!(sea(3), sea(4));
    }

    /// A regression test: the generator's stream is part of what a case file means.
    #[test]
    fn the_stream_of_a_seed_stays_what_it_was() {
        let mut random = ChaCha8Rng::seed_from_u64(0);
        assert_eq!(random.next_u64(), 13_080_132_717_333_068_652);
    }

    #[test]
    fn the_sea_does_not_repeat_itself() {
        let sea = sea(5);
        // Components at equal intervals would repeat with the inverse of the interval.
        let (low, high) = (0.5 / 1.4, 3.0 / 1.4);
        let period = 200.0 / (high - low);
        let difference: f64 = (0..400)
            .map(|i| f64::from(i) * 0.2)
            .map(|t| (sea.elevation(0.0, t) - sea.elevation(0.0, t + period)).powi(2))
            .sum::<f64>();
        assert!((difference / 400.0).sqrt() > 0.5 * 0.06 / 4.0);
    }
}
