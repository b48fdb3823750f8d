//! Which components can work together in which scheme.

use super::settings::{Coupling, Scheme};
use crate::CouplerError;
use crate::interface::{Component, LoadComponent, MotionComponent};

/// Refuses components that cannot work together in this coupling.
pub(super) fn check_combination(
    coupling: &Coupling,
    load: &dyn LoadComponent,
    motion: Option<&dyn MotionComponent>,
) -> Result<(), CouplerError> {
    let (load_boundaries, motion_bodies) =
        (load.boundary_count(), motion.map_or(0, |motion| motion.body_count()));
    if load_boundaries != motion_bodies {
        return Err(CouplerError::BoundaryCount {
            load: load.description().name.clone(),
            load_boundaries,
            motion: motion.map_or("no component".to_owned(), |m| m.description().name.clone()),
            motion_bodies,
        });
    }
    let Some(motion) = motion else { return Ok(()) };
    match coupling.scheme {
        // An explicit scheme breaks every loop by its prediction.
        Scheme::Jacobi | Scheme::GaussSeidel => Ok(()),
        Scheme::InterfaceJacobian => {
            let capabilities = load.description().capabilities;
            if capabilities.has_direct_feedthrough && !capabilities.provides_directional_derivative
            {
                let component = load.description().name.clone();
                return Err(CouplerError::FeedthroughWithoutDerivative { component });
            }
            if motion.description().capabilities.has_direct_feedthrough {
                let component = motion.description().name.clone();
                return Err(CouplerError::MotionFeedthrough { component });
            }
            Ok(())
        }
        Scheme::Implicit(_) => {
            check_repeatable(motion)?;
            if is_affine(coupling, load) { Ok(()) } else { check_repeatable(load) }
        }
    }
}

/// Whether the load of a whole communication step is known for any acceleration once it has been
/// solved for: F = F₀ − A a holds within one step of the load component.
pub(super) fn is_affine(coupling: &Coupling, load: &dyn LoadComponent) -> bool {
    coupling.load_substeps == 1 && load.description().capabilities.provides_directional_derivative
}

fn check_repeatable(component: &dyn Component) -> Result<(), CouplerError> {
    let description = component.description();
    if description.capabilities.can_get_and_set_state {
        return Ok(());
    }
    Err(CouplerError::CannotRepeat { component: description.name.clone() })
}

/// Refuses a component that cannot be saved.
pub(super) fn check_state_saving(component: &dyn Component) -> Result<(), CouplerError> {
    let description = component.description();
    if description.capabilities.can_get_and_set_state {
        return Ok(());
    }
    Err(CouplerError::NoStateSaving { component: description.name.clone() })
}
