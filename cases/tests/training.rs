//! Training: the same weights for the same seed, also after an interruption; libtorch's inference
//! against the program's own; what is refused.

#![cfg(feature = "torch")]
#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

mod common;

use common::{campaign, run, stderr};
use seakeep::dataset::{Dataset, Split};
use seakeep_fluid::network::Network;
use seakeep_learning::{DeviceNetwork, place};
use std::fs;
use tempfile::TempDir;

const TRAINING: &str = "
data = [\"data\"]
log_every = 2
test_frames = 1

[training]
network = \"residual\"
seed = 3
steps = 4
learning_rate = 1e-2
final_learning_rate = 1e-3
divergence_weight = 0.3
noise_weight = 0.2
";

/// A directory with a small data set and `training.toml`.
fn ready() -> TempDir {
    let directory = campaign();
    let output = run(directory.path(), &["dataset", "tiny.toml", "--out", "data", "--quiet"]);
    assert!(output.status.success(), "{}", stderr(&output));
    fs::write(directory.path().join("training.toml"), TRAINING).unwrap();
    directory
}

fn train(directory: &TempDir, out: &str) -> Vec<u8> {
    let output = run(directory.path(), &["train", "training.toml", "--out", out]);
    assert!(output.status.success(), "{}", stderr(&output));
    fs::read(directory.path().join(out).join("weights.safetensors")).unwrap()
}

fn refused(directory: &TempDir, arguments: &[&str], part: &str) {
    let output = run(directory.path(), arguments);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(message.contains(part), "{part} not in {message}");
}

#[test]
fn the_same_seed_gives_the_same_weights_and_both_inferences_agree() {
    let directory = ready();
    let weights = train(&directory, "first");
    assert_eq!(train(&directory, "second"), weights);
    let path = directory.path().join("training.toml");
    let text = fs::read_to_string(&path).unwrap();
    fs::write(&path, text.replace("seed = 3", "seed = 4")).unwrap();
    assert_ne!(train(&directory, "third"), weights);

    let curve = fs::read_to_string(directory.path().join("first/curve.csv")).unwrap();
    assert_eq!(curve.lines().count(), 3, "{curve}");
    assert!(directory.path().join("first/curve.svg").is_file());

    agree(&directory, &weights);
    fs::write(&path, text.replace("residual", "paper")).unwrap();
    agree(&directory, &train(&directory, "paper"));
}

#[test]
fn libtorch_runs_a_network_beside_the_programs_own_inference() {
    let directory = ready();
    fs::write(directory.path().join("weights.safetensors"), train(&directory, "out")).unwrap();
    let with = |device: &'static str| {
        let arguments = ["evaluate", "weights.safetensors", "--data", "data", "--out", "out"];
        [&arguments[..], &["--device", device]].concat()
    };
    let output = run(directory.path(), &with("cpu"));
    assert!(output.status.success(), "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(
        text.contains("largest difference") && text.contains("until a frame is there"),
        "{text}"
    );
    if place("cuda").is_err() {
        refused(&directory, &with("cuda"), "device cuda: libtorch");
    }
    refused(&directory, &with("abacus"), "device abacus: there is: cpu, cuda");
}

/// libtorch on the processor, step by step within a run, as the program's own code: with the same gates and
/// coarse level, what is left between them is the rounding of single precision.
#[test]
fn a_network_on_a_device_gives_the_same_motion() {
    let directory = common::directory();
    let network = ["run", "small.toml", "--quiet", "--pressure", "network"];
    // Released 10 mm above where it floats.
    let released = ["--set", "end_time_s=0.3", "--set", "body.position_m=[0.4, 0.21]"];
    let heave = |device: &'static str| -> f64 {
        let arguments = [&network[..], &released, &["--device", device, "--out", device]].concat();
        let output = run(directory.path(), &arguments);
        assert!(output.status.success(), "{}", stderr(&output));
        let motion = fs::read_to_string(directory.path().join(device).join("motion.csv")).unwrap();
        let mut lines = motion.lines();
        let column = lines.next().unwrap().split(',').position(|name| name == "heave_m").unwrap();
        lines.last().unwrap().split(',').nth(column).unwrap().parse().unwrap()
    };
    let (own, found) = (heave("own"), heave("cpu"));
    assert!(own.abs() > 1e-4, "meant to move: {own}");
    assert!(found != own, "the device was not used");
    // Measured: 5e-11.
    assert!((found / own - 1.0).abs() < 1e-6, "{found} instead of {own}");
    if place("cuda").is_err() {
        let cuda = [&network[..], &["--device", "cuda", "--out", "cuda"]].concat();
        let output = run(directory.path(), &cuda);
        assert_eq!(output.status.code(), Some(2));
        assert!(stderr(&output).contains("device cuda: libtorch"), "{}", stderr(&output));
        assert!(!directory.path().join("cuda").exists());
    }
}

/// The program's own inference against libtorch's, on test frames.
fn agree(directory: &TempDir, weights: &[u8]) {
    let own = Network::from_bytes(weights).unwrap();
    let other = DeviceNetwork::new(weights, place("cpu").unwrap()).unwrap();
    let dataset = Dataset::open(&directory.path().join("data")).unwrap();
    for path in dataset.files(Split::Test) {
        let frame = Dataset::frame(&path).unwrap();
        let (own, other) = (own.correction(&frame), other.correction(&other.inputs(&frame)));
        let size = other.iter().fold(0.0f32, |most, value| most.max(value.abs()));
        assert!(size > 0.0);
        for (own, other) in own.iter().zip(&other) {
            assert!((own - other).abs() <= 1e-5 * size, "{own} and {other} of {size}");
        }
    }
}

#[test]
fn a_training_goes_on_from_its_checkpoint() {
    let directory = ready();
    let whole = train(&directory, "whole");
    // Killed as soon as there is a checkpoint, that after step 2.
    let mut child = common::seakeep(directory.path())
        .args(["train", "training.toml", "--out", "part"])
        .stderr(std::process::Stdio::null())
        .spawn()
        .unwrap();
    let checkpoint = directory.path().join("part/checkpoint.safetensors");
    while !checkpoint.is_file() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let _ = child.kill();
    child.wait().unwrap();
    assert_eq!(train(&directory, "part"), whole);
}

#[test]
fn what_cannot_be_is_refused() {
    let directory = ready();
    let arguments = ["train", "training.toml", "--out", "out"];
    let with = |more: &[&'static str]| [&arguments[..], more].concat();
    if place("cuda").is_err() {
        refused(&directory, &with(&["--device", "cuda"]), "device cuda: libtorch");
    }
    refused(&directory, &with(&["--device", "abacus"]), "device abacus: there is: cpu, cuda");
    let bench = |device| ["bench-pressure", "--rows", "1", "--device", device];
    if place("cuda").is_err() {
        refused(&directory, &bench("cuda"), "device cuda: libtorch");
    }
    refused(&directory, &bench("abacus"), "pressure.device");
    let path = directory.path().join("training.toml");
    fs::write(&path, TRAINING.replace("seed", "sed")).unwrap();
    refused(&directory, &arguments, "`sed`");
    fs::write(&path, TRAINING.replace("1e-2", "nan")).unwrap();
    refused(&directory, &arguments, "training.learning_rate");
    fs::write(&path, TRAINING.replace("\"data\"", "\"dta\"")).unwrap();
    refused(&directory, &arguments, "dta: cannot be read");
    fs::write(&path, TRAINING).unwrap();
    for case in ["wave-000", "wave-001"] {
        for frame in ["frame-0000.safetensors", "frame-0001.safetensors"] {
            let path = directory.path().join("data").join(case).join(frame);
            let bytes = fs::read(&path).unwrap();
            fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
        }
    }
    refused(&directory, &arguments, "safetensors: the frame cannot be read");
}
