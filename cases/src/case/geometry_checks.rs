//! Checks of how the parts of a scene fit together. They assume that every number is in range.

use super::checks::{Allowed, Checker};
use super::resolve::{centre_of_mass, corners};
use super::source::Source;
use super::{CaseKeys, Problem, moorings};
use crate::geometry::{area_integrals, below, contains, distance_to_outline, is_simple, overlap};
use nalgebra::{Point2, Rotation2};

/// Fewest rows of particles over the depth with which a wave can be told from noise.
const MIN_ROWS: f64 = 4.0;

/// Most particles that a run may have: beyond this the spacing is a mistake.
const MAX_PARTICLES: f64 = 2e7;

/// Distance from its outline, over the size of a body, at which a point lies on it.
const ON_OUTLINE: f64 = 1e-6;

/// Everything that does not fit together.
pub(super) fn check_geometry(keys: &CaseKeys, source: &Source) -> Vec<Problem> {
    let mut check = Checker::new(source);
    let (tank, water) = (&keys.tank, &keys.water);
    check.number("tank.height_m", tank.height_m, Allowed::above(water.depth_m, 1e4));
    let spacing = keys.numerics.particle_spacing_m;
    let finest = (tank.length_m * water.depth_m / MAX_PARTICLES).sqrt();
    let coarsest = (water.depth_m / MIN_ROWS).min(tank.length_m / MIN_ROWS);
    let allowed = Allowed::from(finest, coarsest);
    check.require(allowed.holds(spacing), "numerics.particle_spacing_m", || {
        format!("{spacing} must be {allowed}: particles for {MIN_ROWS} rows, and no more than {MAX_PARTICLES:e}")
    });
    if !check.problems.is_empty() {
        // The distances below are measured in spacings.
        return check.problems;
    }
    let bodies: Vec<_> = keys.body.iter().map(corners).collect();
    let mut placed = Vec::new();
    for (index, (body, corners)) in keys.body.iter().zip(&bodies).enumerate() {
        let key = |name: &str| format!("body[{index}].{name}");
        let shape = key(if body.rectangle.is_some() { "box" } else { "corners_m" });
        let simple = is_simple(corners);
        check.require(simple, &shape, || "the outline must not meet itself".to_owned());
        if !simple {
            continue;
        }
        let rotation = Rotation2::new(body.angle_deg.to_radians());
        let position = Point2::from(body.position_m);
        let outline: Vec<_> = corners.iter().map(|c| position + rotation * c.coords).collect();
        check_outline(&mut check, keys, &key("position_m"), &outline);
        placed.push((index, outline));
    }
    for (nth, (first, outline)) in placed.iter().enumerate() {
        for (second, other) in &placed[nth + 1..] {
            check.require(!overlap(outline, other), &format!("body[{second}].position_m"), || {
                let (a, b) = (&keys.body[*first].name, &keys.body[*second].name);
                format!("{b} overlaps {a}")
            });
        }
    }
    moorings::check_geometry(&mut check, keys);
    for (index, probe) in keys.probe.iter().enumerate() {
        let point = Point2::new(probe.x_m, probe.y_m);
        if let Some(body) = keys.body.iter().find(|body| Some(&body.name) == probe.body.as_ref()) {
            let (outline, place) = (corners(body), point - centre_of_mass(body));
            let size = outline.iter().map(|corner| corner.coords.norm()).fold(0.0, f64::max);
            let inside = contains(&outline, place) != body.holds_water
                && distance_to_outline(&outline, place) > ON_OUTLINE * size;
            check.require(!inside, &format!("probe[{index}].x_m"), || {
                format!("({}, {}) m lies inside {}", probe.x_m, probe.y_m, body.name)
            });
            continue;
        }
        let body = placed
            .iter()
            .find(|(index, outline)| contains(outline, point) != keys.body[*index].holds_water);
        check.require(body.is_none(), &format!("probe[{index}].x_m"), || {
            let name = body.map_or("", |(index, _)| &keys.body[*index].name);
            format!("({}, {}) m lies inside {name}", probe.x_m, probe.y_m)
        });
    }
    check.problems
}

/// A body lies between the walls, above the bed, and at least partly in the water.
fn check_outline(check: &mut Checker<'_>, keys: &CaseKeys, key: &str, outline: &[Point2<f64>]) {
    let spacing = keys.numerics.particle_spacing_m;
    let length = keys.tank.length_m;
    let bounds = outline
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY], |[left, right, bottom], p| {
            [left.min(p.x), right.max(p.x), bottom.min(p.y)]
        });
    let [left, right, bottom] = bounds;
    check.require(left >= spacing && right <= length - spacing, key, || {
        format!(
            "the body reaches from x = {left:.4} to {right:.4} m and overlaps a wall: it must \
             stay one particle spacing off the walls at 0 and {length} m"
        )
    });
    check.require(bottom >= spacing, key, || {
        format!(
            "the body reaches down to y = {bottom:.4} m and overlaps the bed: it must stay one \
             particle spacing off it"
        )
    });
    let depth = keys.water.depth_m;
    check.require(area_integrals(&below(outline, depth)).area > 0.0, key, || {
        format!("the body is outside the water: its lowest point is y = {bottom:.4} m, the still water surface is at {depth} m")
    });
}
