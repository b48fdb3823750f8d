//! Errors of the last pressure that the data do not hold, to learn from.

use crate::graph::column;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;
use seakeep_fluid::frame::Frame;
use std::f64::consts::TAU;
use tch::{Device, Tensor};

/// Waves of a smooth error.
const MODES: usize = 3;

/// A number from 0 to 1, 1 excluded.
pub(crate) fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

/// An error that is independent from particle to particle, n × 1.
pub(crate) fn rough(random: &mut ChaCha8Rng, frame: &Frame, device: Device) -> Tensor {
    let values: Vec<f32> = (0..frame.len()).map(|_| (uniform(random) * 2.0 - 1.0) as f32).collect();
    column(&values, device)
}

/// An error of a few plane waves, of wavelengths from 2 spacings to 20 depths, n × 1.
pub(crate) fn smooth(random: &mut ChaCha8Rng, frame: &Frame, device: Device) -> Tensor {
    let (shortest, longest) = (2.0 * frame.scales.spacing, 20.0 * frame.scales.depth);
    let waves: Vec<[f64; 3]> = (0..MODES)
        .map(|_| {
            let length = shortest * (longest / shortest).powf(uniform(random));
            let (direction, phase) = (TAU * uniform(random), TAU * uniform(random));
            let number = TAU / length;
            [number * direction.cos(), number * direction.sin(), phase]
        })
        .collect();
    let at = |x: f32, y: f32| {
        let wave = |[k, l, phase]: &[f64; 3]| (k * f64::from(x) + l * f64::from(y) + phase).cos();
        waves.iter().map(wave).sum::<f64>() as f32
    };
    let points = frame.position.as_chunks::<2>().0;
    let values: Vec<f32> = points.iter().map(|[x, y]| at(*x, *y)).collect();
    column(&values, device)
}
