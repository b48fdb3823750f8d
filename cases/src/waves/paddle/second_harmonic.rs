//! What evanescent waves ask of the second harmonic of a stroke.
//!
//! To second order in the wave's height, the products of first-order waves at the paddle make a
//! free wave at 2ω. Those of the progressive wave with itself are in the projected stroke; those
//! with evanescent waves, of the same order in water that is not shallow, are here (Schäffer 1996).
//! They follow from Stokes' expansion to second order with the potential
//! Re{Σ b_j C_j(y) exp(i κ_j x − i ω t)}, C_j = cosh κ_j y / cosh κ_j D and
//! g κ_j tanh κ_j D = ω², where κ_0 = k and κ_j = i k_j; a wave at 2ω is free along
//! C = cosh K y / cosh K D with g K tanh K D = 4 ω².

use super::Board;
use crate::waves::StillWater;
use crate::waves::dispersion::cosh_over_cosh;
use crate::waves::quadrature::simpson;
use nalgebra::Complex;

const I: Complex<f64> = Complex::new(0.0, 1.0);
/// Pairs of intervals over the board: forty intervals for the shortest evanescent wave.
const PANELS: usize = 1000;

/// A wave of the first order: κ (1/m) and the amplitude of its potential b (m²/s).
struct Mode {
    number: Complex<f64>,
    potential: Complex<f64>,
}

/// The complex amplitude X₂ of a stroke Re{X₂ exp(−2iωt)} (m) that makes as large a free wave as
/// the evanescent waves of a board that makes a wave a cos(k x − ω t) of `amplitude` a (m) and
/// `frequency` ω (rad/s), and against it.
pub(super) fn against_evanescent_waves(
    board: Board,
    water: StillWater,
    amplitude: f64,
    frequency: f64,
) -> Complex<f64> {
    let (depth, g) = (water.depth, water.gravity);
    let number = water.wave_number(frequency);
    let stroke = I * (amplitude / board.transfer(water, number));
    let potential = |elevation: Complex<f64>| -I * elevation * (g / frequency);
    let progressive =
        Mode { number: number.into(), potential: potential(Complex::from(amplitude)) };
    let evanescent: Vec<Mode> = board
        .evanescent_modes(water, frequency)
        .map(|(k, elevation)| Mode { number: I * k, potential: potential(stroke * elevation) })
        .collect();

    // The velocities of evanescent waves where the board is, off x = 0: −X f ∂²φ/∂x² + X f′ ∂φ/∂y.
    let free = water.wave_number(2.0 * frequency);
    let along = |y: f64| cosh_over_cosh(free * y, free * depth);
    let moved = |y: f64| {
        let (shape, slope) = (board.shape(water, y), board.slope(water, y));
        let velocity = |mode: &Mode| {
            let k = mode.number.im;
            let (sin, cos) = (k * y).sin_cos();
            mode.potential * (-k * (k * shape * cos + slope * sin) / (k * depth).cos())
        };
        evanescent.iter().map(velocity).sum::<Complex<f64>>() * 0.5 * stroke * along(y)
    };
    let part = |f: fn(Complex<f64>) -> f64| simpson(board.foot(), depth, PANELS, |y| f(moved(y)));
    let mut needed = Complex::new(part(|z| z.re), part(|z| z.im));

    // The bound waves of all pairs: with r the right-hand side of the surface condition
    // ∂²φ/∂t² + g ∂φ/∂y = r, ∫ ∂φ/∂x C dy = i K′ r / (g (K′² − K²)), K′ = κ_j + κ_l.
    let deep = frequency * frequency / g;
    let bound = |one: &Mode, other: &Mode| {
        let product = I * frequency * one.potential * other.potential;
        let (p, q) = (one.number, other.number);
        // −∂|∇φ|²/∂t − η ∂(∂²φ/∂t² + g ∂φ/∂y)/∂y, with the elevation i ω b / g.
        let forcing = product * ((-p * q + deep * deep) - (q * q - deep * deep) * 0.5);
        let sum = p + q;
        I * sum * forcing / (g * (sum * sum - free * free))
    };
    for (j, one) in evanescent.iter().enumerate() {
        needed -= bound(&progressive, one) + bound(one, &progressive);
        needed -= bound(one, one);
        for other in &evanescent[..j] {
            needed -= bound(one, other) + bound(other, one);
        }
    }
    let own = board.project(water, free, |y| board.shape(water, y));
    needed / (2.0 * I * frequency * own)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const WATER: StillWater = StillWater { depth: 0.4, gravity: 9.81 };

    #[test]
    fn second_order_in_the_height_and_less_for_longer_waves() {
        let of = |amplitude, period| {
            against_evanescent_waves(Board::Piston, WATER, amplitude, TAU / period)
        };
        let (one, two) = (of(0.01, 1.2), of(0.02, 1.2));
        assert!((two / one - Complex::from(4.0)).norm() < 1e-12);
        // Madsen's harmonic of long waves grows with the square of the period, this one falls.
        assert!(of(0.01, 6.0).norm() < 0.25 * of(0.01, 1.2).norm());
    }

    #[test]
    fn a_hinge_far_below_is_a_piston() {
        let of = |board| against_evanescent_waves(board, WATER, 0.03, TAU / 1.2);
        let (piston, deep) = (of(Board::Piston), of(Board::Flap { hinge: -1e4 }));
        assert!((deep / piston - Complex::from(1.0)).norm() < 1e-3, "{deep} {piston}");
    }

    #[test]
    fn regression_of_the_stroke_of_section_3_of_the_reference() {
        // The same theory evaluated another way, with 40 modes and integrals in closed form; the
        // tail of the sum falls with the inverse of the number of modes. That the free wave goes
        // shows in the tank (docs/validation.md).
        let found = against_evanescent_waves(Board::Piston, WATER, 0.03, TAU / 1.2);
        let sum = Complex::new(0.000_170_67, 0.000_536_45 - 0.000_015_18);
        assert!((found - sum).norm() < 0.02 * sum.norm(), "{found}");
    }
}
