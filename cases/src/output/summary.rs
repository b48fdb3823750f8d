//! `summary.json`: what was run, how it went and what was found.

use super::OutputError;
use crate::case::CaseKeys;
use crate::tally::CouplingTally;
use seakeep_fluid::ParticleCounts;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// It reached its end time.
    Completed,
    /// It was asked to stop.
    Interrupted,
    /// A step failed.
    Failed,
}

/// A figure found, with what it should be where that is known.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// What it is.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Its unit; empty for a plain number.
    pub unit: &'static str,
    /// The value of theory.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub theory: Option<f64>,
}

/// The content of `summary.json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Name of the case.
    pub case: String,
    /// Version of the program.
    pub version: &'static str,
    /// How the run ended.
    pub status: Status,
    /// Why it failed.
    pub failure: Option<String>,
    /// Threads used.
    pub threads: usize,
    /// Particles at the end.
    pub particles: Option<ParticleCounts>,
    /// Steps taken.
    pub steps: u64,
    /// Simulated time, s.
    pub simulated_time_s: f64,
    /// Wall time of the whole run, s.
    pub wall_time_s: f64,
    /// Wall time of each stage, s.
    pub stage_time_s: BTreeMap<String, f64>,
    /// Largest resident memory, bytes, where the operating system tells.
    pub peak_memory_bytes: Option<u64>,
    /// Iterations of a pressure solve, on average over the rows written.
    pub pressure_iterations_mean: Option<f64>,
    /// Steps in which the pressure was found by another solver than the one asked for.
    pub fallback_count: u64,
    /// What the coupling of water and bodies cost and made; absent without bodies.
    pub coupling: Option<CouplingTally>,
    /// Change of the water's mechanical energy over the run relative to the start; absent where
    /// there was none, or where bodies exchange energy with the water.
    pub final_energy_error: Option<f64>,
    /// Change of the water's volume, relative.
    pub final_volume_error: Option<f64>,
    /// What was found.
    pub findings: Vec<Finding>,
    /// The resolved configuration.
    pub configuration: CaseKeys,
}

impl Summary {
    /// Writes the summary into `directory`.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, directory: &Path) -> Result<(), OutputError> {
        let path = directory.join("summary.json");
        let mut text = serde_json::to_string_pretty(self)
            .map_err(|error| OutputError::at(&path)(error.into()))?;
        text.push('\n');
        std::fs::write(&path, text).map_err(OutputError::at(&path))
    }
}

/// Largest resident memory of this process so far, bytes; `None` where it cannot be told.
#[must_use]
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kilobytes * 1024)
}
