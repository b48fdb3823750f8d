//! Conventional ISPH: kernel sums over particles of one volume dx².
//!
//! - Laplacian of Shao & Lo (2003), Σ 8 m / (ρ_a + ρ_b)² (p_a − p_b) r·∇W / (r² + η²), here with one
//!   density: an M-matrix.
//! - Walls as boundary integrals (Ferrand et al. 2013): a wall adds −2 ∂p/∂n ∫ W ds to the Laplacian,
//!   and what the kernel loses behind it comes back by division by γ, the part of the kernel that
//!   is in the water. γ is taken from the kernel's second moment, ½ (Σ V |W'| r + ∫ W n·(r_i − r) ds),
//!   which equals ∫ W dV by Gauss' theorem and makes the Laplacian of r² exact on a lattice, where the
//!   Shepard sum is 2 to 4 % off.
//!   Σ V |W'| r and ∫ W n ds, equal by the same theorem, differ by some per cent on particles: the
//!   wall's integral is scaled so that a uniform gradient has no Laplacian.
//! - Gradient and divergence Σ V (f_b − f_a) ∇W with the correction matrix of Randles & Libersky
//!   (1996), without which a particle on the surface would feel half of its gradient. Walls complete
//!   the matrix: exact for linear fields at walls, corners and the surface too.
//!
//! Lengths are in spacings.

#![allow(clippy::needless_range_loop)] // triangles of a matrix read best by index

use super::Derivatives;
use crate::fields::Fields;
use crate::fit::{self, PressureFit, Quality, Rows, WallRow};
use crate::small_matrix::{Factor, Symmetric};
use nalgebra::{Matrix2, Vector2};
use std::f64::consts::PI;

/// Smoothing length h: the support of the kernel, 2 h, is the radius of the neighbour lists.
const SMOOTHING_LENGTH: f64 = 0.5 * fit::RADIUS;
/// η² of Shao & Lo's Laplacian, η = 0.1 h.
const ETA_SQUARED: f64 = 0.01 * SMOOTHING_LENGTH * SMOOTHING_LENGTH;
/// 7 / (4 π h²), the factor of the kernel in two dimensions.
const NORM: f64 = 7.0 / (4.0 * PI * SMOOTHING_LENGTH * SMOOTHING_LENGTH);
/// A pivot of the correction matrix below this part of its diagonal: neighbours on a line.
const PIVOT_THRESHOLD: f64 = 1e-3;

/// W at squared distance `r2`: the C² kernel of Wendland (1995), (1 − q/2)⁴ (1 + 2 q), q = r/h.
#[inline(always)]
fn kernel(r2: f64) -> f64 {
    let q = r2.sqrt() / SMOOTHING_LENGTH;
    let p = (1.0 - 0.5 * q).max(0.0);
    NORM * p * p * p * p * (1.0 + 2.0 * q)
}

/// |W'| / r.
#[inline(always)]
fn slope(r2: f64) -> f64 {
    let p = (1.0 - 0.5 * r2.sqrt() / SMOOTHING_LENGTH).max(0.0);
    5.0 * NORM / (SMOOTHING_LENGTH * SMOOTHING_LENGTH) * p * p * p
}

/// Weight |W'| / r and row of a neighbour at offset `d`: two entries for the gradient, one for the
/// Laplacian.
#[inline(always)]
pub(super) fn value_row(d: Vector2<f64>) -> (f64, [f64; 5]) {
    let r2 = d.norm_squared();
    (slope(r2), [d.x, d.y, 2.0 * r2 / (r2 + ETA_SQUARED), 0.0, 0.0])
}

/// Weight ∫ W ds and row of the ∂p/∂n of a piece of wall of `length` at offset `d`, taking part
/// with `part`. In the gradient a wall at distance s has p_i − s ∂p/∂n.
#[inline(always)]
pub(super) fn wall_row(
    part: f64,
    d: Vector2<f64>,
    normal: Vector2<f64>,
    length: f64,
) -> (f64, [f64; 5]) {
    let s = distance(d, normal);
    (part * kernel(d.norm_squared()) * length, [s * normal.x, s * normal.y, 0.0, -2.0, 0.0])
}

/// Distance from the wall at offset `d`, 0 behind it.
#[inline(always)]
fn distance(d: Vector2<f64>, normal: Vector2<f64>) -> f64 {
    (-d.dot(&normal)).max(0.0)
}

/// The derivatives around a particle; `wall_excess(w)` is n·(U_w − u_i).
pub(super) fn derive(
    fields: Fields,
    rows: &mut Rows,
    wall_excess: impl Fn(&WallRow) -> f64,
) -> Derivatives {
    if rows.too_few() {
        return Derivatives::default();
    }
    let mut matrix = Symmetric::<2>::zero();
    let mut moment = 0.0;
    let (mut missing, mut of_walls) = (Vector2::zeros(), Vector2::zeros());
    let (mut u, mut v) = ([0.0; 2], [0.0; 2]);
    for k in 0..rows.values.len() {
        let (d, jump) = (rows.values.offset(k), rows.values.velocity(k));
        let (weight, row) = value_row(d);
        matrix.add_outer(weight, &[d.x, d.y]);
        moment += weight * 0.5 * row[2] * d.norm_squared();
        missing += d * (weight * 0.5 * row[2]);
        for (axis, d) in [d.x, d.y].into_iter().enumerate() {
            u[axis] += weight * jump.x * d;
            v[axis] += weight * jump.y * d;
        }
    }
    let velocity_gradient = if rows.walls.is_empty() {
        matrix.factorize(PIVOT_THRESHOLD).map_or_else(Matrix2::zeros, |factor| {
            let (u, v) = (factor.solve(&u), factor.solve(&v));
            Matrix2::new(u[0], u[1], v[0], v[1])
        })
    } else {
        velocity_gradient_at_walls(rows, &matrix, u, v, &wall_excess)
    };
    let velocity = rows.fit_velocity(wall_excess);
    for wall in &rows.walls {
        let d = Vector2::new(wall.basis[0], wall.basis[1]);
        let length = fields.walls.length[wall.index as usize] / fields.spacing;
        let (weight, _) = wall_row(wall.part, d, wall.normal, length);
        let weighted = weight * distance(d, wall.normal);
        matrix.add_outer(weighted, &[wall.normal.x, wall.normal.y]);
        moment += weighted;
        of_walls += wall.normal * weight;
    }
    let gamma = 0.5 * moment;
    let Some(factor) = matrix.factorize(PIVOT_THRESHOLD) else {
        return Derivatives::default();
    };
    let mut diagonal = 0.0;
    for k in 0..rows.values.len() {
        let (weight, row) = value_row(rows.values.offset(k));
        let coefficient = weight * row[2] / gamma;
        rows.values.set_coefficient(k, coefficient);
        diagonal += coefficient;
    }
    let size = of_walls.norm_squared();
    let walls_scale = if size > 0.0 { missing.dot(&of_walls) / size } else { 0.0 };
    let pressure = PressureFit {
        singular: [0.0; 3],
        gradient_x: functional(&factor, [1.0, 0.0]),
        gradient_y: functional(&factor, [0.0, 1.0]),
        laplacian: [0.0, 0.0, 1.0 / gamma, walls_scale / gamma, 0.0],
    };
    Derivatives { pressure, velocity_gradient, velocity, diagonal, quality: Quality::Full }
}

/// The gradient in `direction` as a functional of the rows.
fn functional(factor: &Factor<2>, direction: [f64; 2]) -> [f64; 5] {
    let [x, y] = factor.solve(&direction);
    [x, y, 0.0, 0.0, 0.0]
}

/// ∇u where walls demand n·u = n·U, each wall particle counting as a particle: both components at
/// once, since a wall's row holds both. What slips along the wall is free.
#[inline(never)]
fn velocity_gradient_at_walls(
    rows: &Rows,
    inner: &Symmetric<2>,
    u: [f64; 2],
    v: [f64; 2],
    wall_excess: &impl Fn(&WallRow) -> f64,
) -> Matrix2<f64> {
    let mut matrix = Symmetric::<4>::zero();
    for i in 0..2 {
        for j in 0..=i {
            matrix.0[i][j] = inner.0[i][j];
            matrix.0[i + 2][j + 2] = inner.0[i][j];
        }
    }
    let mut rhs = [u[0], u[1], v[0], v[1]];
    for wall in &rows.walls {
        let (d, n) = (Vector2::new(wall.basis[0], wall.basis[1]), wall.normal);
        let weight = wall.part * slope(d.norm_squared());
        let row = [n.x * d.x, n.x * d.y, n.y * d.x, n.y * d.y];
        matrix.add_outer(weight, &row);
        let excess = weight * wall_excess(wall);
        for (rhs, row) in rhs.iter_mut().zip(row) {
            *rhs += row * excess;
        }
    }
    matrix.factorize(PIVOT_THRESHOLD).map_or_else(Matrix2::zeros, |factor| {
        let [ux, uy, vx, vy] = factor.solve(&rhs);
        Matrix2::new(ux, uy, vx, vy)
    })
}
