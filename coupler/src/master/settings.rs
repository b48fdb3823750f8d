//! What a coupling is asked to be.

use crate::CouplerError;
use serde::{Deserialize, Serialize};

/// Scheme and rates of a coupling. The default is [`Scheme::InterfaceJacobian`], a step for a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Coupling {
    /// How load and motion are brought together in a communication step.
    pub scheme: Scheme,
    /// Steps that the load component takes in a communication step, at least 1.
    pub load_substeps: u32,
    /// Steps that the motion component takes in a communication step, at least 1.
    pub motion_substeps: u32,
    /// How an input varies over the steps of a component, and how it is predicted.
    pub extrapolation: Extrapolation,
}

impl Default for Coupling {
    fn default() -> Self {
        Self {
            scheme: Scheme::InterfaceJacobian,
            load_substeps: 1,
            motion_substeps: 1,
            extrapolation: Extrapolation::Hold,
        }
    }
}

/// How load and motion are brought together in a communication step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Scheme {
    /// The motion component solves (M + A) a = F₀ + F_own with the load component's own response
    /// F = F₀ − A a: one evaluation, stable for any added mass.
    InterfaceJacobian,
    /// Parallel: both components step with inputs predicted from the communication steps before.
    /// One evaluation.
    Jacobi,
    /// Serial: the load component steps with predicted accelerations, the motion component with
    /// the load that follows. One evaluation.
    GaussSeidel,
    /// The step is repeated until the accelerations that the load component is told are those
    /// that its load makes.
    Implicit(Implicit),
}

/// Parameters of [`Scheme::Implicit`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Implicit {
    /// How the next accelerations are found from those before.
    pub acceleration: Acceleration,
    /// Part of the residual by which the first change goes, above 0 and at most 1.
    pub relaxation: f64,
    /// Residual at which the iteration ends, relative to the accelerations, above 0 and below 1.
    pub tolerance: f64,
    /// Evaluations after which the step has failed, at least 1.
    pub max_iterations: u32,
}

impl Default for Implicit {
    fn default() -> Self {
        Self {
            acceleration: Acceleration::IqnIls { reused_steps: 2 },
            relaxation: 0.5,
            tolerance: 1e-6,
            max_iterations: 50,
        }
    }
}

/// Acceleration of a fixed-point iteration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Acceleration {
    /// The same relaxation throughout.
    Constant,
    /// Aitken's dynamic relaxation (Küttler and Wall, Comput. Mech. 43, 2008).
    Aitken,
    /// Interface quasi-Newton with an inverse Jacobian from least squares (Degroote, Bathe and
    /// Vierendeels, Comput. Struct. 87, 2009).
    IqnIls {
        /// Communication steps whose differences are used again.
        reused_steps: u32,
    },
}

/// Degree of the polynomial through the means of an input over the last communication steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Extrapolation {
    /// The last value.
    Hold,
    /// A straight line through the last two.
    Linear,
    /// A parabola through the last three.
    Quadratic,
}

impl Extrapolation {
    /// Values that the polynomial goes through.
    pub(super) fn values(self) -> usize {
        match self {
            Self::Hold => 1,
            Self::Linear => 2,
            Self::Quadratic => 3,
        }
    }
}

impl Coupling {
    /// Refuses a value outside its range.
    pub(super) fn validate(&self) -> Result<(), CouplerError> {
        let positive = "at least 1";
        let substeps = |name, value: u32| (name, f64::from(value), value >= 1, positive);
        let mut checks = vec![
            substeps("load substeps", self.load_substeps),
            substeps("motion substeps", self.motion_substeps),
        ];
        if let Scheme::Implicit(implicit) = self.scheme {
            let Implicit { relaxation, tolerance, max_iterations, .. } = implicit;
            checks.extend([
                ("relaxation", relaxation, relaxation > 0.0 && relaxation <= 1.0, "in (0, 1]"),
                ("tolerance", tolerance, tolerance > 0.0 && tolerance < 1.0, "in (0, 1)"),
                ("iterations", f64::from(max_iterations), max_iterations >= 1, positive),
            ]);
        }
        match checks.into_iter().find(|(.., holds, _)| !holds) {
            None => Ok(()),
            Some((setting, value, _, allowed)) => {
                Err(CouplerError::Setting { setting, value, allowed })
            }
        }
    }
}
