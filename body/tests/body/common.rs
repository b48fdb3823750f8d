//! A load component with an analytic answer: F = −K (r − r₀) − A a, evaluated at the midpoint of
//! the step as the fluid does.

use nalgebra::{DMatrix, DVector, Vector2};
use seakeep_body::{BodyProperties, RapierEngine, RigidBodies};
use seakeep_coupler::interface::{
    BoundaryKinematics, Capabilities, Component, ComponentError, ComponentState, Description, Load,
    LoadComponent, LoadResponse, ValueReference,
};

pub(crate) const NAME: &str = "linear_load";

/// Linear restoring load and added mass on any number of boundaries, about a pose of rest.
pub(crate) struct LinearLoad {
    description: Description,
    stiffness: DMatrix<f64>,
    rest: Vec<f64>,
    now: Vec<BoundaryKinematics>,
    accelerations: Vec<f64>,
    response: LoadResponse,
    loads: Vec<Load>,
    /// Added to the load that is reported, but not to the one that is handed over, N/m.
    pub(crate) dishonesty: f64,
}

impl LinearLoad {
    pub(crate) fn new(stiffness: DMatrix<f64>, added_mass: DMatrix<f64>, rest: Vec<f64>) -> Self {
        let boundaries = rest.len() / 3;
        let capabilities = Capabilities {
            can_get_and_set_state: true,
            provides_directional_derivative: true,
            can_handle_variable_step: true,
            has_direct_feedthrough: true,
        };
        let description =
            Description { name: NAME.to_owned(), capabilities, variables: Vec::new() };
        Self {
            description,
            stiffness,
            rest,
            now: Vec::new(),
            accelerations: vec![0.0; 3 * boundaries],
            response: LoadResponse { added_mass, ..LoadResponse::zero(boundaries) },
            loads: vec![Load::zero(); boundaries],
            dishonesty: 0.0,
        }
    }

    /// One boundary with the same stiffness and added mass in sway, heave and roll about the
    /// origin.
    pub(crate) fn isotropic(stiffness: f64, added_mass: f64) -> Self {
        let identity = DMatrix::identity(3, 3);
        Self::new(&identity * stiffness, identity * added_mass, vec![0.0; 3])
    }
}

impl Component for LinearLoad {
    fn description(&self) -> &Description {
        &self.description
    }
    fn enter_initialization_mode(&mut self, _start_time: f64) -> Result<(), ComponentError> {
        Ok(())
    }
    fn exit_initialization_mode(&mut self) -> Result<(), ComponentError> {
        Ok(())
    }
    fn do_step(&mut self, _now: f64, _step: f64) -> Result<(), ComponentError> {
        self.response.at(&self.accelerations, &mut self.loads);
        for load in &mut self.loads {
            load.force.y += self.dishonesty;
        }
        Ok(())
    }
    fn terminate(&mut self) {}
    fn get_float64(&self, reference: ValueReference) -> Result<f64, ComponentError> {
        Err(ComponentError::UnknownVariable { component: NAME.to_owned(), reference })
    }
    fn set_float64(&mut self, reference: ValueReference, _: f64) -> Result<(), ComponentError> {
        Err(ComponentError::UnknownVariable { component: NAME.to_owned(), reference })
    }
    fn get_state(&self) -> Result<ComponentState, ComponentError> {
        ComponentState::save(NAME, &self.loads)
    }
    fn set_state(&mut self, state: &ComponentState) -> Result<(), ComponentError> {
        self.loads = state.load(NAME)?;
        Ok(())
    }
}

impl LoadComponent for LinearLoad {
    fn boundary_count(&self) -> usize {
        self.loads.len()
    }
    fn set_kinematics(&mut self, kinematics: &[BoundaryKinematics]) {
        self.now = kinematics.to_vec();
    }
    fn solve_load(&mut self, _now: f64, step: f64) -> Result<&LoadResponse, ComponentError> {
        let pose: Vec<f64> = self
            .now
            .iter()
            .map(|body| body.drifted(0.5 * step))
            .flat_map(|body| [body.position.x, body.position.y, body.angle])
            .collect();
        let offset = DVector::from_iterator(
            pose.len(),
            pose.iter().zip(&self.rest).map(|(value, rest)| value - rest),
        );
        let load = -&self.stiffness * offset;
        for (body, zero) in self.response.at_zero_acceleration.iter_mut().enumerate() {
            zero.force = Vector2::new(load[3 * body], load[3 * body + 1]);
            zero.torque = load[3 * body + 2];
        }
        Ok(&self.response)
    }
    fn set_accelerations(&mut self, accelerations: &[f64]) {
        self.accelerations = accelerations.to_vec();
    }
    fn loads(&self) -> &[Load] {
        &self.loads
    }
}

/// The bodies on rapier2d, without gravity.
pub(crate) fn weightless(bodies: Vec<BodyProperties>) -> RigidBodies {
    RigidBodies::new(bodies, 0.0, Box::new(RapierEngine::new())).expect("valid bodies")
}

/// Largest magnitude.
pub(crate) fn largest(errors: impl Iterator<Item = f64>) -> f64 {
    errors.map(f64::abs).fold(0.0, f64::max)
}

/// Smallest observed order of errors whose step halves from one to the next.
pub(crate) fn order_of(errors: &[f64]) -> f64 {
    errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).fold(f64::INFINITY, f64::min)
}
