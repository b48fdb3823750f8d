//! Fluid.
pub mod setup;
