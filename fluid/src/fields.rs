//! What the operators of a step read.

use crate::neighbours::Neighbours;
use crate::setup::Discretisation;
use crate::walls::Walls;
use nalgebra::{Point2, Vector2};

/// Particles, walls and their neighbourhoods at the point where a step is assembled.
#[derive(Clone, Copy)]
pub(crate) struct Fields<'a> {
    pub(crate) position: &'a [Point2<f64>],
    pub(crate) velocity: &'a [Vector2<f64>],
    pub(crate) on_surface: &'a [bool],
    pub(crate) normal: &'a [Vector2<f64>],
    pub(crate) fluid: &'a Neighbours,
    pub(crate) wall_lists: &'a Neighbours,
    pub(crate) walls: &'a Walls,
    pub(crate) spacing: f64,
    pub(crate) discretisation: Discretisation,
}
