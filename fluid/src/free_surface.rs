//! Which particles lie on the free surface, where it points, and which walls it wets.

use crate::neighbours::{BLOCK, Neighbours};
use crate::walls::Walls;
use nalgebra::{Point2, Vector2};
use rayon::prelude::*;
use std::f64::consts::PI;

/// Directions are looked at within this many spacings.
const SIGHT: f64 = 2.0;
/// Only particles within this many spacings of the last surface are tested: a false surface
/// particle deep in the water would be accelerated at g z / dx.
const REACH: f64 = 1.7;
/// An inner particle that sees an empty angle above this comes to the surface, and a surface
/// particle whose largest empty angle falls below the second leaves it.
const EMERGES: f64 = 140.0 / 180.0 * PI;
const SUBMERGES: f64 = 100.0 / 180.0 * PI;
/// A particle deep in the water that sees an empty angle above this stands beside a hole.
const HOLE: f64 = 100.0 / 180.0 * PI;
/// A wall particle fades out over this many spacings on either side of the local surface.
const WALL_MARGIN: f64 = 0.5;

/// A surface that faces a wall touches it when its particles are this near, in spacings.
const TOUCH: f64 = 0.75;

/// Positions and neighbourhoods that the tests look at.
#[derive(Clone, Copy)]
pub(crate) struct Surroundings<'a> {
    pub(crate) position: &'a [Point2<f64>],
    pub(crate) fluid: &'a Neighbours,
    /// Wall particles around each fluid particle.
    pub(crate) walls: &'a Neighbours,
    pub(crate) spacing: f64,
}

/// Sets `flags` to the particles on the surface, from the surface `last` of the step before.
pub(crate) fn detect(around: Surroundings, wall: &Walls, last: &[bool], flags: &mut [bool]) {
    flags.par_chunks_mut(BLOCK).enumerate().for_each(|(block, flags)| {
        for (local, flag) in flags.iter_mut().enumerate() {
            let i = block * BLOCK + local;
            let near = |j: &&u32| {
                let j = **j as usize;
                last[j]
                    && (around.position[j] - around.position[i]).norm_squared()
                        < (REACH * around.spacing).powi(2)
            };
            *flag = if around.fluid.of(i).is_empty() || last[i] {
                largest_gap(around, wall, i).angle > SUBMERGES
            } else {
                around.fluid.of(i).iter().any(|j| near(&j))
                    && largest_gap(around, wall, i).angle > EMERGES
            };
        }
    });
}

/// Where a hole in the water beside inner particle `i` gets a particle, a spacing away in the middle of
/// the empty angle; `None` where there is none.
pub(crate) fn hole(around: Surroundings, wall: &Walls, i: usize) -> Option<Point2<f64>> {
    let gap = largest_gap(around, wall, i);
    let (sin, cos) = gap.direction.sin_cos();
    (HOLE..2.0 * PI)
        .contains(&gap.angle)
        .then(|| around.position[i] + Vector2::new(cos, sin) * around.spacing)
}

/// An angle without neighbours, rad, and the direction of its middle.
struct Gap {
    angle: f64,
    direction: f64,
}

/// Largest angle without neighbours as particle `i` sees it.
fn largest_gap(around: Surroundings, wall: &Walls, i: usize) -> Gap {
    const MANY: usize = 64;
    let mut angles = [0.0; MANY];
    let mut count = 0;
    let centre = around.position[i];
    let sight = (SIGHT * around.spacing).powi(2);
    let mut see = |d: Vector2<f64>| {
        if d.norm_squared() < sight && count < MANY {
            angles[count] = d.y.atan2(d.x);
            count += 1;
        }
    };
    for &j in around.fluid.of(i) {
        see(around.position[j as usize] - centre);
    }
    for w in around.walls.of(i).iter().map(|&w| w as usize) {
        if wall.activity[w] > 0.5 {
            let d = wall.position[w] - centre;
            see(d);
            // A wall has no holes: right before it, its particles are far apart as seen from here.
            let foot = wall.normal[w] * d.dot(&wall.normal[w]);
            if (d - foot).norm() < 0.5 * wall.length[w] {
                see(foot);
            }
        }
    }
    if count == 0 {
        return Gap { angle: 2.0 * PI, direction: 0.0 };
    }
    let angles = &mut angles[..count];
    angles.sort_unstable_by(f64::total_cmp);
    let between = |from: f64, to: f64| Gap { angle: to - from, direction: 0.5 * (from + to) };
    let around_the_back = between(angles[count - 1], angles[0] + 2.0 * PI);
    angles.windows(2).fold(around_the_back, |largest, pair| {
        if pair[1] - pair[0] > largest.angle { between(pair[0], pair[1]) } else { largest }
    })
}

/// Sets the outward unit normal of each surface particle; elsewhere it is zero.
pub(crate) fn normals(around: Surroundings, flags: &[bool], normal: &mut [Vector2<f64>]) {
    normal.par_chunks_mut(BLOCK).enumerate().for_each(|(block, normal)| {
        for (local, normal) in normal.iter_mut().enumerate() {
            let i = block * BLOCK + local;
            *normal = if flags[i] { outward(around, flags, i) } else { Vector2::zeros() };
        }
    });
}

/// Normal to the principal direction of the surface neighbours, away from the fluid.
fn outward(around: Surroundings, flags: &[bool], i: usize) -> Vector2<f64> {
    let mut inward = Vector2::zeros();
    let (mut xx, mut xy, mut yy) = (0.0, 0.0, 0.0);
    for &j in around.fluid.of(i) {
        let d = (around.position[j as usize] - around.position[i]) / around.spacing;
        let weight = crate::fit::weight(d.norm_squared());
        inward += weight * d;
        if flags[j as usize] {
            xx += weight * d.x * d.x;
            xy += weight * d.x * d.y;
            yy += weight * d.y * d.y;
        }
    }
    if xx + yy == 0.0 {
        return if inward == Vector2::zeros() { Vector2::y() } else { -inward.normalize() };
    }
    let tangent_angle = 0.5 * (2.0 * xy).atan2(xx - yy);
    let normal = Vector2::new(-tangent_angle.sin(), tangent_angle.cos());
    if normal.dot(&inward) > 0.0 { -normal } else { normal }
}

/// Sets which wall particles bound the water and the wetted fraction of each. `fluid` lists the
/// fluid particles around each wall particle.
pub(crate) fn wet(
    around: Surroundings,
    flags: &[bool],
    normal: &[Vector2<f64>],
    fluid: &Neighbours,
    walls: &mut Walls,
) {
    for w in 0..walls.len() {
        let point = walls.position[w];
        let mut nearest = None;
        let mut close = false;
        let mut least = f64::INFINITY;
        for &j in fluid.of(w) {
            let j = j as usize;
            let distance = (around.position[j] - point).norm_squared();
            close |= distance < (1.7 * around.spacing).powi(2);
            if flags[j] && distance < least {
                least = distance;
                nearest = Some(j);
            }
        }
        // The surface as a line through the nearest surface particle: it cuts the piece of wall at
        // `cut` in half lengths from the middle along the direction `down`.
        let tangent = Vector2::new(-walls.normal[w].y, walls.normal[w].x);
        let half = 0.5 * walls.length[w];
        let (height, rise) = match nearest {
            None if close => (f64::NEG_INFINITY, 0.0),
            None => (f64::INFINITY, 0.0),
            Some(s) => {
                let facing = walls.normal[w].dot(&normal[s]).min(0.0);
                let touch = TOUCH * facing * facing * around.spacing;
                ((point - around.position[s]).dot(&normal[s]) - touch, tangent.dot(&normal[s]))
            }
        };
        let activity = (0.5 - height / (2.0 * WALL_MARGIN * around.spacing)).clamp(0.0, 1.0);
        let wetted = if activity == 0.0 {
            0.0
        } else if height.abs() >= half * rise.abs() {
            f64::from(u8::from(height < 0.0))
        } else {
            0.5 * (1.0 - height / (half * rise.abs()))
        };
        walls.activity[w] = activity;
        walls.wetted[w] = wetted;
        walls.wetted_middle[w] = point - tangent * (rise.signum() * half * (1.0 - wetted));
    }
}
