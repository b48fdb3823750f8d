//! A frame as tensors.

use seakeep_fluid::frame::Frame;
use tch::{Device, Kind, Tensor};

/// The pressure matrix A of n particles, with a unit diagonal.
pub(crate) struct Matrix {
    start: Tensor,
    column: Tensor,
    value: Tensor,
    /// 0 for a row that stands alone, as those of the surface do, otherwise 1: n × 1.
    pub(crate) active: Tensor,
}

impl Matrix {
    /// That with these off-diagonal entries in its rows.
    pub(crate) fn new(start: &[u32], columns: &[u32], values: &[f32], device: Device) -> Self {
        let start = indices(start, device);
        let count = start.size()[0] - 1;
        let active = start.narrow(0, 0, count).less_tensor(&start.narrow(0, 1, count));
        Self {
            active: active.to_kind(Kind::Float).unsqueeze(1),
            start,
            column: indices(columns, device),
            value: Tensor::from_slice(values).to(device),
        }
    }

    /// A x for x of n × c.
    pub(crate) fn product(&self, x: &Tensor) -> Tensor {
        /// Mode of `embedding_bag` that adds up.
        const SUM: i64 = 0;
        let (sums, _, _, _) = Tensor::embedding_bag(
            x,
            &self.column,
            &self.start,
            false,
            SUM,
            false,
            Some(&self.value),
            true,
        );
        x + sums
    }
}

/// What all networks need of a frame of n particles.
pub(crate) struct Graph {
    pub(crate) matrix: Matrix,
    /// Weights s of Eq. (29), n × 1.
    pub(crate) weight: Tensor,
    /// b − A p of the last pressure, n × 1, in units of `scale`.
    pub(crate) residual: Tensor,
    /// Exact minus last pressure, n × 1, in units of `scale`.
    pub(crate) target: Tensor,
    /// Root mean square of the target or, where it is not known, of the residual, Pa.
    pub(crate) scale: f64,
    /// Number of particles.
    pub(crate) count: i64,
}

impl Graph {
    pub(crate) fn new(frame: &Frame, device: Device) -> Self {
        let count = frame.len() as i64;
        let size = |values: &[f32]| -> f64 {
            let square: f64 = values.iter().map(|v| f64::from(*v).powi(2)).sum();
            (square / count.max(1) as f64).sqrt()
        };
        // Within a run the target is not known; in water at rest there is nothing to find.
        let sizes = [size(&frame.target), size(&frame.residual)];
        let scale = sizes.into_iter().find(|size| *size > 0.0).unwrap_or(1.0);
        let scaled = |values: &[f32]| -> Vec<f32> {
            values.iter().map(|value| (f64::from(*value) / scale) as f32).collect()
        };
        // Eq. (29).
        let weight = |distance: &f32| match *distance {
            d if d <= 3.0 => 3.0,
            d if d <= 6.0 => 2.0,
            _ => 1.0,
        };
        let weight: Vec<f32> = frame.wall_distance.iter().map(weight).collect();
        let matrix = Matrix::new(&frame.row_start, &frame.column, &frame.value, device);
        Self {
            weight: column(&weight, device) * &matrix.active,
            matrix,
            residual: column(&scaled(&frame.residual), device),
            target: column(&scaled(&frame.target), device),
            scale,
            count,
        }
    }
}

/// Values as a column, n × 1.
pub(crate) fn column(values: &[f32], device: Device) -> Tensor {
    Tensor::from_slice(values).unsqueeze(1).to(device)
}

/// Indices in a type that libtorch takes: particles and entries are fewer than 2³¹.
pub(crate) fn indices(values: &[u32], device: Device) -> Tensor {
    let values: Vec<i32> = values.iter().map(|value| value.cast_signed()).collect();
    Tensor::from_slice(&values).to(device)
}
