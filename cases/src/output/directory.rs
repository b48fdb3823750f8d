//! Where results go, so that nothing is ever written over.

use super::OutputError;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Folder of results where no `--out` is given.
pub const DEFAULT_PARENT: &str = "results";

/// The file that is written first and marks a directory as a result.
pub const RESOLVED_CASE: &str = "resolved.toml";

/// First line of the resolved case.
pub const MARK: &str = "# seakeep: the case as it was run";

/// Everything that a run may write.
const FILES: [&str; 15] = [
    "motion.csv",
    "loads.csv",
    "mooring.csv",
    "gauges.csv",
    "probes.csv",
    "diagnostics.csv",
    "summary.json",
    "run.mcap",
    "motion.svg",
    "elevation.svg",
    "wave_gauges.csv",
    "wave_profile.csv",
    "wave_velocity.csv",
    "paddle.csv",
    RESOLVED_CASE,
];

/// Why a directory is not used.
#[derive(Debug, Error)]
pub enum DirectoryError {
    /// It holds something.
    #[error("--out {}: the directory is not empty; name another, or add --force", .0.display())]
    NotEmpty(PathBuf),
    /// The default place holds something that is no result.
    #[error("{}: exists and is no result of seakeep; name a directory with --out", .0.display())]
    NotAResult(PathBuf),
    /// It is a file, or cannot be read.
    #[error("{}: cannot be used for results: {source}", .path.display())]
    Unusable {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
}

/// The directory for a run of the case `name`: `out` if given, else `results/<name>` or, where
/// an earlier result stands there, `results/<name>-2` and so on. Nothing is created yet.
///
/// # Errors
/// A directory that holds something else than an earlier result in the default place; with
/// `force`, `out` may hold anything.
pub fn choose(name: &str, out: Option<&Path>, force: bool) -> Result<PathBuf, DirectoryError> {
    if let Some(out) = out {
        return match is_empty(out)? {
            false if !force => Err(DirectoryError::NotEmpty(out.to_owned())),
            _ => Ok(out.to_owned()),
        };
    }
    let parent = Path::new(DEFAULT_PARENT);
    let mut candidate = parent.join(name);
    let mut number = 1;
    while !is_empty(&candidate)? {
        if !is_result(&candidate) {
            return Err(DirectoryError::NotAResult(candidate));
        }
        number += 1;
        candidate = parent.join(format!("{name}-{number}"));
    }
    Ok(candidate)
}

/// Creates the directory and removes the files of an earlier run from it.
///
/// # Errors
/// When the directory cannot be created or a file not removed.
pub fn prepare(directory: &Path) -> Result<(), OutputError> {
    std::fs::create_dir_all(directory).map_err(OutputError::at(directory))?;
    for name in FILES {
        let path = directory.join(name);
        match std::fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                return Err(OutputError::at(&path)(error));
            }
            _ => {}
        }
    }
    Ok(())
}

fn is_empty(directory: &Path) -> Result<bool, DirectoryError> {
    match std::fs::read_dir(directory) {
        Ok(mut entries) => Ok(entries.next().is_none()),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(true),
        Err(source) => Err(DirectoryError::Unusable { path: directory.to_owned(), source }),
    }
}

/// A run, or runs beside each other: those of a bench or a validation.
fn is_result(directory: &Path) -> bool {
    let marked = |path: &Path| {
        let text = std::fs::read_to_string(path.join(RESOLVED_CASE));
        text.is_ok_and(|text| text.starts_with(MARK))
    };
    let mut entries = std::fs::read_dir(directory).into_iter().flatten().flatten();
    marked(directory) || entries.any(|entry| marked(&entry.path()))
}
