//! Keeping particles regular: shifts towards an even arrangement.
//!
//! Inner particles repel each other, the row on the surface and their mirror images in walls over
//! less than two spacings, so that an even arrangement is at rest wherever it ends. Surface
//! particles move along the surface only, to even out their distances. A shift takes the
//! velocity along with the quadratic fit, so that it is a change of sampling points, not of the
//! flow.

use crate::fields::Fields;
use crate::fit::Rows;
use nalgebra::Vector2;

/// Range of the repulsion in spacings: below two, so that the row under the surface sees as much
/// above as below.
const RANGE: f64 = 1.8;
/// Shift a step of a pair at contact, in spacings.
const STRENGTH: f64 = 0.1;
/// The same among surface particles, which have fewer neighbours and must not crowd.
const SURFACE_STRENGTH: f64 = 0.5;
/// A surface neighbour closer than this along the surface, in spacings, says nothing of its shape.
const CLOSEST: f64 = 0.3;
/// A particle further behind a wall than this, in spacings, is on the other side of what it bounds.
const DEEPEST: f64 = -1.0;
/// See [`collide`].
const APPROACH_STEPS: f64 = 5.0;
/// Longest shift a step, in spacings.
const LONGEST: f64 = 0.05;

/// How near the nearest wall is, in spacings, with its normal and its normal velocity (m/s).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    pub(crate) distance: f64,
    pub(crate) normal: Vector2<f64>,
    pub(crate) wall_velocity: f64,
}

/// The nearest wall that the particle stands before.
pub(crate) fn contact(fields: Fields, rows: &Rows) -> Option<Contact> {
    let mut nearest: Option<Contact> = None;
    for wall in rows.walls.iter().chain(&rows.dry_walls) {
        let d = Vector2::new(wall.basis[0], wall.basis[1]);
        if let Some(distance) = foot(fields, d, wall.normal, wall.index)
            && nearest.is_none_or(|nearest| distance < nearest.distance)
        {
            let wall_velocity = fields.walls.velocity[wall.index as usize].dot(&wall.normal);
            nearest = Some(Contact { distance, normal: wall.normal, wall_velocity });
        }
    }
    nearest
}

/// Velocity after contact: a particle does not approach a wall faster than would bring it there
/// in [`APPROACH_STEPS`] steps, so that none passes through. Away from walls, or where a wall's
/// condition is met as it should be, this does nothing.
pub(crate) fn collide(
    velocity: Vector2<f64>,
    contact: Option<Contact>,
    spacing: f64,
    h: f64,
) -> Vector2<f64> {
    let Some(contact) = contact else { return velocity };
    let approach = contact.wall_velocity - velocity.dot(&contact.normal);
    let allowed = contact.distance.max(0.0) * spacing / (APPROACH_STEPS * h);
    velocity + contact.normal * (approach - allowed).max(0.0)
}

/// Distance to the wall particle's piece if the perpendicular from the centre meets it.
fn foot(fields: Fields, d: Vector2<f64>, normal: Vector2<f64>, w: u32) -> Option<f64> {
    let distance = -d.dot(&normal);
    let beside = (d + distance * normal).norm();
    let half_piece = 0.5 * fields.walls.length[w as usize] / fields.spacing;
    (beside <= half_piece * (1.0 + 1e-9) && distance > DEEPEST).then_some(distance)
}

/// Shift of particle `i` in spacings.
#[inline(always)]
pub(crate) fn shift(fields: Fields, i: usize, rows: &Rows) -> Vector2<f64> {
    let shift = if fields.on_surface[i] {
        along_surface(fields, i, rows)
    } else {
        STRENGTH * repulsion(fields, rows, false)
    };
    let length = shift.norm();
    if length > LONGEST { shift * (LONGEST / length) } else { shift }
}

/// Push of the neighbours, or of those on the surface only, and of mirror images in walls, in
/// spacings.
fn repulsion(fields: Fields, rows: &Rows, of_surface_only: bool) -> Vector2<f64> {
    let values = &rows.values;
    let pushing = || (0..values.len()).filter(|&k| values.on_surface()[k] || !of_surface_only);
    let mut sum = Vector2::zeros();
    let mut push = |d: Vector2<f64>| {
        let r2 = d.norm_squared();
        if r2 < RANGE * RANGE && r2 > 0.0 {
            let r = r2.sqrt();
            let closeness = 1.0 - r / RANGE;
            sum -= d * (closeness * closeness / r);
        }
    };
    pushing().for_each(|k| push(values.offset(k)));
    // A wall acts as a mirror: the particle's own image and those of its neighbours.
    for wall in rows.walls.iter().chain(&rows.dry_walls) {
        let d = Vector2::new(wall.basis[0], wall.basis[1]);
        let Some(distance) = foot(fields, d, wall.normal, wall.index) else { continue };
        if distance > RANGE {
            continue;
        }
        push(-2.0 * distance * wall.normal);
        for d in pushing().map(|k| values.offset(k)) {
            push(d - 2.0 * (distance + d.dot(&wall.normal)) * wall.normal);
        }
    }
    sum
}

/// Shift along the surface: the push of other surface particles, followed along the parabola
/// through the nearest on either side.
fn along_surface(fields: Fields, i: usize, rows: &Rows) -> Vector2<f64> {
    let normal = fields.normal[i];
    let tangent = Vector2::new(normal.y, -normal.x);
    let push = repulsion(fields, rows, true);
    let along = (SURFACE_STRENGTH * push.dot(&tangent)).clamp(-LONGEST, LONGEST);
    let (mut ahead, mut behind) = (None, None);
    for k in (0..rows.values.len()).filter(|&k| rows.values.on_surface()[k]) {
        let d = rows.values.offset(k);
        let (x, height) = (d.dot(&tangent), d.dot(&normal));
        let side: &mut Option<(f64, f64)> = if x > 0.0 { &mut ahead } else { &mut behind };
        if x.abs() > CLOSEST && side.is_none_or(|(nearest, _)| x.abs() < nearest.abs()) {
            *side = Some((x, height));
        }
    }
    let (Some((a, ha)), Some((b, hb))) = (ahead, behind) else { return tangent * along };
    let curvature = (ha / a - hb / b) / (a - b);
    let slope = ha / a - curvature * a;
    tangent * along + normal * (along * (slope + curvature * along))
}
