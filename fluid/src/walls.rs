//! Wall particles: one layer on the surface of the tank and of every rigid boundary itself.
//!
//! Each wall particle stands at the middle of its piece of an edge, so that none lies on a
//! corner, every normal is that of an edge, and lengths add up to the true perimeter.

use crate::geometry::{cross, edges};
use crate::setup::FluidSetup;
use nalgebra::{Point2, Rotation2, Vector2};
use seakeep_coupler::interface::BoundaryKinematics;

/// Distance in spacings over which a wall fades out for particles from before to behind it.
const BEHIND: f64 = 0.3;

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
        for (a, b) in tank {
            walls.add_edge(a, b, 1.0, Owner::Tank, spacing);
        }
        for (index, boundary) in setup.boundaries.iter().enumerate() {
            walls.first.push(walls.reference.len());
            let corners: Vec<_> = boundary.corners.iter().map(|c| Point2::from(*c)).collect();
            for (a, b) in edges(&corners) {
                walls.add_edge(a.coords, b.coords, -1.0, Owner::Boundary(index), spacing);
            }
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
