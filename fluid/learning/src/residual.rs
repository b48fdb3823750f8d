//! The residual network in tensors; see [`seakeep_fluid::network::residual`] for what it is.

use crate::graph::{Matrix, indices};
use seakeep_fluid::frame::Frame;
use seakeep_fluid::network::residual::{FEATURES, GATES};
use seakeep_fluid::network::{CoarseLevel, ResidualGraph, ResidualStep};
use tch::{Device, Tensor, no_grad};

/// The coarse level on a device.
pub(crate) struct Level {
    /// What each row was divided by for its unit diagonal, n × 1.
    divisor: Tensor,
    nodes: Tensor,
    weights: Tensor,
    node_count: i64,
}

impl Level {
    fn new(divisor: &[f32], coarse: CoarseLevel<'_>, device: Device) -> Self {
        let shaped =
            |values: &[f32], shape: &[i64]| Tensor::from_slice(values).reshape(shape).to(device);
        Self {
            divisor: shaped(divisor, &[-1, 1]),
            nodes: indices(&coarse.nodes(), device),
            weights: shaped(&coarse.weights(), &[-1, 4, 1]),
            node_count: coarse.node_count() as i64,
        }
    }
}

/// How the coarse equation is solved.
enum Solve {
    /// By its factors, on the processor: for one residual, without gradients.
    Factors(ResidualGraph),
    /// By its inverse: it can be differentiated.
    Inverse(Tensor),
}

/// What this network alone needs of a frame.
pub(crate) struct Levels {
    features: Tensor,
    level: Level,
    solve: Solve,
}

impl Levels {
    /// For the correction of one residual.
    pub(crate) fn new(frame: &Frame, device: Device) -> Self {
        Self::with(frame, device, Solve::Factors)
    }

    /// For training: many residuals, and gradients.
    pub(crate) fn differentiable(frame: &Frame, device: Device) -> Self {
        Self::with(frame, device, |graph| {
            let (inverse, count) = (graph.coarse().inverse(), graph.coarse().node_count() as i64);
            Solve::Inverse(Tensor::from_slice(&inverse).reshape([count, count]).to(device))
        })
    }

    fn with(frame: &Frame, device: Device, solve: impl FnOnce(ResidualGraph) -> Solve) -> Self {
        let graph = ResidualGraph::new(frame);
        let features = Tensor::from_slice(&graph.features).reshape([-1, FEATURES as i64]);
        Self {
            features: features.to(device),
            level: Level::new(&graph.divisor, graph.coarse(), device),
            solve: solve(graph),
        }
    }

    /// The corrections, n × c, for residuals `r`, n × c, by the network of `parameters`, which are in
    /// the order of [`seakeep_fluid::network::residual::TENSORS`].
    pub(crate) fn correction(&self, parameters: &[Tensor], matrix: &Matrix, r: &Tensor) -> Tensor {
        let [encoder, encoder_bias, gates, gates_bias] = [0, 1, 2, 3].map(|i| &parameters[i]);
        let hidden = (self.features.matmul(&encoder.tr()) + encoder_bias).relu();
        let gates = hidden.matmul(&gates.tr()) + gates_bias;
        correction(&gates, matrix, &self.level, r, |nodes| match &self.solve {
            Solve::Factors(graph) => on_processor(graph.coarse(), nodes),
            Solve::Inverse(inverse) => inverse.matmul(&nodes),
        })
    }
}

/// The correction, n × 1, for a step of a run, Pa.
pub(crate) fn of_step(step: ResidualStep<'_>, device: Device) -> Tensor {
    no_grad(|| {
        let rows = step.rows();
        let matrix = Matrix::new(&rows.start, &rows.column, &rows.value, device);
        let level = Level::new(&step.divisor(), step.coarse(), device);
        let column = |values: &[f32], width: usize| {
            Tensor::from_slice(values).reshape([-1, width as i64]).to(device)
        };
        let (gates, r) = (column(&step.gates(), GATES), column(&step.residual(), 1));
        correction(&gates, &matrix, &level, &r, |nodes| on_processor(step.coarse(), nodes))
    })
}

/// The coarse equation solved on the processor for one right-hand side, by its factors: they are banded, of a few
/// nodes, and each row waits for the one before.
fn on_processor(coarse: CoarseLevel<'_>, nodes: Tensor) -> Tensor {
    debug_assert_eq!(nodes.numel(), coarse.node_count());
    let mut values = vec![0.0f32; nodes.numel()];
    nodes.to_device(Device::Cpu).copy_data(&mut values, nodes.numel());
    coarse.solve(&mut values);
    Tensor::from_slice(&values).reshape(nodes.size()).to(nodes.device())
}

/// The corrections, n × c, for residuals `r`, n × c, by particles with these `gates`, n × [`GATES`];
/// `solve` solves the coarse equation.
fn correction(
    gates: &Tensor,
    matrix: &Matrix,
    level: &Level,
    r: &Tensor,
    solve: impl FnOnce(Tensor) -> Tensor,
) -> Tensor {
    let gates = gates * &matrix.active;
    let gate = |index: usize| gates.narrow(1, index as i64, 1);
    let (n, columns) = (r.size()[0], r.size()[1]);

    let sent = &level.weights * (&level.divisor * gate(0) * r).unsqueeze(1);
    let restricted = Tensor::zeros([level.node_count, columns], (r.kind(), r.device())).index_add(
        0,
        &level.nodes,
        &sent.reshape([4 * n, columns]),
    );
    let around = solve(restricted).index_select(0, &level.nodes).reshape([n, 4, columns]);
    let interpolated =
        (&level.weights * around).sum_dim_intlist([1i64].as_slice(), false, r.kind());
    let alone: Tensor = 1.0 - &matrix.active;
    let x = gate(1) * interpolated + gate(2) * r + alone * r;
    let left = r - matrix.product(&x);
    &x + gate(3) * left + gate(4) * r
}
