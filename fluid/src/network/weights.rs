//! Weights files: safetensors, one tensor a name, with the kind of network in the metadata.

use super::NetworkError;
use safetensors::tensor::TensorView;
use safetensors::{Dtype, SafeTensors};
use std::collections::{BTreeMap, HashMap};

/// Named tensors in single precision, each with its shape.
#[derive(Clone, Debug, Default)]
pub(crate) struct Tensors(BTreeMap<String, (Vec<usize>, Vec<f32>)>);

impl Tensors {
    /// Reads a weights file; also the kind of network that it says it is for.
    pub(crate) fn read(bytes: &[u8]) -> Result<(Self, String), NetworkError> {
        let (tensors, mut metadata) = Self::read_any(bytes)?;
        Ok((tensors, metadata.remove("network").ok_or(NetworkError::NoKind)?))
    }

    /// Reads a file of tensors in single precision; also its metadata.
    fn read_any(bytes: &[u8]) -> Result<(Self, HashMap<String, String>), NetworkError> {
        let unreadable =
            |error: safetensors::SafeTensorError| NetworkError::Unreadable(error.to_string());
        let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(unreadable)?;
        let metadata = metadata.metadata().clone().unwrap_or_default();
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
        Ok((Self(tensors), metadata))
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

/// A weights file: named `tensors`, each with its shape, and `metadata` that name the network (key
/// "network") and say how it was trained.
///
/// # Errors
/// [`NetworkError::Unreadable`] where a tensor has not as many values as its shape asks for.
pub fn encode(
    tensors: &[(String, Vec<usize>, Vec<f32>)],
    metadata: HashMap<String, String>,
) -> Result<Vec<u8>, NetworkError> {
    let unreadable =
        |error: safetensors::SafeTensorError| NetworkError::Unreadable(error.to_string());
    let bytes: Vec<Vec<u8>> = tensors
        .iter()
        .map(|(_, _, values)| values.iter().flat_map(|value| value.to_le_bytes()).collect())
        .collect();
    let views = tensors
        .iter()
        .zip(&bytes)
        .map(|((name, shape, _), bytes)| {
            TensorView::new(Dtype::F32, shape.clone(), bytes).map(|view| (name.as_str(), view))
        })
        .collect::<Result<Vec<_>, _>>()
        .map_err(unreadable)?;
    safetensors::serialize(views, Some(metadata)).map_err(unreadable)
}

/// Named tensors in single precision of any file, with their shapes, and its metadata.
pub type Decoded = (Vec<(String, Vec<usize>, Vec<f32>)>, HashMap<String, String>);

/// The tensors and metadata of a file that [`encode`] wrote.
///
/// # Errors
/// [`NetworkError`].
pub fn decode(bytes: &[u8]) -> Result<Decoded, NetworkError> {
    let (tensors, metadata) = Tensors::read_any(bytes)?;
    let tensors = tensors.0.into_iter().map(|(name, (shape, values))| (name, shape, values));
    Ok((tensors.collect(), metadata))
}
