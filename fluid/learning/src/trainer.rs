//! Training, Eq. (28) with the weights of Eq. (29).

use crate::device::Place;
use crate::error::LearningError;
use crate::graph::Graph;
use crate::model::{Model, Prepared, paper_change};
use crate::noise::{self, uniform};
use crate::optimizer::{Adam, metadata};
use crate::paper::Links;
use crate::residual::Levels;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use seakeep_fluid::frame::Frame;
use seakeep_fluid::network::{decode, encode};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;
use tch::{Device, Kind, Tensor, no_grad};

/// Typical p_d over ρ g D, by which errors of the paper's network are measured.
const PRESSURE: f64 = 0.05;

/// How a network is trained.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    /// Which network.
    pub network: Model,
    /// Seed of the first weights, the order of the frames and the noise.
    pub seed: u64,
    /// Steps, a frame each.
    pub steps: u64,
    /// Learning rate at the start.
    pub learning_rate: f64,
    /// Learning rate at the end; in between it follows half a cosine.
    pub final_learning_rate: f64,
    /// Weight of the divergence left, as a part of that before, beside the error of Eq. (28), as a
    /// part of that before.
    pub divergence_weight: f64,
    /// Weight of the errors of the last pressure that are not in the frame: rough, smooth, and what
    /// the network leaves of these. For the paper's network, which is not linear, the size of such
    /// an error that is added to the last pressure, as a part of the change of a step.
    pub noise_weight: f64,
}

/// How good a network is on a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Losses {
    /// What was minimized.
    pub loss: f64,
    /// 1 − Σ (p̂ − p)² / Σ (p_t − p)²: the skill against the last pressure p_t.
    pub skill: f64,
    /// Root-mean-square residual left over that before.
    pub residual: f64,
}

/// Sets the number of threads of libtorch. Results are the same for the same number.
pub fn use_threads(count: usize) {
    tch::set_num_threads(count.clamp(1, 1024) as i32);
}

/// A network in training.
pub struct Trainer {
    settings: Settings,
    adam: Adam,
    device: Device,
}

impl Trainer {
    /// A network with first weights drawn from the seed, or with those of the file `start`.
    ///
    /// # Errors
    /// [`LearningError`] where `start` is no weights file of this network.
    pub fn new(
        settings: Settings,
        start: Option<&[u8]>,
        place: Place,
    ) -> Result<Self, LearningError> {
        let tensors = match start {
            Some(bytes) => {
                let (model, tensors) = Model::read(bytes)?;
                if model != settings.network {
                    return Err(LearningError::OtherNetwork(model.name()));
                }
                tensors
            }
            None => settings.network.first_weights(settings.seed),
        };
        let adam = Adam::new(&tensors, settings.network.fixed(), place.0);
        Ok(Self { adam, device: place.0, settings })
    }

    /// Steps done.
    #[must_use]
    pub fn steps(&self) -> u64 {
        self.adam.steps
    }

    /// Which of `frames` frames the next step learns from.
    #[must_use]
    pub fn next_frame(&self, frames: usize) -> usize {
        let mut random = self.random(0);
        ((uniform(&mut random) * frames as f64) as usize).min(frames.saturating_sub(1))
    }

    fn random(&self, purpose: u64) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::seed_from_u64(self.settings.seed);
        random.set_stream(self.adam.steps << 2 | purpose);
        random
    }

    fn learning_rate(&self) -> f64 {
        let part = self.adam.steps as f64 / self.settings.steps.max(1) as f64;
        let (first, last) = (self.settings.learning_rate, self.settings.final_learning_rate);
        last + (first - last) * 0.5 * (1.0 + (std::f64::consts::PI * part.min(1.0)).cos())
    }

    /// Learns from `frame`.
    ///
    /// # Errors
    /// [`LearningError::Diverged`].
    pub fn step(&mut self, frame: &Frame) -> Result<Losses, LearningError> {
        let graph = Graph::new(frame, self.device);
        let (v, r, found, size) = self.found(frame, &graph, true);
        let (loss, losses) = self.losses(&graph, &v, &r, &found, &size);
        if !losses.loss.is_finite() {
            return Err(LearningError::Diverged { step: self.adam.steps });
        }
        let rate = self.learning_rate();
        self.adam.step(&loss, rate);
        Ok(losses)
    }

    /// How good the network is on `frame`, without noise.
    #[must_use]
    pub fn test(&self, frame: &Frame) -> Losses {
        no_grad(|| {
            let graph = Graph::new(frame, self.device);
            let (v, r, found, size) = self.found(frame, &graph, false);
            self.losses(&graph, &v, &r, &found, &size).1
        })
    }

    fn prepare(&self, frame: &Frame) -> Prepared {
        match self.settings.network {
            Model::Residual => Prepared::Residual(Levels::differentiable(frame, self.device)),
            Model::Paper => Prepared::Paper(Links::new(frame, self.device)),
        }
    }

    /// Errors of the last pressure, their residuals, what the network finds for them, a column each,
    /// with or without noise, and what an error in it is measured by: the error before, or a typical
    /// p_d.
    fn found(&self, frame: &Frame, graph: &Graph, noise: bool) -> (Tensor, Tensor, Tensor, Tensor) {
        let noise = noise && self.settings.noise_weight > 0.0;
        let parameters = &self.adam.parameters;
        let own = || (graph.target.shallow_clone(), graph.residual.shallow_clone());
        match self.prepare(frame) {
            Prepared::Residual(levels) => {
                let (v, r) = if noise { self.errors(frame, graph, &levels) } else { own() };
                let found = levels.correction(parameters, &graph.matrix, &r);
                let size = v.shallow_clone();
                (v, r, found, size)
            }
            Prepared::Paper(links) => {
                let (v, r) = own();
                // Of the size of the change of a step.
                let size = self.settings.noise_weight * graph.scale / links.unit;
                let mut random = self.random(1);
                let noise = noise.then(|| {
                    let rough = noise::rough(&mut random, frame, self.device);
                    let smooth = noise::smooth(&mut random, frame, self.device);
                    (rough + smooth) * &graph.matrix.active * size
                });
                let found = paper_change(parameters, graph, &links, noise.as_ref());
                let size = &graph.matrix.active * (PRESSURE * links.unit / graph.scale);
                (v, r, found, size)
            }
        }
    }

    /// Errors v of the last pressure and their residuals A v, a column each: that of the frame,
    /// a rough and a smooth one, and what the network leaves of these. The network being linear,
    /// each may have any size.
    fn errors(&self, frame: &Frame, graph: &Graph, levels: &Levels) -> (Tensor, Tensor) {
        let mut random = self.random(1);
        no_grad(|| {
            let rough = noise::rough(&mut random, frame, self.device) * &graph.matrix.active;
            let smooth = noise::smooth(&mut random, frame, self.device) * &graph.matrix.active;
            let mut left = unit(&rough, graph) + unit(&smooth, graph) + &graph.target;
            for _ in 0..2 {
                let r = graph.matrix.product(&left);
                let found = levels.correction(&self.adam.parameters, &graph.matrix, &r);
                left = unit(&(&left - found), graph);
            }
            let others = Tensor::cat(&[unit(&rough, graph), unit(&smooth, graph), left], 1);
            let residuals = graph.matrix.product(&others);
            (
                Tensor::cat(&[&graph.target, &others], 1),
                Tensor::cat(&[&graph.residual, &residuals], 1),
            )
        })
    }

    fn losses(
        &self,
        graph: &Graph,
        v: &Tensor,
        r: &Tensor,
        found: &Tensor,
        size: &Tensor,
    ) -> (Tensor, Losses) {
        let sum = |x: Tensor| x.sum_dim_intlist([0i64].as_slice(), false, Kind::Float);
        let error = found - v;
        // Eq. (28).
        let pressure = sum(&graph.weight * error.square())
            / sum(&graph.weight * size.square()).clamp_min(1e-30);
        let left = sum((graph.matrix.product(&error) * &graph.matrix.active).square())
            / sum(r.square()).clamp_min(1e-30);
        let columns = v.size()[1];
        let weights: Vec<f32> = (0..columns)
            .map(|column| if column == 0 { 1.0 } else { self.settings.noise_weight as f32 })
            .collect();
        let weights = Tensor::from_slice(&weights).to(self.device);
        let each = &pressure + &left * self.settings.divergence_weight;
        let loss = (each * weights).sum(Kind::Float);
        let first = |x: &Tensor| x.narrow(1, 0, 1);
        let skill = 1.0
            - (first(&error).square().sum(Kind::Float).double_value(&[])
                / first(v).square().sum(Kind::Float).double_value(&[]).max(1e-30));
        let losses = Losses {
            loss: loss.double_value(&[]),
            skill,
            residual: left.double_value(&[0]).sqrt(),
        };
        (loss, losses)
    }

    /// Everything the training goes on from, with `training`, which says what it is.
    ///
    /// # Errors
    /// [`LearningError::Network`] where it cannot be encoded.
    pub fn checkpoint(&self, training: &str) -> Result<Vec<u8>, LearningError> {
        let metadata = metadata(self.settings.network.name(), self.adam.steps, training);
        Ok(encode(&self.adam.state(), metadata)?)
    }

    /// Goes on from a checkpoint of the same `training`.
    ///
    /// # Errors
    /// [`LearningError::Checkpoint`] where it is of another training.
    pub fn restore(&mut self, bytes: &[u8], training: &str) -> Result<(), LearningError> {
        let (tensors, metadata) = decode(bytes)?;
        let value = |key: &str| metadata.get(key).map(String::as_str).unwrap_or_default();
        if value("training") != training {
            return Err(LearningError::Checkpoint(
                "its configuration differs; use another folder".to_owned(),
            ));
        }
        let steps = value("steps").parse().map_err(|_| {
            LearningError::Checkpoint("it does not say how many steps were done".to_owned())
        })?;
        Ok(self.adam.restore(&tensors, steps)?)
    }

    /// The weights file.
    ///
    /// # Errors
    /// [`LearningError::Network`] where it cannot be encoded.
    pub fn weights(&self) -> Result<Vec<u8>, LearningError> {
        // No more than one entry: their order in the file is not defined.
        let name = self.settings.network.name().to_owned();
        let metadata = HashMap::from([("network".to_owned(), name)]);
        Ok(encode(&self.adam.weights(), metadata)?)
    }
}

/// `v` with a root mean square of one.
fn unit(v: &Tensor, graph: &Graph) -> Tensor {
    v * ((graph.count as f64).sqrt() / v.norm().double_value(&[]).max(1e-30))
}
