//! Quadratic weighted least-squares fits around a particle: one fit serves divergence, gradient
//! and Laplacian (LSMPS type A; the quadric SFDI of Yan et al. 2020 is its block elimination).
//!
//! A field f near particle i is f_i + B(d)·c with d the offset in spacings dx and
//! B = [x, y, x²/2, xy, y²/2]. Walls enter as further rows: n·∇p = q for the pressure and
//! n·u = n·U for the velocity, so that no wall unknowns arise and a corner is just two rows.

use crate::small_matrix::{Factor, Symmetric};
use nalgebra::Vector2;

/// Support radius of a fit in particle spacings.
pub(crate) const RADIUS: f64 = 2.6;

/// A pivot below this part of its diagonal means a direction that the neighbours do not resolve.
const PIVOT_THRESHOLD: f64 = 1e-5;

/// Added to the second-derivative diagonal of an unresolved fit, in parts of its trace: the fit
/// then falls back to a linear one.
const LINEAR_FALLBACK: f64 = 10.0;

/// Weight of a Neumann row relative to a value row. A small weight keeps the condition where a
/// quadratic field can meet it, and lets the fit give way where it cannot, at a corner and where
/// the surface meets a wall: with 1 the contact line becomes unstable.
pub(crate) const WALL_WEIGHT: f64 = 0.2;

/// Weight of the centre's own value in a velocity fit at a wall.
const CENTRE_WEIGHT: f64 = 0.5;

/// Weight of a value row, (1 − q)³ (1 + 3 q) / r², q = r / radius, at squared distance `r2` in
/// spacings. A Neumann row is a slope already and takes the weight without 1/r².
#[inline(always)]
pub(crate) fn weight(r2: f64) -> f64 {
    bell(r2) / (r2 + 0.1)
}

/// (1 − q)³ (1 + 3 q) = 1 − 6 q² + 8 q³ − 3 q⁴.
#[inline(always)]
pub(crate) fn bell(r2: f64) -> f64 {
    let q = r2.sqrt() * (1.0 / RADIUS);
    let p = (1.0 - q).max(0.0);
    p * p * p * (1.0 + 3.0 * q)
}

/// B(d).
#[inline(always)]
pub(crate) fn basis(d: Vector2<f64>) -> [f64; 5] {
    [d.x, d.y, 0.5 * d.x * d.x, d.x * d.y, 0.5 * d.y * d.y]
}

/// n·∇B(d), times the spacing.
#[inline(always)]
pub(crate) fn normal_derivative(d: Vector2<f64>, n: Vector2<f64>) -> [f64; 5] {
    [n.x, n.y, n.x * d.x, n.x * d.y + n.y * d.x, n.y * d.y]
}

#[inline(always)]
pub(crate) fn dot(a: &[f64; 5], b: &[f64; 5]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4]
}

/// A value row: a neighbouring particle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ValueRow {
    pub(crate) basis: [f64; 5],
    pub(crate) weight: f64,
    /// The neighbour.
    pub(crate) index: u32,
}

/// A wall row: an active wall particle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallRow {
    pub(crate) basis: [f64; 5],
    pub(crate) slope: [f64; 5],
    pub(crate) normal: Vector2<f64>,
    /// Part with which it enters; see [`crate::walls::Walls::part`].
    pub(crate) part: f64,
    /// The wall particle.
    pub(crate) index: u32,
}

impl WallRow {
    /// Squared distance from the centre, in spacings squared.
    #[inline(always)]
    fn distance2(&self) -> f64 {
        self.basis[0] * self.basis[0] + self.basis[1] * self.basis[1]
    }
}

/// The rows around one particle.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    pub(crate) values: Vec<ValueRow>,
    pub(crate) walls: Vec<WallRow>,
}

/// Functionals of a pressure fit: each derivative is its dot product with
/// Σ w B Δp + Σ w N q dx. Derivatives are per spacing and spacing².
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PressureFit {
    pub(crate) gradient_x: [f64; 5],
    pub(crate) gradient_y: [f64; 5],
    pub(crate) laplacian: [f64; 5],
}

/// Coefficients of a velocity fit and how far its centre lies off it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct VelocityFit {
    pub(crate) u: [f64; 5],
    pub(crate) v: [f64; 5],
    /// Smooth value minus value at the centre; zero for any quadratic field that meets the walls.
    pub(crate) roughness: Vector2<f64>,
}

/// Quality of a fit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Quality {
    /// Quadratic.
    #[default]
    Quadratic,
    /// Linear: the neighbours do not resolve second derivatives.
    Linear,
    /// No fit at all.
    None,
}

/// Factorizes `matrix`, as a quadratic fit if it can be, else as a linear one. `seconds` are the
/// indices of second derivatives.
#[inline(always)]
fn factorize<const N: usize>(
    matrix: Symmetric<N>,
    seconds: &[usize],
) -> (Option<Factor<N>>, Quality) {
    if let Some(factor) = matrix.factorize(PIVOT_THRESHOLD) {
        return (Some(factor), Quality::Quadratic);
    }
    let mut linear = matrix;
    let trace: f64 = (0..N).map(|i| matrix.0[i][i]).sum();
    for &i in seconds {
        linear.0[i][i] += LINEAR_FALLBACK * trace;
    }
    match linear.factorize(PIVOT_THRESHOLD) {
        Some(factor) => (Some(factor), Quality::Linear),
        None => (None, Quality::None),
    }
}

impl Rows {
    /// Fits pressure and velocity. `velocity_change(j)` is u_j − u_i and `wall_excess(w)` is
    /// n·(U_w − u_i).
    #[inline(always)]
    pub(crate) fn fit(
        &self,
        velocity_change: impl Fn(u32) -> Vector2<f64>,
        wall_excess: impl Fn(&WallRow) -> f64,
    ) -> (PressureFit, VelocityFit, Quality) {
        let mut values = Symmetric::<5>::zero();
        let mut rhs_u = [0.0; 5];
        let mut rhs_v = [0.0; 5];
        for row in &self.values {
            values.add_outer(row.weight, &row.basis);
            let change = row.weight * velocity_change(row.index);
            for k in 0..5 {
                rhs_u[k] += row.basis[k] * change.x;
                rhs_v[k] += row.basis[k] * change.y;
            }
        }
        let mut pressure = values;
        for row in &self.walls {
            pressure.add_outer(row.part * WALL_WEIGHT * bell(row.distance2()), &row.slope);
        }
        let (factor, quality) = factorize(pressure, &[2, 3, 4]);
        let Some(factor) = factor else {
            return (PressureFit::default(), VelocityFit::default(), Quality::None);
        };
        let pressure_fit = PressureFit {
            gradient_x: factor.solve(&[1.0, 0.0, 0.0, 0.0, 0.0]),
            gradient_y: factor.solve(&[0.0, 1.0, 0.0, 0.0, 0.0]),
            laplacian: factor.solve(&[0.0, 0.0, 1.0, 0.0, 1.0]),
        };
        let velocity = if self.walls.is_empty() {
            let (u, v) = (factor.solve(&rhs_u), factor.solve(&rhs_v));
            let mut roughness = Vector2::zeros();
            let mut total = 0.0;
            for row in &self.values {
                let change = velocity_change(row.index);
                let misfit =
                    Vector2::new(change.x - dot(&row.basis, &u), change.y - dot(&row.basis, &v));
                roughness += row.weight * misfit;
                total += row.weight;
            }
            VelocityFit { u, v, roughness: roughness / total }
        } else {
            self.fit_velocity_at_walls(velocity_change, wall_excess)
        };
        (pressure_fit, velocity, quality)
    }

    /// Both velocity components at once, since a wall's row holds both; the value at the centre
    /// is free too, so that it is drawn to what the wall demands.
    #[inline(never)]
    fn fit_velocity_at_walls(
        &self,
        velocity_change: impl Fn(u32) -> Vector2<f64>,
        wall_excess: impl Fn(&WallRow) -> f64,
    ) -> VelocityFit {
        let mut values = Symmetric::<6>::zero();
        let mut rhs = [0.0; 12];
        let with_value = |b: &[f64; 5]| [1.0, b[0], b[1], b[2], b[3], b[4]];
        for row in &self.values {
            let full = with_value(&row.basis);
            values.add_outer(row.weight, &full);
            let change = row.weight * velocity_change(row.index);
            for k in 0..6 {
                rhs[k] += full[k] * change.x;
                rhs[k + 6] += full[k] * change.y;
            }
        }
        values.0[0][0] += CENTRE_WEIGHT;
        let mut matrix = Symmetric::<12>::zero();
        for i in 0..6 {
            for j in 0..=i {
                matrix.0[i][j] = values.0[i][j];
                matrix.0[i + 6][j + 6] = values.0[i][j];
            }
        }
        for row in &self.walls {
            let full = with_value(&row.basis);
            let mut both = [0.0; 12];
            for k in 0..6 {
                both[k] = row.normal.x * full[k];
                both[k + 6] = row.normal.y * full[k];
            }
            let weight = row.part * weight(row.distance2());
            matrix.add_outer(weight, &both);
            let excess = weight * wall_excess(row);
            for k in 0..12 {
                rhs[k] += both[k] * excess;
            }
        }
        match factorize(matrix, &[3, 4, 5, 9, 10, 11]).0 {
            Some(factor) => {
                let c = factor.solve(&rhs);
                VelocityFit {
                    u: [c[1], c[2], c[3], c[4], c[5]],
                    v: [c[7], c[8], c[9], c[10], c[11]],
                    roughness: Vector2::new(c[0], c[6]),
                }
            }
            None => VelocityFit::default(),
        }
    }
}
