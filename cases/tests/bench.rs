//! `seakeep bench`: a grid of settings, its table and its plot.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

mod common;

use common::{directory, entries, run, stderr, stdout};

/// A standing wave in a small tank: five periods.
const STANDING: &str = r#"
end_time_s = 4.2

[tank]
length_m = 0.8
height_m = 0.3

[water]
depth_m = 0.2
standing_wave = { amplitude_m = 0.008, half_waves = 2 }

[numerics]
particle_spacing_m = 0.04

[[gauge]]
name = "antinode"
x_m = 0.4
"#;

#[test]
fn a_grid_is_run_and_its_errors_are_tabulated_and_drawn() {
    let folder = directory();
    std::fs::write(folder.path().join("standing.toml"), STANDING).unwrap();
    let output = run(
        folder.path(),
        &[
            "bench",
            "standing.toml",
            "--out",
            "bench",
            "--vary",
            "numerics.particle_spacing_m=0.04,0.02",
            "--vary",
            "numerics.time_step_s=0.004,0.002",
        ],
    );
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stdout(&output).contains("antinode: period"), "{}", stdout(&output));
    let out = folder.path().join("bench");
    let expected = ["bench.csv", "bench.svg", "trial-01", "trial-02", "trial-03", "trial-04"];
    assert_eq!(entries(&out), expected);
    let mut reader = csv::Reader::from_path(out.join("bench.csv")).unwrap();
    let header = reader.headers().unwrap().clone();
    let column = |name: &str| header.iter().position(|known| known == name).unwrap();
    let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), 4);
    let number = |row: &csv::StringRecord, name: &str| row[column(name)].parse::<f64>().unwrap();
    for row in &rows {
        assert_eq!(&row[column("status")], "completed");
        assert!(number(row, "error: antinode: period") < 0.2);
        assert!(number(row, "error: volume error, largest") < 0.05);
        assert!(number(row, "wall_time_s") > 0.0);
        // A solve whose first guess is good enough takes none.
        assert!(number(row, "iterations_per_solve") > 0.0);
    }
    assert_eq!(&rows[2][column("numerics.particle_spacing_m")], "0.02");
    assert_eq!(number(&rows[1], "steps"), 2.0 * number(&rows[0], "steps"));
    assert_eq!(number(&rows[2], "particles"), 4.0 * number(&rows[0], "particles"));
    let plot = std::fs::read_to_string(out.join("bench.svg")).unwrap();
    assert!(plot.contains("antinode: period") && plot.matches("<circle").count() == 4);
}

#[test]
fn a_grid_with_a_bad_value_or_a_bad_variation_is_refused() {
    let folder = directory();
    std::fs::write(folder.path().join("standing.toml"), STANDING).unwrap();
    let bench = |vary: &str| {
        let output = run(folder.path(), &["bench", "standing.toml", "--vary", vary]);
        (output.status.code(), stderr(&output))
    };
    let (code, message) = bench("numerics.particle_spacing_m=0.04,0.5");
    assert_eq!(code, Some(2));
    assert!(message.contains("numerics.particle_spacing_m") && message.contains("0.5"));
    let (code, message) = bench("numerics.particle_spacing_m");
    assert_eq!(code, Some(2));
    assert!(message.contains("key=value,value"), "{message}");
    assert_eq!(entries(folder.path()), ["small.toml", "standing.toml"]);
}
