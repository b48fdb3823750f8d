//! A network on a device of libtorch beside the program's own inference, on the test frames of a data
//! set.

use crate::dataset::{Dataset, DatasetError, Split};
use seakeep_fluid::network::{Network, NetworkError};
use seakeep_learning::{DeviceNetwork, LearningError, place, use_threads};
use std::path::{Path, PathBuf};
use std::time::Instant;
use thiserror::Error;

/// Repetitions of which the quickest counts.
const REPETITIONS: usize = 5;

/// Why there is no comparison.
#[derive(Debug, Error)]
pub enum DeviceError {
    /// The weights cannot be read.
    #[error("{}: cannot be read: {source}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The weights are none.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The device cannot be used.
    #[error(transparent)]
    Learning(#[from] LearningError),
    /// Frames cannot be had.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// The data set has no frame for tests.
    #[error("{}: holds no frames of test cases", .0.display())]
    NoTest(PathBuf),
}

/// What came of it.
#[derive(Clone, Copy, Debug)]
pub struct DeviceRow {
    /// Frames.
    pub frames: usize,
    /// Particles of all frames.
    pub particles: usize,
    /// Largest difference of the two over the largest correction, over all frames.
    pub difference: f64,
    /// Skill of the network on the device: 1 − Σ (p̂ − p)² / Σ (p_t − p)².
    pub skill: f64,
    /// Time of the program's own inference, its preparation included, ms for a thousand particles.
    pub own_ms: f64,
    /// Time on the device, with the coarse equation, which is solved on the processor, and the copy of the result
    /// but not that of the frame, likewise.
    pub device_ms: f64,
    /// Time until a frame is on the device, likewise.
    pub transfer_ms: f64,
}

/// Compares the two inferences of the network in the file `weights` on the test frames in `data`.
///
/// # Errors
/// [`DeviceError`].
pub fn on_device(
    weights: &Path,
    data: &Path,
    device: &str,
    threads: usize,
) -> Result<DeviceRow, DeviceError> {
    let bytes = std::fs::read(weights)
        .map_err(|source| DeviceError::Read { path: weights.to_owned(), source })?;
    let own = Network::from_bytes(&bytes)?;
    use_threads(threads);
    let other = DeviceNetwork::new(&bytes, place(device)?)?;
    let files = Dataset::open(data)?.files(Split::Test);
    if files.is_empty() {
        return Err(DeviceError::NoTest(data.to_owned()));
    }
    let mut row = DeviceRow {
        frames: files.len(),
        particles: 0,
        difference: 0.0,
        skill: 0.0,
        own_ms: 0.0,
        device_ms: 0.0,
        transfer_ms: 0.0,
    };
    let (mut after, mut before) = (0.0, 0.0);
    for path in files {
        let frame = Dataset::frame(&path)?;
        let (mine, own_ms) = quickest(|| own.correction(&frame));
        let (inputs, transfer_ms) = quickest(|| other.inputs(&frame));
        let (theirs, device_ms) = quickest(|| other.correction(&inputs));
        let pairs = || mine.iter().zip(&theirs).map(|(a, b)| (f64::from(*a), f64::from(*b)));
        let largest = pairs().map(|(_, b)| b.abs()).fold(f64::MIN_POSITIVE, f64::max);
        row.difference =
            pairs().map(|(a, b)| (a - b).abs() / largest).fold(row.difference, f64::max);
        for ((_, found), target) in pairs().zip(&frame.target) {
            let target = f64::from(*target);
            after += (found - target).powi(2);
            before += target * target;
        }
        row.particles += frame.len();
        row.own_ms += own_ms;
        row.device_ms += device_ms;
        row.transfer_ms += transfer_ms;
    }
    let thousands = row.particles as f64 / 1e3;
    row.own_ms /= thousands;
    row.device_ms /= thousands;
    row.transfer_ms /= thousands;
    row.skill = 1.0 - after / before;
    Ok(row)
}

/// What `run` gives, and its time in the quickest of some repetitions, ms.
fn quickest<T>(mut run: impl FnMut() -> T) -> (T, f64) {
    let mut timed = || {
        let start = Instant::now();
        let result = run();
        (result, 1e3 * start.elapsed().as_secs_f64())
    };
    let mut best = timed();
    for _ in 1..REPETITIONS {
        let next = timed();
        if next.1 < best.1 {
            best = next;
        }
    }
    best
}
