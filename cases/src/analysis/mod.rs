//! Figures drawn from the series of a run, each a plain function over slices.

pub mod comparison;
pub mod decay;
pub mod harmonics;
pub mod hydrostatics;
pub mod reflection;
pub mod signal;
pub mod spectrum;
pub mod wave;
pub mod zero_crossing;
