//! Running what is to be validated.

use super::{Compared, Results, ResultsError, compare, page, write_csv};
use crate::case::{Case, CaseError, Resolution, library};
use crate::job::{self, JobError};
use crate::output::OutputError;
use std::path::Path;
use std::sync::atomic::AtomicBool;
use thiserror::Error;

/// Why there is no comparison.
#[derive(Debug, Error)]
pub enum ValidationError {
    /// A case cannot be. Nothing has been run.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// A case names nothing to compare with. Nothing has been run.
    #[error("{0}: the case names no [[reference]]")]
    NoReference(String),
    /// A run could not begin or its results not be written.
    #[error(transparent)]
    Job(#[from] JobError),
    /// Results cannot be read.
    #[error(transparent)]
    Results(#[from] ResultsError),
    /// The table or the page could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// The cases `asked` for, or all of the program's that name references; as `resolution` says,
/// where a case that has no coarse variant is taken as it is; with `settings` (`key=value`), once
/// for each of `solvers`, or with the case's own without any.
///
/// # Errors
/// The first that is no case, or names no reference.
pub fn cases(
    asked: &[String],
    resolution: Resolution,
    settings: &[String],
    solvers: &[String],
) -> Result<Vec<Case>, ValidationError> {
    let mut names = asked.to_vec();
    if names.is_empty() {
        for known in library() {
            if !Case::load(known.name, &[])?.keys.reference.is_empty() {
                names.push(known.name.to_owned());
            }
        }
    }
    let solvers: Vec<Vec<String>> = match solvers {
        [] => vec![Vec::new()],
        _ => solvers.iter().map(|solver| vec![format!("pressure.solver={solver:?}")]).collect(),
    };
    let mut cases = Vec::new();
    for name in &names {
        for solver in &solvers {
            // Of the runs, only the tables are of use.
            let own = ["output.mcap=false", "output.plot=false"].map(str::to_owned);
            let overrides = [&own, settings, solver].concat();
            let case = Case::load_as(name, resolution, &overrides)?;
            if case.keys.reference.is_empty() {
                return Err(ValidationError::NoReference(name.clone()));
            }
            cases.push(case);
        }
    }
    Ok(cases)
}

/// The name of what finds the pressure in `case`.
#[must_use]
pub fn solver(case: &Case) -> String {
    let name = serde_json::to_value(case.keys.pressure.solver).ok();
    name.and_then(|name| name.as_str().map(str::to_owned)).unwrap_or_default()
}

/// Runs `case` on `threads` threads with its results in `directory`, and compares them.
///
/// # Errors
/// [`ValidationError`]. A run that breaks down is none: what it has is compared.
pub fn run(
    case: &Case,
    directory: &Path,
    threads: usize,
    stop: &AtomicBool,
    observe: &mut (dyn FnMut(job::Progress) + Send),
) -> Result<Compared, ValidationError> {
    job::run(case, directory, threads, stop, observe)?;
    read(case, directory)
}

/// Compares the results in `directory` with the references of `case`.
///
/// # Errors
/// When the results cannot be read.
pub fn read(case: &Case, directory: &Path) -> Result<Compared, ValidationError> {
    let results = Results::open(directory)?;
    let run = |keys: &[&str]| results.number(&[&["configuration"], keys].concat());
    let solver = results.text(&["configuration", "pressure", "solver"]);
    Ok(Compared {
        case: results.text(&["case"]).unwrap_or(&case.name).to_owned(),
        description: case.keys.description.clone(),
        solver: solver.map_or_else(|| self::solver(case), str::to_owned),
        spacing: run(&["numerics", "particle_spacing_m"])
            .unwrap_or(case.keys.numerics.particle_spacing_m),
        wall_time: results.number(&["wall_time_s"]).unwrap_or_default(),
        threads: results.number(&["threads"]).unwrap_or_default() as u64,
        failure: results.failure(),
        found: compare(case, &results)?,
    })
}

/// Writes `validation.csv` and `validation.html` into `directory`.
///
/// # Errors
/// When a file cannot be written.
pub fn write(directory: &Path, runs: &[Compared]) -> Result<(), ValidationError> {
    std::fs::create_dir_all(directory).map_err(OutputError::at(directory))?;
    write_csv(&directory.join("validation.csv"), runs)?;
    let path = directory.join("validation.html");
    let text = page(runs)
        .map_err(|reason| OutputError::Plot { path: path.clone(), reason: reason.to_string() })?;
    std::fs::write(&path, text).map_err(OutputError::at(&path))?;
    Ok(())
}
