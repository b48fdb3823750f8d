//! Data for the networks: random waves without bodies, frames of whose pressure equations are kept.
//!
//! A [`Campaign`] draws its cases from a seed. Each is run on its own into a folder of its own,
//! which appears whole or not at all, so that an interrupted campaign goes on where it was and a
//! workflow engine can spread the cases.

mod campaign;
mod reader;

pub use campaign::{Campaign, CampaignError, Group, PlannedCase, Split, StartOf, WaveOf};
pub use reader::{Dataset, DatasetError};

use crate::case::{Case, CaseError};
use crate::output::OutputError;
use crate::simulation::{Simulation, SimulationError};
use seakeep_fluid::frame::FrameError;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use thiserror::Error;

/// Name of a case's manifest.
pub(crate) const MANIFEST: &str = "manifest.json";

/// Why a case of a campaign gave no frames.
#[derive(Debug, Error)]
pub enum GenerateError {
    /// The case drawn is refused.
    #[error("case {name}: {source}")]
    Case {
        /// Its name.
        name: String,
        /// Why.
        source: CaseError,
    },
    /// It cannot start or a step failed.
    #[error("case {name}, t = {time:.3} s: {source}")]
    Simulation {
        /// Its name.
        name: String,
        /// Simulated time, s.
        time: f64,
        /// Why.
        source: SimulationError,
    },
    /// The threads cannot be started.
    #[error("the threads cannot be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// A frame cannot be encoded.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// The manifest cannot be encoded.
    #[error("the manifest cannot be written: {0}")]
    Manifest(#[from] serde_json::Error),
    /// A file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Asked to stop.
    #[error("interrupted in case {0}")]
    Interrupted(String),
}

/// What a case's folder holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// Name of the case, also that of its folder.
    pub case: String,
    /// Version of the program.
    pub version: String,
    /// Seed of the campaign.
    pub seed: u64,
    /// Whether to learn from it or to test with it.
    pub split: Split,
    /// What found the pressure while the case ran; that of the frames is always exact.
    pub solver: String,
    /// Files of the frames, in order of time.
    pub frames: Vec<String>,
    /// Tensors of a frame: name, which ends in its unit, and shape for n particles and m entries of
    /// the pressure matrix.
    pub tensors: Vec<(String, String)>,
    /// The case as it was run, as a case file.
    pub case_file: String,
}

/// What a folder is to be filled with.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Overrides of every case, such as `pressure.solver="network"`.
    pub overrides: Vec<String>,
    /// Threads of a case.
    pub threads: usize,
}

/// Runs `planned` and puts its frames into a folder of its name in `out`. `observe` is called with
/// the part that is done. A folder that is there already is left alone; `false` then.
///
/// # Errors
/// [`GenerateError`]; the folder is then not there.
pub fn generate(
    planned: &PlannedCase,
    seed: u64,
    out: &Path,
    options: &Options,
    stop: &AtomicBool,
    observe: &mut (dyn FnMut(f64) + Send),
) -> Result<bool, GenerateError> {
    let folder = out.join(&planned.name);
    if folder.join(MANIFEST).is_file() {
        return Ok(false);
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build()?;
    let part = out.join(format!("{}.part", planned.name));
    let _ = std::fs::remove_dir_all(&part);
    std::fs::create_dir_all(&part).map_err(OutputError::at(&part))?;
    let result = pool.install(|| run(planned, seed, &part, options, stop, observe));
    if let Err(error) = result {
        let _ = std::fs::remove_dir_all(&part);
        return Err(error);
    }
    std::fs::rename(&part, &folder).map_err(OutputError::at(&folder))?;
    Ok(true)
}

fn run(
    planned: &PlannedCase,
    seed: u64,
    folder: &Path,
    options: &Options,
    stop: &AtomicBool,
    observe: &mut (dyn FnMut(f64) + Send),
) -> Result<(), GenerateError> {
    let name = || planned.name.clone();
    let file = format!("{}.toml", planned.name);
    let case = Case::parse(&planned.name, &file, &planned.text, &options.overrides)
        .map_err(|source| GenerateError::Case { name: name(), source })?;
    let fail = |time| move |source| GenerateError::Simulation { name: name(), time, source };
    let mut simulation = Simulation::start(&case.scene).map_err(fail(0.0))?;
    let step = case.scene.communication_step();
    let mut frames = Vec::new();
    for number in 0..planned.frames {
        let at = planned.first_frame + planned.frame_interval * number as f64;
        let before = (at / step).round() as u64;
        while simulation.steps() < before {
            if stop.load(Ordering::Relaxed) {
                return Err(GenerateError::Interrupted(name()));
            }
            let time = simulation.time();
            simulation.step().map_err(fail(time))?;
        }
        let time = simulation.time();
        simulation.record_frame();
        simulation.step().map_err(fail(time))?;
        if let Some(frame) = simulation.take_frame() {
            let file = format!("frame-{number:04}.safetensors");
            let path = folder.join(&file);
            std::fs::write(&path, frame.to_bytes()?).map_err(OutputError::at(&path))?;
            frames.push(file);
        }
        observe((number + 1) as f64 / planned.frames as f64);
    }
    let tensors = seakeep_fluid::frame::TENSORS;
    let manifest = Manifest {
        case: planned.name.clone(),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        seed,
        split: planned.split,
        solver: format!("{:?}", case.keys.pressure.solver).to_lowercase(),
        frames,
        tensors: tensors.map(|(name, shape)| (name.to_owned(), shape.to_owned())).to_vec(),
        case_file: case.to_toml().unwrap_or_else(|_| planned.text.clone()),
    };
    let path = folder.join(MANIFEST);
    std::fs::write(&path, serde_json::to_string_pretty(&manifest)?)
        .map_err(OutputError::at(&path))?;
    Ok(())
}
