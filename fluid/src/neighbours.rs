//! Neighbour search: a uniform grid of cells and, for each block of particles, lists of those
//! within a radius.

use nalgebra::Point2;
use rayon::prelude::*;
use std::ops::Range;

/// Particles that one task treats. Blocks, not threads, cut the work and the sums, so that
/// results do not depend on the number of threads.
pub(crate) const BLOCK: usize = 256;

/// Fewest particles of a task in a loop that does next to nothing for each.
pub(crate) const MANY: usize = 4 * BLOCK;

/// Candidates whose distances are found together.
const AT_ONCE: usize = 32;

/// Points sorted into square cells.
#[derive(Clone, Debug, Default)]
pub(crate) struct CellGrid {
    origin: Point2<f64>,
    inverse_size: f64,
    columns: usize,
    rows: usize,
    /// First entry of each cell in `points`; one more than there are cells.
    start: Vec<u32>,
    points: Vec<u32>,
    /// Coordinates of the `points`, m.
    x: Vec<f64>,
    y: Vec<f64>,
    cell_of: Vec<u32>,
}

impl CellGrid {
    /// A grid over the rectangle from `low` to `high` with cells of `size` (m). Points outside
    /// count to the nearest cell.
    pub(crate) fn new(low: Point2<f64>, high: Point2<f64>, size: f64) -> Self {
        let cells = |length: f64| ((length / size).ceil() as usize).max(1);
        Self {
            origin: low,
            inverse_size: 1.0 / size,
            columns: cells(high.x - low.x),
            rows: cells(high.y - low.y),
            ..Self::default()
        }
    }

    fn cell_at(&self, point: &Point2<f64>) -> (usize, usize) {
        // A float cast saturates, so a point outside (or NaN) falls into a border cell.
        let index =
            |offset: f64, count: usize| ((offset * self.inverse_size) as usize).min(count - 1);
        (index(point.x - self.origin.x, self.columns), index(point.y - self.origin.y, self.rows))
    }

    /// Sorts `points` into the cells.
    pub(crate) fn sort(&mut self, points: &[Point2<f64>]) {
        let mut cell_of = std::mem::take(&mut self.cell_of);
        cell_of.resize(points.len(), 0);
        cell_of.par_chunks_mut(BLOCK).zip(points.par_chunks(BLOCK)).for_each(|(cells, points)| {
            for (cell, point) in cells.iter_mut().zip(points) {
                let (column, row) = self.cell_at(point);
                *cell = (column * self.rows + row) as u32;
            }
        });
        self.start.clear();
        self.start.resize(self.columns * self.rows + 1, 0);
        for &cell in &cell_of {
            self.start[cell as usize + 1] += 1;
        }
        for cell in 1..self.start.len() {
            self.start[cell] += self.start[cell - 1];
        }
        self.points.resize(points.len(), 0);
        self.x.resize(points.len(), 0.0);
        self.y.resize(points.len(), 0.0);
        // Filled from the back, so that each cell lists its points in rising order.
        for (point, &cell) in cell_of.iter().enumerate().rev() {
            let end = &mut self.start[cell as usize + 1];
            *end -= 1;
            let entry = *end as usize;
            self.points[entry] = point as u32;
            self.x[entry] = points[point].x;
            self.y[entry] = points[point].y;
        }
        // Each `start[cell + 1]` now is the first entry of `cell`: shift down by one.
        self.start.rotate_left(1);
        if let Some(last) = self.start.last_mut() {
            *last = points.len() as u32;
        }
        self.cell_of = cell_of;
    }

    /// Where `points` has those in the cells that touch the square of half-width one cell around
    /// `centre`, column by column: all points within one cell size are among them.
    #[inline(always)]
    fn candidates(&self, centre: &Point2<f64>) -> impl Iterator<Item = Range<usize>> {
        let (column, row) = self.cell_at(centre);
        let rows = row.saturating_sub(1)..(row + 2).min(self.rows);
        (column.saturating_sub(1)..(column + 2).min(self.columns)).map(move |column| {
            let first = self.start[column * self.rows + rows.start] as usize;
            let last = self.start[column * self.rows + rows.end] as usize;
            first..last
        })
    }
}

/// Lists of neighbours of a block of points.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lists {
    start: Vec<u32>,
    index: Vec<u32>,
}

impl Lists {
    /// Starts anew.
    fn clear(&mut self) {
        self.start.clear();
        self.start.push(0);
        self.index.clear();
    }

    /// Adds the list of the points of `grid` within `radius` of `centre` for which `keep` holds.
    #[inline(always)]
    fn add(
        &mut self,
        grid: &CellGrid,
        centre: &Point2<f64>,
        radius: f64,
        keep: impl Fn(usize) -> bool,
    ) {
        let mut distance2 = [0.0; AT_ONCE];
        let mut near = [0; AT_ONCE];
        for candidates in grid.candidates(centre) {
            for first in candidates.clone().step_by(AT_ONCE) {
                let some = first..candidates.end.min(first + AT_ONCE);
                let places = grid.x[some.clone()].iter().zip(&grid.y[some.clone()]);
                for (distance2, (x, y)) in distance2.iter_mut().zip(places) {
                    let (x, y) = (x - centre.x, y - centre.y);
                    *distance2 = x * x + y * y;
                }
                // Each is written, over the last one if that was not kept: a branch would often be
                // foreseen wrongly. The remainder changes nothing and spares a check.
                let mut count = 0;
                for (&point, distance2) in grid.points[some].iter().zip(&distance2) {
                    near[count % AT_ONCE] = point;
                    count += usize::from((*distance2 < radius * radius) & keep(point as usize));
                }
                self.index.extend_from_slice(&near[..count]);
            }
        }
        self.start.push(self.index.len() as u32);
    }

    /// Keeps those entries for which `keep(local, neighbour)` holds.
    fn retain(&mut self, keep: impl Fn(usize, usize) -> bool) {
        let (mut from, mut kept) = (0, 0);
        for local in 0..self.start.len().saturating_sub(1) {
            let end = self.start[local + 1] as usize;
            for entry in from..end {
                let neighbour = self.index[entry];
                if keep(local, neighbour as usize) {
                    self.index[kept] = neighbour;
                    kept += 1;
                }
            }
            self.start[local + 1] = kept as u32;
            from = end;
        }
        self.index.truncate(kept);
    }

    /// Where the list of the block's point `local` is among all.
    #[inline(always)]
    pub(crate) fn range(&self, local: usize) -> Range<usize> {
        self.start[local] as usize..self.start[local + 1] as usize
    }

    /// Length of all lists together.
    pub(crate) fn len(&self) -> usize {
        self.index.len()
    }

    /// The list of the block's point `local`.
    #[inline(always)]
    pub(crate) fn of(&self, local: usize) -> &[u32] {
        &self.index[self.range(local)]
    }
}

/// The search for the lists of a block.
struct Search<'a, F> {
    lists: &'a mut Lists,
    centres: &'a [Point2<f64>],
    block: usize,
    grid: &'a CellGrid,
    radius: f64,
    keep: &'a F,
}

impl<F: Fn(usize, usize) -> bool> pulp::NullaryFnOnce for Search<'_, F> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let Self { lists, centres, block, grid, radius, keep } = self;
        lists.clear();
        for (own, centre) in (block * BLOCK..).zip(centres) {
            lists.add(grid, centre, radius, |point| keep(own, point));
        }
    }
}

/// Neighbour lists of all points, a block at a time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Neighbours {
    pub(crate) blocks: Vec<Lists>,
}

impl Neighbours {
    /// Finds, for each of `centres`, the points that are sorted into `grid` within `radius` (at most its
    /// cell size) for which `keep(centre, point)` holds, which all candidates are asked for.
    pub(crate) fn find(
        &mut self,
        centres: &[Point2<f64>],
        grid: &CellGrid,
        radius: f64,
        keep: impl Fn(usize, usize) -> bool + Sync,
    ) {
        self.blocks.resize_with(centres.len().div_ceil(BLOCK), Lists::default);
        // With the widest instructions that the processor has.
        let arch = pulp::Arch::new();
        let blocks = self.blocks.par_iter_mut().zip(centres.par_chunks(BLOCK)).enumerate();
        blocks.for_each(|(block, (lists, centres))| {
            arch.dispatch(Search { lists, centres, block, grid, radius, keep: &keep });
        });
    }

    /// Keeps those neighbours for which `keep(centre, other)` holds.
    pub(crate) fn retain(&mut self, keep: impl Fn(usize, usize) -> bool + Sync) {
        self.blocks.par_iter_mut().enumerate().for_each(|(block, lists)| {
            lists.retain(|local, neighbour| keep(block * BLOCK + local, neighbour));
        });
    }

    /// Number of neighbours of point `i`; `None` for one that no search has seen.
    pub(crate) fn count(&self, i: usize) -> Option<usize> {
        let lists = self.blocks.get(i / BLOCK)?;
        (i % BLOCK + 1 < lists.start.len()).then(|| lists.of(i % BLOCK).len())
    }

    /// The list of point `i`.
    #[inline(always)]
    pub(crate) fn of(&self, i: usize) -> &[u32] {
        self.blocks[i / BLOCK].of(i % BLOCK)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_what_a_search_over_all_pairs_finds() {
        // A deterministic scatter, some of it outside the grid.
        let points: Vec<_> = (0..700)
            .map(|i| {
                let i = f64::from(i);
                Point2::new(
                    (i * 0.618_034).fract() * 2.2 - 0.1,
                    (i * 0.414_214).fract() * 1.2 - 0.1,
                )
            })
            .collect();
        let mut neighbours = Neighbours::default();
        // The wider radius has more candidates in a column than are looked at at once.
        for (radius, most) in [(0.1, 1..=AT_ONCE), (0.3, AT_ONCE + 1..=points.len())] {
            let mut grid = CellGrid::new(Point2::origin(), Point2::new(2.0, 1.0), 1.1 * radius);
            grid.sort(&points);
            neighbours.find(&points, &grid, radius, |i, j| i != j);
            let column = points.iter().flat_map(|x| grid.candidates(x)).map(|range| range.len());
            assert!(most.contains(&column.max().unwrap_or(0)), "{most:?}");
            for (i, a) in points.iter().enumerate() {
                let mut found = neighbours.of(i).to_vec();
                found.sort_unstable();
                let all: Vec<u32> = (0..points.len())
                    .filter(|&j| j != i && (points[j] - a).norm() < radius)
                    .map(|j| j as u32)
                    .collect();
                assert_eq!(found, all, "point {i}");
            }
        }
        let all = neighbours.clone();
        neighbours.retain(|i, j| i % 3 > 0 && j % 5 > 0);
        for i in 0..points.len() {
            let kept = all.of(i).iter().filter(|j| i % 3 > 0 && *j % 5 > 0);
            assert!(neighbours.of(i).iter().eq(kept), "point {i}");
        }
    }
}
