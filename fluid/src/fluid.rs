//! The fluid component: state, and the stages of a step in their order.
//!
//! A step goes drift, kick, drift: the pressure equation is assembled halfway, at r + u dt/2, and
//! Eq. (12) moves the particles on, which is second order in time and neutral for linear waves
//! where the paper's step, assembled at r + u* dt, damps them.

use crate::component::{Phase, describe};
use crate::error::FluidError;
use crate::fill;
use crate::fit;
use crate::free_surface::{self, Surroundings};
use crate::krylov::{Krylov, Report, Stop};
use crate::loads::{PointPressure, load_on_piece};
use crate::neighbours::{BLOCK, CellGrid, Neighbours};
use crate::operators::{self, Fields, Local, Scratch};
use crate::particles::{Particles, permute};
use crate::plan::{Plan, Stage};
use crate::regularise;
use crate::setup::FluidSetup;
use crate::sparse::{Preconditioner, SparseMatrix};
use crate::walls::{Owner, Walls};
use nalgebra::{Point2, Vector2};
use rayon::prelude::*;
use seakeep_coupler::interface::{BoundaryKinematics, Description, Load, LoadResponse};
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// Part of the drift after which a step is assembled. A wave loses the part (2 θ − 1) π ω dt of its
/// energy a period: all of it with the paper's 1, none with 1/2. As in off-centred implicit schemes,
/// a little more than a half makes up for the energy that the fits add: without it, the standing
/// wave gains 0.07 % a period at D/dx = 20.
const ASSEMBLY_POINT: f64 = 0.52;
/// Steps between two factorizations of the preconditioner.
const FACTORS_LAST: u64 = 8;
/// Steps between two renumberings.
const NUMBERING_LASTS: u64 = 64;
/// Rate of the velocity filter in units of sqrt(g / dx): the part of the roughness that a step
/// takes away is this rate times the step. At walls it also draws the velocity to what the wall
/// demands.
const FILTER_RATE: f64 = 2.0;
/// Tolerance of the pressure of unit accelerations, in pressure tolerances.
const UNIT_TOLERANCE: f64 = 10.0;
/// Largest relative volume error that Eq. (9b) feeds back.
const LARGEST_FEEDBACK: f64 = 0.01;

/// What a saved state holds: everything that the coming steps depend on.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct State {
    pub(crate) start_time: f64,
    pub(crate) time: f64,
    pub(crate) step: u64,
    pub(crate) particles: Particles,
    pub(crate) kinematics: Vec<BoundaryKinematics>,
    pub(crate) accelerations: Vec<f64>,
    /// Pressure of unit accelerations of each free boundary, Pa per m/s² and rad/s².
    pub(crate) unit_pressure: Vec<Vec<[f64; 3]>>,
    pub(crate) wall_activity: Vec<f64>,
    pub(crate) preconditioner: Preconditioner,
    pub(crate) factorized_at: Option<u64>,
    pub(crate) loads: Vec<Load>,
}

/// What a step works on; nothing of it outlives the step but its memory.
#[derive(Default)]
pub(crate) struct Work {
    pub(crate) position: Vec<Point2<f64>>,
    pub(crate) on_surface: Vec<bool>,
    pub(crate) normal: Vec<Vector2<f64>>,
    grid: CellGrid,
    wall_grid: CellGrid,
    pub(crate) fluid: Neighbours,
    pub(crate) wall_lists: Neighbours,
    fluid_of_walls: Neighbours,
    scratch: Vec<Scratch>,
    pub(crate) locals: Vec<Local>,
    matrix: SparseMatrix,
    rhs: Vec<[f64; 1]>,
    solution: Vec<[f64; 1]>,
    unit_rhs: Vec<[f64; 3]>,
    unit_solution: Vec<Vec<[f64; 3]>>,
    krylov: Krylov<1>,
    unit_krylov: Krylov<3>,
    wall_pressure: Vec<PointPressure>,
    /// Dynamic pressure of the step, Pa.
    pressure: Vec<f64>,
    order: Vec<u32>,
    keys: Vec<(u32, u64)>,
    line: Vec<Point2<f64>>,
    scratch_points: Vec<Point2<f64>>,
    scratch_vectors: Vec<Vector2<f64>>,
    scratch_numbers: Vec<f64>,
    scratch_flags: Vec<bool>,
    scratch_identities: Vec<u32>,
    scratch_units: Vec<[f64; 3]>,
}

/// Incompressible water with a free surface in a tank, as particles.
pub struct Fluid {
    pub(crate) setup: FluidSetup,
    pub(crate) description: Description,
    pub(crate) phase: Phase,
    plan: Plan,
    runs: [bool; Stage::ALL.len()],
    pub(crate) state: State,
    pub(crate) walls: Walls,
    pub(crate) work: Work,
    pub(crate) response: LoadResponse,
    /// Length of the step that `work` and `response` are solved for, s.
    pub(crate) solved_for: Option<f64>,
    pub(crate) report: Report,
    pub(crate) unit_report: Report,
    pub(crate) initial_volume: f64,
    stage_time: [Duration; Stage::ALL.len()],
    /// Indices of the free boundaries.
    free: Vec<usize>,
}

impl Fluid {
    /// Fills the tank of `setup` with particles at rest.
    ///
    /// # Errors
    /// [`FluidError`] for a parameter out of range, a boundary that is no simple polygon, or a
    /// spacing that leaves no particle.
    pub fn new(setup: FluidSetup) -> Result<Self, FluidError> {
        setup.validate()?;
        let particles = fill::fill(&setup)?;
        let count = particles.len();
        let walls = Walls::new(&setup);
        let dx = setup.numerics.particle_spacing;
        let radius = fit::RADIUS * dx;
        let low = Point2::new(-radius, -radius);
        let high = Point2::new(setup.tank.length + radius, setup.tank.height + radius);
        let plan = Plan::new(&setup);
        let free: Vec<usize> =
            (0..setup.boundaries.len()).filter(|&b| setup.boundaries[b].free).collect();
        let boundaries = setup.boundaries.len();
        let work = Work {
            grid: CellGrid::new(low, high, radius),
            wall_grid: CellGrid::new(low, high, radius),
            position: particles.position.clone(),
            on_surface: particles.on_surface.clone(),
            normal: vec![Vector2::zeros(); count],
            locals: vec![Local::default(); count],
            rhs: vec![[0.0]; count],
            solution: vec![[0.0]; count],
            unit_rhs: vec![[0.0; 3]; if free.is_empty() { 0 } else { count }],
            unit_solution: vec![vec![[0.0; 3]; count]; free.len()],
            pressure: vec![0.0; count],
            ..Work::default()
        };
        let mut fluid = Self {
            runs: Stage::ALL.map(|stage| plan.runs(stage)),
            plan,
            description: describe(setup.boundaries.iter().map(|b| b.name.as_str())),
            phase: Phase::Instantiated,
            state: State {
                start_time: 0.0,
                time: 0.0,
                step: 0,
                kinematics: setup
                    .boundaries
                    .iter()
                    .map(|b| BoundaryKinematics::at_rest(b.position, b.angle))
                    .collect(),
                accelerations: vec![0.0; 3 * boundaries],
                unit_pressure: vec![vec![[0.0; 3]; count]; free.len()],
                wall_activity: vec![0.0; walls.len()],
                preconditioner: Preconditioner::default(),
                factorized_at: None,
                loads: vec![Load::zero(); boundaries],
                particles,
            },
            walls,
            work,
            response: LoadResponse::zero(boundaries),
            solved_for: None,
            report: Report::default(),
            unit_report: Report::default(),
            initial_volume: 0.0,
            stage_time: [Duration::ZERO; Stage::ALL.len()],
            free,
            setup,
        };
        fluid.settle();
        let mut line = Vec::new();
        fluid.surface_line(&mut line);
        fluid.initial_volume = fluid.volume_below(&line);
        Ok(fluid)
    }

    /// What the fluid was asked to be.
    #[must_use]
    pub fn setup(&self) -> &FluidSetup {
        &self.setup
    }

    /// Which stages a step runs.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.state.time
    }

    /// Steps done.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.state.step
    }

    /// Lets the particles around boundaries, cut out of a lattice, find an even arrangement.
    fn settle(&mut self) {
        const STEPS: usize = 200;
        self.walls.place(&self.state.kinematics, 0.0);
        let setup = &self.setup;
        let below = |x: &Point2<f64>| x.y < setup.water.depth + fill::initial_elevation(setup, x.x);
        self.state.wall_activity =
            self.walls.position.iter().map(|x| f64::from(u8::from(below(x)))).collect();
        let steps = if self.setup.boundaries.is_empty() { 2 } else { STEPS };
        for _ in 0..steps {
            self.neighbours(0.0);
            self.free_surface();
            self.wetted_walls();
            self.operators();
            if !self.setup.boundaries.is_empty() {
                for (x, local) in self.state.particles.position.iter_mut().zip(&self.work.locals) {
                    *x += local.shift;
                }
            }
            self.state.particles.on_surface.copy_from_slice(&self.work.on_surface);
            self.state.wall_activity.copy_from_slice(&self.walls.activity);
        }
        self.renumber();
        self.neighbours(0.0);
        self.free_surface();
        self.wetted_walls();
    }

    /// Runs `stage` if the plan has it, and adds its wall time.
    fn timed<T>(&mut self, stage: Stage, run: impl FnOnce(&mut Self) -> T) -> Option<T> {
        if !self.runs[stage as usize] {
            return None;
        }
        let start = Instant::now();
        let result = run(self);
        self.stage_time[stage as usize] += start.elapsed();
        Some(result)
    }

    /// Everything up to the loads at zero acceleration, for a step of `h` (s).
    pub(crate) fn solve(&mut self, h: f64) -> Result<(), FluidError> {
        for (boundary, kinematics) in self.setup.boundaries.iter().zip(&self.state.kinematics) {
            let k = kinematics;
            let sum = k.position.coords.sum() + k.velocity.sum() + k.angle + k.angular_velocity;
            if !sum.is_finite() {
                return Err(FluidError::Kinematics { boundary: boundary.name.clone() });
            }
        }
        if self.state.step.is_multiple_of(NUMBERING_LASTS) {
            self.timed(Stage::Renumber, Self::renumber);
        }
        self.timed(Stage::Neighbours, |fluid| fluid.neighbours(h));
        self.timed(Stage::FreeSurface, Self::free_surface);
        self.timed(Stage::WettedWalls, Self::wetted_walls);
        self.timed(Stage::Operators, Self::operators);
        self.timed(Stage::AddedMass, Self::added_mass_pressure).transpose()?;
        self.timed(Stage::Pressure, |fluid| fluid.pressure(h)).transpose()?;
        self.timed(Stage::Loads, Self::loads_at_zero_acceleration);
        self.solved_for = Some(h);
        Ok(())
    }

    /// Completes the step of `h` (s) for which the pressure has been solved.
    pub(crate) fn finish(&mut self, h: f64) -> Result<(), FluidError> {
        self.timed(Stage::Correct, |fluid| fluid.correct(h));
        self.timed(Stage::Damping, |fluid| fluid.damp(h));
        self.timed(Stage::Regularise, |fluid| fluid.regularise(h));
        self.check()?;
        self.response.at(&self.state.accelerations, &mut self.state.loads);
        self.state.step += 1;
        self.solved_for = None;
        Ok(())
    }

    /// Midpoint positions of particles and walls, and their neighbours.
    fn neighbours(&mut self, h: f64) {
        let radius = fit::RADIUS * self.setup.numerics.particle_spacing;
        let (work, particles) = (&mut self.work, &self.state.particles);
        work.position
            .par_chunks_mut(BLOCK)
            .zip(particles.position.par_chunks(BLOCK).zip(particles.velocity.par_chunks(BLOCK)))
            .for_each(|(middle, (position, velocity))| {
                for ((middle, x), u) in middle.iter_mut().zip(position).zip(velocity) {
                    *middle = x + u * (ASSEMBLY_POINT * h);
                }
            });
        self.walls.place(&self.state.kinematics, ASSEMBLY_POINT * h);
        work.grid.sort(&work.position);
        work.wall_grid.sort(&self.walls.position);
        let (fluid, walls) = (&work.position, &self.walls.position);
        work.fluid.find(fluid, fluid, &work.grid, radius, |i, j| i != j);
        work.wall_lists.find(fluid, walls, &work.wall_grid, radius, |_, _| true);
        work.fluid_of_walls.find(walls, fluid, &work.grid, radius, |_, _| true);
    }

    fn free_surface(&mut self) {
        self.walls.activity.copy_from_slice(&self.state.wall_activity);
        let work = &mut self.work;
        let around = Surroundings {
            position: &work.position,
            fluid: &work.fluid,
            walls: &work.wall_lists,
            spacing: self.setup.numerics.particle_spacing,
        };
        let last = &self.state.particles.on_surface;
        free_surface::detect(around, &self.walls, last, &mut work.on_surface);
        free_surface::normals(around, &work.on_surface, &mut work.normal);
    }

    fn wetted_walls(&mut self) {
        let work = &self.work;
        let around = Surroundings {
            position: &work.position,
            fluid: &work.fluid,
            walls: &work.wall_lists,
            spacing: self.setup.numerics.particle_spacing,
        };
        let (flags, normal) = (&work.on_surface, &work.normal);
        free_surface::wet(around, flags, normal, &work.fluid_of_walls, &mut self.walls);
    }

    pub(crate) fn fields<'a>(
        setup: &FluidSetup,
        particles: &'a Particles,
        walls: &'a Walls,
        work: &'a Work,
    ) -> Fields<'a> {
        Fields {
            position: &work.position,
            velocity: &particles.velocity,
            on_surface: &work.on_surface,
            normal: &work.normal,
            fluid: &work.fluid,
            wall_lists: &work.wall_lists,
            walls,
            spacing: setup.numerics.particle_spacing,
        }
    }

    fn operators(&mut self) {
        let mut scratch = std::mem::take(&mut self.work.scratch);
        let mut locals = std::mem::take(&mut self.work.locals);
        let mut matrix = std::mem::take(&mut self.work.matrix);
        let fields = Self::fields(&self.setup, &self.state.particles, &self.walls, &self.work);
        operators::assemble(fields, &mut scratch, &mut locals, &mut matrix);
        self.work.scratch = scratch;
        self.work.locals = locals;
        self.work.matrix = matrix;
    }

    /// ∂p/∂n at wall particle `w` that the known accelerations of held and prescribed boundaries
    /// ask for, Eq. (4) for the dynamic pressure, Pa/m.
    fn known_slope(&self, w: usize) -> f64 {
        match self.walls.owner[w] {
            Owner::Boundary(b) if !self.setup.boundaries[b].free => self.slope(w, b, |mode| {
                let k = &self.state.kinematics[b];
                [k.acceleration.x, k.acceleration.y, k.angular_acceleration][mode]
            }),
            _ => 0.0,
        }
    }

    /// ∂p/∂n at wall particle `w` of boundary `b` for its `accelerations`, Pa/m.
    fn slope(&self, w: usize, b: usize, accelerations: impl Fn(usize) -> f64) -> f64 {
        let centre = self.walls.centre[b];
        let normal_acceleration: f64 = (0..3)
            .map(|mode| accelerations(mode) * self.walls.unit_normal_motion(w, mode, centre))
            .sum();
        -self.setup.water.density * normal_acceleration
    }

    /// Dynamic pressure on the surface, Eq. (5): p = 0, Pa.
    fn surface_pressure(&self, i: usize) -> f64 {
        let water = &self.setup.water;
        water.density * water.gravity * (self.work.position[i].y - water.depth)
    }

    fn factorize_if_due(&mut self) {
        let age = self.state.factorized_at.map(|step| self.state.step - step);
        if age.is_none_or(|age| age >= FACTORS_LAST) {
            self.state.preconditioner.factorize(&self.work.matrix, self.state.particles.len());
            self.state.factorized_at = Some(self.state.step);
        }
    }

    /// Solves ∇²p_k = 0, n·∇p_k = −ρ n_k on each free boundary, p_k = 0 on the surface, for unit
    /// accelerations k: the pressure is then p = p_0 + Σ a_k p_k with no iteration.
    fn added_mass_pressure(&mut self) -> Result<(), FluidError> {
        self.factorize_if_due();
        for slot in 0..self.free.len() {
            let boundary = self.free[slot];
            let mut rhs = std::mem::take(&mut self.work.unit_rhs);
            let fields = Self::fields(&self.setup, &self.state.particles, &self.walls, &self.work);
            rhs.par_chunks_mut(BLOCK).enumerate().for_each(|(block, rhs)| {
                for (offset, rhs) in rhs.iter_mut().enumerate() {
                    let i = block * BLOCK + offset;
                    let local = &self.work.locals[i];
                    *rhs = [0.0; 3];
                    if fields.on_surface[i]
                        || local.diagonal <= 0.0
                        || fields.wall_lists.of(i).is_empty()
                    {
                        continue;
                    }
                    for (mode, rhs) in rhs.iter_mut().enumerate() {
                        let sum = operators::neumann(fields, i, |w| {
                            if self.walls.owner[w] == Owner::Boundary(boundary) {
                                self.slope(w, boundary, |k| f64::from(u8::from(k == mode)))
                            } else {
                                0.0
                            }
                        });
                        *rhs = fit::dot(&local.pressure.laplacian, &sum) / local.diagonal;
                    }
                }
            });
            let mut solution = std::mem::take(&mut self.work.unit_solution[slot]);
            solution.copy_from_slice(&self.state.unit_pressure[slot]);
            clear_rows(&mut solution, &self.work.on_surface, &self.work.locals);
            // Its error enters times the acceleration, and the next step starts from it.
            let mut stop = self.stop(0.0);
            stop.relative *= if self.state.step == 0 { 1e-2 } else { UNIT_TOLERANCE };
            let report = self.work.unit_krylov.solve(
                &self.work.matrix,
                &mut self.state.preconditioner,
                &rhs,
                &mut solution,
                stop,
            );
            self.work.unit_rhs = rhs;
            self.work.unit_solution[slot] = solution;
            self.unit_report = report;
            self.require_convergence(report)?;
        }
        Ok(())
    }

    fn stop(&self, absolute: f64) -> Stop {
        let numerics = &self.setup.numerics;
        Stop {
            relative: numerics.pressure_tolerance,
            absolute,
            iterations: numerics.pressure_max_iterations,
        }
    }

    fn require_convergence(&self, report: Report) -> Result<(), FluidError> {
        if report.converged {
            return Ok(());
        }
        Err(FluidError::PressureNotConverged {
            residual: report.residual,
            iterations: report.iterations,
            tolerance: self.setup.numerics.pressure_tolerance,
        })
    }

    /// (ρ − ρ*)/ρ of Eq. (9b), with ρ* the mean density: the mass over the volume that the
    /// particles take up now. A particle's own density, from a kernel, is noise of some per cent
    /// that the pressure would answer; shifting evens out what is local. Where the surface
    /// overturns, its volume cannot be told by its elevation, and nothing is fed back.
    fn density_deficit(&mut self) -> f64 {
        const STEEPEST: f64 = 0.2;
        let overturns = |(n, &surface): (&Vector2<f64>, &bool)| surface && n.y < STEEPEST;
        if self.work.normal.iter().zip(&self.work.on_surface).any(overturns) {
            return 0.0;
        }
        let mut line = std::mem::take(&mut self.work.line);
        self.surface_line(&mut line);
        let volume = self.volume_below(&line);
        self.work.line = line;
        (1.0 - self.initial_volume / volume).clamp(-LARGEST_FEEDBACK, LARGEST_FEEDBACK)
    }

    /// Solves Eq. (9b) for p_0, the pressure with every free boundary unaccelerated.
    fn pressure(&mut self, h: f64) -> Result<(), FluidError> {
        self.factorize_if_due();
        let (water, numerics) = (self.setup.water, self.setup.numerics);
        let alpha = numerics.density_blend;
        let square = numerics.particle_spacing.powi(2);
        let too_thin = if alpha > 0.0 { self.density_deficit() } else { 0.0 };
        let mut rhs = std::mem::take(&mut self.work.rhs);
        let mut solution = std::mem::take(&mut self.work.solution);
        let particles = &self.state.particles;
        let fields = Self::fields(&self.setup, particles, &self.walls, &self.work);
        let this = &*self;
        rhs.par_chunks_mut(BLOCK).zip(solution.par_chunks_mut(BLOCK)).enumerate().for_each(
            |(block, (rhs, solution))| {
                for (offset, (rhs, solution)) in rhs.iter_mut().zip(solution).enumerate() {
                    let i = block * BLOCK + offset;
                    let local = &this.work.locals[i];
                    if fields.on_surface[i] || local.diagonal <= 0.0 {
                        *rhs = [0.0];
                        *solution = [0.0];
                        continue;
                    }
                    // Eq. (9b): Ψ = α (ρ − ρ*)/dt + (1 − α) ρ ∇·u*.
                    let psi =
                        water.density * (alpha * too_thin / h + (1.0 - alpha) * local.divergence);
                    let walls = operators::neumann(fields, i, |w| this.known_slope(w));
                    rhs[0] = (fit::dot(&local.pressure.laplacian, &walls) - square * psi / h)
                        / local.diagonal
                        + operators::dirichlet(fields, i, local, |j| this.surface_pressure(j));
                    // Guess: the last pressure carried on, less the part of the accelerations.
                    let units: f64 = this
                        .free
                        .iter()
                        .zip(&this.work.unit_solution)
                        .map(|(&b, unit)| {
                            let a = &this.state.accelerations[3 * b..3 * b + 3];
                            a[0] * unit[i][0] + a[1] * unit[i][1] + a[2] * unit[i][2]
                        })
                        .sum();
                    solution[0] = particles.pressure[i] + particles.pressure_change[i] - units;
                }
            },
        );
        // A residual below this leaves a divergence below 1e-7 sqrt(g/D).
        let floor = 1e-7 * square * water.density / h * (water.gravity / water.depth).sqrt();
        let stop = self.stop(floor);
        self.report = self.work.krylov.solve(
            &self.work.matrix,
            &mut self.state.preconditioner,
            &rhs,
            &mut solution,
            stop,
        );
        self.work.rhs = rhs;
        self.work.solution = solution;
        self.require_convergence(self.report)
    }

    /// F_0 and A of F = F_0 − A a, Eqs. (19) and (20).
    fn loads_at_zero_acceleration(&mut self) {
        let mut wall_pressure = std::mem::take(&mut self.work.wall_pressure);
        let fields = Self::fields(&self.setup, &self.state.particles, &self.walls, &self.work);
        let water = &self.setup.water;
        let mut response = std::mem::replace(&mut self.response, LoadResponse::zero(0));
        let (at_zero, added_mass) = (&mut response.at_zero_acceleration, &mut response.added_mass);
        at_zero.fill(Load::zero());
        added_mass.fill(0.0);
        for (b, total) in at_zero.iter_mut().enumerate() {
            let range = self.walls.of_boundary(b);
            let centre = self.walls.centre[b];
            wall_pressure.resize_with(range.len().max(wall_pressure.len()), Default::default);
            wall_pressure[..range.len()].par_iter_mut().enumerate().for_each(|(k, functional)| {
                let w = range.start + k;
                if self.walls.wetted[w] > 0.0 {
                    let around = self.work.fluid_of_walls.of(w).iter().copied();
                    functional.build(fields, self.walls.position[w], around, range.clone());
                }
            });
            for (w, functional) in range.clone().zip(&wall_pressure) {
                let wetted = self.walls.wetted[w];
                if wetted == 0.0 {
                    continue;
                }
                let value = |i: usize| {
                    if fields.on_surface[i] {
                        self.surface_pressure(i)
                    } else {
                        self.work.solution[i][0]
                    }
                };
                let dynamic = functional.evaluate(value, |w| self.known_slope(w));
                let (normal, length) = (self.walls.normal[w], self.walls.length[w] * wetted);
                let point = self.walls.wetted_middle[w];
                let hydrostatic = water.density * water.gravity * (water.depth - point.y);
                let load = load_on_piece(normal, length, point, centre, dynamic + hydrostatic);
                total.force += load.force;
                total.torque += load.torque;
                for (slot, &other) in self.free.iter().enumerate() {
                    for mode in 0..3 {
                        let unit = functional.evaluate(
                            |i| self.work.unit_solution[slot][i][mode],
                            |w| {
                                if self.walls.owner[w] == Owner::Boundary(other) {
                                    self.slope(w, other, |k| f64::from(u8::from(k == mode)))
                                } else {
                                    0.0
                                }
                            },
                        );
                        let reaction = load_on_piece(normal, length, point, centre, unit);
                        let column = 3 * other + mode;
                        added_mass[(3 * b, column)] -= reaction.force.x;
                        added_mass[(3 * b + 1, column)] -= reaction.force.y;
                        added_mass[(3 * b + 2, column)] -= reaction.torque;
                    }
                }
            }
        }
        self.response = response;
        self.work.wall_pressure = wall_pressure;
    }

    /// Eqs. (10) to (12): velocity from the pressure gradient at the midpoint, then half a drift.
    fn correct(&mut self, h: f64) {
        let mut pressure = std::mem::take(&mut self.work.pressure);
        let this = &*self;
        pressure.par_chunks_mut(BLOCK).enumerate().for_each(|(block, pressure)| {
            for (offset, pressure) in pressure.iter_mut().enumerate() {
                let i = block * BLOCK + offset;
                *pressure = if this.work.on_surface[i] {
                    this.surface_pressure(i)
                } else {
                    let units: f64 = this
                        .free
                        .iter()
                        .zip(&this.work.unit_solution)
                        .map(|(&b, unit)| {
                            let a = &this.state.accelerations[3 * b..3 * b + 3];
                            a[0] * unit[i][0] + a[1] * unit[i][1] + a[2] * unit[i][2]
                        })
                        .sum();
                    this.work.solution[i][0] + units
                };
            }
        });
        let mut velocity = std::mem::take(&mut self.work.scratch_vectors);
        velocity.resize(pressure.len(), Vector2::zeros());
        let this = &*self;
        let fields = Self::fields(&this.setup, &this.state.particles, &this.walls, &this.work);
        let water = &this.setup.water;
        let slope = |w: usize| match this.walls.owner[w] {
            Owner::Boundary(b) if this.setup.boundaries[b].free => {
                this.slope(w, b, |mode| this.state.accelerations[3 * b + mode])
            }
            _ => this.known_slope(w),
        };
        let viscous = this.runs[Stage::Viscosity as usize];
        velocity.par_chunks_mut(BLOCK).enumerate().for_each(|(block, velocity)| {
            for (offset, velocity) in velocity.iter_mut().enumerate() {
                let i = block * BLOCK + offset;
                let local = &this.work.locals[i];
                let mut acceleration = if local.quality == fit::Quality::None {
                    // Alone in the air: free fall.
                    Vector2::new(0.0, -water.gravity)
                } else {
                    let walls = operators::neumann(fields, i, slope);
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
        for ((x, old), new) in
            particles.position.iter_mut().zip(&mut particles.velocity).zip(&velocity)
        {
            *x += (*old + new) * (0.5 * h);
            *old = *new;
        }
        for (i, value) in pressure.iter().enumerate() {
            particles.pressure_change[i] = value - particles.pressure[i];
            particles.pressure[i] = *value;
        }
        particles.on_surface.copy_from_slice(&self.work.on_surface);
        self.state.wall_activity.copy_from_slice(&self.walls.activity);
        for (state, work) in self.state.unit_pressure.iter_mut().zip(&self.work.unit_solution) {
            state.copy_from_slice(work);
        }
        self.work.pressure = pressure;
        self.work.scratch_vectors = velocity;
    }

    /// u ← u / (1 + γ(x) dt) in the damping zones.
    fn damp(&mut self, h: f64) {
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

    /// Shifts particles, their velocity with them, and filters what no fit can resolve.
    fn regularise(&mut self, h: f64) {
        let spacing = self.setup.numerics.particle_spacing;
        let rate = FILTER_RATE * (self.setup.water.gravity / spacing).sqrt();
        let part = (rate * h).min(0.5);
        let particles = &mut self.state.particles;
        for ((x, u), local) in
            particles.position.iter_mut().zip(&mut particles.velocity).zip(&self.work.locals)
        {
            *x += local.shift;
            *u += local.shift_velocity + local.roughness * part;
            *u = regularise::collide(*u, local.contact, spacing, h);
        }
    }

    fn check(&self) -> Result<(), FluidError> {
        let particles = &self.state.particles;
        let margin = 3.0 * self.setup.numerics.particle_spacing;
        for (i, (x, u)) in particles.position.iter().zip(&particles.velocity).enumerate() {
            let inside = x.x > -margin && x.x < self.setup.tank.length + margin && x.y > -margin;
            if !(inside && x.y.is_finite() && u.norm_squared().is_finite()) {
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

    /// Numbers the particles column by column along the tank.
    fn renumber(&mut self) {
        let dx = self.setup.numerics.particle_spacing;
        let (work, particles) = (&mut self.work, &mut self.state.particles);
        work.keys.clear();
        work.keys.extend(particles.position.iter().enumerate().map(|(i, x)| {
            let column = (x.x / dx).max(0.0) as u64;
            // Heights in millionths of a spacing sort as whole numbers.
            let height = ((x.y / dx + 1e3).max(0.0) * 1e6) as u64;
            (i as u32, (column << 40) | height.min((1 << 40) - 1))
        }));
        work.keys.sort_unstable_by_key(|&(i, key)| (key, i));
        work.order.clear();
        work.order.extend(work.keys.iter().map(|&(i, _)| i));
        let order = &work.order;
        permute(&mut particles.position, order, &mut work.scratch_points);
        permute(&mut particles.velocity, order, &mut work.scratch_vectors);
        permute(&mut particles.pressure, order, &mut work.scratch_numbers);
        permute(&mut particles.pressure_change, order, &mut work.scratch_numbers);
        permute(&mut particles.on_surface, order, &mut work.scratch_flags);
        permute(&mut particles.identity, order, &mut work.scratch_identities);
        for unit in &mut self.state.unit_pressure {
            permute(unit, order, &mut work.scratch_units);
        }
        // The factors belong to the old numbering.
        self.state.factorized_at = None;
    }

    /// Wall time of each stage that the plan keeps, summed over the steps so far.
    pub fn stage_times(&self) -> impl Iterator<Item = (Stage, Duration)> + '_ {
        Stage::ALL
            .into_iter()
            .filter(|stage| self.runs[*stage as usize])
            .map(|stage| (stage, self.stage_time[stage as usize]))
    }
}

/// Zeroes the rows of the surface and of particles without an equation.
fn clear_rows(values: &mut [[f64; 3]], on_surface: &[bool], locals: &[Local]) {
    for ((value, &surface), local) in values.iter_mut().zip(on_surface).zip(locals) {
        if surface || local.diagonal <= 0.0 {
            *value = [0.0; 3];
        }
    }
}
