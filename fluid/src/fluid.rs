//! The fluid component: state, and the stages of a step in their order.
//!
//! A step goes drift, kick, drift: the pressure equation is assembled halfway, at r + u dt/2, and
//! Eq. (12) moves the particles on, which is second order in time and neutral for linear waves
//! where the paper's step, assembled at r + u* dt, damps them. A set-up may ask for the latter.

use crate::error::FluidError;
use crate::fields::Fields;
use crate::fill;
use crate::fit;
use crate::frame::Frame;
use crate::free_surface::{self, Surroundings};
use crate::krylov::Report;
use crate::neighbours::{BLOCK, CellGrid};
use crate::operators;
use crate::particles::Particles;
use crate::plan::{Plan, Stage};
use crate::pressure;
use crate::pressure::solver::{PressureMemory, PressureReport, PressureSolver};
use crate::setup::{FluidSetup, InitialFlow, StillWater};
use crate::state::{Phase, State, Work};
use crate::trial::{Outcome, Trial};
use crate::variables::describe;
use crate::walls::Walls;
use nalgebra::Point2;
use rayon::prelude::*;
use seakeep_coupler::interface::{BoundaryKinematics, Description, Load, LoadResponse};
use std::time::{Duration, Instant};

/// Steps between two resamplings of the surface, with new numbers: a whole number of times as long
/// as the factors of the preconditioner last.
const NUMBERING_LASTS: u64 = 8;

/// Incompressible water with a free surface in a tank, as particles.
pub struct Fluid {
    pub(crate) setup: FluidSetup,
    pub(crate) description: Description,
    pub(crate) phase: Phase,
    plan: Plan,
    pub(crate) runs: [bool; Stage::ALL.len()],
    pub(crate) state: State,
    pub(crate) walls: Walls,
    pub(crate) work: Work,
    pub(crate) response: LoadResponse,
    /// Length of the step that `work` and `response` are solved for, s.
    pub(crate) solved_for: Option<f64>,
    pub(crate) solver: Box<dyn PressureSolver>,
    pub(crate) report: PressureReport,
    pub(crate) fallbacks: u64,
    pub(crate) unit_report: Report,
    /// Whether the next step's frame is wanted, and the last that was.
    pub(crate) recording: bool,
    pub(crate) frame: Option<Frame>,
    /// What is to be tried in the next step, and what came of it.
    pub(crate) trials: Vec<Trial>,
    pub(crate) outcomes: Vec<Outcome>,
    pub(crate) initial_volume: f64,
    stage_time: [Duration; Stage::ALL.len()],
    /// Indices of the free boundaries.
    pub(crate) free: Vec<usize>,
}

impl Fluid {
    /// Fills the tank of `setup` with particles at rest.
    ///
    /// # Errors
    /// As [`Self::flowing`].
    pub fn new(setup: FluidSetup) -> Result<Self, FluidError> {
        Self::flowing(setup, &StillWater)
    }

    /// Fills the tank of `setup` with particles that flow like `flow`.
    ///
    /// # Errors
    /// [`FluidError`] for a parameter out of range, a boundary that is no simple polygon, or a
    /// spacing that leaves no particle.
    pub fn flowing(setup: FluidSetup, flow: &dyn InitialFlow) -> Result<Self, FluidError> {
        setup.validate()?;
        let (particles, cut) = fill::fill(&setup, flow)?;
        let count = particles.len();
        let walls = Walls::new(&setup);
        let dx = setup.numerics.particle_spacing;
        let radius = fit::RADIUS * dx;
        let low = Point2::new(-setup.behind() - radius, -radius);
        let high = Point2::new(setup.tank.length + radius, setup.tank.height + radius);
        let plan = Plan::new(&setup);
        let free: Vec<usize> =
            (0..setup.boundaries.len()).filter(|&b| setup.boundaries[b].free).collect();
        let boundaries = setup.boundaries.len();
        let mut work = Work {
            grid: CellGrid::new(low, high, radius),
            wall_grid: CellGrid::new(low, high, radius),
            unit_solution: vec![Vec::new(); free.len()],
            ..Work::default()
        };
        work.resize(count);
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
                pressure: PressureMemory::default(),
                loads: vec![Load::zero(); boundaries],
                next_identity: count as u32,
                lost: 0,
                particles,
            },
            walls,
            work,
            response: LoadResponse::zero(boundaries),
            solved_for: None,
            solver: pressure::solver(setup.pressure, &setup.network, None),
            report: PressureReport::default(),
            fallbacks: 0,
            unit_report: Report::default(),
            recording: false,
            frame: None,
            trials: Vec::new(),
            outcomes: Vec::new(),
            initial_volume: 0.0,
            stage_time: [Duration::ZERO; Stage::ALL.len()],
            free,
            setup,
        };
        fluid.settle(flow, cut);
        fluid.initial_volume = fluid.volume();
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

    /// Solves that another solver than the one asked for had to finish.
    #[must_use]
    pub fn fallback_count(&self) -> u64 {
        self.fallbacks
    }

    /// Steps done.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.state.step
    }

    /// Finds which walls are wet and, where a boundary has `cut` the lattice, lets the particles
    /// find an even arrangement.
    fn settle(&mut self, flow: &dyn InitialFlow, cut: bool) {
        const STEPS: usize = 200;
        self.walls.place(&self.state.kinematics, 0.0);
        let depth = self.setup.water.depth;
        let below = |x: &Point2<f64>| x.y < depth + flow.elevation(x.x);
        self.state.wall_activity =
            self.walls.position.iter().map(|x| f64::from(u8::from(below(x)))).collect();
        let steps = if cut { STEPS } else { 2 };
        for _ in 0..steps {
            self.neighbours(0.0);
            self.free_surface();
            self.wetted_walls();
            self.operators();
            if cut {
                for (x, local) in self.state.particles.position.iter_mut().zip(&self.work.locals) {
                    *x += local.shift;
                }
            }
            self.state.particles.on_surface.copy_from_slice(&self.work.on_surface);
            self.state.wall_activity.copy_from_slice(&self.walls.activity);
        }
        self.resample();
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
            self.timed(Stage::Resample, Self::resample);
        }
        self.timed(Stage::Neighbours, |fluid| fluid.neighbours(h));
        self.timed(Stage::FreeSurface, Self::free_surface);
        self.timed(Stage::WettedWalls, Self::wetted_walls);
        self.timed(Stage::Operators, Self::operators);
        self.timed(Stage::AddedMass, Self::added_mass_pressure).transpose()?;
        self.timed(Stage::Pressure, |fluid| fluid.pressure(h)).transpose()?;
        self.keep_frame(h)?;
        self.try_solvers(h)?;
        self.timed(Stage::Loads, |fluid| fluid.loads_at_zero_acceleration(h)).transpose()?;
        self.solved_for = Some(h);
        Ok(())
    }

    /// Completes the step of `h` (s) for which the pressure has been solved.
    pub(crate) fn finish(&mut self, h: f64) -> Result<(), FluidError> {
        self.timed(Stage::Correct, |fluid| fluid.correct(h));
        self.timed(Stage::Correct, |fluid| fluid.measure_vain_divergence(h));
        self.timed(Stage::Damping, |fluid| fluid.damp(h));
        self.timed(Stage::Regularise, |fluid| fluid.regularise(h));
        self.check()?;
        self.response.at(&self.state.accelerations, &mut self.state.loads);
        self.state.step += 1;
        self.solved_for = None;
        Ok(())
    }

    /// Positions of particles and walls where the step is assembled, and their neighbours.
    pub(crate) fn neighbours(&mut self, h: f64) {
        let radius = fit::RADIUS * self.setup.numerics.particle_spacing;
        let drift = self.setup.assembly_time(h);
        let (work, particles) = (&mut self.work, &self.state.particles);
        work.position
            .par_chunks_mut(BLOCK)
            .zip(particles.position.par_chunks(BLOCK).zip(particles.velocity.par_chunks(BLOCK)))
            .for_each(|(middle, (position, velocity))| {
                for ((middle, x), u) in middle.iter_mut().zip(position).zip(velocity) {
                    *middle = x + u * drift;
                }
            });
        self.walls.place(&self.state.kinematics, drift);
        work.grid.sort(&work.position);
        work.wall_grid.sort(&self.walls.position);
        let (fluid, walls) = (&work.position, &self.walls.position);
        work.fluid.find(fluid, &work.grid, radius, |i, j| i != j);
        work.wall_lists.find(fluid, &work.wall_grid, radius, |_, _| true);
        work.fluid_of_walls.find(walls, &work.grid, radius, |_, _| true);
        let spacing = self.setup.numerics.particle_spacing;
        let lists = (&mut work.fluid, &work.wall_lists, &mut work.fluid_of_walls);
        work.spray.part(fluid, spacing, lists.0, lists.1, lists.2);
    }

    pub(crate) fn free_surface(&mut self) {
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
        let depth = self.setup.water.depth;
        work.broken.find(&work.position, &work.on_surface, &work.normal, depth);
    }

    pub(crate) fn wetted_walls(&mut self) {
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
            discretisation: setup.numerics.discretisation,
        }
    }

    pub(crate) fn operators(&mut self) {
        self.assemble(Self::known_slope, Self::surface_pressure);
    }

    /// The operators, and the equations for walls with ∂p/∂n = `slope(w)` (Pa/m) and surface particles
    /// of `surface_pressure(j)` (Pa): those of the water, or of a manufactured solution.
    pub(crate) fn assemble(
        &mut self,
        slope: impl Fn(&Self, usize) -> f64 + Sync,
        surface_pressure: impl Fn(&Self, usize) -> f64 + Sync,
    ) {
        let mut scratch = std::mem::take(&mut self.work.scratch);
        let mut locals = std::mem::take(&mut self.work.locals);
        let mut equations = std::mem::take(&mut self.work.equations);
        let mut matrix = std::mem::take(&mut self.work.matrix);
        let fields = Self::fields(&self.setup, &self.state.particles, &self.walls, &self.work);
        operators::assemble(
            fields,
            |w| slope(self, w),
            |j| surface_pressure(self, j),
            &mut scratch,
            &mut locals,
            &mut equations,
            &mut matrix,
        );
        self.work.scratch = scratch;
        self.work.locals = locals;
        self.work.equations = equations;
        self.work.matrix = matrix;
    }

    /// Wall time of each stage that the plan keeps, summed over the steps so far.
    pub fn stage_times(&self) -> impl Iterator<Item = (Stage, Duration)> + '_ {
        Stage::ALL
            .into_iter()
            .filter(|stage| self.runs[*stage as usize])
            .map(|stage| (stage, self.stage_time[stage as usize]))
    }
}
