//! Linear (Airy) waves, alone or superposed: η = Σ a cos(k x − ω t + φ).

use super::dispersion::{cosh_over_cosh, sinh_over_cosh};
use super::{StillWater, WaveError, WaveTheory, require_positive};
use nalgebra::Vector2;
use std::f64::consts::TAU;

/// One component of a linear wave field.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Component {
    /// Amplitude a, m.
    pub amplitude: f64,
    /// Angular frequency ω, rad/s.
    pub frequency: f64,
    /// Wave number k, 1/m.
    pub wave_number: f64,
    /// Phase φ, rad.
    pub phase: f64,
}

impl Component {
    /// The component of `amplitude` (m), `frequency` (rad/s) and `phase` (rad) with the wave
    /// number that the water gives it.
    #[must_use]
    pub fn in_water(water: StillWater, amplitude: f64, frequency: f64, phase: f64) -> Self {
        Self { amplitude, frequency, wave_number: water.wave_number(frequency), phase }
    }

    /// The one component of a regular wave of `height` (m) and `period` (s) with a crest at
    /// x = 0, t = 0.
    ///
    /// # Errors
    /// Parameters that are not positive; a height above the limit of Miche (1944),
    /// 0.142 L tanh(k D).
    pub fn regular(water: StillWater, height: f64, period: f64) -> Result<Self, WaveError> {
        require_positive("wave height (m)", height)?;
        require_positive("wave period (s)", period)?;
        water.validate()?;
        let wave = Self::in_water(water, 0.5 * height, TAU / period, 0.0);
        let length = TAU / wave.wave_number;
        let limit = 0.142 * length * (wave.wave_number * water.depth).tanh();
        if height > limit {
            let (length, depth) = (Some(length), water.depth);
            return Err(WaveError::Breaking { height, limit, length, depth });
        }
        Ok(wave)
    }

    fn angle(&self, x: f64, time: f64) -> f64 {
        self.wave_number * x - self.frequency * time + self.phase
    }
}

/// A sum of linear waves. Between still water and a crest the velocity is extrapolated linearly
/// from still water: exponential growth there would let the shortest components rule.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearWaves {
    water: StillWater,
    components: Vec<Component>,
}

impl LinearWaves {
    /// A superposition.
    ///
    /// # Errors
    /// Water without depth or gravity.
    pub fn new(water: StillWater, components: Vec<Component>) -> Result<Self, WaveError> {
        water.validate()?;
        Ok(Self { water, components })
    }

    /// One regular wave with a crest at x = 0, t = 0.
    ///
    /// # Errors
    /// As [`Component::regular`].
    pub fn regular(water: StillWater, height: f64, period: f64) -> Result<Self, WaveError> {
        Self::new(water, vec![Component::regular(water, height, period)?])
    }

    /// The components.
    #[must_use]
    pub fn components(&self) -> &[Component] {
        &self.components
    }

    /// The one component of a regular wave.
    fn only(&self) -> Option<&Component> {
        match self.components.as_slice() {
            [component] => Some(component),
            _ => None,
        }
    }
}

impl WaveTheory for LinearWaves {
    fn elevation(&self, x: f64, time: f64) -> f64 {
        self.components.iter().map(|c| c.amplitude * c.angle(x, time).cos()).sum()
    }

    fn velocity(&self, x: f64, y: f64, time: f64) -> Vector2<f64> {
        let depth = self.water.depth;
        let (within, above) = (y.min(depth), (y - depth).max(0.0));
        self.components.iter().fold(Vector2::zeros(), |sum, c| {
            let k = c.wave_number;
            let (sin, cos) = c.angle(x, time).sin_cos();
            // a ω / sinh(k D) = (a g k / ω) / cosh(k D).
            let scale = c.amplitude * self.water.gravity * k / c.frequency;
            let tanh = (k * depth).tanh();
            let along = cosh_over_cosh(k * within, k * depth) + above * k * tanh;
            let up = sinh_over_cosh(k * within, k * depth) + above * k;
            sum + scale * Vector2::new(along * cos, up * sin)
        })
    }

    fn celerity(&self) -> Option<f64> {
        self.only().map(|c| c.frequency / c.wave_number)
    }

    fn wavelength(&self) -> Option<f64> {
        self.only().map(|c| TAU / c.wave_number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::tests::{assert_potential_flow, surface_residual};

    const WATER: StillWater = StillWater { depth: 0.4, gravity: 9.81 };

    #[test]
    fn potential_flow_with_the_kinematics_of_its_surface() {
        let wave = LinearWaves::regular(WATER, 0.06, 1.2).unwrap();
        assert_potential_flow(&wave, 0.4, 0.3, 0.2);
        // Vertical velocity at still water is ∂η/∂t.
        let rate = (wave.elevation(0.3, 0.2 + 1e-5) - wave.elevation(0.3, 0.2 - 1e-5)) / 2e-5;
        assert!((wave.velocity(0.3, 0.4, 0.2).y - rate).abs() < 1e-8);
        assert!((wave.wavelength().unwrap() - 1.936_248).abs() < 1e-6);
        assert!((wave.celerity().unwrap() - 1.613_54).abs() < 1e-5);
    }

    #[test]
    fn surface_condition_holds_to_second_order() {
        let residual = |height: f64| {
            surface_residual(&LinearWaves::regular(WATER, height, 1.2).unwrap(), 0.4, 0.3, 0.2)
        };
        let order = (residual(0.02) / residual(0.01)).log2();
        assert!((order - 2.0).abs() < 0.1, "order {order}");
    }

    #[test]
    fn a_wave_that_breaks_is_refused() {
        let error = LinearWaves::regular(WATER, 0.3, 1.2).unwrap_err();
        assert!(matches!(error, WaveError::Breaking { limit, .. } if (limit - 0.237).abs() < 1e-3));
    }
}
