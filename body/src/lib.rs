//! Rigid bodies in the plane: the motion component of seakeep.
//!
//! [`RigidBodies`] is given the hydrodynamic load on its bodies as an affine function of their
//! accelerations, adds weight and loads of its own (springs, moorings), and moves them with a
//! [`RigidBodyEngine`]: [`RapierEngine`] (rapier2d, the default) or [`NewtonEulerEngine`]. A body
//! can also follow a [`PrescribedMotion`], whatever the loads on it.
//!
//! Time scheme of a step of length h with rapier2d, second order and symplectic for loads that
//! derive from a potential, and the same midpoint as the fluid's:
//!
//! 1. drift: r ← r + V h/2;
//! 2. kick: (M + A) a = F₀ + F_own(r), V ← V + a h;
//! 3. drift: r ← r + V h/2.
//!
//! The other engine is of fourth order. Either may take several substeps in a step.
//!
//! ```
//! use nalgebra::Point2;
//! use seakeep_body::{BodyProperties, LinearSpring, RapierEngine, RigidBodies};
//! use seakeep_coupler::interface::{Component, MotionComponent};
//!
//! // A box of 42 kg/m released 0.05 m above its rest on a spring in heave.
//! let body = BodyProperties::new("box", 42.0, 1.5, Point2::new(0.0, 0.05));
//! let mut bodies = RigidBodies::new(vec![body], 0.0, Box::new(RapierEngine::new()))?;
//! let spring = LinearSpring::diagonal(0.0, 3924.0, 0.0, Point2::origin());
//! bodies.add_own_load(0, Box::new(spring))?;
//!
//! bodies.enter_initialization_mode(0.0)?;
//! bodies.exit_initialization_mode()?;
//! bodies.do_step(0.0, 0.01)?;
//! assert!(bodies.kinematics()[0].velocity.y < 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Frame: x along the waves, y up, angles counter-clockwise; SI; per metre of width.

mod balance;
mod contact;
mod engine;
mod error;
mod mooring;
mod newton_euler;
mod own_load;
mod prescribed;
mod properties;
mod rapier;
mod rigid_bodies;
mod spline;
mod variables;

pub use contact::Contacts;
pub use engine::{Forcing, RigidBodyEngine};
pub use error::BodyError;
pub use mooring::{
    Catenary, LineLaw, LineState, MooringLine, Spring, UnknownTension, static_tensions,
};
pub use newton_euler::NewtonEulerEngine;
pub use own_load::{LinearSpring, OwnLoad};
pub use prescribed::{Harmonic, Oscillation, PrescribedMotion, TimeSeries};
pub use properties::{BodyProperties, FreeDegrees};
pub use rapier::RapierEngine;
pub use rigid_bodies::RigidBodies;
