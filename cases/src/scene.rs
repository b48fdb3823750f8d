//! A case in the terms of the components: what is simulated, measured and written.

use crate::case::{BodyKeys, CaseKeys, Device, EngineName, TableName};
use crate::initial_water::{Displacement, InitialWater};
use crate::instruments::{Gauge, Probe};
use crate::wavemaker;
use crate::waves::StillWater;
use crate::waves::plan::WavePlan;
use nalgebra::{Point2, Vector2};
use seakeep_body::{BodyError, Contacts, Harmonic, MooringLine, PrescribedMotion, TimeSeries};
use seakeep_coupler::Coupling;
use seakeep_coupler::interface::BoundaryKinematics;
use seakeep_fluid::network::Network;
use seakeep_fluid::setup::{
    DampingZone, FluidSetup, Numerics, PressureSettings, RigidBoundary, Tank, Water,
};
use std::path::PathBuf;

/// What a run simulates and writes.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    /// The fluid and the boundaries in it.
    pub fluid: FluidSetup,
    /// Where the network is evaluated, if one finds the pressure.
    pub device: Device,
    /// Its weights file, if it is not the one that comes with the program.
    pub weights: Option<PathBuf>,
    /// The water at the start.
    pub initial_water: InitialWater,
    /// How far the particles are off their lattice at the start.
    pub displacement: Displacement,
    /// The wave, and what makes it.
    pub wave: Option<WavePlan>,
    /// The bodies, in the order of the fluid's boundaries. What else bounds the fluid follows
    /// there: the paddle and its foot.
    pub bodies: Vec<Body>,
    /// What moves the bodies that are not prescribed.
    pub engine: EngineName,
    /// How bodies touch each other and the tank.
    pub contacts: Contacts,
    /// Mooring lines.
    pub lines: Vec<Line>,
    /// Substeps of the bodies in a time step, enough to resolve the lines.
    pub substeps: usize,
    /// Wave gauges.
    pub gauges: Vec<Gauge>,
    /// Pressure probes.
    pub probes: Vec<Probe>,
    /// How the fluid and the bodies are coupled.
    pub coupling: Coupling,
    /// Number of communication steps.
    pub steps: u64,
    /// When what is written.
    pub output: OutputPlan,
}

/// A rigid body: what its boundary does not say.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Name in the tables.
    pub name: String,
    /// Mass, kg/m.
    pub mass: f64,
    /// Moment of inertia about the centre of mass, kg m²/m.
    pub inertia: f64,
    /// Whether it moves in sway, heave and roll.
    pub free: [bool; 3],
    /// What it follows if its motion is prescribed.
    pub motion: Option<Motion>,
    /// What sway and heave are relative to, m.
    pub equilibrium: Point2<f64>,
}

impl Body {
    /// Whether it does not move at all.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.free == [false; 3] && self.motion.is_none()
    }

    /// Whether loads move it.
    #[must_use]
    pub fn is_free(&self) -> bool {
        self.free != [false; 3] && self.motion.is_none()
    }
}

/// A motion that a body follows.
#[derive(Clone, Debug, PartialEq)]
pub enum Motion {
    /// A record.
    Series(TimeSeries),
    /// A formula.
    Harmonic(Harmonic),
}

impl Motion {
    /// Kinematics at `time` (s).
    ///
    /// # Errors
    /// When the motion does not cover the time.
    pub fn kinematics(&self, time: f64) -> Result<BoundaryKinematics, BodyError> {
        match self {
            Self::Series(series) => series.kinematics(time),
            Self::Harmonic(harmonic) => harmonic.kinematics(time),
        }
    }

    /// The motion for a body to follow.
    #[must_use]
    pub fn boxed(&self) -> Box<dyn PrescribedMotion> {
        match self {
            Self::Series(series) => Box::new(series.clone()),
            Self::Harmonic(harmonic) => Box::new(*harmonic),
        }
    }
}

/// A mooring line.
#[derive(Clone, Debug, PartialEq)]
pub struct Line {
    /// Name in the table.
    pub name: String,
    /// Number of the body it is fastened to.
    pub body: usize,
    /// Where it is fastened, and what it answers.
    pub line: MooringLine,
}

/// What is written, and after how many steps.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputPlan {
    /// Steps between two rows of the tables, at least 1.
    pub series_every: u64,
    /// Steps between two particle frames, if there are any.
    pub frames_every: Option<u64>,
    /// The tables asked for that have something in them.
    pub tables: Vec<TableName>,
    /// Whether `run.mcap` is written.
    pub mcap: bool,
    /// Whether a plot is drawn at the end.
    pub plot: bool,
}

impl Scene {
    /// The scene of resolved keys that have passed the checks, with the motion of each body that
    /// is prescribed, the mooring lines and the wave.
    pub(crate) fn new(
        keys: &CaseKeys,
        motions: Vec<Option<Motion>>,
        lines: Vec<Line>,
        wave: Option<WavePlan>,
        network: Network,
    ) -> Self {
        let time_step = keys.numerics.time_step_s.unwrap_or_default();
        let mut fluid = FluidSetup {
            tank: Tank { length: keys.tank.length_m, height: keys.tank.height_m, paddle: None },
            water: Water {
                depth: keys.water.depth_m,
                density: keys.water.density_kg_m3,
                kinematic_viscosity: keys.water.kinematic_viscosity_m2_s,
                gravity: keys.water.gravity_m_s2,
            },
            boundaries: keys.body.iter().map(boundary).collect(),
            damping_zones: keys
                .damping_zone
                .iter()
                .map(|zone| DampingZone {
                    inner_x: zone.inner_x_m,
                    outer_x: zone.outer_x_m,
                    rate: zone.rate_per_s,
                })
                .collect(),
            numerics: Numerics {
                particle_spacing: keys.numerics.particle_spacing_m,
                time_step,
                discretisation: keys.numerics.discretisation,
                integrator: keys.numerics.integrator,
                density_blend: keys.numerics.density_blend,
            },
            pressure: PressureSettings {
                solver: keys.pressure.solver,
                preconditioner: keys.pressure.preconditioner,
                start: keys.pressure.start,
                tolerance: keys.pressure.tolerance,
                divergence_tolerance: keys.pressure.divergence_tolerance,
                max_iterations: keys.pressure.max_iterations as usize,
                guard_tolerance: keys.pressure.guard_tolerance,
                sweeps: keys.pressure.sweeps,
            },
            network,
        };
        let coupling = keys.coupling.coupling();
        let communication_step = time_step * f64::from(coupling.load_substeps);
        let gauges = keys.gauge.iter().map(|g| Gauge { name: g.name.clone(), x: g.x_m }).collect();
        let probes = keys
            .probe
            .iter()
            .map(|p| Probe {
                name: p.name.clone(),
                body: p.body.as_ref().and_then(|on| keys.body.iter().position(|b| b.name == *on)),
                point: Point2::new(p.x_m, p.y_m),
            })
            .collect();
        let initial_water = match (&keys.water.standing_wave, keys.water.width_m) {
            (None, None) => InitialWater::Still,
            (None, Some(width)) => InitialWater::Column { width },
            (Some(wave), _) => InitialWater::StandingWave {
                amplitude: wave.amplitude_m,
                half_waves: wave.half_waves,
                tank_length: keys.tank.length_m,
            },
        };
        if let Some(plan) = &wave {
            wavemaker::add(&mut fluid, plan, keys.end_time_s);
        }
        let bodies: Vec<Body> =
            keys.body.iter().zip(motions).map(|(keys, m)| body(keys, m)).collect();
        Self {
            fluid,
            device: keys.pressure.device,
            weights: keys.pressure.weights.clone(),
            initial_water,
            displacement: Displacement {
                largest: keys.numerics.displacement * keys.numerics.particle_spacing_m,
                seed: keys.numerics.seed,
            },
            wave,
            substeps: substeps(&bodies, &lines, time_step),
            bodies,
            lines,
            engine: engine(keys),
            contacts: Contacts {
                restitution: keys.contact.restitution,
                friction: keys.contact.friction,
                tank_length: Some(keys.tank.length_m),
            },
            gauges,
            probes,
            // A hair below the exact ratio, so that rounding does not add a step.
            coupling,
            steps: (keys.end_time_s / communication_step * (1.0 - 1e-12)).ceil().max(1.0) as u64,
            output: output_plan(keys, communication_step),
        }
    }

    /// Time step of the fluid, s.
    #[must_use]
    pub fn time_step(&self) -> f64 {
        self.fluid.numerics.time_step
    }

    /// Time between two exchanges of load and motion, s: a time step or several.
    #[must_use]
    pub fn communication_step(&self) -> f64 {
        self.time_step() * f64::from(self.coupling.load_substeps)
    }

    /// Still-water depth, m.
    #[must_use]
    pub fn depth(&self) -> f64 {
        self.fluid.water.depth
    }

    /// The water at rest, as the theory of waves has it.
    #[must_use]
    pub fn still_water(&self) -> StillWater {
        StillWater { depth: self.fluid.water.depth, gravity: self.fluid.water.gravity }
    }

    /// Whether loads move any body.
    #[must_use]
    pub fn has_free_body(&self) -> bool {
        self.bodies.iter().any(Body::is_free)
    }

    /// Whether nothing moves at the start and nothing will.
    #[must_use]
    pub fn is_still(&self) -> bool {
        self.bodies.iter().all(Body::is_held)
            && self.wave.is_none()
            && self.initial_water == InitialWater::Still
    }
}

/// Whether the scene of `keys` has anything to write into a table.
pub(crate) fn has_rows(keys: &CaseKeys, table: TableName) -> bool {
    match table {
        TableName::Motion | TableName::Loads => !keys.body.is_empty(),
        TableName::Mooring => !keys.mooring.is_empty(),
        TableName::Gauges => !keys.gauge.is_empty(),
        TableName::Probes => !keys.probe.is_empty(),
        TableName::Diagnostics => true,
    }
}

fn output_plan(keys: &CaseKeys, communication_step: f64) -> OutputPlan {
    let output = &keys.output;
    let every = |interval: f64| ((interval / communication_step).round() as u64).max(1);
    OutputPlan {
        series_every: every(output.series_interval_s),
        frames_every: (output.mcap && output.frame_interval_s > 0.0)
            .then(|| every(output.frame_interval_s)),
        tables: TableName::ALL
            .into_iter()
            .filter(|table| output.tables.contains(table) && has_rows(keys, *table))
            .collect(),
        mcap: output.mcap,
        plot: output.plot,
    }
}

fn boundary(keys: &BodyKeys) -> RigidBoundary {
    let corners = keys.corners_m.iter().flatten();
    let mut corners: Vec<_> = corners.map(|[x, y]| Vector2::new(*x, *y)).collect();
    if keys.holds_water {
        corners.reverse();
    }
    RigidBoundary {
        name: keys.name.clone(),
        corners,
        position: Point2::from(keys.position_m),
        angle: keys.angle_deg.to_radians(),
        free: !keys.free.is_empty() && keys.engine != EngineName::Prescribed,
    }
}

/// Largest angle by which the fastest oscillation on a line may advance in a substep, rad: its
/// frequency is then less than 0.1 % too high.
const ANGLE_PER_SUBSTEP: f64 = 0.1;

/// Substeps that resolve the bodies on their lines, the water's added mass left out.
fn substeps(bodies: &[Body], lines: &[Line], time_step: f64) -> usize {
    let rate = |(index, body): (usize, &Body)| {
        let of_body = lines.iter().filter(|line| line.body == index).map(|line| line.line);
        let (mut stiffness, mut damping) = (0.0, 0.0);
        for line in of_body {
            let mobility = 1.0 / body.mass + line.fairlead.norm_squared() / body.inertia;
            stiffness += mobility * line.stiffness();
            damping += mobility * line.damping();
        }
        if body.is_free() { stiffness.sqrt().max(damping) } else { 0.0 }
    };
    let fastest = bodies.iter().enumerate().map(rate).fold(0.0, f64::max);
    (fastest * time_step / ANGLE_PER_SUBSTEP).ceil().max(1.0) as usize
}

/// The engine of the first body that needs one; the checks see to it that the others agree.
fn engine(keys: &CaseKeys) -> EngineName {
    let engines = keys.body.iter().map(|body| body.engine);
    engines.into_iter().find(|engine| *engine != EngineName::Prescribed).unwrap_or_default()
}

fn body(keys: &BodyKeys, motion: Option<Motion>) -> Body {
    Body {
        name: keys.name.clone(),
        // Only a prescribed body may have no mass, and it does not matter there.
        mass: keys.mass_kg_m.unwrap_or(1.0),
        inertia: keys.inertia_kg_m2_m.unwrap_or(1.0),
        motion,
        free: keys.free_directions(),
        equilibrium: Point2::from(keys.equilibrium_m.unwrap_or(keys.position_m)),
    }
}
