//! What every way to find the pressure has in common: the problem, the answer's report, and what
//! is kept from step to step.

use crate::error::FluidError;
use crate::fields::Fields;
use crate::frame::Scales;
use crate::krylov::{Stop, System};
use crate::neighbours::{BLOCK, MANY};
use crate::network::lattice::{self, Coarse, Places};
use crate::network::residual::{Gates, Level};
use crate::particles::permute;
use crate::preconditioner::Preconditioner;
use crate::sparse::{Entry, SparseMatrix};
use nalgebra::Point2;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;
use std::time::Duration;

/// A way to find the pressure of a step.
pub(crate) trait PressureSolver: Send + Sync {
    /// Replaces the pressure of the step before in `problem.pressure` by that of this step.
    ///
    /// # Errors
    /// [`FluidError::PressureNotConverged`] where no solver left can do it.
    fn solve(&mut self, problem: Problem<'_>) -> Result<PressureReport, FluidError>;
}

/// The assembled pressure equation of a step, and all that a solver may look at.
pub(crate) struct Problem<'a> {
    /// Rows of the inner particles, scaled to a diagonal of one; those of the surface are p = 0.
    pub(crate) matrix: &'a SparseMatrix,
    /// Right-hand side in the same scaling, Pa.
    pub(crate) rhs: &'a [[f64; 1]],
    /// Before: the pressure of the step before. After: the solution. Zero on the surface. Pa.
    pub(crate) pressure: &'a mut [[f64; 1]],
    /// Change of the pressure over a step, the mean of [`SolverKind::steps_of_change`], Pa.
    pub(crate) change: &'a [f64],
    /// Ψ of Eq. (9b), kg/(m³ s).
    pub(crate) source: &'a [f64],
    /// Step, spacing and water.
    pub(crate) scales: Scales,
    /// Particles, walls and neighbours where the step is assembled.
    pub(crate) fields: Fields<'a>,
    /// Number of the step.
    pub(crate) step: u64,
    /// When to stop.
    pub(crate) stop: Stop,
    /// Divergence (1/s) that a residual of 1 Pa is worth.
    pub(crate) divergence_per_residual: f64,
    /// What outlives the step.
    pub(crate) memory: &'a mut PressureMemory,
}

/// What a pressure solver keeps from step to step, and a saved state holds.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct PressureMemory {
    preconditioner: Preconditioner,
    /// One without factors.
    #[serde(skip)]
    diagonal: Preconditioner,
    places: Places,
    coarse: Coarse,
    coarse_at: Option<u64>,
    gates: Vec<Gates>,
}

/// Steps that the network's coarse level and gates last. Particles keep their places in it, as if it went
/// with the water: it fits its factors better so than with places of the step.
const COARSE_LASTS: u64 = 24;

impl PressureMemory {
    /// The equations of `matrix` in `rows` at least, with the preconditioner of `kind`: factors of this
    /// step or of a few steps back.
    pub(crate) fn system<'a>(
        &'a mut self,
        kind: PreconditionerKind,
        matrix: &'a SparseMatrix,
        rows: Range<usize>,
        step: u64,
    ) -> System<'a> {
        let (preconditioner, rows) = match kind {
            PreconditionerKind::Milu => {
                let rows = self.preconditioner.factorize(matrix, rows, step);
                (&mut self.preconditioner, rows)
            }
            PreconditionerKind::Diagonal => {
                let rows = rows.start / BLOCK * BLOCK..rows.end.next_multiple_of(BLOCK);
                (&mut self.diagonal, rows.start..rows.end.min(matrix.rows()))
            }
        };
        System { matrix, preconditioner, rows }
    }

    /// The network's coarse level, the particles' places in it and their gates, all of this step or of
    /// the same step back. `gates` makes the gates.
    pub(crate) fn coarse(
        &mut self,
        fields: Fields,
        matrix: &SparseMatrix,
        step: u64,
        gates: impl Fn(&Places, &mut Vec<Gates>),
    ) -> Level<'_> {
        let position = fields.position;
        if self.coarse_at.is_none_or(|built| step - built >= COARSE_LASTS) {
            self.places.find(position, fields.spacing, lattice::shape(position, fields.spacing));
            self.coarse.factorize(&self.places, matrix);
            gates(&self.places, &mut self.gates);
            self.coarse_at = Some(step);
        }
        Level { places: &self.places, coarse: &self.coarse, gates: &self.gates }
    }

    /// One more particle, at `position`, which takes its gates from particle `like`.
    pub(crate) fn add(&mut self, position: Point2<f64>, spacing: f64, like: usize) {
        if self.coarse_at.is_some() {
            self.places.add(position, spacing);
            self.gates.push(self.gates[like]);
        }
    }

    /// The new i-th particle is the old `order[i]`-th. Factors of the old numbering are of no use.
    pub(crate) fn renumber(&mut self, order: &[u32]) {
        self.preconditioner.forget();
        if self.coarse_at.is_some() {
            self.places.renumber(order);
            permute(&mut self.gates, order, &mut Vec::new());
        }
    }
}

/// Part of a residual that a damped Jacobi sweep takes.
const DAMPING: f64 = 0.6;

impl Problem<'_> {
    /// Makes the last pressure what a solver starts from.
    pub(crate) fn start(&mut self, start: Start) {
        match start {
            Start::Given => {}
            Start::Cold => self.pressure.fill([0.0]),
            Start::Warm => {
                let inner = self.change.par_iter().zip(self.fields.on_surface);
                let pressure = self.pressure.par_iter_mut().zip(inner).with_min_len(MANY);
                pressure.for_each(|(p, (change, on_surface))| {
                    if !on_surface {
                        p[0] += change;
                    }
                });
            }
        }
    }

    /// r = b − A p into `r`; the squares of r and of b. `sums` is scratch.
    pub(crate) fn residual(
        &self,
        r: &mut Vec<[f64; 1]>,
        sums: &mut Vec<[Entry<1>; 2]>,
    ) -> (f64, f64) {
        let rhs = self.rhs;
        r.resize(rhs.len(), [0.0]);
        let (rows, x) = (0..rhs.len(), &*self.pressure);
        let [[r2], [b2]] = self.matrix.multiply(rows, x, r, sums, |i, r, [r2, b2]| {
            r[0] = rhs[i][0] - r[0];
            r2[0] += r[0] * r[0];
            b2[0] += rhs[i][0] * rhs[i][0];
        });
        (r2, b2)
    }

    /// A damped Jacobi sweep, p ← p + ω r.
    pub(crate) fn sweep(&mut self, r: &[[f64; 1]]) {
        for (p, r) in self.pressure.iter_mut().zip(r) {
            p[0] += DAMPING * r[0];
        }
    }
}

/// What a pressure solve did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PressureReport {
    /// Iterations of the Krylov solver.
    pub iterations: usize,
    /// Residual of the start relative to the right-hand side, 2-norms.
    pub residual_before: f64,
    /// Residual of the solution relative to the right-hand side, 2-norms. That of a network without
    /// sweeps is the residual before its messages, which comes for nothing; a guarded one looks again where
    /// that is too much.
    pub residual: f64,
    /// Root-mean-square divergence that the solution leaves in the velocity, 1/s.
    pub divergence_left: f64,
    /// Whether another solver than the one asked for had to finish.
    pub fell_back: bool,
    /// Wall time of the solve, the assembly not counted.
    pub time: Duration,
}

/// How the pressure is found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PressureSettings {
    /// The solver.
    pub solver: SolverKind,
    /// Preconditioner of the pressure Poisson equation.
    pub preconditioner: PreconditionerKind,
    /// What the pressure Poisson equation and the residual network start from.
    pub start: Start,
    /// Stop: residual relative to the right-hand side, 2-norms.
    pub tolerance: f64,
    /// Stop in any case: root-mean-square divergence left, in units of √(g/D).
    pub divergence_tolerance: f64,
    /// Iterations after which a solve has failed, or ends where it is capped.
    pub max_iterations: usize,
    /// Root-mean-square divergence left, in units of √(g/D), above which a guarded network's step goes
    /// on with the pressure Poisson equation.
    pub guard_tolerance: f64,
    /// Damped Jacobi sweeps after a network or capped iterations.
    pub sweeps: u32,
}

impl Default for PressureSettings {
    fn default() -> Self {
        Self {
            solver: SolverKind::Ppe,
            preconditioner: PreconditionerKind::Milu,
            start: Start::Warm,
            tolerance: 1e-3,
            divergence_tolerance: 5e-7,
            max_iterations: 500,
            guard_tolerance: 1e-3,
            sweeps: 0,
        }
    }
}

/// The solvers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SolverKind {
    /// The pressure Poisson equation (PPE), Eq. (9b), by BiCGSTAB.
    Ppe,
    /// A network alone.
    Network,
    /// A network, and the pressure Poisson equation where its residual is too large.
    Guarded,
    /// For comparisons: as many iterations and sweeps as are asked for, whatever residual remains.
    Capped,
}

impl SolverKind {
    /// Over how many steps back the change of the pressure is averaged, each counted less than the one
    /// after it. A solver that meets a tolerance takes the last change for that of the next step. What a
    /// network leaves of one step is in the changes of the next: with the last alone, modes of which it
    /// leaves e < −1/7 or e > 1/2 grow, with the mean of five e < −0.3 or e > 0.84, and without the change
    /// e < −1/3 or e > 1.
    pub(crate) fn steps_of_change(self) -> f64 {
        match self {
            Self::Ppe | Self::Capped => 1.0,
            Self::Network | Self::Guarded => 5.0,
        }
    }
}

/// The preconditioners of the pressure Poisson equation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PreconditionerKind {
    /// Modified incomplete LU factorization without fill, in overlapping slabs.
    Milu,
    /// The diagonal, as in conventional ISPH.
    Diagonal,
}

/// What a solve starts from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// The last pressure carried on: it changes once more as it did.
    Warm,
    /// Zero, as in conventional ISPH.
    Cold,
    /// What it is given: the pressure of the last step, or a network's.
    #[serde(rename = "last")]
    Given,
}
