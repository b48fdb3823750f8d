//! The components of a run and what is read off them: the only place that drives them.

use crate::case::EngineName;
use crate::output::rows::DiagnosticsRow;
use crate::scene::Scene;
use crate::tally::CouplingTally;
use crate::waves::WaveError;
use nalgebra::{DMatrix, Point2, Vector2};
use seakeep_body::{
    BodyError, BodyProperties, FreeDegrees, LineState, NewtonEulerEngine, RapierEngine,
    RigidBodies, RigidBodyEngine,
};
use seakeep_coupler::interface::{BoundaryKinematics, Load, LoadComponent, MotionComponent};
use seakeep_coupler::{CouplerError, FixedStepMaster};
use seakeep_fluid::frame::Frame;
use seakeep_fluid::network::Inference;
use seakeep_fluid::setup::InitialFlow;
use seakeep_fluid::trial::{Outcome, Trial};
use seakeep_fluid::{Fluid, FluidError, ParticleCounts, ParticlesView, Plan};
use std::sync::Arc;
use std::time::Duration;
use thiserror::Error;

/// Why a simulation cannot start or go on.
#[derive(Debug, Error)]
pub enum SimulationError {
    /// The fluid cannot be set up.
    #[error("fluid: {0}")]
    Fluid(#[from] FluidError),
    /// A body cannot be set up.
    #[error("body: {0}")]
    Body(#[from] BodyError),
    /// The device that the network is to be evaluated on cannot be used.
    #[error("{0}")]
    Device(String),
    /// The wave cannot be.
    #[error("wave: {0}")]
    Wave(#[from] WaveError),
    /// A step failed.
    #[error(transparent)]
    Coupling(#[from] CouplerError),
}

/// A fluid and, where the scene has bodies, their motion, coupled.
pub struct Simulation {
    fluid: Fluid,
    bodies: Option<RigidBodies>,
    master: FixedStepMaster,
    /// Of the whole run.
    tally: CouplingTally,
    /// Since the last sample.
    recent: CouplingTally,
    /// The paddle among the bodies, where it absorbs waves.
    absorbing: Option<usize>,
}

/// One row of every series.
#[derive(Clone, Debug, Default)]
pub struct Sample {
    /// Time, s.
    pub time: f64,
    /// Kinematics of every body.
    pub motion: Vec<BoundaryKinematics>,
    /// Load on every body over the step that ended now; empty at the start.
    pub loads: Vec<Load>,
    /// Every mooring line.
    pub lines: Vec<LineState>,
    /// Elevation above still water at every gauge, m.
    pub elevations: Vec<Option<f64>>,
    /// Where every probe is, m.
    pub places: Vec<Point2<f64>>,
    /// Pressure at every probe, Pa.
    pub pressures: Vec<Option<f64>>,
    /// Velocity of the water at every probe, m/s.
    pub velocities: Vec<Option<Vector2<f64>>>,
    /// State of health.
    pub diagnostics: DiagnosticsRow,
    /// Largest speed in the water, m/s.
    pub max_speed: f64,
    /// Largest departure from hydrostatic pressure, Pa.
    pub max_hydrostatic_pressure_error: f64,
}

/// A particle in a frame: x, y (m), u, v (m/s), p (Pa).
pub type FramePoint = [f32; 5];

impl Simulation {
    /// Sets the components of `scene` up and initializes them at time 0.
    ///
    /// # Errors
    /// When a component refuses its set-up.
    pub fn start(scene: &Scene) -> Result<Self, SimulationError> {
        let water = scene.still_water();
        let plan = scene.wave.as_ref();
        let wave = plan.map(|plan| plan.initial_flow(water)).transpose()?.flatten();
        let flow: &dyn InitialFlow = match &wave {
            Some(wave) => wave,
            None => &scene.initial_water,
        };
        let mut fluid = Fluid::flowing(scene.fluid.clone(), &scene.displacement.of(flow))?;
        if let Some(elsewhere) = inference(scene)? {
            fluid.infer(elsewhere);
        }
        let mut bodies = match scene.fluid.boundaries.as_slice() {
            [] => None,
            _ => Some(rigid_bodies(scene)?),
        };
        let maker = plan.map(|plan| plan.wavemaker(water)).transpose()?.flatten();
        let mut absorbing = None;
        if let (Some(maker), Some(paddle), Some(bodies)) =
            (maker, scene.fluid.tank.paddle, &mut bodies)
        {
            absorbing = maker.target(0.0).map(|_| paddle);
            bodies.prescribe(paddle, Box::new(maker))?;
        }
        let motion = bodies.as_mut().map(|bodies| bodies as &mut dyn MotionComponent);
        let step = scene.communication_step();
        let master = FixedStepMaster::start_with(scene.coupling, 0.0, step, &mut fluid, motion)?;
        let tally = CouplingTally::default();
        Ok(Self { fluid, bodies, master, tally, recent: tally, absorbing })
    }

    /// Tells the paddle the elevation in front of it.
    fn observe(&mut self) -> Result<(), SimulationError> {
        let (Some(paddle), Some(bodies)) = (self.absorbing, &mut self.bodies) else {
            return Ok(());
        };
        let setup = self.fluid.setup();
        let board = bodies.kinematics()[paddle];
        let face = board.position.x - board.angle.tan() * (setup.water.depth - board.position.y);
        let x = face + 0.5 * setup.numerics.particle_spacing;
        if let Some(elevation) = self.fluid.surface_elevation(x) {
            bodies.observe_elevation(paddle, elevation)?;
        }
        Ok(())
    }

    /// Takes one communication step.
    ///
    /// # Errors
    /// When a component fails; the simulation cannot go on then, but can still be read.
    pub fn step(&mut self) -> Result<(), SimulationError> {
        self.observe()?;
        let motion = self.bodies.as_mut().map(|bodies| bodies as &mut dyn MotionComponent);
        let report = self.master.step(&mut self.fluid, motion)?;
        self.tally.add(&report);
        self.recent.add(&report);
        Ok(())
    }

    /// Asks for the frame of the next step.
    pub fn record_frame(&mut self) {
        self.fluid.record_frame();
    }

    /// The frame that was asked for.
    pub fn take_frame(&mut self) -> Option<Frame> {
        self.fluid.take_frame()
    }

    /// Asks for trials of other pressure solvers in the next step.
    pub fn try_at_next_step(&mut self, trials: Vec<Trial>) {
        self.fluid.try_at_next_step(trials);
    }

    /// What came of the trials.
    pub fn take_outcomes(&mut self) -> Vec<Outcome> {
        self.fluid.take_outcomes()
    }

    /// Time, s.
    #[must_use]
    pub fn time(&self) -> f64 {
        self.master.time()
    }

    /// Steps taken.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.master.step_count()
    }

    /// Kinematics of every body, in the order of the scene.
    #[must_use]
    pub fn kinematics(&self) -> &[BoundaryKinematics] {
        self.bodies.as_ref().map_or(&[], |bodies| bodies.kinematics())
    }

    /// What the coupling has cost and made so far.
    #[must_use]
    pub fn coupling_tally(&self) -> &CouplingTally {
        &self.tally
    }

    /// Reads off what `scene` measures. What the coupling did is that since the last sample.
    #[must_use]
    pub fn sample(&mut self, scene: &Scene) -> Sample {
        let recent = std::mem::take(&mut self.recent);
        let found = self.fluid.diagnostics();
        let loads = if self.steps() == 0 { &[] } else { self.fluid.loads() };
        let elevation = |gauge: &crate::instruments::Gauge| self.fluid.surface_elevation(gauge.x);
        let motion = self.kinematics().to_vec();
        let places: Vec<_> = scene.probes.iter().map(|probe| probe.place(&motion)).collect();
        Sample {
            time: self.time(),
            lines: scene.lines.iter().map(|line| line.line.at(&motion[line.body])).collect(),
            motion,
            loads: loads.to_vec(),
            elevations: scene.gauges.iter().map(elevation).collect(),
            pressures: places.iter().map(|place| self.fluid.pressure_at(*place)).collect(),
            velocities: places.iter().map(|place| self.fluid.velocity_at(*place)).collect(),
            places,
            diagnostics: DiagnosticsRow {
                time_s: self.time(),
                kinetic_energy_j_per_m: found.kinetic_energy,
                potential_energy_j_per_m: found.potential_energy,
                volume_error: found.volume_error,
                divergence_rms_per_s: found.divergence_rms,
                density_error_rms: found.density_error_rms,
                pressure_iterations: found.pressure_iterations as u64,
                pressure_residual: found.pressure_residual,
                particles_active: found.particles_active as u64,
                load_evaluations: recent.load_evaluations,
                coupling_residual: recent.residual_largest,
                power_bond_residual_j_per_m: recent.power_bond_residual_j_per_m,
            },
            max_speed: found.max_speed,
            max_hydrostatic_pressure_error: found.max_hydrostatic_pressure_error,
        }
    }

    /// Elevation above still water at `x` (m), m.
    #[must_use]
    pub fn surface_elevation(&self, x: f64) -> Option<f64> {
        self.fluid.surface_elevation(x)
    }

    /// The particles as they are.
    #[must_use]
    pub fn particles(&self) -> ParticlesView<'_> {
        self.fluid.particles()
    }

    /// The particles as a frame of the results has them.
    #[must_use]
    pub fn frame(&self) -> Vec<FramePoint> {
        let view = self.particles();
        view.position
            .iter()
            .zip(view.velocity)
            .zip(self.fluid.pressures())
            .map(|((x, u), p)| [x.x, x.y, u.x, u.y, p].map(|value| value as f32))
            .collect()
    }

    /// Pressure solves that another solver than the one asked for had to finish.
    #[must_use]
    pub fn fallback_count(&self) -> u64 {
        self.fluid.fallback_count()
    }

    /// How many particles there are.
    #[must_use]
    pub fn particle_counts(&self) -> ParticleCounts {
        self.fluid.particle_counts()
    }

    /// Added-mass matrix of the last step, three rows a body: kg/m, kg, kg m²/m.
    #[must_use]
    pub fn added_mass(&self) -> &DMatrix<f64> {
        self.fluid.added_mass()
    }

    /// Wall time of every stage of the fluid's step so far.
    #[must_use]
    pub fn stage_times(&self) -> Vec<(String, Duration)> {
        self.fluid.stage_times().map(|(stage, time)| (stage.to_string(), time)).collect()
    }

    /// Ends the simulation. It can still be read.
    pub fn finish(&mut self) {
        let motion = self.bodies.as_mut().map(|bodies| bodies as &mut dyn MotionComponent);
        self.master.clone().finish(&mut self.fluid, motion);
    }
}

/// The stages of the fluid's step: name, whether it is kept, and why.
#[must_use]
pub fn fluid_stages(scene: &Scene) -> Vec<(String, bool, String)> {
    let entries = Plan::new(&scene.fluid).entries;
    entries.into_iter().map(|e| (e.stage.to_string(), e.kept, e.reason.to_owned())).collect()
}

fn rigid_bodies(scene: &Scene) -> Result<RigidBodies, BodyError> {
    let engine: Box<dyn RigidBodyEngine> = match scene.engine {
        EngineName::NewtonEuler => Box::new(NewtonEulerEngine::new()),
        EngineName::Rapier | EngineName::Prescribed => {
            Box::new(RapierEngine::with_contacts(scene.contacts))
        }
    };
    let mut bodies = RigidBodies::new(properties(scene), scene.fluid.water.gravity, engine)?;
    for (index, body) in scene.bodies.iter().enumerate() {
        if let Some(motion) = &body.motion {
            bodies.prescribe(index, motion.boxed())?;
        }
    }
    for line in &scene.lines {
        bodies.add_own_load(line.body, Box::new(line.line))?;
    }
    bodies.with_substeps(scene.substeps)
}

/// The bodies, and after them the boundaries that are none: what moves those is prescribed.
fn properties(scene: &Scene) -> Vec<BodyProperties> {
    let boundaries = scene.fluid.boundaries.iter().enumerate();
    boundaries
        .map(|(index, boundary)| match scene.bodies.get(index) {
            Some(body) => {
                let [sway, heave, roll] = body.free;
                BodyProperties {
                    angle: boundary.angle,
                    equilibrium: body.equilibrium,
                    // A container is no obstacle to what is in it.
                    outline: match boundary.holds_water() {
                        true => Vec::new(),
                        false => boundary.corners.clone(),
                    },
                    free: FreeDegrees { sway, heave, roll },
                    ..BodyProperties::new(&body.name, body.mass, body.inertia, boundary.position)
                }
            }
            None => BodyProperties {
                free: FreeDegrees::NONE,
                ..BodyProperties::new(&boundary.name, 1.0, 1.0, boundary.position)
            },
        })
        .collect()
}

/// Position of a body relative to its equilibrium: sway, heave (m) and roll (rad).
#[must_use]
pub fn displacement(kinematics: &BoundaryKinematics, equilibrium: Point2<f64>) -> [f64; 3] {
    let moved = kinematics.position - equilibrium;
    [moved.x, moved.y, kinematics.angle]
}

/// The inference of the network on the device of `scene`, where that is not by the program's own code.
///
/// # Errors
/// [`SimulationError::Device`] where the device cannot be used.
#[cfg(feature = "torch")]
pub fn inference(scene: &Scene) -> Result<Option<Arc<dyn Inference>>, SimulationError> {
    use crate::case::Device;
    use seakeep_fluid::network::SHIPPED;
    use seakeep_learning::{DeviceNetwork, StepByStep, place, use_threads};

    let name = match scene.device {
        Device::Own => return Ok(None),
        Device::Cpu => "cpu",
        Device::Cuda => "cuda",
    };
    let unusable = |reason: &dyn std::fmt::Display| SimulationError::Device(reason.to_string());
    let read = scene.weights.as_ref().map(std::fs::read).transpose();
    let bytes = read.map_err(|error| unusable(&error))?;
    let place = place(name).map_err(|error| unusable(&error))?;
    use_threads(rayon::current_num_threads());
    let network = DeviceNetwork::new(bytes.as_deref().unwrap_or(SHIPPED), place)
        .map_err(|error| unusable(&error))?;
    Ok(Some(Arc::new(StepByStep::new(network))))
}

/// Without the feature `torch` a case cannot ask for a device.
///
/// # Errors
/// Never.
#[cfg(not(feature = "torch"))]
pub fn inference(_scene: &Scene) -> Result<Option<Arc<dyn Inference>>, SimulationError> {
    Ok(None)
}
