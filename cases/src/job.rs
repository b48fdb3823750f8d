//! A run from start to end: stepping, writing, and the summary.

use crate::case::Case;
use crate::findings::{energy_error, findings};
use crate::output::summary::{Status, Summary, peak_memory};
use crate::output::{OutputError, Recorder, directory};
use crate::plot::{Curve, Figure, Panel};
use crate::simulation::{Sample, Simulation, SimulationError, displacement};
use nalgebra::DMatrix;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};
use thiserror::Error;

/// Why a run gave no summary.
#[derive(Debug, Error)]
pub enum JobError {
    /// A component refuses the scene. Nothing has been written.
    #[error("{0}")]
    Setup(SimulationError),
    /// The threads cannot be started. Nothing has been written.
    #[error("the threads cannot be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The resolved case cannot be written as TOML. Nothing has been written.
    #[error("the resolved case cannot be written: {0}")]
    Resolved(#[from] toml::ser::Error),
    /// A result could not be written. What is there is complete up to then.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// How far a run is.
#[derive(Clone, Copy, Debug)]
pub struct Progress {
    /// Steps done.
    pub step: u64,
    /// Steps in all.
    pub steps: u64,
    /// Simulated time, s.
    pub time: f64,
}

/// Runs `case` on `threads` threads and writes its results into `directory`, which is made if it
/// does not exist. `stop` ends the run after the current step; `observe` is called after each.
///
/// A step that fails ends the run too, but is no error here: everything up to it is written, and
/// the summary says what failed.
///
/// # Errors
/// [`JobError`].
pub fn run(
    case: &Case,
    directory: &Path,
    threads: usize,
    stop: &AtomicBool,
    observe: &mut (dyn FnMut(Progress) + Send),
) -> Result<Summary, JobError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    pool.install(|| {
        let begun = Instant::now();
        let mut simulation = Simulation::start(&case.scene).map_err(JobError::Setup)?;
        let resolved = format!("{}\n{}", directory::MARK, case.to_toml()?);
        directory::prepare(directory)?;
        let path = directory.join(directory::RESOLVED_CASE);
        std::fs::write(&path, &resolved).map_err(OutputError::at(&path))?;

        let mut recorder = Recorder::create(directory, case, &resolved)?;
        let start_time = begun.elapsed();
        let mut course = go(case, &mut simulation, &mut recorder, stop, observe)?;
        course.start_time = start_time;
        recorder.finish()?;
        simulation.finish();
        draw_plots(case, directory, &course.samples)?;
        let summary = summarize(case, &simulation, &course, threads, begun);
        summary.write(directory)?;
        Ok(summary)
    })
}

/// What happened over a run.
struct Course {
    status: Status,
    failure: Option<String>,
    samples: Vec<Sample>,
    /// Of the first step, if there is a free body.
    added_mass: Option<DMatrix<f64>>,
    /// Wall time before the first step.
    start_time: Duration,
    /// Wall time of the steps.
    step_time: Duration,
}

/// Steps to the end, writing as it goes.
fn go(
    case: &Case,
    simulation: &mut Simulation,
    recorder: &mut Recorder,
    stop: &AtomicBool,
    observe: &mut (dyn FnMut(Progress) + Send),
) -> Result<Course, OutputError> {
    let scene = &case.scene;
    let mut course = Course {
        status: Status::Completed,
        failure: None,
        samples: Vec::new(),
        added_mass: None,
        start_time: Duration::ZERO,
        step_time: Duration::ZERO,
    };
    for step in 0..=scene.steps {
        if step > 0 {
            let begun = Instant::now();
            let taken = simulation.step();
            course.step_time += begun.elapsed();
            if let Err(error) = taken {
                course.status = Status::Failed;
                course.failure = Some(error.to_string());
                break;
            }
            observe(Progress { step, steps: scene.steps, time: simulation.time() });
        }
        if step == 1 && scene.has_free_body() {
            course.added_mass = Some(simulation.added_mass().clone());
        }
        let stopping = stop.load(Ordering::Relaxed);
        let last = step == scene.steps || stopping;
        if step % scene.output.series_every == 0 || last {
            let sample = simulation.sample(scene);
            recorder.sample(scene, &sample)?;
            course.samples.push(sample);
        }
        if scene.output.frames_every.is_some_and(|every| step % every == 0 || last) {
            recorder.frame(simulation.time(), &simulation.frame())?;
        }
        if stopping && step < scene.steps {
            course.status = Status::Interrupted;
            break;
        }
    }
    Ok(course)
}

fn summarize(
    case: &Case,
    simulation: &Simulation,
    course: &Course,
    threads: usize,
    begun: Instant,
) -> Summary {
    let samples = &course.samples;
    Summary {
        case: case.name.clone(),
        version: env!("CARGO_PKG_VERSION"),
        status: course.status,
        failure: course.failure.clone(),
        threads,
        particles: Some(simulation.particle_counts()),
        steps: simulation.steps(),
        simulated_time_s: simulation.time(),
        wall_time_s: begun.elapsed().as_secs_f64(),
        stage_time_s: stage_times(simulation, course, begun.elapsed()),
        peak_memory_bytes: peak_memory(),
        pressure_iterations_mean: mean_iterations(samples),
        fallback_count: simulation.fallback_count(),
        coupling: (!case.scene.bodies.is_empty()).then(|| *simulation.coupling_tally()),
        final_energy_error: energy_error(&case.scene, samples),
        final_volume_error: samples.last().map(|sample| sample.diagnostics.volume_error),
        findings: findings(case, samples, course.added_mass.as_ref()),
        configuration: case.keys.clone(),
    }
}

/// Iterations of a pressure solve, on average over the samples after the start.
fn mean_iterations(samples: &[Sample]) -> Option<f64> {
    let solved = samples.get(1..).filter(|solved| !solved.is_empty())?;
    let sum: u64 = solved.iter().map(|sample| sample.diagnostics.pressure_iterations).sum();
    Some(sum as f64 / solved.len() as f64)
}

/// Wall time of the fluid's stages and of all around them, s; together the wall time of the run.
fn stage_times(simulation: &Simulation, course: &Course, whole: Duration) -> BTreeMap<String, f64> {
    let mut times: BTreeMap<String, f64> = simulation
        .stage_times()
        .into_iter()
        .map(|(stage, time)| (stage, time.as_secs_f64()))
        .collect();
    let steps = course.step_time.as_secs_f64();
    let fluid: f64 = times.values().sum();
    let start = course.start_time.as_secs_f64();
    times.insert("start".to_owned(), start);
    times.insert("bodies and coupling".to_owned(), (steps - fluid).max(0.0));
    times.insert("output".to_owned(), (whole.as_secs_f64() - steps - start).max(0.0));
    times
}

/// The motion of the bodies or, without any, the elevation at the gauges.
fn draw_plots(case: &Case, directory: &Path, samples: &[Sample]) -> Result<(), OutputError> {
    let scene = &case.scene;
    if !scene.output.plot {
        return Ok(());
    }
    if !scene.bodies.is_empty() {
        let directions = [
            ("sway (m)", 1.0),
            ("heave (m)", 1.0),
            ("roll (degrees)", 180.0 / std::f64::consts::PI),
        ];
        let curve = |index: usize, direction: usize, scale: f64| {
            let (body, points) = (&scene.bodies[index], samples.iter());
            let value =
                |s: &Sample| scale * displacement(&s.motion[index], body.equilibrium)[direction];
            Curve::line(&body.name, points.map(|s| (s.time, value(s))).collect())
        };
        let panels: Vec<Panel> = directions
            .into_iter()
            .enumerate()
            .map(|(direction, (label, scale))| {
                let curves = (0..scene.bodies.len()).map(|i| curve(i, direction, scale));
                Panel::over_time(label, curves.collect())
            })
            .collect();
        Figure::new(&case.name, panels).write(&directory.join("motion.svg"))
    } else if !scene.gauges.is_empty() {
        let curve = |(index, gauge): (usize, &crate::instruments::Gauge)| {
            let points = samples.iter().filter_map(|s| Some((s.time, s.elevations[index]?)));
            Curve::line(&gauge.name, points.collect())
        };
        let curves = scene.gauges.iter().enumerate().map(curve).collect();
        let panel = Panel::over_time("elevation (m)", curves);
        Figure::new(&case.name, vec![panel]).write(&directory.join("elevation.svg"))
    } else {
        Ok(())
    }
}
