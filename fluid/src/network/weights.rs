//! Weights files: safetensors, one tensor a name, with the kind of network in the metadata.

use super::NetworkError;
use safetensors::{Dtype, SafeTensors};
use std::collections::BTreeMap;

/// Named tensors in single precision, each with its shape.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tensors(BTreeMap<String, (Vec<usize>, Vec<f32>)>);

impl Tensors {
    /// Reads a weights file; also the kind of network that it says it is for.
    pub(crate) fn read(bytes: &[u8]) -> Result<(Self, String), NetworkError> {
        let unreadable =
            |error: safetensors::SafeTensorError| NetworkError::Unreadable(error.to_string());
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(unreadable)?;
        let kind = metadata.metadata().as_ref().and_then(|own| own.get("network")).cloned();
        let file = SafeTensors::deserialize(bytes).map_err(unreadable)?;
        let mut tensors = BTreeMap::new();
        for (name, view) in file.tensors() {
            if view.dtype() != Dtype::F32 {
                return Err(NetworkError::Type { tensor: name });
            }
            let values: Vec<f32> =
                view.data().as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
            if values.iter().any(|value| !value.is_finite()) {
                return Err(NetworkError::NotFinite { tensor: name });
            }
            tensors.insert(name, (view.shape().to_vec(), values));
        }
        Ok((Self(tensors), kind.ok_or(NetworkError::NoKind)?))
    }

    /// The values of the tensors of these names and shapes.
    pub(crate) fn take<const N: usize>(
        &self,
        wanted: [(&str, &[usize]); N],
    ) -> Result<[Vec<f32>; N], NetworkError> {
        let mut values = std::array::from_fn(|_| Vec::new());
        for (values, (name, shape)) in values.iter_mut().zip(wanted) {
            let (found, own) = self
                .0
                .get(name)
                .ok_or_else(|| NetworkError::Missing { tensor: name.to_owned() })?;
            if found != shape {
                return Err(NetworkError::Shape {
                    tensor: name.to_owned(),
                    found: found.clone(),
                    expected: shape.to_vec(),
                });
            }
            values.clone_from(own);
        }
        Ok(values)
    }
}
