//! Incompressible SPH for waves and rigid boundaries in a vertical plane.
//!
//! [`Fluid`] owns the particles: as a component of the co-simulation it takes the kinematics of
//! rigid boundaries and returns hydrodynamic force and torque (Eqs. (19) and (20) of Ma, Zhang,
//! Yan & Li 2024, whose equation numbers are used throughout) together with their directional
//! derivative with respect to the boundaries' acceleration, the added mass.
//!
//! Frame: x along the tank, y up from the bed, angles counter-clockwise; SI, per metre of width.

mod broken_water;
mod component;
mod corner;
mod error;
mod fields;
mod fill;
mod fit;
mod fluid;
pub mod frame;
mod free_surface;
mod geometry;
mod krylov;
mod lanes;
mod loads;
mod measure;
mod motion;
mod neighbours;
pub mod network;
mod observe;
mod operators;
mod particles;
mod plan;
mod preconditioner;
mod pressure;
mod regularise;
mod resample;
pub mod setup;
mod small_matrix;
mod sparse;
mod state;
#[cfg(test)]
mod tests;
pub mod trial;
mod variables;
mod walls;

pub use error::FluidError;
pub use fluid::Fluid;
pub use observe::{Diagnostics, ParticleCounts, ParticlesView};
pub use plan::{Plan, PlanEntry, Stage};
pub use pressure::Rival;
pub use pressure::solver::PressureReport;
pub use setup::FluidSetup;
