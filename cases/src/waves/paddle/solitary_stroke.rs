//! The stroke that leaves next to no other wave behind a solitary one.
//!
//! Goring (1978) moves a piston with the mean velocity over the depth, which follows from mass. But
//! the velocity of the wave varies over the depth, and what it differs by makes waves: by linear
//! theory the mean velocity makes a component of q = kD too low by q⁴/45. What travels with the wave
//! varies as exp iω(x/c − t), and the part of the difference that goes into it is the one along
//! cosh ωy/c. So the stroke is the one for which ∫ (u − X f′ v − Ẋ f) cosh(ωy/c) dy from the bed to
//! the surface, with the wave's velocity taken where the board is, has no component at any ω. At
//! ω = 0 this is mass, in low waves the linear transfer function.

use super::Board;
use super::stroke::Ramp;
use crate::waves::quadrature::gauss;
use crate::waves::solitary::SolitaryWave;
use crate::waves::spline::Spline;
use crate::waves::{StillWater, WaveError, WaveTheory};
use std::f64::consts::TAU;

/// Instants over the passage of the wave at which velocities are compared.
const INSTANTS: usize = 128;
/// Points of the stroke for each of them.
const FINER: usize = 16;
/// Highest wave number over the rate of the tails: of the spectrum of sech² 4e-6 are beyond.
const HIGHEST: f64 = 8.0;
/// Depth times the wave number from which on the part along cosh ky is taken at this number. Less than
/// a thousandth of a wave is beyond, and where the crest is high the iteration would hardly converge.
const STEEPEST: f64 = 2.5;
/// Iterations; each takes away at least the part by which the water is deeper under the crest.
const MAX_ITERATIONS: usize = 100;
/// Component of the velocity that may be left, over the mean velocity.
const TOLERANCE: f64 = 1e-6;

/// The velocity Ẋ as a Fourier series.
struct Velocity {
    frequency: f64,
    /// Cosine and sine coefficients, from frequency 0 on, m/s.
    terms: Vec<(f64, f64)>,
}

impl Velocity {
    /// Frequency, cosine and sine coefficient of every term but the constant one.
    fn waves(&self) -> impl Iterator<Item = (f64, f64, f64)> {
        let terms = self.terms.iter().enumerate().skip(1);
        terms.map(|(j, (cos, sin))| (j as f64 * self.frequency, *cos, *sin))
    }

    fn at(&self, time: f64) -> f64 {
        self.waves().fold(self.terms[0].0, |sum, (frequency, a, b)| {
            let (sin, cos) = (frequency * time).sin_cos();
            sum + a * cos + b * sin
        })
    }

    fn displacement(&self, time: f64) -> f64 {
        self.waves().fold(self.terms[0].0 * time, |sum, (frequency, a, b)| {
            let (sin, cos) = (frequency * time).sin_cos();
            sum + (a * sin + b * (1.0 - cos)) / frequency
        })
    }
}

/// Displacement of the `board` at the still-water level for `wave`, m over s, from the instant at
/// which the elevation there is [`SolitaryWave::START`] of the height.
///
/// # Errors
/// A stroke that cannot be found.
pub(super) fn solitary_stroke(
    board: Board,
    water: StillWater,
    wave: &SolitaryWave,
) -> Result<Spline, WaveError> {
    let celerity = wave.celerity().unwrap_or_default();
    let first = wave.reach(SolitaryWave::START);
    let volume = 4.0 * wave.height() * wave.reach(0.42);
    let end = (2.0 * first + volume / water.depth) / celerity;
    let frequency = TAU / end;
    let highest = (HIGHEST * wave.tail_rate() * celerity / frequency) as usize;
    let numbers: Vec<f64> = (0..=highest)
        .map(|j| (j as f64 * frequency / celerity).min(STEEPEST / water.depth))
        .collect();
    // With the depth under the crest in place of that of the instant no iteration takes too much.
    let norms = along(board, water.depth + wave.height(), &numbers, |y| board.shape(water, y));

    let mut velocity = Velocity { frequency, terms: vec![(0.0, 0.0); numbers.len()] };
    for _ in 0..MAX_ITERATIONS {
        let mut change = vec![(0.0, 0.0); numbers.len()];
        for instant in 0..INSTANTS {
            let time = end * instant as f64 / INSTANTS as f64;
            let (x, speed) = (velocity.displacement(time), velocity.at(time));
            let surface = water.depth + wave.elevation(x, time);
            let left = along(board, surface, &numbers, |y| {
                let shape = board.shape(water, y);
                let u = wave.velocity(x * shape, y, time);
                u.x - x * board.slope(water, y) * u.y - speed * shape
            });
            for (j, change) in change.iter_mut().enumerate() {
                let share = if j == 0 { 1.0 } else { 2.0 } / INSTANTS as f64 * left[j] / norms[j];
                let (sin, cos) = (j as f64 * frequency * time).sin_cos();
                change.0 += share * cos;
                change.1 += share * sin;
            }
        }
        for (term, change) in velocity.terms.iter_mut().zip(&change) {
            *term = (term.0 + change.0, term.1 + change.1);
        }
        let most = change.iter().fold(0.0, |most: f64, (a, b)| most.max(a.abs()).max(b.abs()));
        if most <= TOLERANCE * velocity.terms[0].0 {
            // Within the first stretch, in which the elevation rises tenfold, the velocity is ramped.
            let stretch = (first - wave.reach(10.0 * SolitaryWave::START)) / celerity;
            return sampled(&velocity, Ramp::new(stretch)?, end);
        }
    }
    Err(WaveError::NoConvergence {
        theory: "stroke of a solitary wave",
        height: wave.height(),
        residual: TOLERANCE,
        iterations: MAX_ITERATIONS,
    })
}

/// The displacement that goes with `velocity` behind the `ramp`.
fn sampled(velocity: &Velocity, ramp: Ramp, end: f64) -> Result<Spline, WaveError> {
    let points = FINER * INSTANTS;
    let step = end / points as f64;
    let (mut times, mut places) = (vec![0.0], vec![0.0]);
    let mut place = 0.0;
    for n in 0..points {
        let time = step * n as f64;
        gauss(time, time + step, |time, weight| {
            place += weight * ramp.at(time)[0] * velocity.at(time);
        });
        times.push(time + step);
        places.push(place);
    }
    Spline::new(times, places)
}

/// ∫ `f`(y) cosh ky dy from the bed to the `surface` for each of the wave numbers k. `f` may have a
/// kink at the foot of the moving part.
fn along(board: Board, surface: f64, numbers: &[f64], f: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut sums = vec![0.0; numbers.len()];
    let foot = board.foot();
    for (low, high) in [(0.0, foot), (foot, surface)] {
        if high > low {
            gauss(low, high, |y, weight| {
                let part = weight * f(y);
                for (sum, number) in sums.iter_mut().zip(numbers) {
                    *sum += part * (number * y).cosh();
                }
            });
        }
    }
    sums
}
