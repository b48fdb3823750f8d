//! The `seakeep` program: runs, checks and lists cases, and finds the tensions of moorings.
//!
//! Exit code 0: done; 1: the run failed or was interrupted, what it had is written; 2: it could
//! not begin (bad input), and nothing was written.

mod cli;
mod learning;
mod progress;
mod report;

use clap::Parser;
use cli::{
    BenchArguments, BenchPressureArguments, CaseArguments, Cli, Command, MooringArguments,
    OutArguments, RunArguments, ValidateArguments, WaveArguments,
};
use progress::ProgressDisplay;
use seakeep::bench;
use seakeep::case::{Case, Resolution, library};
use seakeep::job::{self, JobError};
use seakeep::mooring_job::{self, MooringError};
use seakeep::output::{directory, summary::Status};
use seakeep::plan::plan;
use seakeep::pressure_bench::{self, BenchError};
use seakeep::theory;
use seakeep::validation::{self, ValidationError};
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// The run failed or was interrupted.
const FAILED: u8 = 1;
/// The run could not begin.
const REFUSED: u8 = 2;

fn main() -> ExitCode {
    let command = Cli::parse().command.unwrap_or_else(cli::main_job);
    let result = match command {
        Command::Run(arguments) => run(&arguments),
        Command::Check { case, plan } => check(&case, plan),
        Command::Wave(arguments) => wave(&arguments),
        Command::Validate(arguments) => validate(&arguments),
        Command::Bench(arguments) => bench(&arguments),
        Command::Mooring(arguments) => mooring(&arguments),
        Command::List => list(),
        Command::Train(arguments) => learning::train(&arguments),
        Command::Evaluate(arguments) => learning::evaluate(&arguments),
        Command::Dataset(arguments) => learning::dataset(&arguments),
        Command::BenchPressure(arguments) => bench_pressure(&arguments),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(Stop { message, code }) => {
            // One line a problem, each recognisable as an error.
            for line in message.lines() {
                let _ = writeln!(std::io::stderr(), "error: {line}");
            }
            ExitCode::from(code)
        }
    }
}

/// Why the program ends early.
struct Stop {
    message: String,
    code: u8,
}

fn refused(error: impl std::fmt::Display) -> Stop {
    Stop { message: error.to_string(), code: REFUSED }
}

fn run(arguments: &RunArguments) -> Result<(), Stop> {
    let case = load(&with_pressure(arguments))?;
    if !arguments.quiet {
        warn(&case);
    }
    let out = folder(&case.name, &arguments.into)?;
    let threads = threads(arguments.threads);
    let stop = stop_on_signal()?;

    let mut display = ProgressDisplay::new(arguments.quiet, &case);
    let observe = &mut |progress| display.update(progress);
    let summary = job::run(&case, &out, threads, &stop, observe).map_err(|error| match error {
        JobError::Output(_) => Stop { message: error.to_string(), code: FAILED },
        _ => refused(error),
    })?;
    display.finish();
    if !arguments.quiet {
        say(&report::report(&summary));
        say(&format!("results in {}\n", out.display()));
    }
    match summary.status {
        Status::Completed => Ok(()),
        Status::Interrupted => Err(Stop {
            message: format!("interrupted at t = {:.4} s", summary.simulated_time_s),
            code: FAILED,
        }),
        Status::Failed => Err(Stop { message: summary.failure.unwrap_or_default(), code: FAILED }),
    }
}

/// The folder of results about `name`.
fn folder(name: &str, into: &OutArguments) -> Result<PathBuf, Stop> {
    directory::choose(name, into.out.as_deref(), into.force).map_err(refused)
}

/// As many as asked for, or as there are processors.
fn threads(asked: Option<NonZeroUsize>) -> usize {
    asked.or_else(|| std::thread::available_parallelism().ok()).map_or(1, NonZeroUsize::get)
}

/// A flag that an interruption sets.
fn stop_on_signal() -> Result<Arc<AtomicBool>, Stop> {
    let stop = Arc::new(AtomicBool::new(false));
    let on_signal = Arc::clone(&stop);
    ctrlc::set_handler(move || on_signal.store(true, Ordering::Relaxed)).map_err(refused)?;
    Ok(stop)
}

fn validate(arguments: &ValidateArguments) -> Result<(), Stop> {
    let failed = |error: ValidationError| match error {
        ValidationError::Case(_) | ValidationError::NoReference(_) => refused(error),
        ValidationError::Job(JobError::Setup(_) | JobError::Threads(_)) => refused(error),
        _ => Stop { message: error.to_string(), code: FAILED },
    };
    let given = arguments.results.len();
    if given > 0 && given != arguments.cases.len() {
        let cases = arguments.cases.len();
        return Err(refused(format!("--results: {given} directories for {cases} cases")));
    }
    let variant = resolution(!arguments.full && given == 0);
    let cases = validation::cases(&arguments.cases, variant, &arguments.set, &arguments.pressure)
        .map_err(failed)?;
    let out = folder("validation", &arguments.into)?;
    let (threads, stop) = (threads(arguments.threads), stop_on_signal()?);
    let mut runs = Vec::new();
    for (index, case) in cases.iter().enumerate() {
        let run = match arguments.results.get(index) {
            Some(results) => validation::read(case, results).map_err(refused)?,
            None => {
                say(&format!("{}/{} {}\n", index + 1, cases.len(), case.name));
                let folder = out.join(format!("{}-{}", case.name, validation::solver(case)));
                let mut display = ProgressDisplay::new(false, case);
                let observe = &mut |progress| display.update(progress);
                let run = validation::run(case, &folder, threads, &stop, observe);
                display.finish();
                run.map_err(failed)?
            }
        };
        runs.push(run);
        // After each run, so that an interrupted validation leaves what it has.
        validation::write(&out, &runs).map_err(failed)?;
        if stop.load(Ordering::Relaxed) {
            let message = format!("interrupted in {}", case.name);
            return Err(Stop { message, code: FAILED });
        }
    }
    say(&format!("\n{}\n", validation::table(&runs)));
    say(&format!("page and table in {}\n", out.display()));
    let broken: Vec<String> = runs
        .iter()
        .filter_map(|run| Some(format!("{}: {}", run.case, run.failure.as_ref()?)))
        .collect();
    if broken.is_empty() {
        return Ok(());
    }
    Err(Stop { message: broken.join("\n"), code: FAILED })
}

fn bench(arguments: &BenchArguments) -> Result<(), Stop> {
    let base = load(&arguments.case)?;
    warn(&base);
    let cases = bench::cases(
        &arguments.case.case,
        resolution(arguments.case.coarse),
        &arguments.case.set,
        &arguments.vary,
    )
    .map_err(refused)?;
    let name = format!("{}-bench", base.name);
    let out = folder(&name, &arguments.into)?;
    let (threads, stop) = (threads(arguments.threads), stop_on_signal()?);
    let failed = |error: &dyn std::fmt::Display| Stop { message: error.to_string(), code: FAILED };
    let mut trials = Vec::new();
    let count = cases.len();
    for (number, (settings, case)) in (1..).zip(cases) {
        let label = settings.join(" ");
        let folder = out.join(format!("trial-{number:02}"));
        let trial = bench::run(settings, &case, &folder, threads, &stop, bench::errors).map_err(
            |error| match error {
                JobError::Output(_) => failed(&error),
                _ => refused(error),
            },
        )?;
        say(&report::trial(number, count, &label, &trial));
        trials.push(trial);
        // After each trial, so that an interrupted bench leaves what it has.
        bench::write(&out.join("bench.csv"), &trials).map_err(|error| failed(&error))?;
        if stop.load(Ordering::Relaxed) {
            return Err(Stop { message: format!("interrupted in trial {number}"), code: FAILED });
        }
    }
    let first = || trials.iter().flat_map(|trial| &trial.errors).map(|(name, _)| name).next();
    let Some(error) = arguments.error.as_ref().or_else(first) else {
        return Err(Stop { message: "no trial has an error to plot".to_owned(), code: FAILED });
    };
    if trials.iter().all(|trial| trial.error(error).is_none()) {
        let message = format!("--error {error}: no trial has an error of this name");
        return Err(Stop { message, code: FAILED });
    }
    bench::draw(&out.join("bench.svg"), &base.name, error, &trials)
        .map_err(|error| failed(&error))?;
    say(&format!("table and plot of \"{error}\" in {}\n", out.display()));
    Ok(())
}

fn check(arguments: &CaseArguments, with_plan: bool) -> Result<(), Stop> {
    let case = load(arguments)?;
    warn(&case);
    say(&report::overview(&case));
    if with_plan {
        for line in plan(&case) {
            say(&format!("{line}\n"));
        }
    }
    Ok(())
}

fn wave(arguments: &WaveArguments) -> Result<(), Stop> {
    let case = load(&arguments.case)?;
    warn(&case);
    let theory = theory::theory(&case, arguments.at).map_err(refused)?;
    let name = format!("{}-wave", case.name);
    let out = folder(&name, &arguments.into)?;
    theory.write(&case, &out).map_err(|error| Stop { message: error.to_string(), code: FAILED })?;
    say(&report::wave(&case, &theory));
    say(&format!("tables in {}\n", out.display()));
    Ok(())
}

fn mooring(arguments: &MooringArguments) -> Result<(), Stop> {
    let case = load(&arguments.case)?;
    let out = folder(&case.name, &arguments.into)?;
    let lines = mooring_job::run(&case, &arguments.motion, &out).map_err(|error| match error {
        MooringError::Output(_) => Stop { message: error.to_string(), code: FAILED },
        _ => refused(error),
    })?;
    if !arguments.quiet {
        say(&report::tensions(&lines));
        say(&format!("results in {}\n", out.display()));
    }
    Ok(())
}

fn list() -> Result<(), Stop> {
    for known in library() {
        let description = Case::load(known.name, &[])
            .map_or_else(|error| error.to_string(), |case| case.keys.description);
        say(&format!("{:<15} {description}\n", known.name));
    }
    Ok(())
}

fn bench_pressure(arguments: &BenchPressureArguments) -> Result<(), Stop> {
    let mut rows = Vec::new();
    for &row in &arguments.rows {
        let threads = threads(arguments.threads);
        let BenchPressureArguments { steps, tolerance, ref device, .. } = *arguments;
        let found = pressure_bench::bench(row, steps, threads, tolerance, device.as_deref())
            .map_err(|error| match error {
                BenchError::Row(_) | BenchError::Case(_) | BenchError::Device(_) => refused(error),
                _ => Stop { message: error.to_string(), code: FAILED },
            })?;
        if rows.is_empty() {
            say(
                "row particles D/dx solver           tolerance iterations processor_ms median_ms least_ms divergence_1/s\n",
            );
        }
        for r in &found {
            say(&format!(
                "{:<3} {:>9} {:>4.0} {:<16} {:>9.1e} {:>10.1} {:>12.2} {:>9.2} {:>8.2} {:>14.1e}\n",
                r.row,
                r.particles,
                r.depth_over_spacing,
                r.solver,
                r.tolerance,
                r.iterations,
                r.processor_ms.unwrap_or(f64::NAN),
                r.median_ms,
                r.least_ms,
                r.divergence_left_per_s,
            ));
        }
        rows.extend(found);
    }
    let Some(path) = &arguments.out else { return Ok(()) };
    pressure_bench::write(&rows, path)
        .map_err(|error| Stop { message: error.to_string(), code: FAILED })
}

/// The case of a run, with the pressure solver and the device that the command line asks for.
fn with_pressure(arguments: &RunArguments) -> CaseArguments {
    let solver = arguments.pressure.iter().map(|solver| format!("pressure.solver={solver:?}"));
    let device = arguments.device.iter().map(|device| format!("pressure.device={device:?}"));
    let CaseArguments { case, coarse, set } = &arguments.case;
    let set = set.iter().cloned().chain(solver).chain(device).collect();
    CaseArguments { case: case.clone(), coarse: *coarse, set }
}

fn load(arguments: &CaseArguments) -> Result<Case, Stop> {
    Case::load_as(&arguments.case, resolution(arguments.coarse), &arguments.set).map_err(refused)
}

fn resolution(coarse: bool) -> Resolution {
    if coarse { Resolution::Coarse } else { Resolution::Full }
}

/// Says what can be run but may not be what was meant.
fn warn(case: &Case) {
    for warning in &case.warnings {
        let _ = writeln!(std::io::stderr(), "warning: {warning}");
    }
}

/// Writes to standard output; a reader that has gone away is no error.
fn say(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes());
}
