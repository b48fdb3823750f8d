//! The table: a row for each reference of each case.

use super::{Compared, Found};
use crate::case::{MeasureName, ReferenceKeys};
use crate::output::OutputError;
use std::fmt::Write;
use std::path::Path;

/// The head of the table.
const HEAD: [&str; 11] = [
    "case",
    "spacing",
    "solver",
    "reference",
    "measure",
    "found",
    "should be",
    "error",
    "goal",
    "paper",
    "wall time",
];

/// What is compared, in a word or two.
pub(super) fn measure(reference: &ReferenceKeys) -> &'static str {
    match (&reference.finding, reference.measure) {
        (Some(_), _) => "finding",
        (None, Some(MeasureName::Series)) => "Eq. (31)",
        (None, Some(MeasureName::Amplitude)) => "amplitude",
        (None, Some(MeasureName::Mean)) => "mean",
        (None, Some(MeasureName::Largest)) => "largest",
        (None, Some(MeasureName::Arrival)) => "arrival, s",
        (None, None) => "",
    }
}

/// The cells of a table of `runs`, without its head.
pub(super) fn cells(runs: &[Compared]) -> Vec<[String; HEAD.len()]> {
    let row = |run: &Compared, reference: &ReferenceKeys, found: &Found| {
        [
            run.case.clone(),
            format!("{} m", run.spacing),
            run.solver.clone(),
            reference.name.clone(),
            measure(reference).to_owned(),
            found.value.map_or(String::new(), number),
            found.reference.map_or(String::new(), number),
            match (&found.missing, found.error) {
                (Some(reason), _) => reason.clone(),
                (None, error) => error.map_or(String::new(), percent),
            },
            reference.goal.map_or(String::new(), percent),
            reference.paper_error.map_or(String::new(), percent),
            format!("{:.0} s", run.wall_time),
        ]
    };
    runs.iter()
        .flat_map(|run| run.found.iter().map(|(reference, found)| row(run, reference, found)))
        .collect()
}

/// The head of [`cells`].
pub(super) fn head() -> [&'static str; HEAD.len()] {
    HEAD
}

/// The table as text, its columns aligned.
#[must_use]
pub fn table(runs: &[Compared]) -> String {
    let rows = cells(runs);
    let mut widths = HEAD.map(|title| title.chars().count());
    for row in &rows {
        for (width, cell) in widths.iter_mut().zip(row) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let mut text = String::new();
    let mut add = |cells: &[&str]| {
        let mut line = String::new();
        for (cell, width) in cells.iter().zip(widths) {
            let _ = write!(line, "{cell:<width$}  ");
        }
        let _ = writeln!(text, "{}", line.trim_end());
    };
    add(&HEAD);
    for row in &rows {
        add(&row.each_ref().map(String::as_str));
    }
    text
}

/// Writes the table as CSV: the errors as fractions, the wall time in s.
///
/// # Errors
/// When the file cannot be written.
pub fn write_csv(path: &Path, runs: &[Compared]) -> Result<(), OutputError> {
    let failed = |error: csv::Error| OutputError::at(path)(error.into());
    let mut writer = csv::Writer::from_path(path).map_err(failed)?;
    let header = [
        "case",
        "particle_spacing_m",
        "solver",
        "reference",
        "measure",
        "found",
        "should_be",
        "error",
        "goal",
        "paper_error",
        "time_shift_s",
        "wall_time_s",
        "threads",
        "missing",
        "source",
    ];
    writer.write_record(header).map_err(failed)?;
    let text = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    for run in runs {
        for (reference, found) in &run.found {
            let row = [
                run.case.clone(),
                run.spacing.to_string(),
                run.solver.clone(),
                reference.name.clone(),
                measure(reference).to_owned(),
                text(found.value),
                text(found.reference),
                text(found.error),
                text(reference.goal),
                text(reference.paper_error),
                text(found.shift),
                run.wall_time.to_string(),
                run.threads.to_string(),
                found.missing.clone().unwrap_or_default(),
                reference.source.clone(),
            ];
            writer.write_record(row).map_err(failed)?;
        }
    }
    writer.flush().map_err(OutputError::at(path))
}

fn percent(fraction: f64) -> String {
    format!("{:.2} %", 100.0 * fraction)
}

/// Four significant digits.
fn number(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || (1e-3..1e5).contains(&size) {
        let decimals = if size > 0.0 { (3 - size.log10().floor() as i32).max(0) } else { 0 };
        format!("{value:.*}", decimals as usize)
    } else {
        format!("{value:.3e}")
    }
}
