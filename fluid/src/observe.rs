//! What can be read off all particles together: counts, energy, volume, errors.

use crate::fit;
use crate::fluid::Fluid;
use crate::geometry::{area_below, placed, placed_corners, signed_distance};
use crate::operators;
use crate::setup::RigidBoundary;
use nalgebra::{Point2, Vector2};
use rayon::prelude::*;
use serde::Serialize;

/// How many particles there are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct ParticleCounts {
    /// Fluid particles, those on the surface included.
    pub fluid: usize,
    /// Fluid particles on the free surface.
    pub surface: usize,
    /// Wall particles of the tank.
    pub wall: usize,
    /// Wall particles of rigid boundaries.
    pub body: usize,
}

/// State of health of the last step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Diagnostics {
    /// Kinetic energy of the water, J/m.
    pub kinetic_energy: f64,
    /// Potential energy of the water relative to a flat surface, ½ ρ g ∫ η² dx, J/m.
    pub potential_energy: f64,
    /// Change of the volume of water since the start, relative.
    pub volume_error: f64,
    /// Root mean square of ∇·u at the middle of the step, before the pressure acts, 1/s.
    pub divergence_rms: f64,
    /// Standard deviation of the particle density away from surface and walls, relative to its
    /// mean.
    pub density_error_rms: f64,
    /// Iterations of the last pressure solve.
    pub pressure_iterations: usize,
    /// Iterations of the last solve for the pressure of unit accelerations.
    pub added_mass_iterations: usize,
    /// Residual of the last pressure solve, relative to the right-hand side.
    pub pressure_residual: f64,
    /// Particles that take part in the step.
    pub particles_active: usize,
    /// Largest speed, m/s.
    pub max_speed: f64,
    /// Largest |p − ρ g (D − y)| of all particles, Pa.
    pub max_hydrostatic_pressure_error: f64,
    /// Particles taken out since the start because they had left the tank or were faster than any
    /// water in it could be.
    pub particles_lost: u64,
    /// Particles whose last fit was not quadratic.
    pub thin_stencils: usize,
}

/// The particles as they are, in the order of this step.
#[derive(Clone, Copy)]
pub struct ParticlesView<'a> {
    /// Position, m.
    pub position: &'a [Point2<f64>],
    /// Velocity, m/s.
    pub velocity: &'a [Vector2<f64>],
    /// Dynamic pressure p + ρ g (y − D) of the last step, Pa.
    pub dynamic_pressure: &'a [f64],
    /// Whether a particle is on the free surface.
    pub on_surface: &'a [bool],
    /// Identity, kept over renumberings.
    pub identity: &'a [u32],
}

/// Height of the surface `line` at `x`, level beyond its ends, m; `None` for an empty line.
fn height_of(line: &[Point2<f64>], x: f64) -> Option<f64> {
    let after = line.partition_point(|p| p.x < x);
    match (after.checked_sub(1).map(|before| line[before]), line.get(after)) {
        (Some(a), Some(b)) => Some(a.y + (b.y - a.y) * (x - a.x) / (b.x - a.x)),
        (Some(end), None) => Some(end.y),
        (None, end) => end.map(|end| end.y),
    }
}

/// Integrals over the water per metre of width.
#[derive(Clone, Copy, Debug, Default)]
struct Integrals {
    /// ∫ dA, m².
    volume: f64,
    /// ∫ y dA, m³.
    height: f64,
    /// ∫ u² dA, m⁴/s².
    speed2: f64,
}

impl Fluid {
    /// The particles.
    #[must_use]
    pub fn particles(&self) -> ParticlesView<'_> {
        let particles = &self.state.particles;
        ParticlesView {
            position: &particles.position,
            velocity: &particles.velocity,
            dynamic_pressure: &particles.pressure,
            on_surface: &particles.on_surface,
            identity: &particles.identity,
        }
    }

    /// Total pressure of each particle, Pa.
    pub fn pressures(&self) -> impl Iterator<Item = f64> + '_ {
        let water = &self.setup.water;
        let particles = &self.state.particles;
        particles.pressure.iter().zip(&particles.position).map(move |(dynamic, position)| {
            dynamic + water.density * water.gravity * (water.depth - position.y)
        })
    }

    /// How many particles there are.
    #[must_use]
    pub fn particle_counts(&self) -> ParticleCounts {
        let body: usize =
            (0..self.setup.boundaries.len()).map(|b| self.walls.of_boundary(b).len()).sum();
        ParticleCounts {
            fluid: self.state.particles.len(),
            surface: self.state.particles.on_surface.iter().filter(|&&s| s).count(),
            wall: self.walls.len() - body,
            body,
        }
    }

    /// State of health of the last step.
    #[must_use]
    pub fn diagnostics(&self) -> Diagnostics {
        let (water, particles) = (&self.setup.water, &self.state.particles);
        let mut line = Vec::new();
        if self.surface_is_a_line() {
            self.surface_line(&mut line);
        }
        let integrals = self.integrals(&line);
        let (depth, length) = (water.depth, self.setup.tank.length);
        // ∫ y dA − D V + ½ D² L = ½ ∫ (y − D)² dx where the surface is a function of x.
        let (volume, potential) = if line.is_empty() {
            let volume = integrals.volume;
            (volume, integrals.height - depth * volume + 0.5 * depth * depth * length)
        } else {
            let square = |y: f64| (y - depth) * (y - depth);
            (self.volume_below(&line), 0.5 * self.integrate_surface(&line, square))
        };
        let mut d = Diagnostics {
            pressure_iterations: self.report.iterations,
            added_mass_iterations: self.unit_report.iterations,
            pressure_residual: self.report.residual,
            particles_active: particles.len(),
            particles_lost: self.state.lost,
            volume_error: volume / self.initial_volume - 1.0,
            potential_energy: water.density * water.gravity * potential,
            kinetic_energy: 0.5 * water.density * integrals.speed2,
            ..Diagnostics::default()
        };
        for (i, local) in self.work.locals.iter().enumerate() {
            let speed2 = particles.velocity[i].norm_squared();
            d.max_speed = d.max_speed.max(speed2.sqrt());
            d.max_hydrostatic_pressure_error =
                d.max_hydrostatic_pressure_error.max(particles.pressure[i].abs());
            d.divergence_rms += self.work.equations[i].divergence.powi(2);
            d.thin_stencils += usize::from(local.quality != fit::Quality::Full);
        }
        d.divergence_rms = (d.divergence_rms / particles.len() as f64).sqrt();
        let fields = Self::fields(&self.setup, particles, &self.walls, &self.work);
        d.density_error_rms = operators::density_deviation(fields);
        d
    }

    /// Whether the surface is a function of x along the whole tank: not where it overturns, nor in a
    /// container.
    pub(crate) fn surface_is_a_line(&self) -> bool {
        let container = self.setup.boundaries.iter().any(RigidBoundary::holds_water);
        !container && !self.work.broken.is_anywhere()
    }

    /// Volume of the water, m².
    pub(crate) fn volume(&self) -> f64 {
        let mut line = Vec::new();
        if !self.surface_is_a_line() {
            return self.integrals(&line).volume;
        }
        self.surface_line(&mut line);
        self.volume_below(&line)
    }

    /// Integrals over the water by sampling: below the surface `line` or, if that is empty, wherever
    /// particles are, whatever the shape of the surface. A sample takes the velocity of the nearest
    /// particle, carried on by its gradient: the water around a surface particle lies all below it,
    /// and its own speed would be (k dx)²/2 too much.
    fn integrals(&self, line: &[Point2<f64>]) -> Integrals {
        const SAMPLES_A_SPACING: f64 = 3.0;
        let particles = &self.state.particles;
        let dx = self.setup.numerics.particle_spacing;
        let (low, high) = (-self.setup.behind(), self.setup.tank.length);
        let top = particles.position.iter().map(|x| x.y).fold(0.0, f64::max).min(1e3 * dx);
        let count = |length: f64| (length / dx * SAMPLES_A_SPACING).ceil().max(1.0) as usize;
        let columns = count(high - low);
        let width = (high - low) / columns as f64;
        let centre = |column: usize| low + (column as f64 + 0.5) * width;
        // Samples in each column and the height that each stands for.
        let column = |column: usize| {
            let surface = height_of(line, centre(column)).unwrap_or(top);
            (count(surface), surface / count(surface) as f64)
        };
        let heights: Vec<(usize, f64)> = (0..columns).map(column).collect();
        let most = heights.iter().map(|(rows, _)| *rows).max().unwrap_or(1);

        // Each particle looks for the samples around, of which there are fewer than of particles
        // around each sample.
        let mut nearest = vec![(dx * dx, u32::MAX); columns * most];
        for (i, x) in (0..).zip(&particles.position) {
            let first = ((x.x - dx - low) / width - 0.5).ceil().max(0.0) as usize;
            let last = ((x.x + dx - low) / width + 0.5).floor().clamp(0.0, columns as f64) as usize;
            for column in first..last {
                let across = (centre(column) - x.x).powi(2);
                let (rows, height) = heights[column];
                let low = ((x.y - dx) / height - 0.5).ceil().max(0.0) as usize;
                let high = ((x.y + dx) / height + 0.5).floor().clamp(0.0, rows as f64) as usize;
                for row in low..high {
                    let distance = across + ((row as f64 + 0.5) * height - x.y).powi(2);
                    let known = &mut nearest[column * most + row];
                    if distance < known.0 {
                        *known = (distance, i);
                    }
                }
            }
        }

        let polygons: Vec<_> = (0..self.setup.boundaries.len()).map(|b| self.polygon(b)).collect();
        let displaced = |sample: Point2<f64>| {
            polygons.iter().any(|polygon| signed_distance(polygon, sample) < 0.0)
        };
        let column_integrals = |column: usize| {
            let (rows, height) = heights[column];
            let mut sum = Integrals::default();
            for row in 0..rows {
                let sample = Point2::new(centre(column), (row as f64 + 0.5) * height);
                let i = nearest[column * most + row].1 as usize;
                let Some(position) = particles.position.get(i) else { continue };
                let d = sample - position;
                let above = line.is_empty() && particles.on_surface[i];
                if (above && d.dot(&self.work.normal[i]) > 0.0)
                    // Water away from boundaries need not be looked at.
                    || (!self.work.wall_lists.of(i).is_empty() && displaced(sample))
                {
                    continue;
                }
                let velocity = particles.velocity[i] + self.work.locals[i].velocity_gradient * d;
                sum.volume += height;
                sum.height += height * sample.y;
                sum.speed2 += height * velocity.norm_squared();
            }
            sum
        };
        let mut parts = vec![Integrals::default(); columns];
        parts.par_iter_mut().enumerate().for_each(|(column, e)| *e = column_integrals(column));
        let mut total = Integrals::default();
        for part in &parts {
            total.volume += part.volume * width;
            total.height += part.height * width;
            total.speed2 += part.speed2 * width;
        }
        total
    }

    /// Polygon of boundary `b` where it is now.
    pub(crate) fn polygon(&self, b: usize) -> Vec<Point2<f64>> {
        let k = &self.state.kinematics[b];
        placed(&self.setup.boundaries[b].corners, k.position, k.angle)
    }

    /// Surface particles by x, into `line`.
    pub(crate) fn surface_line(&self, line: &mut Vec<Point2<f64>>) {
        let particles = &self.state.particles;
        line.clear();
        line.extend(
            particles
                .position
                .iter()
                .zip(&particles.on_surface)
                .filter(|(_, surface)| **surface)
                .map(|(x, _)| *x),
        );
        line.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(b.y.total_cmp(&a.y)));
    }

    /// Slope dx/dy of the paddle's face, with its x at height `y` (m); 0 and 0 without a paddle.
    fn left_end(&self, y: f64) -> (f64, f64) {
        self.setup.tank.paddle.map_or((0.0, 0.0), |paddle| {
            let k = &self.state.kinematics[paddle];
            let slope = -k.angle.tan();
            (slope, k.position.x + slope * (y - k.position.y))
        })
    }

    /// ∫ f(y) dx along the surface from wall to wall, straight across boundaries.
    fn integrate_surface(&self, line: &[Point2<f64>], f: impl Fn(f64) -> f64) -> f64 {
        let (Some(first), Some(last)) = (line.first(), line.last()) else { return 0.0 };
        let (_, left) = self.left_end(first.y);
        let right = self.setup.tank.length;
        // Beyond an end that stands off the wall the bed is dry.
        let dry = 2.0 * self.setup.numerics.particle_spacing;
        let end = |y: f64, gap: f64| f(if gap > dry { 0.0 } else { y }) * gap;
        let ends = end(first.y, first.x - left) + end(last.y, right - last.x);
        let between: f64 = line
            .windows(2)
            .map(|pair| 0.5 * (f(pair[0].y) + f(pair[1].y)) * (pair[1].x - pair[0].x))
            .sum();
        ends + between
    }

    /// Volume of water per metre of width, m²: below the surface, less what boundaries displace.
    pub(crate) fn volume_below(&self, line: &[Point2<f64>]) -> f64 {
        let mut volume = self.integrate_surface(line, |y| y);
        let paddle = self.setup.tank.paddle;
        for (b, k) in self.state.kinematics.iter().enumerate() {
            let split = line.partition_point(|p| p.x < k.position.x);
            if Some(b) == paddle {
                // Between the face of a flap and the vertical through its upper end.
                let top = line.first().map_or(0.0, |first| first.y);
                let hinge = k.position.y.max(0.0);
                let above = top - hinge;
                volume += self.left_end(top).0 * above * (hinge + 0.5 * above);
            } else if split > 0 && split < line.len() {
                let corners =
                    placed_corners(&self.setup.boundaries[b].corners, k.position, k.angle);
                // The wall below the hinge of a flap stands behind the water's left end.
                if corners.clone().any(|corner| corner.x > 0.0) {
                    volume -= area_below(corners, line[split - 1], line[split]);
                }
            }
        }
        volume
    }
}
