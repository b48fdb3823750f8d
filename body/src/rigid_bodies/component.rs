//! The rigid bodies as a co-simulation component.

use super::{Motion, NAME, Phase, RigidBodies};
use crate::variables;
use seakeep_coupler::interface::{
    BoundaryKinematics, Component, ComponentError, ComponentState, Description, Load, LoadResponse,
    MotionComponent, ValueReference,
};
use serde::{Deserialize, Serialize};

/// The component's whole state.
#[derive(Serialize, Deserialize)]
struct State {
    motion: Motion,
    engine: Vec<u8>,
    /// Of each prescribed motion.
    prescribed: Vec<Vec<u8>>,
}

fn state_error(reason: String) -> ComponentError {
    ComponentError::State { component: NAME.to_owned(), reason }
}

impl RigidBodies {
    fn require(&self, phase: Phase, call: &'static str) -> Result<(), ComponentError> {
        if self.phase == phase {
            return Ok(());
        }
        let state = self.phase.in_words();
        Err(ComponentError::CallSequence { component: NAME.to_owned(), call, state })
    }

    /// Number of the body and the variable's place in it.
    fn locate(&self, reference: ValueReference) -> Result<(usize, usize), ComponentError> {
        let (body, place) = variables::locate(reference);
        if body < self.bodies.len() {
            return Ok((body, place));
        }
        Err(ComponentError::UnknownVariable { component: NAME.to_owned(), reference })
    }
}

impl Component for RigidBodies {
    fn description(&self) -> &Description {
        &self.description
    }

    fn enter_initialization_mode(&mut self, start_time: f64) -> Result<(), ComponentError> {
        self.require(Phase::Instantiated, "enter_initialization_mode")?;
        if !start_time.is_finite() {
            return Err(ComponentError::NotFinite {
                component: NAME.to_owned(),
                variable: "start time".to_owned(),
                value: start_time,
            });
        }
        self.motion.time = start_time;
        self.take_up_prescriptions().map_err(|error| ComponentError::Initialization {
            component: NAME.to_owned(),
            source: error.into(),
        })?;
        self.phase = Phase::Initialization;
        Ok(())
    }

    fn exit_initialization_mode(&mut self) -> Result<(), ComponentError> {
        self.require(Phase::Initialization, "exit_initialization_mode")?;
        self.phase = Phase::Stepping;
        Ok(())
    }

    fn do_step(
        &mut self,
        current_communication_point: f64,
        communication_step_size: f64,
    ) -> Result<(), ComponentError> {
        self.require(Phase::Stepping, "do_step")?;
        let (asked, actual) = (current_communication_point, self.motion.time);
        // The master's sum of steps and this one's may differ in the last bits.
        let tolerance = 1e-6 * communication_step_size.abs() + 1e-12 * actual.abs();
        if asked.is_nan() || (asked - actual).abs() > tolerance {
            let component = NAME.to_owned();
            return Err(ComponentError::CommunicationPoint { component, asked, actual });
        }
        let step = self.motion.steps + 1;
        self.step(asked, communication_step_size).map_err(|error| ComponentError::Step {
            component: NAME.to_owned(),
            time: asked,
            step,
            source: error.into(),
        })
    }

    fn terminate(&mut self) {
        self.phase = Phase::Terminated;
    }

    fn get_float64(&self, variable: ValueReference) -> Result<f64, ComponentError> {
        let (body, place) = self.locate(variable)?;
        let mut load =
            self.motion.response.at_zero_acceleration.get(body).copied().unwrap_or(Load::zero());
        Ok(match variables::input(&mut load, place) {
            Some(value) => *value,
            None => variables::output(&self.bodies[body], &self.motion.kinematics[body], place),
        })
    }

    fn set_float64(&mut self, variable: ValueReference, value: f64) -> Result<(), ComponentError> {
        let (body, place) = self.locate(variable)?;
        let name = || self.description.variables[variable.0 as usize].name.clone();
        let component = NAME.to_owned();
        if !value.is_finite() {
            return Err(ComponentError::NotFinite { component, variable: name(), value });
        }
        let loads = &mut self.motion.response.at_zero_acceleration;
        // A load set with the wrong number of bodies is reported by the step that uses it.
        loads.resize(self.bodies.len().max(loads.len()), Load::zero());
        match variables::input(&mut loads[body], place) {
            Some(input) => *input = value,
            None => return Err(ComponentError::NotAnInput { component, variable: name() }),
        }
        Ok(())
    }

    fn get_state(&self) -> Result<ComponentState, ComponentError> {
        let engine = self.engine.save().map_err(|error| state_error(error.to_string()))?;
        let prescribed = self.prescriptions.iter().map(|known| known.motion.save());
        let prescribed =
            prescribed.collect::<Result<_, _>>().map_err(|error| state_error(error.to_string()))?;
        ComponentState::save(NAME, &State { motion: self.motion.clone(), engine, prescribed })
    }

    fn set_state(&mut self, state: &ComponentState) -> Result<(), ComponentError> {
        let State { motion, engine, prescribed } = state.load(NAME)?;
        let bodies = self.bodies.len();
        if motion.kinematics.len() != bodies || motion.mean_accelerations.len() != 3 * bodies {
            return Err(state_error(format!(
                "{} bodies, where {bodies} are expected",
                motion.kinematics.len()
            )));
        }
        if prescribed.len() != self.prescriptions.len() {
            return Err(state_error(format!(
                "{} prescribed motions, where {} are expected",
                prescribed.len(),
                self.prescriptions.len()
            )));
        }
        for (known, state) in self.prescriptions.iter_mut().zip(&prescribed) {
            known.motion.restore(state).map_err(|error| state_error(error.to_string()))?;
        }
        self.engine.restore(&engine).map_err(|error| state_error(error.to_string()))?;
        self.motion = motion;
        Ok(())
    }
}

impl MotionComponent for RigidBodies {
    fn body_count(&self) -> usize {
        self.bodies.len()
    }

    fn kinematics(&self) -> &[BoundaryKinematics] {
        &self.motion.kinematics
    }

    fn set_load(&mut self, response: &LoadResponse) {
        self.motion.response.clone_from(response);
    }

    fn mean_accelerations(&self) -> &[f64] {
        &self.motion.mean_accelerations
    }
}
