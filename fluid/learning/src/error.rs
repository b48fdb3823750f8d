//! What can go wrong in training.

use seakeep_fluid::network::NetworkError;
use tch::TchError;
use thiserror::Error;

/// An error of training, or of inference by libtorch.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum LearningError {
    /// A device that there is not.
    #[error("device {name}: {reason}")]
    Device {
        /// What was asked for.
        name: String,
        /// Why it cannot be had.
        reason: String,
    },
    /// A weights file or a checkpoint that is none, or for another network.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// Weights to start from that are another network's.
    #[error("the weights to start from are of the network \"{0}\"")]
    OtherNetwork(&'static str),
    /// A checkpoint of another training.
    #[error("the checkpoint is of another training: {0}")]
    Checkpoint(String),
    /// The loss is not finite.
    #[error("the loss is not finite at step {step}: the learning rate may be too large")]
    Diverged {
        /// Number of the step.
        step: u64,
    },
    /// libtorch refuses an operation.
    #[error("libtorch: {0}")]
    Torch(String),
}

impl From<TchError> for LearningError {
    fn from(error: TchError) -> Self {
        // libtorch appends a trace of calls.
        Self::Torch(error.to_string().lines().next().unwrap_or_default().to_owned())
    }
}
