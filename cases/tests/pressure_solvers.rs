//! The same scene with every pressure solver: a body released in water at rest.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

mod common;

use common::{directory, run, stderr};
use serde_json::Value;

/// Runs the small case with `settings`; its summary and its heave at the end, m.
fn heave(settings: &[&str]) -> (Value, f64) {
    let directory = directory();
    let mut arguments = vec!["run", "small.toml", "--quiet", "--out", "out"];
    // Released 10 mm above where it floats.
    arguments.extend(["--set", "end_time_s=0.3", "--set", "body.position_m=[0.4, 0.21]"]);
    arguments.extend(settings);
    let output = run(directory.path(), &arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    let read = |file: &str| std::fs::read_to_string(directory.path().join("out").join(file));
    let summary = serde_json::from_str(&read("summary.json").unwrap()).unwrap();
    let motion = read("motion.csv").unwrap();
    let mut lines = motion.lines();
    let column = lines.next().unwrap().split(',').position(|name| name == "heave_m").unwrap();
    let heave = lines.last().unwrap().split(',').nth(column).unwrap().parse().unwrap();
    (summary, heave)
}

#[test]
fn every_solver_gives_the_same_motion() {
    let exact = ["--set", "pressure.tolerance=1e-9", "--set", "pressure.divergence_tolerance=0"];
    let (_, reference) = heave(&exact);
    assert!(reference.abs() > 1e-4, "meant to move: {reference}");
    let diagonal =
        ["--set", "pressure.preconditioner=\"diagonal\"", "--set", "pressure.start=\"cold\""];
    for settings in [&[][..], &diagonal, &["--pressure", "network"], &["--pressure", "guarded"]] {
        let (summary, found) = heave(settings);
        let off = (found / reference - 1.0).abs();
        assert!(off < 0.01, "{settings:?}: {found} instead of {reference}");
        let steps = summary["steps"].as_f64().unwrap();
        let fallbacks = summary["fallback_count"].as_f64().unwrap();
        // Measured: 7 of 150 by the guarded network, most of them right after the release.
        assert!(fallbacks <= 0.1 * steps, "{settings:?}: {fallbacks} of {steps}");
    }
}

#[test]
fn a_guard_that_nothing_passes_falls_back_every_step() {
    let strict = ["--pressure", "guarded", "--set", "pressure.guard_tolerance=1e-12"];
    let (summary, _) =
        heave(&[&strict[..], &["--set", "pressure.divergence_tolerance=0"]].concat());
    let count = |what: &str| summary[what].as_u64().unwrap();
    // In the first step from rest there may be nothing to correct.
    assert!(count("fallback_count") + 1 >= count("steps"), "{summary:#}");
}
