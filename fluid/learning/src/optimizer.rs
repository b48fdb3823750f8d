//! Adam (Kingma & Ba 2015) whose whole state can be saved, so that a training that was interrupted
//! goes on to the same weights.

use seakeep_fluid::network::NetworkError;
use std::collections::HashMap;
use tch::{Device, Kind, Tensor, no_grad};

const BETA_1: f64 = 0.9;
const BETA_2: f64 = 0.999;
const EPSILON: f64 = 1e-8;

/// Parameters, their moments and the number of steps taken.
pub(crate) struct Adam {
    names: Vec<String>,
    pub(crate) parameters: Vec<Tensor>,
    first: Vec<Tensor>,
    second: Vec<Tensor>,
    pub(crate) steps: u64,
}

/// A named tensor with its shape, as it is in a file.
pub(crate) type Stored = (String, Vec<usize>, Vec<f32>);

impl Adam {
    /// Parameters of which the first `fixed` are not learnt.
    pub(crate) fn new(tensors: &[Stored], fixed: usize, device: Device) -> Self {
        let parameters: Vec<Tensor> = (tensors.iter().enumerate())
            .map(|(index, stored)| load(stored, device).set_requires_grad(index >= fixed))
            .collect();
        let zeros = || parameters.iter().map(|p| p.detach().zeros_like()).collect();
        Self {
            names: tensors.iter().map(|(name, _, _)| name.clone()).collect(),
            first: zeros(),
            second: zeros(),
            parameters,
            steps: 0,
        }
    }

    /// Takes the state of [`Self::state`].
    pub(crate) fn restore(&mut self, stored: &[Stored], steps: u64) -> Result<(), NetworkError> {
        let device = self.parameters.first().map_or(Device::Cpu, Tensor::device);
        let find = |name: String, like: &Tensor| {
            let (_, shape, values) = stored
                .iter()
                .find(|(own, _, _)| *own == name)
                .ok_or_else(|| NetworkError::Missing { tensor: name.clone() })?;
            let expected = shape_of(like);
            if *shape != expected {
                return Err(NetworkError::Shape { tensor: name, found: shape.clone(), expected });
            }
            Ok(load(&(name, shape.clone(), values.clone()), device))
        };
        for (index, name) in self.names.iter().enumerate() {
            let own = find(name.clone(), &self.parameters[index])?;
            self.first[index] = find(format!("{name}.first"), &self.parameters[index])?;
            self.second[index] = find(format!("{name}.second"), &self.parameters[index])?;
            let learnt = self.parameters[index].requires_grad();
            self.parameters[index] = own.set_requires_grad(learnt);
        }
        self.steps = steps;
        Ok(())
    }

    /// One step down the gradient of `loss`.
    pub(crate) fn step(&mut self, loss: &Tensor, learning_rate: f64) {
        for parameter in &mut self.parameters {
            parameter.zero_grad();
        }
        loss.backward();
        self.steps += 1;
        let power = self.steps.min(1_000_000) as i32;
        let rate = learning_rate * (1.0 - BETA_2.powi(power)).sqrt() / (1.0 - BETA_1.powi(power));
        no_grad(|| {
            let moments = self.first.iter_mut().zip(&mut self.second);
            for (parameter, (first, second)) in self.parameters.iter_mut().zip(moments) {
                let gradient = parameter.grad();
                if gradient.defined() {
                    *first = &*first * BETA_1 + &gradient * (1.0 - BETA_1);
                    *second = &*second * BETA_2 + gradient.square() * (1.0 - BETA_2);
                    let change = &*first / (second.sqrt() + EPSILON) * rate;
                    *parameter -= change;
                }
            }
        });
    }

    /// The parameters.
    pub(crate) fn weights(&self) -> Vec<Stored> {
        self.names.iter().zip(&self.parameters).map(|(name, p)| store(name.clone(), p)).collect()
    }

    /// The parameters and their moments.
    pub(crate) fn state(&self) -> Vec<Stored> {
        let mut stored = self.weights();
        for (index, name) in self.names.iter().enumerate() {
            stored.push(store(format!("{name}.first"), &self.first[index]));
            stored.push(store(format!("{name}.second"), &self.second[index]));
        }
        stored
    }
}

fn shape_of(tensor: &Tensor) -> Vec<usize> {
    tensor.size().iter().map(|length| *length as usize).collect()
}

fn store(name: String, tensor: &Tensor) -> Stored {
    let flat = tensor.detach().to_device(Device::Cpu).reshape([-1]).to_kind(Kind::Float);
    let mut values = vec![0.0f32; flat.numel()];
    flat.copy_data(&mut values, flat.numel());
    (name, shape_of(tensor), values)
}

pub(crate) fn load((_, shape, values): &Stored, device: Device) -> Tensor {
    let shape: Vec<i64> = shape.iter().map(|length| *length as i64).collect();
    Tensor::from_slice(values).reshape(shape.as_slice()).to(device)
}

/// Metadata of a checkpoint.
pub(crate) fn metadata(network: &str, steps: u64, training: &str) -> HashMap<String, String> {
    [
        ("network", network.to_owned()),
        ("steps", steps.to_string()),
        ("training", training.to_owned()),
    ]
    .into_iter()
    .map(|(key, value)| (key.to_owned(), value))
    .collect()
}
