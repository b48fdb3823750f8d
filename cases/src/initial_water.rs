//! The water at the start.

use nalgebra::{Point2, Vector2};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use seakeep_fluid::setup::InitialFlow;
use std::f64::consts::PI;

/// The water at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InitialWater {
    /// At rest under a flat surface.
    Still,
    /// A column at rest with a free face, as behind a dam that is taken away.
    Column {
        /// Width of the column from x = 0, m.
        width: f64,
    },
    /// At rest under η = a cos(k x), k = π n / L: the start from rest that the standing-wave
    /// solution of Wu & Taylor (1994) has to second order too.
    StandingWave {
        /// First-order amplitude a, m.
        amplitude: f64,
        /// Number n of half wavelengths in the tank.
        half_waves: u32,
        /// Length L of the tank, m.
        tank_length: f64,
    },
}

impl InitialFlow for InitialWater {
    fn elevation(&self, x: f64) -> f64 {
        match *self {
            Self::Still | Self::Column { .. } => 0.0,
            Self::StandingWave { amplitude, half_waves, tank_length } => {
                amplitude * (PI * f64::from(half_waves) / tank_length * x).cos()
            }
        }
    }

    fn velocity(&self, _point: Point2<f64>) -> Vector2<f64> {
        Vector2::zeros()
    }

    fn reach(&self) -> Option<f64> {
        match *self {
            Self::Column { width } => Some(width),
            _ => None,
        }
    }
}

/// Particles displaced at random off the lattice: a test of what an arrangement does to a run.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Displacement {
    /// Largest displacement along x and along y, m.
    pub largest: f64,
    /// Seed of the draw.
    pub seed: u64,
}

impl Displacement {
    /// `flow`, with its particles displaced.
    #[must_use]
    pub fn of<'a>(&self, flow: &'a dyn InitialFlow) -> Displaced<'a> {
        Displaced { flow, by: *self }
    }
}

/// Water whose particles are displaced.
pub struct Displaced<'a> {
    flow: &'a dyn InitialFlow,
    by: Displacement,
}

impl InitialFlow for Displaced<'_> {
    fn elevation(&self, x: f64) -> f64 {
        self.flow.elevation(x)
    }

    fn velocity(&self, point: Point2<f64>) -> Vector2<f64> {
        self.flow.velocity(point)
    }

    fn reach(&self) -> Option<f64> {
        self.flow.reach()
    }

    fn displacement(&self, place: u64) -> Vector2<f64> {
        if self.by.largest == 0.0 {
            return Vector2::zeros();
        }
        // A stream for each place: independent of what else is drawn.
        let mut random = ChaCha8Rng::seed_from_u64(self.by.seed);
        random.set_stream(place);
        let mut uniform = || f64::from(random.next_u32()) / f64::from(u32::MAX) * 2.0 - 1.0;
        Vector2::new(uniform(), uniform()) * self.by.largest
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn displacements_are_the_same_for_a_seed_and_within_their_bounds() {
        let of = |seed| Displacement { largest: 0.002, seed };
        let (one, two) = (of(1), of(2));
        let at = |by: &Displacement, place| by.of(&InitialWater::Still).displacement(place);
        let all: Vec<Vector2<f64>> = (0..1000).map(|place| at(&one, place)).collect();
        assert!(all.iter().all(|by| by.amax() <= 0.002));
        assert!(all.iter().map(Vector2::amax).fold(0.0, f64::max) > 0.0019);
        let mean = all.iter().sum::<Vector2<f64>>() / 1000.0;
        assert!(mean.amax() < 1e-4, "{mean}");
        assert_eq!(at(&one, 7), all[7]);
        assert_ne!(at(&two, 7), all[7]);
        assert_eq!(at(&Displacement::default(), 7), Vector2::zeros());
    }
}
