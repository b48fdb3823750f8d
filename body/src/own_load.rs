//! Loads of the bodies' own: what acts on a body besides the fluid and its weight.

use nalgebra::{Matrix3, Point2, Vector2, Vector3};
use seakeep_coupler::interface::{BoundaryKinematics, Load};
use serde::{Deserialize, Serialize};

/// A load on one body from its kinematics, evaluated within each of the body's own substeps,
/// wherever the engine asks for it, and never held over a step: a stiff restoring load that is
/// held adds energy.
///
/// Any closure `Fn(time, &kinematics) -> Load` is one.
pub trait OwnLoad: Send {
    /// Load about the centre of mass at `time` (s).
    fn load(&self, time: f64, kinematics: &BoundaryKinematics) -> Load;

    /// Whether the load depends on the velocity. If so rapier2d's step evaluates it a second time
    /// with the velocity at the midpoint, which keeps the step second order.
    fn depends_on_velocity(&self) -> bool {
        true
    }
}

impl<F: Fn(f64, &BoundaryKinematics) -> Load + Send> OwnLoad for F {
    fn load(&self, time: f64, kinematics: &BoundaryKinematics) -> Load {
        self(time, kinematics)
    }
}

/// A linear spring on all degrees of freedom about a pose of rest: F = −K (r − r₀).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LinearSpring {
    /// K, over sway, heave and roll: N/m², N/m, N m/m, per metre of width.
    pub stiffness: Matrix3<f64>,
    /// Position of the centre of mass at rest, m.
    pub rest_position: Point2<f64>,
    /// Angle at rest, rad.
    pub rest_angle: f64,
}

impl LinearSpring {
    /// Uncoupled springs in `sway`, `heave` (N/m²) and `roll` (N m/m) about `rest_position` (m)
    /// and the angle zero.
    #[must_use]
    pub fn diagonal(sway: f64, heave: f64, roll: f64, rest_position: Point2<f64>) -> Self {
        let stiffness = Matrix3::from_diagonal(&Vector3::new(sway, heave, roll));
        Self { stiffness, rest_position, rest_angle: 0.0 }
    }
}

impl OwnLoad for LinearSpring {
    fn load(&self, _time: f64, kinematics: &BoundaryKinematics) -> Load {
        let offset = kinematics.position - self.rest_position;
        let turn = kinematics.angle - self.rest_angle;
        let load = -self.stiffness * Vector3::new(offset.x, offset.y, turn);
        Load { force: Vector2::new(load.x, load.y), torque: load.z }
    }

    fn depends_on_velocity(&self) -> bool {
        false
    }
}
