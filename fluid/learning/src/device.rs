//! Where tensors are: the processor, or a CUDA device.
//!
//! The program is not linked to libtorch's CUDA part, which is larger than all else and not needed
//! without such a device. It is opened when one is asked for, and registers itself.

use crate::error::LearningError;
use tch::{Cuda, Device};

/// A device that can be used.
#[derive(Clone, Copy, Debug)]
pub struct Place(pub(crate) Device);

/// libtorch's CUDA part.
const LIBRARY: &str = "libtorch_cuda.so";

/// The device called `name`: `cpu` or `cuda`.
///
/// # Errors
/// [`LearningError::Device`] for another name, or where libtorch's CUDA part or a device is missing.
pub fn place(name: &str) -> Result<Place, LearningError> {
    let fail = |reason: String| LearningError::Device { name: name.to_owned(), reason };
    match name {
        "cpu" => Ok(Place(Device::Cpu)),
        "cuda" => {
            open().map_err(|reason| fail(format!("{LIBRARY} cannot be loaded: {reason}")))?;
            if !Cuda::is_available() {
                return Err(fail("libtorch finds no CUDA device".to_owned()));
            }
            Ok(Place(Device::Cuda(0)))
        }
        _ => Err(fail("there is: cpu, cuda".to_owned())),
    }
}

#[allow(unsafe_code, reason = "opening a library runs its initializers; there is no safe way to")]
fn open() -> Result<(), String> {
    use libloading::os::unix::{Library, RTLD_GLOBAL, RTLD_NOW};
    // SAFETY: the initializers of libtorch_cuda register its operators with the libtorch that is
    // linked and of the same version; nothing of it is called by name.
    let library = unsafe { Library::open(Some(LIBRARY), RTLD_NOW | RTLD_GLOBAL) };
    match library {
        // What is registered must stay.
        Ok(library) => {
            std::mem::forget(library);
            Ok(())
        }
        Err(error) => Err(error.to_string().lines().next().unwrap_or_default().to_owned()),
    }
}
