//! Rigid bodies in the plane: the motion component of seakeep.
//!
//! [`RigidBodies`] is given the hydrodynamic load on its bodies as an affine function of their
//! accelerations, adds weight and loads of its own (springs, moorings), and moves them with a
//! [`RigidBodyEngine`]: [`RapierEngine`] (rapier2d, the default) or [`NewtonEulerEngine`].
//!
//! Time scheme of a step of length h, second order and symplectic for loads that derive from a
//! potential, and the same midpoint as the fluid's:
//!
//! 1. drift: r ← r + V h/2;
//! 2. kick: (M + A) a = F₀ + F_own(r), V ← V + a h;
//! 3. drift: r ← r + V h/2.
//!
//! Frame: x along the waves, y up, angles counter-clockwise; SI; per metre of width.

mod balance;
mod engine;
mod error;
mod newton_euler;
mod own_load;
mod properties;
mod rapier;
mod rigid_bodies;
mod variables;

pub use engine::{AccelerationOf, RigidBodyEngine};
pub use error::BodyError;
pub use newton_euler::NewtonEulerEngine;
pub use own_load::{LinearSpring, OwnLoad};
pub use properties::{BodyProperties, FreeDegrees};
pub use rapier::RapierEngine;
pub use rigid_bodies::RigidBodies;
