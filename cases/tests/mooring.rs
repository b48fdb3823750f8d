//! Mooring lines in cases: tensions without water against MoorDyn, in a run, and lines that cannot
//! be.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

mod common;

use common::{directory, entries, run, stderr, stdout};
use std::fmt::Write;
use std::path::Path;

const TWO_LINES: &str = include_str!("../reference/mooring/two_line_vertical_moordyn.csv");

/// The box of the reference, held down by its lines: nothing is said of their pretension.
const MOORED: &str = r#"
end_time_s = 0.05

[tank]
length_m = 1.5
height_m = 0.9

[water]
depth_m = 0.6

[numerics]
particle_spacing_m = 0.05
time_step_s = 0.005

[[body]]
name = "breakwater"
box = { width_m = 0.4, height_m = 0.15 }
position_m = [0.75, 0.525]
mass_kg_m = 42.0
inertia_kg_m2_m = 0.64

[[mooring]]
name = "seaward"
body = "breakwater"
fairlead_m = [-0.2, -0.075]
anchor_m = [0.55, 0.0]
stiffness_n_m2 = 1.2e5

[[mooring]]
name = "leeward"
body = "breakwater"
fairlead_m = [0.2, -0.075]
anchor_m = [0.95, 0.0]
stiffness_n_m2 = 1.2e5

[output]
series_interval_s = 0.005
"#;

/// Rows of a table, those of one name: its other columns as numbers.
fn rows(path: &Path, name: &str) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).unwrap();
    let of_name = text.lines().skip(1).filter(|line| line.split(',').nth(1) == Some(name));
    let numbers = |line: &str| {
        let cells = line.split(',').enumerate().filter(|(column, _)| *column != 1);
        cells.map(|(_, cell)| cell.parse().unwrap()).collect()
    };
    of_name.map(numbers).collect()
}

/// The reference's motion, its roll turned to counter-clockwise, and the tensions of both lines.
fn reference() -> (String, Vec<[f64; 2]>) {
    let mut motion = "time_s,sway_m,heave_m,roll_rad\n".to_owned();
    let mut tensions = Vec::new();
    for line in TWO_LINES.lines().skip(1) {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        writeln!(motion, "{},{},{},{}", cells[0], cells[1], cells[2], -cells[3]).unwrap();
        tensions.push([cells[4], cells[5]]);
    }
    (motion, tensions)
}

#[test]
fn tensions_without_water_are_those_of_moordyn() {
    let directory = directory();
    let path = directory.path();
    let (motion, tensions) = reference();
    std::fs::write(path.join("moored.toml"), MOORED).unwrap();
    std::fs::write(path.join("motion.csv"), motion).unwrap();
    let output = run(path, &["mooring", "moored.toml", "--motion", "motion.csv", "--out", "out"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stdout(&output).contains("seaward") && stdout(&output).contains("slack"));
    assert_eq!(entries(&path.join("out")), ["mooring.csv", "resolved.toml", "run.mcap"]);
    let table = path.join("out/mooring.csv");
    let header = "time_s,line,tension_n_per_m,length_m,fairlead_x_m,fairlead_y_m";
    assert!(std::fs::read_to_string(&table).unwrap().starts_with(header));
    for (index, name) in ["seaward", "leeward"].into_iter().enumerate() {
        let found = rows(&table, name);
        assert_eq!(found.len(), tensions.len());
        let (mut error, mut scale) = (0.0, 0.0);
        for (row, known) in found.iter().zip(&tensions) {
            error += (row[1] - known[index]).powi(2);
            scale += known[index].powi(2);
        }
        let relative = f64::sqrt(error / scale);
        println!("{name}: {relative:.2e}");
        assert!(relative < 1e-4, "{name}: {relative}");
    }
    // What was found is said, and asks for the same.
    let resolved = std::fs::read_to_string(path.join("out/resolved.toml")).unwrap();
    let length = 0.45 - 88.29 / 1.2e5;
    let lengths: Vec<f64> = resolved
        .lines()
        .filter_map(|line| line.strip_prefix("unstretched_length_m = "))
        .map(|value| value.parse().unwrap())
        .collect();
    assert_eq!(lengths.len(), 2);
    assert!(lengths.iter().all(|found| (found - length).abs() < 1e-12), "{lengths:?}");
}

#[test]
fn a_run_records_its_lines() {
    let directory = directory();
    let path = directory.path();
    std::fs::write(path.join("moored.toml"), MOORED).unwrap();
    let plan = run(path, &["check", "moored.toml", "--plan"]);
    let plan = stdout(&plan);
    let line = plan.lines().find(|line| line.contains("moorings")).unwrap();
    // ω² = 2 k/m + 2 k (0.2² + 0.075²)/I, ω h = 0.7.
    assert!(line.contains("kept") && line.contains("seaward, leeward; 8 substeps"), "{line}");
    let output = run(path, &["run", "moored.toml", "--out", "out", "--quiet"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let found = rows(&path.join("out/mooring.csv"), "seaward");
    assert_eq!(found.len(), 11);
    assert!((found[0][1] - 88.29).abs() < 1e-6, "{:?}", found[0]);
    assert!((found[0][2] - 0.45).abs() < 1e-12);
    assert!((found[0][3] - 0.55).abs() < 1e-12 && (found[0][4] - 0.45).abs() < 1e-12);
    // In its equilibrium it stays: the load of still water is exact.
    assert!(found.iter().all(|row| (row[1] - 88.29).abs() < 0.5), "{found:?}");
    // The motion of the run will do for the lines alone.
    let motion = ["--motion", "out/motion.csv", "--out", "alone", "--quiet"];
    let output = run(path, &[&["mooring", "moored.toml"], &motion[..]].concat());
    assert!(output.status.success(), "{}", stderr(&output));
    let alone = rows(&path.join("alone/mooring.csv"), "seaward");
    for (coupled, alone) in found.iter().zip(&alone) {
        assert!((coupled[1] - alone[1]).abs() < 1e-6, "{coupled:?} {alone:?}");
    }
}

/// One line of error, with all of `parts`, and exit code 2.
fn refused(arguments: &[&str], text: &str, parts: &[&str]) {
    let directory = directory();
    let path = directory.path();
    std::fs::write(path.join("moored.toml"), text).unwrap();
    std::fs::write(path.join("motion.csv"), reference().0).unwrap();
    let unsorted = "time_s,sway_m,heave_m,roll_rad\n0,0,0,0\n2,0,0,0\n1,0,0,0\n3,0,0,0\n";
    std::fs::write(path.join("unsorted.csv"), unsorted).unwrap();
    let before = entries(path);
    let output = run(path, arguments);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(parts.iter().all(|part| message.contains(part)), "{parts:?}: {message}");
    assert_eq!(entries(path), before);
}

#[test]
fn lines_that_cannot_be() {
    let catenary = "kind = \"catenary\"\naxial_stiffness_n_m = 1e4\nweight_n_m2 = 0.8\n\
                    unstretched_length_m = ";
    let first = |old: &str, new: &str| MOORED.replacen(old, new, 1);
    let spring = "stiffness_n_m2 = 1.2e5";
    for (text, parts) in [
        (
            first("[-0.2, -0.075]", "[-0.25, -0.075]"),
            ["mooring[0].fairlead_m", "0.0500 m off breakwater"],
        ),
        (
            first(spring, &format!("{catenary}0.4")),
            ["mooring[0].unstretched_length_m", "0.4 m is too short"],
        ),
        (
            first(spring, &format!("{catenary}0")),
            ["mooring[0].unstretched_length_m", "0 must be above 0"],
        ),
        (
            first(spring, "stiffness_n_m2 = 100\npretension_n_m = 50"),
            ["mooring[0]", "unstretched length (m) = -0.0"],
        ),
        (
            first(spring, "stiffness_n_m2 = 100\nunstretched_length_m = -1"),
            ["mooring[0].unstretched_length_m", "-1 must be above 0"],
        ),
        (
            first(spring, "stiffness_n_m2 = 9\npretension_n_m = 0\nunstretched_length_m = 1"),
            ["mooring[0].pretension_n_m", "given once"],
        ),
        (first(spring, ""), ["mooring[0].stiffness_n_m2", "a spring needs it"]),
        (
            first(spring, &format!("{catenary}0.5\ndamping_n_s_m2 = 1")),
            ["mooring[0].damping_n_s_m2", "a catenary has none"],
        ),
        (
            first("body = \"breakwater\"", "body = \"ship\""),
            ["mooring[0].body", "no body \"ship\""],
        ),
        (first("[0.55, 0.0]", "[0.55, -1]"), ["mooring[0].anchor_m[1]", "-1 must be at least 0"]),
        (first("[0.55, 0.0]", "[0.75, 0.0]"), ["mooring[0].pretension_n_m", "no pull"]),
        (
            first("mass_kg_m = 42.0", "mass_kg_m = 70.0"),
            ["mooring[0].pretension_n_m", "(0.00, -98.10) N/m"],
        ),
        (first("leeward", "seaward"), ["mooring[1].name", "another mooring"]),
    ] {
        refused(&["check", "moored.toml"], &text, &parts);
    }
}

#[test]
fn motions_that_lines_cannot_follow() {
    let with = |file| ["mooring", "moored.toml", "--motion", file];
    refused(&with("absent.csv"), MOORED, &["absent.csv: cannot be read"]);
    refused(&with("unsorted.csv"), MOORED, &["unsorted.csv", "times must rise"]);
    let without = MOORED.split("[[mooring]]").next().unwrap();
    refused(&with("motion.csv"), without, &["no mooring in the case"]);
    let second = "\n[[body]]\nname = \"buoy\"\nbox = { width_m = 0.1, height_m = 0.1 }\n\
                  position_m = [0.3, 0.6]\ndensity_kg_m3 = 500\n\n[[mooring]]\nname = \"chain\"\n\
                  body = \"buoy\"\nkind = \"catenary\"\nfairlead_m = [0, -0.05]\n\
                  anchor_m = [0.1, 0.0]\naxial_stiffness_n_m = 1e4\nweight_n_m2 = 1\n\
                  unstretched_length_m = 0.7\n";
    let both = format!("{MOORED}{second}");
    refused(&with("motion.csv"), &both, &["2 bodies are moored", "column body"]);
}
