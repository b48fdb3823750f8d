//! The keys of bodies in a case file.

use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// `[[body]]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct BodyKeys {
    /// Name in the tables.
    #[serde(default = "default_body_name")]
    pub name: String,
    /// Shape: a rectangle. Either this or `corners_m`.
    #[serde(rename = "box", skip_serializing_if = "Option::is_none")]
    pub rectangle: Option<BoxKeys>,
    /// Shape: corners of a simple polygon at angle 0, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub corners_m: Option<Vec<[f64; 2]>>,
    /// Centre of mass at the start, m.
    pub position_m: [f64; 2],
    /// Position that sway and heave in `motion.csv` are relative to, m; `position_m` if absent.
    pub equilibrium_m: Option<[f64; 2]>,
    /// Angle at the start, degrees, counter-clockwise.
    #[serde(default)]
    pub angle_deg: f64,
    /// Mass, kg/m. Either this and the inertia, or the density.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mass_kg_m: Option<f64>,
    /// Moment of inertia about the centre of mass, kg m²/m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub inertia_kg_m2_m: Option<f64>,
    /// Uniform density that mass and inertia follow from, kg/m³.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub density_kg_m3: Option<f64>,
    /// Centre of mass in the frame in which the shape is given, m; without it the centroid where
    /// the density is given, and the frame's origin otherwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub centre_of_mass_m: Option<[f64; 2]>,
    /// Whether it is a container with the water in it, which a prescribed motion moves.
    #[serde(default, skip_serializing_if = "is_false")]
    pub holds_water: bool,
    /// Directions in which it moves; none for a held body.
    #[serde(default = "all_directions")]
    pub free: Vec<Direction>,
    /// What moves it.
    #[serde(default)]
    pub engine: EngineName,
    /// How it moves if that is prescribed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub motion: Option<MotionKeys>,
}

impl BodyKeys {
    /// Whether it moves in sway, heave and roll.
    pub(crate) fn free_directions(&self) -> [bool; 3] {
        [Direction::Sway, Direction::Heave, Direction::Roll].map(|d| self.free.contains(&d))
    }
}

/// What moves a body.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EngineName {
    /// rapier2d, with contacts.
    #[default]
    Rapier,
    /// Newton's and Euler's equations, of fourth order, without contacts.
    NewtonEuler,
    /// It follows `motion`, whatever the loads.
    Prescribed,
}

/// `[body.motion]`: either `file`, or some of `sway`, `heave` and `roll`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct MotionKeys {
    /// A table (CSV) with the columns `time_s`, `sway_m`, `heave_m` and `roll_rad`, relative to
    /// the case file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Oscillation along x about the equilibrium.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sway: Option<TranslationKeys>,
    /// Oscillation along y about the equilibrium.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub heave: Option<TranslationKeys>,
    /// Rotation about the upright.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub roll: Option<RotationKeys>,
    /// Time over which the oscillation rises from rest, s.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub ramp_s: f64,
}

/// `[body.motion.sway]` and `[body.motion.heave]`: amplitude sin(2π t / period + phase).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct TranslationKeys {
    /// Amplitude, m.
    pub amplitude_m: f64,
    /// Period, s.
    pub period_s: f64,
    /// Phase, degrees.
    #[serde(default)]
    pub phase_deg: f64,
}

/// `[body.motion.roll]`: amplitude sin(2π t / period + phase).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct RotationKeys {
    /// Amplitude, degrees.
    pub amplitude_deg: f64,
    /// Period, s.
    pub period_s: f64,
    /// Phase, degrees.
    #[serde(default)]
    pub phase_deg: f64,
}

/// `[contact]`: contacts that rapier resolves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table")]
pub struct ContactKeys {
    /// Speed after over speed before a collision, along the normal.
    pub restitution: f64,
    /// Coefficient of Coulomb friction.
    pub friction: f64,
}

/// `[body.box]`: a rectangle about the origin of the body's frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct BoxKeys {
    /// Width (along x at angle 0), m.
    pub width_m: f64,
    /// Height (along y at angle 0), m.
    pub height_m: f64,
}

/// A direction of motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// Along x.
    Sway,
    /// Along y.
    Heave,
    /// Rotation, counter-clockwise.
    Roll,
}

pub(super) fn default_body_name() -> String {
    "body".to_owned()
}

fn all_directions() -> Vec<Direction> {
    vec![Direction::Sway, Direction::Heave, Direction::Roll]
}

fn is_false(value: &bool) -> bool {
    !value
}

fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
