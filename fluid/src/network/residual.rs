//! The residual network: a correction of the last pressure from the residual that it leaves.
//!
//! Its input is r = b − A p, the residual of Eq. (9b) in the last pressure p; its output, added to
//! p, is linear in r. The amplitude path has neither bias nor normalisation, so that spacing, time
//! step, density, gravity and wave height drop out, and the exact pressure is a fixed point. What
//! is learned decides how each particle answers, from the geometry around it: an encoder turns
//! [`FEATURES`] numbers into [`GATES`] gates. Then
//!
//! 1. coarse level: x⁰ = g_P · P (Pᵀ D A P)⁻¹ Pᵀ D (g_R · r), see `lattice`, reaches bed and
//!    far walls at once;
//! 2. fine level: x¹ = x⁰ + g_first r, which takes the residual as it came: what either level is for,
//!    the other hardly sees, and a pass over the matrix is saved. Then message passing on the particle
//!    graph: particle j sends a_ij x¹_j, the operator's own weight, and with the sum m_i of its messages,
//!    its own part included, particle i answers by x_i = x¹_i + g_step (r_i − m_i) + g_again r_i.
//!
//! With gates of one and a constant step this is a two-level correction with two damped Jacobi sweeps.

use super::NetworkError;
use super::lattice::{Around, Coarse, Places};
use super::weights::Tensors;
use crate::neighbours::BLOCK;
use crate::sparse::{Row, SparseMatrix};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Numbers that tell a particle's geometry.
pub const FEATURES: usize = 6;
/// Width of the encoder.
pub const WIDTH: usize = 16;
/// Gates of a particle: to the coarse level, from it, and of its own residual; its step by what its
/// messages leave, and once more of its residual.
pub const GATES: usize = 5;

/// Names and shapes of the tensors, as they are in a weights file.
pub const TENSORS: [(&str, &[usize]); 4] = [
    ("encoder.weight", &[WIDTH, FEATURES]),
    ("encoder.bias", &[WIDTH]),
    ("gates.weight", &[GATES, WIDTH]),
    ("gates.bias", &[GATES]),
];

/// Gates before training: steps for the part of the spectrum above the lattice's.
pub const INITIAL_GATES: [f32; GATES] = [1.0, 1.0, 0.5, 0.8, 0.0];

/// Gates of a particle, and some that are not used: rows of eight are quicker.
pub(crate) type Gates = [f32; 8];

/// The weights, a row for each input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ResidualWeights {
    encoder: Vec<[f32; WIDTH]>,
    encoder_bias: [f32; WIDTH],
    gates: Vec<Gates>,
    gates_bias: Gates,
}

impl ResidualWeights {
    pub(crate) fn new(tensors: &Tensors) -> Result<Self, NetworkError> {
        let [encoder, encoder_bias, gates, gates_bias] = tensors.take(TENSORS)?;
        let gate =
            |k: usize, values: &dyn Fn(usize) -> f32| if k < GATES { values(k) } else { 0.0 };
        Ok(Self {
            encoder: (0..FEATURES)
                .map(|input| std::array::from_fn(|k| encoder[k * FEATURES + input]))
                .collect(),
            encoder_bias: std::array::from_fn(|k| encoder_bias[k]),
            gates: (0..WIDTH)
                .map(|input| std::array::from_fn(|k| gate(k, &|k| gates[k * WIDTH + input])))
                .collect(),
            gates_bias: std::array::from_fn(|k| gate(k, &|k| gates_bias[k])),
        })
    }

    /// The gates of a particle.
    #[inline(always)]
    fn gates(&self, features: [f32; FEATURES]) -> Gates {
        let mut hidden = self.encoder_bias;
        for (row, feature) in self.encoder.iter().zip(features) {
            for (hidden, weight) in hidden.iter_mut().zip(row) {
                *hidden += weight * feature;
            }
        }
        let mut gates = self.gates_bias;
        for (row, hidden) in self.gates.iter().zip(hidden) {
            let hidden = hidden.max(0.0);
            for (gate, weight) in gates.iter_mut().zip(row) {
                *gate += weight * hidden;
            }
        }
        gates
    }

    /// The gates of all particles.
    pub(crate) fn all_gates(
        &self,
        matrix: &SparseMatrix,
        places: &Places,
        walls: impl Fn(usize) -> usize + Sync,
        gates: &mut Vec<Gates>,
    ) {
        gates.resize(places.place.len(), Gates::default());
        gates.par_chunks_mut(BLOCK).enumerate().for_each(|(block, gates)| {
            for (offset, gates) in gates.iter_mut().enumerate() {
                let i = block * BLOCK + offset;
                *gates = self.gates(features(matrix, places, walls(i), i));
            }
        });
    }
}

/// What the network is told of particle `i`, all of it without dimension: how far its row's sum is
/// from nought (the surface is near), walls nearby, two measures of irregularity, and where it
/// stands between the nodes of the lattice.
#[inline(always)]
pub(crate) fn features(
    matrix: &SparseMatrix,
    places: &Places,
    walls: usize,
    i: usize,
) -> [f32; FEATURES] {
    let (_, values) = matrix.row(i);
    let (mut sum, mut size, mut square) = (0.0f32, 0.0f32, 0.0f32);
    for &a in values {
        sum += a;
        size += a.abs();
        square += a * a;
    }
    let place = places.place[i];
    let bubble = |x: f32| 4.0 * x * (1.0 - x);
    [
        1.0 + sum,
        0.125 * walls as f32,
        size - 1.0,
        10.0 * (square - 0.1),
        bubble(place.x),
        bubble(place.y),
    ]
}

/// Rows that follow each other and are worked off together: small enough for what is fetched for them to
/// stay at hand, many enough for few others to be fetched.
const SLAB: usize = 16 * BLOCK;

/// The network at work.
#[derive(Clone, Debug, Default)]
pub(crate) struct Residual {
    r: Vec<f32>,
    nodes: Vec<f32>,
    slabs: Vec<Slab>,
}

/// What belongs to a slab of rows.
#[derive(Clone, Debug, Default)]
struct Slab {
    /// What its particles send to the coarse level, and what comes of it there.
    sent: Vec<f32>,
    around: Around,
    /// What particles around send: values before the messages.
    x: Vec<f32>,
    squares: Squares,
}

/// Sums of squares, Pa².
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Squares {
    /// Of the residual.
    pub(crate) residual: f64,
    /// Of the right-hand side.
    pub(crate) rhs: f64,
    /// Of the residual that was left before the messages.
    pub(crate) left: f64,
}

/// The coarse level of a step, and the gates that were found with it.
#[derive(Clone, Copy)]
pub(crate) struct Level<'a> {
    /// Where the particles stand in its lattice.
    pub(crate) places: &'a Places,
    pub(crate) coarse: &'a Coarse,
    /// Of each particle.
    pub(crate) gates: &'a [Gates],
}

/// What the levels work on.
#[derive(Clone, Copy)]
struct Levels<'a> {
    level: Level<'a>,
    /// What the coarse level found.
    nodes: &'a [f32],
    matrix: &'a SparseMatrix,
    r: &'a [f32],
}

impl Residual {
    /// Adds the correction for `matrix` to the `pressure`, Pa. `residual` gives the residual that a row
    /// leaves in it, and the right-hand side, Pa. A row that stands alone, as those of the surface do, is
    /// corrected by its residual.
    pub(crate) fn correct(
        &mut self,
        level: Level<'_>,
        matrix: &SparseMatrix,
        pressure: &mut [[f64; 1]],
        residual: impl Fn(usize, Row<'_>, &[[f64; 1]]) -> [f64; 2] + Sync,
    ) -> Squares {
        let Level { places, coarse, gates } = level;
        let n = gates.len();
        self.r.resize(n, 0.0);
        self.slabs.resize_with(n.div_ceil(SLAB), Slab::default);
        let slabs = self.r.par_chunks_mut(SLAB).zip(&mut self.slabs);
        let last = &*pressure;
        slabs.enumerate().for_each(|(index, (r, slab))| {
            let first = index * SLAB;
            slab.squares = Squares::default();
            slab.sent.clear();
            matrix.for_rows(first..first + r.len(), |i, row| {
                let [residual, rhs] = residual(i, row, last);
                slab.squares.residual += residual * residual;
                slab.squares.rhs += rhs * rhs;
                r[i - first] = residual as f32;
                slab.sent.push(match row.stands_alone() {
                    true => 0.0,
                    false => row.divisor * gates[i][0] * residual as f32,
                });
            });
            places.restrict(first, &slab.sent, &mut slab.around);
        });
        self.nodes.clear();
        self.nodes.resize(places.shape.nodes(), 0.0);
        for slab in &self.slabs {
            slab.around.add_to(&mut self.nodes);
        }
        coarse.solve(&mut self.nodes);
        let levels = Levels { level, nodes: &self.nodes, matrix, r: &self.r };
        let slabs = pressure.par_chunks_mut(SLAB).zip(&mut self.slabs);
        slabs.enumerate().for_each(|(index, (pressure, slab))| {
            slab.work(levels, index * SLAB, pressure);
        });
        self.slabs.iter().fold(Squares::default(), |sum, slab| Squares {
            residual: sum.residual + slab.squares.residual,
            rhs: sum.rhs + slab.squares.rhs,
            left: sum.left + slab.squares.left,
        })
    }
}

impl Slab {
    /// Both levels for the rows from `first` on that `pressure` is of, to which what they find is added.
    fn work(&mut self, levels: Levels<'_>, first: usize, pressure: &mut [[f64; 1]]) {
        let Levels { level: Level { places, gates, .. }, nodes, matrix, r } = levels;
        let rows = first..first + pressure.len();
        let around = matrix.reach(rows.clone());
        let low = around.start;
        let Self { x, squares, .. } = self;
        x.clear();
        matrix.for_rows(around, |i, row| {
            x.push(match row.stands_alone() {
                true => r[i],
                false => gates[i][1] * places.interpolate(i, nodes) + gates[i][2] * r[i],
            });
        });
        matrix.for_rows(rows, |i, row| {
            let (own, [_, _, _, step, again, ..]) = (x[i - low], gates[i]);
            let change = if row.stands_alone() {
                own
            } else {
                let left = r[i] - row.times_single(own, x, low);
                squares.left += f64::from(left) * f64::from(left);
                own + step * left + again * r[i]
            };
            pressure[i - first][0] += f64::from(change);
        });
    }
}
