//! Sparse matrices with a unit diagonal, in blocks of rows.

use crate::neighbours::BLOCK;
use rayon::prelude::*;
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
        self.reach = (u32::MAX, 0);
    }

    /// Adds a row of these off-diagonal `entries`, column and value, that was divided by `divisor`, its
    /// diagonal before. Returns how many there are.
    #[inline(always)]
    pub(crate) fn add_row(
        &mut self,
        entries: impl Iterator<Item = (u32, f64)>,
        divisor: f64,
    ) -> usize {
        let before = self.column.len();
        let (mut low, mut high) = self.reach;
        let mut lost = 0.0;
        for (column, value) in entries {
            let rounded = value as f32;
            self.column.push(column);
            self.value.push(rounded);
            lost += value - f64::from(rounded);
            (low, high) = (low.min(column), high.max(column));
        }
        self.reach = (low, high);
        self.start.push(self.column.len() as u32);
        self.diagonal.push(1.0 + lost);
        self.divisor.push(divisor as f32);
        self.column.len() - before
    }

    /// Columns and values of the off-diagonal entries of row `local`.
    #[inline(always)]
    fn row(&self, local: usize) -> (&[u32], &[f32]) {
        let range = self.start[local] as usize..self.start[local + 1] as usize;
        (&self.column[range.clone()], &self.value[range])
    }
}

/// A row of a matrix.
#[derive(Clone, Copy)]
pub(crate) struct Row<'a> {
    /// Columns and values of the off-diagonal entries.
    columns: &'a [u32],
    values: &'a [f32],
    diagonal: f64,
    /// What the row was divided by for its unit diagonal.
    pub(crate) divisor: f32,
}

impl Row<'_> {
    /// Whether it is that of a known value or of one that depends on known values alone.
    #[inline(always)]
    pub(crate) fn stands_alone(self) -> bool {
        self.columns.is_empty()
    }

    /// Product with `x`, whose own entry is `own`.
    #[inline(always)]
    pub(crate) fn times<const R: usize>(self, own: Entry<R>, x: &[Entry<R>]) -> Entry<R> {
        let mut sums = [[0.0; R]; LANES];
        sums[0] = own.map(|x| x * self.diagonal);
        let (columns, last_columns) = self.columns.as_chunks::<LANES>();
        let (values, last_values) = self.values.as_chunks::<LANES>();
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

    /// Product with `x`, whose own entry is `own`, in single precision; `x` begins with that of row `first`.
    #[inline(always)]
    pub(crate) fn times_single(self, own: f32, x: &[f32], first: usize) -> f32 {
        let mut sums = [0.0f32; LANES];
        let (columns, last_columns) = self.columns.as_chunks::<LANES>();
        let (values, last_values) = self.values.as_chunks::<LANES>();
        for (columns, values) in columns.iter().zip(values) {
            for lane in 0..LANES {
                sums[lane] += values[lane] * x[columns[lane] as usize - first];
            }
        }
        for (&column, &value) in last_columns.iter().zip(last_values) {
            sums[0] += value * x[column as usize - first];
        }
        own + ((sums[0] + sums[1]) + (sums[2] + sums[3]))
    }
}

/// Off-diagonal entries of the rows of a matrix.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    /// Where each row begins, n + 1.
    pub start: Vec<u32>,
    /// Column of each entry.
    pub column: Vec<u32>,
    /// The entries.
    pub value: Vec<f32>,
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

    /// Calls `visit` for every one of the `rows`, in their order.
    #[inline(always)]
    pub(crate) fn for_rows(&self, rows: Range<usize>, mut visit: impl FnMut(usize, Row<'_>)) {
        let blocks = rows.start / BLOCK..rows.end.div_ceil(BLOCK);
        for (index, block) in blocks.clone().zip(&self.blocks[blocks]) {
            let first = index * BLOCK;
            let local = rows.start.saturating_sub(first)..(rows.end - first).min(BLOCK);
            let starts = block.start[local.start..=local.end].windows(2);
            let own = block.diagonal[local.clone()].iter().zip(&block.divisor[local.clone()]);
            for ((start, (&diagonal, &divisor)), i) in starts.zip(own).zip(first + local.start..) {
                let range = start[0] as usize..start[1] as usize;
                let (columns, values) = (&block.column[range.clone()], &block.value[range]);
                visit(i, Row { columns, values, diagonal, divisor });
            }
        }
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

    /// The off-diagonal entries of all rows, one row after the other.
    pub(crate) fn all_rows(&self) -> Rows {
        let mut rows = Rows { start: vec![0], ..Rows::default() };
        for block in &self.blocks {
            let before = rows.start.last().copied().unwrap_or(0);
            rows.start.extend(block.start[1..].iter().map(|start| before + start));
        }
        let entries = rows.start.last().map_or(0, |last| *last as usize);
        rows.column.resize(entries, 0);
        rows.value.resize(entries, 0.0);
        let (mut columns, mut values) = (&mut *rows.column, &mut *rows.value);
        let mut parts = Vec::with_capacity(self.blocks.len());
        for block in &self.blocks {
            let (column, more_columns) = columns.split_at_mut(block.column.len());
            let (value, more_values) = values.split_at_mut(block.value.len());
            parts.push((block, column, value));
            (columns, values) = (more_columns, more_values);
        }
        parts.into_par_iter().with_min_len(16).for_each(|(block, column, value)| {
            column.copy_from_slice(&block.column);
            value.copy_from_slice(&block.value);
        });
        rows
    }

    /// Number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.blocks.iter().map(|block| block.diagonal.len()).sum()
    }

    /// Calls `visit` for every entry y_i = (A x)_i of the `rows`, which begin with a block, and returns
    /// its sums of each block, added up in order.
    pub(crate) fn multiply<const R: usize, const S: usize>(
        &self,
        rows: Range<usize>,
        x: &[Entry<R>],
        y: &mut [Entry<R>],
        sums: &mut Vec<[Entry<R>; S]>,
        visit: impl Fn(usize, &mut Entry<R>, &mut [Entry<R>; S]) + Sync,
    ) -> [Entry<R>; S] {
        let blocks = rows.start / BLOCK..rows.end.div_ceil(BLOCK);
        sums.resize(blocks.len(), [[0.0; R]; S]);
        y[rows.clone()]
            .par_chunks_mut(BLOCK)
            .zip(sums.par_iter_mut())
            .with_min_len(4)
            .enumerate()
            .for_each(|(block, (y, sum))| {
                *sum = [[0.0; R]; S];
                let first = rows.start + block * BLOCK;
                self.for_rows(first..first + y.len(), |i, row| {
                    let y = &mut y[i - first];
                    *y = row.times(x[i], x);
                    visit(i, y, sum);
                });
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
