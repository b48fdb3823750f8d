//! `seakeep validate`: references of every kind against a motion that is known, the table, the
//! page, and references that cannot be compared with. And the coarse variant of a case.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

mod common;

use common::{SMALL, directory, entries, run, stderr, stdout};
use std::f64::consts::TAU;
use std::fmt::Write;
use std::path::Path;

/// The small case with a box that heaves by 10 mm sin(2π t/0.5 s) for two periods, and references.
fn heaving(references: &str) -> String {
    let text = SMALL
        .replace("angle_deg = 5.0\n", "")
        .replace(
            "density_kg_m3 = 500.0",
            "engine = \"prescribed\"\nmotion = { heave = { amplitude_m = 0.01, period_s = 0.5 } }",
        )
        .replace("end_time_s = 0.1", "coarse = [\"numerics.time_step_s=0.004\"]\nend_time_s = 1.0")
        .replace("particle_spacing_m = 0.02", "particle_spacing_m = 0.02\ntime_step_s = 0.0025");
    format!("{text}\n{references}")
}

/// The heave of the box in mm, downwards, on a clock that is 0.13 s slow, and 10 % too much.
fn write_measured(path: &Path) {
    let mut text = "# as measured\nclock_s,down_mm,note\n".to_owned();
    for row in 0..40 {
        let clock = 0.02 * f64::from(row);
        let heave = 0.011 * (TAU * (clock + 0.13) / 0.5).sin();
        writeln!(text, "{clock},{},x", -1000.0 * heave).unwrap();
    }
    std::fs::write(path.join("measured.csv"), text).unwrap();
}

const REFERENCES: &str = r#"
[comparison]
time_shift_s = [0.0, 0.2]

[[reference]]
name = "heave"
source = "made up <here>"
table = "motion"
column = "heave_m"
measure = "series"
file = "measured.csv"
file_columns = ["clock_s", "down_mm"]
scale = -0.001
goal = 0.10

[[reference]]
name = "amplitude"
source = "the motion asked for"
table = "motion"
of = "pontoon"
column = "heave_m"
measure = "amplitude"
period_s = 0.5
value = 0.01
goal = 0.001

[[reference]]
name = "amplitude of the file"
source = "the file"
table = "motion"
column = "heave_m"
measure = "amplitude"
period_s = 0.5
file = "measured.csv"
file_columns = ["clock_s", "down_mm"]
scale = -0.001

[[reference]]
name = "largest speed"
source = "the motion asked for"
table = "motion"
column = "heave_velocity_m_s"
measure = "largest"
from_s = 0.4
value = 0.12566

[[reference]]
name = "too late"
source = "nowhere"
table = "motion"
column = "heave_m"
measure = "mean"
until_s = 2.0
value = 1.0

[[reference]]
name = "volume"
source = "incompressible"
finding = "volume error, largest"
"#;

/// The rows of `validation.csv` as cells.
fn rows(path: &Path) -> Vec<Vec<String>> {
    let mut reader = csv::Reader::from_path(path.join("validation.csv")).unwrap();
    let cells = |row: csv::StringRecord| row.iter().map(str::to_owned).collect();
    reader.records().map(|row| cells(row.unwrap())).collect()
}

#[test]
fn a_known_motion_against_references_of_every_kind() {
    let directory = directory();
    let path = directory.path();
    write_measured(path);
    std::fs::write(path.join("heaving.toml"), heaving(REFERENCES)).unwrap();
    let output = run(path, &["validate", "heaving.toml", "--full", "--out", "out"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(entries(&path.join("out")), ["heaving-ppe", "validation.csv", "validation.html"]);

    let rows = rows(&path.join("out"));
    let number = |row: usize, column: usize| rows[row][column].parse::<f64>().unwrap();
    let error = |row: usize| number(row, 7);
    // Eq. (31) of a factor 1/1.1, with the clock found.
    assert!((error(0) - 0.1 / 1.1).abs() < 1e-3, "{rows:?}");
    assert!((number(0, 10) - 0.13).abs() < 1e-3, "{rows:?}");
    assert!(error(1) < 1e-4, "{rows:?}");
    assert!((number(2, 6) - 0.011).abs() < 1e-4 && (error(2) - 0.1 / 1.1).abs() < 1e-2);
    assert!(error(3) < 1e-3, "{rows:?}");
    assert_eq!((rows[4][7].as_str(), rows[4][13].as_str()), ("", "the run is too short"));
    assert_eq!(error(5), number(5, 5));

    let table = stdout(&output);
    let line = |name: &str| table.lines().find(|line| line.contains(name)).unwrap().to_owned();
    assert!(line("  heave  ").contains("9.09 %"), "{table}");
    assert!(line("too late").contains("the run is too short"), "{table}");
    let page = std::fs::read_to_string(path.join("out/validation.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("made up &lt;here&gt;"));
    assert!(!page.contains("href") && !page.contains("src="), "the page needs nothing beside it");

    // The results that are there can be compared again, also with the resolved case alone.
    let again = ["validate", "heaving.toml", "--results", "out/heaving-ppe", "--out", "again"];
    let output = run(path, &again);
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(self::rows(&path.join("again")), rows);
    std::fs::remove_file(path.join("measured.csv")).unwrap();
    let resolved = "out/heaving-ppe/resolved.toml";
    let output = run(path, &["validate", resolved, "--results", "out/heaving-ppe", "--out", "c"]);
    assert!(output.status.success(), "{}", stderr(&output));
    assert_eq!(self::rows(&path.join("c")), rows);
}

#[test]
fn a_coarse_variant_is_run_where_it_is_asked_for() {
    let directory = directory();
    let path = directory.path();
    let text = heaving("").replace("end_time_s = 1.0", "end_time_s = 0.02");
    std::fs::write(path.join("heaving.toml"), text).unwrap();
    let steps = |arguments: &[&str]| {
        let output = run(path, &[&["check", "heaving.toml"], arguments].concat());
        assert!(output.status.success(), "{}", stderr(&output));
        stdout(&output)
    };
    assert!(steps(&[]).starts_with("heaving: ok, 8 steps of 0.0025 s"));
    assert!(steps(&["--coarse"]).starts_with("heaving-coarse: ok, 5 steps of 0.004 s"));
    let finer = ["--coarse", "--set", "numerics.time_step_s=0.002"];
    assert!(steps(&finer).starts_with("heaving-coarse: ok, 10 steps of 0.002 s"));
    // What is coarse by now is not so again.
    let output = run(path, &["run", "heaving.toml", "--coarse", "--out", "out", "--quiet"]);
    assert!(output.status.success(), "{}", stderr(&output));
    let output = run(path, &["check", "out/resolved.toml", "--coarse"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("no coarse variant"), "{}", stderr(&output));
}

#[test]
fn references_that_cannot_be() {
    let directory = directory();
    let path = directory.path();
    write_measured(path);
    let refused = |text: &str, parts: &[&str]| {
        std::fs::write(path.join("bad.toml"), heaving(text)).unwrap();
        for command in ["validate", "check"] {
            let output = run(path, &[command, "bad.toml"]);
            let message = stderr(&output);
            assert_eq!(output.status.code(), Some(2), "{message}");
            assert_eq!(message.lines().count(), 1, "{message}");
            assert!(parts.iter().all(|part| message.contains(part)), "{parts:?}: {message}");
        }
    };
    let reference = |rest: &str| format!("[[reference]]\nname = \"a\"\nsource = \"b\"\n{rest}\n");
    let series = |table: &str, column: &str, rest: &str| {
        reference(&format!("table = \"{table}\"\ncolumn = \"{column}\"\n{rest}"))
    };
    let file = |name: &str, column: &str| {
        format!(
            "measure = \"series\"\nfile = \"{name}\"\nfile_columns = [\"clock_s\", \"{column}\"]"
        )
    };
    let mean = "measure = \"mean\"\nvalue = 1";
    let lacks = "table = \"motion\"\nmeasure = \"mean\"\nvalue = 1";
    refused(&reference(lacks), &["reference[0].column", "missing: there is no finding either"]);
    refused(
        &series("motion", "pitch", mean),
        &["reference[0].column", "no column \"pitch\"", "roll_rad"],
    );
    refused(
        &series("motion", "roll_rad", &format!("of = \"hull\"\n{mean}")),
        &["reference[0].of", "\"hull\"", "pontoon"],
    );
    refused(
        &series("motion", "roll_rad", "measure = \"amplitude\"\nvalue = 1"),
        &["reference[0].period_s", "amplitude"],
    );
    refused(
        &series("motion", "roll_rad", "measure = \"largest\""),
        &["reference[0].value", "either a value or a file"],
    );
    let roll = |rest: &str| series("motion", "roll_rad", rest);
    refused(&roll(&file("absent.csv", "down_mm")), &["reference[0].file", "absent.csv"]);
    refused(&roll(&file("measured.csv", "up_mm")), &["measured.csv", "no column \"up_mm\""]);
    refused(
        &roll(&file("measured.csv", "note")),
        &["measured.csv", "line 3", "\"x\" is no number"],
    );
    let still = "finding = \"x\"\n[comparison]\ntime_shift_s = [1.0, 0.5]";
    refused(&reference(still), &["comparison.time_shift_s", "must rise"]);

    std::fs::write(path.join("none.toml"), heaving("")).unwrap();
    let output = run(path, &["validate", "none.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("names no [[reference]]"), "{}", stderr(&output));
    assert_eq!(entries(path), ["bad.toml", "measured.csv", "none.toml", "small.toml"]);
}
