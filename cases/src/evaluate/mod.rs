//! How good a network is, beside other ways to find the pressure: on single steps of cases it has
//! not learnt from, by wavelength, and over whole runs.

#[cfg(feature = "torch")]
mod device;
mod rollout;
mod single;
mod write;

#[cfg(feature = "torch")]
pub use device::{DeviceError, DeviceRow, on_device};
pub use rollout::{RolloutRow, rollout};
pub use single::{FactorRow, SkillRow, single_steps};
pub use write::{write_factors, write_rollouts, write_skills};

use crate::case::CaseError;
use crate::output::OutputError;
use crate::simulation::SimulationError;
use seakeep_fluid::setup::{PressureSettings, SolverKind, Start};
use thiserror::Error;

/// Why there is no evaluation.
#[derive(Debug, Error)]
pub enum EvaluateError {
    /// A case is refused.
    #[error(transparent)]
    Case(#[from] CaseError),
    /// A case cannot start, or the reference fails.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The threads cannot be started.
    #[error("the threads cannot be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The campaign has no test case.
    #[error("the campaign has no case for tests")]
    NoTest,
    /// A file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// What is compared, by name: the network, no correction at all, sweeps, a few iterations, and the
/// pressure equation solved as runs do by default, but to `tolerance`.
#[must_use]
pub fn solvers(tolerance: f64) -> Vec<(&'static str, PressureSettings)> {
    let own = PressureSettings { tolerance, ..PressureSettings::default() };
    let capped = PressureSettings {
        solver: SolverKind::Capped,
        start: Start::Given,
        tolerance: 1e-12,
        divergence_tolerance: 0.0,
        max_iterations: 0,
        ..own
    };
    let iterations = |count| PressureSettings { max_iterations: count, ..capped };
    vec![
        ("network", PressureSettings { solver: SolverKind::Network, ..own }),
        ("persistence", capped),
        ("2 Jacobi", PressureSettings { sweeps: 2, ..capped }),
        ("1 iteration", iterations(1)),
        ("3 iterations", iterations(3)),
        ("5 iterations", iterations(5)),
        ("PPE", own),
    ]
}
