//! The residual network in tensors; see [`seakeep_fluid::network::residual`] for what it is.

use crate::graph::{Graph, indices};
use seakeep_fluid::frame::Frame;
use seakeep_fluid::network::ResidualGraph;
use seakeep_fluid::network::residual::FEATURES;
use tch::{Device, Tensor};

/// What this network alone needs of a frame.
pub(crate) struct Levels {
    features: Tensor,
    divisor: Tensor,
    nodes: Tensor,
    weights: Tensor,
    coarse_inverse: Tensor,
}

impl Levels {
    pub(crate) fn new(frame: &Frame, device: Device) -> Self {
        let graph = ResidualGraph::new(frame);
        let (n, c) = (frame.len() as i64, graph.node_count as i64);
        let shaped =
            |values: &[f32], shape: &[i64]| Tensor::from_slice(values).reshape(shape).to(device);
        Self {
            features: shaped(&graph.features, &[n, FEATURES as i64]),
            divisor: shaped(&graph.divisor, &[n, 1]),
            nodes: indices(&graph.nodes, device),
            weights: shaped(&graph.weights, &[n, 4, 1]),
            coarse_inverse: shaped(&graph.coarse_inverse, &[c, c]),
        }
    }
}

/// The corrections, n × c, for residuals `r`, n × c, by the network of `parameters`, which are in
/// the order of [`seakeep_fluid::network::residual::TENSORS`].
pub(crate) fn correction(
    parameters: &[Tensor],
    graph: &Graph,
    levels: &Levels,
    r: &Tensor,
) -> Tensor {
    let [encoder, encoder_bias, gates, gates_bias] = [0, 1, 2, 3].map(|i| &parameters[i]);
    let hidden = (levels.features.matmul(&encoder.tr()) + encoder_bias).relu();
    let gates = (hidden.matmul(&gates.tr()) + gates_bias) * &graph.active;
    let gate = |index: usize| gates.narrow(1, index as i64, 1);
    let (n, columns) = (graph.count, r.size()[1]);
    let nodes = levels.coarse_inverse.size()[0];

    let sent = &levels.weights * (&levels.divisor * gate(0) * r).unsqueeze(1);
    let restricted = Tensor::zeros([nodes, columns], (r.kind(), r.device())).index_add(
        0,
        &levels.nodes,
        &sent.reshape([4 * n, columns]),
    );
    let coarse = levels.coarse_inverse.matmul(&restricted);
    let around = coarse.index_select(0, &levels.nodes).reshape([n, 4, columns]);
    let interpolated =
        (&levels.weights * around).sum_dim_intlist([1i64].as_slice(), false, r.kind());
    let alone: Tensor = 1.0 - &graph.active;
    let x = gate(1) * interpolated + gate(2) * r + alone * r;
    let left = r - graph.product(&x);
    &x + gate(3) * left + gate(4) * r
}
