//! Stream-function waves: steady waves of any height short of breaking, to any order.
//!
//! Rienecker & Fenton (1981), Fenton (1988). In the frame that moves with the wave,
//! ψ = −Ū y + Σ B_j sinh(j k y)/cosh(j k D) cos(j k x), with ψ = −Q and Bernoulli's constant R on
//! the surface at N + 1 places between crest and trough. What fixes the celerity is either the
//! mean Eulerian velocity (c = Ū + u_E) or the mean mass transport (c = Q/D + u_S); a closed flume
//! has u_S = 0.

mod solve;

use super::dispersion::{cosh_over_cosh, sinh_over_cosh};
use super::{StillWater, WaveError, WaveTheory, require, require_positive};
use nalgebra::Vector2;
use solve::{Problem, Solution};
use std::f64::consts::{PI, TAU};

/// What is known of the length of a wave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// The period, s.
    Period(f64),
    /// The wavelength, m.
    Wavelength(f64),
}

/// What is known of the mean flow, m/s along the waves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Current {
    /// Mean velocity u_E at a fixed place below the troughs.
    Eulerian(f64),
    /// Mean mass transport velocity u_S, over the depth; 0 in a closed flume.
    MassTransport(f64),
}

/// A stream-function wave with a crest at x = 0, t = 0.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamFunctionWave {
    water: StillWater,
    /// Wave number k, 1/m.
    wave_number: f64,
    /// Celerity c, m/s.
    celerity: f64,
    /// Mean Eulerian velocity u_E = c − Ū, m/s.
    mean_velocity: f64,
    /// j k B_j, m/s: harmonics of the velocity at still water.
    velocities: Vec<f64>,
    /// Harmonics of the elevation from the first, m.
    elevations: Vec<f64>,
}

/// The highest steady wave (m) of a wavelength: Fenton (1990), a fit to the results of
/// Williams (1981).
#[must_use]
pub fn highest_wave(depth: f64, wavelength: f64) -> f64 {
    let s = wavelength / depth;
    depth * s * (0.141_063 + s * (0.009_572_1 + s * 0.007_782_9))
        / (1.0 + s * (0.078_834_0 + s * (0.031_756_7 + s * 0.009_340_7)))
}

impl StreamFunctionWave {
    /// The wave of `height` (m) with `order` harmonics (5 to 64): 10 do for most waves, long and
    /// high ones need more.
    ///
    /// # Errors
    /// Parameters out of range; a wave above [`highest_wave`]; equations that do not converge.
    pub fn new(
        water: StillWater,
        height: f64,
        extent: Extent,
        current: Current,
        order: usize,
    ) -> Result<Self, WaveError> {
        water.validate()?;
        require_positive("wave height (m)", height)?;
        match extent {
            Extent::Period(period) => require_positive("wave period (s)", period)?,
            Extent::Wavelength(length) => require_positive("wavelength (m)", length)?,
        }
        let (Current::Eulerian(flow) | Current::MassTransport(flow)) = current;
        require(flow.is_finite(), "current (m/s)", flow, "a finite number")?;
        require((5..=64).contains(&order), "order of the theory", order as f64, "5 to 64")?;

        // Lengths in depths, velocities in √(g D).
        let (depth, speed) = (water.depth, water.long_wave_speed());
        let problem = Problem {
            height: height / depth,
            extent: match extent {
                Extent::Period(period) => Extent::Period(period * speed / depth),
                Extent::Wavelength(length) => Extent::Wavelength(length / depth),
            },
            current: match current {
                Current::Eulerian(flow) => Current::Eulerian(flow / speed),
                Current::MassTransport(flow) => Current::MassTransport(flow / speed),
            },
            order,
        };
        let found = problem.solve().map_err(|error| error.in_units(depth))?;
        Ok(Self::from_solution(water, &found))
    }

    fn from_solution(water: StillWater, found: &Solution) -> Self {
        let (depth, speed) = (water.depth, water.long_wave_speed());
        let order = found.coefficients.len();
        let elevations = (1..=order).map(|j| {
            // Discrete cosine transform of the collocation points.
            let sum: f64 = found
                .surface
                .iter()
                .enumerate()
                .map(|(m, y)| {
                    let end = if m == 0 || m == order { 0.5 } else { 1.0 };
                    end * (y - 1.0) * (PI * (j * m) as f64 / order as f64).cos()
                })
                .sum();
            let last = if j == order { 0.5 } else { 1.0 };
            depth * last * 2.0 / order as f64 * sum
        });
        let velocities = found.coefficients.iter().enumerate();
        Self {
            water,
            wave_number: found.wave_number / depth,
            celerity: found.celerity * speed,
            mean_velocity: (found.celerity - found.mean_speed) * speed,
            velocities: velocities
                .map(|(j, b)| (j + 1) as f64 * found.wave_number * b * speed)
                .collect(),
            elevations: elevations.collect(),
        }
    }

    /// Still water.
    #[must_use]
    pub fn water(&self) -> StillWater {
        self.water
    }

    /// Wave number k, 1/m.
    #[must_use]
    pub fn wave_number(&self) -> f64 {
        self.wave_number
    }

    /// Period, s.
    #[must_use]
    pub fn period(&self) -> f64 {
        TAU / (self.wave_number * self.celerity)
    }

    /// Mean Eulerian velocity u_E below the troughs, m/s.
    #[must_use]
    pub fn mean_velocity(&self) -> f64 {
        self.mean_velocity
    }

    /// Amplitudes of the harmonics of the elevation, m, from the first: η = Σ a_j cos jθ.
    #[must_use]
    pub fn harmonics(&self) -> &[f64] {
        &self.elevations
    }

    /// The last harmonic of the elevation relative to the first: what the order leaves out.
    #[must_use]
    pub fn truncation(&self) -> f64 {
        match self.elevations.as_slice() {
            [first, .., last] => (last / first).abs(),
            _ => 0.0,
        }
    }
}

impl WaveTheory for StreamFunctionWave {
    fn elevation(&self, x: f64, time: f64) -> f64 {
        let angle = self.wave_number * (x - self.celerity * time);
        let harmonics = self.elevations.iter().enumerate();
        harmonics.map(|(j, a)| a * ((j + 1) as f64 * angle).cos()).sum()
    }

    fn velocity(&self, x: f64, y: f64, time: f64) -> Vector2<f64> {
        let angle = self.wave_number * (x - self.celerity * time);
        let mut velocity = Vector2::new(self.mean_velocity, 0.0);
        for (j, b) in self.velocities.iter().enumerate() {
            let number = (j + 1) as f64;
            let (sin, cos) = (number * angle).sin_cos();
            let jk = number * self.wave_number;
            let (ky, kd) = (jk * y, jk * self.water.depth);
            velocity.x += b * cosh_over_cosh(ky, kd) * cos;
            velocity.y += b * sinh_over_cosh(ky, kd) * sin;
        }
        velocity
    }

    fn celerity(&self) -> Option<f64> {
        Some(self.celerity)
    }

    fn wavelength(&self) -> Option<f64> {
        Some(TAU / self.wave_number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::quadrature::simpson;
    use crate::waves::tests::{assert_potential_flow, raschii, surface_residual};

    fn closed_flume(depth: f64, height: f64, period: f64, order: usize) -> StreamFunctionWave {
        let water = StillWater { depth, gravity: 9.81 };
        let extent = Extent::Period(period);
        StreamFunctionWave::new(water, height, extent, Current::MassTransport(0.0), order).unwrap()
    }

    #[test]
    fn elevation_and_velocity_of_raschii() {
        for wave in raschii("Fenton") {
            let extent = Extent::Wavelength(wave.length);
            let current = Current::Eulerian(0.0);
            let found =
                StreamFunctionWave::new(wave.water(), wave.height, extent, current, wave.order)
                    .unwrap();
            // raschii stops its iteration at 1e-8 in SI units.
            let (length, speed) = (wave.height, wave.height / wave.period);
            assert!((found.period() / wave.period - 1.0).abs() < 1e-6);
            for point in &wave.points {
                let elevation = found.elevation(point.x, 0.0);
                let velocity = found.velocity(point.x, point.y, 0.0);
                assert!((elevation - point.elevation).abs() < 1e-6 * length, "{elevation}");
                assert!((velocity - point.velocity).norm() < 1e-5 * speed, "{velocity}");
            }
        }
    }

    #[test]
    fn wavelengths_of_the_independent_calculation() {
        // Wavelength without Eulerian velocity, in a closed flume, and there mean velocity.
        for (depth, height, period, eulerian, closed, mean) in [
            (0.4, 0.06, 1.2, 1.95578, 1.94422, -0.00676),
            (0.4, 0.04, 1.2, 1.94495, 1.93975, -0.00302),
            (0.6, 0.046, 1.0, 1.55116, 1.54604, -0.00279),
            (0.7, 0.10, 1.0, 1.60940, 1.58987, -0.01091),
        ] {
            let wave = closed_flume(depth, height, period, 16);
            assert!((wave.wavelength().unwrap() - closed).abs() < 6e-6);
            assert!((wave.mean_velocity() - mean).abs() < 6e-6);
            let (extent, current) = (Extent::Period(period), Current::Eulerian(0.0));
            let wave = StreamFunctionWave::new(wave.water, height, extent, current, 16).unwrap();
            assert!((wave.wavelength().unwrap() - eulerian).abs() < 6e-6);
        }
    }

    #[test]
    fn satisfies_the_equations_between_the_collocation_points() {
        let wave = closed_flume(0.4, 0.12, 1.6, 24);
        assert_potential_flow(&wave, 0.4, 0.3, 0.2);
        for x in [0.05, 0.2, 0.613, 1.3] {
            // The step of the differences leaves 1e-7 m/s.
            assert!(surface_residual(&wave, 0.4, x, 0.1) < 1e-6, "x = {x}");
        }
        assert!(wave.truncation() < 1e-6);
        let height = wave.elevation(0.0, 0.0) - wave.elevation(0.0, 0.5 * wave.period());
        assert!((height - 0.12).abs() < 1e-10, "{height}");
    }

    #[test]
    fn no_mass_transport_in_a_closed_flume() {
        let wave = closed_flume(0.4, 0.1, 1.4, 20);
        // Mean over a period of the flux through x = 0.3.
        let flux = (0..64)
            .map(|n| f64::from(n) / 64.0 * wave.period())
            .map(|t| simpson(0.0, 0.4 + wave.elevation(0.3, t), 60, |y| wave.velocity(0.3, y, t).x))
            .sum::<f64>()
            / 64.0;
        assert!(flux.abs() < 1e-9, "{flux}");
    }

    #[test]
    fn long_and_high_waves_converge_and_breaking_ones_are_refused() {
        let water = StillWater { depth: 1.0, gravity: 9.81 };
        let wave = |height, order| {
            let (extent, current) = (Extent::Wavelength(30.0), Current::MassTransport(0.0));
            StreamFunctionWave::new(water, height, extent, current, order)
        };
        let long = wave(0.4, 48).unwrap();
        assert!(long.truncation() < 1e-3, "{}", long.truncation());
        let error = wave(0.9, 48).unwrap_err();
        assert!(matches!(error, WaveError::Breaking { limit, .. } if limit < 0.9), "{error}");
        let steep = closed_flume(0.4, 0.06, 1.2, 16);
        assert!(highest_wave(0.4, steep.wavelength().unwrap()) > 0.19);
    }
}
