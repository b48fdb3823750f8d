//! What can go wrong with rigid bodies. Time and step are added where the error leaves the
//! component, by [`ComponentError`](seakeep_coupler::interface::ComponentError).

use thiserror::Error;

/// An error of the rigid bodies.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum BodyError {
    /// A property outside its range.
    #[error("body {body}: {property} = {value}, must be {allowed}")]
    Property {
        /// Name of the body.
        body: String,
        /// The property with its unit.
        property: &'static str,
        /// Its value.
        value: f64,
        /// The allowed range, in words.
        allowed: &'static str,
    },
    /// A body without a name, or with the name of another.
    #[error("body name {name:?} is empty or used twice")]
    Name {
        /// The name.
        name: String,
    },
    /// A velocity in a degree of freedom that is held.
    #[error("body {body}: {degree} is held but has the velocity {value}")]
    HeldVelocity {
        /// Name of the body.
        body: String,
        /// The degree of freedom.
        degree: &'static str,
        /// The velocity, m/s or rad/s.
        value: f64,
    },
    /// A gravity that is NaN or infinite.
    #[error("gravity = {value} m/s2 is not finite")]
    Gravity {
        /// The value, m/s².
        value: f64,
    },
    /// A body number that does not exist.
    #[error("there is no body number {index}: there are {count}")]
    UnknownBody {
        /// The number, from 0.
        index: usize,
        /// How many bodies there are.
        count: usize,
    },
    /// A property of a mooring line outside its range.
    #[error("{property} = {value}, must be {allowed}")]
    Line {
        /// The property with its unit.
        property: &'static str,
        /// Its value.
        value: f64,
        /// The allowed range, in words.
        allowed: &'static str,
    },
    /// A prescribed motion that cannot be followed.
    #[error("motion: {reason}")]
    Motion {
        /// What is wrong with it.
        reason: String,
    },
    /// A prescribed motion was asked for at a time that it does not cover.
    #[error("the prescribed motion lasts from {start} to {end} s: nothing is known at {time} s")]
    OutsideMotion {
        /// The time asked for, s.
        time: f64,
        /// First time of the motion, s.
        start: f64,
        /// Last time of the motion, s.
        end: f64,
    },
    /// A body for which a motion is prescribed already.
    #[error("body {body}: a motion is prescribed already")]
    PrescribedTwice {
        /// Name of the body.
        body: String,
    },
    /// A state that is not one of this prescribed motion.
    #[error("the state is not one of this prescribed motion")]
    MotionState,
    /// The number of substeps is zero.
    #[error("a step needs at least one substep")]
    NoSubsteps,
    /// A step length that is not positive and finite.
    #[error("step length {value} s must be positive and finite")]
    StepLength {
        /// The step length, s.
        value: f64,
    },
    /// A load response of another size than three rows a body.
    #[error("load response for {loads} bodies and {rows} x {columns} added mass: {bodies} bodies")]
    ResponseSize {
        /// Number of loads given.
        loads: usize,
        /// Rows of the added-mass matrix given.
        rows: usize,
        /// Columns of the added-mass matrix given.
        columns: usize,
        /// Number of bodies.
        bodies: usize,
    },
    /// A number of values that does not fit the number of bodies.
    #[error("{quantity}: {actual} values given, {expected} expected")]
    Length {
        /// What was given.
        quantity: &'static str,
        /// How many values.
        actual: usize,
        /// How many are needed.
        expected: usize,
    },
    /// A value that is NaN or infinite.
    #[error("body {body}: {quantity} = {value} is not finite")]
    NotFinite {
        /// Name of the body.
        body: String,
        /// What is not finite.
        quantity: &'static str,
        /// The value.
        value: f64,
    },
    /// M + A, reduced to the free degrees of freedom, cannot be solved.
    #[error("the {size} x {size} mass matrix with added mass is singular")]
    SingularMass {
        /// Number of free degrees of freedom.
        size: usize,
    },
    /// The engine refused or failed.
    #[error("{engine}: {reason}")]
    Engine {
        /// Name of the engine.
        engine: &'static str,
        /// Why.
        reason: String,
    },
}
