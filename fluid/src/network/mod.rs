//! Networks that give the pressure in place of the pressure Poisson equation, section 2.3 of
//! Ma, Zhang, Yan & Li (2024), and their inference on the processor in single precision.

mod graph;
pub(crate) mod lattice;
pub mod paper;
pub mod residual;
mod weights;

use crate::frame::Frame;
pub use crate::sparse::Rows;
pub use graph::{CoarseLevel, PaperGraph, ResidualGraph, ResidualStep};
use paper::PaperWeights;
use residual::ResidualWeights;
use serde::{Deserialize, Serialize};
use thiserror::Error;
use weights::Tensors;
pub use weights::{Decoded, decode, encode};

/// A network's inference in another place than this program's own code, as by libtorch on a device.
pub trait Inference: Send + Sync {
    /// The change of the pressure that the residual network finds in `step`: Pa, one for each particle.
    ///
    /// # Errors
    /// A line that says what failed.
    fn residual(&self, step: ResidualStep<'_>) -> Result<Vec<f32>, String>;

    /// The change of the last pressure that the paper's network finds for `frame`, whose target is not
    /// known: Pa, one for each particle.
    ///
    /// # Errors
    /// A line that says what failed.
    fn paper(&self, frame: &Frame) -> Result<Vec<f32>, String>;
}

/// A network with its weights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Network(pub(crate) Weights);

/// The weights file that comes with the program.
pub const SHIPPED: &[u8] = include_bytes!("../../weights/residual.safetensors");

/// The weights of one of the networks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Weights {
    /// [`residual`].
    Residual(ResidualWeights),
    /// [`paper`].
    Paper(Box<PaperWeights>),
}

/// What is wrong with a weights file.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// No safetensors file, or a truncated one.
    #[error("the weights cannot be read: {0}")]
    Unreadable(String),
    /// The metadata name no network.
    #[error("the weights do not say for which network they are (metadata key \"network\")")]
    NoKind,
    /// The metadata name a network that there is not.
    #[error("there is no network \"{kind}\" (there are: residual, paper)")]
    Kind {
        /// The name.
        kind: String,
    },
    /// A tensor is not in single precision.
    #[error("tensor {tensor} of the weights is not of type F32")]
    Type {
        /// Its name.
        tensor: String,
    },
    /// A tensor holds NaN or infinity.
    #[error("tensor {tensor} of the weights holds a number that is not finite")]
    NotFinite {
        /// Its name.
        tensor: String,
    },
    /// A tensor is not there.
    #[error("the weights have no tensor {tensor}")]
    Missing {
        /// Its name.
        tensor: String,
    },
    /// A tensor of another shape.
    #[error(
        "tensor {tensor} of the weights has the shape {found:?}, the network needs {expected:?}"
    )]
    Shape {
        /// Its name.
        tensor: String,
        /// The shape in the file.
        found: Vec<usize>,
        /// The shape of the network.
        expected: Vec<usize>,
    },
}

impl Network {
    /// The network that comes with the program.
    ///
    /// # Errors
    /// Never, unless the program was built with a damaged file.
    pub fn shipped() -> Result<Self, NetworkError> {
        Self::from_bytes(SHIPPED)
    }

    /// The network in a weights file.
    ///
    /// # Errors
    /// [`NetworkError`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, NetworkError> {
        let (tensors, kind) = Tensors::read(bytes)?;
        match kind.as_str() {
            "residual" => ResidualWeights::new(&tensors).map(Weights::Residual).map(Self),
            "paper" => PaperWeights::new(&tensors).map(|own| Self(Weights::Paper(Box::new(own)))),
            _ => Err(NetworkError::Kind { kind }),
        }
    }
}
