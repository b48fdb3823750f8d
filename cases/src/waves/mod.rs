//! Waves in theory, and the paddles that make them.
//!
//! Frame: x along the waves from the paddle's position at rest, y up from the bed, t from the
//! start of the run; elevation above still water. Regular waves have a crest at x = 0, t = 0.
//! Everything is two-dimensional, inviscid and irrotational over a level bed.

pub mod dispersion;
pub mod focused;
pub mod irregular;
pub mod linear;
pub mod paddle;
pub mod plan;
mod quadrature;
pub mod solitary;
mod solitary_exact;
pub mod spectrum;
pub mod spline;
pub mod stokes;
pub mod stream_function;
#[cfg(test)]
mod tests;

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};
use std::fmt;
use thiserror::Error;

/// A wave field as a theory has it.
pub trait WaveTheory: fmt::Debug + Send + Sync {
    /// Elevation above still water at `x` (m) and `time` (s), m.
    fn elevation(&self, x: f64, time: f64) -> f64;

    /// Velocity at `x`, `y` (m, y up from the bed) and `time` (s), m/s. Between still water and a
    /// crest it is what each theory says of that place; higher up it means nothing.
    fn velocity(&self, x: f64, y: f64, time: f64) -> Vector2<f64>;

    /// Speed of a wave of constant form, m/s; none where the form changes.
    fn celerity(&self) -> Option<f64> {
        None
    }

    /// Distance between crests, m; none where there is no period.
    fn wavelength(&self) -> Option<f64> {
        None
    }
}

/// Water of constant depth at rest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StillWater {
    /// Depth D, m.
    pub depth: f64,
    /// Gravitational acceleration g, m/s².
    pub gravity: f64,
}

/// Why a theory or a paddle motion cannot be had.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum WaveError {
    /// A parameter outside its range.
    #[error("{parameter} = {value} must be {allowed}")]
    Parameter {
        /// What it is, with its unit.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// What it may be.
        allowed: String,
    },
    /// The wave is higher than any wave of permanent form.
    #[error(
        "a wave {height} m high breaks: at most {limit:.4} m, {what}",
        what = match length {
            Some(length) => format!("with a wavelength of {length:.4} m in water {depth} m deep"),
            None => format!("for a solitary wave in water {depth} m deep"),
        }
    )]
    Breaking {
        /// Height, m.
        height: f64,
        /// The highest wave, m.
        limit: f64,
        /// Wavelength, m; none for a solitary wave.
        length: Option<f64>,
        /// Water depth, m.
        depth: f64,
    },
    /// The equations of a theory could not be solved.
    #[error(
        "{theory}: no solution beyond a height of {height:.6} m \
         (residual {residual:.1e} after {iterations} iterations)"
    )]
    NoConvergence {
        /// The theory.
        theory: &'static str,
        /// The greatest height reached, m.
        height: f64,
        /// Residual of the failed step, without dimension.
        residual: f64,
        /// Its iterations.
        iterations: usize,
    },
}

/// Refuses `value` unless `holds`.
pub(crate) fn require(
    holds: bool,
    parameter: &'static str,
    value: f64,
    allowed: &str,
) -> Result<(), WaveError> {
    if holds && value.is_finite() {
        Ok(())
    } else {
        Err(WaveError::Parameter { parameter, value, allowed: allowed.to_owned() })
    }
}

/// Refuses `value` unless it is above 0 and finite.
pub(crate) fn require_positive(parameter: &'static str, value: f64) -> Result<(), WaveError> {
    require(value > 0.0, parameter, value, "a finite number above 0")
}

impl StillWater {
    /// Refuses a depth or gravity that is not positive.
    pub(crate) fn validate(&self) -> Result<(), WaveError> {
        require_positive("water depth (m)", self.depth)?;
        require_positive("gravity (m/s²)", self.gravity)
    }

    /// Speed of long waves, √(g D), m/s.
    #[must_use]
    pub fn long_wave_speed(&self) -> f64 {
        (self.gravity * self.depth).sqrt()
    }
}
