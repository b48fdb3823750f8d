//! The pressure by a network, alone or guarded.
//!
//! Guarded: after the network, optional damped Jacobi sweeps; then the divergence that is left is
//! checked, and a step that leaves more than the guard allows goes on with the pressure Poisson
//! equation from there.

use crate::error::FluidError;
use crate::frame::{Assembled, Frame};
use crate::neighbours::BLOCK;
use crate::network::paper::{self, Paper, PaperWeights};
use crate::network::residual::{Residual, ResidualWeights};
use crate::network::{Inference, Network, Weights};
use crate::pressure::poisson::Poisson;
use crate::pressure::solver::{PressureReport, PressureSettings, PressureSolver, Problem, Start};
use crate::sparse::Entry;
use rayon::prelude::*;
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
    single: Vec<f32>,
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
            single: Vec::new(),
            product: Vec::new(),
            sums: Vec::new(),
            poisson: Poisson::new(PressureSettings { start: Start::Given, ..settings }),
        }
    }

    /// Adds the residual network's correction to the pressure; the sum of the squares of the
    /// residual before its last layer, Pa².
    fn correct(&mut self, weights: &ResidualWeights, problem: &mut Problem<'_>) -> f64 {
        let (fields, matrix) = (problem.fields, problem.matrix);
        self.single.resize(self.product.len(), 0.0);
        self.single.par_chunks_mut(BLOCK).zip(self.product.par_chunks(BLOCK)).for_each(
            |(single, r)| single.iter_mut().zip(r).for_each(|(single, r)| *single = r[0] as f32),
        );
        let level = problem.memory.coarse(fields, matrix, problem.step, |cells, gates| {
            weights.all_gates(matrix, cells, |i| fields.wall_lists.of(i).len(), gates);
        });
        let (correction, left) = self.residual.correction(level, matrix, &self.single);
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
        left
    }

    /// Adds the change of the pressure that the network finds elsewhere; its residual is known.
    fn correct_elsewhere(
        &self,
        elsewhere: &dyn Inference,
        problem: &mut Problem<'_>,
    ) -> Result<(), FluidError> {
        let frame = Frame::of(&Assembled {
            scales: problem.scales,
            fields: problem.fields,
            matrix: problem.matrix,
            source: problem.source,
            last: problem.pressure,
            change: problem.change,
            residual: &self.product,
        });
        let change = elsewhere.change(&frame).map_err(|reason| FluidError::Inference { reason })?;
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

impl PressureSolver for NetworkSolver {
    fn solve(&mut self, mut problem: Problem<'_>) -> Result<PressureReport, FluidError> {
        let begun = Instant::now();
        let (before, size) = problem.residual(&mut self.product, &mut self.sums);
        let weights = Arc::clone(&self.weights);
        let elsewhere = self.elsewhere.clone();
        let mut after = match (elsewhere, &*weights) {
            (Some(elsewhere), _) => {
                self.correct_elsewhere(&*elsewhere, &mut problem)?;
                problem.residual(&mut self.product, &mut self.sums).0
            }
            (None, Weights::Residual(weights)) => self.correct(weights, &mut problem),
            (None, Weights::Paper(weights)) => {
                self.replace(weights, &mut problem);
                problem.residual(&mut self.product, &mut self.sums).0
            }
        };
        for _ in 0..self.settings.sweeps {
            (after, _) = problem.residual(&mut self.product, &mut self.sums);
            problem.sweep(&self.product);
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
        let rate = (problem.scales.gravity / problem.scales.depth).sqrt();
        let good = report.divergence_left <= self.settings.guard_tolerance * rate;
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
