//! Filling in the defaults that follow from other keys.

use super::{BodyKeys, CaseKeys, wave_plan};
use crate::geometry;
use nalgebra::{Point2, Vector2};

/// Default time step over particle spacing, s/m: that of the reference (Ma et al. 2024).
const TIME_STEP_PER_SPACING: f64 = 0.1;

/// Time step (s) for a particle spacing (m) where a case names none.
pub(super) fn default_time_step(particle_spacing: f64) -> f64 {
    TIME_STEP_PER_SPACING * particle_spacing
}

/// The same case with nothing left to a default.
pub(super) fn resolve(mut keys: CaseKeys) -> CaseKeys {
    let spacing = keys.numerics.particle_spacing_m;
    keys.numerics.time_step_s.get_or_insert(default_time_step(spacing));
    wave_plan::resolve(&mut keys);
    keys.coupling = keys.coupling.resolve(keys.pressure.tolerance);
    // Fairleads move with the frames of the shapes, to the centres of mass.
    for line in &mut keys.mooring {
        if let Some(body) = keys.body.iter().find(|body| body.name == line.body) {
            line.fairlead_m = (Vector2::from(line.fairlead_m) - centre_of_mass(body)).into();
        }
    }
    // So do the probes on bodies.
    for probe in &mut keys.probe {
        if let Some(body) = keys.body.iter().find(|body| Some(&body.name) == probe.body.as_ref()) {
            let centre = centre_of_mass(body);
            (probe.x_m, probe.y_m) = (probe.x_m - centre.x, probe.y_m - centre.y);
        }
    }
    keys.body = keys.body.into_iter().map(resolve_body).collect();
    keys
}

/// Shape as counter-clockwise corners, mass and inertia as numbers.
fn resolve_body(mut body: BodyKeys) -> BodyKeys {
    let corners = corners(&body);
    if let Some(density) = body.density_kg_m3.take() {
        let integrals = geometry::area_integrals(&corners);
        body.mass_kg_m = Some(density * integrals.area);
        body.inertia_kg_m2_m = Some(density * integrals.polar_moment);
    }
    body.centre_of_mass_m = None;
    body.rectangle = None;
    body.corners_m = Some(corners.iter().map(|corner| [corner.x, corner.y]).collect());
    body.equilibrium_m.get_or_insert(body.position_m);
    body
}

/// Corners of a body relative to its centre of mass, counter-clockwise, m.
pub(super) fn corners(body: &BodyKeys) -> Vec<Point2<f64>> {
    let mut corners = outline(body);
    if geometry::area_integrals(&corners).area < 0.0 {
        corners.reverse();
    }
    let centre = centre_of_mass(body);
    corners.iter().map(|corner| corner - centre).collect()
}

/// Centre of mass in the frame in which the shape is given, m.
pub(super) fn centre_of_mass(body: &BodyKeys) -> Vector2<f64> {
    match (body.centre_of_mass_m, body.density_kg_m3) {
        (Some(centre), _) => centre.into(),
        (None, Some(_)) => {
            let centroid = geometry::area_integrals(&outline(body)).centroid.coords;
            // A shape that is given about its centroid keeps its bits.
            let extent = outline(body).iter().map(|c| c.coords.norm()).fold(0.0, f64::max);
            if centroid.norm() > 1e-9 * extent { centroid } else { Vector2::zeros() }
        }
        (None, None) => Vector2::zeros(),
    }
}

/// Corners as they are given, m.
fn outline(body: &BodyKeys) -> Vec<Point2<f64>> {
    match (&body.rectangle, &body.corners_m) {
        (Some(rectangle), _) => {
            let (x, y) = (rectangle.width_m / 2.0, rectangle.height_m / 2.0);
            [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| Point2::new(x, y)).to_vec()
        }
        (None, Some(corners)) => corners.iter().map(|[x, y]| Point2::new(*x, *y)).collect(),
        (None, None) => Vec::new(),
    }
}
