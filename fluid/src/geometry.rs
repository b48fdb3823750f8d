//! Plane polygons.

use nalgebra::{Point2, Rotation2, Vector2};

/// z component of a × b.
#[inline(always)]
pub(crate) fn cross(a: Vector2<f64>, b: Vector2<f64>) -> f64 {
    a.x * b.y - a.y * b.x
}

/// `vector`, or one of length `most` in its direction if it is longer.
#[inline(always)]
pub(crate) fn capped(vector: Vector2<f64>, most: f64) -> Vector2<f64> {
    // nalgebra's norm calls a portable square root, which cannot be worked into the sums around it.
    let size = vector.norm_squared().sqrt();
    if size > most { vector * (most / size) } else { vector }
}

/// Corners of a rigid polygon at a pose.
pub(crate) fn placed(
    corners: &[Vector2<f64>],
    position: Point2<f64>,
    angle: f64,
) -> Vec<Point2<f64>> {
    placed_corners(corners, position, angle).collect()
}

/// As [`placed`], one corner after the other.
pub(crate) fn placed_corners(
    corners: &[Vector2<f64>],
    position: Point2<f64>,
    angle: f64,
) -> impl Iterator<Item = Point2<f64>> + Clone + '_ {
    let rotation = Rotation2::new(angle);
    corners.iter().map(move |corner| position + rotation * corner)
}

/// Area of a polygon, positive when its corners run counter-clockwise, m².
pub(crate) fn signed_area(polygon: &[Point2<f64>]) -> f64 {
    edges(polygon).map(|(a, b)| 0.5 * cross(a.coords, b.coords)).sum()
}

/// Edges from corner to corner, the last to the first included.
pub(crate) fn edges(
    polygon: &[Point2<f64>],
) -> impl Iterator<Item = (Point2<f64>, Point2<f64>)> + '_ {
    polygon.iter().zip(polygon.iter().cycle().skip(1)).map(|(a, b)| (*a, *b))
}

/// Distance to a polygon, negative where it is solid, m: inside, or outside one whose corners run
/// clockwise.
pub(crate) fn signed_distance(polygon: &[Point2<f64>], point: Point2<f64>) -> f64 {
    let mut distance = f64::INFINITY;
    let mut inside = false;
    for (a, b) in edges(polygon) {
        let edge = b - a;
        let along = ((point - a).dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
        distance = distance.min((point - (a + edge * along)).norm());
        if (a.y > point.y) != (b.y > point.y)
            && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
        {
            inside = !inside;
        }
    }
    let solid = inside != (signed_area(polygon) < 0.0);
    if solid { -distance } else { distance }
}

/// The point of the outline nearest to `point`, and the outward unit normal of the edge that it is
/// on, for a polygon whose corners run counter-clockwise. `None` for one without an edge.
pub(crate) fn nearest_on_outline(
    polygon: &[Point2<f64>],
    point: Point2<f64>,
) -> Option<(Point2<f64>, Vector2<f64>)> {
    let foot = |(a, b): (Point2<f64>, Point2<f64>)| {
        let edge = b - a;
        let along = ((point - a).dot(&edge) / edge.norm_squared()).clamp(0.0, 1.0);
        (a + edge * along, Vector2::new(edge.y, -edge.x) / edge.norm())
    };
    let distance = |(foot, _): &(Point2<f64>, Vector2<f64>)| (point - foot).norm_squared();
    edges(polygon).map(foot).min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Area of the part of a polygon below the line through `left` and `right`, m².
pub(crate) fn area_below(
    polygon: impl Iterator<Item = Point2<f64>> + Clone,
    left: Point2<f64>,
    right: Point2<f64>,
) -> f64 {
    let height = |p: Point2<f64>| cross(right - left, p - left);
    // Each edge's part below the line, as a triangle with a corner on the line: the parts of the
    // line itself then add nothing.
    let next = polygon.clone().cycle().skip(1);
    polygon
        .zip(next)
        .map(|(a, b)| {
            let (ha, hb) = (height(a), height(b));
            let crossing = || a + (b - a) * (ha / (ha - hb));
            let (a, b) = match (ha <= 0.0, hb <= 0.0) {
                (true, true) => (a, b),
                (true, false) => (a, crossing()),
                (false, true) => (crossing(), b),
                (false, false) => return 0.0,
            };
            0.5 * cross(a - left, b - left)
        })
        .sum()
}

/// Whether two edges of the polygon that are not neighbours meet.
pub(crate) fn crosses_itself(polygon: &[Point2<f64>]) -> bool {
    let n = polygon.len();
    let side = |a: Point2<f64>, b: Point2<f64>, p: Point2<f64>| cross(b - a, p - a);
    (0..n).any(|i| {
        let (a, b) = (polygon[i], polygon[(i + 1) % n]);
        (i + 2..n).filter(|j| (j + 1) % n != i).any(|j| {
            let (c, d) = (polygon[j], polygon[(j + 1) % n]);
            side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Vec<Point2<f64>> {
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
            .iter()
            .map(|&(x, y)| Point2::new(x, y))
            .collect()
    }

    #[test]
    fn measures_of_the_unit_square() {
        let square = square();
        assert!((signed_area(&square) - 1.0).abs() < 1e-15);
        assert!((signed_distance(&square, Point2::new(0.5, 0.9)) + 0.1).abs() < 1e-15);
        assert!((signed_distance(&square, Point2::new(2.0, 2.0)) - 2f64.sqrt()).abs() < 1e-15);
        let (foot, normal) = nearest_on_outline(&square, Point2::new(0.9, 0.4)).unwrap();
        assert!((foot - Point2::new(1.0, 0.4)).norm() < 1e-15, "{foot}");
        assert_eq!(normal, Vector2::x());
        let below =
            area_below(square.iter().copied(), Point2::new(-1.0, 0.0), Point2::new(2.0, 1.5));
        assert!((below - 0.75).abs() < 1e-12, "{below}");
        assert!(!crosses_itself(&square));
        let mut bow = square.clone();
        bow.swap(1, 2);
        assert!(crosses_itself(&bow));
    }
}
