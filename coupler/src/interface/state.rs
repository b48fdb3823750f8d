//! Saved states.

use super::ComponentError;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

/// The serialized state of one component (FMI: `fmi3FMUState`, serialized).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ComponentState {
    /// Name of the component that saved it.
    pub component: String,
    /// The state; floating-point numbers are stored exactly.
    pub bytes: Vec<u8>,
}

impl ComponentState {
    /// Serializes `state` of the component `name`.
    ///
    /// # Errors
    /// [`ComponentError::State`].
    pub fn save<T: Serialize>(name: &str, state: &T) -> Result<Self, ComponentError> {
        let bytes = postcard::to_stdvec(state).map_err(|error| ComponentError::State {
            component: name.to_owned(),
            reason: error.to_string(),
        })?;
        Ok(Self { component: name.to_owned(), bytes })
    }

    /// Reads the state back for the component `name`.
    ///
    /// # Errors
    /// [`ComponentError::State`] for another component's state or damaged bytes.
    pub fn load<T: DeserializeOwned>(&self, name: &str) -> Result<T, ComponentError> {
        let failed = |reason: String| ComponentError::State { component: name.to_owned(), reason };
        if self.component != name {
            return Err(failed(format!("this is a state of {}", self.component)));
        }
        postcard::from_bytes(&self.bytes).map_err(|error| failed(error.to_string()))
    }
}
