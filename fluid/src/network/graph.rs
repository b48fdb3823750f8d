//! The networks outside of the program's own inference: on a frame, for training and tests, and on a step of
//! a run whose network is evaluated elsewhere.

use super::lattice::{self, Coarse, Place, Places};
use super::paper::{self, Links, Paper};
use super::residual::{self, Gates, Level, Residual};
use super::{Network, Weights};
use crate::frame::Frame;
use crate::neighbours::{CellGrid, Neighbours};
use crate::sparse::{Row, Rows, SparseMatrix};
use nalgebra::Point2;
use rayon::prelude::*;

/// A frame as the residual network sees it.
#[derive(Clone, Debug)]
pub struct ResidualGraph {
    /// [`residual::FEATURES`] numbers a particle.
    pub features: Vec<f32>,
    /// What each row was divided by for its unit diagonal.
    pub divisor: Vec<f32>,
    places: Places,
    coarse: Coarse,
}

fn points(frame: &Frame) -> Vec<Point2<f64>> {
    let points = frame.position.as_chunks::<2>().0.iter();
    points.map(|[x, y]| Point2::new(f64::from(*x), f64::from(*y))).collect()
}

fn known(frame: &Frame) -> Vec<bool> {
    frame.on_surface.iter().map(|surface| *surface != 0).collect()
}

/// The matrix of `frame`, the particles' places in a lattice and its coarse equation.
fn levels(frame: &Frame) -> (SparseMatrix, Places, Coarse) {
    let matrix = frame.matrix();
    let position = points(frame);
    let (mut places, mut coarse) = (Places::default(), Coarse::default());
    let spacing = frame.scales.spacing;
    places.find(&position, spacing, lattice::shape(&position, spacing));
    coarse.factorize(&places, &matrix);
    (matrix, places, coarse)
}

impl ResidualGraph {
    /// The graph of `frame`.
    #[must_use]
    pub fn new(frame: &Frame) -> Self {
        let (matrix, places, coarse) = levels(frame);
        let features = |i| residual::features(&matrix, &places, usize::from(frame.walls[i]), i);
        Self {
            features: (0..frame.len()).flat_map(features).collect(),
            divisor: frame.divisor.clone(),
            places,
            coarse,
        }
    }

    /// Its coarse level.
    #[must_use]
    pub fn coarse(&self) -> CoarseLevel<'_> {
        CoarseLevel { places: &self.places, coarse: &self.coarse }
    }
}

/// The coarse level of the residual network, for inference elsewhere.
#[derive(Clone, Copy)]
pub struct CoarseLevel<'a> {
    places: &'a Places,
    coarse: &'a Coarse,
}

impl CoarseLevel<'_> {
    /// Number of nodes c.
    #[must_use]
    pub fn node_count(self) -> usize {
        self.places.shape.nodes()
    }

    /// The four lattice nodes around each particle, 4 n.
    #[must_use]
    pub fn nodes(self) -> Vec<u32> {
        let shape = self.places.shape;
        let nodes = |place: &Place| place.nodes(shape).map(|node| node as u32);
        self.places.place.par_iter().flat_map_iter(nodes).collect()
    }

    /// Their bilinear weights, 4 n.
    #[must_use]
    pub fn weights(self) -> Vec<f32> {
        self.places.place.par_iter().flat_map_iter(|place| place.weights()).collect()
    }

    /// Solves the coarse equation for the right-hand side in `nodes`, c, in place.
    pub fn solve(self, nodes: &mut [f32]) {
        self.coarse.solve(nodes);
    }

    /// Inverse of the coarse equation, c × c, by rows: for training, on frames of moderate size.
    #[must_use]
    pub fn inverse(self) -> Vec<f32> {
        let count = self.node_count();
        let mut transposed = vec![0.0f32; count * count];
        for (node, column) in transposed.chunks_exact_mut(count.max(1)).enumerate() {
            column[node] = 1.0;
            self.solve(column);
        }
        (0..count * count).map(|k| transposed[k % count * count + k / count]).collect()
    }
}

/// A step of a run as the residual network sees it, for inference elsewhere: gates and coarse level may be of
/// some steps back, as in the program's own.
#[derive(Clone, Copy)]
pub struct ResidualStep<'a> {
    level: Level<'a>,
    matrix: &'a SparseMatrix,
    residual: &'a [[f64; 1]],
}

impl<'a> ResidualStep<'a> {
    pub(crate) fn new(
        level: Level<'a>,
        matrix: &'a SparseMatrix,
        residual: &'a [[f64; 1]],
    ) -> Self {
        Self { level, matrix, residual }
    }

    /// Its coarse level.
    #[must_use]
    pub fn coarse(self) -> CoarseLevel<'a> {
        CoarseLevel { places: self.level.places, coarse: self.level.coarse }
    }

    /// Off-diagonal entries of the rows of A.
    #[must_use]
    pub fn rows(self) -> Rows {
        self.matrix.all_rows()
    }

    /// What each row was divided by for its unit diagonal, n.
    #[must_use]
    pub fn divisor(self) -> Vec<f32> {
        (0..self.residual.len()).into_par_iter().map(|i| self.matrix.divisor(i)).collect()
    }

    /// b − A p of the pressure that is to be corrected, Pa, n.
    #[must_use]
    pub fn residual(self) -> Vec<f32> {
        self.residual.par_iter().map(|r| r[0] as f32).collect()
    }

    /// The gates, [`residual::GATES`] a particle.
    #[must_use]
    pub fn gates(self) -> Vec<f32> {
        let used = |gates: &'a Gates| gates.iter().copied().take(residual::GATES);
        self.level.gates.par_iter().flat_map_iter(used).collect()
    }
}

/// A frame as the paper's network sees it.
#[derive(Clone, Debug)]
pub struct PaperGraph {
    /// [`paper::INPUTS`] dimensionless numbers a particle.
    pub inputs: Vec<f32>,
    /// Where each particle's links begin, n + 1.
    pub link_start: Vec<u32>,
    /// The particle at the other end of each link.
    pub link: Vec<u32>,
    /// Weights of the links, Eqs. (23) and (24): they add up to one for each particle.
    pub link_weight: Vec<f32>,
    /// ρ g D, the unit of p_d, Pa.
    pub unit: f32,
    /// p_d of the step before, Pa, n.
    pub last: Vec<f32>,
}

impl PaperGraph {
    /// The graph of `frame`.
    #[must_use]
    pub fn new(frame: &Frame) -> Self {
        let (scales, position) = (frame.scales, points(frame));
        let known = known(frame);
        let elevation = paper::elevations(&position, &known, scales.depth);
        let weight = scales.density * scales.gravity;
        let last: Vec<f64> =
            frame.last.iter().zip(&elevation).map(|(p, y)| f64::from(*p) - weight * y).collect();
        let inputs = (0..frame.len()).flat_map(|i| {
            let velocity = [frame.velocity[2 * i], frame.velocity[2 * i + 1]].map(f64::from);
            paper::inputs(&scales, f64::from(frame.source[i]), velocity, last[i])
        });
        let inputs = inputs.collect();
        let links = links(&position, scales.spacing);
        Self {
            inputs,
            link_start: links.start,
            link: links.column,
            link_weight: links.weight,
            unit: (weight * scales.depth) as f32,
            last: last.iter().map(|p| *p as f32).collect(),
        }
    }
}

fn links(position: &[Point2<f64>], spacing: f64) -> Links {
    let radius = paper::RADIUS * spacing;
    let low = position.iter().fold(Point2::origin(), |low: Point2<f64>, x| low.inf(x));
    let high = position.iter().fold(Point2::origin(), |high: Point2<f64>, x| high.sup(x));
    let mut grid = CellGrid::new(low, high, radius);
    grid.sort(position);
    let mut neighbours = Neighbours::default();
    neighbours.find(position, &grid, radius, |i, j| i != j);
    let mut links = Links::default();
    links.find(position, spacing, |i| neighbours.of(i));
    links
}

impl Network {
    /// The change of the last pressure that the network finds in `frame`, Pa, n.
    #[must_use]
    pub fn correction(&self, frame: &Frame) -> Vec<f32> {
        match &self.0 {
            Weights::Residual(weights) => {
                let (matrix, places, coarse) = levels(frame);
                let walls = |i: usize| usize::from(frame.walls[i]);
                let mut gates = Vec::new();
                weights.all_gates(&matrix, &places, walls, &mut gates);
                let level = Level { places: &places, coarse: &coarse, gates: &gates };
                let residual = |i: usize, _: Row<'_>, _: &[_]| [f64::from(frame.residual[i]), 0.0];
                let mut change = vec![[0.0]; frame.len()];
                Residual::default().correct(level, &matrix, &mut change, residual);
                change.iter().map(|change| change[0] as f32).collect()
            }
            Weights::Paper(weights) => {
                let graph = PaperGraph::new(frame);
                let mut network = Paper::default();
                network.links = Links {
                    start: graph.link_start,
                    column: graph.link,
                    weight: graph.link_weight,
                };
                let inputs = graph.inputs.as_chunks().0;
                let found = network.pressure(weights, |i| inputs[i], frame.len());
                let alone = |i: usize| frame.row_start[i] == frame.row_start[i + 1];
                (found.iter().zip(&graph.last).enumerate())
                    .map(|(i, (found, last))| match alone(i) {
                        true => frame.residual[i],
                        false => found * graph.unit - last,
                    })
                    .collect()
            }
        }
    }
}
