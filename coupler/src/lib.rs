//! Co-simulation of floating bodies: the component interface and the masters that drive it.
//!
//! A master sees only [`interface`]: it never learns whether the loads come from particles or
//! from a formula, nor whether the motion comes from rapier2d or from a time series.

mod error;
pub mod interface;
mod master;

pub use error::CouplerError;
pub use master::{
    Acceleration, Coupling, Extrapolation, FixedStepMaster, Implicit, SavedState, Scheme,
    SchemeMemory, StepReport,
};
