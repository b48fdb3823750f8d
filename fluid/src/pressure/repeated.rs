//! The part of the pressure that asks again for what the last step asked for in vain: no load.
//!
//! The rows of the pressure equation are a Laplacian, not the divergence of the gradient that
//! moves the particles: part of a divergence, above all what alternates along a wall, has a pressure
//! whose gradient does not take it away. The next step finds it and asks again, with a pressure that
//! is as large as that of the first time and gives the water hardly any momentum. On a body it is an
//! impulse that no water receives: in linear waves at D/dx = 20 it makes the moment on a box four times
//! the true one. So near bodies each step measures what its pressure asked for in vain, and the next
//! takes the pressure that answers to it out of the loads. The water keeps its pressure, which holds
//! such divergence down.
//!
//! But what is asked for in vain may come back a little larger than it was, and the more often it is
//! asked for, the faster it grows: with steps of a quarter of the default's a pattern that alternates along
//! the bed grew behind a paddle faster than the filter takes it away, and braked the wave. So it is asked for
//! at a rate, whatever the step: a step shorter than [`ANSWER_TIME`] asks for a part of it and keeps the rest back.
//! It then is measured at every wall, and all of it that is asked for within six depths of a body is no load.

use super::Fluid;
use crate::error::FluidError;
use crate::fields::Fields;
use crate::neighbours::BLOCK;
use crate::operators;
use crate::pressure::poisson::require_convergence;
use crate::pressure::solver::{SolverKind, Start};
use crate::walls::Owner;
use rayon::prelude::*;

/// Steps as long as this, in units of sqrt(dx / g), ask in full for what earlier ones asked for in vain: in a
/// solitary wave at D/dx = 12.5 and 25 half as long a time is too short, and twice as long gives the same.
const ANSWER_TIME: f64 = 0.02;

impl Fluid {
    /// Part of the divergence left in vain that a step of `h` (s) does not ask for again. Nothing where the surface
    /// is no line: in broken water there is no pattern to grow, and what is left in vain is another thing in each step.
    pub(crate) fn part_kept(&self, h: f64) -> f64 {
        if !self.surface_is_a_line() {
            return 0.0;
        }
        let unit = (self.setup.numerics.particle_spacing / self.setup.water.gravity).sqrt();
        (1.0 - h / (ANSWER_TIME * unit)).max(0.0)
    }

    /// Measures what is left in vain after a step of `h` (s), before damping zones act: with the part κ of v
    /// that was kept back, v ← ∇·u after − ∇·u before + h ∇²p/ρ + κ v. What a solver leaves is thus no part of
    /// it. What the filter is about to add is one: it makes divergence, but no load. It is measured where a body's
    /// walls reach and one neighbour further; where something is kept back, at every wall.
    pub(crate) fn measure_vain_divergence(&mut self, h: f64) {
        let kept = self.part_kept(h);
        if !self.has_bodies() && kept == 0.0 {
            self.state.particles.vain_divergence.fill(0.0);
            return;
        }
        self.mark_near_walls(kept == 0.0);
        let mut vain = std::mem::take(&mut self.state.particles.vain_divergence);
        let mut last = std::mem::take(&mut self.work.scratch_numbers);
        last.clone_from(&vain);
        let mut velocity = std::mem::take(&mut self.work.scratch_vectors);
        let mut scratch = std::mem::take(&mut self.work.scratch);
        let this = &*self;
        let (work, particles) = (&this.work, &this.state.particles);
        velocity.clear();
        // What viscosity adds is new to the pressure, which has not been asked for it yet.
        let viscous = h * this.setup.water.kinematic_viscosity;
        let filtered = particles.velocity.iter().zip(&work.locals);
        velocity.extend(filtered.map(|(u, local)| {
            u + local.roughness * this.filter_part(local, h) - local.laplacian_of_velocity * viscous
        }));
        let fields = Self::fields(&this.setup, particles, &this.walls, work);
        let after = Fields { velocity: &velocity, ..fields };
        let density = this.setup.water.density;
        // Of the wall at the end of the step.
        let wall = |w: usize| {
            this.walls.velocity[w].dot(&this.walls.normal[w]) - this.present_slope(w) * h / density
        };
        operators::divergences(after, &mut scratch, &work.near_walls, wall, &mut vain);
        vain.par_chunks_mut(BLOCK).enumerate().for_each(|(block, vain)| {
            for (offset, vain) in vain.iter_mut().enumerate() {
                let i = block * BLOCK + offset;
                if work.near_walls[i] {
                    let local = &work.locals[i];
                    let walls = operators::neumann(fields, i, |w| this.present_slope(w));
                    let asked = operators::laplacian(fields, i, local, &particles.pressure, &walls);
                    *vain += asked * h / density - work.equations[i].divergence;
                    *vain += kept * last[i];
                }
            }
        });
        self.work.scratch_numbers = last;
        self.work.scratch = scratch;
        self.work.scratch_vectors = velocity;
        self.state.particles.vain_divergence = vain;
        self.state.particles.repeated_pressure.clone_from(&self.work.repeated);
    }

    /// Whether there is another boundary than the paddle, whose loads keep the whole pressure.
    fn has_bodies(&self) -> bool {
        self.setup.boundaries.len() > usize::from(self.setup.tank.paddle.is_some())
    }

    /// Marks the inner particles that walls, or those of a body only, reach, or a neighbour that they do.
    fn mark_near_walls(&mut self, of_bodies_only: bool) {
        let mut near = std::mem::take(&mut self.work.near_walls);
        let (work, walls, paddle) = (&self.work, &self.walls, self.setup.tank.paddle);
        let counts = |w: &u32| match walls.owner[*w as usize] {
            Owner::Boundary(b) => !of_bodies_only || Some(b) != paddle,
            Owner::Tank => !of_bodies_only,
        };
        let reached = |i: usize| work.wall_lists.of(i).iter().any(counts);
        near.par_chunks_mut(BLOCK).enumerate().for_each(|(block, near)| {
            for (offset, near) in near.iter_mut().enumerate() {
                let i = block * BLOCK + offset;
                let around = || work.fluid.of(i).iter().any(|&j| reached(j as usize));
                let has_equation = !work.on_surface[i] && work.equations[i].diagonal > 0.0;
                *near = has_equation && (reached(i) || around());
            }
        });
        self.work.near_walls = near;
    }

    /// Solves Eq. (9b) for the divergence alone that the step before asked for in vain.
    pub(crate) fn solve_repeated_pressure(&mut self, h: f64) -> Result<(), FluidError> {
        if !self.has_bodies() {
            return Ok(());
        }
        let (settings, numerics) = (self.setup.pressure, self.setup.numerics);
        let scale = (1.0 - self.part_kept(h))
            * (1.0 - numerics.density_blend)
            * self.setup.water.density
            * numerics.particle_spacing.powi(2)
            / h;
        let mut rhs = std::mem::take(&mut self.work.repeated_rhs);
        let mut solution = std::mem::take(&mut self.work.repeated);
        let (work, particles) = (&self.work, &self.state.particles);
        let blocks = rhs.par_chunks_mut(BLOCK).zip(solution.par_chunks_mut(BLOCK));
        blocks.enumerate().for_each(|(block, (rhs, solution))| {
            for (offset, (rhs, solution)) in rhs.iter_mut().zip(solution).enumerate() {
                let i = block * BLOCK + offset;
                let diagonal = work.equations[i].diagonal;
                let has_equation = !work.on_surface[i] && diagonal > 0.0;
                let or_nought = |value: f64| if has_equation { [value] } else { [0.0] };
                *rhs = or_nought(-scale * particles.vain_divergence[i] / diagonal);
                *solution = match settings.start {
                    Start::Cold => [0.0],
                    Start::Warm | Start::Given => or_nought(particles.repeated_pressure[i][0]),
                };
            }
        });
        // As sharp as the pressure itself: smooth parts matter to a load, and are the last to be found.
        let stop = self.stop(&settings, self.divergence_per_residual(h));
        let rows = self.rows_around(|b| Some(b) != self.setup.tank.paddle);
        let (kind, step) = (settings.preconditioner, self.state.step);
        let system = self.state.pressure.system(kind, &self.work.matrix, rows, step);
        let report = self.work.krylov.solve(system, &rhs, &mut solution, stop);
        self.work.repeated_rhs = rhs;
        self.work.repeated = solution;
        match settings.solver {
            SolverKind::Capped => Ok(()),
            _ => require_convergence(report, stop),
        }
    }
}
