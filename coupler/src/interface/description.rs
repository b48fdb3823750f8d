//! What a component says of itself: FMI 3.0's model description, as far as it is used.

use serde::{Deserialize, Serialize};

/// Identifies a variable within its component (FMI: `valueReference`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
pub struct ValueReference(pub u32);

/// Role of a variable (FMI: `causality`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Causality {
    /// Set by the master between steps.
    Input,
    /// Computed by the component for others.
    Output,
    /// Constant over a run.
    Parameter,
    /// Computed by the component, for inspection.
    Local,
}

/// When a variable may change (FMI: `variability`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "camelCase")]
pub enum Variability {
    /// Never.
    Fixed,
    /// At communication points only.
    Discrete,
    /// Continuously.
    Continuous,
}

/// One variable of a component.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Variable {
    /// Name, such as `box.force_y`.
    pub name: String,
    /// Handle for getting and setting.
    pub reference: ValueReference,
    /// Role.
    pub causality: Causality,
    /// When it may change.
    pub variability: Variability,
    /// Unit in SI, such as `N/m`; `1` if it has none.
    pub unit: String,
    /// What it is.
    pub description: String,
}

/// What a component can do and needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Capabilities {
    /// State save and restore (FMI: `canGetAndSetFMUState` and `canSerializeFMUState`).
    pub can_get_and_set_state: bool,
    /// The derivative of outputs with respect to inputs (FMI: `providesDirectionalDerivatives`).
    pub provides_directional_derivative: bool,
    /// Steps of different length (FMI: `canHandleVariableCommunicationStepSize`).
    pub can_handle_variable_step: bool,
    /// An output depends at once on an input: a master must treat the algebraic loop.
    pub has_direct_feedthrough: bool,
}

/// What a component says of itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Description {
    /// Name of the component.
    pub name: String,
    /// What it can do and needs.
    pub capabilities: Capabilities,
    /// Its variables, by rising value reference.
    pub variables: Vec<Variable>,
}

impl Description {
    /// The variable named `name`, if there is one.
    #[must_use]
    pub fn variable(&self, name: &str) -> Option<&Variable> {
        self.variables.iter().find(|variable| variable.name == name)
    }
}
