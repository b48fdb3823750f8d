//! Sparse matrices with a unit diagonal, in blocks of rows, and their incomplete factors.

use crate::neighbours::BLOCK;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// A few right-hand sides that are solved together, one entry each.
pub(crate) type Entry<const R: usize> = [f64; R];

/// Sums that are made side by side in a product of a row, so that none waits for another.
const LANES: usize = 4;

/// A block of rows: off-diagonal entries in single precision. What their rounding takes from a
/// row's sum goes to its diagonal, so that a constant vector is treated as exactly as in double
/// precision and the rounding acts on differences between neighbours alone.
#[derive(Clone, Debug, Default)]
pub(crate) struct RowBlock {
    start: Vec<u32>,
    column: Vec<u32>,
    value: Vec<f32>,
    diagonal: Vec<f64>,
    /// What each row was divided by for its unit diagonal; nought for one without entries.
    divisor: Vec<f32>,
    lost: f64,
    /// Least and largest column, the other way round where there is none.
    reach: (u32, u32),
}

impl RowBlock {
    pub(crate) fn clear(&mut self) {
        self.start.clear();
        self.start.push(0);
        self.column.clear();
        self.value.clear();
        self.diagonal.clear();
        self.divisor.clear();
        self.lost = 0.0;
        self.reach = (u32::MAX, 0);
    }

    #[inline(always)]
    pub(crate) fn push(&mut self, column: u32, value: f64) {
        let rounded = value as f32;
        self.column.push(column);
        self.value.push(rounded);
        self.lost += value - f64::from(rounded);
        self.reach = (self.reach.0.min(column), self.reach.1.max(column));
    }

    /// Ends a row that was divided by `divisor`, its diagonal before.
    #[inline(always)]
    pub(crate) fn end_row(&mut self, divisor: f64) {
        self.start.push(self.column.len() as u32);
        self.diagonal.push(1.0 + self.lost);
        self.divisor.push(divisor as f32);
        self.lost = 0.0;
    }

    /// Columns and values of the off-diagonal entries of row `local`.
    #[inline(always)]
    fn row(&self, local: usize) -> (&[u32], &[f32]) {
        let range = self.start[local] as usize..self.start[local + 1] as usize;
        (&self.column[range.clone()], &self.value[range])
    }

    /// Product of row `local`, row `own` of the matrix, with `x`.
    #[inline(always)]
    fn times<const R: usize>(&self, local: usize, own: usize, x: &[Entry<R>]) -> Entry<R> {
        let mut sums = [[0.0; R]; LANES];
        sums[0] = x[own].map(|x| x * self.diagonal[local]);
        let (columns, values) = self.row(local);
        let (columns, last_columns) = columns.as_chunks::<LANES>();
        let (values, last_values) = values.as_chunks::<LANES>();
        for (columns, values) in columns.iter().zip(values) {
            for lane in 0..LANES {
                let (x, value) = (&x[columns[lane] as usize], f64::from(values[lane]));
                for r in 0..R {
                    sums[lane][r] += value * x[r];
                }
            }
        }
        for (&column, &value) in last_columns.iter().zip(last_values) {
            let x = &x[column as usize];
            for r in 0..R {
                sums[0][r] += f64::from(value) * x[r];
            }
        }
        std::array::from_fn(|r| (sums[0][r] + sums[1][r]) + (sums[2][r] + sums[3][r]))
    }
}

/// A square matrix with a diagonal of one (up to rounding, see [`RowBlock`]).
#[derive(Clone, Debug, Default)]
pub(crate) struct SparseMatrix {
    pub(crate) blocks: Vec<RowBlock>,
}

impl SparseMatrix {
    /// Columns and values of the off-diagonal entries of row `i`.
    #[inline(always)]
    pub(crate) fn row(&self, i: usize) -> (&[u32], &[f32]) {
        self.blocks[i / BLOCK].row(i % BLOCK)
    }

    /// What row `i` was divided by for its unit diagonal.
    #[inline(always)]
    pub(crate) fn divisor(&self, i: usize) -> f32 {
        self.blocks[i / BLOCK].divisor[i % BLOCK]
    }

    /// Whether row `i` is that of a known value or of one that depends on known values alone.
    #[inline(always)]
    pub(crate) fn stands_alone(&self, i: usize) -> bool {
        self.row(i).0.is_empty()
    }

    /// Product of row `i` with `x`, in single precision; `x` begins with that of row `first`.
    #[inline(always)]
    pub(crate) fn times_single(&self, i: usize, x: &[f32], first: usize) -> f32 {
        let (columns, values) = self.row(i);
        let mut sums = [0.0f32; LANES];
        let (columns, last_columns) = columns.as_chunks::<LANES>();
        let (values, last_values) = values.as_chunks::<LANES>();
        for (columns, values) in columns.iter().zip(values) {
            for lane in 0..LANES {
                sums[lane] += values[lane] * x[columns[lane] as usize - first];
            }
        }
        for (&column, &value) in last_columns.iter().zip(last_values) {
            sums[0] += value * x[column as usize - first];
        }
        x[i - first] + ((sums[0] + sums[1]) + (sums[2] + sums[3]))
    }

    /// The rows whose values products of the rows in `range` may need, those themselves among
    /// them.
    pub(crate) fn reach(&self, range: Range<usize>) -> Range<usize> {
        let blocks = range.start / BLOCK..range.end.div_ceil(BLOCK);
        let reaches = self.blocks[blocks].iter().map(|block| block.reach);
        reaches.filter(|(low, high)| low <= high).fold(range, |range, (low, high)| {
            range.start.min(low as usize)..range.end.max(high as usize + 1)
        })
    }

    /// Number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.blocks.iter().map(|block| block.diagonal.len()).sum()
    }

    /// Calls `visit` for every entry y_i = (A x)_i, and returns its sums of each block, added up
    /// in order.
    pub(crate) fn multiply<const R: usize, const S: usize>(
        &self,
        x: &[Entry<R>],
        y: &mut [Entry<R>],
        sums: &mut Vec<[Entry<R>; S]>,
        visit: impl Fn(usize, &mut Entry<R>, &mut [Entry<R>; S]) + Sync,
    ) -> [Entry<R>; S] {
        sums.resize(self.blocks.len(), [[0.0; R]; S]);
        self.blocks
            .par_iter()
            .zip(y.par_chunks_mut(BLOCK).zip(sums.par_iter_mut()))
            .with_min_len(4)
            .enumerate()
            .for_each(|(block, (rows, (y, sum)))| {
                let mut own = [[0.0; R]; S];
                for (local, y) in y.iter_mut().enumerate() {
                    let i = block * BLOCK + local;
                    *y = rows.times(local, i, x);
                    visit(i, y, &mut own);
                }
                *sum = own;
            });
        total(sums)
    }
}

/// Sums of blocks added up in their order.
pub(crate) fn total<const R: usize, const S: usize>(sums: &[[Entry<R>; S]]) -> [Entry<R>; S] {
    let mut total = [[0.0; R]; S];
    for sum in sums {
        for (total, sum) in total.iter_mut().zip(sum) {
            for r in 0..R {
                total[r] += sum[r];
            }
        }
    }
    total
}

/// Part of what incomplete factorization drops that is added to the diagonal (MILU).
const DROPPED_TO_DIAGONAL: f64 = 0.95;

/// Rows that one slab owns, and rows that it shares with each neighbour. Together they fit the
/// 16 bits of a local column.
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

    /// z ≈ A⁻¹ r; z = r before anything was factorized, which is the diagonal preconditioner.
    pub(crate) fn apply<const R: usize>(&mut self, r: &[Entry<R>], z: &mut [Entry<R>]) {
        if self.slabs.is_empty() {
            z.copy_from_slice(r);
            return;
        }
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
