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
//! 2. fine level: [`LAYERS`] layers of message passing on the particle graph. Particle j sends
//!    a_ij x_j, the operator's own weight, and with the sum m_i of its messages, its own part
//!    included, particle i goes on by x_i ← x_i + g_step (r_i − m_i) + g_carry (x_i − x_i before).
//!
//! With gates of one and a constant step this is a two-level correction with damped Jacobi sweeps.

use super::NetworkError;
use super::lattice::{Cells, Coarse};
use super::weights::Tensors;
use crate::neighbours::BLOCK;
use crate::sparse::SparseMatrix;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Layers of message passing.
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
        cells: &Cells,
        walls: impl Fn(usize) -> usize + Sync,
        gates: &mut Vec<Gates>,
    ) {
        gates.resize(cells.place.len(), [0.0; GATES + 1]);
        gates.par_chunks_mut(BLOCK).enumerate().for_each(|(block, gates)| {
            for (offset, gates) in gates.iter_mut().enumerate() {
                let i = block * BLOCK + offset;
                *gates = self.gates(features(matrix, cells, walls(i), i));
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
    cells: &Cells,
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
    let place = cells.place[i];
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

/// Rows whose layers are worked off together, so that their part of the matrix is fetched once.
const SLAB: usize = 16 * BLOCK;

/// The network at work.
#[derive(Clone, Debug, Default)]
pub(crate) struct Residual {
    coarse: Vec<f32>,
    start: Vec<f32>,
    found: Vec<f32>,
    slabs: Vec<Slab>,
}

/// Values of the layers around a slab, and the sum of squares of its residual.
#[derive(Clone, Debug, Default)]
struct Slab {
    x: Vec<f32>,
    before: Vec<f32>,
    next: Vec<f32>,
    square: f64,
}

/// The coarse level of a step, and the gates that were found with it.
pub(crate) struct Level<'a> {
    /// Where the particles stand in its lattice.
    pub(crate) cells: &'a mut Cells,
    pub(crate) coarse: &'a Coarse,
    /// Of each particle.
    pub(crate) gates: &'a [Gates],
}

/// What the layers work on.
#[derive(Clone, Copy)]
struct Layers<'a> {
    gates: &'a [Gates],
    matrix: &'a SparseMatrix,
    r: &'a [f32],
}

impl Residual {
    /// The correction for the residual `r` (Pa) of the rows of `matrix`, Pa, and the sum of the
    /// squares of the residual that was left before the last layer, Pa². A row that stands alone, as
    /// those of the surface do, is corrected by its residual.
    pub(crate) fn correction(
        &mut self,
        level: Level<'_>,
        matrix: &SparseMatrix,
        r: &[f32],
    ) -> (&[f32], f64) {
        let Level { cells, coarse, gates } = level;
        let n = r.len();
        self.start.resize(n, 0.0);
        self.found.resize(n, 0.0);
        self.slabs.resize_with(n.div_ceil(SLAB), Slab::default);
        // In the place of what it will be: what each particle sends to the coarse level.
        let sent = &mut self.found;
        sent.par_chunks_mut(BLOCK).enumerate().for_each(|(block, sent)| {
            for (offset, sent) in sent.iter_mut().enumerate() {
                let i = block * BLOCK + offset;
                *sent = match matrix.stands_alone(i) {
                    true => 0.0,
                    false => matrix.divisor(i) * gates[i][0] * r[i],
                };
            }
        });
        cells.restrict(sent, &mut self.coarse);
        coarse.solve(&mut self.coarse);
        let (cells, nodes) = (&*cells, &self.coarse);
        self.start.par_chunks_mut(BLOCK).enumerate().for_each(|(block, x)| {
            for (offset, x) in x.iter_mut().enumerate() {
                let i = block * BLOCK + offset;
                *x = match matrix.stands_alone(i) {
                    true => r[i],
                    false => gates[i][1] * cells.interpolate(i, nodes),
                };
            }
        });
        let (layers, start) = (Layers { gates, matrix, r }, &self.start);
        let slabs = self.found.par_chunks_mut(SLAB).zip(&mut self.slabs);
        slabs.enumerate().for_each(|(index, (found, slab))| {
            slab.work(layers, start, index * SLAB, found);
        });
        (&self.found, self.slabs.iter().map(|slab| slab.square).sum())
    }
}

impl Slab {
    /// All layers for the rows from `first` on that `found` is for, from `start`. A layer is worked
    /// off for as many rows around as the next one reaches.
    fn work(&mut self, layers: Layers<'_>, start: &[f32], first: usize, found: &mut [f32]) {
        let Layers { gates, matrix, r } = layers;
        let mut ranges: [Range<usize>; LAYERS + 1] =
            std::array::from_fn(|_| first..first + found.len());
        for layer in (0..LAYERS).rev() {
            ranges[layer] = matrix.reach(ranges[layer + 1].clone());
        }
        let low = ranges[0].start;
        self.x.clear();
        self.x.extend_from_slice(&start[ranges[0].clone()]);
        self.before.resize(self.x.len(), 0.0);
        self.next.resize(self.x.len(), 0.0);
        for layer in 0..LAYERS {
            self.square = 0.0;
            for i in ranges[layer + 1].clone() {
                let own = i - low;
                if matrix.stands_alone(i) {
                    self.next[own] = r[i];
                    continue;
                }
                let gate = &gates[i];
                let left = r[i] - matrix.times_single(i, &self.x, low);
                self.square += f64::from(left) * f64::from(left);
                let mut next = self.x[own] + gate[2 + layer] * left;
                if layer > 0 {
                    next += gate[1 + LAYERS + layer] * (self.x[own] - self.before[own]);
                }
                self.next[own] = next;
            }
            std::mem::swap(&mut self.before, &mut self.x);
            std::mem::swap(&mut self.x, &mut self.next);
        }
        found.copy_from_slice(&self.x[first - low..first - low + found.len()]);
    }
}
