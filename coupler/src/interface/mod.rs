//! The component interface: co-simulation in FMI 3.0's terms, in process.
//!
//! Life cycle of a component (FMI 3.0, section 4.2): instantiate (the component's own
//! constructor) → [`Component::enter_initialization_mode`] →
//! [`Component::exit_initialization_mode`] → any number of [`Component::do_step`] →
//! [`Component::terminate`].
//!
//! Two typed roles carry the hot path without copies: a [`LoadComponent`] is given the kinematics
//! of boundaries and answers with the load on each; a [`MotionComponent`] is given loads and
//! answers with kinematics. The same quantities are reachable by name and value reference
//! ([`Variable`], [`Component::get_float64`]) for recorders, the command line and FMI.
//!
//! Frame: x along the waves, y up, angles counter-clockwise; SI; loads and masses per metre of
//! width.

mod description;
mod error;
mod kinematics;
mod state;

pub use description::{
    Capabilities, Causality, Description, ValueReference, Variability, Variable,
};
pub use error::ComponentError;
pub use kinematics::{BoundaryKinematics, Load, LoadResponse};
pub use state::ComponentState;

/// A co-simulation component: anything with inputs, outputs and a state that steps in time.
pub trait Component {
    /// Name, capabilities and variables. Constant over the life of the component.
    fn description(&self) -> &Description;

    /// Starts the initialization at `start_time` (s). Inputs set from now on are start values.
    ///
    /// # Errors
    /// When the component cannot start from its set-up.
    fn enter_initialization_mode(&mut self, start_time: f64) -> Result<(), ComponentError>;

    /// Ends the initialization: the outputs are valid at the start time afterwards.
    ///
    /// # Errors
    /// When no consistent initial state exists.
    fn exit_initialization_mode(&mut self) -> Result<(), ComponentError>;

    /// Advances from `current_communication_point` by `communication_step_size` (both s).
    ///
    /// # Errors
    /// When the step fails (a solver that does not converge, a value that is not finite) or the
    /// communication point is not where the component stands. The state is then that of before
    /// the step or must be restored.
    fn do_step(
        &mut self,
        current_communication_point: f64,
        communication_step_size: f64,
    ) -> Result<(), ComponentError>;

    /// Ends the simulation. Outputs stay readable.
    fn terminate(&mut self);

    /// Value of a variable in its unit.
    ///
    /// # Errors
    /// [`ComponentError::UnknownVariable`].
    fn get_float64(&self, variable: ValueReference) -> Result<f64, ComponentError>;

    /// Sets an input variable, in its unit.
    ///
    /// # Errors
    /// [`ComponentError::UnknownVariable`], [`ComponentError::NotAnInput`], or
    /// [`ComponentError::NotFinite`] for a NaN or an infinity.
    fn set_float64(&mut self, variable: ValueReference, value: f64) -> Result<(), ComponentError>;

    /// The whole state, serialized: [`Component::set_state`] with it repeats a step to the bit.
    ///
    /// # Errors
    /// [`ComponentError::State`] when it cannot be serialized.
    fn get_state(&self) -> Result<ComponentState, ComponentError>;

    /// Restores a state that [`Component::get_state`] of an equal component returned.
    ///
    /// # Errors
    /// [`ComponentError::State`] when it is not a state of such a component.
    fn set_state(&mut self, state: &ComponentState) -> Result<(), ComponentError>;
}

/// A component that is given the kinematics of rigid boundaries and returns the load on each.
///
/// Its load may have direct feedthrough from the acceleration. With a directional derivative a
/// master needs three calls for a step from `t` to `t + h`: [`set_kinematics`](Self::set_kinematics)
/// at `t`, [`solve_load`](Self::solve_load) for the load at zero acceleration with its derivative,
/// and, once the motion has been solved for, [`set_accelerations`](Self::set_accelerations) and
/// `do_step`. Without one, `solve_load` is left out: accelerations are set, the step is taken, and
/// [`loads`](Self::loads) is what they lead to.
pub trait LoadComponent: Component {
    /// Number of rigid boundaries.
    fn boundary_count(&self) -> usize;

    /// Sets the kinematics of every boundary at the current communication point, in the
    /// component's order of boundaries.
    fn set_kinematics(&mut self, kinematics: &[BoundaryKinematics]);

    /// Load on the boundaries over the step that begins at `current_communication_point`, as an
    /// affine function of their accelerations, held over the step. Repeating the call with the
    /// same inputs returns the same bits. Not called on a component that has direct feedthrough
    /// but [provides no derivative](Capabilities::provides_directional_derivative).
    ///
    /// # Errors
    /// As [`Component::do_step`].
    fn solve_load(
        &mut self,
        current_communication_point: f64,
        communication_step_size: f64,
    ) -> Result<&LoadResponse, ComponentError>;

    /// Sets the mean acceleration of each boundary over the coming step: `[x (m/s²), y (m/s²),
    /// angle (rad/s²)]` per boundary, `3 * boundary_count` values.
    fn set_accelerations(&mut self, accelerations: &[f64]);

    /// Load on each boundary over the last completed step.
    fn loads(&self) -> &[Load];
}

/// A component that is given loads and returns the kinematics of rigid bodies.
pub trait MotionComponent: Component {
    /// Number of bodies.
    fn body_count(&self) -> usize;

    /// Kinematics of every body at the current communication point.
    fn kinematics(&self) -> &[BoundaryKinematics];

    /// Sets the load that acts over the coming step. The component adds loads of its own
    /// (weight, moorings) and solves (M + A) a = F₀ + F_own, so that a body lighter than its
    /// added mass moves stably.
    fn set_load(&mut self, response: &LoadResponse);

    /// Mean acceleration of each body over the last completed step, laid out as in
    /// [`LoadComponent::set_accelerations`].
    fn mean_accelerations(&self) -> &[f64];
}
