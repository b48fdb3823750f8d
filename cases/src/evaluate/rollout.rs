//! Whole runs: every solver on its own, against the equation solved to 1e-8.

use super::{EvaluateError, solvers};
use crate::case::Case;
use crate::simulation::{Simulation, SimulationError};
use seakeep_fluid::setup::PressureSettings;
use serde::Serialize;

/// Places along the tank at which elevations are compared.
const PLACES: usize = 24;
/// Tolerance of the reference.
const REFERENCE: f64 = 1e-8;

/// How far a run with a solver is from the reference at one time.
#[derive(Clone, Debug, Serialize)]
pub struct RolloutRow {
    /// The case.
    pub case: String,
    /// The solver.
    pub solver: &'static str,
    /// Time, s.
    pub time_s: f64,
    /// Root-mean-square difference of the elevation along the tank to the reference's, over the
    /// largest root-mean-square elevation of the reference. Nothing once a run has failed.
    pub error: Option<f64>,
    /// Root-mean-square divergence, 1/s.
    pub divergence_rms_per_s: f64,
    /// Volume error.
    pub volume_error: f64,
    /// Wall time of the pressure stage so far, ms a step.
    pub pressure_ms: f64,
}

struct Course {
    times: Vec<f64>,
    elevations: Vec<Vec<f64>>,
    rows: Vec<(f64, f64, f64)>,
}

/// Runs `asked` (a case with overrides) with every solver, the pressure equation to the tolerance of
/// the case. Samples are `interval` (s) apart.
///
/// # Errors
/// [`EvaluateError`], not for a run that fails but for the reference.
pub fn rollout(
    asked: &str,
    overrides: &[String],
    interval: f64,
    threads: usize,
    observe: &mut (dyn FnMut(&str) + Send),
) -> Result<Vec<RolloutRow>, EvaluateError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let case = Case::load(asked, overrides)?;
    pool.install(|| {
        observe("reference");
        let mut exact = case.clone();
        exact.scene.fluid.pressure = PressureSettings {
            tolerance: REFERENCE,
            divergence_tolerance: 0.0,
            ..PressureSettings::default()
        };
        let (reference, failed) = run(&exact, interval)?;
        if let Some(error) = failed {
            return Err(error.into());
        }
        let rms = |values: &mut dyn Iterator<Item = f64>| {
            (values.map(|v| v * v).sum::<f64>() / PLACES as f64).sqrt()
        };
        let size = reference
            .elevations
            .iter()
            .map(|elevation| rms(&mut elevation.iter().copied()))
            .fold(0.0, f64::max);
        let mut rows = Vec::new();
        for (solver, settings) in solvers(case.scene.fluid.pressure.tolerance) {
            observe(solver);
            let mut other = case.clone();
            other.scene.fluid.pressure = settings;
            let (course, _) = run(&other, interval)?;
            for (index, &time_s) in reference.times.iter().enumerate() {
                let found = course.elevations.get(index);
                let error = found.map(|elevation| {
                    let differences = elevation.iter().zip(&reference.elevations[index]);
                    rms(&mut differences.map(|(a, b)| a - b)) / size
                });
                let last = course.rows.get(index).or(course.rows.last());
                let (divergence_rms_per_s, volume_error, pressure_ms) =
                    last.copied().unwrap_or_default();
                rows.push(RolloutRow {
                    case: case.name.clone(),
                    solver,
                    time_s,
                    error: error.filter(|error| error.is_finite()),
                    divergence_rms_per_s,
                    volume_error,
                    pressure_ms,
                });
            }
        }
        Ok(rows)
    })
}

/// A run, and why it ended early.
fn run(case: &Case, interval: f64) -> Result<(Course, Option<SimulationError>), EvaluateError> {
    let scene = &case.scene;
    let mut simulation = Simulation::start(scene)?;
    let mut course = Course { times: Vec::new(), elevations: Vec::new(), rows: Vec::new() };
    let every = (interval / scene.communication_step()).round().max(1.0) as u64;
    let length = scene.fluid.tank.length;
    for step in 1..=scene.steps {
        if let Err(error) = simulation.step() {
            return Ok((course, Some(error)));
        }
        if step % every == 0 {
            let sample = simulation.sample(scene);
            let place = |index: usize| (index as f64 + 0.5) / PLACES as f64 * length;
            course.times.push(simulation.time());
            course.elevations.push(
                (0..PLACES)
                    .map(|index| simulation.surface_elevation(place(index)).unwrap_or(0.0))
                    .collect(),
            );
            let stages = simulation.stage_times();
            let pressure = stages.iter().find(|(stage, _)| stage == "pressure");
            course.rows.push((
                sample.diagnostics.divergence_rms_per_s,
                sample.diagnostics.volume_error,
                pressure.map_or(0.0, |(_, time)| time.as_secs_f64() * 1e3 / step as f64),
            ));
        }
    }
    Ok((course, None))
}
