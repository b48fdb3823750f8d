//! Tensions that hold a body in a place.

use nalgebra::{DMatrix, DVector, Vector2};
use seakeep_coupler::interface::Load;

/// A line whose tension is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UnknownTension {
    /// Fairlead relative to the centre of mass, as the body stands, m.
    pub arm: Vector2<f64>,
    /// From the fairlead to the anchor, m; any length.
    pub direction: Vector2<f64>,
}

/// Tensions (N/m) of `lines` that hold a body against `load` on its `free` degrees of freedom
/// (sway, heave, roll); where several sets do, the one with the least sum of squares.
///
/// `None` where no set does, or where this one needs a line to push.
#[must_use]
pub fn static_tensions(lines: &[UnknownTension], load: &Load, free: [bool; 3]) -> Option<Vec<f64>> {
    let rows: Vec<usize> = (0..3).filter(|row| free[*row]).collect();
    let loads = [load.force.x, load.force.y, load.torque];
    let pull = |line: &UnknownTension| {
        let unit = line.direction.normalize();
        [unit.x, unit.y, line.arm.perp(&unit)]
    };
    let pulls: Vec<[f64; 3]> = lines.iter().map(pull).collect();
    let matrix = DMatrix::from_fn(rows.len(), lines.len(), |r, c| pulls[c][rows[r]]);
    let wanted = DVector::from_iterator(rows.len(), rows.iter().map(|row| -loads[*row]));
    if lines.is_empty() || rows.is_empty() {
        return (wanted.norm() == 0.0).then(|| vec![0.0; lines.len()]);
    }
    let tensions = matrix.clone().svd(true, true).solve(&wanted, 1e-9).ok()?;
    let scale = wanted.norm().max(f64::MIN_POSITIVE);
    let held = (matrix * &tensions - &wanted).norm() <= 1e-6 * scale;
    let pulling = tensions.iter().all(|tension| *tension >= -1e-9 * scale);
    (held && pulling).then(|| tensions.iter().map(|tension| tension.max(0.0)).collect())
}
