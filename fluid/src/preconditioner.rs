//! Incomplete factors of the pressure equation's matrix, which precondition its solution.

use crate::neighbours::BLOCK;
use crate::sparse::{Entry, SparseMatrix};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Part of what incomplete factorization drops that is added to the diagonal (MILU).
const DROPPED_TO_DIAGONAL: f64 = 0.95;

/// Rows that one slab owns, and rows that it shares with each neighbour. Together they fit the
/// 16 bits of a local column.
const SLAB_ROWS: usize = 6144;
const SLAB_OVERLAP: usize = 512;
/// Steps that factors last.
const FACTORS_LAST: u64 = 8;

/// Restricted additive Schwarz over slabs of rows, each solved by a modified incomplete LU
/// factorization without fill.
///
/// Particles are numbered along the tank, so a slab of rows is a slab of water. The cut depends
/// on the number of rows alone, so results do not depend on the number of threads.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Preconditioner {
    slabs: Vec<Slab>,
    /// Rows that each slab owns, but the last.
    own: usize,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Slab {
    /// Step of its factors, if they are of the present numbering.
    factorized_at: Option<u64>,
    /// First row, first owned row, one past the last owned row (all global).
    first: usize,
    own_first: usize,
    own_last: usize,
    start: Vec<u32>,
    /// Local column and factor, sorted by column; strictly lower, then strictly upper.
    column: Vec<u16>,
    value: Vec<f32>,
    /// First upper entry of each row.
    upper: Vec<u32>,
    inverse_diagonal: Vec<f32>,
    #[serde(skip)]
    solved: Vec<f64>,
    /// Where each column of the row that is being factorized stands.
    #[serde(skip)]
    place: Vec<u32>,
    #[serde(skip)]
    row: Vec<(u16, f64)>,
    #[serde(skip)]
    work: Vec<f64>,
}

impl Preconditioner {
    /// Factorizes the slabs of `matrix` that hold `rows`, where that was not done in the last few
    /// steps. The rows of these slabs.
    pub(crate) fn factorize(
        &mut self,
        matrix: &SparseMatrix,
        rows: Range<usize>,
        step: u64,
    ) -> Range<usize> {
        let all = matrix.rows();
        let count = all.div_ceil(SLAB_ROWS).max(1);
        // A whole number of blocks each, so that slabs cut vectors where blocks do.
        let own = all.div_ceil(count).div_ceil(BLOCK).max(1) * BLOCK;
        self.own = own;
        self.slabs.resize_with(all.div_ceil(own).max(1), Slab::default);
        let first = rows.start / own;
        let slabs = first..rows.end.div_ceil(own).max(first + 1);
        self.slabs[slabs.clone()].par_iter_mut().zip(slabs.clone()).for_each(|(this, slab)| {
            let owned = slab * own..((slab + 1) * own).min(all);
            let age = this.factorized_at.map(|factorized| step - factorized);
            if age.is_none_or(|age| age >= FACTORS_LAST) || this.owned() != owned {
                let first = owned.start.saturating_sub(SLAB_OVERLAP);
                let last = (owned.end + SLAB_OVERLAP).min(all);
                this.factorize(matrix, first..last, owned);
                this.factorized_at = Some(step);
            }
        });
        slabs.start * own..(slabs.end * own).min(all)
    }

    /// The rows have been renumbered: factors of the old numbering are of no use.
    pub(crate) fn forget(&mut self) {
        self.slabs.iter_mut().for_each(|slab| slab.factorized_at = None);
    }

    /// z ≈ A⁻¹ r in `rows`, those of whole slabs; z = r before anything was factorized, which is the
    /// diagonal preconditioner.
    pub(crate) fn apply<const R: usize>(
        &mut self,
        rows: Range<usize>,
        r: &[Entry<R>],
        z: &mut [Entry<R>],
    ) {
        if self.slabs.is_empty() {
            z[rows.clone()].copy_from_slice(&r[rows]);
            return;
        }
        let slabs = &mut self.slabs[rows.start / self.own..];
        let z = z[rows].par_chunks_mut(self.own);
        slabs.par_iter_mut().zip(z).for_each(|(slab, z)| slab.apply(r, z));
    }
}

impl Slab {
    /// The rows that it owns.
    fn owned(&self) -> Range<usize> {
        self.own_first..self.own_last
    }

    fn factorize(&mut self, matrix: &SparseMatrix, rows: Range<usize>, own: Range<usize>) {
        self.first = rows.start;
        self.own_first = own.start;
        self.own_last = own.end;
        self.start.clear();
        self.start.push(0);
        self.column.clear();
        self.value.clear();
        self.upper.clear();
        self.inverse_diagonal.clear();
        let (n, first) = (rows.len(), rows.start as u32);
        const ABSENT: u32 = u32::MAX;
        let (mut place, mut sorted, mut work) = (
            std::mem::take(&mut self.place),
            std::mem::take(&mut self.row),
            std::mem::take(&mut self.work),
        );
        place.clear();
        place.resize(n, ABSENT);
        for i in 0..n {
            sorted.clear();
            let (columns, values) = matrix.row(i + rows.start);
            sorted.extend(
                columns
                    .iter()
                    .zip(values)
                    .filter(|(column, _)| rows.contains(&(**column as usize)))
                    .map(|(&column, &value)| ((column - first) as u16, f64::from(value))),
            );
            sorted.sort_unstable_by_key(|&(column, _)| column);
            let begin = self.column.len();
            work.clear();
            for (k, &(column, value)) in sorted.iter().enumerate() {
                place[column as usize] = k as u32;
                self.column.push(column);
                work.push(value);
            }
            let mut diagonal = 1.0;
            let mut dropped = 0.0;
            let lower = sorted.partition_point(|&(column, _)| (column as usize) < i);
            for k in 0..lower {
                let pivot_row = sorted[k].0 as usize;
                let factor = work[k] * f64::from(self.inverse_diagonal[pivot_row]);
                work[k] = factor;
                let from = self.upper[pivot_row] as usize;
                let to = self.start[pivot_row + 1] as usize;
                for entry in from..to {
                    let column = self.column[entry];
                    let update = factor * f64::from(self.value[entry]);
                    if column as usize == i {
                        diagonal -= update;
                    } else if place[column as usize] == ABSENT {
                        dropped += update;
                    } else {
                        work[place[column as usize] as usize] -= update;
                    }
                }
            }
            diagonal -= DROPPED_TO_DIAGONAL * dropped;
            // A pivot near zero would ruin the factors: fall back to the row's own diagonal.
            if diagonal.abs() < 0.05 {
                diagonal = 1.0;
            }
            self.inverse_diagonal.push((1.0 / diagonal) as f32);
            self.value.extend(work.iter().map(|&value| value as f32));
            self.upper.push((begin + lower) as u32);
            self.start.push(self.column.len() as u32);
            for &(column, _) in &sorted {
                place[column as usize] = ABSENT;
            }
        }
        (self.place, self.row, self.work) = (place, sorted, work);
    }

    fn apply<const R: usize>(&mut self, r: &[Entry<R>], z: &mut [Entry<R>]) {
        let n = self.inverse_diagonal.len();
        self.solved.resize(n * R, 0.0);
        let (work, _) = self.solved.as_chunks_mut::<R>();
        for i in 0..n {
            let mut sum = r[self.first + i];
            for entry in self.start[i] as usize..self.upper[i] as usize {
                let value = f64::from(self.value[entry]);
                let known = work[self.column[entry] as usize];
                for k in 0..R {
                    sum[k] -= value * known[k];
                }
            }
            work[i] = sum;
        }
        for i in (0..n).rev() {
            let mut sum = work[i];
            for entry in self.upper[i] as usize..self.start[i + 1] as usize {
                let value = f64::from(self.value[entry]);
                let known = work[self.column[entry] as usize];
                for k in 0..R {
                    sum[k] -= value * known[k];
                }
            }
            let inverse = f64::from(self.inverse_diagonal[i]);
            work[i] = sum.map(|sum| sum * inverse);
        }
        let offset = self.own_first - self.first;
        z.copy_from_slice(&work[offset..offset + z.len()]);
    }
}
