//! Evaluation: what it writes, and that the shipped weights are worth having.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

mod common;

use common::{campaign, entries, run, stderr};
use std::collections::HashMap;

const SHIPPED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../fluid/weights/residual.safetensors");

/// Rows of a table: value of each column.
fn table(path: &std::path::Path) -> Vec<HashMap<String, String>> {
    let mut reader = csv::Reader::from_path(path).unwrap();
    reader.deserialize().map(Result::unwrap).collect()
}

#[test]
fn the_shipped_network_beats_persistence_and_sweeps() {
    let directory = campaign();
    let arguments = [
        "evaluate",
        SHIPPED,
        "--campaign",
        "tiny.toml",
        "--steps",
        "2",
        "--out",
        "out",
        "--rollout",
        "standing_wave",
        "--set",
        "end_time_s=0.2",
        "--set",
        "numerics.particle_spacing_m=0.05",
    ];
    let output = run(directory.path(), &arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    let out = directory.path().join("out");
    let expected = [
        "factors.csv",
        "factors.svg",
        "rollout.csv",
        "rollout.svg",
        "rollout_cost.svg",
        "skill.csv",
        "skill.svg",
    ];
    assert_eq!(entries(&out), expected);

    let skills = table(&out.join("skill.csv"));
    let skill = |solver: &str, column: &str| -> f64 {
        skills.iter().find(|row| row["solver"] == solver).unwrap()[column].parse().unwrap()
    };
    for column in ["skill", "skill_surface", "skill_walls"] {
        assert_eq!(skill("persistence", column), 0.0);
        // A regression bound for the shipped weights, measured 0.968 to 0.99 at ten spacings over the
        // depth; the goals are 0.9, and 0.8 at surface and walls.
        assert!(skill("network", column) > 0.95, "{column}: {}", skill("network", column));
        assert!(skill("network", column) > skill("2 Jacobi", column));
    }
    for row in table(&out.join("factors.csv")).iter().filter(|row| row["solver"] == "network") {
        let factor: f64 = row["factor"].parse().unwrap();
        assert!(factor > -1.0 / 3.0 && factor < 0.5, "{row:?}");
    }
    let errors = |solver: &str| -> f64 {
        let rows = table(&out.join("rollout.csv"));
        let own = rows.iter().filter(|row| row["solver"] == solver);
        own.map(|row| row["error"].parse().unwrap_or(1.0)).sum()
    };
    assert!(errors("network") < 0.1 * errors("2 Jacobi"));
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let directory = campaign();
    for (arguments, part) in [
        (
            vec!["absent.safetensors", "--campaign", "tiny.toml"],
            "absent.safetensors: cannot be read",
        ),
        (vec!["tiny.toml", "--campaign", "tiny.toml"], "tiny.toml: the weights cannot be read"),
        (vec![SHIPPED, "--campaign", "absent.toml"], "absent.toml: cannot be read"),
        (vec![SHIPPED], "name a --campaign, a case for a --rollout or --data"),
        (vec![SHIPPED, "--rollout", "absent"], "absent: no such file"),
        #[cfg(not(feature = "torch"))]
        (vec![SHIPPED, "--data", "data", "--device", "cuda"], "built without the feature torch"),
    ] {
        let output =
            run(directory.path(), &[&["evaluate"], &arguments[..], &["--out", "out"]].concat());
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        assert!(message.contains(part), "{part} not in {message}");
    }
}
