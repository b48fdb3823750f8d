//! Campaign files: which waves, how many, in which ranges.

use crate::waves::StillWater;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use thiserror::Error;

const GRAVITY: f64 = 9.81;

/// Why there is no campaign.
#[derive(Debug, Error)]
pub enum CampaignError {
    /// The file cannot be read.
    #[error("{}: cannot be read: {source}", .path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is no campaign.
    #[error("{}: {message}", .path.display())]
    Parse {
        /// The file.
        path: PathBuf,
        /// What is wrong, on one line.
        message: String,
    },
    /// A value out of range.
    #[error("{}: group {group}: {key}: {reason}", .path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// Name of the group.
        group: String,
        /// The key.
        key: &'static str,
        /// What is wrong.
        reason: &'static str,
    },
}

/// A campaign file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Campaign {
    /// Seed of everything that is drawn.
    pub seed: u64,
    /// Groups of cases.
    pub group: Vec<Group>,
}

/// Cases of one kind.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Group {
    /// First part of the cases' names.
    pub name: String,
    /// Kind of wave.
    pub wave: WaveOf,
    /// What makes the wave.
    pub start: StartOf,
    /// Number of cases.
    pub cases: usize,
    /// How many of them, drawn at random, are for training; the others are for tests.
    pub training_cases: usize,
    /// Frames of a case.
    pub frames: usize,
    /// Time of the first frame, s.
    pub first_frame_s: f64,
    /// Time between frames, s.
    pub frame_interval_s: f64,
    /// Depths to draw from, m.
    pub depth_m: Vec<f64>,
    /// Spacings to draw from, m.
    pub particle_spacing_m: Vec<f64>,
    /// Length of the tank over its depth.
    pub length_over_depth: f64,
    /// Range of the wave height over the depth.
    pub height_over_depth: [f64; 2],
    /// Range of the period, s, of regular waves.
    #[serde(default)]
    pub period_s: Option<[f64; 2]>,
}

/// Kinds of wave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WaveOf {
    /// Regular, by the stream function.
    Regular,
    /// Solitary.
    Solitary,
}

/// What makes a wave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StartOf {
    /// A piston at the left; regular waves are damped at the right.
    Paddle,
    /// It is in the tank at the start, its crest at a third to two thirds of the length.
    Tank,
}

/// What a case is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Split {
    /// To learn from.
    Training,
    /// To test with.
    Test,
}

/// A case as it was drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedCase {
    /// Its name.
    pub name: String,
    /// What it is for.
    pub split: Split,
    /// The case file.
    pub text: String,
    /// Number of frames.
    pub frames: usize,
    /// Time of the first, s.
    pub first_frame: f64,
    /// Time between them, s.
    pub frame_interval: f64,
}

impl Campaign {
    /// The campaign in the file `path`.
    ///
    /// # Errors
    /// [`CampaignError`].
    pub fn load(path: &Path) -> Result<Self, CampaignError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| CampaignError::Read { path: path.to_owned(), source })?;
        let campaign: Self = toml::from_str(&text).map_err(|error| CampaignError::Parse {
            path: path.to_owned(),
            message: error.message().to_owned(),
        })?;
        for group in &campaign.group {
            if let Some((key, reason)) = group.fault() {
                let group = group.name.clone();
                return Err(CampaignError::Value { path: path.to_owned(), group, key, reason });
            }
        }
        Ok(campaign)
    }

    /// Every case, in order. The same campaign gives the same cases on every machine.
    #[must_use]
    pub fn plan(&self) -> Vec<PlannedCase> {
        let mut planned = Vec::new();
        for (number, group) in (0..).zip(&self.group) {
            // A stream a group, and one a case: adding cases does not change the others.
            let mut random = stream(self.seed, number, 0);
            let mut order: Vec<usize> = (0..group.cases).collect();
            for i in (1..order.len()).rev() {
                order.swap(i, (uniform(&mut random) * (i + 1) as f64) as usize);
            }
            for (index, rank) in order.into_iter().enumerate() {
                let mut random = stream(self.seed, number, 1 + index as u64);
                planned.push(PlannedCase {
                    name: format!("{}-{index:03}", group.name),
                    split: match rank < group.training_cases {
                        true => Split::Training,
                        false => Split::Test,
                    },
                    text: group.draw(&mut random),
                    frames: group.frames,
                    first_frame: group.first_frame_s,
                    frame_interval: group.frame_interval_s,
                });
            }
        }
        planned
    }
}

impl Group {
    fn fault(&self) -> Option<(&'static str, &'static str)> {
        let positive = |value: f64| value.is_finite() && value > 0.0;
        let range = |[low, high]: [f64; 2]| positive(low) && positive(high) && low <= high;
        let all = |values: &[f64]| !values.is_empty() && values.iter().all(|v| positive(*v));
        let name = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        let period = self.period_s.is_some_and(range) == (self.wave == WaveOf::Regular);
        let numbers = "needs finite numbers above 0";
        [
            (
                "name",
                !self.name.is_empty() && self.name.chars().all(name),
                "letters, digits, - and _",
            ),
            ("training_cases", self.training_cases <= self.cases, "no more than there are cases"),
            ("frames", self.frames > 0, "at least 1"),
            ("first_frame_s", positive(self.first_frame_s), "a finite number above 0"),
            ("frame_interval_s", positive(self.frame_interval_s), "a finite number above 0"),
            ("depth_m", all(&self.depth_m), numbers),
            ("particle_spacing_m", all(&self.particle_spacing_m), numbers),
            ("length_over_depth", positive(self.length_over_depth), "a finite number above 0"),
            ("height_over_depth", range(self.height_over_depth), "a range above 0"),
            ("period_s", period, "a range above 0 for regular waves, and for no others"),
        ]
        .into_iter()
        .find(|(_, sound, _)| !sound)
        .map(|(key, _, reason)| (key, reason))
    }

    /// The case file of a case.
    fn draw(&self, random: &mut ChaCha8Rng) -> String {
        let depth = pick(random, &self.depth_m);
        let spacing = pick(random, &self.particle_spacing_m);
        let height = between(random, self.height_over_depth) * depth;
        let period = between(random, self.period_s.unwrap_or([1.0; 2]));
        let crest = between(random, [1.0 / 3.0, 2.0 / 3.0]);
        let length = (self.length_over_depth * depth / spacing).round() * spacing;
        let end = self.first_frame_s + self.frame_interval_s * self.frames as f64;
        let mut text = format!(
            "end_time_s = {end:?}\n[tank]\nlength_m = {length:?}\nheight_m = {:?}\n[water]\n\
             depth_m = {depth:?}\n[numerics]\nparticle_spacing_m = {spacing:?}\n[wave]\n\
             height_m = {height:?}\n",
            2.0 * depth,
        );
        match self.wave {
            WaveOf::Regular => {
                text += &format!("kind = \"stream_function\"\nperiod_s = {period:?}\n");
            }
            WaveOf::Solitary => text += "kind = \"solitary\"\n",
        }
        match self.start {
            StartOf::Paddle => text += "[wavemaker]\ntype = \"piston\"\n",
            StartOf::Tank => text += &format!("[initial_wave]\ncrest_m = {:?}\n", crest * length),
        }
        if self.wave == WaveOf::Regular {
            let frequency = TAU / period;
            let water = StillWater { depth, gravity: GRAVITY };
            let wavelength = TAU / water.wave_number(frequency);
            let inner = length - (3.0 * wavelength).min(length / 3.0);
            text += &format!(
                "[[damping_zone]]\ninner_x_m = {inner:?}\nouter_x_m = {length:?}\n\
                 rate_per_s = {:?}\n",
                2.0 * frequency,
            );
        }
        text
    }
}

fn stream(seed: u64, group: u64, index: u64) -> ChaCha8Rng {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(group << 32 | index);
    random
}

/// A number from 0 to 1, 1 excluded: the 53 highest bits.
fn uniform(random: &mut ChaCha8Rng) -> f64 {
    (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

fn between(random: &mut ChaCha8Rng, [low, high]: [f64; 2]) -> f64 {
    low + (high - low) * uniform(random)
}

fn pick(random: &mut ChaCha8Rng, values: &[f64]) -> f64 {
    values[(uniform(random) * values.len() as f64) as usize]
}
