//! The fits reproduce every quadratic field, which is what makes the scheme second order.
//!
//! Reference: the coefficients of the field itself. Offsets are in spacings.

use crate::fit::{
    PressureFit, Quality, Rows, VelocityFit, WALL_WEIGHT, WallRow, basis, bell, dot,
    normal_derivative, weight,
};
use crate::tests::scatter;
use nalgebra::Vector2;

/// Normal equations of a jittered stencil have a condition number of up to about 1e3 (before
/// scaling) and coefficients of order one: this is some hundred roundings.
const ROUNDING: f64 = 1e-11;

/// f(d) = c₀ x + c₁ y + c₂ x²/2 + c₃ x y + c₄ y²/2, the change from the centre.
type Field = [f64; 5];

/// Three fields with no term in common with another: slopes, curvatures and a saddle, all.
const FIELDS: [Field; 3] =
    [[0.7, -1.3, 2.1, -0.4, 0.9], [-0.2, 0.5, -1.7, 1.1, 2.3], [1.9, 0.3, 0.6, -2.2, -0.8]];

/// A wall along which wall particles stand: a point on it and its normal into the fluid.
struct Wall {
    normal: Vector2<f64>,
    distance: f64,
}

/// Bed half a spacing below the centre.
const BED: Wall = Wall { normal: Vector2::new(0.0, 1.0), distance: 0.5 };
/// Side wall just over half a spacing to the left of the centre.
const SIDE: Wall = Wall { normal: Vector2::new(1.0, 0.0), distance: 0.6 };
/// An oblique wall.
const OBLIQUE: Wall = Wall { normal: Vector2::new(0.6, 0.8), distance: 0.4 };

impl Wall {
    /// How far `d` is before the wall.
    fn ahead(&self, d: Vector2<f64>) -> f64 {
        self.normal.dot(&d) + self.distance
    }

    /// Points on the wall within sight of the centre, one a spacing, on the fluid's side of
    /// `others`.
    fn points<'a>(&'a self, others: &'a [Wall]) -> impl Iterator<Item = Vector2<f64>> + 'a {
        let tangent = Vector2::new(-self.normal.y, self.normal.x);
        (-4..4)
            .map(move |k| tangent * (f64::from(k) + 0.3) - self.normal * self.distance)
            .filter(|d| d.norm() < 2.6)
            .filter(|d| others.iter().all(|other| other.ahead(*d) > -1e-9))
    }
}

/// A jittered lattice around the centre, cut off behind `walls`.
fn lattice(jitter: f64, seed: i64, walls: &[Wall]) -> Vec<Vector2<f64>> {
    let mut points = Vec::new();
    for i in -3..=3i64 {
        for j in -3..=3i64 {
            let shift = Vector2::new(scatter(i + 7 * seed, j), scatter(j, i + 11 * seed));
            let d = Vector2::new(i as f64, j as f64) + shift * jitter;
            let inside = walls.iter().all(|wall| wall.ahead(d) > 0.2);
            if (i, j) != (0, 0) && d.norm() < 2.6 && inside {
                points.push(d);
            }
        }
    }
    points
}

fn value(field: &Field, d: Vector2<f64>) -> f64 {
    dot(field, &basis(d))
}

/// The rows of velocity (u, v) at `points`, with `walls` of full part.
fn rows(points: &[Vector2<f64>], walls: &[Wall], u: &Field, v: &Field) -> Rows {
    let mut rows = Rows::default();
    let list: Vec<u32> = (0..points.len() as u32).collect();
    rows.values.gather(&list, |j| {
        let d = points[j];
        (d, Vector2::new(value(u, d), value(v, d)), false)
    });
    for wall in walls {
        for d in wall.points(walls) {
            rows.walls.push(WallRow {
                basis: basis(d),
                slope: normal_derivative(d, wall.normal),
                normal: wall.normal,
                part: 1.0,
                index: 0,
            });
        }
    }
    rows
}

/// Fits with walls that move as the field (u, v) does.
fn fit(rows: &Rows, u: &Field, v: &Field) -> (PressureFit, VelocityFit, Quality) {
    rows.fit(|row| row.normal.x * dot(&row.basis, u) + row.normal.y * dot(&row.basis, v))
}

/// What the functional gives for pressure `field`, the walls' Neumann data being the field's.
fn apply(functional: &[f64; 5], points: &[Vector2<f64>], walls: &[WallRow], field: &Field) -> f64 {
    let inner: f64 = points
        .iter()
        .map(|&d| weight(d.norm_squared()) * dot(functional, &basis(d)) * value(field, d))
        .sum();
    let at_walls: f64 = walls
        .iter()
        .map(|row| {
            let distance2 = row.basis[0].powi(2) + row.basis[1].powi(2);
            let weight = row.part * WALL_WEIGHT * bell(distance2);
            weight * dot(functional, &row.slope) * dot(field, &row.slope)
        })
        .sum();
    inner + at_walls
}

fn close(found: f64, exact: f64, what: &str) {
    assert!((found - exact).abs() < ROUNDING, "{what}: {found}, exact {exact}");
}

/// All functionals on all fields, over ten arrangements of particles before `walls`.
fn reproduces_quadratics(walls: &[Wall]) {
    for seed in 0..10 {
        let points = lattice(0.3, seed, walls);
        let (u, v) = (&FIELDS[0], &FIELDS[1]);
        let rows = rows(&points, walls, u, v);
        assert!(walls.is_empty() || rows.walls.len() >= 4, "the wall is in sight");
        let (pressure, velocity, quality) = fit(&rows, u, v);
        assert_eq!(quality, Quality::Full);
        for field in &FIELDS {
            let gives = |functional| apply(functional, &points, &rows.walls, field);
            close(gives(&pressure.gradient_x), field[0], "dp/dx");
            close(gives(&pressure.gradient_y), field[1], "dp/dy");
            close(gives(&pressure.laplacian), field[2] + field[4], "Laplacian of p");
        }
        for k in 0..5 {
            close(velocity.u[k], u[k], "u");
            close(velocity.v[k], v[k], "v");
        }
        close(velocity.u[0] + velocity.v[1], u[0] + v[1], "divergence of u");
        close(Vector2::from(velocity.roughness).norm(), 0.0, "roughness");
    }
}

#[test]
fn quadratic_fields_are_reproduced_inside() {
    reproduces_quadratics(&[]);
}

#[test]
fn quadratic_fields_are_reproduced_at_a_wall() {
    reproduces_quadratics(&[BED]);
    reproduces_quadratics(&[OBLIQUE]);
}

#[test]
fn quadratic_fields_are_reproduced_in_a_corner() {
    reproduces_quadratics(&[BED, SIDE]);
}

#[test]
fn the_matrix_row_is_the_laplacian() {
    // Row of the pressure matrix: Σ coefficient Δp, and its sum belongs to p = 1 around, 0 inside.
    let points = lattice(0.3, 3, &[]);
    let mut rows = rows(&points, &[], &FIELDS[0], &FIELDS[1]);
    let (pressure, ..) = fit(&rows, &FIELDS[0], &FIELDS[1]);
    let sum = rows.laplacian(&pressure);
    let coefficients = rows.values.coefficients();
    for field in &FIELDS {
        let found: f64 = coefficients.iter().zip(&points).map(|(c, d)| c * value(field, *d)).sum();
        close(found, field[2] + field[4], "Laplacian by the matrix row");
    }
    close(coefficients.iter().sum(), sum, "sum of the row");
    // The five-point stencil has 4, a wide stencil less; a row without diagonal could not be scaled.
    assert!(sum > 0.5, "diagonal {sum}");
}

#[test]
fn a_wall_row_counts() {
    // A wall at odds with the field must be felt, or the tests above show nothing.
    let points = lattice(0.3, 1, &[BED]);
    let (u, v) = (&FIELDS[0], &FIELDS[1]);
    let rows = rows(&points, &[BED], u, v);
    let exact =
        |row: &WallRow| row.normal.x * dot(&row.basis, u) + row.normal.y * dot(&row.basis, v);
    let (_, velocity, _) = rows.fit(|row| exact(row) + 1.0);
    assert!(velocity.roughness[1] > 0.1, "{:?}", velocity.roughness);
}

#[test]
fn a_centre_that_sticks_out_is_rough() {
    // One particle 1 m/s faster than water at rest: smoothing must slow it, by at most all of it.
    let points = lattice(0.3, 2, &[]);
    let list: Vec<u32> = (0..points.len() as u32).collect();
    let mut rows = Rows::default();
    rows.values.gather(&list, |j| (points[j], Vector2::new(-1.0, 0.0), false));
    let (_, velocity, _) = rows.fit(|_| 0.0);
    assert!((-1.0..-0.1).contains(&velocity.roughness[0]), "{:?}", velocity.roughness);
    close(velocity.roughness[1], 0.0, "roughness across");
}

#[test]
fn few_neighbours_leave_a_linear_fit() {
    // A cross resolves no mixed derivative. A linear field is reproduced all the same.
    let points =
        [(1.1, 0.0), (-0.8, 0.0), (0.0, 0.9), (0.0, -1.2), (2.0, 0.0), (0.0, 1.9), (-1.7, 0.0)];
    let points = points.map(|(x, y)| Vector2::new(x, y));
    let (u, v) = ([0.7, -1.3, 0.0, 0.0, 0.0], [0.4, 0.9, 0.0, 0.0, 0.0]);
    let rows = rows(&points, &[], &u, &v);
    let (pressure, velocity, quality) = fit(&rows, &u, &v);
    assert_eq!(quality, Quality::Linear);
    close(apply(&pressure.gradient_x, &points, &[], &u), u[0], "dp/dx");
    close(apply(&pressure.gradient_y, &points, &[], &u), u[1], "dp/dy");
    close(velocity.u[0] + velocity.v[1], u[0] + v[1], "divergence of u");
}

/// Four neighbours along `direction` (rad), up to `off` beside that line.
fn line(direction: f64, off: f64) -> Vec<Vector2<f64>> {
    let along = Vector2::new(direction.cos(), direction.sin());
    let across = Vector2::new(-along.y, along.x);
    [-2, -1, 1, 2].into_iter().map(|s| along * s as f64 + across * (off * scatter(s, 5))).collect()
}

/// The fit of two quadratic fields at neighbours along a line.
fn fit_on_line(direction: f64, off: f64) -> (Vec<f64>, Quality) {
    let (u, v) = (&FIELDS[0], &FIELDS[1]);
    let (pressure, velocity, quality) = fit(&rows(&line(direction, off), &[], u, v), u, v);
    let numbers = pressure.gradient_x.iter().chain(&pressure.gradient_y).chain(&pressure.laplacian);
    let numbers = numbers.chain(&velocity.u).chain(&velocity.v).chain(&velocity.roughness);
    (numbers.copied().collect(), quality)
}

#[test]
fn neighbours_on_a_line_leave_no_fit() {
    for direction in [0.0, 0.3, 0.5 * std::f64::consts::PI, 2.2] {
        let (numbers, quality) = fit_on_line(direction, 0.0);
        assert_eq!(quality, Quality::None, "direction {direction}");
        assert!(numbers.iter().all(|x| *x == 0.0), "{numbers:?}");
    }
    let (_, _, quality) = Rows::default().fit(|_| 0.0);
    assert_eq!(quality, Quality::None, "no neighbour");
}

#[test]
fn neighbours_nearly_on_a_line_leave_no_quadratic_fit() {
    for direction in [0.0, 0.3, 0.5 * std::f64::consts::PI, 2.2] {
        for off in [1e-12, 1e-8, 1e-4, 1e-2] {
            let (numbers, quality) = fit_on_line(direction, off);
            assert_ne!(quality, Quality::Full, "direction {direction}, {off} off the line");
            assert!(numbers.iter().all(|x| x.is_finite()), "{numbers:?}");
        }
    }
}
