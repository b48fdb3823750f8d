//! The pressure that asks again for what earlier steps asked for in vain, which is no load.
//!
//! The rows of the pressure equation are a Laplacian, not the divergence of the gradient that
//! moves the particles: part of a divergence, above all what alternates along a wall, has a pressure
//! whose gradient does not take it away. The next step finds it and asks again, with a pressure that
//! is as large as that of the first time and gives the water hardly any momentum. On a body it is an
//! impulse that no water receives: in linear waves at D/dx = 20 a moment of three times the true one.
//! So near bodies each step measures the divergence that it leaves, and the next takes the
//! pressure that answers to it out of the loads. The water keeps its pressure, which holds such
//! divergence down.

use super::Fluid;
use crate::error::FluidError;
use crate::neighbours::BLOCK;
use crate::operators;
use crate::pressure::poisson::require_convergence;
use crate::pressure::solver::PreconditionerKind;
use crate::sparse::Preconditioner;
use crate::walls::Owner;
use rayon::prelude::*;

impl Fluid {
    /// Measures the divergence that the step of `h` (s) leaves in the particles whose fits a
    /// body enters and in their neighbours, with the operators of this step. A shift moves the
    /// point at which the velocity is known, and is no part of it.
    pub(crate) fn keep_divergence(&mut self, h: f64) {
        if !self.has_bodies() {
            return;
        }
        self.mark_near_bodies();
        let mut left = std::mem::take(&mut self.state.particles.divergence_left);
        let mut velocity = std::mem::take(&mut self.work.scratch_vectors);
        let mut scratch = std::mem::take(&mut self.work.scratch);
        velocity.clear();
        let moved = self.state.particles.velocity.iter().zip(&self.work.locals);
        velocity.extend(moved.map(|(u, local)| u - local.shift_velocity));
        let fields = Self::fields(&self.setup, &self.state.particles, &self.walls, &self.work);
        let fields = crate::fields::Fields { velocity: &velocity, ..fields };
        // Of the wall at the end of the step.
        let wall = |w: usize| {
            self.walls.velocity[w].dot(&self.walls.normal[w])
                - self.present_slope(w) * h / self.setup.water.density
        };
        operators::divergences(fields, &mut scratch, &self.work.near_body, wall, &mut left);
        self.work.scratch = scratch;
        self.work.scratch_vectors = velocity;
        self.state.particles.divergence_left = left;
        self.state.particles.repeated_pressure.copy_from_slice(&self.work.repeated);
    }

    /// Whether there is another boundary than the paddle, on which nobody asks for loads.
    fn has_bodies(&self) -> bool {
        self.setup.boundaries.len() > usize::from(self.setup.tank.paddle.is_some())
    }

    /// Marks the inner particles that the walls of a body, or a neighbour that they do, reach.
    fn mark_near_bodies(&mut self) {
        let (work, walls, paddle) = (&mut self.work, &self.walls, self.setup.tank.paddle);
        work.near_body.fill(false);
        for i in 0..work.near_body.len() {
            let of_body = |w: &u32| match walls.owner[*w as usize] {
                Owner::Boundary(b) => Some(b) != paddle,
                Owner::Tank => false,
            };
            if work.wall_lists.of(i).iter().any(of_body) {
                work.near_body[i] = true;
                for &j in work.fluid.of(i) {
                    work.near_body[j as usize] = true;
                }
            }
        }
        let equations = work.on_surface.iter().zip(&work.locals);
        for (near, (surface, local)) in work.near_body.iter_mut().zip(equations) {
            *near &= !surface && local.diagonal > 0.0;
        }
    }

    /// Solves Eq. (9b) for the divergence that the step before has left alone.
    pub(crate) fn repeated_pressure(&mut self, h: f64) -> Result<(), FluidError> {
        if !self.has_bodies() {
            return Ok(());
        }
        let settings = self.setup.pressure;
        let scale = self.setup.water.density * self.setup.numerics.particle_spacing.powi(2) / h;
        let mut rhs = std::mem::take(&mut self.work.rhs);
        let mut solution = std::mem::take(&mut self.work.repeated);
        let (work, particles) = (&self.work, &self.state.particles);
        let blocks = rhs.par_chunks_mut(BLOCK).zip(solution.par_chunks_mut(BLOCK));
        blocks.enumerate().for_each(|(block, (rhs, solution))| {
            for (offset, (rhs, solution)) in rhs.iter_mut().zip(solution).enumerate() {
                let i = block * BLOCK + offset;
                let diagonal = work.locals[i].diagonal;
                let has_equation = !work.on_surface[i] && diagonal > 0.0;
                let or_nought = |value: f64| if has_equation { [value] } else { [0.0] };
                *rhs = or_nought(-scale * particles.divergence_left[i] / diagonal);
                *solution = or_nought(particles.repeated_pressure[i][0]);
            }
        });
        let stop = self.stop(&settings, self.divergence_per_residual(h));
        let mut diagonal = Preconditioner::default();
        let preconditioner = match settings.preconditioner {
            PreconditionerKind::Milu => {
                self.state.pressure.preconditioner(&self.work.matrix, self.state.step)
            }
            PreconditionerKind::Diagonal => &mut diagonal,
        };
        let krylov = &mut self.work.krylov;
        let report = krylov.solve(&self.work.matrix, preconditioner, &rhs, &mut solution, stop);
        self.work.rhs = rhs;
        self.work.repeated = solution;
        require_convergence(report, stop)
    }
}
