//! Validation: the results of runs held against the references that their cases name.
//!
//! A run is read back from its directory, by the names of its tables' columns and of the findings
//! in its summary, so that a run of yesterday can be compared as well as one of now.

mod compare;
mod job;
mod page;
mod results;
mod table;

pub use compare::{Comparison, compare};
pub use job::{ValidationError, cases, read, run, solver, write};
pub use page::page;
pub use results::{Results, ResultsError, Series};
pub use table::{table, write_csv};

use crate::case::ReferenceKeys;
use crate::plot::Panel;

/// A reference and what one run made of it.
#[derive(Clone, Debug)]
pub struct Found {
    /// The figure of the run, in the units of its table; none for a series.
    pub value: Option<f64>,
    /// What it should be.
    pub reference: Option<f64>,
    /// How far it is off: relative, or the value of a finding without a reference.
    pub error: Option<f64>,
    /// Why there is none.
    pub missing: Option<String>,
    /// Time that was added to the times of the reference, s.
    pub shift: Option<f64>,
    /// The run's curve over the reference's.
    pub panel: Option<Panel>,
}

/// A run that was compared.
#[derive(Clone, Debug)]
pub struct Compared {
    /// Name of the case.
    pub case: String,
    /// One line on it.
    pub description: String,
    /// What found the pressure: `ppe`, `network`, `guarded`.
    pub solver: String,
    /// Particle spacing, m.
    pub spacing: f64,
    /// Wall time of the run, s.
    pub wall_time: f64,
    /// Threads that it ran on.
    pub threads: u64,
    /// Why the run ended before its time.
    pub failure: Option<String>,
    /// Each reference with what was found.
    pub found: Vec<(ReferenceKeys, Found)>,
}
