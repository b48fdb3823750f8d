//! Training of the pressure networks of Ma, Zhang, Yan & Li (2024), section 2.3, and their
//! inference by libtorch.
//!
//! Everything here needs the feature `torch` and libtorch. A network trained here is a weights file
//! that `seakeep-fluid` reads; that crate's own inference and this one's agree to rounding, which a
//! test shows.

#[cfg(feature = "torch")]
mod device;
#[cfg(feature = "torch")]
mod error;
#[cfg(feature = "torch")]
mod graph;
#[cfg(feature = "torch")]
mod model;
#[cfg(feature = "torch")]
mod noise;
#[cfg(feature = "torch")]
mod optimizer;
#[cfg(feature = "torch")]
mod paper;
#[cfg(feature = "torch")]
mod residual;
#[cfg(feature = "torch")]
mod trainer;

#[cfg(feature = "torch")]
pub use device::{Place, place};
#[cfg(feature = "torch")]
pub use error::LearningError;
#[cfg(feature = "torch")]
pub use model::{DeviceNetwork, Inputs, Model, StepByStep};
#[cfg(feature = "torch")]
pub use trainer::{Losses, Settings, Trainer, use_threads};
