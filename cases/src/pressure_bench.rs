//! Effort and time of the pressure solvers at the sizes of Table 1 of Ma, Zhang, Yan & Li (2024).
//!
//! A tank of the table's length and depth with standing waves of two metres; every solver is given
//! the same equation in each step, the fluid going on with its own.

use crate::case::{Case, CaseError};
use crate::output::OutputError;
use crate::simulation::{SimulationError, inference};
use seakeep_coupler::CouplerError;
use seakeep_coupler::interface::{Component, ComponentError, LoadComponent};
use seakeep_fluid::network::Inference;
use seakeep_fluid::setup::{PreconditionerKind, PressureSettings, SolverKind, Start};
use seakeep_fluid::{Fluid, FluidError};
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use thiserror::Error;

/// Depth (m) and length (m) of the tanks of Table 1, all with a spacing of 0.01 m.
pub const TABLE_1: [(f64, f64); 5] =
    [(0.4, 20.0), (0.4, 40.0), (0.4, 80.0), (0.8, 80.0), (0.8, 160.0)];

/// Steps before the first that counts: the start from rest is no moving wave yet.
const LEAD: u64 = 8;

/// Why there is no table.
#[derive(Debug, Error)]
pub enum BenchError {
    /// No such row.
    #[error("row {0} of Table 1: there are rows 1 to {count}", count = TABLE_1.len())]
    Row(usize),
    /// The case of a row is refused.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// The fluid cannot be set up, or a solver fails.
    #[error("fluid: {0}")]
    Fluid(#[from] FluidError),
    /// A step failed.
    #[error(transparent)]
    Step(#[from] ComponentError),
    /// A coupling failed.
    #[error(transparent)]
    Coupling(#[from] CouplerError),
    /// The device cannot be used.
    #[error(transparent)]
    Device(#[from] SimulationError),
    /// The threads cannot be started.
    #[error("the threads cannot be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The table cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// One solver at one size.
#[derive(Clone, Debug, Serialize)]
pub struct BenchRow {
    /// Row of Table 1, from 1.
    pub row: usize,
    /// Fluid particles.
    pub particles: usize,
    /// Depth over spacing.
    pub depth_over_spacing: f64,
    /// The solver.
    pub solver: &'static str,
    /// Residual relative to the right-hand side that it was asked for.
    pub tolerance: f64,
    /// Iterations a step, mean.
    pub iterations: f64,
    /// Processor time of a solve over all threads, mean, ms, where the operating system tells: it does
    /// not depend on what else the machine does as much as wall time.
    pub processor_ms: Option<f64>,
    /// Wall time of a solve, median, ms.
    pub median_ms: f64,
    /// Wall time of the quickest solve, ms.
    pub least_ms: f64,
    /// Root-mean-square divergence left, mean, 1/s.
    pub divergence_left_per_s: f64,
}

/// The solvers that are compared, by name; `tolerance` is that of the warm ones.
#[must_use]
pub fn solvers(tolerance: f64) -> Vec<(&'static str, PressureSettings)> {
    let own = PressureSettings { tolerance, ..PressureSettings::default() };
    let (cold, diagonal) = (Start::Cold, PreconditionerKind::Diagonal);
    vec![
        (
            "diagonal, cold",
            PressureSettings { preconditioner: diagonal, start: cold, tolerance: 1e-6, ..own },
        ),
        ("diagonal, warm", PressureSettings { preconditioner: diagonal, ..own }),
        ("milu, cold", PressureSettings { start: cold, tolerance: 1e-6, ..own }),
        ("milu, warm", own),
        ("network", PressureSettings { solver: SolverKind::Network, ..own }),
    ]
}

/// Compares the solvers at row `row` of Table 1 over `steps` steps, on `threads` threads, the warm
/// pressure equation solved to `tolerance`; the network by the program's own code and, if one is named, by
/// libtorch on a `device`.
///
/// # Errors
/// [`BenchError`].
pub fn bench(
    row: usize,
    steps: u64,
    threads: usize,
    tolerance: f64,
    device: Option<&str>,
) -> Result<Vec<BenchRow>, BenchError> {
    let &(depth, length) =
        row.checked_sub(1).and_then(|index| TABLE_1.get(index)).ok_or(BenchError::Row(row))?;
    let text = format!(
        "end_time_s = 1.0\n[tank]\nlength_m = {length:?}\nheight_m = {:?}\n[water]\n\
         depth_m = {depth:?}\nstanding_wave = {{ amplitude_m = 0.02, half_waves = {} }}\n\
         [numerics]\nparticle_spacing_m = 0.01\n[pressure]\ntolerance = {tolerance:?}\n",
        2.0 * depth,
        length.round(),
    );
    let case = |set: &[String]| Case::parse("table_1", "table_1.toml", &text, set);
    let on_device = device.map(|device| {
        case(&["pressure.solver=\"network\"".to_owned(), format!("pressure.device={device:?}")])
    });
    let (case, on_device) = (case(&[])?, on_device.transpose()?);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    pool.install(|| {
        let elsewhere = on_device.map(|case| inference(&case.scene)).transpose()?.flatten();
        compare(row, &case, steps, elsewhere)
    })
}

fn compare(
    row: usize,
    case: &Case,
    steps: u64,
    elsewhere: Option<Arc<dyn Inference>>,
) -> Result<Vec<BenchRow>, BenchError> {
    let mut fluid = Fluid::flowing(case.scene.fluid.clone(), &case.scene.initial_water)?;
    fluid.enter_initialization_mode(0.0)?;
    fluid.exit_initialization_mode()?;
    let h = case.scene.time_step();
    let mut solvers = solvers(case.scene.fluid.pressure.tolerance);
    let mut rivals: Vec<_> =
        solvers.iter().map(|(_, settings)| fluid.rival(*settings, None)).collect();
    if let (Some(elsewhere), Some(&(_, network))) = (elsewhere, solvers.last()) {
        solvers.push(("network, device", network));
        rivals.push(fluid.rival(network, Some(elsewhere)));
    }
    let mut reports = vec![Vec::new(); solvers.len()];
    let mut processor = vec![Some(Duration::ZERO); solvers.len()];
    for step in 0..LEAD + steps {
        let time = step as f64 * h;
        fluid.solve_load(time, h)?;
        if step >= LEAD {
            for (index, rival) in rivals.iter_mut().enumerate() {
                fluid.prepare(rival);
                let before = processor_time();
                reports[index].extend(fluid.try_pressure(rival)?);
                let used = processor_time().zip(before).map(|(now, before)| now - before);
                processor[index] = processor[index].zip(used).map(|(sum, used)| sum + used);
            }
        }
        fluid.do_step(time, h)?;
    }
    let numerics = &case.scene.fluid.numerics;
    let rows = solvers.iter().zip(processor).zip(&mut reports).map(|((solver, time), reports)| {
        let (solver, settings) = solver;
        let count = reports.len().max(1) as f64;
        reports.sort_by_key(|report| report.time);
        let ms = |index: usize| reports.get(index).map_or(0.0, |r| r.time.as_secs_f64() * 1e3);
        BenchRow {
            row,
            particles: fluid.particle_counts().fluid,
            depth_over_spacing: case.scene.depth() / numerics.particle_spacing,
            solver,
            tolerance: settings.tolerance,
            iterations: reports.iter().map(|r| r.iterations as f64).sum::<f64>() / count,
            processor_ms: time.map(|time| time.as_secs_f64() * 1e3 / count),
            median_ms: ms(reports.len() / 2),
            least_ms: ms(0),
            divergence_left_per_s: reports.iter().map(|r| r.divergence_left).sum::<f64>() / count,
        }
    });
    Ok(rows.collect())
}

/// Time that the threads of this program have spent on a processor, on Linux.
fn processor_time() -> Option<Duration> {
    let mut sum = 0;
    for task in std::fs::read_dir("/proc/self/task").ok()? {
        let text = std::fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        sum += text.split_whitespace().next()?.parse::<u64>().ok()?;
    }
    Some(Duration::from_nanos(sum))
}

/// Writes `rows` as CSV to `path`.
///
/// # Errors
/// When the file cannot be written.
pub fn write(rows: &[BenchRow], path: &Path) -> Result<(), BenchError> {
    let fail = |error: csv::Error| BenchError::Output(OutputError::at(path)(error.into()));
    let mut writer = csv::Writer::from_path(path).map_err(fail)?;
    for row in rows {
        writer.serialize(row).map_err(fail)?;
    }
    writer.flush().map_err(|error| fail(error.into()))
}
