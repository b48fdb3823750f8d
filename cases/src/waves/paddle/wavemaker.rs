//! A wavemaker: a paddle that makes one wave and may absorb others.

use super::{AbsorptionState, ActiveAbsorption, PaddleMotion};
use crate::waves::WaveTheory;
use seakeep_body::{BodyError, PrescribedMotion};
use seakeep_coupler::interface::BoundaryKinematics;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A paddle at x = 0 as a prescribed motion. With active absorption it is told the elevation of
/// the water at it, and has a state.
#[derive(Clone, Debug)]
pub struct Wavemaker {
    motion: PaddleMotion,
    /// How returning waves are absorbed, and the wave that they are told from.
    absorption: Option<(ActiveAbsorption, Arc<dyn WaveTheory>)>,
    state: WavemakerState,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct WavemakerState {
    correction: AbsorptionState,
    /// The last elevation measured, m.
    measured: Option<f64>,
}

impl Wavemaker {
    /// A paddle that moves like `motion` and, with `absorption`, lets pass what is not the wave
    /// given there.
    #[must_use]
    pub fn new(
        motion: PaddleMotion,
        absorption: Option<(ActiveAbsorption, Arc<dyn WaveTheory>)>,
    ) -> Self {
        Self { motion, absorption, state: WavemakerState::default() }
    }

    /// The motion without absorption.
    #[must_use]
    pub fn motion(&self) -> &PaddleMotion {
        &self.motion
    }

    /// The elevation (m) at the paddle at `time` (s) if nothing comes back to it: the wave and the
    /// evanescent waves. `None` without active absorption.
    #[must_use]
    pub fn target(&self, time: f64) -> Option<f64> {
        let (_, wave) = self.absorption.as_ref()?;
        let x = self.motion.stroke(time).displacement;
        Some(self.motion.ramp(time) * wave.elevation(x, time) + self.motion.near_field(time))
    }
}

impl PrescribedMotion for Wavemaker {
    fn kinematics(&self, time: f64) -> Result<BoundaryKinematics, BodyError> {
        Ok(self.motion.kinematics(time, self.state.correction.at(time)))
    }

    fn observe(&mut self, elevation: f64) {
        self.state.measured = Some(elevation);
    }

    fn advance(&mut self, time: f64, duration: f64) -> Result<(), BodyError> {
        if let (Some((absorption, _)), Some(target)) = (&self.absorption, self.target(time)) {
            let excess = self.state.measured.map_or(0.0, |measured| measured - target);
            self.state.correction =
                absorption.advance(self.state.correction, time, duration, excess);
        }
        Ok(())
    }

    fn save(&self) -> Result<Vec<u8>, BodyError> {
        postcard::to_stdvec(&self.state).map_err(|_| BodyError::MotionState)
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), BodyError> {
        self.state = postcard::from_bytes(state).map_err(|_| BodyError::MotionState)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::StillWater;
    use crate::waves::linear::LinearWaves;
    use crate::waves::paddle::Board;

    const WATER: StillWater = StillWater { depth: 0.4, gravity: 9.81 };

    fn wavemaker() -> Wavemaker {
        let wave = LinearWaves::regular(WATER, 0.02, 1.2).unwrap();
        let motion = PaddleMotion::linear(WATER, Board::Piston, &wave, 2.4).unwrap();
        let absorption = ActiveAbsorption::new(WATER, 10.0).unwrap();
        Wavemaker::new(motion, Some((absorption, Arc::new(wave))))
    }

    #[test]
    fn nothing_to_absorb_no_correction() {
        let mut maker = wavemaker();
        for n in 0..1000 {
            let time = f64::from(n) * 0.005;
            maker.observe(maker.target(time).unwrap());
            maker.advance(time, 0.005).unwrap();
        }
        let found = maker.kinematics(5.0).unwrap();
        assert_eq!(found, maker.motion.kinematics(5.0, Default::default()));
        assert!(found.velocity.x.abs() > 0.0);
    }

    #[test]
    fn a_step_repeated_from_a_saved_state_is_the_same_to_the_bit() {
        let mut maker = wavemaker();
        let go = |maker: &mut Wavemaker, from: i32| {
            for n in from..from + 50 {
                let time = f64::from(n) * 0.005;
                maker.observe(0.01 * (3.0 * time).sin());
                maker.advance(time, 0.005).unwrap();
            }
            maker.kinematics(f64::from(from + 50) * 0.005).unwrap()
        };
        go(&mut maker, 0);
        let saved = maker.save().unwrap();
        let first = go(&mut maker, 50);
        maker.restore(&saved).unwrap();
        assert_eq!(go(&mut maker, 50), first);
        assert!(maker.restore(&[]).is_err());
    }
}
