//! The function that fits take at corners: against its definition, and fits that must reproduce it.

use crate::corner::Corner;
use crate::fit::{self, Quality, Rows, Singular};
use crate::tests::scatter;
use nalgebra::{Point2, Rotation2, Vector2};
use std::f64::consts::PI;

/// A corner of a body whose inside takes the angle `inside`, turned by `turned`: the body lies to the left of
/// the face along the first direction.
fn corner(inside: f64, turned: f64) -> Corner {
    Corner {
        position: Point2::origin(),
        along: Rotation2::new(turned) * Vector2::x(),
        open: 2.0 * PI - inside,
        faces: [0, 0],
        room: 1.0,
    }
}

/// The other face's direction, and both normals into the water.
fn faces(corner: &Corner) -> [(Vector2<f64>, Vector2<f64>); 2] {
    let first = corner.along;
    let second = Rotation2::new(-corner.open) * first;
    [(first, Rotation2::new(-0.5 * PI) * first), (second, Rotation2::new(0.5 * PI) * second)]
}

const CORNERS: [(f64, f64); 4] =
    [(0.5 * PI, 0.0), (0.5 * PI, 2.1), (PI / 3.0, -1.0), (0.7 * PI, 3.0)];

#[test]
fn its_gradient_is_that_of_the_potential() {
    for (inside, turned) in CORNERS {
        let corner = corner(inside, turned);
        for k in 0..40 {
            // Into the water only: across the body's middle the angle jumps.
            let angle = -corner.open * (0.02 + 0.96 * f64::from(k) / 39.0);
            let r = 0.3 + 0.07 * f64::from(k);
            let d = Rotation2::new(angle) * corner.along * r;
            let slope = |step: Vector2<f64>| {
                (corner.potential(d + step) - corner.potential(d - step)) / (2.0 * step.norm())
            };
            let found = corner.gradient(d);
            let exact = Vector2::new(slope(Vector2::x() * 1e-5), slope(Vector2::y() * 1e-5));
            assert!((found - exact).norm() < 1e-8, "{found} and {exact}");
        }
    }
}

#[test]
fn no_flux_goes_through_the_faces() {
    for (inside, turned) in CORNERS {
        let corner = corner(inside, turned);
        for (along, normal) in faces(&corner) {
            for r in [0.1, 0.5, 1.5, 2.9] {
                let flux = corner.gradient(along * r).dot(&normal);
                assert!(flux.abs() < 1e-12, "{flux} at {r}");
            }
        }
    }
}

#[test]
fn the_potential_is_that_of_a_right_angle() {
    // r^(2/3) cos 2θ/3: 1 along the first face, −1 along the second, 0 in the middle.
    let corner = corner(0.5 * PI, 0.0);
    let at = |angle: f64| corner.potential(Rotation2::new(-angle) * Vector2::x() * 8.0);
    assert!((at(0.0) - 4.0).abs() < 1e-12);
    assert!((at(1.5 * PI) + 4.0).abs() < 1e-12);
    assert!(at(0.75 * PI).abs() < 1e-12);
}

/// Particles around a centre in the water near the corner, without walls: their pressure and velocity are
/// of the function and of a quadratic.
#[test]
fn fits_reproduce_it_beside_quadratics() {
    let corner = corner(0.5 * PI, 0.4);
    for seed in 0..10 {
        let centre = Rotation2::new(-1.3 - 0.2 * f64::from(seed as i32)) * corner.along * 0.9;
        let mut points = Vec::new();
        for i in -3..=3i64 {
            for j in -3..=3i64 {
                let shift = Vector2::new(scatter(i + 7 * seed, j), scatter(j, i + 11 * seed));
                let d = Vector2::new(i as f64, j as f64) + shift * 0.2;
                let x = centre + d;
                let in_water = faces(&corner).iter().any(|(_, normal)| normal.dot(&x) > 0.1);
                if (i, j) != (0, 0) && d.norm() < 2.6 && in_water {
                    points.push(d);
                }
            }
        }
        let (a, b, strength) = ([0.7, -1.3, 2.1, -0.4, 0.9], [-0.2, 0.5, -1.7, 1.1, 2.3], 1.7);
        let own = corner.gradient(centre);
        let mut rows = Rows::default();
        let list: Vec<u32> = (0..points.len() as u32).collect();
        rows.values.gather(&list, |j| {
            let basis = fit::basis(points[j]);
            let quadratic = Vector2::new(fit::dot(&a, &basis), fit::dot(&b, &basis));
            let singular = (corner.gradient(centre + points[j]) - own) * strength;
            (points[j], quadratic + singular, false)
        });
        rows.singular = Some(Singular::new(&rows.values, &corner, 0, -centre, 0.0));
        let (pressure, _, quality) = rows.fit(|_| 0.0);
        assert_eq!(quality, Quality::Full);
        // p = a·B + strength S, of which the corner's part is harmonic.
        let potential = |d: Vector2<f64>| corner.potential(centre + d) - corner.potential(centre);
        let apply = |row: &[f64; 5], singular: f64| -> f64 {
            let term = |d: &Vector2<f64>| {
                let basis = fit::basis(*d);
                let p = fit::dot(&a, &basis) + strength * potential(*d);
                let of_row = fit::dot(row, &basis) + singular * potential(*d);
                fit::weight(d.norm_squared()) * of_row * p
            };
            points.iter().map(term).sum()
        };
        let [x, y, laplacian] = pressure.singular;
        let close =
            |found: f64, exact: f64| assert!((found - exact).abs() < 1e-9, "{found}, {exact}");
        close(apply(&pressure.gradient_x, x), a[0] + strength * own.x);
        close(apply(&pressure.gradient_y, y), a[1] + strength * own.y);
        close(apply(&pressure.laplacian, laplacian), a[2] + a[4]);
        // The row of the matrix is the same functional.
        let sum = rows.laplacian(&pressure);
        let coefficients = rows.values.coefficients();
        let by_row: f64 = (coefficients.iter().zip(&points))
            .map(|(c, d)| c * (fit::dot(&a, &fit::basis(*d)) + strength * potential(*d)))
            .sum();
        close(by_row, a[2] + a[4]);
        close(coefficients.iter().sum(), sum);
    }
}

#[test]
fn a_corner_is_felt_the_less_the_further_off_and_the_drier_it_is() {
    let corner = corner(0.5 * PI, 0.0);
    let at = |r: f64, part: f64| corner.restraint(r, part);
    assert!(at(0.1, 1.0).unwrap() < 0.02);
    assert!(at(1.0, 1.0) < at(2.0, 1.0) && at(2.0, 1.0) < at(2.9, 1.0));
    assert!(at(1.0, 1.0) < at(1.0, 0.3));
    assert_eq!(at(3.0, 1.0), None);
    assert_eq!(at(1.0, 0.0), None);
}
