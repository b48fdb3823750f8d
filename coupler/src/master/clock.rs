//! Where a master stands in time, and the errors that say so.

use crate::CouplerError;
use crate::interface::{Component, ComponentError};

/// Time as a number of communication steps, which no sum of steps can make drift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Clock {
    /// Start time, s.
    pub(super) start_time: f64,
    /// Communication step, s.
    pub(super) communication_step: f64,
    /// Steps done.
    pub(super) step: u64,
}

impl Clock {
    /// A clock at the start.
    pub(super) fn start(start_time: f64, communication_step: f64) -> Result<Self, CouplerError> {
        if start_time.is_finite() && communication_step.is_finite() && communication_step > 0.0 {
            return Ok(Self { start_time, communication_step, step: 0 });
        }
        Err(CouplerError::Time { start_time, communication_step })
    }

    /// Time reached, s.
    pub(super) fn time(self) -> f64 {
        self.start_time + self.step as f64 * self.communication_step
    }

    /// Time at the part `part` of the coming step, s.
    pub(super) fn at(self, part: f64) -> f64 {
        self.time() + part * self.communication_step
    }

    /// The error of a component in the coming step.
    pub(super) fn failed(self, source: ComponentError) -> CouplerError {
        CouplerError::Component { time: self.time(), step: self.step + 1, source }
    }

    /// Refuses a number of values that does not fit the boundaries.
    pub(super) fn check(
        self,
        component: &dyn Component,
        quantity: &'static str,
        actual: usize,
        expected: usize,
    ) -> Result<(), CouplerError> {
        if actual == expected {
            return Ok(());
        }
        let component = component.description().name.clone();
        let (time, step) = (self.time(), self.step + 1);
        Err(CouplerError::Length { component, quantity, actual, expected, time, step })
    }
}
