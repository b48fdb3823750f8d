//! Figures drawn from the series of a run, each a plain function over slices.

pub mod decay;
pub mod hydrostatics;
pub mod signal;
pub mod wave;
