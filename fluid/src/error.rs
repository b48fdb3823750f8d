//! What can go wrong in the fluid.

use thiserror::Error;

/// An error of the fluid.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum FluidError {
    /// A parameter out of its range.
    #[error("{parameter} = {value} is out of range: {allowed}")]
    Parameter {
        /// Name of the parameter.
        parameter: &'static str,
        /// Its value, in SI units.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// A polygon that does not enclose an area, or crosses itself.
    #[error("boundary {boundary}: {reason}")]
    Boundary {
        /// Name of the boundary.
        boundary: String,
        /// What is wrong.
        reason: String,
    },
    /// The spacing leaves no room for particles.
    #[error("no fluid particle fits in the tank at a spacing of {spacing} m")]
    NoParticles {
        /// Particle spacing, m.
        spacing: f64,
    },
    /// The pressure solve stopped short of its tolerance.
    #[error(
        "pressure solve did not converge: residual {residual:.3e} after {iterations} iterations \
         (tolerance {tolerance:.1e})"
    )]
    PressureNotConverged {
        /// Relative residual reached.
        residual: f64,
        /// Iterations done.
        iterations: usize,
        /// Relative residual asked for.
        tolerance: f64,
    },
    /// A network's pressure is not finite.
    #[error("the network's pressure is not finite (residual {residual:.3e})")]
    NetworkPressure {
        /// Relative residual.
        residual: f64,
    },
    /// A network's inference elsewhere failed.
    #[error("the network cannot be evaluated: {reason}")]
    Inference {
        /// What failed.
        reason: String,
    },
    /// A particle has a position or velocity that is not finite, or too many have left the tank or are
    /// faster than any water in it could be.
    #[error(
        "particle {particle} at ({x:.4}, {y:.4}) m moves at ({u:.3e}, {v:.3e}) m/s: the run has \
         become unstable"
    )]
    Unstable {
        /// Identity of the particle.
        particle: u32,
        /// Position, m.
        x: f64,
        /// Position, m.
        y: f64,
        /// Velocity, m/s.
        u: f64,
        /// Velocity, m/s.
        v: f64,
    },
    /// A boundary was given kinematics that are not finite.
    #[error("boundary {boundary}: its kinematics are not finite")]
    Kinematics {
        /// Name of the boundary.
        boundary: String,
    },
}
