//! The paper's network in tensors; see [`seakeep_fluid::network::paper`] for what it is.

use crate::graph::{column, indices};
use seakeep_fluid::frame::Frame;
use seakeep_fluid::network::PaperGraph;
use seakeep_fluid::network::paper::{INPUTS, LAYERS, LEAK, OUTPUT_SCALE};
use tch::{Device, Tensor};

/// What this network alone needs of a frame.
pub(crate) struct Links {
    inputs: Tensor,
    start: Tensor,
    other: Tensor,
    weight: Tensor,
    /// p_d of the step before over ρ g D, n × 1.
    pub(crate) last: Tensor,
    /// ρ g D, Pa.
    pub(crate) unit: f64,
}

impl Links {
    pub(crate) fn new(frame: &Frame, device: Device) -> Self {
        let graph = PaperGraph::new(frame);
        let inputs = Tensor::from_slice(&graph.inputs).reshape([-1, INPUTS as i64]);
        Self {
            inputs: inputs.to(device),
            start: indices(&graph.link_start, device),
            other: indices(&graph.link, device),
            weight: Tensor::from_slice(&graph.link_weight).to(device),
            last: column(&graph.last, device) / f64::from(graph.unit),
            unit: f64::from(graph.unit),
        }
    }
}

/// p_d/(ρ g D), n × 1, by the network of `parameters`, which are in the order of
/// [`seakeep_fluid::network::paper::TENSORS`], with `noise` on the last p_d/(ρ g D).
pub(crate) fn pressure(parameters: &[Tensor], links: &Links, noise: Option<&Tensor>) -> Tensor {
    let activate = |x: Tensor| x.maximum(&(&x * f64::from(LEAK)));
    let linear = |x: &Tensor, map: usize| x.matmul(&parameters[map].tr()) + &parameters[map + 1];
    let mut inputs = links.inputs.shallow_clone();
    if let Some(noise) = noise {
        let last = inputs.narrow(1, INPUTS as i64 - 1, 1) + noise;
        inputs = Tensor::cat(&[inputs.narrow(1, 0, INPUTS as i64 - 1), last], 1);
    }
    // Eqs. (21) and (22).
    let mut h = activate(linear(&(inputs * &parameters[0]), 1));
    h = activate(linear(&h, 3));
    for layer in 0..LAYERS {
        // Eqs. (23) and (24), then (25).
        let (messages, _, _, _) = Tensor::embedding_bag(
            &h,
            &links.other,
            &links.start,
            false,
            0,
            false,
            Some(&links.weight),
            true,
        );
        let [neighbours, own] = [5, 6].map(|first| parameters[first + 2 * layer].tr());
        h = activate(messages.matmul(&neighbours) + h.matmul(&own));
    }
    // Eq. (26).
    linear(&activate(linear(&h, 9)), 11) * f64::from(OUTPUT_SCALE)
}
