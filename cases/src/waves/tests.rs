//! What the tests of all theories share.

use super::{StillWater, WaveTheory};
use nalgebra::Vector2;

/// The velocity at (x, y, t) is free of divergence and rotation.
pub(super) fn assert_potential_flow(wave: &dyn WaveTheory, depth: f64, x: f64, time: f64) {
    let step = 1e-4 * depth;
    for y in [0.1 * depth, 0.5 * depth, 0.9 * depth] {
        let along = |dx: f64| wave.velocity(x + dx, y, time);
        let up = |dy: f64| wave.velocity(x, y + dy, time);
        let by_x = (along(step) - along(-step)) / (2.0 * step);
        let by_y = (up(step) - up(-step)) / (2.0 * step);
        let scale = by_x.norm() + by_y.norm();
        assert!((by_x.x + by_y.y).abs() < 1e-6 * scale, "divergence at y = {y}");
        assert!((by_x.y - by_y.x).abs() < 1e-6 * scale, "rotation at y = {y}");
    }
    assert!(wave.velocity(x, 0.0, time).y.abs() < 1e-14, "the bed");
}

/// How far the kinematic condition η_t + u η_x = v is from holding on the surface, m/s.
pub(super) fn surface_residual(wave: &dyn WaveTheory, depth: f64, x: f64, time: f64) -> f64 {
    let step = 1e-4;
    let rate = (wave.elevation(x, time + step) - wave.elevation(x, time - step)) / (2.0 * step);
    let slope = (wave.elevation(x + step, time) - wave.elevation(x - step, time)) / (2.0 * step);
    let u = wave.velocity(x, depth + wave.elevation(x, time), time);
    (rate + u.x * slope - u.y).abs()
}

/// A wave of `cases/reference/waves/raschii.csv`.
pub(super) struct Reference {
    pub(super) order: usize,
    pub(super) depth: f64,
    pub(super) gravity: f64,
    pub(super) height: f64,
    pub(super) length: f64,
    pub(super) period: f64,
    pub(super) points: Vec<Point>,
}

/// A row of it: elevation at `x`, velocity at `x`, `y`, with a crest at x = 0.
pub(super) struct Point {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) elevation: f64,
    pub(super) velocity: Vector2<f64>,
}

impl Reference {
    pub(super) fn water(&self) -> StillWater {
        StillWater { depth: self.depth, gravity: self.gravity }
    }
}

/// The waves of one model in the reference made with raschii.
pub(super) fn raschii(model: &str) -> Vec<Reference> {
    let text = include_str!("../../reference/waves/raschii.csv");
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let mut waves: Vec<Reference> = Vec::new();
    let mut last = String::new();
    for record in reader.records() {
        let record = record.unwrap();
        if &record[0] != model {
            continue;
        }
        let value = |column: usize| record[column].parse::<f64>().unwrap();
        let wave: Vec<&str> = record.iter().take(7).collect();
        if wave.join(",") != last {
            last = wave.join(",");
            waves.push(Reference {
                order: record[1].parse().unwrap(),
                depth: value(2),
                gravity: value(3),
                height: value(4),
                length: value(5),
                period: value(6),
                points: Vec::new(),
            });
        }
        waves.last_mut().unwrap().points.push(Point {
            x: value(7),
            y: value(8),
            elevation: value(9),
            velocity: Vector2::new(value(10), value(11)),
        });
    }
    assert!(!waves.is_empty(), "no {model} in the reference");
    waves
}
