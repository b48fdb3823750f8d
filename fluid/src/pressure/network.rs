//! The pressure by a network, alone or guarded.
//!
//! Guarded: after the network, optional damped Jacobi sweeps; then the divergence that is left is
//! checked, and a step that leaves more than the guard allows goes on with the pressure Poisson
//! equation from there.

use crate::error::FluidError;
use crate::fields::Fields;
use crate::frame::{Assembled, Frame};
use crate::network::paper::{self, Paper, PaperWeights};
use crate::network::residual::{Level, Residual, ResidualWeights, Squares};
use crate::network::{Inference, Network, ResidualStep, Weights};
use crate::pressure::poisson::Poisson;
use crate::pressure::solver::{
    PressureMemory, PressureReport, PressureSettings, PressureSolver, Problem, Start,
};
use crate::sparse::{Entry, Row, SparseMatrix};
use std::sync::Arc;
use std::time::Instant;

/// Finds the pressure by a network.
pub(crate) struct NetworkSolver {
    weights: Arc<Weights>,
    elsewhere: Option<Arc<dyn Inference>>,
    settings: PressureSettings,
    guarded: bool,
    residual: Residual,
    paper: Paper,
    product: Vec<[f64; 1]>,
    sums: Vec<[Entry<1>; 2]>,
    poisson: Poisson,
}

impl NetworkSolver {
    /// With the inference `elsewhere` in the place of the program's own, if there is one.
    pub(crate) fn new(
        network: Network,
        elsewhere: Option<Arc<dyn Inference>>,
        settings: PressureSettings,
        guarded: bool,
    ) -> Self {
        Self {
            weights: Arc::new(network.0),
            elsewhere,
            settings,
            guarded,
            residual: Residual::default(),
            paper: Paper::default(),
            product: Vec::new(),
            sums: Vec::new(),
            poisson: Poisson::new(PressureSettings { start: Start::Given, ..settings }),
        }
    }

    /// Adds the residual network's correction to the pressure.
    fn correct(&mut self, weights: &ResidualWeights, problem: &mut Problem<'_>) -> Squares {
        let (matrix, rhs) = (problem.matrix, problem.rhs);
        let level = level(weights, problem.memory, problem.fields, matrix, problem.step);
        let residual = |i: usize, row: Row<'_>, last: &[[f64; 1]]| {
            let [product] = row.times(last[i], last);
            [rhs[i][0] - product, rhs[i][0]]
        };
        self.residual.correct(level, matrix, problem.pressure, residual)
    }

    /// Adds the change of the pressure that the network finds elsewhere; its residual is known.
    fn correct_elsewhere(
        &self,
        elsewhere: &dyn Inference,
        weights: &Weights,
        problem: &mut Problem<'_>,
    ) -> Result<(), FluidError> {
        let change = match weights {
            Weights::Residual(weights) => {
                let (fields, matrix) = (problem.fields, problem.matrix);
                let level = level(weights, problem.memory, fields, matrix, problem.step);
                elsewhere.residual(ResidualStep::new(level, matrix, &self.product))
            }
            Weights::Paper(_) => elsewhere.paper(&Frame::of(&Assembled {
                scales: problem.scales,
                fields: problem.fields,
                matrix: problem.matrix,
                source: problem.source,
                last: problem.pressure,
                change: problem.change,
                residual: &self.product,
            })),
        };
        let change = change.map_err(|reason| FluidError::Inference { reason })?;
        for (p, change) in problem.pressure.iter_mut().zip(&change) {
            p[0] += f64::from(*change);
        }
        Ok(())
    }

    /// Puts the pressure of the paper's network in the place of the last.
    fn replace(&mut self, weights: &PaperWeights, problem: &mut Problem<'_>) {
        let (fields, scales) = (problem.fields, problem.scales);
        let elevation = paper::elevations(fields.position, fields.on_surface, scales.depth);
        let weight = scales.density * scales.gravity;
        self.paper.links.find(fields.position, scales.spacing, |i| fields.fluid.of(i));
        let (source, last) = (problem.source, &*problem.pressure);
        let inputs = |i: usize| {
            // p = 0 on the surface is p_d = 0.
            let p_d = if fields.on_surface[i] { 0.0 } else { last[i][0] - weight * elevation[i] };
            let velocity = fields.velocity[i];
            paper::inputs(&scales, source[i], [velocity.x, velocity.y], p_d)
        };
        let found = self.paper.pressure(weights, inputs, fields.position.len());
        let unit = weight * scales.depth;
        for (i, p) in problem.pressure.iter_mut().enumerate() {
            p[0] = match problem.matrix.stands_alone(i) {
                true => problem.rhs[i][0],
                false => f64::from(found[i]) * unit + weight * elevation[i],
            };
        }
    }
}

/// The coarse level and the gates for the equations of `matrix`.
fn level<'a>(
    weights: &ResidualWeights,
    memory: &'a mut PressureMemory,
    fields: Fields<'_>,
    matrix: &SparseMatrix,
    step: u64,
) -> Level<'a> {
    memory.coarse(fields, matrix, step, |places, gates| {
        weights.all_gates(matrix, places, |i| fields.wall_lists.of(i).len(), gates);
    })
}

impl PressureSolver for NetworkSolver {
    fn solve(&mut self, mut problem: Problem<'_>) -> Result<PressureReport, FluidError> {
        let begun = Instant::now();
        let weights = Arc::clone(&self.weights);
        let elsewhere = self.elsewhere.clone();
        if matches!(*weights, Weights::Residual(_)) {
            problem.start(self.settings.start);
        }
        let Squares { residual: before, rhs: size, left: mut after } = match (elsewhere, &*weights)
        {
            (Some(elsewhere), _) => {
                let (residual, rhs) = problem.residual(&mut self.product, &mut self.sums);
                self.correct_elsewhere(&*elsewhere, &weights, &mut problem)?;
                let (left, _) = problem.residual(&mut self.product, &mut self.sums);
                Squares { residual, rhs, left }
            }
            (None, Weights::Residual(weights)) => self.correct(weights, &mut problem),
            (None, Weights::Paper(weights)) => {
                let (residual, rhs) = problem.residual(&mut self.product, &mut self.sums);
                self.replace(weights, &mut problem);
                let (left, _) = problem.residual(&mut self.product, &mut self.sums);
                Squares { residual, rhs, left }
            }
        };
        for _ in 0..self.settings.sweeps {
            (after, _) = problem.residual(&mut self.product, &mut self.sums);
            problem.sweep(&self.product);
        }
        let root_mean = |square: f64| (square / problem.rhs.len() as f64).sqrt();
        let scale = problem.divergence_per_residual;
        let limit =
            self.settings.guard_tolerance * (problem.scales.gravity / problem.scales.depth).sqrt();
        // What is known of the residual is from before the last messages or sweep: enough for most steps.
        if self.guarded && after.is_finite() && root_mean(after) * scale > limit {
            (after, _) = problem.residual(&mut self.product, &mut self.sums);
        }
        let relative = |square: f64| if square > 0.0 { (square / size).sqrt() } else { 0.0 };
        let report = PressureReport {
            iterations: 0,
            residual_before: relative(before),
            residual: relative(after),
            divergence_left: root_mean(after) * scale,
            fell_back: false,
            time: begun.elapsed(),
        };
        let good = report.divergence_left <= limit;
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
