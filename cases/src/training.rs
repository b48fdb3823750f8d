//! Training of a network on the frames of data sets, into a folder: weights, checkpoint, curve.

use crate::dataset::{Dataset, DatasetError, Split};
use crate::output::OutputError;
use crate::plot::{Curve, Figure, Panel};
use seakeep_learning::{LearningError, Losses, Settings, Trainer, place, use_threads};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use thiserror::Error;

/// What training leaves in its folder.
const WEIGHTS: &str = "weights.safetensors";
const CHECKPOINT: &str = "checkpoint.safetensors";
const CURVE: &str = "curve.csv";
const MANIFEST: &str = "weights.json";

/// Why there is no training, or why it ended.
#[derive(Debug, Error)]
pub enum TrainingError {
    /// The configuration cannot be read.
    #[error("{}: {reason}", .path.display())]
    Configuration {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// Frames cannot be had.
    #[error(transparent)]
    Dataset(#[from] DatasetError),
    /// The network, the device or the checkpoint.
    #[error(transparent)]
    Learning(#[from] LearningError),
    /// A file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Asked to stop; the checkpoint is written.
    #[error("interrupted at step {0}; the same command goes on from there")]
    Interrupted(u64),
}

/// A training file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrainingKeys {
    /// Folders of data sets, relative to this file.
    pub data: Vec<PathBuf>,
    /// Weights to start from, relative to this file; without it, drawn from the seed.
    pub start: Option<PathBuf>,
    /// Steps between two rows of the learning curve, each with a checkpoint.
    pub log_every: u64,
    /// Frames of test cases that each row is measured on, evenly spread.
    pub test_frames: usize,
    /// How it is trained.
    pub training: Settings,
}

/// A row of the learning curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CurveRow {
    /// Steps done.
    pub step: u64,
    /// Mean loss over the steps since the last row.
    pub loss: f64,
    /// Mean skill on the frames learnt from since the last row, before each step.
    pub training_skill: f64,
    /// Mean skill on the test frames.
    pub test_skill: f64,
    /// Mean part of the residual that is left on the test frames.
    pub test_residual: f64,
}

/// Where and on what to train.
#[derive(Clone, Debug)]
pub struct Options {
    /// Folder of the results.
    pub out: PathBuf,
    /// `cpu` or `cuda`.
    pub device: String,
    /// Threads of libtorch.
    pub threads: usize,
}

/// Trains as the file `path` says; `observe` is called with each row and the number of steps.
/// Goes on from the checkpoint in the folder if there is one. Returns the path of the weights.
///
/// # Errors
/// [`TrainingError`].
pub fn train(
    path: &Path,
    options: &Options,
    stop: &AtomicBool,
    observe: &mut dyn FnMut(&CurveRow, u64),
) -> Result<PathBuf, TrainingError> {
    let (keys, start) = read(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let (mut learning, mut test) = (Vec::new(), Vec::new());
    for data in &keys.data {
        let dataset = Dataset::open(&folder.join(data))?;
        learning.extend(dataset.files(Split::Training));
        test.extend(dataset.files(Split::Test));
    }
    if learning.is_empty() {
        let reason = "data: no frame is for training".to_owned();
        return Err(TrainingError::Configuration { path: path.to_owned(), reason });
    }
    use_threads(options.threads);
    let mut trainer =
        Trainer::new(keys.training.clone(), start.as_deref(), place(&options.device)?)?;
    let out = &options.out;
    std::fs::create_dir_all(out).map_err(OutputError::at(out))?;
    let checkpoint = out.join(CHECKPOINT);
    let configuration = serde_json::to_string(&keys).unwrap_or_default();
    let mut curve = Vec::new();
    if let Ok(bytes) = std::fs::read(&checkpoint) {
        trainer.restore(&bytes, &configuration)?;
        curve = read_curve(&out.join(CURVE), trainer.steps());
    }
    let every = keys.log_every.max(1);
    while trainer.steps() < keys.training.steps {
        let mut sums = (0.0, 0.0, 0.0);
        let until = (trainer.steps() / every + 1) * every;
        while trainer.steps() < until.min(keys.training.steps) {
            if stop.load(Ordering::Relaxed) {
                return Err(TrainingError::Interrupted(
                    curve.last().map_or(0, |r: &CurveRow| r.step),
                ));
            }
            let frame = Dataset::frame(&learning[trainer.next_frame(learning.len())])?;
            let losses = trainer.step(&frame)?;
            sums = (sums.0 + losses.loss, sums.1 + losses.skill, sums.2 + 1.0);
        }
        let tested = test_on(&trainer, &test, keys.test_frames)?;
        let row = CurveRow {
            step: trainer.steps(),
            loss: sums.0 / sums.2,
            training_skill: sums.1 / sums.2,
            test_skill: tested.skill,
            test_residual: tested.residual,
        };
        observe(&row, keys.training.steps);
        curve.push(row);
        write_curve(out, &curve)?;
        replace(&checkpoint, &trainer.checkpoint(&configuration)?)?;
    }
    let manifest = Manifest {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        training_frames: learning.len(),
        test_skill: curve.last().map(|row| row.test_skill),
        configuration: keys,
    };
    let text = serde_json::to_string_pretty(&manifest).unwrap_or_default();
    replace(&out.join(MANIFEST), text.as_bytes())?;
    let weights = out.join(WEIGHTS);
    replace(&weights, &trainer.weights()?)?;
    Ok(weights)
}

/// How weights were trained.
#[derive(Clone, Debug, Serialize)]
struct Manifest {
    /// Version of the program.
    version: String,
    /// Number of frames that were learnt from.
    training_frames: usize,
    /// Skill on the test frames at the end.
    test_skill: Option<f64>,
    /// The training file.
    configuration: TrainingKeys,
}

/// The training file, and the weights it starts from.
fn read(path: &Path) -> Result<(TrainingKeys, Option<Vec<u8>>), TrainingError> {
    let fail = |reason: String| TrainingError::Configuration { path: path.to_owned(), reason };
    let text = std::fs::read_to_string(path).map_err(|e| fail(format!("cannot be read: {e}")))?;
    let keys: TrainingKeys = toml::from_str(&text).map_err(|e| fail(e.message().to_owned()))?;
    let t = &keys.training;
    for (key, value) in [
        ("learning_rate", t.learning_rate),
        ("final_learning_rate", t.final_learning_rate),
        ("divergence_weight", t.divergence_weight),
        ("noise_weight", t.noise_weight),
    ] {
        if !(value.is_finite() && value >= 0.0) {
            return Err(fail(format!("training.{key} = {value}: a finite number, 0 or above")));
        }
    }
    let start = keys.start.as_ref().map(|start| {
        let start = path.parent().unwrap_or(Path::new("")).join(start);
        std::fs::read(&start).map_err(|source| DatasetError::Read { path: start, source })
    });
    let start = start.transpose()?;
    Ok((keys, start))
}

/// Means over `count` of the `files`, evenly spread.
fn test_on(trainer: &Trainer, files: &[PathBuf], count: usize) -> Result<Losses, TrainingError> {
    let count = count.min(files.len());
    let mut mean = Losses::default();
    for index in 0..count {
        let found = trainer.test(&Dataset::frame(&files[index * files.len() / count])?);
        let part = 1.0 / count as f64;
        mean.loss += part * found.loss;
        mean.skill += part * found.skill;
        mean.residual += part * found.residual;
    }
    Ok(mean)
}

/// Writes a file that is there whole or not at all.
fn replace(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let part = path.with_extension("part");
    std::fs::write(&part, bytes).map_err(OutputError::at(&part))?;
    std::fs::rename(&part, path).map_err(OutputError::at(path))
}

/// The rows of an earlier part of this training, up to its checkpoint.
fn read_curve(path: &Path, steps: u64) -> Vec<CurveRow> {
    let Ok(mut reader) = csv::Reader::from_path(path) else { return Vec::new() };
    let rows = reader.deserialize().filter_map(Result::ok);
    rows.filter(|row: &CurveRow| row.step <= steps).collect()
}

fn write_curve(out: &Path, curve: &[CurveRow]) -> Result<(), OutputError> {
    let path = out.join(CURVE);
    let fail = |error: csv::Error| OutputError::at(&path)(error.into());
    let mut writer = csv::Writer::from_path(&path).map_err(fail)?;
    for row in curve {
        writer.serialize(row).map_err(fail)?;
    }
    writer.flush().map_err(|error| fail(error.into()))?;
    let line = |name: &str, value: fn(&CurveRow) -> f64| {
        Curve::line(name, curve.iter().map(|row| (row.step as f64, value(row))).collect())
    };
    let panel = |label: &str, curves: Vec<Curve>| Panel {
        x_label: "step".to_owned(),
        y_label: label.to_owned(),
        logarithmic: false,
        curves,
        notes: Vec::new(),
    };
    let panels = vec![
        panel("loss", vec![line("", |row| row.loss)]),
        panel(
            "skill",
            vec![line("training", |row| row.training_skill), line("test", |row| row.test_skill)],
        ),
        panel("residual left", vec![line("test", |row| row.test_residual)]),
    ];
    Figure::new("Learning curve", panels).write(&out.join("curve.svg"))
}
