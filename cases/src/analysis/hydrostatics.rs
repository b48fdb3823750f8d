//! Exact hydrostatic load on a polygon: the part below the waterline (Archimedes).

use crate::geometry::{area_integrals, below};
use nalgebra::Point2;

/// Buoyancy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Buoyancy {
    /// Upward force, N/m.
    pub force: f64,
    /// Moment about the reference point, counter-clockwise, N m/m.
    pub moment: f64,
}

/// Buoyancy of the outline `corners` (m, counter-clockwise) in still water of density `density`
/// (kg/m³) whose surface is at `level` (m), with the moment about `reference` (m).
#[must_use]
pub fn buoyancy(
    corners: &[Point2<f64>],
    level: f64,
    density: f64,
    gravity: f64,
    reference: Point2<f64>,
) -> Buoyancy {
    let wet = area_integrals(&below(corners, level));
    let force = density * gravity * wet.area;
    Buoyancy { force, moment: force * (wet.centroid.x - reference.x) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::placed;
    use nalgebra::Vector2;

    #[test]
    fn wall_sided_formula_of_a_tilted_box() {
        // Inclined about the waterline: righting arm = (BM tan²θ / 2 + GM) sin θ.
        let (width, draft) = (0.3, 0.1f64);
        let corners = [(-0.15, -0.1), (0.15, -0.1), (0.15, 0.1), (-0.15, 0.1)]
            .map(|(x, y)| Vector2::new(x, y));
        let angle = 15f64.to_radians();
        let centre = Point2::new(1.5, 0.4);
        let found = buoyancy(&placed(&corners, centre, angle), 0.4, 1000.0, 9.81, centre);
        let weight = 1000.0 * 9.81 * width * draft;
        assert!((found.force - weight).abs() < 1e-9);
        let metacentric_radius = width.powi(2) / (12.0 * draft);
        let arm = angle.sin()
            * (metacentric_radius - draft / 2.0 + metacentric_radius * angle.tan().powi(2) / 2.0);
        assert!((found.moment + weight * arm).abs() < 1e-9, "{found:?}");
    }
}
