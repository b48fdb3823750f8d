//! The commands, and where results go.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

mod common;

use common::{directory, entries, run, stderr, stdout};

#[test]
fn list_names_every_case() {
    let output = run(directory().path(), &["list"]);
    assert!(output.status.success());
    for name in ["still_tank", "standing_wave", "buoyancy", "heave_decay", "roll_decay"] {
        assert!(stdout(&output).lines().any(|line| line.starts_with(name)), "{name}");
    }
}

#[test]
fn every_case_comes_with_all_its_files() {
    // In a folder without the sources: what a case names must be in the program.
    let directory = directory();
    let list = stdout(&run(directory.path(), &["list"]));
    for name in list.lines().filter_map(|line| line.split_whitespace().next()) {
        let output = run(directory.path(), &["check", name]);
        assert!(output.status.success(), "{name}: {}", stderr(&output));
    }
}

#[test]
fn check_says_what_would_be_run_and_writes_nothing() {
    let directory = directory();
    let output = run(directory.path(), &["check", "small.toml", "--set", "end_time_s=0.2"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stdout(&output).starts_with("small: ok, 100 steps"), "{}", stdout(&output));
    assert_eq!(entries(directory.path()), ["small.toml"]);
}

/// The lines of a plan for a stage.
fn planned(arguments: &[&str], stage: &str) -> String {
    let directory = directory();
    let output = run(directory.path(), &[&["check", "--plan"], arguments].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let text = stdout(&output);
    let line = text.lines().find(|line| line.contains(stage));
    line.unwrap_or_else(|| panic!("no {stage} in\n{text}")).to_owned()
}

#[test]
fn the_plan_keeps_what_the_scene_needs_and_says_why() {
    let left_out = |line: String, reason: &str| {
        assert!(line.contains("left out") && line.contains(reason), "{line}");
    };
    let kept = |line: String| assert!(!line.contains("left out"), "{line}");
    left_out(planned(&["still_tank"], "rigid bodies"), "no body in the case");
    left_out(planned(&["still_tank"], "motion.csv"), "no body in the case");
    left_out(planned(&["buoyancy"], "motion  "), "every body is held");
    left_out(planned(&["roll_decay"], "viscosity"), "inviscid");
    left_out(planned(&["roll_decay"], "moorings"), "no mooring");
    left_out(planned(&["small.toml", "--set", "output.mcap=false"], "run.mcap"), "false");
    left_out(planned(&["small.toml", "--set", "output.mcap=false"], "particle frames"), "no run");
    left_out(planned(&["small.toml", "--set", "output.tables=[]"], "loads.csv"), "output.tables");
    kept(planned(&["small.toml"], "motion.csv"));
    kept(planned(&["small.toml", "--set", "water.kinematic_viscosity_m2_s=1e-6"], "viscosity"));
}

#[test]
fn a_wrong_command_line_is_refused() {
    for arguments in [&["fly"][..], &["run"], &["run", "small.toml", "--threads", "0"]] {
        let output = run(directory().path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
    }
}

#[test]
fn nothing_is_written_over() {
    let directory = directory();
    let path = directory.path();
    let quick = ["run", "small.toml", "--quiet", "--set", "end_time_s=0.004"];
    let with = |more: &[&str]| run(path, &[&quick[..], more].concat());

    // The default place takes a number once it is used.
    for _ in 0..2 {
        let output = with(&[]);
        assert!(output.status.success(), "{}", stderr(&output));
        assert!(output.stdout.is_empty() && output.stderr.is_empty());
    }
    assert_eq!(entries(&path.join("results")), ["small", "small-2"]);

    // Something that is no result stands in the default place.
    std::fs::create_dir_all(path.join("results/small-3")).unwrap();
    std::fs::write(path.join("results/small-3/letter.txt"), "mine").unwrap();
    let output = with(&[]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("small-3"), "{}", stderr(&output));
    assert_eq!(entries(&path.join("results/small-3")), ["letter.txt"]);

    // A directory that is named must be empty, unless forced.
    let output = with(&["--out", "results/small"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--force"));
    let output = with(&["--out", "results/small", "--force", "--set", "output.mcap=false"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let names = entries(&path.join("results/small"));
    assert!(!names.contains(&"run.mcap".to_owned()), "an earlier file is left: {names:?}");

    // A file is no directory.
    assert_eq!(with(&["--out", "small.toml"]).status.code(), Some(2));
}
