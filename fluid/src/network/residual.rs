//! The residual network: a correction of the last pressure from the residual that it leaves.
//!
//! Its input is r = b − A p, the residual of Eq. (9b) in the last pressure p; its output, added to
//! p, is linear in r. The amplitude path has neither bias nor normalisation, so that spacing, time
//! step, density, gravity and wave height drop out, and the exact pressure is a fixed point. What
//! is learned decides how each particle answers, from the geometry around it: an encoder turns
//! [`FEATURES`] numbers into [`GATES`] gates. Then
//!
//! 1. coarse level: x⁰ = g_P · P (Pᵀ A P)⁻¹ Pᵀ (g_R · r), see `lattice`, reaches bed and
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

/// The weights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ResidualWeights {
    encoder: Vec<[f32; FEATURES]>,
    encoder_bias: Vec<f32>,
    gates: Vec<[f32; WIDTH]>,
    gates_bias: Vec<f32>,
}

impl ResidualWeights {
    pub(crate) fn new(tensors: &Tensors) -> Result<Self, NetworkError> {
        let [encoder, encoder_bias, gates, gates_bias] = tensors.take(TENSORS)?;
        Ok(Self {
            encoder: encoder.as_chunks().0.to_vec(),
            encoder_bias,
            gates: gates.as_chunks().0.to_vec(),
            gates_bias,
        })
    }

    /// The gates of a particle.
    #[inline(always)]
    fn gates(&self, features: [f32; FEATURES]) -> [f32; GATES] {
        let mut hidden = [0.0f32; WIDTH];
        for ((hidden, row), bias) in hidden.iter_mut().zip(&self.encoder).zip(&self.encoder_bias) {
            let sum: f32 = row.iter().zip(&features).map(|(w, f)| w * f).sum();
            *hidden = (sum + bias).max(0.0);
        }
        let mut gates = [0.0f32; GATES];
        for ((gate, row), bias) in gates.iter_mut().zip(&self.gates).zip(&self.gates_bias) {
            *gate = bias + row.iter().zip(&hidden).map(|(w, h)| w * h).sum::<f32>();
        }
        gates
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

/// The network at work.
#[derive(Clone, Debug, Default)]
pub(crate) struct Residual {
    gates: Vec<[f32; GATES]>,
    coarse: Vec<f32>,
    x: Vec<f32>,
    before: Vec<f32>,
    next: Vec<f32>,
}

impl Residual {
    /// The correction for the residual `r` (Pa) of the rows of `matrix`, Pa. `walls(i)` is the
    /// number of wall particles around particle i. Rows for which `known` holds stay at zero.
    pub(crate) fn correction(
        &mut self,
        weights: &ResidualWeights,
        matrix: &SparseMatrix,
        (cells, coarse): (&mut Cells, &Coarse),
        walls: impl Fn(usize) -> usize + Sync,
        known: &[bool],
        r: &[f32],
    ) -> &[f32] {
        let n = r.len();
        self.gates.resize(n, [0.0; GATES]);
        for vector in [&mut self.x, &mut self.before, &mut self.next] {
            vector.resize(n, 0.0);
        }
        let sorted = &*cells;
        self.gates.par_chunks_mut(BLOCK).enumerate().for_each(|(block, gates)| {
            for (offset, gates) in gates.iter_mut().enumerate() {
                let i = block * BLOCK + offset;
                if known[i] {
                    *gates = [0.0; GATES];
                } else {
                    *gates = weights.gates(features(matrix, sorted, walls(i), i));
                }
            }
        });
        let gates = &self.gates;
        cells.restrict(|i| gates[i][0] * r[i], &mut self.coarse);
        coarse.solve(&mut self.coarse);
        let (cells, nodes) = (&*cells, &self.coarse);
        self.x.par_chunks_mut(BLOCK).enumerate().for_each(|(block, x)| {
            for (offset, x) in x.iter_mut().enumerate() {
                let i = block * BLOCK + offset;
                *x = gates[i][1] * cells.interpolate(i, nodes);
            }
        });
        self.before.copy_from_slice(&self.x);
        for layer in 0..LAYERS {
            let (x, before) = (&self.x, &self.before);
            self.next.par_chunks_mut(BLOCK).enumerate().for_each(|(block, next)| {
                for (offset, next) in next.iter_mut().enumerate() {
                    let i = block * BLOCK + offset;
                    let gate = &gates[i];
                    let messages = matrix.times_single(i, x);
                    let carried = if layer == 0 {
                        0.0
                    } else {
                        gate[1 + LAYERS + layer] * (x[i] - before[i])
                    };
                    *next = x[i] + gate[2 + layer] * (r[i] - messages) + carried;
                }
            });
            std::mem::swap(&mut self.before, &mut self.x);
            std::mem::swap(&mut self.x, &mut self.next);
        }
        &self.x
    }
}
