//! Cases with waves: what is refused, what is warned of, and what theory writes.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

mod common;

use common::{directory, entries, run, stderr, stdout};
use std::path::Path;

const TANK: &str = r#"
end_time_s = 6.0

[tank]
length_m = 12.0
height_m = 0.6

[water]
depth_m = 0.4

[numerics]
particle_spacing_m = 0.02

[[gauge]]
name = "near"
x_m = 3.0

[[damping_zone]]
inner_x_m = 8.0
outer_x_m = 12.0
rate_per_s = 10.0
"#;

const PISTON: &str = "\n[wavemaker]\ntype = \"piston\"\n";

/// The output of `command` for the tank with `text`.
fn with(folder: &Path, command: &[&str], text: &str) -> std::process::Output {
    std::fs::write(folder.join("tank.toml"), format!("{TANK}{text}")).unwrap();
    run(folder, command)
}

/// `check` refuses `text` with one line of error for each of `expected`, with all of its parts.
fn refused(text: &str, expected: &[&[&str]]) {
    let folder = directory();
    let output = with(folder.path(), &["check", "tank.toml"], text);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert_eq!(message.lines().count(), expected.len(), "{message}");
    for parts in expected {
        let found = message.lines().any(|line| parts.iter().all(|part| line.contains(part)));
        assert!(found, "{parts:?} not in one line of:\n{message}");
    }
}

/// `check` accepts `text` and warns with all of the parts, or does not warn.
fn warned(text: &str, expected: &[&str]) {
    let folder = directory();
    let output = with(folder.path(), &["check", "tank.toml"], text);
    let message = stderr(&output);
    assert!(output.status.success(), "{message}");
    assert_eq!(message.lines().count(), usize::from(!expected.is_empty()), "{message}");
    assert!(expected.iter().all(|part| message.contains(part)), "{message}");
}

fn wave(keys: &str) -> String {
    format!("\n[wave]\n{keys}\n")
}

fn made(keys: &str) -> String {
    wave(keys) + PISTON
}

#[test]
fn every_kind_is_accepted_with_its_keys_and_its_resolved_form_is_the_same_case() {
    for keys in [
        "kind = \"linear\"\nheight_m = 0.01\nperiod_s = 1.2",
        "kind = \"stokes\"\nheight_m = 0.06\nperiod_s = 1.2",
        "kind = \"stream_function\"\nheight_m = 0.06\nperiod_s = 1.2",
        "kind = \"jonswap\"\nsignificant_height_m = 0.04\npeak_period_s = 1.4\nseed = 3",
        "kind = \"pierson_moskowitz\"\nsignificant_height_m = 0.04\npeak_period_s = 1.4",
        "kind = \"new_wave\"\namplitude_m = 0.05\npeak_period_s = 1.4\nfocus_x_m = 4\nfocus_time_s = 5",
        "kind = \"equal_steepness\"\namplitude_m = 0.05\nfocus_x_m = 4\nfocus_time_s = 5\n\
         lowest_frequency_hz = 0.5\nhighest_frequency_hz = 1.2",
        "kind = \"solitary\"\nheight_m = 0.1",
    ] {
        warned(&made(keys), &[]);
        let start = "\n[initial_wave]\ncrest_m = 5.0\n";
        warned(&format!("{}{start}", wave(keys)), &[]);
        let case = seakeep::case::Case::parse(
            "tank",
            "tank.toml",
            &format!("{TANK}{}active_absorption = {{}}\n", made(keys)),
            &[],
        )
        .unwrap();
        let text = case.to_toml().unwrap();
        let again = seakeep::case::Case::parse("tank", "resolved.toml", &text, &[]).unwrap();
        assert_eq!(again, case, "{keys}");
    }
}

#[test]
fn keys_of_another_kind_and_keys_that_lack() {
    refused(
        &made("kind = \"linear\"\nheight_m = 0.01\nseed = 3"),
        &[
            &["wave.period_s", "kind = \"linear\" needs it"],
            &["wave.seed", "takes no such key", "tank.toml:"],
        ],
    );
    refused(&made("kind = \"tsunami\""), &[&["tsunami", "linear"]]);
    refused(
        &made("kind = \"jonswap\"\nsignificant_height_m = -1\npeak_period_s = 1\ncomponents = 3"),
        &[&["wave.significant_height_m", "-1"], &["wave.components", "at least 10"]],
    );
}

#[test]
fn waves_that_nothing_makes_or_two_make() {
    let linear = "kind = \"linear\"\nheight_m = 0.01\nperiod_s = 1.2";
    let start = "\n[initial_wave]\ncrest_m = 0\n";
    refused(&wave(linear), &[&["wave", "nothing makes it"]]);
    refused(PISTON, &[&["wavemaker", "no [wave]"]]);
    refused(&format!("{}{start}", made(linear)), &[&["initial_wave", "[wavemaker] too"]]);
    refused(&format!("{}hinge_m = 0.1\n", made(linear)), &[&["hinge_m", "piston has no hinge"]]);
    let flap = "\n[wavemaker]\ntype = \"flap\"\nhinge_m = 0.5\n";
    refused(&format!("{}{flap}", wave(linear)), &[&["wavemaker.hinge_m", "at most 0.36"]]);
}

#[test]
fn waves_that_break_and_waves_out_of_range() {
    refused(
        &made("kind = \"stream_function\"\nheight_m = 0.3\nperiod_s = 1.2"),
        &[&["wave.height_m", "breaks", "at most 0.2"]],
    );
    refused(&made("kind = \"solitary\"\nheight_m = 0.35"), &[&["breaks", "at most 0.33"]]);
    refused(
        &made(
            "kind = \"new_wave\"\namplitude_m = 0.05\npeak_period_s = 1.4\nfocus_x_m = 40\nfocus_time_s = 5",
        ),
        &[&["wave.focus_x_m", "at most 12"]],
    );
    warned(
        &made("kind = \"linear\"\nheight_m = 0.08\nperiod_s = 1.2"),
        &["wave.height_m", "too high for linear theory"],
    );
    warned(
        &made("kind = \"solitary\"\nheight_m = 0.12\ntheory = \"boussinesq\""),
        &["wave.theory", "off the exact one"],
    );
    warned(
        &made("kind = \"stream_function\"\nheight_m = 0.04\nperiod_s = 4.5"),
        &["damping_zone[0]", "shorter than half a wavelength"],
    );
}

#[test]
fn the_paddle_must_fit_the_tank() {
    let text = made("kind = \"linear\"\nheight_m = 0.01\nperiod_s = 1.2");
    let folder = directory();
    let output = with(
        folder.path(),
        &[
            "check",
            "tank.toml",
            "--set",
            "tank.length_m=0.16",
            "--set",
            "wave.height_m=0.2",
            "--set",
            "damping_zone=[]",
            "--set",
            "gauge=[]",
        ],
        &text,
    );
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("at most half the tank"), "{}", stderr(&output));
}

#[test]
fn a_recorded_motion() {
    let folder = directory();
    let write = |text: &str| std::fs::write(folder.path().join("motion.csv"), text).unwrap();
    let check = || {
        let text = made("kind = \"recorded\"\nfile = \"motion.csv\"");
        let output = with(folder.path(), &["check", "tank.toml"], &text);
        (output.status.code(), stderr(&output))
    };
    assert_eq!(check().0, Some(2), "a file that is not there");
    let series = |f: fn(f64) -> f64| {
        let rows = (0..=700).map(|n| f64::from(n) * 0.01).map(|t| format!("{t},{}\n", f(t)));
        rows.collect::<String>()
    };
    let good = series(|t| 0.02 * (3.0 * t).sin() * t.min(1.0));
    write(&format!("# a motion\ntime_s,position_m\n{good}"));
    assert_eq!(check(), (Some(0), String::new()));
    write(&format!("time_s,angle_rad\n{good}"));
    assert!(check().1.contains("piston needs a record of its position_m"), "{}", check().1);
    write(&format!("t,x\n{good}"));
    assert!(check().1.contains("columns t,x"), "{}", check().1);
    write(&format!("time_s,position_m\n{}", series(|t| 0.1 + 0.0 * t)));
    assert!(check().1.contains("must start at rest"), "{}", check().1);
    write("time_s,position_m\n0,0\n1,zero\n");
    assert!(check().1.contains("wave.file"), "{}", check().1);
    write("time_s,position_m\n0,0\n1,0.1\n");
    let (code, message) = check();
    assert_eq!(code, Some(0));
    assert!(message.contains("warning") && message.contains("ends at 1 s"), "{message}");
}

/// Rows of a table as numbers, without the columns that are none.
fn table(path: &Path) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    text.lines()
        .skip(1)
        .map(|line| line.split(',').filter_map(|cell| cell.parse().ok()).collect())
        .collect()
}

#[test]
fn theory_as_tables() {
    let folder = directory();
    let text = made("kind = \"stream_function\"\nheight_m = 0.06\nperiod_s = 1.2");
    let output =
        with(folder.path(), &["wave", "tank.toml", "--out", "theory", "--at", "1.2"], &text);
    assert!(output.status.success(), "{}", stderr(&output));
    // Wavelength in a closed flume of an independent calculation: 1.94422 m.
    assert!(stdout(&output).contains("1.9442"), "{}", stdout(&output));
    let theory = folder.path().join("theory");
    let expected =
        ["paddle.csv", "resolved.toml", "wave_gauges.csv", "wave_profile.csv", "wave_velocity.csv"];
    assert_eq!(entries(&theory), expected);
    let gauges = table(&theory.join("wave_gauges.csv"));
    assert_eq!(gauges.len(), 601);
    let highest = gauges.iter().map(|row| row[2]).fold(f64::MIN, f64::max);
    assert!((highest - 0.03261).abs() < 2e-5, "{highest}");
    // After one period there is a crest at the paddle, and the velocity below it grows upwards.
    let profile = table(&theory.join("wave_profile.csv"));
    assert!((profile[0][1] - 0.03261).abs() < 1e-5);
    let velocity = table(&theory.join("wave_velocity.csv"));
    assert!(velocity.windows(2).all(|pair| pair[1][2] > pair[0][2]));
    let paddle = table(&theory.join("paddle.csv"));
    assert_eq!(paddle[0][1..], [0.0; 4]);
    let stroke = paddle.iter().map(|row| row[1]).fold(f64::MIN, f64::max);
    assert!((stroke - 0.0242).abs() < 0.001, "{stroke}");

    let output = with(folder.path(), &["wave", "tank.toml", "--at", "7"], &text);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("--at 7"));
    let output = with(folder.path(), &["wave", "tank.toml"], "");
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("no [wave]"));
}
