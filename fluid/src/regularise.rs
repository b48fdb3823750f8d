//! Keeping particles regular: shifts towards an even arrangement.
//!
//! Inner particles repel each other, the row on the surface and their mirror images in walls over
//! less than two spacings, so that an even arrangement is at rest wherever it ends. Surface
//! particles move along the surface only, to even out their distances. A shift takes the
//! velocity along with the quadratic fit, so that it is a change of sampling points, not of the
//! flow.

use crate::fields::Fields;
use crate::fit::{self, Rows};
use crate::geometry::capped;
use crate::lanes::Number;
use crate::small_matrix::Symmetric;
use nalgebra::Vector2;

/// Range of the repulsion in spacings: below two, so that the row under the surface sees as much
/// above as below.
const RANGE: f64 = 1.8;
/// Sum of (1 − r/range)² over the neighbours in a square lattice: 4 at 1 and 4 at √2 spacings.
const LATTICE_CLOSENESS: f64 = 0.9739;
/// Shift a step of a pair at contact, in spacings.
const STRENGTH: f64 = 0.1;
/// The same among surface particles, which have fewer neighbours and must not crowd.
const SURFACE_STRENGTH: f64 = 0.5;
/// A surface neighbour closer than this along the surface, in spacings, says nothing of its shape.
const CLOSEST: f64 = 0.3;
/// A wall reaches this far beyond its end, in spacings, so that nothing slips out at a corner.
const OVERHANG: f64 = 1e-9;
/// Distance in spacings on either side of a piece's end over which one mirror gives way to the next, the last
/// of a face to none.
const OVERLAP: f64 = 0.25;
/// Distance in spacings before a wall over which what is mirrored in it comes in. What stands behind its plane, around a
/// corner, has no image: that would be in the water.
const BEFORE: f64 = 0.2;
/// A particle further behind a wall than this, in spacings, is on the other side of what it bounds.
const DEEPEST: f64 = -1.0;
/// Walls whose normals differ by less than this (cosine) count as one.
const SAME_WALL: f64 = 0.7;
/// No particle stays nearer to a wall than this, in spacings.
const NEAREST: f64 = 0.2;
/// See [`collide`].
const APPROACH_STEPS: f64 = 5.0;
/// See [`collision`].
const COLLISION_STEPS: f64 = 20.0;
/// Distance of particles that have met, in spacings.
const TOGETHER: f64 = 0.7;
/// Particles further apart than this, in spacings, do not collide.
pub(crate) const COLLISION_RANGE: f64 = 1.5;
/// Longest shift a step, in spacings.
const LONGEST: f64 = 0.05;

/// How near the nearest wall is, in spacings, with its normal and its normal velocity (m/s).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    pub(crate) distance: f64,
    pub(crate) normal: Vector2<f64>,
    pub(crate) wall_velocity: f64,
}

/// The nearest wall that the particle stands before and, in a corner, the nearest of another
/// direction.
pub(crate) fn contacts(fields: Fields, rows: &Rows) -> [Option<Contact>; 2] {
    let mut contacts: [Option<Contact>; 2] = [None; 2];
    for wall in rows.walls.iter().chain(&rows.dry_walls) {
        let d = Vector2::new(wall.basis[0], wall.basis[1]);
        let Some((distance, beyond)) = foot(fields, d, wall.normal, wall.index) else { continue };
        if beyond > OVERHANG {
            continue;
        }
        let wall_velocity = fields.walls.velocity[wall.index as usize].dot(&wall.normal);
        let found = Contact { distance, normal: wall.normal, wall_velocity };
        let same = |known: &Contact| known.normal.dot(&found.normal) > SAME_WALL;
        let nearer = |known: &Option<Contact>| known.is_none_or(|known| distance < known.distance);
        let place = contacts.iter().position(|known| known.as_ref().is_none_or(same));
        if let Some(contact) = place.map(|place| &mut contacts[place])
            && nearer(contact)
        {
            *contact = Some(found);
        }
    }
    contacts
}

/// Velocity and displacement (m) after contact: a particle does not approach a wall faster than
/// would bring it there in [`APPROACH_STEPS`] steps, so that none passes through, and one that has
/// come too near, or behind it, comes back. Away from walls, or where a wall's condition is met as it should be, this
/// does nothing.
pub(crate) fn collide(
    mut velocity: Vector2<f64>,
    contacts: [Option<Contact>; 2],
    spacing: f64,
    h: f64,
) -> (Vector2<f64>, Vector2<f64>) {
    let mut back = Vector2::zeros();
    for contact in contacts.into_iter().flatten() {
        let approach = contact.wall_velocity - velocity.dot(&contact.normal);
        let allowed = contact.distance.max(0.0) * spacing / (APPROACH_STEPS * h);
        velocity += contact.normal * (approach - allowed).max(0.0);
        back -= contact.normal * ((contact.distance - NEAREST).min(0.0) * spacing / APPROACH_STEPS);
    }
    (velocity, back)
}

/// Change of velocity (m/s) by collisions: a neighbour at `distance` (spacings) in direction `ahead`
/// that is approached at `approach` (m/s). Two particles do not approach each other faster than
/// would bring them together in [`COLLISION_STEPS`] steps; what is more they lose to each other in
/// equal parts, as in a blow without rebound. In smooth flow neighbours approach a hundred times
/// slower and this does nothing; in spray and where jets meet, where no fit resolves the pressure,
/// it keeps particles apart, conserves momentum and takes energy.
pub(crate) fn collision(
    ahead: Vector2<f64>,
    distance: f64,
    approach: f64,
    pace: f64,
) -> Vector2<f64> {
    let allowed = (distance - TOGETHER).max(0.0) * pace / COLLISION_STEPS;
    ahead * (-0.5 * (approach - allowed).max(0.0))
}

/// Distance of the centre to the wall particle's piece, and how far the foot of the perpendicular is beyond the
/// piece's end, less than nought between its ends, both in spacings.
fn foot(fields: Fields, d: Vector2<f64>, normal: Vector2<f64>, w: u32) -> Option<(f64, f64)> {
    let distance = -d.dot(&normal);
    let beside = (d + distance * normal).norm();
    let half_piece = 0.5 * fields.walls.length[w as usize] / fields.spacing;
    (distance > DEEPEST).then_some((distance, beside - half_piece))
}

/// Part of the filter's rate for particle `i`: more on the surface, where short waves would grow,
/// less at walls, where the filter rounds off the flow around corners, which a body feels as
/// damping and added mass.
pub(crate) fn filter(fields: Fields, i: usize, rows: &Rows) -> f64 {
    const ON_SURFACE: f64 = 3.0;
    const AT_WALLS: f64 = 0.25;
    if fields.on_surface[i] {
        ON_SURFACE
    } else if rows.walls.is_empty() || rows.values.on_surface().contains(&true) {
        1.0
    } else {
        AT_WALLS
    }
}

/// What the smooth surface has more than a particle on it.
pub(crate) struct AlongSurface {
    /// Height, in spacings along the normal.
    pub(crate) height: f64,
    /// Velocity, m/s.
    pub(crate) velocity: Vector2<f64>,
}

/// How surface particle `i` differs from parabolas along the surface that fit height and velocity of
/// its neighbours on the surface and, with the weight of the nearest, its own. `None` at its end:
/// parabolas would be carried on from one side.
///
/// A fit over all neighbours would have them on one side only, so that the growth of waves towards
/// the surface, e^(kz), counts as roughness, of one sign in crests and the other in troughs. As
/// crests are faster than troughs, taking it away drives a current against the waves, which came to
/// three times the drift of Stokes at the surface of short steep waves.
pub(crate) fn along_surface(fields: Fields, i: usize, rows: &Rows) -> Option<AlongSurface> {
    let normal = fields.normal[i];
    let tangent = Vector2::new(normal.y, -normal.x);
    let mut matrix = Symmetric::<3>::zero();
    let mut rhs = [[0.0; 3]; 3];
    let mut add = |weight: f64, x: f64, data: [f64; 3]| {
        let row = [1.0, x, x * x];
        matrix.add_outer(weight, &row);
        for (rhs, data) in rhs.iter_mut().zip(data) {
            for (sum, value) in rhs.iter_mut().zip(row) {
                *sum += weight * value * data;
            }
        }
    };
    add(fit::bell(0.0), 0.0, [0.0; 3]);
    let mut sides = [0; 2];
    for k in (0..rows.values.len()).filter(|&k| rows.values.on_surface()[k]) {
        let (d, u) = (rows.values.offset(k), rows.values.velocity(k));
        add(fit::bell(d.norm_squared()), d.dot(&tangent), [d.dot(&normal), u.x, u.y]);
        sides[usize::from(d.dot(&tangent) > 0.0)] += 1;
    }
    if sides[0] == 0 || sides[1] == 0 || sides[0] + sides[1] < 3 {
        return None;
    }
    let factor = matrix.factorize(1e-3)?;
    let [height, u, v] = rhs.map(|rhs| factor.solve(&rhs)[0]);
    let height = height.clamp(-LONGEST, LONGEST);
    Some(AlongSurface { height, velocity: Vector2::new(u, v) })
}

/// Shift of particle `i` in spacings, and how crowded it is: the density around it relative to a
/// lattice's; 1 on the surface.
#[inline(always)]
pub(crate) fn shift(fields: Fields, i: usize, rows: &Rows) -> (Vector2<f64>, f64) {
    if fields.on_surface[i] {
        return (capped(spread_along_surface(fields, i, rows), LONGEST), 1.0);
    }
    let (push, closeness) = repulsion(fields, rows, false);
    inner_shift(push, closeness)
}

/// [`shift`] of an inner particle by the `push` of the particles around it and their `closeness`.
#[inline(always)]
pub(crate) fn inner_shift(push: Vector2<f64>, closeness: f64) -> (Vector2<f64>, f64) {
    (capped(STRENGTH * push, LONGEST), closeness / LATTICE_CLOSENESS)
}

/// Part of a particle's crowding that another at the `offset` (m) makes.
pub(crate) fn crowding(offset: Vector2<f64>, spacing: f64) -> f64 {
    push(offset.x / spacing, offset.y / spacing).1 / LATTICE_CLOSENESS
}

/// Push in spacings of a particle at offset (x, y), and how close it is, (1 − r/range)².
#[inline(always)]
pub(crate) fn push<T: Number>(x: T, y: T) -> ([T; 2], T) {
    // One at the same place pushes nowhere.
    let r = (x * x + y * y).larger(T::of(f64::MIN_POSITIVE)).sqrt();
    let near = (T::of(1.0) - r / T::of(RANGE)).larger(T::of(0.0));
    let closeness = near * near;
    let force = closeness / r;
    ([-x * force, -y * force], closeness)
}

/// Push of the neighbours, or of those on the surface only, and of mirror images in walls, in
/// spacings; and the sum of (1 − r/range)², how close they are.
fn repulsion(fields: Fields, rows: &Rows, of_surface_only: bool) -> (Vector2<f64>, f64) {
    let values = &rows.values;
    let pushing = || (0..values.len()).filter(|&k| values.on_surface()[k] || !of_surface_only);
    let mut sum = Vector2::zeros();
    let mut close = 0.0;
    let mut add = |d: Vector2<f64>, part: f64| {
        let (force, closeness) = push(d.x, d.y);
        close += part * closeness;
        sum += part * Vector2::from(force);
    };
    pushing().for_each(|k| add(values.offset(k), 1.0));
    // A wall acts as a mirror: the particle's own image and those of its neighbours.
    for wall in rows.walls.iter().chain(&rows.dry_walls) {
        let d = Vector2::new(wall.basis[0], wall.basis[1]);
        let Some((distance, beyond)) = foot(fields, d, wall.normal, wall.index) else { continue };
        let met = ((OVERLAP - beyond) / (2.0 * OVERLAP)).clamp(0.0, 1.0);
        if met == 0.0 || distance > RANGE {
            continue;
        }
        add(-2.0 * distance * wall.normal, met);
        for d in pushing().map(|k| values.offset(k)) {
            let height = distance + d.dot(&wall.normal);
            let before = (height / BEFORE).clamp(0.0, 1.0);
            add(d - 2.0 * height * wall.normal, met * before * before * (3.0 - 2.0 * before));
        }
    }
    (sum, close)
}

/// Shift along the surface: the push of other surface particles, followed along the parabola
/// through the nearest on either side.
fn spread_along_surface(fields: Fields, i: usize, rows: &Rows) -> Vector2<f64> {
    let normal = fields.normal[i];
    let tangent = Vector2::new(normal.y, -normal.x);
    let (push, _) = repulsion(fields, rows, true);
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
