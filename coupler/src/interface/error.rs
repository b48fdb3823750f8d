//! What can go wrong inside a component, as a master sees it.

use super::ValueReference;
use thiserror::Error;

/// An error of a component.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ComponentError {
    /// A step failed.
    #[error("{component}: step {step} at t = {time:.6} s failed: {source}")]
    Step {
        /// Name of the component.
        component: String,
        /// Time at the start of the step, s.
        time: f64,
        /// Number of the step, from 1.
        step: u64,
        /// The component's own error.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The component could not be initialized.
    #[error("{component}: initialization failed: {source}")]
    Initialization {
        /// Name of the component.
        component: String,
        /// The component's own error.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A call that the component's life cycle does not allow now.
    #[error("{component}: {call} is not allowed {state}")]
    CallSequence {
        /// Name of the component.
        component: String,
        /// The call.
        call: &'static str,
        /// Where the component stands, in words.
        state: &'static str,
    },
    /// A communication point that is not where the component stands.
    #[error("{component}: asked to step from t = {asked} s, but stands at t = {actual} s")]
    CommunicationPoint {
        /// Name of the component.
        component: String,
        /// The communication point that the master named, s.
        asked: f64,
        /// The component's time, s.
        actual: f64,
    },
    /// A value reference that the component does not have.
    #[error("{component}: no variable has value reference {}", .reference.0)]
    UnknownVariable {
        /// Name of the component.
        component: String,
        /// The value reference.
        reference: ValueReference,
    },
    /// A variable that is not an input was set.
    #[error("{component}: {variable} is not an input")]
    NotAnInput {
        /// Name of the component.
        component: String,
        /// Name of the variable.
        variable: String,
    },
    /// A value is NaN or infinite.
    #[error("{component}: {variable} = {value} is not finite")]
    NotFinite {
        /// Name of the component.
        component: String,
        /// Name of the variable.
        variable: String,
        /// The value.
        value: f64,
    },
    /// A state could not be saved or restored.
    #[error("{component}: state: {reason}")]
    State {
        /// Name of the component.
        component: String,
        /// Why.
        reason: String,
    },
}
