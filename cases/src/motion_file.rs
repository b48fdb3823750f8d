//! Motions as tables: CSV files with the columns `time_s`, `sway_m`, `heave_m` and `roll_rad`.
//!
//! Other columns are passed over, so that the `motion.csv` of a run is such a file; where there is
//! a column `body`, only its rows of the body asked for are read.

use csv::{ReaderBuilder, StringRecord, Trim};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use thiserror::Error;

const COLUMNS: [&str; 4] = ["time_s", "sway_m", "heave_m", "roll_rad"];

/// Why a motion file gave no motion.
#[derive(Debug, Error)]
pub enum MotionFileError {
    /// It cannot be read, or is no table.
    #[error("{}: cannot be read: {source}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: csv::Error,
    },
    /// A column is missing.
    #[error("{}: there is no column {column} (needed: {})", .path.display(), COLUMNS.join(", "))]
    Column {
        /// The file.
        path: PathBuf,
        /// Name of the column.
        column: &'static str,
    },
    /// A cell is no number.
    #[error("{}:{line}: {column} = {cell:?} is no number", .path.display())]
    Number {
        /// The file.
        path: PathBuf,
        /// Line of the row, from 1.
        line: u64,
        /// Name of the column.
        column: &'static str,
        /// What stands there.
        cell: String,
    },
    /// A cell is empty.
    #[error("{}:{line}: a gap: {column} is empty", .path.display())]
    Gap {
        /// The file.
        path: PathBuf,
        /// Line of the row, from 1.
        line: u64,
        /// Name of the column.
        column: &'static str,
    },
}

/// A motion as it was read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Samples {
    /// Times, s.
    pub times: Vec<f64>,
    /// Sway (m), heave (m) and roll (rad) at each time.
    pub samples: Vec<[f64; 3]>,
    /// Whether the file says which body each row is of.
    pub names_bodies: bool,
}

/// Reads the motion of `body` from the file at `path`.
///
/// # Errors
/// [`MotionFileError`].
pub fn read(path: &Path, body: &str) -> Result<Samples, MotionFileError> {
    let opened = File::open(path)
        .map_err(|error| MotionFileError::Read { path: path.to_owned(), source: error.into() })?;
    parse(opened, path, body)
}

/// Reads the motion of `body` from the text of the file at `path`.
///
/// # Errors
/// [`MotionFileError`].
pub fn parse(text: impl Read, path: &Path, body: &str) -> Result<Samples, MotionFileError> {
    let failed = |source| MotionFileError::Read { path: path.to_owned(), source };
    let mut builder = ReaderBuilder::new();
    let mut reader = builder.trim(Trim::All).comment(Some(b'#')).from_reader(text);
    let header = reader.headers().map_err(failed)?.clone();
    let place = |name: &str| header.iter().position(|column| column == name);
    let mut columns = [0; COLUMNS.len()];
    for (index, column) in columns.iter_mut().zip(COLUMNS) {
        *index = place(column).ok_or(MotionFileError::Column { path: path.to_owned(), column })?;
    }
    let named_by = place("body");
    let mut found = Samples { names_bodies: named_by.is_some(), ..Samples::default() };
    for row in reader.records() {
        let row = row.map_err(failed)?;
        if named_by.is_some_and(|index| row.get(index) != Some(body)) {
            continue;
        }
        let mut values = [0.0; COLUMNS.len()];
        for ((value, index), column) in values.iter_mut().zip(columns).zip(COLUMNS) {
            *value = number(path, &row, index, column)?;
        }
        let [time, sample @ ..] = values;
        found.times.push(time);
        found.samples.push(sample);
    }
    Ok(found)
}

fn number(
    path: &Path,
    row: &StringRecord,
    index: usize,
    column: &'static str,
) -> Result<f64, MotionFileError> {
    let (path, line) = (path.to_owned(), row.position().map_or(0, csv::Position::line));
    match row.get(index).unwrap_or_default() {
        "" => Err(MotionFileError::Gap { path, line, column }),
        cell => cell.parse().map_err(|_| {
            let cell = cell.to_owned();
            MotionFileError::Number { path, line, column, cell }
        }),
    }
}
