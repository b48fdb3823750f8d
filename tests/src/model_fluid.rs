//! A load component with an exact solution: added mass, spring, damping and a fading memory.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use seakeep_coupler::interface::{
    BoundaryKinematics, Capabilities, Component, ComponentError, ComponentState, Description, Load,
    LoadComponent, LoadResponse, ValueReference,
};
use serde::{Deserialize, Serialize};

const NAME: &str = "model_fluid";

/// The coefficients of F = −A a − C V − K r − B q with the memory q' = V − q/τ, on one boundary,
/// with r from a pose of rest at the origin.
#[derive(Clone, Debug)]
pub struct Coefficients {
    /// A: kg/m, kg, kg m²/m.
    pub added_mass: Matrix3<f64>,
    /// C, per second.
    pub damping: Matrix3<f64>,
    /// K, per second squared.
    pub stiffness: Matrix3<f64>,
    /// B, per second squared.
    pub memory: Matrix3<f64>,
    /// τ, s.
    pub memory_time: f64,
}

impl Coefficients {
    /// Pose (m, m, rad) at `time` (s) of a body of the mass matrix `mass`, let go at a pose and a
    /// velocity without memory: the matrix exponential of the whole linear system.
    ///
    /// # Panics
    /// When M + A is singular.
    #[must_use]
    #[allow(clippy::unwrap_used, reason = "a helper of tests")]
    pub fn exact(
        &self,
        mass: &Matrix3<f64>,
        pose: &Vector3<f64>,
        velocity: &Vector3<f64>,
        time: f64,
    ) -> Vector3<f64> {
        let inverse = (mass + self.added_mass).try_inverse().unwrap();
        let mut system = DMatrix::zeros(9, 9);
        let mut set = |row, column, block: &Matrix3<f64>| {
            system.view_mut((row, column), (3, 3)).copy_from(block);
        };
        set(0, 3, &Matrix3::identity());
        set(3, 0, &(-inverse * self.stiffness));
        set(3, 3, &(-inverse * self.damping));
        set(3, 6, &(-inverse * self.memory));
        set(6, 3, &Matrix3::identity());
        set(6, 6, &(-Matrix3::identity() / self.memory_time));
        let mut state = DVector::zeros(9);
        state.rows_mut(0, 3).copy_from(pose);
        state.rows_mut(3, 3).copy_from(velocity);
        ((system * time).exp() * state).fixed_rows::<3>(0).into_owned()
    }
}

/// What changes from step to step.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct State {
    time: f64,
    memory: Vector3<f64>,
    loads: Vec<Load>,
}

/// The fluid of the [`Coefficients`], evaluated at the middle of its steps: second order.
pub struct ModelFluid {
    description: Description,
    coefficients: Coefficients,
    now: BoundaryKinematics,
    acceleration: Vector3<f64>,
    response: LoadResponse,
    state: State,
}

impl ModelFluid {
    /// A fluid that does or does not tell its added mass. It can save its state.
    #[must_use]
    pub fn new(coefficients: Coefficients, provides_directional_derivative: bool) -> Self {
        let capabilities = Capabilities {
            can_get_and_set_state: true,
            provides_directional_derivative,
            can_handle_variable_step: true,
            has_direct_feedthrough: true,
        };
        Self {
            description: Description { name: NAME.to_owned(), capabilities, variables: Vec::new() },
            coefficients,
            now: BoundaryKinematics::at_rest(nalgebra::Point2::origin(), 0.0),
            acceleration: Vector3::zeros(),
            response: LoadResponse::zero(1),
            state: State { time: 0.0, memory: Vector3::zeros(), loads: vec![Load::zero()] },
        }
    }

    fn velocity(&self) -> Vector3<f64> {
        let now = &self.now;
        Vector3::new(now.velocity.x, now.velocity.y, now.angular_velocity)
    }

    /// Memory after `duration` (s) at the velocity (m/s, m/s, rad/s) and memory of its middle.
    fn remembered(
        &self,
        duration: f64,
        velocity: Vector3<f64>,
        middle: Vector3<f64>,
    ) -> Vector3<f64> {
        self.state.memory + (velocity - middle / self.coefficients.memory_time) * duration
    }

    fn at(&self, point: f64) -> Result<(), ComponentError> {
        if (point - self.state.time).abs() < 1e-9 {
            return Ok(());
        }
        let (component, actual) = (NAME.to_owned(), self.state.time);
        Err(ComponentError::CommunicationPoint { component, asked: point, actual })
    }

    fn solve(&mut self, h: f64) {
        let Coefficients { added_mass, damping, stiffness, memory, .. } = &self.coefficients;
        let middle = self.now.drifted(0.5 * h);
        let pose = Vector3::new(middle.position.x, middle.position.y, middle.angle);
        let velocity = self.velocity();
        let remembered = self.remembered(0.5 * h, velocity, self.state.memory);
        let load = -stiffness * pose - damping * velocity - memory * remembered;
        let zero = &mut self.response.at_zero_acceleration[0];
        zero.force = load.xy();
        zero.torque = load.z;
        // The velocity at the middle depends on the acceleration too.
        self.response.added_mass.copy_from(&(added_mass + damping * (0.5 * h)));
    }
}

impl Component for ModelFluid {
    fn description(&self) -> &Description {
        &self.description
    }
    fn enter_initialization_mode(&mut self, start_time: f64) -> Result<(), ComponentError> {
        self.state.time = start_time;
        Ok(())
    }
    fn exit_initialization_mode(&mut self) -> Result<(), ComponentError> {
        Ok(())
    }
    fn do_step(&mut self, now: f64, h: f64) -> Result<(), ComponentError> {
        self.at(now)?;
        self.solve(h);
        self.response.at(self.acceleration.as_slice(), &mut self.state.loads);
        let middle = self.remembered(0.5 * h, self.velocity(), self.state.memory);
        let velocity = self.velocity() + self.acceleration * (0.5 * h);
        self.state.memory = self.remembered(h, velocity, middle);
        self.state.time = now + h;
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
        ComponentState::save(NAME, &self.state)
    }
    fn set_state(&mut self, state: &ComponentState) -> Result<(), ComponentError> {
        self.state = state.load(NAME)?;
        Ok(())
    }
}

impl LoadComponent for ModelFluid {
    fn boundary_count(&self) -> usize {
        1
    }
    fn set_kinematics(&mut self, kinematics: &[BoundaryKinematics]) {
        self.now = kinematics[0];
    }
    fn solve_load(&mut self, now: f64, h: f64) -> Result<&LoadResponse, ComponentError> {
        if !self.description.capabilities.provides_directional_derivative {
            let (component, call) = (NAME.to_owned(), "solve_load");
            return Err(ComponentError::CallSequence {
                component,
                call,
                state: "without derivative",
            });
        }
        self.at(now)?;
        self.solve(h);
        Ok(&self.response)
    }
    fn set_accelerations(&mut self, accelerations: &[f64]) {
        self.acceleration.copy_from_slice(accelerations);
    }
    fn loads(&self) -> &[Load] {
        &self.state.loads
    }
}
