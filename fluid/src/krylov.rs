//! Preconditioned BiCGSTAB (van der Vorst 1992) for a few right-hand sides at once.
//!
//! The right-hand sides share every pass over matrix and factors but are otherwise independent.
//! Sums are made over fixed blocks in fixed order.

use crate::neighbours::BLOCK;
use crate::sparse::{Entry, Preconditioner, SparseMatrix};
use rayon::prelude::*;

/// When to stop, for each right-hand side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Stop {
    /// Residual relative to the right-hand side, both in the 2-norm.
    pub(crate) relative: f64,
    /// Residual in the root-mean-square norm below which a solve is done in any case.
    pub(crate) absolute: f64,
    /// Iterations at most.
    pub(crate) iterations: usize,
}

/// What a solve did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Report {
    pub(crate) iterations: usize,
    /// Largest residual of the right-hand sides, relative to its stopping value times the
    /// relative tolerance: below that tolerance means converged.
    pub(crate) residual: f64,
    pub(crate) converged: bool,
}

/// Work vectors, kept between solves.
#[derive(Clone, Debug)]
pub(crate) struct Krylov<const R: usize> {
    r: Vec<Entry<R>>,
    shadow: Vec<Entry<R>>,
    p: Vec<Entry<R>>,
    v: Vec<Entry<R>>,
    z: Vec<Entry<R>>,
    t: Vec<Entry<R>>,
    sums: Vec<[Entry<R>; 2]>,
}

impl<const R: usize> Default for Krylov<R> {
    fn default() -> Self {
        Self {
            r: Vec::new(),
            shadow: Vec::new(),
            p: Vec::new(),
            v: Vec::new(),
            z: Vec::new(),
            t: Vec::new(),
            sums: Vec::new(),
        }
    }
}

fn quotient<const R: usize>(a: Entry<R>, b: Entry<R>) -> Entry<R> {
    std::array::from_fn(|k| if b[k] == 0.0 { 0.0 } else { a[k] / b[k] })
}

impl<const R: usize> Krylov<R> {
    /// Σ a·b and Σ a·c.
    fn dots(&mut self, which: impl Fn(&Self) -> [&[Entry<R>]; 3]) -> [Entry<R>; 2] {
        let mut sums = std::mem::take(&mut self.sums);
        let [a, b, c] = which(self);
        sums.resize(a.len().div_ceil(BLOCK), [[0.0; R]; 2]);
        sums.par_iter_mut()
            .zip(a.par_chunks(BLOCK))
            .zip(b.par_chunks(BLOCK).zip(c.par_chunks(BLOCK)))
            .with_min_len(8)
            .for_each(|((sum, a), (b, c))| {
                let mut own = [[0.0; R]; 2];
                for ((a, b), c) in a.iter().zip(b).zip(c) {
                    for k in 0..R {
                        own[0][k] += a[k] * b[k];
                        own[1][k] += a[k] * c[k];
                    }
                }
                *sum = own;
            });
        let mut total = [[0.0; R]; 2];
        for sum in &sums {
            for k in 0..R {
                total[0][k] += sum[0][k];
                total[1][k] += sum[1][k];
            }
        }
        self.sums = sums;
        total
    }

    /// Solves A x = b from the guess in `x`.
    pub(crate) fn solve(
        &mut self,
        matrix: &SparseMatrix,
        preconditioner: &mut Preconditioner,
        b: &[Entry<R>],
        x: &mut [Entry<R>],
        stop: Stop,
    ) -> Report {
        let n = b.len();
        for vector in
            [&mut self.r, &mut self.shadow, &mut self.p, &mut self.v, &mut self.z, &mut self.t]
        {
            vector.resize(n, [0.0; R]);
        }
        let floor = stop.absolute * stop.absolute * n as f64;
        self.t.copy_from_slice(b);
        let [b2, _] = self.dots(|s| [&s.t, &s.t, &s.t]);
        // No tolerance relative to zero can be met from a guess that is not.
        for k in (0..R).filter(|&k| b2[k] == 0.0) {
            x.iter_mut().for_each(|x| x[k] = 0.0);
        }
        let goal: Entry<R> =
            std::array::from_fn(|k| (stop.relative * stop.relative * b2[k]).max(floor));
        let mut report = Report::default();
        // Rounding makes the recursive residual drift from the true one: restart from the true
        // residual until that meets the goal.
        loop {
            matrix.multiply(x, &mut self.r);
            for (r, b) in self.r.iter_mut().zip(b) {
                for k in 0..R {
                    r[k] = b[k] - r[k];
                }
            }
            let [r2, _] = self.dots(|s| [&s.r, &s.r, &s.r]);
            let excess = (0..R).map(|k| (r2[k] / goal[k]).sqrt()).fold(0.0, f64::max);
            report.residual = excess * stop.relative;
            report.converged = excess <= 1.0;
            if report.converged || report.iterations >= stop.iterations || !excess.is_finite() {
                return report;
            }
            let before = report.iterations;
            self.cycle(matrix, preconditioner, x, r2, goal, stop, &mut report);
            if report.iterations == before {
                return report;
            }
        }
    }

    /// Iterates until the recursive residual meets the goal or breaks down.
    #[allow(clippy::too_many_arguments)] // the state of one solve
    fn cycle(
        &mut self,
        matrix: &SparseMatrix,
        preconditioner: &mut Preconditioner,
        x: &mut [Entry<R>],
        r2: Entry<R>,
        goal: Entry<R>,
        stop: Stop,
        report: &mut Report,
    ) {
        self.shadow.copy_from_slice(&self.r);
        self.p.copy_from_slice(&self.r);
        let mut rho = r2;
        while report.iterations < stop.iterations {
            report.iterations += 1;
            preconditioner.apply(&self.p, &mut self.z);
            matrix.multiply(&self.z, &mut self.v);
            let [shadow_v, _] = self.dots(|s| [&s.shadow, &s.v, &s.v]);
            let alpha = quotient(rho, shadow_v);
            update(x, &self.z, alpha);
            update(&mut self.r, &self.v, alpha.map(|a| -a));
            preconditioner.apply(&self.r, &mut self.z);
            matrix.multiply(&self.z, &mut self.t);
            let [tr, tt] = self.dots(|s| [&s.t, &s.r, &s.t]);
            let omega = quotient(tr, tt);
            update(x, &self.z, omega);
            update(&mut self.r, &self.t, omega.map(|o| -o));
            let [r2, next] = self.dots(|s| [&s.r, &s.r, &s.shadow]);
            if (0..R).all(|k| r2[k] <= goal[k]) {
                return;
            }
            let beta: Entry<R> = std::array::from_fn(|k| {
                let denominator = rho[k] * omega[k];
                if denominator == 0.0 { 0.0 } else { next[k] / denominator * alpha[k] }
            });
            if beta.iter().any(|b| !b.is_finite()) {
                return;
            }
            rho = next;
            let (r, v) = (&self.r, &self.v);
            self.p
                .par_chunks_mut(BLOCK)
                .zip(r.par_chunks(BLOCK).zip(v.par_chunks(BLOCK)))
                .with_min_len(8)
                .for_each(|(p, (r, v))| {
                    for ((p, r), v) in p.iter_mut().zip(r).zip(v) {
                        for k in 0..R {
                            p[k] = r[k] + beta[k] * (p[k] - omega[k] * v[k]);
                        }
                    }
                });
        }
    }
}

/// y += a x.
fn update<const R: usize>(y: &mut [Entry<R>], x: &[Entry<R>], a: Entry<R>) {
    y.par_chunks_mut(BLOCK).zip(x.par_chunks(BLOCK)).with_min_len(8).for_each(|(y, x)| {
        for (y, x) in y.iter_mut().zip(x) {
            for k in 0..R {
                y[k] += a[k] * x[k];
            }
        }
    });
}
