//! What the wave of a case should be: curves of theory and the motion of the paddle, as tables.

use crate::case::Case;
use crate::output::{OutputError, directory};
use crate::waves::paddle::Wavemaker;
use crate::waves::{WaveError, WaveTheory};
use seakeep_body::PrescribedMotion;
use serde::Serialize;
use std::path::Path;
use std::sync::Arc;
use thiserror::Error;

/// Places along the tank of a profile.
const PLACES: usize = 2000;
/// Heights of a velocity profile.
const HEIGHTS: usize = 50;

/// Why there are no tables.
#[derive(Debug, Error)]
pub enum TheoryError {
    /// The case has no wave.
    #[error("the case has no [wave]")]
    NoWave,
    /// The wave cannot be.
    #[error(transparent)]
    Wave(#[from] WaveError),
    /// The time is not one of the run.
    #[error("--at {at}: it must be from 0 to {end}, the end of the run")]
    Time {
        /// Asked for, s.
        at: f64,
        /// End of the run, s.
        end: f64,
    },
    /// The resolved case cannot be written as TOML.
    #[error("the resolved case cannot be written: {0}")]
    Resolved(#[from] toml::ser::Error),
    /// A table could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Elevation above still water at a gauge.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs, reason = "the names are the columns and carry the units")]
pub struct GaugeRow {
    pub time_s: f64,
    pub gauge: String,
    pub x_m: f64,
    pub elevation_m: f64,
}

/// Elevation above still water along the tank.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs, reason = "the names are the columns and carry the units")]
pub struct ProfileRow {
    pub x_m: f64,
    pub elevation_m: f64,
}

/// Velocity below the highest crest.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs, reason = "the names are the columns and carry the units")]
pub struct VelocityRow {
    pub x_m: f64,
    pub y_m: f64,
    pub velocity_x_m_s: f64,
    pub velocity_y_m_s: f64,
}

/// Motion of the paddle without active absorption; its stroke is at the still-water level.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[allow(missing_docs, reason = "the names are the columns and carry the units")]
pub struct PaddleRow {
    pub time_s: f64,
    pub stroke_m: f64,
    pub velocity_m_s: f64,
    pub acceleration_m_s2: f64,
    pub angle_rad: f64,
}

/// The wave of a case in theory.
#[derive(Debug)]
pub struct Theory {
    /// The wave; none for a recorded motion of the paddle.
    pub wave: Option<Arc<dyn WaveTheory>>,
    /// What makes it; none where it is there at the start.
    pub wavemaker: Option<Wavemaker>,
    /// Elevation at the gauges over the run.
    pub gauges: Vec<GaugeRow>,
    /// Elevation along the tank at one time.
    pub profile: Vec<ProfileRow>,
    /// Velocity from the bed to the highest crest of the profile.
    pub velocity: Vec<VelocityRow>,
    /// Motion of the paddle over the run.
    pub paddle: Vec<PaddleRow>,
}

/// The wave of `case`, with the profile at the time `at` (s), without it the end of the run.
///
/// # Errors
/// [`TheoryError`]: a case without a wave, a time outside the run.
pub fn theory(case: &Case, at: Option<f64>) -> Result<Theory, TheoryError> {
    let plan = case.scene.wave.as_ref().ok_or(TheoryError::NoWave)?;
    let water = case.scene.still_water();
    let end = case.keys.end_time_s;
    let at = at.unwrap_or(end);
    if !(0.0..=end).contains(&at) {
        return Err(TheoryError::Time { at, end });
    }
    let (wave, wavemaker) = (plan.theory(water)?, plan.wavemaker(water)?);
    let interval = case.scene.output.series_every as f64 * case.scene.time_step();
    let count = (end / interval * (1.0 + 1e-12)).floor() as usize;
    let times = || (0..=count).map(|n| n as f64 * interval);

    let (mut gauges, mut profile, mut velocity) = (Vec::new(), Vec::new(), Vec::new());
    if let Some(wave) = &wave {
        gauges = times()
            .flat_map(|time_s| {
                case.scene.gauges.iter().map(move |gauge| GaugeRow {
                    time_s,
                    gauge: gauge.name.clone(),
                    x_m: gauge.x,
                    elevation_m: wave.elevation(gauge.x, time_s),
                })
            })
            .collect();
        let length = case.keys.tank.length_m;
        profile = (0..=PLACES)
            .map(|n| length * n as f64 / PLACES as f64)
            .map(|x_m| ProfileRow { x_m, elevation_m: wave.elevation(x_m, at) })
            .collect();
        if let Some(crest) = profile.iter().max_by(|a, b| a.elevation_m.total_cmp(&b.elevation_m)) {
            let surface = water.depth + crest.elevation_m;
            velocity = (0..=HEIGHTS)
                .map(|n| surface * n as f64 / HEIGHTS as f64)
                .map(|y_m| {
                    let velocity = wave.velocity(crest.x_m, y_m, at);
                    VelocityRow {
                        x_m: crest.x_m,
                        y_m,
                        velocity_x_m_s: velocity.x,
                        velocity_y_m_s: velocity.y,
                    }
                })
                .collect();
        }
    }
    let paddle = wavemaker.iter().flat_map(|maker| {
        times().map(|time_s| {
            let stroke = maker.motion().stroke(time_s);
            PaddleRow {
                time_s,
                stroke_m: stroke.displacement,
                velocity_m_s: stroke.velocity,
                acceleration_m_s2: stroke.acceleration,
                angle_rad: maker.kinematics(time_s).map_or(0.0, |board| board.angle),
            }
        })
    });
    let paddle = paddle.collect();
    Ok(Theory { wave, wavemaker, gauges, profile, velocity, paddle })
}

impl Theory {
    /// Writes `wave_gauges.csv`, `wave_profile.csv`, `wave_velocity.csv` and `paddle.csv`, those
    /// with anything in them, and the resolved case into `folder`.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write(&self, case: &Case, folder: &Path) -> Result<(), TheoryError> {
        let resolved = format!("{}\n{}", directory::MARK, case.to_toml()?);
        directory::prepare(folder)?;
        let path = folder.join(directory::RESOLVED_CASE);
        std::fs::write(&path, resolved).map_err(OutputError::at(&path))?;
        write_rows(&folder.join("wave_gauges.csv"), &self.gauges)?;
        write_rows(&folder.join("wave_profile.csv"), &self.profile)?;
        write_rows(&folder.join("wave_velocity.csv"), &self.velocity)?;
        write_rows(&folder.join("paddle.csv"), &self.paddle)?;
        Ok(())
    }
}

/// Writes a table, if it has rows.
pub(crate) fn write_rows<R: Serialize>(path: &Path, rows: &[R]) -> Result<(), OutputError> {
    if rows.is_empty() {
        return Ok(());
    }
    let failed = |error: csv::Error| OutputError::at(path)(error.into());
    let mut writer = csv::Writer::from_path(path).map_err(failed)?;
    for row in rows {
        writer.serialize(row).map_err(failed)?;
    }
    writer.flush().map_err(OutputError::at(path))
}
