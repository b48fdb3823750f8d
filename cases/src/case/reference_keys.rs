//! The keys of references: what the results of a case are held against by `seakeep validate`.
//!
//! Every key, its unit, default and range is described in `docs/cases.md`.

use super::TableName;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// `[comparison]`
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table")]
pub struct ComparisonKeys {
    /// Least and largest time, s, that may be added to the times of the references with
    /// `measure = "series"`: one for all of them, where they fit best.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_shift_s: Option<[f64; 2]>,
}

/// `[[reference]]`: a figure of the run, what it should be, and how far it may be off.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct ReferenceKeys {
    /// Name in the table.
    pub name: String,
    /// Where the reference is from.
    pub source: String,
    /// A finding of `summary.json`, by its name; instead of `table`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub finding: Option<String>,
    /// The table that a series is taken from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<TableName>,
    /// The body, line, gauge or probe that it is of.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub of: Option<String>,
    /// The column.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// What is compared of a series.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub measure: Option<MeasureName>,
    /// Time over which the series and its reference are averaged first, s; without it they are not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub average_s: Option<f64>,
    /// Value from which on `measure = "arrival"` counts, in the units of the table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<f64>,
    /// Period of the harmonic of `measure = "amplitude"`, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_s: Option<f64>,
    /// Start of what is compared of the run, s; without it the start.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_s: Option<f64>,
    /// End of what is compared of the run, s; without it the end.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub until_s: Option<f64>,
    /// What the figure should be, in the units of the table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// A table (CSV) with the reference as a series.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Its columns of the time, s, and of the value.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file_columns: Option<[String; 2]>,
    /// Times of the reference, s: those of the file in a resolved case.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub times_s: Option<Vec<f64>>,
    /// Its values.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub values: Option<Vec<f64>>,
    /// What its values are multiplied with to have the unit and sign of the table.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub scale: f64,
    /// Whether the level of the reference is unknown: the mean difference is taken out.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub free_level: bool,
    /// Error that is to be reached.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub goal: Option<f64>,
    /// Error of the paper that the case is from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub paper_error: Option<f64>,
}

/// What is compared of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MeasureName {
    /// The series itself, by Eq. (31).
    Series,
    /// The amplitude of its first harmonic.
    Amplitude,
    /// Its mean.
    Mean,
    /// Its largest value.
    Largest,
    /// The time when it first reaches a level.
    Arrival,
}

fn one() -> f64 {
    1.0
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "the signature that serde asks for")]
fn is_one(value: &f64) -> bool {
    *value == 1.0
}
