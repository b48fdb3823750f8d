//! The coarse level of the residual network: a lattice of nodes a few spacings apart, between
//! which values are interpolated bilinearly, and the pressure equation on it.
//!
//! The coarse equation is the Galerkin product Pᵀ D A P of the fine one with the interpolation P, so
//! that surface, walls and bodies are in it without being named. D takes back what the rows of A
//! were divided by: rows of the Laplacian itself, one a particle and so one a volume, add up to the
//! fluxes through the boundary. Rows of unit diagonal do not where diagonals differ, at walls and
//! most in corners; what is amiss there weighs more the longer the longest mode, whose own
//! eigenvalue falls as (dx/D)², and at sixty spacings over the depth had turned its sign. It is banded, the nodes being
//! numbered up each column, and solved by factors without pivoting; its cost grows as N (D/dx)²/16²
//! where that of everything else grows as N.

use crate::neighbours::BLOCK;
use crate::particles::permute;
use crate::sparse::SparseMatrix;
use nalgebra::Point2;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Distance between nodes in particle spacings.
pub(crate) const SPACINGS: f64 = 4.0;
/// Least diagonal of a node's equation, over the mean of all; a smaller one is raised to it.
pub(crate) const LEAST_DIAGONAL: f64 = 0.15;
/// Nodes around a cell that its particles' equations reach, in each direction.
const REACH: usize = 4;
/// Entries of the equations of a cell's four nodes.
const CELL: usize = 4 * REACH * REACH;

/// Nodes of a lattice: `columns` by `rows`, the lowest half a cell below the bed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Shape {
    /// Where the first column stands, in cells from x = −½ cell: a paddle takes water to x < 0.
    pub(crate) first: i32,
    pub(crate) columns: usize,
    pub(crate) rows: usize,
}

impl Shape {
    /// Number of nodes.
    pub(crate) fn nodes(self) -> usize {
        self.columns * self.rows
    }

    /// Largest distance of the numbers of two nodes in one equation.
    fn band(self) -> usize {
        2 * self.rows + 2
    }
}

/// Where a particle stands in the lattice: its cell's lowest node, and the part of the way to the
/// next in each direction.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Place {
    pub(crate) column: u32,
    pub(crate) row: u32,
    pub(crate) x: f32,
    pub(crate) y: f32,
}

impl Place {
    fn of(point: Point2<f64>, spacing: f64, shape: Shape) -> Self {
        let along = |x: f64, first: i32, nodes: usize| {
            let s = (x / (SPACINGS * spacing) + 0.5 - f64::from(first)).max(0.0);
            let cell = (s as usize).min(nodes - 2);
            (cell as u32, (s - cell as f64).min(1.0) as f32)
        };
        let (column, x) = along(point.x, shape.first, shape.columns);
        let (row, y) = along(point.y, 0, shape.rows);
        Self { column, row, x, y }
    }

    /// Bilinear weights of the nodes (0, 0), (0, 1), (1, 0), (1, 1) of the cell.
    #[inline(always)]
    pub(crate) fn weights(self) -> [f32; 4] {
        let (x, y) = (self.x, self.y);
        [(1.0 - x) * (1.0 - y), (1.0 - x) * y, x * (1.0 - y), x * y]
    }

    /// The nodes of the cell.
    #[inline(always)]
    pub(crate) fn nodes(self, shape: Shape) -> [usize; 4] {
        let first = self.column as usize * shape.rows + self.row as usize;
        [first, first + 1, first + shape.rows, first + shape.rows + 1]
    }
}

/// Where the particles stand in a lattice.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Places {
    pub(crate) shape: Shape,
    /// Place of each particle.
    pub(crate) place: Vec<Place>,
}

/// The shape of a lattice that holds the particles at `position`.
pub(crate) fn shape(position: &[Point2<f64>], spacing: f64) -> Shape {
    let high = position.iter().fold((0.0f64, 0.0f64), |(x, y), p| (x.max(p.x), y.max(p.y)));
    let low = position.iter().fold(high.0, |x, p| x.min(p.x));
    let cell = |length: f64| (length / (SPACINGS * spacing) + 0.5).floor() as i32;
    let first = cell(low);
    let nodes = |cells: i32| cells.max(0) as usize + 2;
    // Spray far away must not make the lattice larger than the water is.
    let columns = nodes(cell(high.0).saturating_sub(first)).min(position.len() / 4 + 4);
    let rows = nodes(cell(high.1)).min(position.len() / (2 * columns) + 4);
    Shape { first, columns, rows }
}

impl Places {
    /// Places the particles at `position` in a lattice of this `shape`; one that is outside counts to
    /// the nearest cell.
    pub(crate) fn find(&mut self, position: &[Point2<f64>], spacing: f64, shape: Shape) {
        self.shape = shape;
        self.place.resize(position.len(), Place::default());
        self.place.par_chunks_mut(BLOCK).zip(position.par_chunks(BLOCK)).for_each(|(place, x)| {
            for (place, x) in place.iter_mut().zip(x) {
                *place = Place::of(*x, spacing, shape);
            }
        });
    }

    /// One more particle, at `position`.
    pub(crate) fn add(&mut self, position: Point2<f64>, spacing: f64) {
        self.place.push(Place::of(position, spacing, self.shape));
    }

    /// The new i-th particle is the old `order[i]`-th and keeps its place.
    pub(crate) fn renumber(&mut self, order: &[u32]) {
        permute(&mut self.place, order, &mut Vec::new());
    }

    /// Pᵀ v of the particles from `first` on, whose values are `value`: for each node around the sum of a
    /// particle's value times its weight.
    pub(crate) fn restrict(&self, first: usize, value: &[f32], around: &mut Around) {
        let (shape, places) = (self.shape, &self.place[first..first + value.len()]);
        let columns = places.iter().map(|place| place.column as usize);
        let (low, high) = columns.fold((usize::MAX, 0), |(low, high), c| (low.min(c), high.max(c)));
        around.first = low.min(high) * shape.rows;
        around.sums.clear();
        around.sums.resize((high + 2) * shape.rows - around.first, 0.0);
        for (place, value) in places.iter().zip(value) {
            for (node, weight) in place.nodes(shape).into_iter().zip(place.weights()) {
                around.sums[node - around.first] += weight * value;
            }
        }
    }

    /// (P c)_i at particle `i`.
    #[inline(always)]
    pub(crate) fn interpolate(&self, i: usize, coarse: &[f32]) -> f32 {
        let place = self.place[i];
        let nodes = place.nodes(self.shape);
        let weights = place.weights();
        (0..4).map(|k| weights[k] * coarse[nodes[k]]).sum()
    }
}

/// Sums for the nodes around some particles, from node `first` on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Around {
    first: usize,
    sums: Vec<f32>,
}

impl Around {
    /// Adds the sums to those of the whole lattice.
    pub(crate) fn add_to(&self, nodes: &mut [f32]) {
        for (node, sum) in nodes[self.first..].iter_mut().zip(&self.sums) {
            *node += sum;
        }
    }
}

/// The particles of each cell, in rising order.
struct Cells {
    start: Vec<u32>,
    particles: Vec<u32>,
}

impl Cells {
    fn new(places: &Places) -> Self {
        let shape = places.shape;
        let cell = |place: &Place| place.column as usize * shape.rows + place.row as usize;
        let mut start = vec![0u32; shape.nodes() + 1];
        for place in &places.place {
            start[cell(place) + 1] += 1;
        }
        for cell in 1..start.len() {
            start[cell] += start[cell - 1];
        }
        let mut particles = vec![0; places.place.len()];
        // Filled from the back, so that each cell lists its particles in rising order.
        for (particle, place) in places.place.iter().enumerate().rev() {
            let end = &mut start[cell(place) + 1];
            *end -= 1;
            particles[*end as usize] = particle as u32;
        }
        start.rotate_left(1);
        if let Some(last) = start.last_mut() {
            *last = particles.len() as u32;
        }
        Self { start, particles }
    }

    fn of(&self, cell: usize) -> &[u32] {
        &self.particles[self.start[cell] as usize..self.start[cell + 1] as usize]
    }
}

/// Factors of the coarse equation.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Coarse {
    pub(crate) shape: Shape,
    /// For each node its row of the band, lower factors first, the diagonal's inverse in the
    /// middle.
    factors: Vec<f32>,
}

impl Coarse {
    /// Assembles Pᵀ D A P for the particles at these `places` and factorizes it. Rows that stand alone are
    /// not in it.
    pub(crate) fn factorize(&mut self, places: &Places, matrix: &SparseMatrix) {
        let (shape, cells) = (places.shape, Cells::new(places));
        let mut weights = vec![Weights::default(); places.place.len()];
        weights.par_chunks_mut(BLOCK).enumerate().for_each(|(block, weights)| {
            for (offset, weights) in weights.iter_mut().enumerate() {
                let i = block * BLOCK + offset;
                if !matrix.stands_alone(i) {
                    *weights = places.place[i].weights();
                }
            }
        });
        let mut blocks = vec![[0.0f64; CELL]; shape.nodes()];
        blocks.par_iter_mut().with_min_len(16).enumerate().for_each(|(cell, block)| {
            let corner = ((cell / shape.rows) as u32, (cell % shape.rows) as u32);
            for &i in cells.of(cell) {
                add_row(&places.place, &weights, matrix, corner, i as usize, block);
            }
        });
        let (n, band) = (shape.nodes(), shape.band());
        let width = 2 * band + 1;
        let mut rows = vec![0.0f64; n * width];
        for (cell, block) in blocks.iter().enumerate() {
            let (column, row) = (cell / shape.rows, cell % shape.rows);
            if column + 1 == shape.columns || row + 1 == shape.rows {
                continue;
            }
            for (own, entries) in block.chunks_exact(REACH * REACH).enumerate() {
                let node = (column + own / 2) * shape.rows + row + own % 2;
                for (k, value) in entries.iter().enumerate().filter(|(_, value)| **value != 0.0) {
                    // The window begins one node below the cell.
                    let other = (column + k / REACH) * shape.rows + row + k % REACH;
                    rows[node * width + band + other - (shape.rows + 1) - node] += value;
                }
            }
        }
        self.shape = shape;
        eliminate(&mut rows, n, band);
        self.factors.clear();
        self.factors.extend(rows.iter().map(|&value| value as f32));
    }

    /// Solves the coarse equation in place.
    pub(crate) fn solve(&self, values: &mut [f32]) {
        let (n, band) = (self.shape.nodes(), self.shape.band());
        let width = 2 * band + 1;
        for i in 0..n {
            let from = band.saturating_sub(i);
            let row = &self.factors[i * width + from..i * width + band];
            values[i] -= product(row, &values[i + from - band..i]);
        }
        for i in (0..n).rev() {
            let to = band.min(n - 1 - i);
            let row = &self.factors[i * width + band..i * width + band + 1 + to];
            values[i] = (values[i] - product(&row[1..], &values[i + 1..=i + to])) * row[0];
        }
    }
}

/// Σ a x, in sums side by side, so that none waits for another.
fn product(a: &[f32], x: &[f32]) -> f32 {
    let mut sums = [0.0f32; 8];
    let (a, last_a) = a.as_chunks::<8>();
    let (x, last_x) = x.as_chunks::<8>();
    for (a, x) in a.iter().zip(x) {
        for lane in 0..8 {
            sums[lane] += a[lane] * x[lane];
        }
    }
    let last: f32 = last_a.iter().zip(last_x).map(|(a, x)| a * x).sum();
    sums.iter().sum::<f32>() + last
}

/// Weights of the nodes of a particle's cell where its own row is in the coarse equation, else nought.
type Weights = [f32; 4];

/// Adds Pᵢᵀ dᵢ (A P)ᵢ of particle `i` in the cell at `corner` to the cell's block of equations.
#[inline(always)]
fn add_row(
    place: &[Place],
    weights: &[Weights],
    matrix: &SparseMatrix,
    corner: (u32, u32),
    i: usize,
    block: &mut [f64; CELL],
) {
    // By the cell that a neighbour is in, of three by three: it is less than a cell away.
    // Two sums of each, so that a neighbour need not wait for the one before.
    let mut parts = [[[0.0f32; 4]; 12]; 2];
    let mut add = |i: usize, value: f32, turn: usize| {
        let column = (place[i].column + 1).wrapping_sub(corner.0) as usize;
        let row = (place[i].row + 1).wrapping_sub(corner.1) as usize;
        if column < 3 && row < 3 {
            for (part, weight) in parts[turn][column * 4 + row].iter_mut().zip(weights[i]) {
                *part += value * weight;
            }
        }
    };
    add(i, 1.0, 0);
    let (columns, values) = matrix.row(i);
    for (k, (&j, &value)) in columns.iter().zip(values).enumerate() {
        add(j as usize, value, k % 2);
    }
    let mut reached = [0.0f32; REACH * REACH];
    for (first, (even, odd)) in parts[0].iter().zip(&parts[1]).enumerate() {
        if first % REACH < 3 {
            for k in 0..4 {
                reached[first + k / 2 * REACH + k % 2] += even[k] + odd[k];
            }
        }
    }
    let divisor = matrix.divisor(i);
    for (entries, weight) in block.chunks_exact_mut(REACH * REACH).zip(weights[i]) {
        let weight = divisor * weight;
        for (entry, value) in entries.iter_mut().zip(&reached) {
            *entry += f64::from(weight * value);
        }
    }
}

/// LU factors of a banded matrix in place, without pivoting; the diagonal becomes its inverse. A
/// node that few particles are near, under the surface or at a paddle, has an equation of next to
/// nothing, and water that comes to it while the factors last would be answered with too large a
/// pressure, the more so from step to step: its diagonal is raised. A node without any has none.
fn eliminate(rows: &mut [f64], n: usize, band: usize) {
    let width = 2 * band + 1;
    let diagonals = || rows.chunks_exact(width).map(|row| row[band]).filter(|d| *d > 0.0);
    let least = LEAST_DIAGONAL * diagonals().sum::<f64>() / diagonals().count().max(1) as f64;
    let near: Vec<bool> = rows.chunks_exact(width).map(|row| row[band] > 0.0).collect();
    for row in rows.chunks_exact_mut(width) {
        row[band] = row[band].max(least);
    }
    for i in 0..n {
        let inverse = if near[i] { 1.0 / rows[i * width + band] } else { 0.0 };
        rows[i * width + band] = inverse;
        let (done, rest) = rows.split_at_mut((i + 1) * width);
        let pivot = &done[i * width + band + 1..];
        for (below, row) in rest.chunks_exact_mut(width).take(band).enumerate() {
            let at = band - 1 - below;
            let factor = row[at] * inverse;
            row[at] = factor;
            if factor != 0.0 {
                for (value, pivot) in row[at + 1..].iter_mut().zip(pivot) {
                    *value -= factor * pivot;
                }
            }
        }
    }
}
