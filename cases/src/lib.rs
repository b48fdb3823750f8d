//! Floating bodies in waves, in two dimensions: case files, runs and their results.
//!
//! A [`Case`](case::Case) is read from TOML and checked; [`job::run`] steps it, writes the files
//! described in `docs/output.md` and returns a [`Summary`](output::summary::Summary) with the
//! figures that [`analysis`] draws from the series. Everything is per metre of width and in SI;
//! x along the tank, y up from the bed, angles counter-clockwise.

pub mod analysis;
pub mod bench;
pub mod case;
pub mod dataset;
pub mod evaluate;
mod findings;
pub mod geometry;
pub mod initial_water;
pub mod instruments;
pub mod job;
pub mod mooring_job;
pub mod motion_file;
pub mod output;
pub mod plan;
pub mod plot;
pub mod pressure_bench;
pub mod scene;
pub mod simulation;
pub mod tally;
pub mod theory;
#[cfg(feature = "torch")]
pub mod training;
pub mod validation;
mod wave_findings;
mod wavemaker;
pub mod waves;
