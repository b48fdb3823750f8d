//! A run from end to end: the files of the output contract, and what an interruption leaves.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

mod common;

use common::{directory, entries, run, seakeep, stderr, stdout};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

const COLUMNS: [(&str, &str, usize); 5] = [
    (
        "motion.csv",
        "time_s,body,sway_m,heave_m,roll_rad,sway_velocity_m_s,heave_velocity_m_s,\
         roll_rate_rad_s,sway_acceleration_m_s2,heave_acceleration_m_s2,roll_acceleration_rad_s2",
        11,
    ),
    // No step has ended at the start.
    ("loads.csv", "time_s,body,force_x_n_per_m,force_y_n_per_m,torque_n_m_per_m", 10),
    ("gauges.csv", "time_s,gauge,x_m,elevation_m", 11),
    ("probes.csv", "time_s,probe,x_m,y_m,pressure_pa,velocity_x_m_s,velocity_y_m_s", 11),
    (
        "diagnostics.csv",
        "time_s,kinetic_energy_j_per_m,potential_energy_j_per_m,volume_error,\
         divergence_rms_per_s,density_error_rms,pressure_iterations,pressure_residual,\
         particles_active,load_evaluations,\
         coupling_residual,power_bond_residual_j_per_m",
        11,
    ),
];

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap()
}

#[test]
fn the_output_contract() {
    let directory = directory();
    let output = run(directory.path(), &["run", "small.toml", "--out", "out"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(stderr(&output).lines().count(), 10, "a line every tenth:\n{}", stderr(&output));
    assert!(stdout(&output).ends_with("results in out\n"), "{}", stdout(&output));
    let out = directory.path().join("out");
    let expected = [
        "diagnostics.csv",
        "gauges.csv",
        "loads.csv",
        "motion.csv",
        "motion.svg",
        "probes.csv",
        "resolved.toml",
        "run.mcap",
        "summary.json",
    ];
    assert_eq!(entries(&out), expected);

    for (name, columns, rows) in COLUMNS {
        let text = read(&out.join(name));
        let mut lines = text.lines();
        assert_eq!(lines.next().unwrap(), columns, "{name}");
        let width = columns.split(',').count();
        let cells: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
        assert_eq!(cells.len(), rows, "{name}");
        for row in &cells {
            assert_eq!(row.len(), width, "{name}");
            let named = |cell: &str| ["pontoon", "left", "bed"].contains(&cell);
            assert!(row.iter().all(|cell| named(cell) || cell.parse::<f64>().unwrap().is_finite()));
        }
        let last: f64 = cells.last().unwrap()[0].parse().unwrap();
        assert!((last - 0.1).abs() < 1e-9, "{name}");
    }
    let first = read(&out.join("motion.csv"));
    let first: Vec<&str> = first.lines().nth(1).unwrap().split(',').collect();
    assert_eq!(first[4].parse::<f64>().unwrap(), 5f64.to_radians());

    let summary: serde_json::Value =
        serde_json::from_str(&read(&out.join("summary.json"))).unwrap();
    assert_eq!(summary["case"], "small");
    assert_eq!(summary["status"], "completed");
    assert_eq!(summary["steps"], 50);
    assert_eq!(summary["fallback_count"], 0);
    assert_eq!(summary["configuration"]["numerics"]["time_step_s"], 0.002);
    for key in ["version", "threads", "simulated_time_s", "wall_time_s", "final_volume_error"] {
        assert!(!summary[key].is_null(), "{key}");
    }
    let coupling = &summary["coupling"];
    assert_eq!((&coupling["steps"], &coupling["load_evaluations"]), (&50.into(), &50.into()));
    let made = coupling["power_bond_residual_magnitude_j_per_m"].as_f64().unwrap();
    assert!(made < 1e-6 * coupling["interface_work_j_per_m"].as_f64().unwrap().abs(), "{made}");
    assert!(summary["stage_time_s"].as_object().unwrap().len() > 5);
    assert!(summary["particles"]["fluid"].as_u64().unwrap() > 200);
    assert!(summary["findings"].as_array().unwrap().len() > 3);
    assert!(read(&out.join("motion.svg")).contains("roll (degrees)"));
}

#[test]
fn another_coupling_is_run_and_reported() {
    let directory = directory();
    let arguments = [
        "run",
        "small.toml",
        "--out",
        "out",
        "--set",
        "coupling.scheme='implicit'",
        "--set",
        "coupling.fluid_substeps=2",
        "--set",
        "coupling.extrapolation='linear'",
    ];
    let output = run(directory.path(), &arguments);
    assert!(output.status.success(), "{}", stderr(&output));
    let summary: serde_json::Value =
        serde_json::from_str(&read(&directory.path().join("out/summary.json"))).unwrap();
    assert_eq!(summary["steps"], 25);
    let coupling = &summary["configuration"]["coupling"];
    assert_eq!(coupling["acceleration"], "iqn_ils");
    // What a repeated solution of the pressure can be told apart by.
    assert_eq!(coupling["tolerance"], 1e-3);
    let total = summary["coupling"]["load_evaluations"].as_u64().unwrap();
    let rows = read(&directory.path().join("out/diagnostics.csv"));
    let evaluations = rows.lines().skip(1).map(|row| row.split(',').nth(9).unwrap());
    assert_eq!(evaluations.map(|cell| cell.parse::<u64>().unwrap()).sum::<u64>(), total);
    // A step of the water needs one or two, and more where the guess is poor.
    assert!((26..250).contains(&total), "{total}");
    assert!(summary["coupling"]["residual_largest"].as_f64().unwrap() <= 1e-3);
}

/// Topics with the number of messages of each, and the last log time, ns.
fn messages(path: &Path) -> (std::collections::BTreeMap<String, usize>, u64) {
    let bytes = std::fs::read(path).unwrap();
    let options = enumset::EnumSet::from(mcap::read::Options::IgnoreEndMagic);
    let stream = mcap::MessageStream::new_with_options(&bytes, options).unwrap();
    let (mut topics, mut last) = (std::collections::BTreeMap::new(), 0);
    // A recording that was cut off ends in an error after its last whole chunk.
    for message in stream.map_while(Result::ok) {
        *topics.entry(message.channel.topic.clone()).or_insert(0) += 1;
        last = message.log_time;
    }
    (topics, last)
}

#[test]
fn the_recording_reads_back() {
    let directory = directory();
    let output = run(directory.path(), &["run", "small.toml", "--out", "out", "--quiet"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let path = directory.path().join("out/run.mcap");
    let (topics, last) = messages(&path);
    let expected = [
        ("/diagnostics", 11),
        ("/gauges/left", 11),
        ("/loads/pontoon", 10),
        ("/motion/pontoon", 11),
        ("/particles", 3),
        ("/probes/bed", 11),
    ];
    let expected = expected.map(|(topic, count)| (topic.to_owned(), count));
    assert_eq!(topics, expected.into());
    assert_eq!(last, 100_000_000);

    let bytes = std::fs::read(&path).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    assert_eq!(summary.attachment_indexes.len(), 1);
    let schema = |topic: &str| {
        let channel = summary.channels.values().find(|c| c.topic == topic).unwrap();
        let schema = channel.schema.clone().unwrap();
        (channel.message_encoding.clone(), schema.name.clone(), schema.encoding.clone())
    };
    let text = |a: &str, b: &str, c: &str| (a.to_owned(), b.to_owned(), c.to_owned());
    assert_eq!(schema("/particles"), text("protobuf", "foxglove.PointCloud", "protobuf"));
    assert_eq!(schema("/motion/pontoon"), text("json", "seakeep.motion", "jsonschema"));
}

#[test]
fn the_resolved_case_runs_to_the_same_results() {
    let directory = directory();
    let path = directory.path();
    let short = ["--quiet", "--set", "end_time_s=0.02"];
    assert!(
        run(path, &[&["run", "small.toml", "--out", "a"], &short[..]].concat()).status.success()
    );
    assert!(run(path, &["run", "a/resolved.toml", "--out", "b", "--quiet"]).status.success());
    for name in ["motion.csv", "loads.csv", "diagnostics.csv", "resolved.toml"] {
        assert_eq!(read(&path.join("a").join(name)), read(&path.join("b").join(name)), "{name}");
    }
}

#[test]
fn one_thread_and_two_give_the_same_bits() {
    let directory = directory();
    let path = directory.path();
    for threads in ["1", "2"] {
        let arguments = ["run", "small.toml", "--quiet", "--threads", threads, "--out", threads];
        let output = run(path, &arguments);
        assert!(output.status.success(), "{}", stderr(&output));
    }
    for (name, _, _) in COLUMNS {
        assert_eq!(read(&path.join("1").join(name)), read(&path.join("2").join(name)), "{name}");
    }
}

#[test]
fn only_what_is_asked_for_is_written() {
    let directory = directory();
    let arguments = [
        "run",
        "small.toml",
        "--quiet",
        "--out",
        "out",
        "--set",
        "end_time_s=0.004",
        "--set",
        "output.mcap=false",
        "--set",
        "output.plot=false",
        "--set",
        "output.tables=[\"motion\"]",
    ];
    assert!(run(directory.path(), &arguments).status.success());
    let written = entries(&directory.path().join("out"));
    assert_eq!(written, ["motion.csv", "resolved.toml", "summary.json"]);
}

/// Starts a run that would last for minutes and waits until it has written some rows.
fn long_run(directory: &Path) -> std::process::Child {
    let child = seakeep(directory)
        .args(["run", "small.toml", "--quiet", "--out", "out", "--set", "end_time_s=1000"])
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    let motion = directory.join("out/motion.csv");
    let begun = Instant::now();
    while std::fs::read_to_string(&motion).map_or(0, |text| text.lines().count()) < 20 {
        assert!(begun.elapsed() < Duration::from_secs(60), "the run writes nothing");
        std::thread::sleep(Duration::from_millis(20));
    }
    // Longer than the recording keeps messages to itself.
    std::thread::sleep(Duration::from_secs(1));
    child
}

#[test]
fn a_killed_run_leaves_readable_files() {
    let directory = directory();
    let mut child = long_run(directory.path());
    child.kill().unwrap();
    child.wait().unwrap();
    let out = directory.path().join("out");
    for (name, columns, _) in COLUMNS {
        let text = read(&out.join(name));
        assert!(text.ends_with('\n'), "{name} ends within a row");
        let width = columns.split(',').count();
        assert!(text.lines().all(|line| line.split(',').count() == width), "{name}");
    }
    let (topics, _) = messages(&out.join("run.mcap"));
    assert!(topics["/motion/pontoon"] > 10 && topics["/particles"] > 1, "{topics:?}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_finishes_its_files_and_says_so() {
    let directory = directory();
    let mut child = long_run(directory.path());
    let sent = std::process::Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(sent.success());
    assert_eq!(child.wait().unwrap().code(), Some(1));
    let out = directory.path().join("out");
    let summary: serde_json::Value =
        serde_json::from_str(&read(&out.join("summary.json"))).unwrap();
    assert_eq!(summary["status"], "interrupted");
    let bytes = std::fs::read(out.join("run.mcap")).unwrap();
    assert!(mcap::Summary::read(&bytes).unwrap().is_some(), "the recording has no index");
    assert!(out.join("motion.svg").exists());
}

#[test]
fn a_failed_run_keeps_what_it_has_and_says_what_failed() {
    let directory = directory();
    let arguments = [
        "run",
        "small.toml",
        "--quiet",
        "--out",
        "out",
        "--set",
        "pressure.max_iterations=1",
        "--set",
        "pressure.tolerance=1e-12",
    ];
    let output = run(directory.path(), &arguments);
    assert_eq!(output.status.code(), Some(1), "{}", stderr(&output));
    let message = stderr(&output);
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(message.contains("did not converge") && message.contains("t = 0"), "{message}");
    let out = directory.path().join("out");
    let summary: serde_json::Value =
        serde_json::from_str(&read(&out.join("summary.json"))).unwrap();
    assert_eq!(summary["status"], "failed");
    assert!(summary["failure"].as_str().unwrap().contains("did not converge"));
    assert_eq!(read(&out.join("motion.csv")).lines().count(), 2, "header and start");
    assert_eq!(messages(&out.join("run.mcap")).0["/motion/pontoon"], 1);
}
