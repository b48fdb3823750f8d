//! A paddle among the boundaries of a fluid.

use crate::waves::StillWater;
use crate::waves::paddle::Board;
use crate::waves::plan::{WavePlan, WaveSource};
use nalgebra::{Point2, Vector2};
use seakeep_fluid::setup::{FluidSetup, RigidBoundary};

/// Spacings that the paddle reaches farther back than it moves: no particle sees past it.
const MARGIN: f64 = 8.0;

/// Adds the paddle of `plan`, if there is one, to the boundaries of `fluid`, for a run up to `end`
/// (s); and the fixed wall below a flap that is hinged above the bed.
pub(crate) fn add(fluid: &mut FluidSetup, plan: &WavePlan, end: f64) {
    let water = StillWater { depth: fluid.water.depth, gravity: fluid.water.gravity };
    let WaveSource::Paddle { board, absorption, .. } = plan.source else { return };
    // The checks of the case have found that there is one.
    let Ok(Some(maker)) = plan.wavemaker(water) else { return };
    let (low, high) = maker.motion().range(end);
    let mut behind = MARGIN * fluid.numerics.particle_spacing + low.abs().max(high.abs());
    if absorption.is_some() {
        // What it absorbs may take it as far back as a wave does, and farther.
        behind += 0.5 * fluid.water.depth;
    }
    let foot = match board {
        Board::Piston => 0.0,
        Board::Flap { hinge } => hinge,
    };
    fluid.tank.paddle = Some(fluid.boundaries.len());
    fluid.boundaries.push(wall("paddle", foot, behind, fluid.tank.height - foot));
    if foot > 0.0 {
        fluid.boundaries.push(wall("paddle_foot", 0.0, behind, foot));
    }
}

/// An upright wall whose face is x = 0 from the height `foot` (m) on.
fn wall(name: &str, foot: f64, thickness: f64, height: f64) -> RigidBoundary {
    let corners = [(-thickness, 0.0), (0.0, 0.0), (0.0, height), (-thickness, height)];
    RigidBoundary {
        name: name.to_owned(),
        corners: corners.map(|(x, y)| Vector2::new(x, y)).to_vec(),
        position: Point2::new(0.0, foot),
        angle: 0.0,
        free: false,
    }
}
