//! The keys of a case file, exactly as they are written: units in the names, nothing derived.
//!
//! Every key, its unit, default and range is described in `docs/cases.md`.

use super::body_keys::{BodyKeys, ContactKeys};
use super::coupling::CouplingKeys;
use super::mooring_keys::MooringKeys;
use super::reference_keys::{ComparisonKeys, ReferenceKeys};
use super::wave_keys::{InitialWaveKeys, WaveKeys, WavemakerKeys};
use seakeep_fluid::setup::{
    Discretisation, Integrator, PreconditionerKind, PressureSettings, SolverKind, Start,
};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A case file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct CaseKeys {
    /// One line for `seakeep list`.
    #[serde(default)]
    pub description: String,
    /// Overrides (`key=value`) that make the case coarse and quick, for `--coarse`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub coarse: Vec<String>,
    /// Simulated time, s.
    pub end_time_s: f64,
    /// The tank.
    pub tank: TankKeys,
    /// The water.
    pub water: WaterKeys,
    /// Resolution and solver.
    pub numerics: NumericsKeys,
    /// How the pressure is found.
    #[serde(default)]
    pub pressure: PressureKeys,
    /// The wave.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wave: Option<WaveKeys>,
    /// A paddle that makes it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wavemaker: Option<WavemakerKeys>,
    /// The wave is in the tank at the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub initial_wave: Option<InitialWaveKeys>,
    /// How water and bodies are coupled.
    #[serde(default)]
    pub coupling: CouplingKeys,
    /// What is written.
    #[serde(default)]
    pub output: OutputKeys,
    /// Contact of bodies with each other and with the tank.
    #[serde(default, skip_serializing_if = "is_default")]
    pub contact: ContactKeys,
    /// Rigid bodies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub body: Vec<BodyKeys>,
    /// Mooring lines.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mooring: Vec<MooringKeys>,
    /// Wave gauges.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gauge: Vec<GaugeKeys>,
    /// Pressure probes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub probe: Vec<ProbeKeys>,
    /// How results and references are brought together.
    #[serde(default, skip_serializing_if = "is_default")]
    pub comparison: ComparisonKeys,
    /// What the results are held against by `seakeep validate`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reference: Vec<ReferenceKeys>,
    /// Zones that absorb waves.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub damping_zone: Vec<DampingZoneKeys>,
}

/// `[tank]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct TankKeys {
    /// Distance between the side walls, m.
    pub length_m: f64,
    /// Height of the side walls, m.
    pub height_m: f64,
}

/// `[water]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct WaterKeys {
    /// Still-water depth, m.
    pub depth_m: f64,
    /// Density, kg/m³.
    #[serde(default = "default_density")]
    pub density_kg_m3: f64,
    /// Kinematic viscosity, m²/s.
    #[serde(default)]
    pub kinematic_viscosity_m2_s: f64,
    /// Gravitational acceleration, m/s².
    #[serde(default = "default_gravity")]
    pub gravity_m_s2: f64,
    /// How far the water reaches from x = 0 at the start, m: a column with a free face, as behind a
    /// dam; without it the water fills the length of the tank.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub width_m: Option<f64>,
    /// A standing wave at the start; without it the water is still.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub standing_wave: Option<StandingWaveKeys>,
}

/// `[water.standing_wave]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct StandingWaveKeys {
    /// First-order amplitude, m.
    pub amplitude_m: f64,
    /// Half wavelengths in the tank.
    pub half_waves: u32,
}

/// `[numerics]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct NumericsKeys {
    /// Initial particle spacing, m.
    pub particle_spacing_m: f64,
    /// Time step, s; without it 0.1 s/m times the spacing.
    pub time_step_s: Option<f64>,
    /// How derivatives are formed.
    #[serde(default)]
    pub discretisation: Discretisation,
    /// Where within a step its pressure equation is assembled.
    #[serde(default)]
    pub integrator: Integrator,
    /// Blending coefficient α of Eq. (9b).
    #[serde(default = "default_density_blend")]
    pub density_blend: f64,
    /// Largest displacement of the particles off their lattice at the start, in spacings.
    #[serde(default)]
    pub displacement: f64,
    /// Seed of the displacements.
    #[serde(default)]
    pub seed: u64,
}

/// `[pressure]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table")]
pub struct PressureKeys {
    /// What finds the pressure.
    pub solver: SolverKind,
    /// Preconditioner of the pressure Poisson equation.
    pub preconditioner: PreconditionerKind,
    /// What the pressure Poisson equation starts from.
    pub start: Start,
    /// Residual at which a solve stops, relative to the right-hand side.
    pub tolerance: f64,
    /// Root-mean-square divergence left at which a solve stops in any case, in units of √(g/D).
    pub divergence_tolerance: f64,
    /// Iterations after which a solve has failed.
    pub max_iterations: u32,
    /// Root-mean-square divergence left, in units of √(g/D), above which a guarded network's step goes
    /// on with the pressure Poisson equation.
    pub guard_tolerance: f64,
    /// Damped Jacobi sweeps after a network.
    pub sweeps: u32,
    /// Weights file of the network; without it the one that comes with the program.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weights: Option<PathBuf>,
    /// Where the network is evaluated.
    pub device: Device,
}

/// Where a network is evaluated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Device {
    /// By the program's own code, on the processor.
    #[default]
    Own,
    /// By libtorch on the processor.
    Cpu,
    /// By libtorch on a CUDA device.
    Cuda,
}

impl Default for PressureKeys {
    fn default() -> Self {
        let settings = PressureSettings::default();
        Self {
            solver: settings.solver,
            preconditioner: settings.preconditioner,
            start: settings.start,
            tolerance: settings.tolerance,
            divergence_tolerance: settings.divergence_tolerance,
            max_iterations: settings.max_iterations as u32,
            guard_tolerance: settings.guard_tolerance,
            sweeps: settings.sweeps,
            weights: None,
            device: Device::Own,
        }
    }
}

/// `[output]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table")]
pub struct OutputKeys {
    /// Time between two rows of a table, s; 0 for every step.
    pub series_interval_s: f64,
    /// Time between two particle frames in `run.mcap`, s; 0 for none.
    pub frame_interval_s: f64,
    /// The tables to write; those with nothing in them are left out in any case.
    pub tables: Vec<TableName>,
    /// Whether `run.mcap` is written.
    pub mcap: bool,
    /// Whether a plot (SVG) is drawn at the end.
    pub plot: bool,
}

impl Default for OutputKeys {
    fn default() -> Self {
        Self {
            series_interval_s: 0.01,
            frame_interval_s: 0.05,
            tables: TableName::ALL.to_vec(),
            mcap: true,
            plot: true,
        }
    }
}

/// A table of the output contract.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TableName {
    /// `motion.csv`
    Motion,
    /// `loads.csv`
    Loads,
    /// `mooring.csv`
    Mooring,
    /// `gauges.csv`
    Gauges,
    /// `probes.csv`
    Probes,
    /// `diagnostics.csv`
    Diagnostics,
}

impl TableName {
    /// All tables.
    pub const ALL: [Self; 6] =
        [Self::Motion, Self::Loads, Self::Mooring, Self::Gauges, Self::Probes, Self::Diagnostics];

    /// Name in case files, in topics and before `.csv`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Motion => "motion",
            Self::Loads => "loads",
            Self::Mooring => "mooring",
            Self::Gauges => "gauges",
            Self::Probes => "probes",
            Self::Diagnostics => "diagnostics",
        }
    }
}

/// `[[gauge]]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct GaugeKeys {
    /// Name in the table.
    pub name: String,
    /// Where the elevation is measured, m.
    pub x_m: f64,
}

/// `[[probe]]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct ProbeKeys {
    /// Name in the table.
    pub name: String,
    /// The body that it is fastened to; without one it stands in the tank.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub body: Option<String>,
    /// Where the pressure is measured, m: in the tank, or in the frame of the body's shape.
    pub x_m: f64,
    /// Height above the bed, or along the frame of the body's shape, m.
    pub y_m: f64,
}

/// `[[damping_zone]]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct DampingZoneKeys {
    /// Where the damping begins, m.
    pub inner_x_m: f64,
    /// Where it is strongest, m.
    pub outer_x_m: f64,
    /// Maximum damping rate, 1/s.
    pub rate_per_s: f64,
}

fn default_density() -> f64 {
    1000.0
}

fn default_gravity() -> f64 {
    9.81
}

fn default_density_blend() -> f64 {
    0.01
}

/// Whether a value need not be written.
fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}
