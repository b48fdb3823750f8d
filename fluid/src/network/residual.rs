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
//! 2. fine level: [`LAYERS`] layers. The first goes with the coarse level and takes the residual as it
//!    came, x¹ = x⁰ + g_step r: what either is for, the other hardly sees, and a pass over the matrix is
//!    saved. The others are message passing on the particle graph. Particle j sends a_ij x_j, the
//!    operator's own weight, and with the sum m_i of its messages, its own part included, particle i goes on
//!    by x_i ← x_i + g_step (r_i − m_i) + g_carry (x_i − x_i before).
//!
//! With gates of one and a constant step this is a two-level correction with damped Jacobi sweeps.

use super::NetworkError;
use super::lattice::{Around, Coarse, Places};
use super::weights::Tensors;
use crate::neighbours::BLOCK;
use crate::sparse::{Row, SparseMatrix};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Layers of the fine level.
pub const LAYERS: usize = 3;
/// Numbers that tell a particle's geometry.
pub const FEATURES: usize = 6;
/// Width of the encoder.
pub const WIDTH: usize = 16;
/// Gates of a particle: to the coarse level, from it, a step for each layer, and from the second
/// layer on how much of the last change is carried on.
pub const GATES: usize = 2 + LAYERS + (LAYERS - 1);

/// Names and shapes of the tensors, as they are in a weights file.
pub const TENSORS: [(&str, &[usize]); 4] = [
    ("encoder.weight", &[WIDTH, FEATURES]),
    ("encoder.bias", &[WIDTH]),
    ("gates.weight", &[GATES, WIDTH]),
    ("gates.bias", &[GATES]),
];

/// Gates before training: Chebyshev steps for the part of the spectrum above the lattice's, found
/// on a regular arrangement.
pub const INITIAL_GATES: [f32; GATES] = [1.0, 1.0, 0.45, 0.6, 1.1, 0.0, 0.0];

/// Gates of a particle, and one that is not used: rows of eight are quicker.
pub(crate) type Gates = [f32; GATES + 1];

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
        gates.resize(places.place.len(), [0.0; GATES + 1]);
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
    /// Values of the layers of messages around.
    x: Vec<f32>,
    before: Vec<f32>,
    next: Vec<f32>,
    squares: Squares,
}

/// Sums of squares, Pa².
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Squares {
    /// Of the residual.
    pub(crate) residual: f64,
    /// Of the right-hand side.
    pub(crate) rhs: f64,
    /// Of the residual that was left before the last layer.
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

/// What the layers work on.
#[derive(Clone, Copy)]
struct Layers<'a> {
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
        let layers = Layers { level, nodes: &self.nodes, matrix, r: &self.r };
        let slabs = pressure.par_chunks_mut(SLAB).zip(&mut self.slabs);
        slabs.enumerate().for_each(|(index, (pressure, slab))| {
            slab.work(layers, index * SLAB, pressure);
        });
        self.slabs.iter().fold(Squares::default(), |sum, slab| Squares {
            residual: sum.residual + slab.squares.residual,
            rhs: sum.rhs + slab.squares.rhs,
            left: sum.left + slab.squares.left,
        })
    }
}

impl Slab {
    /// All layers for the rows from `first` on that `pressure` is of, to which what they find is added. A
    /// layer is worked off for as many rows around as the next one reaches.
    fn work(&mut self, layers: Layers<'_>, first: usize, pressure: &mut [[f64; 1]]) {
        let Layers { level: Level { places, gates, .. }, nodes, matrix, r } = layers;
        let mut ranges: [Range<usize>; LAYERS] =
            std::array::from_fn(|_| first..first + pressure.len());
        for layer in (1..LAYERS).rev() {
            ranges[layer - 1] = matrix.reach(ranges[layer].clone());
        }
        let low = ranges[0].start;
        self.x.clear();
        matrix.for_rows(ranges[0].clone(), |i, row| {
            self.x.push(match row.stands_alone() {
                true => r[i],
                false => gates[i][1] * places.interpolate(i, nodes) + gates[i][2] * r[i],
            });
        });
        self.before.resize(self.x.len(), 0.0);
        self.next.resize(self.x.len(), 0.0);
        for layer in 1..LAYERS {
            let Self { x, before, next, squares, .. } = self;
            squares.left = 0.0;
            matrix.for_rows(ranges[layer].clone(), |i, row| {
                let (own, gate) = (i - low, &gates[i]);
                if row.stands_alone() {
                    next[own] = r[i];
                    return;
                }
                let left = r[i] - row.times_single(x[own], x, low);
                squares.left += f64::from(left) * f64::from(left);
                let last = match layer {
                    1 => gate[2] * r[i],
                    _ => x[own] - before[own],
                };
                next[own] = x[own] + gate[2 + layer] * left + gate[1 + LAYERS + layer] * last;
            });
            std::mem::swap(&mut self.before, &mut self.x);
            std::mem::swap(&mut self.x, &mut self.next);
        }
        for (p, change) in pressure.iter_mut().zip(&self.x[first - low..]) {
            p[0] += f64::from(*change);
        }
    }
}
