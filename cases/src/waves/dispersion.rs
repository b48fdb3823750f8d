//! Linear dispersion, ω² = g k tanh(k D), and the ratios of hyperbolic functions that all
//! theories share, written so that deep water does not overflow.

use super::StillWater;

impl StillWater {
    /// Angular frequency (rad/s) of a linear wave of wave number `wave_number` (1/m).
    #[must_use]
    pub fn angular_frequency(&self, wave_number: f64) -> f64 {
        (self.gravity * wave_number * (wave_number * self.depth).tanh()).sqrt()
    }

    /// Wave number (1/m) of a linear wave of angular frequency `frequency` (rad/s), at least 0.
    #[must_use]
    pub fn wave_number(&self, frequency: f64) -> f64 {
        let deep = frequency * frequency * self.depth / self.gravity;
        if deep == 0.0 {
            return 0.0;
        }
        // Newton on x tanh x = deep, which is convex above its root: from the greater of the
        // deep- and shallow-water roots it falls monotonically.
        let mut x = deep.max(deep.sqrt());
        for _ in 0..50 {
            let tanh = x.tanh();
            let change = (x * tanh - deep) / (tanh + x * (1.0 - tanh * tanh));
            x -= change;
            if change.abs() <= 1e-15 * x {
                break;
            }
        }
        x / self.depth
    }

    /// Group velocity (m/s) of a linear wave of wave number `wave_number` (1/m).
    #[must_use]
    pub fn group_velocity(&self, wave_number: f64) -> f64 {
        let kd = wave_number * self.depth;
        let ratio = if kd > 300.0 { 0.0 } else { 2.0 * kd / (2.0 * kd).sinh() };
        0.5 * self.angular_frequency(wave_number) / wave_number * (1.0 + ratio)
    }
}

/// cosh(a) / cosh(b).
pub(crate) fn cosh_over_cosh(a: f64, b: f64) -> f64 {
    ((a - b).exp() + (-a - b).exp()) / (1.0 + (-2.0 * b).exp())
}

/// sinh(a) / cosh(b).
pub(crate) fn sinh_over_cosh(a: f64, b: f64) -> f64 {
    ((a - b).exp() - (-a - b).exp()) / (1.0 + (-2.0 * b).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dispersion_relation_holds_from_shallow_to_deep() {
        let water = StillWater { depth: 0.4, gravity: 9.81 };
        for period in [0.1, 0.3, 0.8, 1.2, 3.0, 20.0, 500.0] {
            let omega = std::f64::consts::TAU / period;
            let k = water.wave_number(omega);
            assert!((water.angular_frequency(k) / omega - 1.0).abs() < 1e-13, "T = {period}");
            let step = 1e-5 * k;
            let slope = (water.angular_frequency(k + step) - water.angular_frequency(k - step))
                / (2.0 * step);
            assert!((water.group_velocity(k) / slope - 1.0).abs() < 1e-8, "T = {period}");
        }
        assert_eq!(water.wave_number(0.0), 0.0);
    }

    #[test]
    fn limits_of_deep_and_shallow_water() {
        let water = StillWater { depth: 10.0, gravity: 9.81 };
        let deep = water.wave_number(20.0);
        assert!((deep - 400.0 / 9.81).abs() < 1e-10);
        let shallow = water.wave_number(1e-4);
        assert!((1e-4 / shallow / water.long_wave_speed() - 1.0).abs() < 1e-8);
    }

    #[test]
    fn ratios_do_not_overflow() {
        assert!((cosh_over_cosh(1.2, 0.7) - 1.2f64.cosh() / 0.7f64.cosh()).abs() < 1e-15);
        assert!((sinh_over_cosh(1.2, 0.7) - 1.2f64.sinh() / 0.7f64.cosh()).abs() < 1e-15);
        assert!((cosh_over_cosh(1e4 - 1.0, 1e4) - (-1f64).exp()).abs() < 1e-12);
    }
}
