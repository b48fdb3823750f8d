//! The divergence that a step asks the pressure to take away.
//!
//! The gradient of the pressure cannot undo all that the fits see of a divergence: what alternates
//! from particle to particle at a wall is left, and the next step asks for it again. Such a mode of
//! slow decay follows a wave out of phase, with a pressure on bodies in phase with the velocity. Near
//! bodies a step therefore asks for the mean over the neighbours. It is still the divergence that
//! comes to nothing: the mean acts as a rate, one in a step for long waves, slower for short ones.
//! Elsewhere it would do harm: what is asked for again takes energy, by which steep waves lose
//! what the fits feed in.

use crate::fit;
use crate::fluid::Fluid;
use crate::neighbours::BLOCK;
use crate::setup::Discretisation;
use crate::walls::Owner;
use rayon::prelude::*;

/// How often the mean over the neighbours is taken.
const PASSES: usize = 2;

impl Fluid {
    /// ∇·u* of each particle as the pressure equation asks for it, 1/s, into `divergence`: near a body
    /// its mean over the neighbours. In broken water, where these may fly apart, and with
    /// conventional operators it is the particle's own everywhere.
    pub(crate) fn divergence(&mut self, divergence: &mut Vec<f64>) {
        divergence.clear();
        divergence.extend(self.work.locals.iter().map(|local| local.velocity_gradient.trace()));
        if self.setup.boundaries.is_empty()
            || self.setup.numerics.discretisation == Discretisation::Conventional
        {
            return;
        }
        let mut last = std::mem::take(&mut self.work.scratch_numbers);
        let (work, owner) = (&self.work, &self.walls.owner);
        let scale = 1.0 / self.setup.numerics.particle_spacing.powi(2);
        let at_body = |i: usize| {
            let mut walls = work.wall_lists.of(i).iter();
            walls.any(|&w| owner[w as usize] != Owner::Tank)
        };
        // The surface has no equation.
        let inner = |i: usize| !work.on_surface[i];
        for _ in 0..PASSES {
            last.clone_from(divergence);
            divergence.par_chunks_mut(BLOCK).enumerate().for_each(|(block, divergence)| {
                for (offset, value) in divergence.iter_mut().enumerate() {
                    let i = block * BLOCK + offset;
                    let centre = work.position[i];
                    if !inner(i) || !at_body(i) || work.broken.is_at(centre.x) {
                        continue;
                    }
                    let (mut sum, mut weights) = (fit::bell(0.0) * last[i], fit::bell(0.0));
                    for j in work.fluid.of(i).iter().map(|&j| j as usize).filter(|&j| inner(j)) {
                        let weight = fit::bell((work.position[j] - centre).norm_squared() * scale);
                        sum += weight * last[j];
                        weights += weight;
                    }
                    *value = sum / weights;
                }
            });
        }
        self.work.scratch_numbers = last;
    }
}
