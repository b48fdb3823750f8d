//! Bodies that follow a motion of the case: formulas and files, and files that cannot be followed.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

mod common;

use common::{SMALL, directory, entries, run, stderr};
use std::path::Path;

/// The small case with its box prescribed.
fn led(motion: &str) -> String {
    let mass = "density_kg_m3 = 500.0";
    SMALL.replace("angle_deg = 5.0\n", "").replace(
        mass,
        &format!("engine = \"prescribed\"\nequilibrium_m = [0.4, 0.19]\nmotion = {motion}"),
    )
}

/// Columns 0 and 2 to 10 of `motion.csv`: time, displacement, velocity, acceleration.
fn motion(directory: &Path) -> Vec<[f64; 10]> {
    let text = std::fs::read_to_string(directory.join("motion.csv")).unwrap();
    let row = |line: &str| {
        let cells = line.split(',').enumerate().filter(|(column, _)| *column != 1);
        let numbers: Vec<f64> = cells.map(|(_, cell)| cell.parse().unwrap()).collect();
        numbers.try_into().unwrap()
    };
    text.lines().skip(1).map(row).collect()
}

#[test]
fn a_formula_is_followed() {
    let directory = directory();
    let path = directory.path();
    let text = led("{ heave = { amplitude_m = 0.01, period_s = 0.5, phase_deg = 90 }, \
                    roll = { amplitude_deg = 2, period_s = 0.4 } }");
    std::fs::write(path.join("led.toml"), text).unwrap();
    let output = run(path, &["run", "led.toml", "--out", "out", "--quiet"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let tau = std::f64::consts::TAU;
    for row in motion(&path.join("out")) {
        let [t, sway, heave, roll, _, heave_velocity, roll_rate, ..] = row;
        assert_eq!(sway, 0.0);
        assert!((heave - 0.01 * (tau * t / 0.5).cos()).abs() < 1e-12, "{row:?}");
        let velocity = -0.01 * tau / 0.5 * (tau * t / 0.5).sin();
        assert!((heave_velocity - velocity).abs() < 1e-12, "{row:?}");
        let amplitude = 2f64.to_radians();
        assert!((roll - amplitude * (tau * t / 0.4).sin()).abs() < 1e-12, "{row:?}");
        let rate = amplitude * tau / 0.4 * (tau * t / 0.4).cos();
        assert!((roll_rate - rate).abs() < 1e-12, "{row:?}");
    }
    // The same from the motion that was written, in another folder, and from the resolved case.
    std::fs::create_dir(path.join("again")).unwrap();
    std::fs::write(path.join("again/file.toml"), led("{ file = \"../out/motion.csv\" }")).unwrap();
    let output = run(path, &["run", "again/file.toml", "--out", "file", "--quiet"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let output = run(path, &["run", "file/resolved.toml", "--out", "resolved", "--quiet"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let [formula, file, resolved] =
        ["out", "file", "resolved"].map(|name| motion(&path.join(name)));
    assert_eq!(file, resolved);
    for (a, b) in formula.iter().zip(&file) {
        // A spline through samples every 0.01 s.
        for (column, bound) in [(2, 1e-6), (3, 1e-6), (5, 1e-3), (6, 1e-2)] {
            assert!((a[column] - b[column]).abs() < bound, "{a:?} {b:?}");
        }
    }
}

#[test]
fn a_probe_on_a_body_goes_with_it_and_reads_the_pressure_there() {
    let directory = directory();
    let path = directory.path();
    let sensor = "name = \"keel\"\nbody = \"pontoon\"\nx_m = 0.02\ny_m = -0.06";
    let text = led("{ heave = { amplitude_m = 1e-4, period_s = 0.5, phase_deg = 90 }, \
                    roll = { amplitude_deg = 2, period_s = 100 } }")
    .replace("name = \"bed\"\nx_m = 0.1\ny_m = 0.05", sensor);
    std::fs::write(path.join("led.toml"), text).unwrap();
    let output = run(path, &["run", "led.toml", "--out", "out", "--quiet"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let table = std::fs::read_to_string(path.join("out/probes.csv")).unwrap();
    let row =
        |line: &str| -> Vec<f64> { line.split(',').filter_map(|cell| cell.parse().ok()).collect() };
    for (probe, body) in table.lines().skip(1).map(row).zip(motion(&path.join("out"))) {
        let [t, x, y, pressure, ..] = probe[..] else { panic!("{probe:?} is not wet") };
        let [_, sway, heave, roll, ..] = body;
        let place = [
            0.4 + sway + 0.02 * roll.cos() + 0.06 * roll.sin(),
            0.19 + heave + 0.02 * roll.sin() - 0.06 * roll.cos(),
        ];
        assert!((x - place[0]).abs() < 1e-12 && (y - place[1]).abs() < 1e-12, "{probe:?}");
        if t == 0.0 {
            continue;
        }
        // Hydrostatics, and the added mass of so small a motion: 16 mm/s² times some 5 cm of water.
        let still = 9810.0 * (0.2 - y);
        assert!((pressure - still).abs() < 0.01 * still, "{pressure} {still}");
    }
}

#[test]
fn motions_that_cannot_be_followed() {
    let good = "0,0,0,0\n0.05,0.001,0,0\n0.1,0.002,0,0\n0.2,0,0,0\n";
    let header = "time_s,sway_m,heave_m,roll_rad\n";
    let with = |text: &str| {
        let directory = directory();
        let path = directory.path();
        std::fs::write(path.join("led.toml"), led("{ file = \"m.csv\" }")).unwrap();
        std::fs::write(path.join("m.csv"), text).unwrap();
        let output = run(path, &["check", "led.toml"]);
        assert_eq!(entries(path), ["led.toml", "m.csv", "small.toml"]);
        (output.status.code(), stderr(&output))
    };
    let (code, message) = with(&format!("{header}{good}"));
    assert_eq!(code, Some(0), "{message}");
    let unsorted = good.replace("0.05,", "0.15,");
    let gap = good.replace("0.001", "");
    let word = good.replace("0.001", "left");
    let short = good.replace("0.2,0,0,0\n", "");
    let late = good.replace("0.2,", "0.09,").replace("0.1,", "0.08,");
    for (text, parts) in [
        (format!("{header}{unsorted}"), ["times must rise", "0.1 s follows one at 0.15 s"]),
        (format!("{header}{gap}"), ["m.csv:3", "a gap: sway_m is empty"]),
        (format!("{header}{word}"), ["m.csv:3", "sway_m = \"left\" is no number"]),
        (format!("{header}{}", good.replace("0.001", "nan")), ["a gap: sway of sample 2", "NaN"]),
        (format!("{header}{short}"), ["3 samples", "at least 4"]),
        (format!("{header}{late}"), ["from 0 to 0.09 s", "the run from 0 to 0.1 s"]),
        (format!("t,sway_m,heave_m,roll_rad\n{good}"), ["m.csv", "no column time_s"]),
        (format!("body,{header}ship,0,0,0,0\n"), ["m.csv", "0 samples"]),
    ] {
        let (code, message) = with(&text);
        assert_eq!(code, Some(2), "{message}");
        assert_eq!(message.lines().count(), 1, "{message}");
        let place = "led.toml:";
        assert!(message.contains(place) && message.contains("body[0].motion.file"), "{message}");
        assert!(parts.iter().all(|part| message.contains(part)), "{parts:?}: {message}");
    }
}

#[test]
fn a_motion_given_twice_or_not_at_all() {
    for (text, parts) in [
        (led("{ file = \"absent.csv\" }"), ["body[0].motion.file", "absent.csv: cannot be read"]),
        (led("{ ramp_s = 1 }"), ["body[0].motion", "given once"]),
        (
            led("{ file = \"m.csv\", sway = { amplitude_m = 1, period_s = 1 } }"),
            ["body[0].motion", "given once"],
        ),
        (
            led("{ sway = { amplitude_m = 0.1, period_s = 0 } }"),
            ["body[0].motion.sway.period_s", "0 must be above 0"],
        ),
        (
            led("{ sway = { amplitude_m = 0.1, period_s = 1 } }").replace("prescribed", "rapier"),
            ["body[0].motion", "only a body with engine = \"prescribed\""],
        ),
        (
            SMALL.replace("density_kg_m3 = 500.0", "engine = \"prescribed\""),
            ["body[0].motion", "needs a motion"],
        ),
    ] {
        let directory = directory();
        std::fs::write(directory.path().join("led.toml"), text).unwrap();
        let output = run(directory.path(), &["check", "led.toml"]);
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        let found = message.lines().any(|line| parts.iter().all(|part| line.contains(part)));
        assert!(found, "{parts:?}: {message}");
    }
}
