//! The fluid as a co-simulation component.

use crate::error::FluidError;
use crate::fluid::{Fluid, State};
use nalgebra::DMatrix;
use seakeep_coupler::interface::{
    BoundaryKinematics, Capabilities, Causality, Component, ComponentError, ComponentState,
    Description, Load, LoadComponent, LoadResponse, ValueReference, Variability, Variable,
};

/// Name of the component.
const NAME: &str = "fluid";

/// Variables of one boundary: suffix, causality, unit, description. Value references run through
/// the boundaries in this order.
const VARIABLES: [(&str, Causality, &str, &str); 12] = [
    ("position_x", Causality::Input, "m", "position of the reference point along the tank"),
    ("position_y", Causality::Input, "m", "height of the reference point above the bed"),
    ("angle", Causality::Input, "rad", "angle, counter-clockwise"),
    ("velocity_x", Causality::Input, "m/s", "velocity of the reference point along the tank"),
    ("velocity_y", Causality::Input, "m/s", "upward velocity of the reference point"),
    ("angular_velocity", Causality::Input, "rad/s", "angular velocity, counter-clockwise"),
    ("acceleration_x", Causality::Input, "m/s2", "mean acceleration over the coming step"),
    ("acceleration_y", Causality::Input, "m/s2", "mean upward acceleration over the coming step"),
    ("angular_acceleration", Causality::Input, "rad/s2", "mean over the coming step"),
    ("force_x", Causality::Output, "N/m", "hydrodynamic force along the tank, Eq. (19)"),
    ("force_y", Causality::Output, "N/m", "upward hydrodynamic force, Eq. (19)"),
    ("torque", Causality::Output, "N", "hydrodynamic torque about the reference point, Eq. (20)"),
];

/// The description of a fluid with boundaries of these names.
pub(crate) fn describe<'a>(boundaries: impl Iterator<Item = &'a str>) -> Description {
    let variables = boundaries
        .flat_map(|boundary| {
            VARIABLES.iter().map(move |(name, causality, unit, description)| Variable {
                name: format!("{boundary}.{name}"),
                reference: ValueReference(0),
                causality: *causality,
                variability: Variability::Continuous,
                unit: (*unit).to_owned(),
                description: (*description).to_owned(),
            })
        })
        .enumerate()
        .map(|(reference, variable)| Variable {
            reference: ValueReference(reference as u32),
            ..variable
        })
        .collect();
    Description {
        name: NAME.to_owned(),
        capabilities: Capabilities {
            can_get_and_set_state: true,
            provides_directional_derivative: true,
            can_handle_variable_step: true,
            has_direct_feedthrough: true,
        },
        variables,
    }
}

impl Fluid {
    fn require(&self, condition: bool, call: &'static str) -> Result<(), ComponentError> {
        if condition {
            return Ok(());
        }
        Err(ComponentError::CallSequence {
            component: NAME.to_owned(),
            call,
            state: self.phase.words(),
        })
    }

    fn at(&self, point: f64) -> Result<(), ComponentError> {
        if (point - self.state.time).abs() <= 1e-9 * self.state.time.abs().max(1.0) {
            return Ok(());
        }
        Err(ComponentError::CommunicationPoint {
            component: NAME.to_owned(),
            asked: point,
            actual: self.state.time,
        })
    }

    fn step_error(&self, error: FluidError) -> ComponentError {
        ComponentError::Step {
            component: NAME.to_owned(),
            time: self.state.time,
            step: self.state.step + 1,
            source: Box::new(error),
        }
    }

    fn ensure_solved(&mut self, h: f64) -> Result<(), ComponentError> {
        if self.solved_for == Some(h) {
            return Ok(());
        }
        self.solve(h).map_err(|error| self.step_error(error))
    }

    fn boundary_of(&self, variable: ValueReference) -> Result<(usize, usize), ComponentError> {
        let reference = variable.0 as usize;
        let (boundary, which) = (reference / VARIABLES.len(), reference % VARIABLES.len());
        if boundary < self.setup.boundaries.len() {
            return Ok((boundary, which));
        }
        Err(ComponentError::UnknownVariable { component: NAME.to_owned(), reference: variable })
    }

    fn input(&mut self, boundary: usize, which: usize) -> Option<&mut f64> {
        let k = &mut self.state.kinematics[boundary];
        Some(match which {
            0 => &mut k.position.x,
            1 => &mut k.position.y,
            2 => &mut k.angle,
            3 => &mut k.velocity.x,
            4 => &mut k.velocity.y,
            5 => &mut k.angular_velocity,
            6..=8 => &mut self.state.accelerations[3 * boundary + which - 6],
            _ => return None,
        })
    }

    /// The added-mass matrix of the last [`LoadComponent::solve_load`]: kg/m, kg, kg m²/m.
    #[must_use]
    pub fn added_mass(&self) -> &DMatrix<f64> {
        &self.response.added_mass
    }
}

/// Where a component stands in its life cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    Instantiated,
    Initializing,
    Stepping,
    Terminated,
}

impl Phase {
    fn words(self) -> &'static str {
        match self {
            Self::Instantiated => "before initialization",
            Self::Initializing => "during initialization",
            Self::Stepping => "between initialization and termination",
            Self::Terminated => "after termination",
        }
    }
}

impl Component for Fluid {
    fn description(&self) -> &Description {
        &self.description
    }

    fn enter_initialization_mode(&mut self, start_time: f64) -> Result<(), ComponentError> {
        self.require(self.phase == Phase::Instantiated, "enter_initialization_mode")?;
        self.state.start_time = start_time;
        self.state.time = start_time;
        self.phase = Phase::Initializing;
        Ok(())
    }

    fn exit_initialization_mode(&mut self) -> Result<(), ComponentError> {
        self.require(self.phase == Phase::Initializing, "exit_initialization_mode")?;
        self.phase = Phase::Stepping;
        Ok(())
    }

    fn do_step(
        &mut self,
        current_communication_point: f64,
        communication_step_size: f64,
    ) -> Result<(), ComponentError> {
        self.require(self.phase == Phase::Stepping, "do_step")?;
        self.at(current_communication_point)?;
        self.ensure_solved(communication_step_size)?;
        self.finish(communication_step_size).map_err(|error| self.step_error(error))?;
        self.state.time = current_communication_point + communication_step_size;
        Ok(())
    }

    fn terminate(&mut self) {
        self.phase = Phase::Terminated;
    }

    fn get_float64(&self, variable: ValueReference) -> Result<f64, ComponentError> {
        let (boundary, which) = self.boundary_of(variable)?;
        let k = &self.state.kinematics[boundary];
        let load = &self.state.loads[boundary];
        Ok(match which {
            0 => k.position.x,
            1 => k.position.y,
            2 => k.angle,
            3 => k.velocity.x,
            4 => k.velocity.y,
            5 => k.angular_velocity,
            9 => load.force.x,
            10 => load.force.y,
            11 => load.torque,
            acceleration => self.state.accelerations[3 * boundary + acceleration - 6],
        })
    }

    fn set_float64(&mut self, variable: ValueReference, value: f64) -> Result<(), ComponentError> {
        let (boundary, which) = self.boundary_of(variable)?;
        let name = || self.description.variables[variable.0 as usize].name.clone();
        if !value.is_finite() {
            return Err(ComponentError::NotFinite {
                component: NAME.to_owned(),
                variable: name(),
                value,
            });
        }
        let not_an_input =
            ComponentError::NotAnInput { component: NAME.to_owned(), variable: name() };
        *self.input(boundary, which).ok_or(not_an_input)? = value;
        // An acceleration of a free boundary enters when the step is completed; all else is
        // part of what has been solved.
        if which < 6 || !self.setup.boundaries[boundary].free {
            self.solved_for = None;
        }
        Ok(())
    }

    fn get_state(&self) -> Result<ComponentState, ComponentError> {
        ComponentState::save(NAME, &self.state)
    }

    fn set_state(&mut self, state: &ComponentState) -> Result<(), ComponentError> {
        let state: State = state.load(NAME)?;
        if state.particles.len() != self.state.particles.len()
            || state.kinematics.len() != self.state.kinematics.len()
        {
            return Err(ComponentError::State {
                component: NAME.to_owned(),
                reason: format!(
                    "it holds {} particles and {} boundaries, this fluid {} and {}",
                    state.particles.len(),
                    state.kinematics.len(),
                    self.state.particles.len(),
                    self.state.kinematics.len(),
                ),
            });
        }
        self.state = state;
        self.solved_for = None;
        Ok(())
    }
}

impl LoadComponent for Fluid {
    fn boundary_count(&self) -> usize {
        self.setup.boundaries.len()
    }

    fn set_kinematics(&mut self, kinematics: &[BoundaryKinematics]) {
        self.state.kinematics.copy_from_slice(kinematics);
        self.solved_for = None;
    }

    fn solve_load(
        &mut self,
        current_communication_point: f64,
        communication_step_size: f64,
    ) -> Result<&LoadResponse, ComponentError> {
        self.require(self.phase == Phase::Stepping, "solve_load")?;
        self.at(current_communication_point)?;
        self.ensure_solved(communication_step_size)?;
        Ok(&self.response)
    }

    fn set_accelerations(&mut self, accelerations: &[f64]) {
        self.state.accelerations.copy_from_slice(accelerations);
    }

    fn loads(&self) -> &[Load] {
        &self.state.loads
    }
}
