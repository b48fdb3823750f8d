//! Preconditioned BiCGSTAB (van der Vorst 1992) for a few right-hand sides at once.
//!
//! The right-hand sides share every pass over matrix and factors but are otherwise independent.
//! A product and the sums over it are one pass over memory. Sums are made over fixed blocks in
//! fixed order.

use crate::neighbours::BLOCK;
use crate::preconditioner::Preconditioner;
use crate::sparse::{Entry, SparseMatrix, total};
use rayon::prelude::*;
use std::ops::Range;

/// Blocks that one task treats at least in a pass over vectors.
const TASK: usize = 8;

/// The equations to solve.
pub(crate) struct System<'a> {
    pub(crate) matrix: &'a SparseMatrix,
    pub(crate) preconditioner: &'a mut Preconditioner,
    /// The rows of the equations, of whole blocks and of whole slabs of the preconditioner: all, or some
    /// with nought in all others.
    pub(crate) rows: Range<usize>,
}

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
    /// The same of the guess.
    pub(crate) residual_before: f64,
    /// Root-mean-square residual of the first right-hand side, in its unit.
    pub(crate) residual_rms: f64,
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
    sums: Sums<R>,
}

/// Sums of each block, one or two of them.
#[derive(Clone, Debug)]
struct Sums<const R: usize> {
    one: Vec<[Entry<R>; 1]>,
    two: Vec<[Entry<R>; 2]>,
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
            sums: Sums { one: Vec::new(), two: Vec::new() },
        }
    }
}

#[inline(always)]
fn quotient<const R: usize>(a: Entry<R>, b: Entry<R>) -> Entry<R> {
    std::array::from_fn(|k| if b[k] == 0.0 { 0.0 } else { a[k] / b[k] })
}

/// sum += a b.
#[inline(always)]
fn add_product<const R: usize>(sum: &mut Entry<R>, a: Entry<R>, b: Entry<R>) {
    for k in 0..R {
        sum[k] += a[k] * b[k];
    }
}

impl<const R: usize> Krylov<R> {
    /// Solves A x = b in the rows of the `system`, from the guess in `x`, and sets x to nought in all
    /// others.
    pub(crate) fn solve(
        &mut self,
        mut system: System<'_>,
        b: &[Entry<R>],
        x: &mut [Entry<R>],
        stop: Stop,
    ) -> Report {
        let (matrix, rows) = (system.matrix, system.rows.clone());
        for vector in
            [&mut self.r, &mut self.shadow, &mut self.p, &mut self.v, &mut self.z, &mut self.t]
        {
            vector.resize(b.len(), [0.0; R]);
        }
        // Those that a product or a slab reaches over the rows' ends into.
        for vector in [&mut *x, &mut self.r, &mut self.p, &mut self.z] {
            vector[..rows.start].fill([0.0; R]);
            vector[rows.end..].fill([0.0; R]);
        }
        let n = rows.len();
        let floor = stop.absolute * stop.absolute * n as f64;
        let sums = &mut self.sums.one;
        sums.resize(n.div_ceil(BLOCK), [[0.0; R]]);
        let blocks = b[rows.clone()].par_chunks(BLOCK);
        sums.par_iter_mut().zip(blocks).with_min_len(TASK).for_each(|(sum, b)| {
            let mut own = [0.0; R];
            b.iter().for_each(|b| add_product(&mut own, *b, *b));
            *sum = [own];
        });
        let [b2] = total(sums);
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
            let (r, sums) = (&mut self.r, &mut self.sums.one);
            let [r2] = matrix.multiply(rows.clone(), x, r, sums, |i, r, [sum]| {
                *r = std::array::from_fn(|k| b[i][k] - r[k]);
                add_product(sum, *r, *r);
            });
            // What is no number is not converged.
            let of = |k: usize| if r2[k] == 0.0 { 0.0 } else { (r2[k] / goal[k]).sqrt() };
            let larger = |a: f64, b: f64| if a.is_nan() || a > b { a } else { b };
            let excess = (0..R).map(of).reduce(larger).unwrap_or(0.0);
            report.residual = excess * stop.relative;
            report.residual_rms = (r2[0] / n as f64).sqrt();
            if report.iterations == 0 {
                report.residual_before = report.residual;
            }
            report.converged = excess <= 1.0;
            if report.converged || report.iterations >= stop.iterations || !excess.is_finite() {
                return report;
            }
            let before = report.iterations;
            self.cycle(&mut system, x, r2, goal, stop, &mut report);
            if report.iterations == before {
                return report;
            }
        }
    }

    /// Iterates until the recursive residual meets the goal or breaks down.
    fn cycle(
        &mut self,
        system: &mut System<'_>,
        x: &mut [Entry<R>],
        r2: Entry<R>,
        goal: Entry<R>,
        stop: Stop,
        report: &mut Report,
    ) {
        let Self { r, shadow, p, v, z, t, sums } = self;
        let System { matrix, preconditioner, rows } = system;
        let rows = &*rows;
        shadow.copy_from_slice(r);
        p.copy_from_slice(r);
        let mut rho = r2;
        while report.iterations < stop.iterations {
            report.iterations += 1;
            preconditioner.apply(rows.clone(), p, z);
            let [shadow_v] = matrix.multiply(rows.clone(), z, v, &mut sums.one, |i, v, [sum]| {
                add_product(sum, shadow[i], *v);
            });
            let alpha = quotient(rho, shadow_v);
            step(rows, (x, z), alpha, (r, v));
            preconditioner.apply(rows.clone(), r, z);
            let [tr, tt] = matrix.multiply(rows.clone(), z, t, &mut sums.two, |i, t, [tr, tt]| {
                add_product(tr, *t, r[i]);
                add_product(tt, *t, *t);
            });
            let omega = quotient(tr, tt);
            step(rows, (x, z), omega, (r, t));
            sums.two
                .par_iter_mut()
                .zip(of(r, rows).zip(of(shadow, rows)))
                .with_min_len(TASK)
                .for_each(|(sum, (r, shadow))| {
                    let mut own = [[0.0; R]; 2];
                    for (r, shadow) in r.iter().zip(shadow) {
                        add_product(&mut own[0], *r, *r);
                        add_product(&mut own[1], *r, *shadow);
                    }
                    *sum = own;
                });
            let [r2, next] = total(&sums.two);
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
            p[rows.clone()]
                .par_chunks_mut(BLOCK)
                .zip(of(r, rows).zip(of(v, rows)))
                .with_min_len(TASK)
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

/// The blocks of `vector` in `rows`.
fn of<'a, const R: usize>(
    vector: &'a [Entry<R>],
    rows: &Range<usize>,
) -> rayon::slice::Chunks<'a, Entry<R>> {
    vector[rows.clone()].par_chunks(BLOCK)
}

/// x += a z and r −= a v in `rows`.
fn step<const R: usize>(
    rows: &Range<usize>,
    (x, z): (&mut [Entry<R>], &[Entry<R>]),
    a: Entry<R>,
    (r, v): (&mut [Entry<R>], &[Entry<R>]),
) {
    x[rows.clone()]
        .par_chunks_mut(BLOCK)
        .zip(of(z, rows))
        .zip(r[rows.clone()].par_chunks_mut(BLOCK).zip(of(v, rows)))
        .with_min_len(TASK)
        .for_each(|((x, z), (r, v))| {
            for ((x, z), (r, v)) in x.iter_mut().zip(z).zip(r.iter_mut().zip(v)) {
                for k in 0..R {
                    x[k] += a[k] * z[k];
                    r[k] -= a[k] * v[k];
                }
            }
        });
}
