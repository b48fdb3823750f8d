//! The pressure Poisson equation, Eq. (9b), solved by BiCGSTAB.

use crate::error::FluidError;
use crate::krylov::{Krylov, Report, Stop};
use crate::pressure::solver::{
    PressureReport, PressureSettings, PressureSolver, Problem, SolverKind,
};
use crate::sparse::Entry;
use std::time::Instant;

/// Solves the pressure Poisson equation.
#[derive(Default)]
pub(crate) struct Poisson {
    settings: PressureSettings,
    krylov: Krylov<1>,
    product: Vec<[f64; 1]>,
    sums: Vec<[Entry<1>; 2]>,
}

impl Poisson {
    pub(crate) fn new(settings: PressureSettings) -> Self {
        Self { settings, ..Self::default() }
    }
}

impl Poisson {
    /// The sweeps after capped iterations.
    fn sweeps(
        &mut self,
        problem: &mut Problem<'_>,
        report: Report,
        begun: Instant,
    ) -> PressureReport {
        let (mut r, mut sums) = (std::mem::take(&mut self.product), std::mem::take(&mut self.sums));
        for _ in 0..self.settings.sweeps {
            problem.residual(&mut r, &mut sums);
            problem.sweep(&r);
        }
        let time = begun.elapsed();
        let (left, size) = problem.residual(&mut r, &mut sums);
        (self.product, self.sums) = (r, sums);
        let rms = (left / problem.rhs.len().max(1) as f64).sqrt();
        PressureReport {
            iterations: report.iterations,
            residual_before: report.residual_before,
            residual: if size > 0.0 { (left / size).sqrt() } else { 0.0 },
            divergence_left: rms * problem.divergence_per_residual,
            fell_back: false,
            time,
        }
    }
}

impl PressureSolver for Poisson {
    fn solve(&mut self, mut problem: Problem<'_>) -> Result<PressureReport, FluidError> {
        let begun = Instant::now();
        problem.start(self.settings.start);
        let (stop, rows) = (problem.stop, 0..problem.rhs.len());
        let kind = self.settings.preconditioner;
        let system = problem.memory.system(kind, problem.matrix, rows, problem.step);
        let report = self.krylov.solve(system, problem.rhs, problem.pressure, stop);
        if self.settings.solver == SolverKind::Capped {
            return Ok(self.sweeps(&mut problem, report, begun));
        }
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
