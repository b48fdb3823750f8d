//! The pressure by a network, alone or guarded.
//!
//! Guarded: after the network, optional damped Jacobi sweeps; then the residual is checked, and a
//! step whose residual is above the guard's goes on with the pressure Poisson equation from there.

use crate::error::FluidError;
use crate::neighbours::BLOCK;
use crate::network::lattice::Cells;
use crate::network::residual::Residual;
use crate::network::{Network, Weights};
use crate::pressure::poisson::Poisson;
use crate::pressure::solver::{PressureReport, PressureSettings, PressureSolver, Problem, Start};
use crate::sparse::Entry;
use rayon::prelude::*;
use std::time::Instant;

/// Part of a residual that a damped Jacobi sweep takes.
const DAMPING: f64 = 0.6;

/// Finds the pressure by a network.
pub(crate) struct NetworkSolver {
    weights: Weights,
    settings: PressureSettings,
    guarded: bool,
    cells: Cells,
    residual: Residual,
    single: Vec<f32>,
    product: Vec<[f64; 1]>,
    sums: Vec<[Entry<1>; 2]>,
    poisson: Poisson,
}

impl NetworkSolver {
    pub(crate) fn new(network: Network, settings: PressureSettings, guarded: bool) -> Self {
        Self {
            weights: network.0,
            settings,
            guarded,
            cells: Cells::default(),
            residual: Residual::default(),
            single: Vec::new(),
            product: Vec::new(),
            sums: Vec::new(),
            poisson: Poisson::new(PressureSettings { start: Start::Given, ..settings }),
        }
    }

    /// r = b − A p into `product`; its square and that of b.
    fn residual(&mut self, problem: &Problem<'_>) -> (f64, f64) {
        self.product.resize(problem.rhs.len(), [0.0]);
        let rhs = problem.rhs;
        let [[r2], [b2]] = problem.matrix.multiply(
            problem.pressure,
            &mut self.product,
            &mut self.sums,
            |i, r, [r2, b2]| {
                r[0] = rhs[i][0] - r[0];
                r2[0] += r[0] * r[0];
                b2[0] += rhs[i][0] * rhs[i][0];
            },
        );
        (r2, b2)
    }

    /// p ← p + ω r.
    fn sweep(&mut self, problem: &mut Problem<'_>) {
        for (p, r) in problem.pressure.iter_mut().zip(&self.product) {
            p[0] += DAMPING * r[0];
        }
    }

    fn correct(&mut self, problem: &mut Problem<'_>) {
        let fields = problem.fields;
        let known = fields.on_surface;
        let coarse = problem.memory.coarse(
            &mut self.cells,
            fields.position,
            fields.spacing,
            problem.matrix,
            known,
            problem.step,
        );
        self.single.resize(self.product.len(), 0.0);
        for (single, r) in self.single.iter_mut().zip(&self.product) {
            *single = r[0] as f32;
        }
        let Weights::Residual(weights) = &self.weights;
        let correction = self.residual.correction(
            weights,
            problem.matrix,
            (&mut self.cells, coarse),
            |i| fields.wall_lists.of(i).len(),
            known,
            &self.single,
        );
        problem
            .pressure
            .par_chunks_mut(BLOCK)
            .zip(correction.par_chunks(BLOCK))
            .with_min_len(8)
            .for_each(|(p, change)| {
                for (p, change) in p.iter_mut().zip(change) {
                    p[0] += f64::from(*change);
                }
            });
    }
}

impl PressureSolver for NetworkSolver {
    fn solve(&mut self, mut problem: Problem<'_>) -> Result<PressureReport, FluidError> {
        let begun = Instant::now();
        let (before, size) = self.residual(&problem);
        self.correct(&mut problem);
        let (mut after, _) = self.residual(&problem);
        for _ in 0..self.settings.sweeps {
            self.sweep(&mut problem);
            (after, _) = self.residual(&problem);
        }
        let n = problem.rhs.len() as f64;
        let relative = |square: f64| if square > 0.0 { (square / size).sqrt() } else { 0.0 };
        let report = PressureReport {
            iterations: 0,
            residual_before: relative(before),
            residual: relative(after),
            divergence_left: (after / n).sqrt() * problem.divergence_per_residual,
            fell_back: false,
            time: begun.elapsed(),
        };
        let settled = (after / n).sqrt() <= problem.stop.absolute;
        let good = report.residual <= self.settings.guard_tolerance || settled;
        if !self.guarded {
            if after.is_finite() {
                return Ok(report);
            }
            return Err(FluidError::NetworkPressure { residual: report.residual });
        }
        if good {
            return Ok(report);
        }
        if !after.is_finite() {
            problem.pressure.fill([0.0]);
        }
        let finished = self.poisson.solve(problem)?;
        Ok(PressureReport {
            residual_before: report.residual_before,
            fell_back: true,
            time: begun.elapsed(),
            ..finished
        })
    }
}
