//! The fluid particles.

use nalgebra::{Point2, Vector2};
use serde::{Deserialize, Serialize};

/// State of the fluid particles, as a structure of arrays.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Particles {
    /// Position, m.
    pub(crate) position: Vec<Point2<f64>>,
    /// Velocity, m/s.
    pub(crate) velocity: Vec<Vector2<f64>>,
    /// Dynamic pressure p_d = p + ρ g (y − D) of the last step, Pa.
    pub(crate) pressure: Vec<f64>,
    /// Change of the dynamic pressure over a step, Pa: the mean of the solver's `steps_of_change`.
    pub(crate) pressure_change: Vec<f64>,
    /// Divergence near walls that the pressure of the steps before asked for in vain, 1/s; see
    /// [`crate::pressure::repeated`].
    pub(crate) vain_divergence: Vec<f64>,
    /// Part of the last step's pressure that is no load, Pa; see [`crate::pressure::repeated`].
    pub(crate) repeated_pressure: Vec<[f64; 1]>,
    /// Whether the particle is on the free surface.
    pub(crate) on_surface: Vec<bool>,
    /// Identity, kept when particles are renumbered.
    pub(crate) identity: Vec<u32>,
}

impl Particles {
    /// Particles at rest at `position`, on the surface where `on_surface` says so.
    pub(crate) fn at_rest(position: Vec<Point2<f64>>, on_surface: Vec<bool>) -> Self {
        let count = position.len();
        Self {
            velocity: vec![Vector2::zeros(); count],
            pressure: vec![0.0; count],
            pressure_change: vec![0.0; count],
            vain_divergence: vec![0.0; count],
            repeated_pressure: vec![[0.0]; count],
            identity: (0..count as u32).collect(),
            position,
            on_surface,
        }
    }

    pub(crate) fn len(&self) -> usize {
        self.position.len()
    }
}

/// Reorders `values` so that the new i-th is the old `order[i]`-th; what is not in `order` goes.
pub(crate) fn permute<T: Copy>(values: &mut Vec<T>, order: &[u32], scratch: &mut Vec<T>) {
    scratch.clear();
    scratch.extend(order.iter().map(|&old| values[old as usize]));
    std::mem::swap(values, scratch);
}
