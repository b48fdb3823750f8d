//! The shifts that keep particles even.

use crate::fields::Fields;
use crate::fit::{self, Rows, WallRow};
use crate::neighbours::Neighbours;
use crate::regularise;
use crate::setup::Discretisation;
use crate::tests::scatter;
use crate::walls::{Owner, Walls};
use nalgebra::{Point2, Vector2};

/// The corner at the origin of a body in x < 0, y > 0, in spacings: its wall particles.
fn corner() -> Walls {
    let mut walls = Walls::default();
    for piece in 0..6 {
        let along = f64::from(piece) + 0.5;
        for (place, normal) in
            [(Point2::new(0.0, along), Vector2::x()), (Point2::new(-along, 0.0), -Vector2::y())]
        {
            walls.position.push(place);
            walls.normal.push(normal);
            walls.velocity.push(Vector2::zeros());
            walls.length.push(1.0);
            walls.owner.push(Owner::Boundary(0));
        }
    }
    walls
}

/// Shift of a particle at `centre` among the `others`, in spacings.
fn shift(walls: &Walls, centre: Point2<f64>, others: &[Point2<f64>]) -> Vector2<f64> {
    let (position, velocity) = ([centre], [Vector2::zeros()]);
    let lists = Neighbours::default();
    let fields = Fields {
        position: &position,
        velocity: &velocity,
        on_surface: &[false],
        normal: &[Vector2::y()],
        fluid: &lists,
        wall_lists: &lists,
        walls,
        spacing: 1.0,
        discretisation: Discretisation::Quadratic,
    };
    let mut rows = Rows::default();
    let list: Vec<u32> = (0..others.len() as u32).collect();
    rows.values.gather(&list, |j| (others[j] - centre, Vector2::zeros(), false));
    for (index, (place, normal)) in walls.position.iter().zip(&walls.normal).enumerate() {
        let d = place - centre;
        rows.walls.push(WallRow {
            basis: fit::basis(d),
            slope: fit::normal_derivative(d, *normal),
            normal: *normal,
            part: 1.0,
            index: index as u32,
        });
    }
    regularise::shift(fields, 0, &rows).0
}

/// A jump of the shift is a jump of the water: two runs that differ by rounding would part there.
#[test]
fn a_shift_does_not_jump_on_the_way_around_a_corner() {
    let walls = corner();
    let mut others = Vec::new();
    for i in -5..=5i64 {
        for j in -5..=5i64 {
            let even = Point2::new(i as f64 + 0.5, j as f64 + 0.5);
            let place = even + 0.3 * Vector2::new(scatter(i, j), scatter(j, i + 20));
            if place.x > 0.2 || place.y < -0.2 {
                others.push(place);
            }
        }
    }
    let paths: [(Point2<f64>, Vector2<f64>); 5] = [
        (Point2::new(0.5, 2.0), -Vector2::y()),
        (Point2::new(1.2, 2.0), -Vector2::y()),
        (Point2::new(0.5, 1.0), Vector2::x()),
        (Point2::new(-2.0, -0.6), Vector2::x()),
        (Point2::new(0.4, 0.6), Vector2::new(0.6, -0.8)),
    ];
    const STEP: f64 = 1e-4;
    for (start, direction) in paths {
        let mut last = None;
        for k in 0..30_000 {
            let centre = start + direction * (STEP * f64::from(k));
            // A particle that is met pushes the other way after it.
            let met = others.iter().any(|other| (other - centre).norm() < 0.3);
            let found = (!met).then(|| shift(&walls, centre, &others));
            if let (Some(last), Some(found)) = (last, found) {
                let change: Vector2<f64> = found - last;
                assert!(change.norm() < 10.0 * STEP, "{change} at {centre}");
            }
            last = found;
        }
    }
}
