//! `[coupling]`: how water and bodies are brought together in a communication step.

use super::checks::{Allowed, Checker};
use seakeep_coupler::{Acceleration, Coupling, Extrapolation, Implicit, Scheme};
use serde::{Deserialize, Serialize};

/// Most steps that a side takes in a communication step.
const MAX_SUBSTEPS: f64 = 1000.0;
/// Communication steps that IQN-ILS uses again where a case names no number.
const REUSED_STEPS: u32 = 2;

/// `[coupling]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table")]
pub struct CouplingKeys {
    /// Scheme.
    pub scheme: SchemeName,
    /// How inputs vary over the steps of a side and how they are predicted.
    pub extrapolation: ExtrapolationName,
    /// Time steps of the water in a communication step.
    pub fluid_substeps: u32,
    /// Steps of the bodies in a communication step.
    pub body_substeps: u32,
    /// Acceleration of an implicit scheme.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub acceleration: Option<AccelerationName>,
    /// First, or constant, relaxation of an implicit scheme.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relaxation: Option<f64>,
    /// Residual at which an implicit scheme stops, relative to the accelerations of the bodies.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tolerance: Option<f64>,
    /// Evaluations of the load after which a step of an implicit scheme has failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub max_iterations: Option<u32>,
    /// Communication steps that IQN-ILS uses again.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reused_steps: Option<u32>,
}

impl Default for CouplingKeys {
    fn default() -> Self {
        Self {
            scheme: SchemeName::InterfaceJacobian,
            extrapolation: ExtrapolationName::Hold,
            fluid_substeps: 1,
            body_substeps: 1,
            acceleration: None,
            relaxation: None,
            tolerance: None,
            max_iterations: None,
            reused_steps: None,
        }
    }
}

/// Name of a scheme.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SchemeName {
    /// [`Scheme::InterfaceJacobian`]
    InterfaceJacobian,
    /// [`Scheme::Jacobi`]
    Jacobi,
    /// [`Scheme::GaussSeidel`]
    GaussSeidel,
    /// [`Scheme::Implicit`]
    Implicit,
}

impl SchemeName {
    /// Name in case files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::InterfaceJacobian => "interface_jacobian",
            Self::Jacobi => "jacobi",
            Self::GaussSeidel => "gauss_seidel",
            Self::Implicit => "implicit",
        }
    }
}

/// Name of an acceleration.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AccelerationName {
    /// [`Acceleration::Constant`]
    Constant,
    /// [`Acceleration::Aitken`]
    Aitken,
    /// [`Acceleration::IqnIls`]
    IqnIls,
}

/// Name of an extrapolation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ExtrapolationName {
    /// [`Extrapolation::Hold`]
    Hold,
    /// [`Extrapolation::Linear`]
    Linear,
    /// [`Extrapolation::Quadratic`]
    Quadratic,
}

impl CouplingKeys {
    /// All numbers outside their ranges, and keys that the scheme has no use for.
    pub(super) fn check(&self, check: &mut Checker<'_>) {
        let key = |name: &str| format!("coupling.{name}");
        let substeps = Allowed::from(1.0, MAX_SUBSTEPS);
        check.number(&key("fluid_substeps"), f64::from(self.fluid_substeps), substeps);
        check.number(&key("body_substeps"), f64::from(self.body_substeps), substeps);
        let numbers = [
            ("relaxation", self.relaxation, Allowed::above(0.0, 1.0)),
            ("tolerance", self.tolerance, Allowed::from(1e-12, 0.1)),
            ("max_iterations", self.max_iterations.map(f64::from), Allowed::from(1.0, 1000.0)),
            ("reused_steps", self.reused_steps.map(f64::from), Allowed::from(0.0, 100.0)),
        ];
        for (name, value, allowed) in numbers {
            if let Some(value) = value {
                check.number(&key(name), value, allowed);
            }
        }
        let given = [
            ("acceleration", self.acceleration.is_some()),
            ("relaxation", self.relaxation.is_some()),
            ("tolerance", self.tolerance.is_some()),
            ("max_iterations", self.max_iterations.is_some()),
            ("reused_steps", self.reused_steps.is_some()),
        ];
        for (name, given) in given {
            let used = self.scheme == SchemeName::Implicit;
            check.require(used || !given, &key(name), || {
                "only the scheme \"implicit\" has it".to_owned()
            });
        }
        let used = self.acceleration.is_none_or(|name| name == AccelerationName::IqnIls);
        check.require(used || self.reused_steps.is_none(), &key("reused_steps"), || {
            "only the acceleration \"iqn_ils\" has it".to_owned()
        });
    }

    /// The same with nothing left to a default. Several steps of the water are repeated for each
    /// evaluation, and are the same again only as far as its pressure tolerance tells.
    pub(super) fn resolve(mut self, pressure_tolerance: f64) -> Self {
        if self.scheme != SchemeName::Implicit {
            return self;
        }
        let default = Implicit::default();
        let least = if self.fluid_substeps > 1 { pressure_tolerance } else { 0.0 };
        self.tolerance.get_or_insert(default.tolerance.max(least));
        self.relaxation.get_or_insert(default.relaxation);
        self.max_iterations.get_or_insert(default.max_iterations);
        let acceleration = *self.acceleration.get_or_insert(AccelerationName::IqnIls);
        if acceleration == AccelerationName::IqnIls {
            self.reused_steps.get_or_insert(REUSED_STEPS);
        }
        self
    }

    /// The coupling in the terms of the master.
    pub(crate) fn coupling(&self) -> Coupling {
        let default = Implicit::default();
        let acceleration = match self.acceleration {
            Some(AccelerationName::Constant) => Acceleration::Constant,
            Some(AccelerationName::Aitken) => Acceleration::Aitken,
            Some(AccelerationName::IqnIls) | None => {
                Acceleration::IqnIls { reused_steps: self.reused_steps.unwrap_or(REUSED_STEPS) }
            }
        };
        Coupling {
            scheme: match self.scheme {
                SchemeName::InterfaceJacobian => Scheme::InterfaceJacobian,
                SchemeName::Jacobi => Scheme::Jacobi,
                SchemeName::GaussSeidel => Scheme::GaussSeidel,
                SchemeName::Implicit => Scheme::Implicit(Implicit {
                    acceleration,
                    relaxation: self.relaxation.unwrap_or(default.relaxation),
                    tolerance: self.tolerance.unwrap_or(default.tolerance),
                    max_iterations: self.max_iterations.unwrap_or(default.max_iterations),
                }),
            },
            load_substeps: self.fluid_substeps,
            motion_substeps: self.body_substeps,
            extrapolation: match self.extrapolation {
                ExtrapolationName::Hold => Extrapolation::Hold,
                ExtrapolationName::Linear => Extrapolation::Linear,
                ExtrapolationName::Quadratic => Extrapolation::Quadratic,
            },
        }
    }
}
