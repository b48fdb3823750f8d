//! Sparse matrices with a unit diagonal, in blocks of rows, and their incomplete factors.

use crate::neighbours::BLOCK;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// A few right-hand sides that are solved together, one entry each.
pub(crate) type Entry<const R: usize> = [f64; R];

/// Off-diagonal entries of a block of rows; the diagonal is one.
#[derive(Clone, Debug, Default)]
pub(crate) struct RowBlock {
    start: Vec<u32>,
    entries: Vec<(u32, f64)>,
}

impl RowBlock {
    pub(crate) fn clear(&mut self) {
        self.start.clear();
        self.start.push(0);
        self.entries.clear();
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, column: u32, value: f64) {
        self.entries.push((column, value));
    }

    #[inline(always)]
    pub(crate) fn end_row(&mut self) {
        self.start.push(self.entries.len() as u32);
    }

    #[inline(always)]
    fn row(&self, local: usize) -> &[(u32, f64)] {
        &self.entries[self.start[local] as usize..self.start[local + 1] as usize]
    }
}

/// A square matrix I + (entries).
#[derive(Clone, Debug, Default)]
pub(crate) struct SparseMatrix {
    pub(crate) blocks: Vec<RowBlock>,
}

impl SparseMatrix {
    #[inline(always)]
    fn row(&self, i: usize) -> &[(u32, f64)] {
        self.blocks[i / BLOCK].row(i % BLOCK)
    }

    /// y = A x, and for each block of rows the sums that `also` makes of y and the row's index.
    pub(crate) fn multiply<const R: usize>(&self, x: &[Entry<R>], y: &mut [Entry<R>]) {
        self.blocks.par_iter().zip(y.par_chunks_mut(BLOCK)).enumerate().for_each(
            |(block, (rows, y))| {
                for (local, y) in y.iter_mut().enumerate() {
                    let mut sum = x[block * BLOCK + local];
                    for &(column, value) in rows.row(local) {
                        let x = &x[column as usize];
                        for r in 0..R {
                            sum[r] += value * x[r];
                        }
                    }
                    *y = sum;
                }
            },
        );
    }
}

/// Part of what incomplete factorization drops that is added to the diagonal (MILU).
const DROPPED_TO_DIAGONAL: f64 = 0.95;

/// Rows that one slab owns, and rows that it shares with each neighbour.
const SLAB_ROWS: usize = 6144;
const SLAB_OVERLAP: usize = 512;

/// Restricted additive Schwarz over slabs of rows, each solved by a modified incomplete LU
/// factorization without fill.
///
/// Particles are numbered along the tank, so a slab of rows is a slab of water. The cut depends
/// on the number of rows alone, so results do not depend on the number of threads.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Preconditioner {
    slabs: Vec<Slab>,
}

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
struct Slab {
    /// First row, first owned row, one past the last owned row (all global).
    first: usize,
    own_first: usize,
    own_last: usize,
    start: Vec<u32>,
    /// Local column and factor, sorted by column; strictly lower, then strictly upper.
    column: Vec<u32>,
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
    row: Vec<(u32, f64)>,
    #[serde(skip)]
    work: Vec<f64>,
}

impl Preconditioner {
    /// Factorizes `matrix` of `rows` rows.
    pub(crate) fn factorize(&mut self, matrix: &SparseMatrix, rows: usize) {
        let count = rows.div_ceil(SLAB_ROWS).max(1);
        // A whole number of blocks each, so that slabs cut vectors where blocks do.
        let own = rows.div_ceil(count).div_ceil(BLOCK) * BLOCK;
        let count = rows.div_ceil(own).max(1);
        self.slabs.resize_with(count, Slab::default);
        self.slabs.par_iter_mut().enumerate().for_each(|(slab, this)| {
            let (own_first, own_last) = (slab * own, ((slab + 1) * own).min(rows));
            let first = own_first.saturating_sub(SLAB_OVERLAP);
            let last = (own_last + SLAB_OVERLAP).min(rows);
            this.factorize(matrix, first..last, own_first..own_last);
        });
    }

    /// z ≈ A⁻¹ r.
    pub(crate) fn apply<const R: usize>(&mut self, r: &[Entry<R>], z: &mut [Entry<R>]) {
        let own = self.slabs.first().map_or(1, |slab| slab.own_last - slab.own_first).max(1);
        self.slabs.par_iter_mut().zip(z.par_chunks_mut(own)).for_each(|(slab, z)| slab.apply(r, z));
    }
}

impl Slab {
    fn factorize(
        &mut self,
        matrix: &SparseMatrix,
        rows: std::ops::Range<usize>,
        own: std::ops::Range<usize>,
    ) {
        self.first = rows.start;
        self.own_first = own.start;
        self.own_last = own.end;
        self.start.clear();
        self.start.push(0);
        self.column.clear();
        self.value.clear();
        self.upper.clear();
        self.inverse_diagonal.clear();
        let n = rows.len();
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
            sorted.extend(
                matrix
                    .row(i + rows.start)
                    .iter()
                    .filter(|(column, _)| rows.contains(&(*column as usize)))
                    .map(|&(column, value)| (column - rows.start as u32, value)),
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
