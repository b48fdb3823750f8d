//! The rows of the tables: one struct a table, whose fields are the columns of the contract.

use crate::case::TableName;
use crate::instruments::Gauge;
use crate::scene::Scene;
use crate::simulation::{Sample, displacement};
use serde::Serialize;

/// A row: written to a table and to the recording alike.
pub trait Row: Serialize {
    /// Name of the table and first part of the topic.
    const TABLE: &'static str;
    /// Columns, in order: the names of the fields.
    const COLUMNS: &'static [&'static str];
    /// The column that names what the row is about, if there is one.
    const NAMED_BY: Option<&'static str>;

    /// What the row is about: a body, a gauge. Empty without [`Self::NAMED_BY`].
    fn name(&self) -> &str {
        ""
    }
}

/// A row of `motion.csv`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs, reason = "the names are the contract's and carry the units")]
pub struct MotionRow<'a> {
    pub time_s: f64,
    pub body: &'a str,
    pub sway_m: f64,
    pub heave_m: f64,
    pub roll_rad: f64,
    pub sway_velocity_m_s: f64,
    pub heave_velocity_m_s: f64,
    pub roll_rate_rad_s: f64,
    pub sway_acceleration_m_s2: f64,
    pub heave_acceleration_m_s2: f64,
    pub roll_acceleration_rad_s2: f64,
}

impl Row for MotionRow<'_> {
    const TABLE: &'static str = "motion";
    const COLUMNS: &'static [&'static str] = &[
        "time_s",
        "body",
        "sway_m",
        "heave_m",
        "roll_rad",
        "sway_velocity_m_s",
        "heave_velocity_m_s",
        "roll_rate_rad_s",
        "sway_acceleration_m_s2",
        "heave_acceleration_m_s2",
        "roll_acceleration_rad_s2",
    ];
    const NAMED_BY: Option<&'static str> = Some("body");

    fn name(&self) -> &str {
        self.body
    }
}

/// A row of `loads.csv`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs, reason = "the names are the contract's and carry the units")]
pub struct LoadsRow<'a> {
    pub time_s: f64,
    pub body: &'a str,
    pub force_x_n_per_m: f64,
    pub force_y_n_per_m: f64,
    pub torque_n_m_per_m: f64,
}

impl Row for LoadsRow<'_> {
    const TABLE: &'static str = "loads";
    const COLUMNS: &'static [&'static str] =
        &["time_s", "body", "force_x_n_per_m", "force_y_n_per_m", "torque_n_m_per_m"];
    const NAMED_BY: Option<&'static str> = Some("body");

    fn name(&self) -> &str {
        self.body
    }
}

/// A row of `mooring.csv`.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs, reason = "the names are the contract's and carry the units")]
pub struct MooringRow<'a> {
    pub time_s: f64,
    pub line: &'a str,
    pub tension_n_per_m: f64,
    pub length_m: f64,
    pub fairlead_x_m: f64,
    pub fairlead_y_m: f64,
}

impl Row for MooringRow<'_> {
    const TABLE: &'static str = "mooring";
    const COLUMNS: &'static [&'static str] =
        &["time_s", "line", "tension_n_per_m", "length_m", "fairlead_x_m", "fairlead_y_m"];
    const NAMED_BY: Option<&'static str> = Some("line");

    fn name(&self) -> &str {
        self.line
    }
}

/// A row of `gauges.csv`; the elevation is empty under a body.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs, reason = "the names are the contract's and carry the units")]
pub struct GaugesRow<'a> {
    pub time_s: f64,
    pub gauge: &'a str,
    pub x_m: f64,
    pub elevation_m: Option<f64>,
}

impl Row for GaugesRow<'_> {
    const TABLE: &'static str = "gauges";
    const COLUMNS: &'static [&'static str] = &["time_s", "gauge", "x_m", "elevation_m"];
    const NAMED_BY: Option<&'static str> = Some("gauge");

    fn name(&self) -> &str {
        self.gauge
    }
}

/// A row of `probes.csv`; pressure and velocity are empty outside the water.
#[derive(Clone, Debug, Serialize)]
#[allow(missing_docs, reason = "the names are the contract's and carry the units")]
pub struct ProbesRow<'a> {
    pub time_s: f64,
    pub probe: &'a str,
    pub x_m: f64,
    pub y_m: f64,
    pub pressure_pa: Option<f64>,
    pub velocity_x_m_s: Option<f64>,
    pub velocity_y_m_s: Option<f64>,
}

impl Row for ProbesRow<'_> {
    const TABLE: &'static str = "probes";
    const COLUMNS: &'static [&'static str] =
        &["time_s", "probe", "x_m", "y_m", "pressure_pa", "velocity_x_m_s", "velocity_y_m_s"];
    const NAMED_BY: Option<&'static str> = Some("probe");

    fn name(&self) -> &str {
        self.probe
    }
}

/// A row of `diagnostics.csv`. Of the coupling, the sum of the load evaluations, the largest
/// residual and the sum of the power-bond residuals since the row before.
#[derive(Clone, Copy, Debug, Default, Serialize)]
#[allow(missing_docs, reason = "the names are the contract's and carry the units")]
pub struct DiagnosticsRow {
    pub time_s: f64,
    pub kinetic_energy_j_per_m: f64,
    pub potential_energy_j_per_m: f64,
    pub volume_error: f64,
    pub divergence_rms_per_s: f64,
    pub density_error_rms: f64,
    pub pressure_iterations: u64,
    pub pressure_residual: f64,
    pub particles_active: u64,
    pub load_evaluations: u64,
    pub coupling_residual: f64,
    pub power_bond_residual_j_per_m: f64,
}

impl Row for DiagnosticsRow {
    const TABLE: &'static str = "diagnostics";
    const COLUMNS: &'static [&'static str] = &[
        "time_s",
        "kinetic_energy_j_per_m",
        "potential_energy_j_per_m",
        "volume_error",
        "divergence_rms_per_s",
        "density_error_rms",
        "pressure_iterations",
        "pressure_residual",
        "particles_active",
        "load_evaluations",
        "coupling_residual",
        "power_bond_residual_j_per_m",
    ];
    const NAMED_BY: Option<&'static str> = None;
}

/// The columns of a table, in order.
#[must_use]
pub fn columns(table: TableName) -> &'static [&'static str] {
    match table {
        TableName::Motion => MotionRow::COLUMNS,
        TableName::Loads => LoadsRow::COLUMNS,
        TableName::Mooring => MooringRow::COLUMNS,
        TableName::Gauges => GaugesRow::COLUMNS,
        TableName::Probes => ProbesRow::COLUMNS,
        TableName::Diagnostics => DiagnosticsRow::COLUMNS,
    }
}

/// The column of a table that names what a row is about, if there is one.
#[must_use]
pub fn named_by(table: TableName) -> Option<&'static str> {
    match table {
        TableName::Motion => MotionRow::NAMED_BY,
        TableName::Loads => LoadsRow::NAMED_BY,
        TableName::Mooring => MooringRow::NAMED_BY,
        TableName::Gauges => GaugesRow::NAMED_BY,
        TableName::Probes => ProbesRow::NAMED_BY,
        TableName::Diagnostics => DiagnosticsRow::NAMED_BY,
    }
}

/// The motion of every body.
pub fn motion<'a>(
    scene: &'a Scene,
    sample: &'a Sample,
) -> impl Iterator<Item = MotionRow<'a>> + 'a {
    scene.bodies.iter().zip(&sample.motion).map(|(body, kinematics)| {
        let [sway_m, heave_m, roll_rad] = displacement(kinematics, body.equilibrium);
        MotionRow {
            time_s: sample.time,
            body: &body.name,
            sway_m,
            heave_m,
            roll_rad,
            sway_velocity_m_s: kinematics.velocity.x,
            heave_velocity_m_s: kinematics.velocity.y,
            roll_rate_rad_s: kinematics.angular_velocity,
            sway_acceleration_m_s2: kinematics.acceleration.x,
            heave_acceleration_m_s2: kinematics.acceleration.y,
            roll_acceleration_rad_s2: kinematics.angular_acceleration,
        }
    })
}

/// The load on every body; none before the first step.
pub fn loads<'a>(scene: &'a Scene, sample: &'a Sample) -> impl Iterator<Item = LoadsRow<'a>> + 'a {
    scene.bodies.iter().zip(&sample.loads).map(|(body, load)| LoadsRow {
        time_s: sample.time,
        body: &body.name,
        force_x_n_per_m: load.force.x,
        force_y_n_per_m: load.force.y,
        torque_n_m_per_m: load.torque,
    })
}

/// Every mooring line.
pub fn mooring<'a>(
    scene: &'a Scene,
    sample: &'a Sample,
) -> impl Iterator<Item = MooringRow<'a>> + 'a {
    scene.lines.iter().zip(&sample.lines).map(|(line, state)| MooringRow {
        time_s: sample.time,
        line: &line.name,
        tension_n_per_m: state.tension,
        length_m: state.length,
        fairlead_x_m: state.fairlead.x,
        fairlead_y_m: state.fairlead.y,
    })
}

/// The elevation at every gauge.
pub fn gauges<'a>(
    scene: &'a Scene,
    sample: &'a Sample,
) -> impl Iterator<Item = GaugesRow<'a>> + 'a {
    let row = |(gauge, elevation): (&'a Gauge, &'a Option<f64>)| GaugesRow {
        time_s: sample.time,
        gauge: &gauge.name,
        x_m: gauge.x,
        elevation_m: *elevation,
    };
    scene.gauges.iter().zip(&sample.elevations).map(row)
}

/// Pressure and velocity at every probe.
pub fn probes<'a>(
    scene: &'a Scene,
    sample: &'a Sample,
) -> impl Iterator<Item = ProbesRow<'a>> + 'a {
    scene.probes.iter().enumerate().map(|(index, probe)| {
        let (place, velocity) = (sample.places[index], sample.velocities[index]);
        ProbesRow {
            time_s: sample.time,
            probe: &probe.name,
            x_m: place.x,
            y_m: place.y,
            pressure_pa: sample.pressures[index],
            velocity_x_m_s: velocity.map(|u| u.x),
            velocity_y_m_s: velocity.map(|u| u.y),
        }
    })
}
