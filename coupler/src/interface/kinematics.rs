//! The typed quantities that cross an interface.

use nalgebra::{DMatrix, Point2, Vector2};
use serde::{Deserialize, Serialize};

/// Kinematics of one rigid boundary in the plane, at its reference point (the centre of mass).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BoundaryKinematics {
    /// Position of the reference point, m.
    pub position: Point2<f64>,
    /// Angle, counter-clockwise, rad.
    pub angle: f64,
    /// Velocity of the reference point, m/s.
    pub velocity: Vector2<f64>,
    /// Angular velocity, rad/s.
    pub angular_velocity: f64,
    /// Acceleration of the reference point, m/s².
    pub acceleration: Vector2<f64>,
    /// Angular acceleration, rad/s².
    pub angular_acceleration: f64,
}

impl BoundaryKinematics {
    /// A boundary at rest at `position` (m) and `angle` (rad).
    #[must_use]
    pub fn at_rest(position: Point2<f64>, angle: f64) -> Self {
        Self {
            position,
            angle,
            velocity: Vector2::zeros(),
            angular_velocity: 0.0,
            acceleration: Vector2::zeros(),
            angular_acceleration: 0.0,
        }
    }

    /// Velocity of the material point at `point` (m): u_b = V + Ω × (r_b − r_G), Eq. (17), m/s.
    #[must_use]
    pub fn velocity_at(&self, point: Point2<f64>) -> Vector2<f64> {
        let arm = point - self.position;
        self.velocity + self.angular_velocity * Vector2::new(-arm.y, arm.x)
    }

    /// The same boundary `duration` (s) later at constant velocity.
    #[must_use]
    pub fn drifted(&self, duration: f64) -> Self {
        Self {
            position: self.position + self.velocity * duration,
            angle: self.angle + self.angular_velocity * duration,
            ..*self
        }
    }
}

/// Force and torque on a rigid boundary, per metre of width.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Load {
    /// Force, N/m.
    pub force: Vector2<f64>,
    /// Torque about the reference point, counter-clockwise, N m/m.
    pub torque: f64,
}

impl Load {
    /// No load.
    #[must_use]
    pub fn zero() -> Self {
        Self { force: Vector2::zeros(), torque: 0.0 }
    }
}

/// Load on all boundaries as an affine function of their accelerations: F = F₀ − A a.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LoadResponse {
    /// F₀, the load on each boundary at zero acceleration.
    pub at_zero_acceleration: Vec<Load>,
    /// A = −∂F/∂a, the added-mass matrix, square with three rows (x, y, angle) a boundary:
    /// kg/m, kg, kg m²/m. A component without feedthrough leaves it zero.
    pub added_mass: DMatrix<f64>,
}

impl LoadResponse {
    /// No load and no added mass on `boundaries` boundaries.
    #[must_use]
    pub fn zero(boundaries: usize) -> Self {
        Self {
            at_zero_acceleration: vec![Load::zero(); boundaries],
            added_mass: DMatrix::zeros(3 * boundaries, 3 * boundaries),
        }
    }

    /// Writes F₀ − A a for the accelerations `[x, y, angle]` of each boundary into `loads`.
    ///
    /// # Panics
    /// When the lengths do not fit the number of boundaries.
    pub fn at(&self, accelerations: &[f64], loads: &mut [Load]) {
        assert_eq!(accelerations.len(), self.added_mass.ncols(), "three accelerations a boundary");
        assert_eq!(loads.len(), self.at_zero_acceleration.len(), "one load a boundary");
        for (body, (load, zero)) in loads.iter_mut().zip(&self.at_zero_acceleration).enumerate() {
            let reaction = |row: usize| -> f64 {
                accelerations
                    .iter()
                    .enumerate()
                    .map(|(column, a)| self.added_mass[(3 * body + row, column)] * a)
                    .sum()
            };
            load.force = zero.force - Vector2::new(reaction(0), reaction(1));
            load.torque = zero.torque - reaction(2);
        }
    }
}
