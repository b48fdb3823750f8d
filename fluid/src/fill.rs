//! Where the fluid particles stand at the start.

use crate::error::FluidError;
use crate::geometry::{placed, signed_distance};
use crate::particles::Particles;
use crate::setup::{FluidSetup, InitialFlow};
use nalgebra::Point2;

/// Lattice particles nearer to a boundary than this, in spacings, are left out. On average over the
/// places of lattice and boundary the water is then as full of particles there as elsewhere.
const CLEARANCE: f64 = 0.05;

/// Fills the tank with water that flows like `flow`: columns half a spacing off the side walls, the
/// top row on the surface itself, the lowest half a row above the bed; nothing inside a boundary.
/// Also says whether a boundary cuts the lattice.
pub(crate) fn fill(
    setup: &FluidSetup,
    flow: &dyn InitialFlow,
) -> Result<(Particles, bool), FluidError> {
    let dx = setup.numerics.particle_spacing;
    // Particles on a free face stand on it, those at a wall half a spacing off.
    let reach = flow.reach().filter(|reach| *reach < setup.tank.length);
    let columns = match reach {
        Some(reach) => (reach / dx + 0.5).floor() as usize,
        None => (setup.tank.length / dx).round() as usize,
    };
    let rows = (setup.water.depth / dx + 0.5).floor() as usize;
    if columns == 0 || rows == 0 {
        return Err(FluidError::NoParticles { spacing: dx });
    }
    let width = match reach {
        Some(reach) => reach / (columns as f64 - 0.5),
        None => setup.tank.length / columns as f64,
    };
    let polygons: Vec<_> =
        setup.boundaries.iter().map(|b| placed(&b.corners, b.position, b.angle)).collect();
    let mut position = Vec::with_capacity(columns * rows);
    let mut on_surface = Vec::with_capacity(columns * rows);
    let mut cut = false;
    for column in 0..columns {
        for row in (0..rows).rev() {
            let off = flow.displacement((column * rows + row) as u64);
            let x = (column as f64 + 0.5) * width + off.x;
            let surface = setup.water.depth + flow.elevation(x);
            let height = surface / (rows as f64 - 0.5);
            let below = if row == 0 { 0.0 } else { row as f64 * height - off.y };
            let point = Point2::new(x, surface - below);
            if polygons.iter().all(|p| signed_distance(p, point) >= CLEARANCE * dx) {
                position.push(point);
                on_surface.push(row == 0 || (reach.is_some() && column + 1 == columns));
            } else {
                cut = true;
            }
        }
    }
    if position.is_empty() {
        return Err(FluidError::NoParticles { spacing: dx });
    }
    let mut particles = Particles::at_rest(position, on_surface);
    for (velocity, position) in particles.velocity.iter_mut().zip(&particles.position) {
        *velocity = flow.velocity(*position);
    }
    Ok((particles, cut))
}
