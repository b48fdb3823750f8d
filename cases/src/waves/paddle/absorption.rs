//! Active absorption: a paddle that gives way to waves that come back to it.
//!
//! A long wave that runs towards the paddle with elevation η has the velocity −√(g/D) η. A paddle
//! that adds this to its motion lets it pass. Shallow-water form (Schäffer & Klopman 2000, their
//! simplest): dX/dt = √(g/D) (η_target − η_measured). A slow return keeps the paddle near its rest
//! position.

use super::StrokeMotion;
use crate::waves::{StillWater, WaveError, require_positive};
use serde::{Deserialize, Serialize};

/// The correction of a paddle's stroke.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ActiveAbsorption {
    /// √(g/D), 1/s.
    gain: f64,
    /// Time in which the correction falls by e, s.
    return_time: f64,
}

/// What the correction has come to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AbsorptionState {
    /// Displacement, m.
    pub displacement: f64,
    /// Velocity over the last step, m/s.
    pub velocity: f64,
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

    /// The state `step` (s) after `state`, with the elevation at the paddle as the wave has it,
    /// `target`, and as it is, `measured` (m); and the motion to be added to the stroke. Nothing
    /// measured (a paddle out of the water) means no correction but the return.
    #[must_use]
    pub fn advance(
        &self,
        state: AbsorptionState,
        step: f64,
        target: f64,
        measured: Option<f64>,
    ) -> (AbsorptionState, StrokeMotion) {
        let wanted = self.gain * (target - measured.unwrap_or(target));
        let displacement = (state.displacement + step * wanted) / (1.0 + step / self.return_time);
        let velocity = (displacement - state.displacement) / step;
        let acceleration = (velocity - state.velocity) / step;
        (
            AbsorptionState { displacement, velocity },
            StrokeMotion { displacement, velocity, acceleration },
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WATER: StillWater = StillWater { depth: 0.4, gravity: 9.81 };

    #[test]
    fn a_long_wave_that_comes_back_finds_an_open_end() {
        // The paddle's velocity is the wave's own, −√(g/D) η.
        let absorption = ActiveAbsorption::new(WATER, 1e9).unwrap();
        let (mut state, dt) = (AbsorptionState::default(), 1e-3);
        let elevation = |t: f64| 0.02 * (0.5 * t).sin();
        for n in 1..4000 {
            let time = f64::from(n) * dt;
            let (next, motion) = absorption.advance(state, dt, 0.01, Some(0.01 + elevation(time)));
            let exact = -(9.81f64 / 0.4).sqrt() * elevation(time);
            assert!((motion.velocity - exact).abs() < 1e-6);
            assert!((motion.displacement - next.displacement).abs() < 1e-15);
            state = next;
        }
    }

    #[test]
    fn returns_to_rest() {
        let absorption = ActiveAbsorption::new(WATER, 2.0).unwrap();
        let mut state = AbsorptionState { displacement: 0.1, velocity: 0.0 };
        for _ in 0..2000 {
            state = absorption.advance(state, 1e-3, 0.0, None).0;
        }
        assert!((state.displacement - 0.1 * (-1f64).exp()).abs() < 1e-4);
        assert!(ActiveAbsorption::new(WATER, 0.0).is_err());
    }
}
