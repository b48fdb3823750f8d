//! Where the fluid particles stand at the start.

use crate::error::FluidError;
use crate::geometry::{placed, signed_distance};
use crate::particles::Particles;
use crate::setup::{FluidSetup, InitialSurface};
use nalgebra::Point2;
use std::f64::consts::PI;

/// An inner particle keeps this distance from a boundary, in spacings.
const CLEARANCE: f64 = 0.5;

/// Fills the tank: columns half a spacing off the side walls, the top row on the surface itself,
/// the lowest half a row above the bed; nothing inside a boundary.
pub(crate) fn fill(setup: &FluidSetup) -> Result<Particles, FluidError> {
    let dx = setup.numerics.particle_spacing;
    let columns = (setup.tank.length / dx).round() as usize;
    let rows = (setup.water.depth / dx + 0.5).floor() as usize;
    if columns == 0 || rows == 0 {
        return Err(FluidError::NoParticles { spacing: dx });
    }
    let width = setup.tank.length / columns as f64;
    let polygons: Vec<_> =
        setup.boundaries.iter().map(|b| placed(&b.corners, b.position, b.angle)).collect();
    let mut position = Vec::with_capacity(columns * rows);
    let mut on_surface = Vec::with_capacity(columns * rows);
    for column in 0..columns {
        let x = (column as f64 + 0.5) * width;
        let surface = setup.water.depth + initial_elevation(setup, x);
        let height = surface / (rows as f64 - 0.5);
        for row in (0..rows).rev() {
            let point = Point2::new(x, surface - row as f64 * height);
            if polygons.iter().all(|p| signed_distance(p, point) >= CLEARANCE * dx) {
                position.push(point);
                on_surface.push(row == 0);
            }
        }
    }
    if position.is_empty() {
        return Err(FluidError::NoParticles { spacing: dx });
    }
    Ok(Particles::at_rest(position, on_surface))
}

/// Elevation of the surface at the start, m.
pub(crate) fn initial_elevation(setup: &FluidSetup, x: f64) -> f64 {
    match setup.water.initial_surface {
        InitialSurface::Still => 0.0,
        InitialSurface::StandingWave { amplitude, half_waves } => {
            amplitude * (PI * f64::from(half_waves) / setup.tank.length * x).cos()
        }
    }
}
