//! Reading frames.

use super::{MANIFEST, Manifest, Split};
use seakeep_fluid::frame::{Frame, FrameError};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why frames cannot be had.
#[derive(Debug, Error)]
pub enum DatasetError {
    /// A file or folder cannot be read.
    #[error("{}: cannot be read: {source}", .path.display())]
    Read {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A manifest that is none.
    #[error("{}: {source}", .path.display())]
    Manifest {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: serde_json::Error,
    },
    /// A frame that is none.
    #[error("{}: {source}", .path.display())]
    Frame {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: FrameError,
    },
    /// There is nothing in it.
    #[error("{}: holds no frames", .0.display())]
    Empty(PathBuf),
}

/// The frames of a data set, by case.
#[derive(Clone, Debug, Default)]
pub struct Dataset {
    /// Folder and manifest of each case, sorted by name.
    pub cases: Vec<(PathBuf, Manifest)>,
}

impl Dataset {
    fn read(path: &Path) -> impl FnOnce(std::io::Error) -> DatasetError + '_ {
        |source| DatasetError::Read { path: path.to_owned(), source }
    }

    /// The finished cases in `folder`.
    ///
    /// # Errors
    /// [`DatasetError`].
    pub fn open(folder: &Path) -> Result<Self, DatasetError> {
        let mut folders = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(Self::read(folder))? {
            let path = entry.map_err(Self::read(folder))?.path();
            if path.join(MANIFEST).is_file() && path.extension().is_none() {
                folders.push(path);
            }
        }
        folders.sort();
        let mut cases = Vec::new();
        for path in folders {
            let file = path.join(MANIFEST);
            let text = std::fs::read_to_string(&file).map_err(Self::read(&file))?;
            let manifest = serde_json::from_str(&text)
                .map_err(|source| DatasetError::Manifest { path: file, source })?;
            cases.push((path, manifest));
        }
        if cases.is_empty() {
            return Err(DatasetError::Empty(folder.to_owned()));
        }
        Ok(Self { cases })
    }

    /// Files of the frames of `split`.
    #[must_use]
    pub fn files(&self, split: Split) -> Vec<PathBuf> {
        let cases = self.cases.iter().filter(|(_, manifest)| manifest.split == split);
        cases
            .flat_map(|(path, manifest)| manifest.frames.iter().map(|frame| path.join(frame)))
            .collect()
    }

    /// The frame in the file `path`.
    ///
    /// # Errors
    /// [`DatasetError`].
    pub fn frame(path: &Path) -> Result<Frame, DatasetError> {
        let bytes = std::fs::read(path).map_err(Self::read(path))?;
        Frame::from_bytes(&bytes)
            .map_err(|source| DatasetError::Frame { path: path.to_owned(), source })
    }
}
