//! Tensions of mooring lines for a motion that is given: no water, no bodies that move by
//! themselves.

use crate::case::{Case, TableName};
use crate::motion_file::{self, MotionFileError};
use crate::output::{OutputError, Recorder, directory};
use crate::simulation::Sample;
use seakeep_body::{BodyError, PrescribedMotion, TimeSeries};
use seakeep_coupler::interface::BoundaryKinematics;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why there are no tensions.
#[derive(Debug, Error)]
pub enum MooringError {
    /// There is nothing to compute.
    #[error("{case}: there is no mooring in the case")]
    NoLine {
        /// Name of the case.
        case: String,
    },
    /// The motion file cannot be read.
    #[error(transparent)]
    File(#[from] MotionFileError),
    /// The motion cannot be followed.
    #[error("{}: {source}", .path.display())]
    Motion {
        /// The file.
        path: PathBuf,
        /// Why.
        source: BodyError,
    },
    /// Several bodies are moored, and the file does not say which one it is about.
    #[error("{}: {count} bodies are moored: a column body must name them", .path.display())]
    WhichBody {
        /// The file.
        path: PathBuf,
        /// How many.
        count: usize,
    },
    /// The rows of two bodies are at different times.
    #[error("{}: the rows of {first} and {second} are not at the same times", .path.display())]
    Times {
        /// The file.
        path: PathBuf,
        /// A body.
        first: String,
        /// Another.
        second: String,
    },
    /// The resolved case cannot be written as TOML. Nothing has been written.
    #[error("the resolved case cannot be written: {0}")]
    Resolved(#[from] toml::ser::Error),
    /// A result could not be written. What is there is complete up to then.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// The tension of one line over a motion.
#[derive(Clone, Debug, PartialEq)]
pub struct LineRange {
    /// Name of the line.
    pub name: String,
    /// Least tension, N/m.
    pub least: f64,
    /// Mean over the samples, N/m.
    pub mean: f64,
    /// Largest, N/m.
    pub largest: f64,
    /// Part of the samples without tension.
    pub slack: f64,
}

/// Writes the tensions of the lines of `case`, whose bodies move as the file `motion` says, at
/// the times of that file into `directory`, which is made if it does not exist: `mooring.csv` and,
/// where the case asks for it, `run.mcap`.
///
/// # Errors
/// [`MooringError`].
pub fn run(case: &Case, motion: &Path, directory: &Path) -> Result<Vec<LineRange>, MooringError> {
    let scene = &case.scene;
    let (times, motions) = motions(case, motion)?;
    let resolved = format!("{}\n{}", directory::MARK, case.to_toml()?);
    directory::prepare(directory)?;
    let path = directory.join(directory::RESOLVED_CASE);
    std::fs::write(&path, &resolved).map_err(OutputError::at(&path))?;
    let mut asked = case.clone();
    asked.scene.output.tables = vec![TableName::Mooring];
    let mut recorder = Recorder::create(directory, &asked, &resolved)?;

    let mut ranges: Vec<LineRange> = scene
        .lines
        .iter()
        .map(|line| LineRange {
            name: line.name.clone(),
            least: f64::INFINITY,
            mean: 0.0,
            largest: 0.0,
            slack: 0.0,
        })
        .collect();
    let share = 1.0 / times.len() as f64;
    for (row, time) in times.iter().enumerate() {
        let states = scene.lines.iter().map(|line| line.line.at(&motions[line.body][row]));
        let lines: Vec<_> = states.collect();
        for (range, state) in ranges.iter_mut().zip(&lines) {
            range.least = range.least.min(state.tension);
            range.largest = range.largest.max(state.tension);
            range.mean += share * state.tension;
            range.slack += share * f64::from(u8::from(state.tension == 0.0));
        }
        recorder.sample(scene, &Sample { time: *time, lines, ..Sample::default() })?;
    }
    recorder.finish()?;
    Ok(ranges)
}

/// The times of the file at `path`, and the kinematics of every moored body at them; nothing for
/// the others.
fn motions(
    case: &Case,
    path: &Path,
) -> Result<(Vec<f64>, Vec<Vec<BoundaryKinematics>>), MooringError> {
    let scene = &case.scene;
    let moored: Vec<usize> = (0..scene.bodies.len())
        .filter(|body| scene.lines.iter().any(|line| line.body == *body))
        .collect();
    let Some(first) = moored.first() else {
        return Err(MooringError::NoLine { case: case.name.clone() });
    };
    let failed = |source| MooringError::Motion { path: path.to_owned(), source };
    let mut times: Vec<f64> = Vec::new();
    let mut motions = vec![Vec::new(); scene.bodies.len()];
    for index in &moored {
        let body = &scene.bodies[*index];
        let found = motion_file::read(path, &body.name)?;
        if moored.len() > 1 && !found.names_bodies {
            return Err(MooringError::WhichBody { path: path.to_owned(), count: moored.len() });
        }
        let series = TimeSeries::new(body.equilibrium, found.times.clone(), &found.samples)
            .map_err(failed)?;
        motions[*index] = found
            .times
            .iter()
            .map(|time| series.kinematics(*time))
            .collect::<Result<_, _>>()
            .map_err(failed)?;
        if index != first && found.times != times {
            return Err(MooringError::Times {
                path: path.to_owned(),
                first: scene.bodies[*first].name.clone(),
                second: body.name.clone(),
            });
        }
        times = found.times;
    }
    Ok((times, motions))
}
