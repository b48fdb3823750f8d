//! The keys of mooring lines in a case file.

use super::body_keys::default_body_name;
use serde::{Deserialize, Serialize};

/// `[[mooring]]`: a line from a fairlead on a body to an anchor.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct MooringKeys {
    /// Name in the table.
    pub name: String,
    /// Name of the body.
    #[serde(default = "default_body_name")]
    pub body: String,
    /// Where it is fastened to the body, in the frame in which the body's shape is given, m.
    pub fairlead_m: [f64; 2],
    /// Where it is fastened to the ground, m.
    pub anchor_m: [f64; 2],
    /// What it answers to the distance of its ends.
    #[serde(default)]
    pub kind: LineKind,
    /// Spring: tension for each metre of elongation, N/m².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stiffness_n_m2: Option<f64>,
    /// Spring: tension for each metre a second of lengthening, N s/m²; none if absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping_n_s_m2: Option<f64>,
    /// Spring: tension with the body in its equilibrium, N/m. Instead of the length; found from
    /// static equilibrium if both are absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pretension_n_m: Option<f64>,
    /// Length without tension, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub unstretched_length_m: Option<f64>,
    /// Catenary: tension for each strain, N/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub axial_stiffness_n_m: Option<f64>,
    /// Catenary: weight in water of each metre of unstretched line, N/m².
    #[serde(skip_serializing_if = "Option::is_none")]
    pub weight_n_m2: Option<f64>,
}

/// What a line answers to the distance of its ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LineKind {
    /// A light spring with slack, Eq. (32).
    #[default]
    Spring,
    /// A heavy elastic line at rest.
    Catenary,
}
