//! How a paddle moves to make a wave.

use super::projection::projected_stroke;
use super::second_harmonic::against_evanescent_waves;
use super::solitary_stroke::solitary_stroke;
use super::stroke::{Harmonic, Ramp, Stroke};
use super::{Board, StrokeMotion};
use crate::waves::linear::LinearWaves;
use crate::waves::solitary::SolitaryWave;
use crate::waves::spline::Spline;
use crate::waves::{StillWater, WaveError, WaveTheory, require};
use seakeep_coupler::interface::BoundaryKinematics;
use std::f64::consts::TAU;

/// The motion of a paddle: a function of time, twice continuously differentiable.
#[derive(Clone, Debug, PartialEq)]
pub struct PaddleMotion {
    water: StillWater,
    board: Board,
    ramp: Ramp,
    stroke: Stroke,
}

impl PaddleMotion {
    fn new(water: StillWater, board: Board, ramp: f64, stroke: Stroke) -> Result<Self, WaveError> {
        water.validate()?;
        board.validate(water)?;
        Ok(Self { water, board, ramp: Ramp::new(ramp)?, stroke })
    }

    /// For linear waves, one or many: every component through the transfer function of the
    /// board. `ramp` (s) is the time to full stroke, in this and the others.
    ///
    /// # Errors
    /// A hinge above the water or a negative ramp, in this and the others.
    pub fn linear(
        water: StillWater,
        board: Board,
        waves: &LinearWaves,
        ramp: f64,
    ) -> Result<Self, WaveError> {
        board.validate(water)?;
        let terms = waves.components().iter().map(|wave| {
            let amplitude = wave.amplitude / board.transfer(water, wave.wave_number);
            Harmonic::new(board, water, amplitude, wave.frequency, -wave.phase)
        });
        Self::new(water, board, ramp, Stroke::Harmonics(terms.collect()))
    }

    /// For a regular wave of second or higher order whose first harmonic has `amplitude` (m):
    /// three harmonics of the stroke such that the velocity of the board and that of the wave
    /// where the board is leave no free wave at these harmonics, and at the second none of the
    /// evanescent waves either (Schäffer 1996).
    ///
    /// # Errors
    /// Also a stroke that cannot be found.
    pub fn regular(
        water: StillWater,
        board: Board,
        wave: &dyn WaveTheory,
        period: f64,
        amplitude: f64,
        ramp: f64,
    ) -> Result<Self, WaveError> {
        board.validate(water)?;
        let mut terms = projected_stroke(board, water, wave, period)?;
        let correction = against_evanescent_waves(board, water, amplitude, TAU / period);
        terms[1] = terms[1].plus(correction);
        Self::new(water, board, ramp, Stroke::Harmonics(terms))
    }

    /// For a solitary wave: the velocity of the board and that of the wave where the board is differ
    /// by nothing that travels with the wave. The wave begins where its elevation is `start` of
    /// the height: see [`SolitaryWave::from_paddle`].
    ///
    /// # Errors
    /// Also a stroke that cannot be found.
    pub fn solitary(
        water: StillWater,
        board: Board,
        wave: &SolitaryWave,
    ) -> Result<Self, WaveError> {
        board.validate(water)?;
        let stroke = solitary_stroke(board, water, wave)?;
        Self::new(water, board, 0.0, Stroke::Series(stroke))
    }

    /// A measured or computed motion: times (s), and for a piston its displacement (m), for a flap
    /// its angle (rad, counter-clockwise). A cubic spline goes through them.
    ///
    /// # Errors
    /// Also fewer than two points, times that do not rise, an angle of a right angle or more.
    pub fn series(
        water: StillWater,
        board: Board,
        times: Vec<f64>,
        values: Vec<f64>,
        ramp: f64,
    ) -> Result<Self, WaveError> {
        let places = match board {
            Board::Piston => values,
            Board::Flap { hinge } => {
                let limit = std::f64::consts::FRAC_PI_2;
                for angle in &values {
                    require(angle.abs() < limit, "angle of the flap (rad)", *angle, "below π/2")?;
                }
                values.into_iter().map(|angle| -(water.depth - hinge) * angle.tan()).collect()
            }
        };
        Self::new(water, board, ramp, Stroke::Series(Spline::new(times, places)?))
    }

    /// The board.
    #[must_use]
    pub fn board(&self) -> Board {
        self.board
    }

    /// Stroke and its rates at `time` (s).
    #[must_use]
    pub fn stroke(&self, time: f64) -> StrokeMotion {
        self.ramp.apply(time, self.stroke.at(time))
    }

    /// Elevation of the evanescent waves at the board at `time` (s), by linear theory, m; none is
    /// known for solitary waves, which have hardly any, and for series.
    #[must_use]
    pub fn near_field(&self, time: f64) -> f64 {
        self.ramp.at(time)[0] * self.stroke.near_field(time)
    }

    /// The part of the wave that is made at `time` (s), 0 to 1.
    #[must_use]
    pub fn ramp(&self, time: f64) -> f64 {
        self.ramp.at(time)[0]
    }

    /// Kinematics of the board at `time` (s), with the `correction` of an active absorption added.
    #[must_use]
    pub fn kinematics(&self, time: f64, correction: StrokeMotion) -> BoundaryKinematics {
        self.board.kinematics(self.water, self.stroke(time) + correction)
    }

    /// Lowest and highest displacement from the start to `end` (s), m, sampled at 1000 instants.
    #[must_use]
    pub fn range(&self, end: f64) -> (f64, f64) {
        (0..=1000)
            .map(|i| self.stroke(end * f64::from(i) / 1000.0).displacement)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::solitary::SolitaryTheory;
    use crate::waves::stokes::StokesWave;
    use crate::waves::stream_function::{Current, Extent, StreamFunctionWave};

    const WATER: StillWater = StillWater { depth: 0.4, gravity: 9.81 };

    /// Rates are the derivatives of what they are rates of, and nothing jumps.
    fn assert_smooth(motion: &PaddleMotion, end: f64) {
        let h = 1e-5;
        for n in 1..200 {
            let time = end * f64::from(n) / 200.0;
            let (before, now, after) =
                (motion.stroke(time - h), motion.stroke(time), motion.stroke(time + h));
            let rate = (after.displacement - before.displacement) / (2.0 * h);
            let growth = (after.velocity - before.velocity) / (2.0 * h);
            assert!((now.velocity - rate).abs() < 1e-6, "t = {time}");
            assert!((now.acceleration - growth).abs() < 1e-4, "t = {time}");
        }
        let (before, after) = (motion.stroke(-1e-9), motion.stroke(1e-9));
        assert!((before.displacement - after.displacement).abs() < 1e-9);
    }

    #[test]
    fn strokes_of_section_3_of_the_reference() {
        // S = 0.048397 m, independently calculated.
        let wave = LinearWaves::regular(WATER, 0.06, 1.2).unwrap();
        let motion = PaddleMotion::linear(WATER, Board::Piston, &wave, 2.4).unwrap();
        assert_smooth(&motion, 5.0);
        let crest = motion.stroke(5.1);
        assert!((crest.displacement - motion.stroke(2.7).displacement).abs() < 1e-12);
        let (low, high) = motion.range(12.0);
        assert!((high - low - 0.048_397).abs() < 2e-6, "{}", high - low);
        assert_eq!(motion.stroke(0.0), StrokeMotion::default());
    }

    #[test]
    fn velocity_of_the_paddle_is_in_phase_with_the_crest() {
        let wave = LinearWaves::regular(WATER, 0.02, 1.2).unwrap();
        let motion = PaddleMotion::linear(WATER, Board::Flap { hinge: 0.1 }, &wave, 0.0).unwrap();
        let found = motion.stroke(1.2);
        assert!(found.displacement.abs() < 1e-12 && found.velocity > 0.0);
        assert!(found.acceleration.abs() < 1e-10);
    }

    fn stream(height: f64, period: f64) -> StreamFunctionWave {
        let (extent, current) = (Extent::Period(period), Current::MassTransport(0.0));
        StreamFunctionWave::new(WATER, height, extent, current, 16).unwrap()
    }

    fn regular(board: Board, wave: &StreamFunctionWave, amplitude: f64, ramp: f64) -> PaddleMotion {
        PaddleMotion::regular(WATER, board, wave, wave.period(), amplitude, ramp).unwrap()
    }

    #[test]
    fn stroke_of_a_low_wave_is_the_linear_one() {
        for board in [Board::Piston, Board::Flap { hinge: 0.1 }, Board::Flap { hinge: -0.2 }] {
            let linear = LinearWaves::regular(WATER, 0.001, 1.2).unwrap();
            let linear = PaddleMotion::linear(WATER, board, &linear, 0.0).unwrap();
            let found = regular(board, &stream(0.001, 1.2), 0.0005, 0.0);
            for time in [0.1, 0.4, 1.0] {
                let ratio = found.stroke(time).velocity / linear.stroke(time).velocity;
                assert!((ratio - 1.0).abs() < 0.01, "{board:?} {ratio}");
            }
        }
    }

    #[test]
    fn stroke_of_a_long_wave_has_madsens_second_harmonic() {
        // Madsen's (1971) theory is for long waves, here kD = 0.45:
        // H²/(32 D) (3 cosh kD / sinh³ kD − 2 S/H) sin 2ωt.
        let (height, period) = (0.01, 2.9);
        let number = WATER.wave_number(TAU / period);
        let (kd, transfer) = (number * WATER.depth, Board::Piston.transfer(WATER, number));
        let madsen = height * height / (32.0 * WATER.depth)
            * (3.0 * kd.cosh() / kd.sinh().powi(3) - 2.0 / transfer);
        let second = |motion: &PaddleMotion| {
            let count = 256;
            (0..count)
                .map(|n| f64::from(n) / f64::from(count) * period)
                .map(|t| motion.stroke(t).displacement * (2.0 * TAU * t / period).sin())
                .sum::<f64>()
                * 2.0
                / f64::from(count)
        };
        let of = |ramp| regular(Board::Piston, &stream(height, period), 0.5 * height, ramp);
        let found = of(0.0);
        assert!((second(&found) / madsen - 1.0).abs() < 0.1, "{}", second(&found) / madsen);
        let stokes = StokesWave::new(WATER, height, period).unwrap();
        let stokes =
            PaddleMotion::regular(WATER, Board::Piston, &stokes, period, 0.5 * height, 0.0);
        let stokes = second(&stokes.unwrap());
        assert!((stokes / madsen - 1.0).abs() < 0.1, "{}", stokes / madsen);
        assert_smooth(&of(0.5 * period), period);
    }

    #[test]
    fn solitary_stroke_is_the_volume_of_the_wave() {
        // Boussinesq: the volume is √(16 H D³ / 3), and the whole of it is pushed out.
        let height = 0.12;
        for (theory, volume) in [
            (SolitaryTheory::Boussinesq, (16.0 * height * 0.4f64.powi(3) / 3.0).sqrt()),
            // 1.3643 D² by interpolation of an independent calculation at 0.27, 0.32 and 0.40.
            (SolitaryTheory::Exact, 1.3727 * 0.16),
        ] {
            let wave = SolitaryWave::from_paddle(WATER, height, theory).unwrap();
            let motion = PaddleMotion::solitary(WATER, Board::Piston, &wave).unwrap();
            assert_smooth(&motion, 5.0);
            let stroke = motion.stroke(20.0);
            assert_eq!(stroke.velocity, 0.0);
            let ratio = stroke.displacement / (volume / 0.4);
            assert!((ratio - 1.0).abs() < 3e-3, "{theory:?}: {ratio}");
        }
    }

    #[test]
    fn solitary_stroke_makes_up_for_what_the_mean_velocity_lacks() {
        // By linear theory (Biésel) q⁴/45 at q = kD, which is D⁴/45 times the fourth derivative
        // along the wave: 16 (αD)⁴/45 under the crest of sech² αx, but for parts of order H/D.
        for part in [0.05, 0.1] {
            let wave = SolitaryWave::from_paddle(WATER, part * 0.4, SolitaryTheory::Exact).unwrap();
            let motion = PaddleMotion::solitary(WATER, Board::Piston, &wave).unwrap();
            let fastest = (0..40_000)
                .map(|n| motion.stroke(f64::from(n) * 2e-4).velocity)
                .fold(0.0, f64::max);
            let mean = wave.celerity().unwrap() * part / (1.0 + part);
            let lacking = 16.0 * (0.4 * wave.tail_rate()).powi(4) / 45.0;
            let ratio = (fastest / mean - 1.0) / lacking;
            assert!((ratio - 1.0).abs() < 4.0 * part, "{part}: {ratio}");
        }
    }

    #[test]
    fn solitary_stroke_of_a_flap_has_its_transfer_function() {
        // A low wave is long, and the flap pushes half of what the piston does.
        let wave = SolitaryWave::from_paddle(WATER, 0.004, SolitaryTheory::Exact).unwrap();
        let flap = Board::Flap { hinge: 0.1 };
        let number = 0.5 * wave.tail_rate();
        let expected = Board::Piston.transfer(WATER, number) / flap.transfer(WATER, number);
        let stroke = |board| {
            let motion = PaddleMotion::solitary(WATER, board, &wave).unwrap();
            motion.stroke(100.0).displacement
        };
        let ratio = stroke(flap) / stroke(Board::Piston);
        assert!((ratio / expected - 1.0).abs() < 0.02, "{ratio} for {expected}");
    }

    #[test]
    fn a_series_is_followed() {
        let times: Vec<f64> = (0..=100).map(|i| f64::from(i) * 0.02).collect();
        let angles: Vec<f64> = times.iter().map(|t| 0.1 * (3.0 * t).sin()).collect();
        let flap = Board::Flap { hinge: -0.1 };
        let motion = PaddleMotion::series(WATER, flap, times.clone(), angles, 0.0).unwrap();
        let found = motion.kinematics(0.777, StrokeMotion::default());
        assert!((found.angle - 0.1 * 2.331f64.sin()).abs() < 1e-7);
        assert!((found.position.y + 0.1).abs() < 1e-15);
        assert_smooth(&motion, 1.9);
        let upright = vec![2.0; 101];
        assert!(PaddleMotion::series(WATER, flap, times, upright, 0.0).is_err());
        let (times, values) = (vec![0.0, 1.0], vec![0.0, 0.1]);
        assert!(PaddleMotion::series(WATER, Board::Piston, times, values, -1.0).is_err());
    }
}
