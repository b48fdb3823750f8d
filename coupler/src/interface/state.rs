//! Saved states.

use super::ComponentError;
use serde::{Deserialize, Serialize, de::DeserializeOwned};

/// The serialized state of one component (FMI: `fmi3FMUState`, serialized).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct ComponentState {
    /// Name of the component that saved it.
    pub component: String,
    /// The state, floating-point numbers exactly; [`ComponentState::save`] ends it with a
    /// checksum, so that a damaged file is an error and not a component in an impossible state.
    pub bytes: Vec<u8>,
}

impl ComponentState {
    /// Serializes `state` of the component `name`.
    ///
    /// # Errors
    /// [`ComponentError::State`].
    pub fn save<T: Serialize>(name: &str, state: &T) -> Result<Self, ComponentError> {
        let mut bytes = postcard::to_stdvec(state).map_err(|error| ComponentError::State {
            component: name.to_owned(),
            reason: error.to_string(),
        })?;
        bytes.extend_from_slice(&checksum(&bytes).to_le_bytes());
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
        let Some((content, sum)) = self.bytes.split_last_chunk() else {
            return Err(failed("it is too short".to_owned()));
        };
        if u64::from_le_bytes(*sum) != checksum(content) {
            return Err(failed("it is damaged".to_owned()));
        }
        postcard::from_bytes(content).map_err(|error| failed(error.to_string()))
    }
}

/// The 64-bit FNV-1a hash (Fowler, Noll and Vo; RFC 9923).
fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::{ComponentState, checksum};

    #[test]
    fn checksum_is_fnv_1a() {
        // The published test vectors.
        assert_eq!(checksum(b""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(checksum(b"a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(checksum(b"foobar"), 0x8594_4171_f739_67e8);
    }

    #[test]
    fn numbers_return_to_the_bit_and_damage_is_found() {
        let numbers = vec![0.1, -0.0, f64::MIN_POSITIVE, f64::MAX, f64::NAN];
        let state = ComponentState::save("fluid", &numbers).expect("serializable");
        let bits = |numbers: &[f64]| numbers.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        let back: Vec<f64> = state.load("fluid").expect("its own");
        assert_eq!(bits(&back), bits(&numbers));
        state.load::<Vec<f64>>("body").expect_err("another component's");
        for place in 0..state.bytes.len() {
            let mut damaged = state.clone();
            damaged.bytes[place] ^= 4;
            damaged.load::<Vec<f64>>("fluid").expect_err("a damaged byte");
            damaged.bytes.truncate(place);
            damaged.load::<Vec<f64>>("fluid").expect_err("a cut state");
        }
    }
}
