//! What a run writes: the tables of the output contract, the recording, the plot, the summary.

pub mod directory;
mod recorder;
mod recording;
pub mod rows;
pub mod summary;
mod table;

pub use recorder::Recorder;

use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why something could not be written.
#[derive(Debug, Error)]
pub enum OutputError {
    /// A file or directory.
    #[error("{}: cannot be written: {source}", .path.display())]
    Write {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The recording.
    #[error("run.mcap: {0}")]
    Recording(#[from] mcap::McapError),
    /// A plot.
    #[error("{}: cannot be drawn: {reason}", .path.display())]
    Plot {
        /// Which.
        path: PathBuf,
        /// Why.
        reason: String,
    },
}

impl OutputError {
    /// Wraps an error at `path`.
    pub(crate) fn at(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |source| Self::Write { path: path.to_owned(), source }
    }
}
