//! Reading back what a run has written.

use crate::case::TableName;
use crate::output::rows::named_by;
use serde_json::Value;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why results cannot be read.
#[derive(Debug, Error)]
pub enum ResultsError {
    /// A file is not there or no text.
    #[error("{}: cannot be read: {source}", .path.display())]
    Read {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The summary is none.
    #[error("{}: no summary of a run: {source}", .path.display())]
    Summary {
        /// Which.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// A table is none.
    #[error("{}: {source}", .path.display())]
    Table {
        /// Which.
        path: PathBuf,
        /// Why.
        source: csv::Error,
    },
    /// A table lacks a column.
    #[error("{}: there is no column {column}", .path.display())]
    Column {
        /// Which table.
        path: PathBuf,
        /// Which column.
        column: String,
    },
}

/// A series: times (s) and values.
pub type Series = (Vec<f64>, Vec<f64>);

/// The directory of a run.
#[derive(Clone, Debug)]
pub struct Results {
    directory: PathBuf,
    summary: Value,
}

impl Results {
    /// The results in `directory`.
    ///
    /// # Errors
    /// When there is no summary in it.
    pub fn open(directory: &Path) -> Result<Self, ResultsError> {
        let path = directory.join("summary.json");
        let text = std::fs::read_to_string(&path)
            .map_err(|source| ResultsError::Read { path: path.clone(), source })?;
        let summary =
            serde_json::from_str(&text).map_err(|source| ResultsError::Summary { path, source })?;
        Ok(Self { directory: directory.to_owned(), summary })
    }

    /// Value and theory of the finding called `name`, if there is one.
    #[must_use]
    pub fn finding(&self, name: &str) -> Option<(f64, Option<f64>)> {
        let found = self.summary["findings"].as_array()?;
        let finding = found.iter().find(|finding| finding["name"] == name)?;
        Some((finding["value"].as_f64()?, finding["theory"].as_f64()))
    }

    /// Why the run ended before its time, if it did.
    #[must_use]
    pub fn failure(&self) -> Option<String> {
        let status = self.summary["status"].as_str().unwrap_or("unknown");
        let reason = || self.summary["failure"].as_str().unwrap_or(status).to_owned();
        (status != "completed").then(reason)
    }

    /// A number of the summary, by the keys that lead to it.
    #[must_use]
    pub fn number(&self, keys: &[&str]) -> Option<f64> {
        keys.iter().fold(&self.summary, |value, key| &value[*key]).as_f64()
    }

    /// A text of the summary, by the keys that lead to it.
    #[must_use]
    pub fn text(&self, keys: &[&str]) -> Option<&str> {
        keys.iter().fold(&self.summary, |value, key| &value[*key]).as_str()
    }

    /// The `column` of a table, in the rows about `of` where that is given; rows with an empty
    /// cell are left out.
    ///
    /// # Errors
    /// When the table cannot be read.
    pub fn series(
        &self,
        table: TableName,
        of: Option<&str>,
        column: &str,
    ) -> Result<Series, ResultsError> {
        let path = self.directory.join(table.name()).with_extension("csv");
        let failed = |source| ResultsError::Table { path: path.clone(), source };
        let mut reader = csv::Reader::from_path(&path).map_err(failed)?;
        let header = reader.headers().map_err(failed)?.clone();
        let place = |column: &str| {
            let missing = || ResultsError::Column { path: path.clone(), column: column.to_owned() };
            header.iter().position(|known| known == column).ok_or_else(missing)
        };
        let (time, value) = (place("time_s")?, place(column)?);
        let name = match (named_by(table), of) {
            (Some(column), Some(of)) => Some((place(column)?, of)),
            _ => None,
        };
        let mut series = Series::default();
        for row in reader.records() {
            let row = row.map_err(failed)?;
            if name.is_some_and(|(place, of)| row.get(place) != Some(of)) {
                continue;
            }
            let number = |place: usize| row.get(place).and_then(|cell| cell.parse::<f64>().ok());
            if let (Some(time), Some(value)) = (number(time), number(value)) {
                series.0.push(time);
                series.1.push(value);
            }
        }
        Ok(series)
    }
}
