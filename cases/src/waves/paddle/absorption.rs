//! Active absorption: a paddle that gives way to waves that come back to it.
//!
//! A long wave that runs towards the paddle with elevation η has the velocity −√(g/D) η; a paddle
//! that adds this to its motion lets it pass. Shallow-water form (Schäffer & Klopman 2000):
//! dX/dt = √(g/D) (η_target − η_measured) − X/τ, whose last term returns the paddle to rest. The
//! velocity approaches this over a short time, so that the correction has no jump but in its
//! acceleration.

use super::StrokeMotion;
use crate::waves::{StillWater, WaveError, require_positive};
use serde::{Deserialize, Serialize};

/// Time over which the velocity follows the elevation, in √(D/g).
const RESPONSE: f64 = 0.05;

/// The correction of a paddle's stroke.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActiveAbsorption {
    /// √(g/D), 1/s.
    gain: f64,
    /// Time τ in which the correction falls by e, s.
    return_time: f64,
}

/// What the correction has come to, and its acceleration from then on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AbsorptionState {
    time: f64,
    displacement: f64,
    velocity: f64,
    acceleration: f64,
}

impl AbsorptionState {
    /// The same correction, told from `time` (s) on.
    #[must_use]
    pub fn moved_to(&self, time: f64) -> Self {
        let StrokeMotion { displacement, velocity, acceleration } = self.at(time);
        Self { time, displacement, velocity, acceleration }
    }

    /// When it was last steered or moved, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.time
    }

    /// The correction at `time` (s).
    #[must_use]
    pub fn at(&self, time: f64) -> StrokeMotion {
        let (s, a) = (time - self.time, self.acceleration);
        StrokeMotion {
            displacement: self.displacement + s * (self.velocity + 0.5 * s * a),
            velocity: self.velocity + s * a,
            acceleration: a,
        }
    }
}

impl ActiveAbsorption {
    /// Absorption in `water`; the paddle drifts back to rest with `return_time` (s), which should
    /// be many periods long.
    ///
    /// # Errors
    /// A time that is not positive.
    pub fn new(water: StillWater, return_time: f64) -> Result<Self, WaveError> {
        water.validate()?;
        require_positive("return time (s)", return_time)?;
        Ok(Self { gain: (water.gravity / water.depth).sqrt(), return_time })
    }

    /// How the correction goes on from `time` (s) over steps of `duration` (s), with `excess` the
    /// measured elevation at the paddle less that of the wave to be made, m.
    #[must_use]
    pub fn steer(
        &self,
        state: AbsorptionState,
        time: f64,
        duration: f64,
        excess: f64,
    ) -> AbsorptionState {
        let now = state.at(time);
        let wanted = -self.gain * excess - now.displacement / self.return_time;
        let response = (RESPONSE / self.gain).max(duration);
        AbsorptionState {
            time,
            displacement: now.displacement,
            velocity: now.velocity,
            acceleration: (wanted - now.velocity) / response,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WATER: StillWater = StillWater { depth: 0.4, gravity: 9.81 };

    #[test]
    fn a_long_wave_that_comes_back_finds_an_open_end() {
        // The paddle's velocity is the wave's own, −√(g/D) η, 0.05 √(D/g) later.
        let absorption = ActiveAbsorption::new(WATER, 1e9).unwrap();
        let (mut state, dt) = (AbsorptionState::default(), 1e-3);
        let excess = |t: f64| 0.02 * (0.5 * t).sin();
        for n in 0..8000 {
            let time = f64::from(n) * dt;
            let before = state.at(time);
            state = absorption.steer(state, time, dt, excess(time));
            assert_eq!(before.displacement, state.at(time).displacement);
            assert_eq!(before.velocity, state.at(time).velocity);
            let (gain, delay) = ((9.81f64 / 0.4).sqrt(), 0.05 * (0.4f64 / 9.81).sqrt());
            let exact = -gain * excess(time - delay);
            if time > 0.2 {
                assert!((before.velocity - exact).abs() < 5e-5, "t = {time}");
            }
        }
    }

    #[test]
    fn returns_to_rest() {
        let absorption = ActiveAbsorption::new(WATER, 2.0).unwrap();
        let mut state = AbsorptionState { displacement: 0.1, ..AbsorptionState::default() };
        for n in 0..2000 {
            state = absorption.steer(state, f64::from(n) * 1e-3, 1e-3, 0.0);
        }
        assert!((state.at(2.0).displacement - 0.1 * (-1f64).exp()).abs() < 5e-4);
        assert!(ActiveAbsorption::new(WATER, 0.0).is_err());
    }
}
