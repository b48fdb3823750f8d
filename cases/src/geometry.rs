//! Plane polygons: area, centroid, second moment, clipping at a waterline, intersections.
//!
//! A polygon is a slice of corners, m, not repeated at the end.

use nalgebra::{Point2, Vector2};

/// Integrals over a polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaIntegrals {
    /// Signed area, m²: positive for counter-clockwise corners.
    pub area: f64,
    /// Centroid, m; the origin for an empty polygon.
    pub centroid: Point2<f64>,
    /// Polar second moment of area about the origin, m⁴, signed like the area.
    pub polar_moment: f64,
}

/// Area, centroid and polar moment of a simple polygon, by Green's theorem.
#[must_use]
pub fn area_integrals(corners: &[Point2<f64>]) -> AreaIntegrals {
    let (mut area, mut first, mut polar) = (0.0, Vector2::zeros(), 0.0);
    for (a, b) in edges(corners) {
        let cross = a.x * b.y - b.x * a.y;
        area += cross / 2.0;
        first += (a.coords + b.coords) * (cross / 6.0);
        polar += (a.coords.dot(&a.coords) + a.coords.dot(&b.coords) + b.coords.dot(&b.coords))
            * (cross / 12.0);
    }
    let centroid = if area == 0.0 { Point2::origin() } else { Point2::from(first / area) };
    AreaIntegrals { area, centroid, polar_moment: polar }
}

/// The edges of a polygon, the closing one last.
pub fn edges(corners: &[Point2<f64>]) -> impl Iterator<Item = (Point2<f64>, Point2<f64>)> + '_ {
    corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| (*a, *b))
}

/// Corners given relative to a reference point, placed in the plane.
#[must_use]
pub fn placed(corners: &[Vector2<f64>], position: Point2<f64>, angle: f64) -> Vec<Point2<f64>> {
    let rotation = nalgebra::Rotation2::new(angle);
    corners.iter().map(|corner| position + rotation * corner).collect()
}

/// The part of a polygon at or below `level` (m) (Sutherland & Hodgman 1974).
///
/// A polygon that is cut into several parts comes back as one with coincident edges along the
/// level; its area integrals are still right.
#[must_use]
pub fn below(corners: &[Point2<f64>], level: f64) -> Vec<Point2<f64>> {
    let mut kept = Vec::with_capacity(corners.len() + 2);
    for (a, b) in edges(corners) {
        if a.y <= level {
            kept.push(a);
        }
        if (a.y <= level) != (b.y <= level) {
            kept.push(a + (b - a) * ((level - a.y) / (b.y - a.y)));
        }
    }
    kept
}

/// Whether a point lies inside a polygon (crossing number).
#[must_use]
pub fn contains(corners: &[Point2<f64>], point: Point2<f64>) -> bool {
    let crossings = edges(corners).filter(|(a, b)| {
        (a.y > point.y) != (b.y > point.y)
            && point.x < a.x + (b.x - a.x) * (point.y - a.y) / (b.y - a.y)
    });
    crossings.count() % 2 == 1
}

/// Distance from a point to the outline of a polygon, m.
#[must_use]
pub fn distance_to_outline(corners: &[Point2<f64>], point: Point2<f64>) -> f64 {
    let to_edge = |(a, b): (Point2<f64>, Point2<f64>)| {
        let (along, to) = (b - a, point - a);
        let part = (to.dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
        (to - along * part).norm()
    };
    edges(corners).map(to_edge).fold(f64::INFINITY, f64::min)
}

/// Whether two segments share a point.
#[must_use]
pub fn segments_meet(
    (a, b): (Point2<f64>, Point2<f64>),
    (c, d): (Point2<f64>, Point2<f64>),
) -> bool {
    let side = |p: Point2<f64>, q: Point2<f64>, r: Point2<f64>| (q - p).perp(&(r - p));
    let within = |p: Point2<f64>, q: Point2<f64>, r: Point2<f64>| {
        r.x >= p.x.min(q.x) && r.x <= p.x.max(q.x) && r.y >= p.y.min(q.y) && r.y <= p.y.max(q.y)
    };
    let (c_side, d_side) = (side(a, b, c), side(a, b, d));
    let (a_side, b_side) = (side(c, d, a), side(c, d, b));
    (c_side * d_side < 0.0 && a_side * b_side < 0.0)
        || (c_side == 0.0 && within(a, b, c))
        || (d_side == 0.0 && within(a, b, d))
        || (a_side == 0.0 && within(c, d, a))
        || (b_side == 0.0 && within(c, d, b))
}

/// Whether no edge of a polygon meets another than its neighbours', and no edge is empty.
#[must_use]
pub fn is_simple(corners: &[Point2<f64>]) -> bool {
    let list: Vec<_> = edges(corners).collect();
    let count = list.len();
    if count < 3 || list.iter().any(|(a, b)| a == b) {
        return false;
    }
    for first in 0..count {
        // A neighbour shares a corner by construction; it must not fold back over the edge.
        let (a, b) = list[first];
        let (_, c) = list[(first + 1) % count];
        if (b - a).perp(&(c - b)) == 0.0 && (b - a).dot(&(c - b)) < 0.0 {
            return false;
        }
        for second in first + 2..count {
            let adjacent = first == 0 && second == count - 1;
            if !adjacent && segments_meet(list[first], list[second]) {
                return false;
            }
        }
    }
    true
}

/// Whether two simple polygons share a point.
#[must_use]
pub fn overlap(first: &[Point2<f64>], second: &[Point2<f64>]) -> bool {
    edges(first).any(|a| edges(second).any(|b| segments_meet(a, b)))
        || first.first().is_some_and(|point| contains(second, *point))
        || second.first().is_some_and(|point| contains(first, *point))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(corners: &[[f64; 2]]) -> Vec<Point2<f64>> {
        corners.iter().map(|[x, y]| Point2::new(*x, *y)).collect()
    }

    #[test]
    fn integrals_of_a_rectangle_off_the_origin() {
        let corners = points(&[[1.0, 2.0], [4.0, 2.0], [4.0, 4.0], [1.0, 4.0]]);
        let found = area_integrals(&corners);
        assert!((found.area - 6.0).abs() < 1e-12);
        assert!((found.centroid - Point2::new(2.5, 3.0)).norm() < 1e-12);
        let about_centre = 6.0 * (9.0 + 4.0) / 12.0;
        let steiner = 6.0 * (2.5f64.powi(2) + 9.0);
        assert!((found.polar_moment - about_centre - steiner).abs() < 1e-9);
    }

    #[test]
    fn clipping_keeps_what_is_below() {
        let square = points(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert!((area_integrals(&below(&square, 0.25)).area - 0.25).abs() < 1e-12);
        assert!(below(&square, -1.0).is_empty());
        assert_eq!(below(&square, 2.0), square);
        // A U cut through both arms: two parts, one list.
        let u = points(&[
            [0.0, 0.0],
            [0.0, -2.0],
            [1.0, -2.0],
            [1.0, -1.0],
            [2.0, -1.0],
            [2.0, -2.0],
            [3.0, -2.0],
            [3.0, 0.0],
        ]);
        assert!((area_integrals(&below(&u, -1.5)).area.abs() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn simple_and_crossed_polygons() {
        assert!(is_simple(&points(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])));
        assert!(!is_simple(&points(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]])));
        assert!(!is_simple(&points(&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.0]])));
        assert!(!is_simple(&points(&[[0.0, 0.0], [2.0, 0.0]])));
    }

    #[test]
    fn overlapping_nested_and_separate_polygons() {
        let outer = points(&[[0.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 3.0]]);
        let inner = points(&[[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]]);
        let (inside, outside) = (Point2::new(1.5, 2.5), Point2::new(6.0, 7.0));
        assert!((distance_to_outline(&outer, inside) - 0.5).abs() < 1e-12);
        assert!((distance_to_outline(&outer, outside) - 5.0).abs() < 1e-12);
        let apart = points(&[[4.0, 1.0], [5.0, 1.0], [5.0, 2.0]]);
        assert!(overlap(&outer, &inner) && overlap(&inner, &outer));
        assert!(!overlap(&outer, &apart));
    }
}
