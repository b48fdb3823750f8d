//! The fluid as a co-simulation component.

use crate::error::FluidError;
use crate::fluid::Fluid;
use crate::state::{Phase, State};
use crate::variables::{NAME, VARIABLES};
use nalgebra::DMatrix;
use seakeep_coupler::interface::{
    BoundaryKinematics, Component, ComponentError, ComponentState, Description, Load,
    LoadComponent, LoadResponse, ValueReference,
};

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
        if state.wall_activity.len() != self.state.wall_activity.len()
            || state.kinematics.len() != self.state.kinematics.len()
        {
            return Err(ComponentError::State {
                component: NAME.to_owned(),
                reason: format!(
                    "it holds {} wall particles and {} boundaries, this fluid {} and {}",
                    state.wall_activity.len(),
                    state.kinematics.len(),
                    self.state.wall_activity.len(),
                    self.state.kinematics.len(),
                ),
            });
        }
        self.state = state;
        self.work.resize(self.state.particles.len());
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
