//! The keys of waves: `[wave]`, `[wavemaker]`, `[initial_wave]`.

use crate::waves::solitary::SolitaryTheory;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// `[wave]`: which keys there may be depends on the kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct WaveKeys {
    /// What kind of wave.
    pub kind: WaveKind,
    /// Height from trough to crest, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub height_m: Option<f64>,
    /// Period, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_s: Option<f64>,
    /// Harmonics of a stream-function wave.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub order: Option<u32>,
    /// Theory of a solitary wave.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub theory: Option<SolitaryTheory>,
    /// Significant height 4 √m₀, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub significant_height_m: Option<f64>,
    /// Peak period, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_period_s: Option<f64>,
    /// Peak enhancement γ of JONSWAP; 1 for Pierson and Moskowitz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_enhancement: Option<f64>,
    /// Highest frequency of a spectrum over that of its peak.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub highest_over_peak: Option<f64>,
    /// Number of components.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub components: Option<u32>,
    /// Seed of the random phases.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// Linear crest elevation of a group at its focus, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub amplitude_m: Option<f64>,
    /// Where a group focuses, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focus_x_m: Option<f64>,
    /// When a group focuses, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub focus_time_s: Option<f64>,
    /// Lowest frequency of a group of equal steepness, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lowest_frequency_hz: Option<f64>,
    /// Highest frequency of a group of equal steepness, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub highest_frequency_hz: Option<f64>,
    /// File with a motion of the paddle, relative to the case file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Times of a recorded motion, s: what a file is resolved into.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub times_s: Option<Vec<f64>>,
    /// Displacements of a piston at these times, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub positions_m: Option<Vec<f64>>,
    /// Angles of a flap at these times, rad.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angles_rad: Option<Vec<f64>>,
}

/// What kind of wave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WaveKind {
    /// Regular, first order.
    Linear,
    /// Regular, second order.
    Stokes,
    /// Regular, any order.
    StreamFunction,
    /// Irregular, with a JONSWAP spectrum.
    Jonswap,
    /// Irregular, with a Pierson-Moskowitz spectrum.
    PiersonMoskowitz,
    /// Focused, in proportion to a JONSWAP spectrum.
    NewWave,
    /// Focused, all components equally steep.
    EqualSteepness,
    /// Solitary.
    Solitary,
    /// What a recorded motion of the paddle makes.
    Recorded,
}

/// `[wavemaker]`: the wave is made by a paddle at x = 0.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct WavemakerKeys {
    /// What it looks like.
    #[serde(rename = "type")]
    pub board: BoardKind,
    /// Height of a flap's hinge above the bed, m; below it where negative.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hinge_m: Option<f64>,
    /// Time to full stroke, in periods of the wave or of the peak of its spectrum.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ramp_periods: Option<f64>,
    /// Whether and how it absorbs waves that come back to it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub active_absorption: Option<AbsorptionKeys>,
}

/// What a paddle looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BoardKind {
    /// An upright wall that moves horizontally.
    Piston,
    /// A wall that turns about a hinge.
    Flap,
}

/// `[wavemaker.active_absorption]`
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct AbsorptionKeys {
    /// Time in which the paddle falls back to rest, s; without it ten periods.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub return_time_s: Option<f64>,
}

/// `[initial_wave]`: the wave is in the tank at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct InitialWaveKeys {
    /// Where a crest is at the start, m.
    pub crest_m: f64,
}

impl WaveKind {
    /// The keys that waves of this kind need, and those they may have.
    #[must_use]
    pub(super) fn keys(self) -> (&'static [&'static str], &'static [&'static str]) {
        match self {
            Self::Linear | Self::Stokes => (&["height_m", "period_s"], &[]),
            Self::StreamFunction => (&["height_m", "period_s"], &["order"]),
            Self::Jonswap => (
                &["significant_height_m", "peak_period_s"],
                &["peak_enhancement", "highest_over_peak", "components", "seed"],
            ),
            Self::PiersonMoskowitz => (
                &["significant_height_m", "peak_period_s"],
                &["highest_over_peak", "components", "seed"],
            ),
            Self::NewWave => (
                &["amplitude_m", "focus_x_m", "focus_time_s", "peak_period_s"],
                &["peak_enhancement", "highest_over_peak", "components"],
            ),
            Self::EqualSteepness => (
                &[
                    "amplitude_m",
                    "focus_x_m",
                    "focus_time_s",
                    "lowest_frequency_hz",
                    "highest_frequency_hz",
                ],
                &["components"],
            ),
            Self::Solitary => (&["height_m"], &["theory"]),
            Self::Recorded => (&[], &["file", "times_s", "positions_m", "angles_rad"]),
        }
    }

    /// The name of the kind in a case file.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Stokes => "stokes",
            Self::StreamFunction => "stream_function",
            Self::Jonswap => "jonswap",
            Self::PiersonMoskowitz => "pierson_moskowitz",
            Self::NewWave => "new_wave",
            Self::EqualSteepness => "equal_steepness",
            Self::Solitary => "solitary",
            Self::Recorded => "recorded",
        }
    }
}

impl WaveKeys {
    /// Every key but the kind, and whether it is given.
    pub(super) fn given(&self) -> [(&'static str, bool); 19] {
        [
            ("height_m", self.height_m.is_some()),
            ("period_s", self.period_s.is_some()),
            ("order", self.order.is_some()),
            ("theory", self.theory.is_some()),
            ("significant_height_m", self.significant_height_m.is_some()),
            ("peak_period_s", self.peak_period_s.is_some()),
            ("peak_enhancement", self.peak_enhancement.is_some()),
            ("highest_over_peak", self.highest_over_peak.is_some()),
            ("components", self.components.is_some()),
            ("seed", self.seed.is_some()),
            ("amplitude_m", self.amplitude_m.is_some()),
            ("focus_x_m", self.focus_x_m.is_some()),
            ("focus_time_s", self.focus_time_s.is_some()),
            ("lowest_frequency_hz", self.lowest_frequency_hz.is_some()),
            ("highest_frequency_hz", self.highest_frequency_hz.is_some()),
            ("file", self.file.is_some()),
            ("times_s", self.times_s.is_some()),
            ("positions_m", self.positions_m.is_some()),
            ("angles_rad", self.angles_rad.is_some()),
        ]
    }
}
