//! Second-order Stokes waves.
//!
//! η = (H/2) cos θ + (H² k / 16) (cosh kD (2 + cosh 2kD) / sinh³ kD) cos 2θ with θ = k x − ω t and
//! the linear wave number, as in Dean & Dalrymple (1984), section 11.3. The mean Eulerian velocity
//! is zero, so that such a wave carries mass; the correction of celerity comes at third order.

use super::dispersion::{cosh_over_cosh, sinh_over_cosh};
use super::linear::Component;
use super::{StillWater, WaveError, WaveTheory};
use nalgebra::Vector2;
use std::f64::consts::TAU;

/// A second-order Stokes wave with a crest at x = 0, t = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct StokesWave {
    water: StillWater,
    amplitude: f64,
    frequency: f64,
    wave_number: f64,
    /// Amplitude of the second harmonic of the elevation, m.
    second_amplitude: f64,
}

impl StokesWave {
    /// The wave of `height` (m) and `period` (s).
    ///
    /// # Errors
    /// Parameters that are not positive; a wave that breaks; a second harmonic so large that the
    /// trough has a crest of its own (a quarter of the first: the expansion has failed).
    pub fn new(water: StillWater, height: f64, period: f64) -> Result<Self, WaveError> {
        let wave = Component::regular(water, height, period)?;
        let (amplitude, k) = (wave.amplitude, wave.wave_number);
        let tanh = (k * water.depth).tanh();
        // cosh (2 + cosh 2x) / sinh³ = (3 − tanh²) / tanh³.
        let second_amplitude =
            0.25 * amplitude * amplitude * k * (3.0 - tanh * tanh) / tanh.powi(3);
        let limit = height * 0.25 * amplitude / second_amplitude;
        super::require(
            height <= limit,
            "wave height (m)",
            height,
            &format!("at most {limit:.4} for second-order Stokes theory in water so shallow"),
        )?;
        Ok(Self { water, amplitude, frequency: wave.frequency, wave_number: k, second_amplitude })
    }

    /// Angular frequency ω, rad/s.
    #[must_use]
    pub fn frequency(&self) -> f64 {
        self.frequency
    }

    /// Height H, m.
    #[must_use]
    pub fn height(&self) -> f64 {
        2.0 * self.amplitude
    }
}

impl WaveTheory for StokesWave {
    fn elevation(&self, x: f64, time: f64) -> f64 {
        let angle = self.wave_number * x - self.frequency * time;
        self.amplitude * angle.cos() + self.second_amplitude * (2.0 * angle).cos()
    }

    fn velocity(&self, x: f64, y: f64, time: f64) -> Vector2<f64> {
        let (k, kd) = (self.wave_number, self.wave_number * self.water.depth);
        let angle = k * x - self.frequency * time;
        let (sin, cos) = angle.sin_cos();
        let (sin2, cos2) = (2.0 * angle).sin_cos();
        let first = self.amplitude * self.frequency / kd.tanh();
        // (3/4) a² ω k cosh 2ky / sinh⁴ kD, written with s = 1 / sinh² kD.
        let s = 1.0 / kd.tanh().powi(2) - 1.0;
        let second = 0.75 * self.amplitude.powi(2) * self.frequency * k * s * (s + 2.0);
        Vector2::new(
            first * cosh_over_cosh(k * y, kd) * cos
                + second * cosh_over_cosh(2.0 * k * y, 2.0 * kd) * cos2,
            first * sinh_over_cosh(k * y, kd) * sin
                + second * sinh_over_cosh(2.0 * k * y, 2.0 * kd) * sin2,
        )
    }

    fn celerity(&self) -> Option<f64> {
        Some(self.frequency / self.wave_number)
    }

    fn wavelength(&self) -> Option<f64> {
        Some(TAU / self.wave_number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::tests::{assert_potential_flow, raschii, surface_residual};

    const WATER: StillWater = StillWater { depth: 0.4, gravity: 9.81 };

    #[test]
    fn potential_flow_whose_surface_condition_holds_to_third_order() {
        let wave = StokesWave::new(WATER, 0.06, 1.2).unwrap();
        assert_potential_flow(&wave, 0.4, 0.3, 0.2);
        let residual =
            |height| surface_residual(&StokesWave::new(WATER, height, 1.2).unwrap(), 0.4, 0.3, 0.2);
        let order = (residual(0.02) / residual(0.01)).log2();
        assert!((order - 3.0).abs() < 0.15, "order {order}");
    }

    #[test]
    fn crest_and_trough_of_the_independent_calculation() {
        // Crest and trough of three waves, from an independent second-order calculation.
        for (depth, height, period, crest, trough) in [
            (0.4, 0.06, 1.2, 0.03258, -0.02742),
            (0.4, 0.04, 1.2, 0.02115, -0.01885),
            (0.7, 0.10, 1.0, 0.05521, -0.04479),
        ] {
            let wave =
                StokesWave::new(StillWater { depth, gravity: 9.81 }, height, period).unwrap();
            assert!((wave.elevation(0.0, 0.0) - crest).abs() < 1e-5);
            assert!((wave.elevation(0.0, 0.5 * period) - trough).abs() < 1e-5);
        }
    }

    #[test]
    fn elevation_of_raschii() {
        // raschii adds the third-order celerity: the comparison is at one wavelength.
        for wave in raschii("Stokes") {
            let period = TAU / wave.water().angular_frequency(TAU / wave.length);
            let found = StokesWave::new(wave.water(), wave.height, period).unwrap();
            for point in &wave.points {
                let error = found.elevation(point.x, 0.0) - point.elevation;
                assert!(error.abs() < 1e-6 * wave.height, "{error} at {}", point.x);
            }
        }
    }

    #[test]
    fn too_shallow_for_the_expansion() {
        let shallow = StillWater { depth: 0.1, gravity: 9.81 };
        let error = StokesWave::new(shallow, 0.05, 3.0).unwrap_err();
        assert!(error.to_string().contains("shallow"), "{error}");
    }
}
