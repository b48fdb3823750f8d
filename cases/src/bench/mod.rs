//! Error against time: a case run over a grid of settings.
//!
//! What counts as an error is up to a [`Measure`]: a function from the summary of a run to named
//! errors. [`errors`] is the one for every case: the distance of each finding from its theory, and
//! the findings that are errors by themselves.

mod grid;
mod plot;
mod table;

pub use grid::{Variation, grid};
pub use plot::draw;
pub use table::write;

use crate::case::{Case, CaseError, Resolution};
use crate::job::{self, JobError};
use crate::output::OutputError;
use crate::output::summary::{Status, Summary};
use std::path::Path;
use std::sync::atomic::AtomicBool;
use thiserror::Error;

/// Named errors of a run, each a number that should be small.
pub type Measure = fn(&Summary) -> Vec<(String, f64)>;

/// One run of the grid.
#[derive(Debug)]
pub struct Trial {
    /// The settings that were varied, `key=value` each.
    pub settings: Vec<String>,
    /// What came of it.
    pub summary: Summary,
    /// Its errors; none of a run that did not complete.
    pub errors: Vec<(String, f64)>,
}

impl Trial {
    /// The error called `name`.
    #[must_use]
    pub fn error(&self, name: &str) -> Option<f64> {
        self.errors.iter().find(|(known, _)| known == name).map(|(_, error)| *error)
    }
}

/// Why a bench ended.
#[derive(Debug, Error)]
pub enum BenchError {
    /// A combination of settings is no case. Nothing has been run.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// A run could not begin or its results not be written.
    #[error(transparent)]
    Job(#[from] JobError),
    /// The results of the bench could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// The cases of a grid, with `settings` for all of them: each combination of the variations.
///
/// # Errors
/// The first combination that is no case.
pub fn cases(
    asked: &str,
    resolution: Resolution,
    settings: &[String],
    variations: &[Variation],
) -> Result<Vec<(Vec<String>, Case)>, CaseError> {
    // Of a trial, only the figures are of use.
    let quiet = ["output.mcap=false", "output.plot=false"].map(str::to_owned);
    grid(variations)
        .into_iter()
        .map(|varied| {
            let overrides = [&quiet[..], settings, &varied].concat();
            Ok((varied, Case::load_as(asked, resolution, &overrides)?))
        })
        .collect()
}

/// Runs one case of the grid on `threads` threads, its results in `directory`.
///
/// # Errors
/// [`JobError`]. A run that breaks down is none: its trial says so.
pub fn run(
    settings: Vec<String>,
    case: &Case,
    directory: &Path,
    threads: usize,
    stop: &AtomicBool,
    measure: Measure,
) -> Result<Trial, JobError> {
    let summary = job::run(case, directory, threads, stop, &mut |_| {})?;
    let errors = match summary.status {
        Status::Completed => measure(&summary),
        Status::Interrupted | Status::Failed => Vec::new(),
    };
    Ok(Trial { settings, summary, errors })
}

/// The errors of any case: |value/theory − 1| of each finding with a theory that is not zero, and
/// the size of those that are called an error, a loss, a change or a reflection.
#[must_use]
pub fn errors(summary: &Summary) -> Vec<(String, f64)> {
    let findings = summary.findings.iter();
    findings
        .filter_map(|finding| {
            let error = match finding.theory {
                Some(theory) if theory.abs() > 1e-9 => (finding.value / theory - 1.0).abs(),
                Some(_) => return None,
                None => {
                    let told = ["error", "loss", "change", "reflection"];
                    let is_error = told.iter().any(|word| finding.name.contains(word));
                    if !is_error {
                        return None;
                    }
                    finding.value.abs()
                }
            };
            Some((finding.name.clone(), error))
        })
        .collect()
}

/// Which of `points`, each a cost and an error, are on the Pareto front: no other is at most as
/// dear and at most as wrong, and better in one of the two.
#[must_use]
pub fn pareto_front(points: &[(f64, f64)]) -> Vec<bool> {
    let beats = |a: &(f64, f64), b: &(f64, f64)| a.0 <= b.0 && a.1 <= b.1 && a != b;
    points.iter().map(|point| !points.iter().any(|other| beats(other, point))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let points = [(1.0, 0.1), (2.0, 0.05), (2.5, 0.06), (4.0, 0.01), (4.0, 0.02)];
        assert_eq!(pareto_front(&points), [true, true, false, true, false]);
        // Equals do not beat each other.
        assert_eq!(pareto_front(&[(1.0, 0.1), (1.0, 0.1)]), [true, true]);
        assert!(pareto_front(&[]).is_empty());
    }

    #[test]
    fn combinations_that_are_no_case_are_refused_before_anything_runs() {
        let vary: Variation = "numerics.particle_spacing_m=0.02,0.01,9".parse().unwrap();
        assert!(matches!(
            cases("still_tank", Resolution::Full, &[], &[vary]),
            Err(CaseError::Invalid(_))
        ));
        let vary: Variation = "numerics.particle_spacing_m=0.02,0.01".parse().unwrap();
        let found =
            cases("still_tank", Resolution::Full, &["end_time_s=0.5".to_owned()], &[vary]).unwrap();
        assert_eq!(found.len(), 2);
        let spacing = |n: usize| found[n].1.keys.numerics.particle_spacing_m;
        assert_eq!((spacing(0), spacing(1)), (0.02, 0.01));
        assert!(found.iter().all(|(_, case)| case.keys.end_time_s == 0.5));
    }
}
