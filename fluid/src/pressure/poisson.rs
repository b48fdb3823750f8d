//! The pressure Poisson equation, Eq. (9b), solved by BiCGSTAB.

use crate::error::FluidError;
use crate::krylov::{Krylov, Report, Stop};
use crate::pressure::solver::{
    PreconditionerKind, PressureReport, PressureSettings, PressureSolver, Problem, Start,
};
use crate::sparse::Preconditioner;
use std::time::Instant;

/// Solves the pressure Poisson equation.
#[derive(Default)]
pub(crate) struct Poisson {
    settings: PressureSettings,
    krylov: Krylov<1>,
    diagonal: Preconditioner,
}

impl Poisson {
    pub(crate) fn new(settings: PressureSettings) -> Self {
        Self { settings, ..Self::default() }
    }
}

impl PressureSolver for Poisson {
    fn solve(&mut self, problem: Problem<'_>) -> Result<PressureReport, FluidError> {
        let begun = Instant::now();
        match self.settings.start {
            Start::Given => {}
            Start::Cold => problem.pressure.fill([0.0]),
            Start::Warm => {
                let carried = problem.change.iter().zip(problem.fields.on_surface);
                for (p, (change, surface)) in problem.pressure.iter_mut().zip(carried) {
                    if !surface {
                        p[0] += change;
                    }
                }
            }
        }
        let preconditioner = match self.settings.preconditioner {
            PreconditionerKind::Milu => problem.memory.preconditioner(problem.matrix, problem.step),
            PreconditionerKind::Diagonal => &mut self.diagonal,
        };
        let (matrix, stop) = (problem.matrix, problem.stop);
        let report = self.krylov.solve(matrix, preconditioner, problem.rhs, problem.pressure, stop);
        require_convergence(report, stop)?;
        Ok(PressureReport {
            iterations: report.iterations,
            residual_before: report.residual_before,
            residual: report.residual,
            divergence_left: report.residual_rms * problem.divergence_per_residual,
            fell_back: false,
            time: begun.elapsed(),
        })
    }
}

/// # Errors
/// [`FluidError::PressureNotConverged`] if it did not.
pub(crate) fn require_convergence(report: Report, stop: Stop) -> Result<(), FluidError> {
    if report.converged {
        return Ok(());
    }
    Err(FluidError::PressureNotConverged {
        residual: report.residual,
        iterations: report.iterations,
        tolerance: stop.relative,
    })
}
