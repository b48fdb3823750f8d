//! Incident and reflected waves from the elevation at two or more gauges.
//!
//! At one frequency η = Re (A_I exp(i k x) + A_R exp(−i k x)) exp(−i ω t). Two gauges give both
//! amplitudes (Goda & Suzuki 1976), more give them by least squares (Mansard & Funke 1980): the
//! same equations.

use super::harmonics::harmonics;
use crate::waves::StillWater;
use nalgebra::Complex;
use realfft::RealFftPlanner;
use std::f64::consts::{PI, TAU};

/// sin² (k Δx) below which two gauges are too near a whole number of half wavelengths apart:
/// that of 0.05 wavelengths, the limit of Goda and Suzuki.
const SMALLEST_SEPARATION: f64 = 0.095;

/// Waves in both directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reflection {
    /// A_I, m.
    pub incident: Complex<f64>,
    /// A_R, m.
    pub reflected: Complex<f64>,
}

impl Reflection {
    /// |A_R| / |A_I|.
    #[must_use]
    pub fn coefficient(&self) -> f64 {
        self.reflected.norm() / self.incident.norm()
    }
}

/// The waves of wave number `wave_number` (1/m) from the complex amplitudes at gauges, `x` (m) and
/// A (m) with η = Re A exp(−i ω t). `None` for fewer than two gauges, and for gauges whose
/// distances are too near to whole numbers of half wavelengths.
#[must_use]
pub fn separate(wave_number: f64, gauges: &[(f64, Complex<f64>)]) -> Option<Reflection> {
    let count = gauges.len() as f64;
    let zero = Complex::new(0.0, 0.0);
    let (mut cross, mut along, mut against) = (zero, zero, zero);
    for (x, amplitude) in gauges {
        let turn = Complex::from_polar(1.0, wave_number * x);
        cross += turn * turn;
        along += amplitude * turn.conj();
        against += amplitude * turn;
    }
    // | n   s̄ | |A_I|   |Σ A e⁻|
    // | s   n | |A_R| = |Σ A e⁺|   with s = Σ exp(2 i k x).
    let determinant = count * count - cross.norm_sqr();
    if determinant < SMALLEST_SEPARATION * count * count {
        return None;
    }
    Some(Reflection {
        incident: (along * count - cross.conj() * against) / determinant,
        reflected: (against * count - cross * along) / determinant,
    })
}

/// The reflection of a regular wave of `frequency` (rad/s) and `wave_number` (1/m) from records
/// at gauges at `x` (m), all sampled at `times` (s).
#[must_use]
pub fn regular(
    times: &[f64],
    gauges: &[(f64, &[f64])],
    frequency: f64,
    wave_number: f64,
) -> Option<Reflection> {
    let amplitudes = gauges.iter().map(|(x, values)| {
        let found = harmonics(times, values, frequency, 3)?;
        Some((*x, *found.amplitudes.first()?))
    });
    separate(wave_number, &amplitudes.collect::<Option<Vec<_>>>()?)
}

/// Reflection of an irregular sea.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SeaReflection {
    /// √(energy reflected / energy incident).
    pub coefficient: f64,
    /// Significant height of the incident sea within the band, 4 √m₀, m.
    pub incident_height: f64,
    /// Part of the band's energy at frequencies at which the gauges can tell the directions apart.
    pub resolved: f64,
}

/// The reflection of a sea between the frequencies of `band` (Hz) from records of even length
/// sampled every `interval` (s), with linear dispersion. Frequencies at which the gauges cannot
/// tell the directions apart are left out. `None` where nothing remains.
#[must_use]
pub fn irregular(
    water: StillWater,
    interval: f64,
    gauges: &[(f64, &[f64])],
    band: (f64, f64),
) -> Option<SeaReflection> {
    let samples = gauges.iter().map(|(_, values)| values.len()).min()?;
    if samples < 8 {
        return None;
    }
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(samples);
    let mut spectra = Vec::new();
    for (x, values) in gauges {
        let mean = values[..samples].iter().sum::<f64>() / samples as f64;
        let window = |i: usize| (PI * (i as f64 + 0.5) / samples as f64).sin().powi(2);
        let mut input: Vec<f64> =
            values[..samples].iter().enumerate().map(|(i, v)| (v - mean) * window(i)).collect();
        let mut output = transform.make_output_vec();
        transform.process(&mut input, &mut output).ok()?;
        // A Hann window keeps 3/8 of the energy; the transform has exp(−i ω t) in its kernel,
        // so that of Re A exp(−i ω t) is the conjugate of A.
        let scale = 2.0 / samples as f64 / 0.375f64.sqrt();
        let amplitudes: Vec<Complex<f64>> = output.iter().map(|a| a.conj() * scale).collect();
        spectra.push((*x, amplitudes));
    }
    let (mut incident, mut reflected, mut resolved, mut whole) = (0.0, 0.0, 0.0, 0.0);
    for index in 1..samples / 2 {
        let frequency = index as f64 / (samples as f64 * interval);
        if frequency < band.0 || frequency > band.1 {
            continue;
        }
        let at: Vec<(f64, Complex<f64>)> =
            spectra.iter().map(|(x, amplitudes)| (*x, amplitudes[index])).collect();
        let energy: f64 = at.iter().map(|(_, a)| a.norm_sqr()).sum();
        whole += energy;
        if let Some(found) = separate(water.wave_number(TAU * frequency), &at) {
            resolved += energy;
            incident += 0.5 * found.incident.norm_sqr();
            reflected += 0.5 * found.reflected.norm_sqr();
        }
    }
    (incident > 0.0).then(|| SeaReflection {
        coefficient: (reflected / incident).sqrt(),
        incident_height: 4.0 * incident.sqrt(),
        resolved: resolved / whole,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::irregular::irregular_sea;
    use crate::waves::spectrum::{Spectrum, SpectrumForm};

    const WATER: StillWater = StillWater { depth: 0.4, gravity: 9.81 };
    const COEFFICIENT: f64 = 0.13;

    fn noise(i: usize) -> f64 {
        f64::from((i as u32).wrapping_mul(2_654_435_761) >> 16) / 65536.0 - 0.5
    }

    /// Records of a regular wave with a reflection, a bound second harmonic and noise.
    fn records(places: &[f64], size: f64) -> (Vec<f64>, Vec<Vec<f64>>, f64, f64) {
        let (w, k) = (TAU / 1.2, WATER.wave_number(TAU / 1.2));
        let times: Vec<f64> = (0..1300).map(|i| 10.0 + f64::from(i) * 0.01).collect();
        let value = |x: f64, t: f64, i: usize| {
            0.03 * (k * x - w * t + 0.4).cos()
                + COEFFICIENT * 0.03 * (k * x + w * t - 1.3).cos()
                + 0.002 * (2.0 * (k * x - w * t)).cos()
                + size * noise(i)
        };
        let record = |x: &f64| {
            times.iter().enumerate().map(|(i, t)| value(*x, *t, i + (1e4 * x) as usize)).collect()
        };
        let records = places.iter().map(record).collect();
        (times, records, w, k)
    }

    fn found(places: &[f64], size: f64) -> Option<Reflection> {
        let (times, records, w, k) = records(places, size);
        let gauges: Vec<(f64, &[f64])> =
            places.iter().zip(&records).map(|(x, r)| (*x, r.as_slice())).collect();
        regular(&times, &gauges, w, k)
    }

    #[test]
    fn two_gauges_and_three() {
        for places in [&[5.0, 5.4][..], &[5.0, 5.4, 5.9], &[2.0, 2.3, 2.7, 3.9]] {
            let clean = found(places, 0.0).unwrap();
            assert!((clean.coefficient() - COEFFICIENT).abs() < 1e-9, "{places:?}");
            let incident = Complex::from_polar(0.03, 0.4);
            assert!((clean.incident - incident).norm() < 1e-9, "{:?}", clean.incident);
            let noisy = found(places, 0.004).unwrap();
            assert!((noisy.coefficient() - COEFFICIENT).abs() < 0.01, "{}", noisy.coefficient());
        }
    }

    #[test]
    fn gauges_half_a_wavelength_apart_see_nothing() {
        let half = PI / WATER.wave_number(TAU / 1.2);
        assert_eq!(found(&[5.0, 5.0 + half], 0.0), None);
        assert_eq!(found(&[5.0], 0.0), None);
        assert!(found(&[5.0, 5.0 + half, 5.3], 0.0).is_some());
    }

    #[test]
    fn a_sea_that_is_partly_reflected() {
        let form = SpectrumForm::Jonswap { peak_enhancement: 3.3 };
        let spectrum = Spectrum::new(form, 0.04, 1.4, 2.5).unwrap();
        let sea = irregular_sea(WATER, &spectrum, 300, 3).unwrap();
        let times: Vec<f64> = (0..8192).map(|i| f64::from(i) * 0.03).collect();
        let record = |x: f64| -> Vec<f64> {
            let value = |t: f64| {
                sea.components()
                    .iter()
                    .map(|c| {
                        let angle = c.frequency * t - c.phase;
                        c.amplitude * (c.wave_number * x - angle).cos()
                            + COEFFICIENT * c.amplitude * (c.wave_number * (x - 20.0) + angle).cos()
                    })
                    .sum()
            };
            times.iter().map(|t| value(*t)).collect()
        };
        let places = [5.0, 5.35, 5.8];
        let records = places.map(record);
        let gauges: Vec<(f64, &[f64])> =
            places.iter().zip(&records).map(|(x, r)| (*x, r.as_slice())).collect();
        let found = irregular(WATER, 0.03, &gauges, spectrum.band()).unwrap();
        assert!((found.coefficient - COEFFICIENT).abs() < 0.003, "{found:?}");
        assert!((found.incident_height - 0.04).abs() < 0.001, "{found:?}");
        assert!(found.resolved > 0.99, "{found:?}");
    }
}
