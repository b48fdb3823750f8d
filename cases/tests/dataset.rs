//! Data sets: what is in them, that they resume, and what is refused.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

mod common;

use common::{campaign, entries, run, stderr};
use seakeep::dataset::{Campaign, Dataset, Split};
use std::fs;

#[test]
fn a_campaign_resumes_and_its_frames_solve_their_equations() {
    let directory = campaign();
    let arguments = ["dataset", "tiny.toml", "--out", "data"];
    let output = run(directory.path(), &[&arguments[..], &["--case", "wave-001"]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let data = directory.path().join("data");
    assert_eq!(entries(&data), ["wave-001"]);
    let file = data.join("wave-001/frame-0001.safetensors");
    let bytes = fs::read(&file).unwrap();

    let output = run(directory.path(), &arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).ends_with("1 cases made, 1 were there\n"), "{}", stderr(&output));
    assert_eq!(entries(&data), ["wave-000", "wave-001"]);
    assert_eq!(fs::read(&file).unwrap(), bytes);

    let dataset = Dataset::open(&data).unwrap();
    assert_eq!(dataset.files(Split::Training).len(), 2);
    assert_eq!(dataset.files(Split::Test).len(), 2);
    for path in dataset.files(Split::Training) {
        let frame = Dataset::frame(&path).unwrap();
        let size = frame.residual.iter().map(|r| f64::from(*r).powi(2)).sum::<f64>().sqrt();
        assert!(size > 0.0);
        // A (p − p_t) = b − A p_t.
        let mut off = 0.0;
        for i in 0..frame.len() {
            let entries = frame.row_start[i] as usize..frame.row_start[i + 1] as usize;
            let sum: f64 = entries
                .map(|k| {
                    f64::from(frame.value[k]) * f64::from(frame.target[frame.column[k] as usize])
                })
                .sum();
            off += (f64::from(frame.target[i]) + sum - f64::from(frame.residual[i])).powi(2);
        }
        assert!(off.sqrt() < 1e-4 * size, "{} of {size}", off.sqrt());
    }
}

#[test]
fn the_same_seed_gives_the_same_cases() {
    let directory = campaign();
    let path = directory.path().join("tiny.toml");
    let plan = |seed: &str| {
        let text = fs::read_to_string(&path).unwrap();
        let other = directory.path().join("other.toml");
        fs::write(&other, text.replace("seed = 1", seed)).unwrap();
        Campaign::load(&other).unwrap().plan()
    };
    assert_eq!(plan("seed = 1"), Campaign::load(&path).unwrap().plan());
    assert_ne!(plan("seed = 2"), plan("seed = 1"));
    let splits: Vec<_> = plan("seed = 1").iter().map(|case| case.split).collect();
    assert_eq!(splits.iter().filter(|split| **split == Split::Training).count(), 1);
}

#[test]
fn the_shipped_campaigns_can_be_run() {
    for name in ["paper", "small"] {
        let path = format!("{}/campaigns/{name}.toml", env!("CARGO_MANIFEST_DIR"));
        for planned in Campaign::load(path.as_ref()).unwrap().plan() {
            let file = format!("{}.toml", planned.name);
            let case = seakeep::case::Case::parse(&planned.name, &file, &planned.text, &[]);
            assert!(case.is_ok(), "{name}, {}: {}", planned.name, case.unwrap_err());
        }
    }
}

#[test]
fn a_bad_campaign_is_refused() {
    let directory = campaign();
    let text = fs::read_to_string(directory.path().join("tiny.toml")).unwrap();
    for (from, to, part) in [
        ("seed = 1", "sed = 1", "`sed`"),
        ("cases = 2", "cases = 0", "training_cases: no more than there are cases"),
        ("depth_m = [0.2]", "depth_m = []", "group wave: depth_m: needs finite numbers above 0"),
        ("depth_m = [0.2]", "depth_m = [0.01]", "case wave-000: wave-000.toml:"),
    ] {
        assert!(text.contains(from));
        fs::write(directory.path().join("bad.toml"), text.replace(from, to)).unwrap();
        let output = run(directory.path(), &["dataset", "bad.toml", "--out", "data"]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(message.contains(part), "{part} not in {message}");
    }
    let output = run(directory.path(), &["dataset", "absent.toml", "--out", "data"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(stderr(&output).lines().count(), 1);
}
