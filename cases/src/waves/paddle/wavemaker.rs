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
    /// Length of the last step, s.
    duration: f64,
    /// Whether an elevation has been measured since.
    observed: bool,
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

    /// Sets the acceleration of the correction from the elevation measured now.
    fn steer(&mut self, measured: Option<f64>) {
        let time = self.state.correction.time();
        if let (Some((absorption, _)), Some(target)) = (&self.absorption, self.target(time)) {
            let excess = measured.map_or(0.0, |measured| measured - target);
            let WavemakerState { correction, duration, .. } = self.state;
            self.state.correction = absorption.steer(correction, time, duration, excess);
        }
    }
}

impl PrescribedMotion for Wavemaker {
    fn kinematics(&self, time: f64) -> Result<BoundaryKinematics, BodyError> {
        Ok(self.motion.kinematics(time, self.state.correction.at(time)))
    }

    fn observe(&mut self, elevation: f64) {
        self.steer(Some(elevation));
        self.state.observed = true;
    }

    fn advance(&mut self, time: f64, duration: f64) -> Result<(), BodyError> {
        if !self.state.observed {
            // Out of the water there is nothing to absorb, but a way back to rest.
            self.state.correction = self.state.correction.moved_to(time);
            self.steer(None);
        }
        self.state = WavemakerState {
            correction: self.state.correction.moved_to(time + duration),
            duration,
            observed: false,
        };
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
    use crate::waves::paddle::{Board, StrokeMotion};

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
        let alone = maker.motion.kinematics(5.0, StrokeMotion::default());
        // The clock that adds up steps is off by rounding.
        assert!((found.position - alone.position).norm() < 1e-12);
        assert!(found.velocity.x.abs() > 0.0);
    }

    #[test]
    fn pose_and_velocity_are_smooth_and_an_unobserved_paddle_returns_to_rest() {
        let mut maker = wavemaker();
        for n in 0..6000 {
            let time = f64::from(n) * 0.005;
            if n < 1000 {
                let before = maker.kinematics(time).unwrap();
                maker.observe(0.02);
                let after = maker.kinematics(time).unwrap();
                // But for the rounding of the clock that adds up steps.
                assert!((before.position - after.position).norm() < 1e-12);
                assert!((before.velocity - after.velocity).norm() < 1e-12);
            }
            let (before, next) = (maker.kinematics(time + 0.005).unwrap(), time + 0.005);
            maker.advance(time, 0.005).unwrap();
            let after = maker.kinematics(next).unwrap();
            if n < 1000 {
                assert!((before.position - after.position).norm() < 1e-12);
            }
        }
        let correction = |time: f64, maker: &Wavemaker| {
            let alone = maker.motion.kinematics(time, StrokeMotion::default());
            maker.kinematics(time).unwrap().position.x - alone.position.x
        };
        // At 5 s it had gone back from the water in front of it; ten seconds take it back by e.
        let last = correction(30.0, &maker);
        assert!(last < 0.0 && last > -0.05, "{last}");
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
