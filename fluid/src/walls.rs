//! Wall particles: one layer on the surface of the tank and of every rigid boundary itself.
//!
//! Each wall particle stands at the middle of its piece of an edge, so that none lies on a
//! corner, every normal is that of an edge, and lengths add up to the true perimeter.

use crate::corner::{Corner, REACH};
use crate::geometry::{cross, edges, signed_area};
use crate::setup::FluidSetup;
use nalgebra::{Point2, Rotation2, Vector2};
use seakeep_coupler::interface::BoundaryKinematics;

/// Distance in spacings over which a wall fades out for particles from before to behind it.
const BEHIND: f64 = 0.3;

/// A corner flatter than this, rad, is left to the polynomials: its function is nearly linear.
const FLATTEST: f64 = 2.6;

/// What a wall particle belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Owner {
    /// The fixed tank.
    Tank,
    /// The rigid boundary of this index.
    Boundary(usize),
}

/// The wall particles, as a structure of arrays.
#[derive(Clone, Debug, Default)]
pub(crate) struct Walls {
    /// Position, m.
    pub(crate) position: Vec<Point2<f64>>,
    /// Unit normal into the fluid.
    pub(crate) normal: Vec<Vector2<f64>>,
    /// Velocity of the wall's material, m/s.
    pub(crate) velocity: Vec<Vector2<f64>>,
    /// Length of the piece of wall, m.
    pub(crate) length: Vec<f64>,
    /// What it belongs to.
    pub(crate) owner: Vec<Owner>,
    /// Reference point of each rigid boundary, m.
    pub(crate) centre: Vec<Point2<f64>>,
    /// Middle of the wetted part, m.
    pub(crate) wetted_middle: Vec<Point2<f64>>,
    /// Wetted fraction of the piece, from 0 (dry) to 1.
    pub(crate) wetted: Vec<f64>,
    /// From 0 for a piece in the air to 1 for one that bounds the fluid: the part with which its
    /// conditions enter nearby fits.
    pub(crate) activity: Vec<f64>,
    /// Position and normal in the boundary's own frame (for the tank: in space).
    reference: Vec<(Vector2<f64>, Vector2<f64>)>,
    /// First particle of each rigid boundary, and the number of all.
    first: Vec<usize>,
    /// Corners of the rigid boundaries that stand out into the water.
    pub(crate) corners: Vec<Corner>,
    /// Boundary, place and face of each in the boundary's own frame.
    reference_corners: Vec<(usize, Vector2<f64>, Vector2<f64>)>,
    /// Left and right end of the tank, and the reach of a corner, m.
    ends: (f64, f64),
    reach: f64,
}

impl Walls {
    /// Lays wall particles over the tank and the boundaries of `setup`.
    pub(crate) fn new(setup: &FluidSetup) -> Self {
        let mut walls = Self::default();
        let (left, length, height) = (-setup.behind(), setup.tank.length, setup.tank.height);
        let tank = [
            (Vector2::new(left, height), Vector2::new(left, 0.0)),
            (Vector2::new(left, 0.0), Vector2::new(length, 0.0)),
            (Vector2::new(length, 0.0), Vector2::new(length, height)),
        ];
        let spacing = setup.numerics.particle_spacing;
        walls.ends = (left, length);
        walls.reach = REACH * spacing;
        for (a, b) in tank {
            walls.add_edge(a, b, 1.0, Owner::Tank, spacing);
        }
        for (index, boundary) in setup.boundaries.iter().enumerate() {
            walls.first.push(walls.reference.len());
            let corners: Vec<_> = boundary.corners.iter().map(|c| Point2::from(*c)).collect();
            for (a, b) in edges(&corners) {
                walls.add_edge(a.coords, b.coords, -1.0, Owner::Boundary(index), spacing);
            }
            walls.add_corners(index, &corners, spacing);
        }
        walls.first.push(walls.reference.len());
        let count = walls.reference.len();
        walls.position = walls.reference.iter().map(|(arm, _)| Point2::from(*arm)).collect();
        walls.normal = walls.reference.iter().map(|(_, normal)| *normal).collect();
        walls.velocity = vec![Vector2::zeros(); count];
        walls.wetted_middle = walls.position.clone();
        walls.wetted = vec![0.0; count];
        walls.activity = vec![0.0; count];
        walls
    }

    /// `side` is 1 where the fluid lies to the left of the edge, −1 where it lies to the right.
    fn add_edge(&mut self, a: Vector2<f64>, b: Vector2<f64>, side: f64, owner: Owner, dx: f64) {
        let edge = b - a;
        let pieces = (edge.norm() / dx).round().max(1.0);
        let normal = side * Vector2::new(-edge.y, edge.x) / edge.norm();
        for piece in 0..pieces as usize {
            self.reference.push((a + edge * ((piece as f64 + 0.5) / pieces), normal));
            self.length.push(edge.norm() / pieces);
            self.owner.push(owner);
        }
    }

    /// Finds the corners of boundary `index` that stand out into the water, whose wall particles have
    /// just been laid. One whose faces are shorter than it reaches is left to the polynomials.
    fn add_corners(&mut self, index: usize, corners: &[Point2<f64>], spacing: f64) {
        // A container has the water inside.
        if signed_area(corners) < 0.0 {
            return;
        }
        let pieces: Vec<usize> = edges(corners)
            .map(|(a, b)| ((b - a).norm() / spacing).round().max(1.0) as usize)
            .collect();
        let mut first = self.first[index];
        let n = corners.len();
        for (k, corner) in corners.iter().enumerate() {
            let (before, after) = (corners[(k + n - 1) % n], corners[(k + 1) % n]);
            let (to, from) = (after - corner, before - corner);
            let inside = cross(to, from).atan2(to.dot(&from));
            let long = to.norm().min(from.norm()) > 2.0 * REACH * spacing;
            if inside > 0.0 && inside < FLATTEST && long {
                let last = if k == 0 { self.reference.len() - 1 } else { first - 1 };
                self.corners.push(Corner {
                    position: *corner,
                    along: to.normalize(),
                    open: std::f64::consts::TAU - inside,
                    faces: [first as u32, last as u32],
                    room: 0.0,
                });
                self.reference_corners.push((index, corner.coords, to.normalize()));
            }
            first += pieces[k];
        }
    }

    /// The corner that a fit at `point` feels, with what holds its strength back there.
    #[inline(always)]
    pub(crate) fn corner(&self, point: Point2<f64>, spacing: f64) -> Option<(u32, f64)> {
        let reach = REACH * spacing;
        self.corners.iter().enumerate().find_map(|(k, corner)| {
            let distance2 = (point - corner.position).norm_squared();
            if distance2 >= reach * reach {
                return None;
            }
            let wet = corner.faces.map(|w| self.activity[w as usize]);
            let part = corner.room * wet[0].min(wet[1]);
            let restraint = corner.restraint(distance2.sqrt() / spacing, part)?;
            Some((k as u32, restraint))
        })
    }

    /// Number of wall particles.
    pub(crate) fn len(&self) -> usize {
        self.position.len()
    }

    /// The wall particles of rigid boundary `index`.
    pub(crate) fn of_boundary(&self, index: usize) -> std::ops::Range<usize> {
        self.first[index]..self.first[index + 1]
    }

    /// Moves the particles of every boundary to where it is `later` (s) than its `kinematics`.
    pub(crate) fn place(&mut self, kinematics: &[BoundaryKinematics], later: f64) {
        self.centre.clear();
        for (index, now) in kinematics.iter().enumerate() {
            let boundary = now.drifted(later);
            self.centre.push(boundary.position);
            let rotation = Rotation2::new(boundary.angle);
            for i in self.of_boundary(index) {
                let (arm, normal) = self.reference[i];
                self.position[i] = boundary.position + rotation * arm;
                self.normal[i] = rotation * normal;
                self.velocity[i] = boundary.velocity_at(self.position[i]);
            }
        }
        for (corner, (index, arm, along)) in self.corners.iter_mut().zip(&self.reference_corners) {
            let boundary = kinematics[*index].drifted(later);
            let rotation = Rotation2::new(boundary.angle);
            corner.position = boundary.position + rotation * arm;
            corner.along = rotation * along;
            let x = corner.position.x;
            let clear = corner.position.y.min(x - self.ends.0).min(self.ends.1 - x);
            corner.room = (clear / self.reach - 1.0).clamp(0.0, 1.0);
        }
    }

    /// Part with which wall particle `w` enters the fits of a particle at `point`: its activity,
    /// faded out for particles behind it, as there are around a corner. The tank, being convex,
    /// has no back. All parts change smoothly: a row that came and went would shake the pressure.
    #[inline(always)]
    pub(crate) fn part(&self, w: usize, point: Point2<f64>, spacing: f64) -> f64 {
        if self.owner[w] == Owner::Tank {
            return self.activity[w];
        }
        let ahead = (point - self.position[w]).dot(&self.normal[w]) / spacing;
        self.activity[w] * (0.5 + ahead / (2.0 * BEHIND)).clamp(0.0, 1.0)
    }

    /// Normal component at wall particle `i` of the unit motion `mode` (0: x, 1: y, 2: angle)
    /// of its boundary about `centre`.
    pub(crate) fn unit_normal_motion(&self, i: usize, mode: usize, centre: Point2<f64>) -> f64 {
        match mode {
            0 => self.normal[i].x,
            1 => self.normal[i].y,
            _ => cross(self.position[i] - centre, self.normal[i]),
        }
    }
}
