//! Running the program in a directory of its own.
#![allow(dead_code, reason = "each test file uses a part")]

use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

/// A small case with everything in it: a free box, a gauge, a probe; 400 particles, 50 steps.
pub(crate) const SMALL: &str = r#"
description = "A small box in a small tank"
end_time_s = 0.1

[tank]
length_m = 0.8
height_m = 0.3

[water]
depth_m = 0.2

[numerics]
particle_spacing_m = 0.02

[[body]]
name = "pontoon"
box = { width_m = 0.16, height_m = 0.12 }
position_m = [0.4, 0.2]
angle_deg = 5.0
density_kg_m3 = 500.0

[[gauge]]
name = "left"
x_m = 0.1

[[probe]]
name = "bed"
x_m = 0.1
y_m = 0.05

[output]
series_interval_s = 0.01
frame_interval_s = 0.05
"#;

/// A directory with `small.toml` in it.
pub(crate) fn directory() -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("small.toml"), SMALL).unwrap();
    directory
}

/// The program, about to be run in `directory`.
pub(crate) fn seakeep(directory: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_seakeep"));
    command.current_dir(directory);
    command
}

/// Runs the program in `directory`.
pub(crate) fn run(directory: &Path, arguments: &[&str]) -> Output {
    seakeep(directory).args(arguments).output().unwrap()
}

/// Standard error as text.
pub(crate) fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Standard output as text.
pub(crate) fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// Names of what is in a directory, sorted.
pub(crate) fn entries(directory: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(directory)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// A campaign of two cases of two frames each.
pub(crate) const CAMPAIGN: &str = r#"
seed = 1

[[group]]
name = "wave"
wave = "solitary"
start = "tank"
cases = 2
training_cases = 1
frames = 2
first_frame_s = 0.02
frame_interval_s = 0.02
depth_m = [0.2]
particle_spacing_m = [0.02]
length_over_depth = 6.0
height_over_depth = [0.2, 0.4]
"#;

/// A directory with `tiny.toml`, a campaign, in it.
pub(crate) fn campaign() -> TempDir {
    let directory = tempfile::tempdir().unwrap();
    std::fs::write(directory.path().join("tiny.toml"), CAMPAIGN).unwrap();
    directory
}
