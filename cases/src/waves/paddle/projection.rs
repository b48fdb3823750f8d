//! The stroke that leaves no free wave beside a nonlinear regular wave, nearly.
//!
//! At the paddle, the velocity of the wave and that of the board differ; the difference makes
//! evanescent and free waves. The free progressive wave at the frequency j ω is the part of it
//! along cosh K_j y, K_j the linear wave number at j ω. So the stroke is the one for which
//! ∫ (u − X f′ v − Ẋ f) cosh K_j y dy has no component at j ω, with the wave's velocity taken
//! where the board is. To first order this is the linear transfer function; the quadratic terms
//! of the board's displacement are in it; those with evanescent waves are [`super::second_harmonic`].

use super::Board;
use super::stroke::Harmonic;
use crate::waves::{StillWater, WaveError, WaveTheory};
use std::f64::consts::TAU;

/// Harmonics of the stroke.
const HARMONICS: usize = 3;
/// Instants over a period.
const INSTANTS: usize = 32;
/// Iterations; each gains a factor of about k X.
const MAX_ITERATIONS: usize = 40;

/// Harmonics of the stroke for `wave` of `period` (s).
pub(super) fn projected_stroke(
    board: Board,
    water: StillWater,
    wave: &dyn WaveTheory,
    period: f64,
) -> Result<Vec<Harmonic>, WaveError> {
    let frequency = TAU / period;
    // Cosine and sine coefficients of the velocity Ẋ at each harmonic.
    let mut velocity = [(0.0, 0.0); HARMONICS];
    let modes: Vec<(f64, f64)> = (1..=HARMONICS)
        .map(|j| {
            let number = water.wave_number(j as f64 * frequency);
            (number, board.project(water, number, |y| board.shape(water, y)))
        })
        .collect();
    let mut change = f64::INFINITY;
    for _ in 0..MAX_ITERATIONS {
        let mut next = [(0.0, 0.0); HARMONICS];
        for instant in 0..INSTANTS {
            let time = period * instant as f64 / INSTANTS as f64;
            let displacement: f64 = velocity
                .iter()
                .enumerate()
                .map(|(j, (cos, sin))| {
                    let w = (j + 1) as f64 * frequency;
                    (cos * (w * time).sin() - sin * (w * time).cos()) / w
                })
                .sum();
            for (j, (number, norm)) in modes.iter().enumerate() {
                let along = board.project(water, *number, |y| {
                    let u = wave.velocity(displacement * board.shape(water, y), y, time);
                    u.x - displacement * board.slope(water, y) * u.y
                });
                let angle = (j + 1) as f64 * frequency * time;
                let share = 2.0 / INSTANTS as f64 * along / norm;
                next[j].0 += share * angle.cos();
                next[j].1 += share * angle.sin();
            }
        }
        let size = next[0].0.hypot(next[0].1);
        change = next
            .iter()
            .zip(&velocity)
            .fold(0.0, |most: f64, (a, b)| most.max((a.0 - b.0).abs()).max((a.1 - b.1).abs()));
        velocity = next;
        if change <= 1e-10 * size {
            return Ok(velocity
                .iter()
                .enumerate()
                .map(|(j, (cos, sin))| {
                    let frequency = (j + 1) as f64 * frequency;
                    // Ẋ = cos·cos ωt + sin·sin ωt, so X = A sin(ωt + φ).
                    let (amplitude, phase) = (cos.hypot(*sin) / frequency, (-sin).atan2(*cos));
                    Harmonic::new(board, water, amplitude, frequency, phase)
                })
                .collect());
        }
    }
    Err(WaveError::NoConvergence {
        theory: "stroke of the paddle",
        height: wave.elevation(0.0, 0.0) - wave.elevation(0.0, 0.5 * period),
        residual: change,
        iterations: MAX_ITERATIONS,
    })
}
