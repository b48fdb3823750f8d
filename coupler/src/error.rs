//! What can go wrong in a co-simulation.

use crate::interface::ComponentError;
use thiserror::Error;

/// An error of a master.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CouplerError {
    /// The communication step is not positive and finite, or the start time is not finite.
    #[error("start at t = {start_time} s with a step of {communication_step} s is impossible")]
    Time {
        /// Start time, s.
        start_time: f64,
        /// Communication step, s.
        communication_step: f64,
    },
    /// A parameter of the coupling is out of its range.
    #[error("{setting} = {value} of the coupling must be {allowed}")]
    Setting {
        /// Name of the parameter.
        setting: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        allowed: &'static str,
    },
    /// The components do not speak of the same boundaries.
    #[error("{load} has {load_boundaries} boundaries, but {motion} moves {motion_bodies}")]
    BoundaryCount {
        /// Name of the load component.
        load: String,
        /// Its number of boundaries.
        load_boundaries: usize,
        /// Name of the motion component, or `no component`.
        motion: String,
        /// Its number of bodies.
        motion_bodies: usize,
    },
    /// The algebraic loop between load and acceleration cannot be closed.
    #[error(
        "the load of {component} depends at once on the acceleration, but it does not provide \
         the directional derivative that this scheme needs to stay stable; iterate instead"
    )]
    FeedthroughWithoutDerivative {
        /// Name of the load component.
        component: String,
    },
    /// The motion component answers a load at once: a second algebraic loop.
    #[error("the motion of {component} depends at once on the load: this scheme cannot close it")]
    MotionFeedthrough {
        /// Name of the motion component.
        component: String,
    },
    /// A component that would have to repeat a step cannot go back.
    #[error("an implicit scheme repeats steps, but {component} cannot save and restore its state")]
    CannotRepeat {
        /// Name of the component.
        component: String,
    },
    /// An implicit step did not converge.
    #[error(
        "step {step} at t = {time:.6} s: the coupling did not converge in {iterations} \
         iterations: residual {residual:.3e}, tolerance {tolerance:.3e}"
    )]
    NotConverged {
        /// Time at the start of the step, s.
        time: f64,
        /// Number of the step, from 1.
        step: u64,
        /// Evaluations of the load.
        iterations: u32,
        /// Residual of the last, relative to the accelerations.
        residual: f64,
        /// What it had to fall to.
        tolerance: f64,
    },
    /// A component cannot save its state.
    #[error("{component} cannot save and restore its state")]
    NoStateSaving {
        /// Name of the component.
        component: String,
    },
    /// A saved state that does not belong to this co-simulation.
    #[error("the saved state does not fit: {reason}")]
    SavedState {
        /// Why.
        reason: String,
    },
    /// A component returned a number of values that does not fit the boundaries.
    #[error(
        "step {step} at t = {time:.6} s: {component} returned {actual} {quantity}, not {expected}"
    )]
    Length {
        /// Name of the component.
        component: String,
        /// What was returned.
        quantity: &'static str,
        /// How many values.
        actual: usize,
        /// How many are needed.
        expected: usize,
        /// Time at the start of the step, s.
        time: f64,
        /// Number of the step, from 1; 0 before the first.
        step: u64,
    },
    /// A component failed.
    #[error("step {step} at t = {time:.6} s: {source}")]
    Component {
        /// Time at the start of the step, s.
        time: f64,
        /// Number of the step, from 1; 0 before the first.
        step: u64,
        /// The component's error.
        source: ComponentError,
    },
}
