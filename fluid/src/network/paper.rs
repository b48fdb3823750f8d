//! The network of the paper, section 2.3: from velocity, Ψ and the last pressure of a particle and
//! its neighbours straight to the pressure.
//!
//! 1. Encoder, Eqs. (21) and (22): four inputs → 32 → 32.
//! 2. Two layers of message passing, Eqs. (23) to (25): M_i = Σ_j W_ij h_j / Σ_j W_ij with
//!    W = r_0/r − 1 within r_0 = 1.705 dx, about eight neighbours; h_i ← σ(w M_i + b' h_i).
//! 3. Decoder, Eq. (26): 32 → 8 → 1.
//!
//! σ is a leaky rectifier, as in the code of Li & Farimani (2022), whose network the paper takes up.
//!
//! The pressure is split as in section 2.3.2: p = p_d + ρ g z, z the vertical distance to the nearest
//! particle on the surface. Inputs and output are made dimensionless with ρ, g, D, dx and dt: Ψ dx²/(dt
//! ρ g D), u*/√(g D), p_d/(ρ g D).

use super::NetworkError;
use super::weights::Tensors;
use crate::frame::Scales;
use crate::neighbours::BLOCK;
use nalgebra::Point2;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Inputs of a particle.
pub const INPUTS: usize = 4;
/// Width of the embeddings.
pub const WIDTH: usize = 32;
/// Width of the decoder.
pub const NARROW: usize = 8;
/// Layers of message passing.
pub const LAYERS: usize = 2;
/// r_0 of Eq. (23) in spacings.
pub const RADIUS: f64 = 1.705;
/// Slope of σ below zero.
pub const LEAK: f32 = 0.01;
/// Factors on the inputs before training, which make them of the order of one.
pub const INPUT_SCALE: [f32; INPUTS] = [300.0, 10.0, 10.0, 10.0];
/// Factor on the output, likewise.
pub const OUTPUT_SCALE: f32 = 0.1;

/// Names and shapes of the tensors, as they are in a weights file. The first is not learnt.
pub const TENSORS: [(&str, &[usize]); 13] = [
    ("input.scale", &[INPUTS]),
    ("encoder.0.weight", &[WIDTH, INPUTS]),
    ("encoder.0.bias", &[WIDTH]),
    ("encoder.1.weight", &[WIDTH, WIDTH]),
    ("encoder.1.bias", &[WIDTH]),
    ("message.0.neighbours", &[WIDTH, WIDTH]),
    ("message.0.own", &[WIDTH, WIDTH]),
    ("message.1.neighbours", &[WIDTH, WIDTH]),
    ("message.1.own", &[WIDTH, WIDTH]),
    ("decoder.0.weight", &[NARROW, WIDTH]),
    ("decoder.0.bias", &[NARROW]),
    ("decoder.1.weight", &[1, NARROW]),
    ("decoder.1.bias", &[1]),
];

type Embedding = [f32; WIDTH];

/// A linear map with `I` inputs, a row for each.
type Map<const I: usize, const O: usize> = Vec<[f32; O]>;

/// The weights.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct PaperWeights {
    first: Map<INPUTS, WIDTH>,
    first_bias: Embedding,
    second: Map<WIDTH, WIDTH>,
    second_bias: Embedding,
    neighbours: [Map<WIDTH, WIDTH>; LAYERS],
    own: [Map<WIDTH, WIDTH>; LAYERS],
    narrow: Map<WIDTH, NARROW>,
    narrow_bias: [f32; NARROW],
    last: [f32; NARROW],
    last_bias: f32,
}

fn map<const O: usize>(
    values: &[f32],
    inputs: usize,
    scale: impl Fn(usize) -> f32,
) -> Vec<[f32; O]> {
    (0..inputs).map(|i| std::array::from_fn(|o| values[o * inputs + i] * scale(i))).collect()
}

#[inline(always)]
fn apply<const O: usize>(map: &[[f32; O]], inputs: &[f32], sums: &mut [f32; O]) {
    for (row, input) in map.iter().zip(inputs) {
        for (sum, weight) in sums.iter_mut().zip(row) {
            *sum += weight * input;
        }
    }
}

#[inline(always)]
fn activate<const O: usize>(values: &mut [f32; O]) {
    for value in values {
        *value = value.max(LEAK * *value);
    }
}

impl PaperWeights {
    pub(crate) fn new(tensors: &Tensors) -> Result<Self, NetworkError> {
        let [scale, w0, b0, w1, b1, n0, o0, n1, o1, w2, b2, w3, b3] = tensors.take(TENSORS)?;
        let one = |_| 1.0;
        Ok(Self {
            first: map(&w0, INPUTS, |i| scale[i]),
            first_bias: std::array::from_fn(|k| b0[k]),
            second: map(&w1, WIDTH, one),
            second_bias: std::array::from_fn(|k| b1[k]),
            neighbours: [map(&n0, WIDTH, one), map(&n1, WIDTH, one)],
            own: [map(&o0, WIDTH, one), map(&o1, WIDTH, one)],
            narrow: map(&w2, WIDTH, one),
            narrow_bias: std::array::from_fn(|k| b2[k]),
            last: std::array::from_fn(|k| w3[k] * OUTPUT_SCALE),
            last_bias: b3[0] * OUTPUT_SCALE,
        })
    }

    fn encode(&self, inputs: &[f32; INPUTS]) -> Embedding {
        let mut hidden = self.first_bias;
        apply(&self.first, inputs, &mut hidden);
        activate(&mut hidden);
        let mut embedding = self.second_bias;
        apply(&self.second, &hidden, &mut embedding);
        activate(&mut embedding);
        embedding
    }

    fn decode(&self, embedding: &Embedding) -> f32 {
        let mut narrow = self.narrow_bias;
        apply(&self.narrow, embedding, &mut narrow);
        activate(&mut narrow);
        self.last_bias + narrow.iter().zip(&self.last).map(|(a, b)| a * b).sum::<f32>()
    }
}

/// Neighbours of each particle with their weights W of Eq. (23) over the sum of them all.
#[derive(Clone, Debug, Default)]
pub(crate) struct Links {
    pub(crate) start: Vec<u32>,
    pub(crate) column: Vec<u32>,
    pub(crate) weight: Vec<f32>,
}

impl Links {
    /// Finds the links of particles at `position` among their `neighbours`.
    pub(crate) fn find<'a>(
        &mut self,
        position: &[Point2<f64>],
        spacing: f64,
        neighbours: impl Fn(usize) -> &'a [u32],
    ) {
        self.start.clear();
        self.start.push(0);
        self.column.clear();
        self.weight.clear();
        let radius = RADIUS * spacing;
        for (i, centre) in position.iter().enumerate() {
            let first = self.column.len();
            let mut sum = 0.0f32;
            for &j in neighbours(i) {
                let distance = (position[j as usize] - centre).norm();
                if distance < radius && distance > 0.0 {
                    let weight = (radius / distance - 1.0) as f32;
                    self.column.push(j);
                    self.weight.push(weight);
                    sum += weight;
                }
            }
            for weight in &mut self.weight[first..] {
                *weight /= sum;
            }
            self.start.push(self.column.len() as u32);
        }
    }

    fn of(&self, i: usize) -> impl Iterator<Item = (usize, f32)> + '_ {
        let range = self.start[i] as usize..self.start[i + 1] as usize;
        self.column[range.clone()]
            .iter()
            .map(|j| *j as usize)
            .zip(self.weight[range].iter().copied())
    }
}

/// Height above still water of the nearest particle on the surface, for each particle, m.
pub(crate) fn elevations(position: &[Point2<f64>], on_surface: &[bool], depth: f64) -> Vec<f64> {
    let mut surface: Vec<Point2<f64>> =
        position.iter().zip(on_surface).filter(|(_, on)| **on).map(|(x, _)| *x).collect();
    surface.sort_by(|a, b| a.x.total_cmp(&b.x));
    let nearest = |x: &Point2<f64>| {
        let middle = surface.partition_point(|s| s.x < x.x);
        let (mut best, mut height) = (f64::INFINITY, depth);
        let mut see = |s: &Point2<f64>| {
            if (s.x - x.x).powi(2) > best {
                return false;
            }
            let distance = (s - x).norm_squared();
            if distance < best {
                (best, height) = (distance, s.y);
            }
            true
        };
        surface[..middle].iter().rev().all(&mut see);
        surface[middle..].iter().all(&mut see);
        height - depth
    };
    position.par_iter().with_min_len(BLOCK).map(nearest).collect()
}

/// Dimensionless inputs of a particle: its Ψ (kg/(m³ s)), u* (m/s) and p_d (Pa).
#[inline(always)]
pub(crate) fn inputs(scales: &Scales, source: f64, velocity: [f64; 2], p_d: f64) -> [f32; INPUTS] {
    let head = scales.density * scales.gravity * scales.depth;
    let speed = (scales.gravity * scales.depth).sqrt();
    let source = source * scales.spacing * scales.spacing / (scales.time_step * head);
    [source, velocity[0] / speed, velocity[1] / speed, p_d / head].map(|value| value as f32)
}

/// The network at work.
#[derive(Clone, Debug, Default)]
pub(crate) struct Paper {
    pub(crate) links: Links,
    now: Vec<Embedding>,
    next: Vec<Embedding>,
    out: Vec<f32>,
}

impl Paper {
    /// p_d/(ρ g D) of each particle from its `inputs`, along the links.
    pub(crate) fn pressure(
        &mut self,
        weights: &PaperWeights,
        inputs: impl Fn(usize) -> [f32; INPUTS] + Sync,
        count: usize,
    ) -> &[f32] {
        self.now.resize(count, [0.0; WIDTH]);
        self.next.resize(count, [0.0; WIDTH]);
        self.out.resize(count, 0.0);
        let each = |values: &mut Vec<Embedding>, make: &(dyn Fn(usize) -> Embedding + Sync)| {
            values.par_chunks_mut(BLOCK).enumerate().for_each(|(block, values)| {
                for (offset, value) in values.iter_mut().enumerate() {
                    *value = make(block * BLOCK + offset);
                }
            });
        };
        each(&mut self.now, &|i| weights.encode(&inputs(i)));
        for layer in 0..LAYERS {
            let (now, links) = (&self.now, &self.links);
            each(&mut self.next, &|i| {
                let mut messages = [0.0f32; WIDTH];
                for (j, weight) in links.of(i) {
                    for (sum, h) in messages.iter_mut().zip(&now[j]) {
                        *sum += weight * h;
                    }
                }
                let mut embedding = [0.0f32; WIDTH];
                apply(&weights.neighbours[layer], &messages, &mut embedding);
                apply(&weights.own[layer], &now[i], &mut embedding);
                activate(&mut embedding);
                embedding
            });
            std::mem::swap(&mut self.now, &mut self.next);
        }
        let now = &self.now;
        self.out.par_chunks_mut(BLOCK).enumerate().for_each(|(block, out)| {
            for (offset, out) in out.iter_mut().enumerate() {
                *out = weights.decode(&now[block * BLOCK + offset]);
            }
        });
        &self.out
    }
}
