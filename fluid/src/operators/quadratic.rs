//! Second order: one quadratic least-squares fit gives everything; see [`crate::fit`].

use super::Derivatives;
use crate::fit::{self, Rows, WallRow};
use nalgebra::{Matrix2, Vector2};

/// Weight and row of a neighbour at offset `d`.
#[inline(always)]
pub(super) fn value_row(d: Vector2<f64>) -> (f64, [f64; 5]) {
    (fit::weight(d.norm_squared()), fit::basis(d))
}

/// Weight and row of a wall's ∂p/∂n at offset `d`, taking part with `part`.
#[inline(always)]
pub(super) fn wall_row(part: f64, d: Vector2<f64>, normal: Vector2<f64>) -> (f64, [f64; 5]) {
    (part * fit::WALL_WEIGHT * fit::bell(d.norm_squared()), fit::normal_derivative(d, normal))
}

/// The derivatives around a particle; `wall_excess(w)` is n·(U_w − u_i).
#[inline(always)]
pub(super) fn derive(rows: &mut Rows, wall_excess: impl Fn(&WallRow) -> f64) -> Derivatives {
    let (pressure, velocity, quality) = rows.fit(wall_excess);
    let (u, v) = (velocity.u, velocity.v);
    Derivatives {
        velocity_gradient: Matrix2::new(u[0], u[1], v[0], v[1]),
        diagonal: rows.laplacian(&pressure),
        pressure,
        velocity,
        quality,
    }
}
