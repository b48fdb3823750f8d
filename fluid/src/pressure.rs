//! The pressure stages: Eq. (9b) and the pressure of unit accelerations.

mod network;
mod poisson;
pub(crate) mod repeated;
pub(crate) mod solver;

use crate::error::FluidError;
use crate::fit;
use crate::fluid::Fluid;
use crate::krylov::Stop;
use crate::neighbours::BLOCK;
use crate::network::{Inference, Network};
use crate::operators::{self, Equation};
use crate::walls::Owner;
use nalgebra::Point2;
use network::NetworkSolver;
use poisson::{Poisson, require_convergence};
use rayon::prelude::*;
use solver::{
    PressureMemory, PressureReport, PressureSettings, PressureSolver, Problem, SolverKind, Start,
};
use std::ops::Range;
use std::sync::Arc;

/// Tolerance of the pressure of unit accelerations, in pressure tolerances.
const UNIT_TOLERANCE: f64 = 10.0;
/// How far from a body its pressure of unit accelerations is looked for, in depths. The slowest mode of
/// one that is nought on the surface falls as exp(−πx/2D): to 8e-5, and what would come back from there to 6e-9.
const BODY_REACH: f64 = 6.0;
/// Largest relative volume error that Eq. (9b) feeds back.
const LARGEST_FEEDBACK: f64 = 0.01;
/// Density of the particles, relative to a lattice's, that counts as even: more varies in smooth
/// flow, too, and would be noise.
const EVEN: std::ops::RangeInclusive<f64> = 0.85..=1.15;
/// Part of what is beyond [`EVEN`] that a step takes away.
const CROWDING_FEEDBACK: f64 = 0.03;

impl Fluid {
    /// ∂p/∂n at wall particle `w` that the known accelerations of held and prescribed boundaries
    /// ask for, Eq. (4) for the dynamic pressure, Pa/m.
    pub(crate) fn known_slope(&self, w: usize) -> f64 {
        match self.walls.owner[w] {
            Owner::Boundary(b) if !self.setup.boundaries[b].free => self.slope(w, b, |mode| {
                let k = &self.state.kinematics[b];
                [k.acceleration.x, k.acceleration.y, k.angular_acceleration][mode]
            }),
            _ => 0.0,
        }
    }

    /// ∂p/∂n at wall particle `w` for the accelerations of the step, Pa/m.
    pub(crate) fn present_slope(&self, w: usize) -> f64 {
        match self.walls.owner[w] {
            Owner::Boundary(b) if self.setup.boundaries[b].free => {
                self.slope(w, b, |mode| self.state.accelerations[3 * b + mode])
            }
            _ => self.known_slope(w),
        }
    }

    /// ∂p/∂n at wall particle `w` of boundary `b` for its `accelerations`, Pa/m.
    pub(crate) fn slope(&self, w: usize, b: usize, accelerations: impl Fn(usize) -> f64) -> f64 {
        let centre = self.walls.centre[b];
        let normal_acceleration: f64 = (0..3)
            .map(|mode| accelerations(mode) * self.walls.unit_normal_motion(w, mode, centre))
            .sum();
        -self.setup.water.density * normal_acceleration
    }

    /// Dynamic pressure on the surface, Eq. (5): p = 0, Pa.
    pub(crate) fn surface_pressure(&self, i: usize) -> f64 {
        let water = &self.setup.water;
        water.density * water.gravity * (self.work.position[i].y - water.depth)
    }

    /// Σ a_k p_k at particle `i`: the pressure of the boundaries' present accelerations, Pa.
    #[inline(always)]
    pub(crate) fn reaction_pressure(&self, i: usize) -> f64 {
        let parts = self.free.iter().zip(&self.work.unit_solution).map(|(&b, unit)| {
            let a = &self.state.accelerations[3 * b..3 * b + 3];
            a[0] * unit[i][0] + a[1] * unit[i][1] + a[2] * unit[i][2]
        });
        parts.sum()
    }

    /// Solves ∇²p_k = 0, n·∇p_k = −ρ n_k on each free boundary, p_k = 0 on the surface, for unit
    /// accelerations k: the pressure is then p = p_0 + Σ a_k p_k with no iteration.
    pub(crate) fn added_mass_pressure(&mut self) -> Result<(), FluidError> {
        let settings = self.setup.pressure;
        for slot in 0..self.free.len() {
            let boundary = self.free[slot];
            let mut rhs = std::mem::take(&mut self.work.unit_rhs);
            let fields = Self::fields(&self.setup, &self.state.particles, &self.walls, &self.work);
            rhs.par_chunks_mut(BLOCK).enumerate().for_each(|(block, rhs)| {
                for (offset, rhs) in rhs.iter_mut().enumerate() {
                    let i = block * BLOCK + offset;
                    let diagonal = self.work.equations[i].diagonal;
                    *rhs = [0.0; 3];
                    if fields.on_surface[i] || diagonal <= 0.0 || fields.wall_lists.of(i).is_empty()
                    {
                        continue;
                    }
                    let laplacian = &self.work.locals[i].pressure.laplacian;
                    for (mode, rhs) in rhs.iter_mut().enumerate() {
                        let sum = operators::neumann(fields, i, |w| {
                            if self.walls.owner[w] == Owner::Boundary(boundary) {
                                self.slope(w, boundary, |k| f64::from(u8::from(k == mode)))
                            } else {
                                0.0
                            }
                        });
                        *rhs = fit::dot(laplacian, &sum) / diagonal;
                    }
                }
            });
            let mut solution = std::mem::take(&mut self.work.unit_solution[slot]);
            match settings.start {
                Start::Warm | Start::Given => {
                    solution.copy_from_slice(&self.state.unit_pressure[slot])
                }
                Start::Cold => solution.fill([0.0; 3]),
            }
            clear_rows(&mut solution, &self.work.on_surface, &self.work.equations);
            // Its error enters times the acceleration, and the next step starts from it.
            let mut stop = self.stop(&settings, f64::INFINITY);
            stop.relative *= if self.state.step == 0 { 1e-2 } else { UNIT_TOLERANCE };
            let rows = self.rows_around(|b| b == boundary);
            let (kind, step) = (settings.preconditioner, self.state.step);
            let system = self.state.pressure.system(kind, &self.work.matrix, rows, step);
            let report = self.work.unit_krylov.solve(system, &rhs, &mut solution, stop);
            self.work.unit_rhs = rhs;
            self.work.unit_solution[slot] = solution;
            self.unit_report = report;
            require_convergence(report, stop)?;
        }
        Ok(())
    }

    /// The rows of the particles that the pressure of a boundary for which `of` holds reaches.
    fn rows_around(&self, of: impl Fn(usize) -> bool) -> Range<usize> {
        let reach = BODY_REACH * self.setup.water.depth;
        let boundaries = (0..self.setup.boundaries.len()).filter(|&b| of(b));
        let walls = boundaries.flat_map(|b| self.walls.of_boundary(b));
        let (low, high) = walls
            .map(|w| self.walls.position[w].x)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        let within = |x: &Point2<f64>| x.x > low - reach && x.x < high + reach;
        let position = &self.work.position;
        // Particles are numbered along the tank, so that few others are among them.
        let first = position.iter().position(within).unwrap_or(0);
        first..position.iter().rposition(within).map_or(first, |last| last + 1)
    }

    /// When a solve ends whose residual of 1 Pa is worth `divergence_per_residual` (1/s).
    fn stop(&self, settings: &PressureSettings, divergence_per_residual: f64) -> Stop {
        let water = &self.setup.water;
        let divergence = settings.divergence_tolerance * (water.gravity / water.depth).sqrt();
        Stop {
            relative: settings.tolerance,
            absolute: divergence / divergence_per_residual,
            iterations: settings.max_iterations,
        }
    }

    /// (ρ − ρ*)/ρ of Eq. (9b), with ρ* the mean density: the mass over the volume that the
    /// particles take up now. A particle's own density, from a kernel, is noise of some per cent
    /// that the pressure would answer; shifting evens out what is local, and only where particles
    /// part or crowd beyond that, in broken water, is their own density fed back. Where the surface
    /// is no line, the volume cannot be told by its elevation, and the mean is not fed back.
    fn density_deficit(&mut self) -> f64 {
        if !self.surface_is_a_line() {
            return 0.0;
        }
        let mut line = std::mem::take(&mut self.work.line);
        self.surface_line(&mut line);
        let volume = self.volume_below(&line);
        self.work.line = line;
        (1.0 - self.initial_volume / volume).clamp(-LARGEST_FEEDBACK, LARGEST_FEEDBACK)
    }

    /// Solves Eq. (9b) for p_0, the pressure with every free boundary unaccelerated.
    pub(crate) fn pressure(&mut self, h: f64) -> Result<(), FluidError> {
        let (water, numerics) = (self.setup.water, self.setup.numerics);
        let alpha = numerics.density_blend;
        let square = numerics.particle_spacing.powi(2);
        let too_thin = if alpha > 0.0 { self.density_deficit() } else { 0.0 };
        let mut source = std::mem::take(&mut self.work.source);
        let mut rhs = std::mem::take(&mut self.work.rhs);
        let mut solution = std::mem::take(&mut self.work.solution);
        let kept = self.part_kept(h);
        let particles = &self.state.particles;
        let this = &*self;
        let blocks = solution.par_chunks_mut(BLOCK).zip(source.par_chunks_mut(BLOCK));
        rhs.par_chunks_mut(BLOCK).zip(blocks).enumerate().for_each(
            |(block, (rhs, (solution, source)))| {
                let values = solution.iter_mut().zip(source);
                for (offset, (rhs, (solution, source))) in rhs.iter_mut().zip(values).enumerate() {
                    let i = block * BLOCK + offset;
                    let equation = &this.work.equations[i];
                    *source = 0.0;
                    if this.work.on_surface[i] {
                        *rhs = [0.0];
                        *solution = [0.0];
                        continue;
                    }
                    if equation.diagonal <= 0.0 {
                        *rhs = [this.surface_pressure(i)];
                        *solution = *rhs;
                        continue;
                    }
                    // Eq. (9b): Ψ = α (ρ − ρ*)/dt + (1 − α) ρ ∇·u*.
                    let divergence = equation.divergence - kept * particles.vain_divergence[i];
                    let mut thin = alpha * too_thin;
                    if this.work.broken.is_at(this.work.position[i].x) {
                        thin += CROWDING_FEEDBACK * too_thin_here(equation.crowding);
                    }
                    *source = water.density * (thin / h + (1.0 - alpha) * divergence);
                    rhs[0] = (equation.walls - square * *source / h) / equation.diagonal
                        + equation.surface;
                    // The last pressure, less the part of the accelerations.
                    solution[0] = particles.pressure[i] - this.reaction_pressure(i);
                }
            },
        );
        self.work.source = source;
        self.work.rhs = rhs;
        self.work.solution = solution;
        self.report = self.solve_assembled(h, None)?;
        self.fallbacks += u64::from(self.report.fell_back);
        Ok(())
    }

    /// Solves the assembled equation from the start in `work.solution` with `solver`, or the
    /// fluid's own.
    fn solve_assembled(
        &mut self,
        h: f64,
        solver: Option<(&mut dyn PressureSolver, Stop)>,
    ) -> Result<PressureReport, FluidError> {
        let divergence_per_residual = self.divergence_per_residual(h);
        let scales = self.scales(h);
        let own_stop = self.stop(&self.setup.pressure, divergence_per_residual);
        let (solver, stop) = solver.unwrap_or((&mut *self.solver, own_stop));
        let mut solution = std::mem::take(&mut self.work.solution);
        let fields = Self::fields(&self.setup, &self.state.particles, &self.walls, &self.work);
        let report = solver.solve(Problem {
            matrix: &self.work.matrix,
            rhs: &self.work.rhs,
            pressure: &mut solution,
            change: &self.state.particles.pressure_change,
            source: &self.work.source,
            scales,
            fields,
            step: self.state.step,
            stop,
            divergence_per_residual,
            memory: &mut self.state.pressure,
        });
        self.work.solution = solution;
        report
    }

    /// The pressure of the step before, less the part of the accelerations; zero on the surface, and
    /// that of the surface for particles without an equation, Pa.
    pub(crate) fn last_pressure(&self) -> Vec<[f64; 1]> {
        let equations = self.work.on_surface.iter().zip(&self.work.equations);
        let start = equations.enumerate().map(|(i, (&surface, equation))| match surface {
            true => [0.0],
            false if equation.diagonal <= 0.0 => [self.surface_pressure(i)],
            false => [self.state.particles.pressure[i] - self.reaction_pressure(i)],
        });
        start.collect()
    }

    fn divergence_per_residual(&self, h: f64) -> f64 {
        let square = self.setup.numerics.particle_spacing.powi(2);
        mean_diagonal(&self.work.equations) * h / (self.setup.water.density * square)
    }

    /// From now on the network, where one finds the pressure, is evaluated `elsewhere`.
    pub fn infer(&mut self, elsewhere: Arc<dyn Inference>) {
        self.solver = solver(self.setup.pressure, &self.setup.network, Some(elsewhere));
    }

    /// A solver to compare with, which keeps factors from step to step as a run does, its network
    /// evaluated `elsewhere` if that is given.
    #[must_use]
    pub fn rival(
        &self,
        settings: PressureSettings,
        elsewhere: Option<Arc<dyn Inference>>,
    ) -> Rival {
        let solver = solver(settings, &self.setup.network, elsewhere);
        let (memory, identity, start) = (PressureMemory::default(), Vec::new(), Vec::new());
        Rival { settings, solver, memory, identity, start }
    }

    /// Hands the `rival` what a run's own solver finds ready: the last pressure, in the numbering of the step.
    pub fn prepare(&self, rival: &mut Rival) {
        rival.follow(&self.state.particles.identity);
        rival.start = self.last_pressure();
    }

    /// Solves the pressure equation of the step that is solved but not yet completed once more, by
    /// the `rival`, which is prepared for it, and leaves everything as it was: a comparison of solvers
    /// on the same equation. `None` where no step is solved.
    ///
    /// # Errors
    /// [`FluidError::PressureNotConverged`].
    pub fn try_pressure(
        &mut self,
        rival: &mut Rival,
    ) -> Result<Option<PressureReport>, FluidError> {
        let Some(h) = self.solved_for else { return Ok(None) };
        let start = std::mem::take(&mut rival.start);
        self.solve_again(h, start, rival).map(|(report, _)| Some(report))
    }

    /// Solves the assembled equation from `start` by the `rival`, and leaves everything as it was;
    /// also the solution.
    pub(crate) fn solve_again(
        &mut self,
        h: f64,
        start: Vec<[f64; 1]>,
        rival: &mut Rival,
    ) -> Result<(PressureReport, Vec<[f64; 1]>), FluidError> {
        let stop = self.stop(&rival.settings, self.divergence_per_residual(h));
        let found = std::mem::replace(&mut self.work.solution, start);
        std::mem::swap(&mut self.state.pressure, &mut rival.memory);
        let report = self.solve_assembled(h, Some((&mut *rival.solver, stop)));
        let solution = std::mem::replace(&mut self.work.solution, found);
        std::mem::swap(&mut self.state.pressure, &mut rival.memory);
        Ok((report?, solution))
    }
}

/// A pressure solver beside the fluid's own.
pub struct Rival {
    settings: PressureSettings,
    solver: Box<dyn PressureSolver>,
    memory: PressureMemory,
    /// Identities of the particles of its memory.
    identity: Vec<u32>,
    start: Vec<[f64; 1]>,
}

impl Rival {
    /// Brings the memory to the numbering of the particles of these identities, as that of a run is.
    fn follow(&mut self, identity: &[u32]) {
        if self.identity == identity {
            return;
        }
        let count = self.identity.iter().max().map_or(0, |last| *last as usize + 1);
        let mut old = vec![None; count];
        for (i, identity) in self.identity.iter().enumerate() {
            old[*identity as usize] = Some(i as u32);
        }
        let order = identity.iter().map(|identity| old.get(*identity as usize).copied().flatten());
        match order.collect::<Option<Vec<_>>>() {
            Some(order) => self.memory.renumber(&order),
            // One of them is new.
            None => self.memory = PressureMemory::default(),
        }
        self.identity.clear();
        self.identity.extend_from_slice(identity);
    }
}

/// The solver that `settings` ask for, a network with its inference `elsewhere` or the program's own.
pub(crate) fn solver(
    settings: PressureSettings,
    network: &Network,
    elsewhere: Option<Arc<dyn Inference>>,
) -> Box<dyn PressureSolver> {
    let by_network =
        |guarded: bool| Box::new(NetworkSolver::new(network.clone(), elsewhere, settings, guarded));
    match settings.solver {
        SolverKind::Ppe | SolverKind::Capped => Box::new(Poisson::new(settings)),
        SolverKind::Network => by_network(false),
        SolverKind::Guarded => by_network(true),
    }
}

/// How much less dense than [`EVEN`] the particles stand: below zero where they are crowded.
fn too_thin_here(crowding: f64) -> f64 {
    crowding.clamp(*EVEN.start(), *EVEN.end()) - crowding
}

/// Mean diagonal of the rows before they were scaled by it, from a sample of them.
fn mean_diagonal(equations: &[Equation]) -> f64 {
    const EVERY: usize = 97;
    let sample = equations.iter().step_by(EVERY).map(|equation| equation.diagonal);
    let sample = sample.filter(|d| *d > 0.0);
    let (sum, count) = sample.fold((0.0, 0.0), |(sum, count), d| (sum + d, count + 1.0));
    if count > 0.0 { sum / count } else { 1.0 }
}

/// Zeroes the rows of the surface and of particles without an equation.
fn clear_rows(values: &mut [[f64; 3]], on_surface: &[bool], equations: &[Equation]) {
    for ((value, &surface), equation) in values.iter_mut().zip(on_surface).zip(equations) {
        if surface || equation.diagonal <= 0.0 {
            *value = [0.0; 3];
        }
    }
}
