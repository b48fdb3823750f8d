//! The stages that move particles: correction, damping zones, regularisation.

use crate::error::FluidError;
use crate::fit;
use crate::fluid::Fluid;
use crate::geometry::{nearest_on_outline, placed_corners, signed_area, signed_distance};
use crate::neighbours::{BLOCK, MANY};
use crate::operators::{self, Local};
use crate::plan::Stage;
use crate::regularise;
use nalgebra::Vector2;
use rayon::prelude::*;

/// Rate of the filter in units of sqrt(g / dx): the part of the roughness that a step takes away is
/// this rate times the step.
const FILTER_RATE: f64 = 2.0;

/// Part of the roughness that a step takes away at most.
const MOST_FILTERED: f64 = 0.5;

/// Part of the particles that may be lost before a run counts as unstable.
const MOST_LOST: f64 = 0.01;

impl Fluid {
    /// Eqs. (10) to (12): velocity from the pressure gradient at the midpoint, then half a drift.
    pub(crate) fn correct(&mut self, h: f64) {
        let mut pressure = std::mem::take(&mut self.work.pressure);
        let this = &*self;
        pressure.par_chunks_mut(BLOCK).enumerate().for_each(|(block, pressure)| {
            for (offset, pressure) in pressure.iter_mut().enumerate() {
                let i = block * BLOCK + offset;
                let air = this.surface_pressure(i);
                let near_surface = |j: &u32| this.work.on_surface[*j as usize];
                *pressure = if this.work.on_surface[i] {
                    air
                } else {
                    let water = this.work.solution[i][0] + this.reaction_pressure(i);
                    // Next to the air water does not pull: it parts, and air comes between.
                    let parts = water < air && this.work.fluid.of(i).iter().any(near_surface);
                    if parts { air } else { water }
                };
            }
        });
        let mut velocity = std::mem::take(&mut self.work.scratch_vectors);
        velocity.resize(pressure.len(), Vector2::zeros());
        let this = &*self;
        let fields = Self::fields(&this.setup, &this.state.particles, &this.walls, &this.work);
        let water = &this.setup.water;
        let viscous = this.runs[Stage::Viscosity as usize];
        velocity.par_chunks_mut(BLOCK).enumerate().for_each(|(block, velocity)| {
            for (offset, velocity) in velocity.iter_mut().enumerate() {
                let i = block * BLOCK + offset;
                let local = &this.work.locals[i];
                let mut acceleration = if local.quality == fit::Quality::None {
                    // Alone in the air: free fall.
                    Vector2::new(0.0, -water.gravity)
                } else {
                    let walls = operators::neumann(fields, i, |w| this.present_slope(w));
                    operators::gradient(fields, i, local, &pressure, &walls) / -water.density
                };
                if viscous {
                    acceleration += water.kinematic_viscosity * local.laplacian_of_velocity;
                }
                *velocity = fields.velocity[i] + acceleration * h;
            }
        });
        let particles = &mut self.state.particles;
        // Eq. (12).
        let moved = particles.position.par_iter_mut().zip(&mut particles.velocity).zip(&velocity);
        moved.with_min_len(MANY).for_each(|((x, old), new)| {
            *x += (*old + new) * (0.5 * h);
            *old = *new;
        });
        let memory = self.setup.pressure.solver.steps_of_change();
        let changed = particles.pressure.par_iter_mut().zip(&mut particles.pressure_change);
        changed.zip(&pressure).with_min_len(MANY).for_each(|((last, change), value)| {
            *change += (value - *last - *change) / memory;
            *last = *value;
        });
        particles.on_surface.copy_from_slice(&self.work.on_surface);
        self.state.wall_activity.copy_from_slice(&self.walls.activity);
        for (state, work) in self.state.unit_pressure.iter_mut().zip(&self.work.unit_solution) {
            state.copy_from_slice(work);
        }
        self.work.pressure = pressure;
        self.work.scratch_vectors = velocity;
    }

    /// Lets particles collide that approach each other faster than water does; see
    /// [`regularise::collision`].
    fn collide(&mut self, h: f64) {
        let spacing = self.setup.numerics.particle_spacing;
        let pace = spacing / h;
        for [i, j] in self.work.spray.pairs.iter().map(|pair| pair.map(|i| i as usize)) {
            let particles = &mut self.state.particles;
            let d = (particles.position[j] - particles.position[i]) / spacing;
            let distance = d.norm();
            if distance > 0.0 {
                let ahead = d / distance;
                let approach = (particles.velocity[i] - particles.velocity[j]).dot(&ahead);
                let change = regularise::collision(ahead, distance, approach, pace);
                particles.velocity[i] += change;
                particles.velocity[j] -= change;
            }
        }
        if !self.work.broken.is_anywhere() {
            return;
        }
        let mut change = std::mem::take(&mut self.work.scratch_vectors);
        change.resize(self.state.particles.len(), Vector2::zeros());
        let (particles, near, broken) =
            (&self.state.particles, &self.work.fluid, &self.work.broken);
        change.par_chunks_mut(BLOCK).enumerate().for_each(|(block, change)| {
            for (offset, change) in change.iter_mut().enumerate() {
                let i = block * BLOCK + offset;
                let (x, u) = (particles.position[i], particles.velocity[i]);
                *change = Vector2::zeros();
                if !broken.is_at(x.x) {
                    continue;
                }
                for j in near.of(i).iter().map(|&j| j as usize) {
                    let d = (particles.position[j] - x) / spacing;
                    let distance = d.norm();
                    if distance < regularise::COLLISION_RANGE && distance > 0.0 {
                        let ahead = d / distance;
                        let approach = (u - particles.velocity[j]).dot(&ahead);
                        *change += regularise::collision(ahead, distance, approach, pace);
                    }
                }
            }
        });
        for (u, change) in self.state.particles.velocity.iter_mut().zip(&change) {
            *u += change;
        }
        self.work.scratch_vectors = change;
    }

    /// u ← u / (1 + γ(x) dt) in the damping zones.
    pub(crate) fn damp(&mut self, h: f64) {
        let particles = &mut self.state.particles;
        for zone in &self.setup.damping_zones {
            for (x, u) in particles.position.iter().zip(&mut particles.velocity) {
                let s = (x.x - zone.inner_x) / (zone.outer_x - zone.inner_x);
                if s > 0.0 {
                    let s = s.min(1.0);
                    let shape = ((s * s).exp() - 1.0) / (std::f64::consts::E - 1.0);
                    *u /= 1.0 + zone.rate * shape * h;
                }
            }
        }
    }

    /// Rate of the filter, 1/s.
    fn filter_rate(&self) -> f64 {
        FILTER_RATE * (self.setup.water.gravity / self.setup.numerics.particle_spacing).sqrt()
    }

    /// Part of the roughness of a particle that the filter takes away in a step of `h` (s).
    pub(crate) fn filter_part(&self, local: &Local, h: f64) -> f64 {
        (self.filter_rate() * h * local.filter).min(MOST_FILTERED)
    }

    /// Lets particles collide, shifts them, their velocity with them, and filters what no fit can
    /// resolve.
    pub(crate) fn regularise(&mut self, h: f64) {
        self.collide(h);
        let spacing = self.setup.numerics.particle_spacing;
        let most = self.filter_rate() * h;
        let particles = &mut self.state.particles;
        let all = particles.position.par_iter_mut().zip(&mut particles.velocity);
        all.zip(&self.work.locals).with_min_len(MANY).for_each(|((x, u), local)| {
            *x += local.shift;
            let part = (most * local.filter).min(MOST_FILTERED);
            *x += local.surface_roughness * part;
            *u += local.shift_velocity + local.roughness * part;
            let (velocity, back) = regularise::collide(*u, local.contacts, spacing, h);
            *u = velocity;
            *x += back;
        });
        self.keep_out(h);
    }

    /// Puts particles that have got into a boundary over a step of `h` (s) back on its outline, where
    /// they go on with its velocity along the normal. Water in contact keeps off by
    /// [`regularise::collide`]; but spray, which a fit over few neighbours may fling, can pass a wall
    /// within a step, and would fall on inside the body and burst out of its keel.
    pub(crate) fn keep_out(&mut self, h: f64) {
        let mut polygon = std::mem::take(&mut self.work.polygon);
        let particles = &mut self.state.particles;
        for (boundary, kinematics) in self.setup.boundaries.iter().zip(&self.state.kinematics) {
            let now = kinematics.drifted(h);
            polygon.clear();
            polygon.extend(placed_corners(&boundary.corners, now.position, now.angle));
            // A container has the water inside.
            if signed_area(&polygon) < 0.0 {
                continue;
            }
            let reach = boundary.corners.iter().map(|c| c.norm_squared()).fold(0.0, f64::max);
            for (x, u) in particles.position.iter_mut().zip(&mut particles.velocity) {
                if (*x - now.position).norm_squared() >= reach
                    || signed_distance(&polygon, *x) >= 0.0
                {
                    continue;
                }
                let Some((foot, normal)) = nearest_on_outline(&polygon, *x) else { continue };
                let inward = (now.velocity_at(foot) - *u).dot(&normal);
                *x = foot;
                *u += normal * inward.max(0.0);
            }
        }
        self.work.polygon = polygon;
    }

    /// Whether particle `i` is lost: out of the tank, or faster than any water in it could be.
    /// Spray does this; resampling takes it out.
    pub(crate) fn is_lost(&self, i: usize) -> bool {
        const FASTEST: f64 = 5.0;
        let (x, u) = (self.state.particles.position[i], self.state.particles.velocity[i]);
        let (tank, water) = (&self.setup.tank, &self.setup.water);
        let margin = 2.0 * self.setup.numerics.particle_spacing;
        let inside =
            x.x > -self.setup.behind() - margin && x.x < tank.length + margin && x.y > -margin;
        !inside || u.norm_squared() > FASTEST * FASTEST * water.gravity * tank.height
    }

    /// Fails when a particle is nowhere or more are lost than [`MOST_LOST`].
    pub(crate) fn check(&self) -> Result<(), FluidError> {
        let particles = &self.state.particles;
        let mut lost = self.state.lost;
        for (i, (x, u)) in particles.position.iter().zip(&particles.velocity).enumerate() {
            let finite = x.x.is_finite() && x.y.is_finite() && u.norm_squared().is_finite();
            lost += u64::from(finite && self.is_lost(i));
            if !finite || lost as f64 > MOST_LOST * particles.len() as f64 {
                return Err(FluidError::Unstable {
                    particle: particles.identity[i],
                    x: x.x,
                    y: x.y,
                    u: u.x,
                    v: u.y,
                });
            }
        }
        Ok(())
    }
}
