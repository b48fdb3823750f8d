//! The two networks behind one face, and their inference.

use crate::device::Place;
use crate::error::LearningError;
use crate::graph::Graph;
use crate::noise::uniform;
use crate::optimizer::{Stored, load};
use crate::paper::{self, Links};
use crate::residual::{self, Levels};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use seakeep_fluid::frame::Frame;
use seakeep_fluid::network::residual::INITIAL_GATES;
use seakeep_fluid::network::{Inference, Network, ResidualStep, decode};
use serde::{Deserialize, Serialize};
use std::sync::{Mutex, MutexGuard};
use tch::{Device, Tensor, no_grad};

/// Which network.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Model {
    /// Ours: [`seakeep_fluid::network::residual`].
    Residual,
    /// The paper's: [`seakeep_fluid::network::paper`].
    Paper,
}

/// A frame ready for a network.
pub(crate) enum Prepared {
    Residual(Levels),
    Paper(Links),
}

impl Model {
    /// Its name in weights files.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Residual => "residual",
            Self::Paper => "paper",
        }
    }

    fn tensors(self) -> &'static [(&'static str, &'static [usize])] {
        match self {
            Self::Residual => &seakeep_fluid::network::residual::TENSORS,
            Self::Paper => &seakeep_fluid::network::paper::TENSORS,
        }
    }

    /// Number of tensors at the front that are not learnt.
    pub(crate) fn fixed(self) -> usize {
        match self {
            Self::Residual => 0,
            Self::Paper => 1,
        }
    }

    /// The tensors of a weights file, in order, and of which network they are.
    pub(crate) fn read(bytes: &[u8]) -> Result<(Self, Vec<Stored>), LearningError> {
        Network::from_bytes(bytes)?;
        let (tensors, metadata) = decode(bytes)?;
        let paper = metadata.get("network").is_some_and(|name| name == "paper");
        let model = if paper { Self::Paper } else { Self::Residual };
        let find = |name: &str| tensors.iter().find(|(own, _, _)| own == name).cloned();
        Ok((model, model.tensors().iter().filter_map(|(name, _)| find(name)).collect()))
    }

    /// First weights. The residual network's leave all gates at [`INITIAL_GATES`].
    pub(crate) fn first_weights(self, seed: u64) -> Vec<Stored> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(u64::MAX);
        let tensor = |(name, shape): &(&str, &[usize])| {
            let count: usize = shape.iter().product();
            let inputs = shape.last().copied().unwrap_or(1) as f64;
            let values = match *name {
                "gates.bias" => INITIAL_GATES.to_vec(),
                "gates.weight" => vec![0.0; count],
                "input.scale" => seakeep_fluid::network::paper::INPUT_SCALE.to_vec(),
                // Uniform with the variance of He et al. (2015) but for a factor.
                _ => (0..count)
                    .map(|_| ((2.0 * uniform(&mut random) - 1.0) * (3.0 / inputs).sqrt()) as f32)
                    .collect(),
            };
            ((*name).to_owned(), shape.to_vec(), values)
        };
        self.tensors().iter().map(tensor).collect()
    }
}

/// The change of the last pressure, n × 1, in units of `graph.scale`, that the paper's network finds.
pub(crate) fn paper_change(
    parameters: &[Tensor],
    graph: &Graph,
    links: &Links,
    noise: Option<&Tensor>,
) -> Tensor {
    let found = paper::pressure(parameters, links, noise);
    let change = (found - &links.last) * (links.unit / graph.scale);
    let alone: Tensor = 1.0 - &graph.matrix.active;
    change * &graph.matrix.active + alone * &graph.residual
}

/// A network on a device of libtorch.
pub struct DeviceNetwork {
    model: Model,
    parameters: Vec<Tensor>,
    device: Device,
}

impl DeviceNetwork {
    /// The network in a weights file, on the device at `place`.
    ///
    /// # Errors
    /// [`LearningError::Network`].
    pub fn new(bytes: &[u8], place: Place) -> Result<Self, LearningError> {
        let (model, tensors) = Model::read(bytes)?;
        let parameters = tensors.iter().map(|stored| load(stored, place.0)).collect();
        Ok(Self { model, parameters, device: place.0 })
    }

    /// `frame`, ready on the device.
    #[must_use]
    pub fn inputs(&self, frame: &Frame) -> Inputs {
        no_grad(|| Inputs {
            graph: Graph::new(frame, self.device),
            prepared: match self.model {
                Model::Residual => Prepared::Residual(Levels::new(frame, self.device)),
                Model::Paper => Prepared::Paper(Links::new(frame, self.device)),
            },
        })
    }

    /// The change of the last pressure that the network finds for `inputs`, Pa, one for each
    /// particle.
    #[must_use]
    pub fn correction(&self, inputs: &Inputs) -> Vec<f32> {
        no_grad(|| {
            let graph = &inputs.graph;
            let found = match &inputs.prepared {
                Prepared::Residual(levels) => {
                    levels.correction(&self.parameters, &graph.matrix, &graph.residual)
                }
                Prepared::Paper(links) => paper_change(&self.parameters, graph, links, None),
            };
            values(&(found * graph.scale))
        })
    }
}

/// The values of a tensor.
fn values(tensor: &Tensor) -> Vec<f32> {
    let mut values = vec![0.0f32; tensor.numel()];
    tensor.reshape([-1]).to_device(Device::Cpu).copy_data(&mut values, tensor.numel());
    values
}

/// A frame on a device.
pub struct Inputs {
    graph: Graph,
    prepared: Prepared,
}

/// A network on a device of libtorch that a fluid may use: one step at a time, whatever its threads. The fluid has
/// the same weights; for the residual network it makes the gates of them.
pub struct StepByStep(Mutex<DeviceNetwork>);

impl StepByStep {
    /// `network`, for a fluid.
    #[must_use]
    pub fn new(network: DeviceNetwork) -> Self {
        Self(Mutex::new(network))
    }

    /// The network, if it is the `model` that the fluid has.
    fn network(&self, model: Model) -> Result<MutexGuard<'_, DeviceNetwork>, String> {
        let network = self.0.lock().map_err(|error| error.to_string())?;
        match network.model == model {
            true => Ok(network),
            false => Err(format!("the network on the device is \"{}\"", network.model.name())),
        }
    }
}

impl Inference for StepByStep {
    fn residual(&self, step: ResidualStep<'_>) -> Result<Vec<f32>, String> {
        Ok(values(&residual::of_step(step, self.network(Model::Residual)?.device)))
    }

    fn paper(&self, frame: &Frame) -> Result<Vec<f32>, String> {
        let network = self.network(Model::Paper)?;
        Ok(network.correction(&network.inputs(frame)))
    }
}
