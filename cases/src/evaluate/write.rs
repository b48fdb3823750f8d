//! Tables and plots of an evaluation.

use super::{EvaluateError, FactorRow, RolloutRow, SkillRow};
use crate::output::OutputError;
use crate::plot::{Curve, Figure, Panel};
use serde::Serialize;
use std::path::Path;

fn table(path: &Path, rows: &[impl Serialize]) -> Result<(), OutputError> {
    let fail = |error: csv::Error| OutputError::at(path)(error.into());
    let mut writer = csv::Writer::from_path(path).map_err(fail)?;
    for row in rows {
        writer.serialize(row).map_err(fail)?;
    }
    writer.flush().map_err(|error| fail(error.into()))
}

/// Error against cost: a dot for each solver, with its name.
fn costs(
    path: &Path,
    title: &str,
    [x_label, y_label]: [&str; 2],
    points: Vec<(f64, f64, String)>,
) -> Result<(), OutputError> {
    let panel = Panel {
        x_label: x_label.to_owned(),
        y_label: y_label.to_owned(),
        logarithmic: true,
        curves: vec![Curve::dots("", points.iter().map(|(x, y, _)| (*x, *y)).collect())],
        notes: points.into_iter().map(|(x, y, name)| ((x, y), name)).collect(),
    };
    Figure { panel_height: 520, ..Figure::new(title, vec![panel]) }.write(path)
}

/// `skill.csv`, and error against time as `skill.svg`.
///
/// # Errors
/// When a file cannot be written.
pub fn write_skills(folder: &Path, rows: &[SkillRow]) -> Result<(), EvaluateError> {
    table(&folder.join("skill.csv"), rows)?;
    let points = rows
        .iter()
        .filter(|row| row.skill < 1.0 && row.time_ms > 0.0)
        .map(|row| (row.time_ms, (1.0 - row.skill).sqrt(), row.solver.to_owned()))
        .collect();
    let axes = ["wall time (ms a step and 1000 particles)", "error over that of the last pressure"];
    Ok(costs(&folder.join("skill.svg"), "Single steps", axes, points)?)
}

/// `factors.csv` and `factors.svg`: what is left of modal errors.
///
/// # Errors
/// When a file cannot be written.
pub fn write_factors(folder: &Path, rows: &[FactorRow]) -> Result<(), EvaluateError> {
    table(&folder.join("factors.csv"), rows)?;
    let panel = |label: &str, value: fn(&FactorRow) -> f64| {
        let groups = rows.chunk_by(|a, b| a.solver == b.solver);
        let point = |row: &FactorRow| (row.wavelength_spacings.log2(), value(row));
        let curves =
            groups.map(|group| Curve::line(group[0].solver, group.iter().map(point).collect()));
        Panel {
            x_label: "wavelength in spacings, powers of two".to_owned(),
            y_label: label.to_owned(),
            logarithmic: false,
            curves: curves.collect(),
            notes: Vec::new(),
        }
    };
    let panels = [panel("e", |row| row.factor), panel("all that is left", |row| row.left)];
    Ok(Figure::new("What is left of an error", panels.to_vec())
        .write(&folder.join("factors.svg"))?)
}

/// `rollout.csv`, error over time as `rollout.svg` and mean error against wall time as
/// `rollout_cost.svg`.
///
/// # Errors
/// When a file cannot be written.
pub fn write_rollouts(folder: &Path, rows: &[RolloutRow]) -> Result<(), EvaluateError> {
    table(&folder.join("rollout.csv"), rows)?;
    let (mut curves, mut points) = (Vec::new(), Vec::new());
    for group in rows.chunk_by(|a, b| a.case == b.case && a.solver == b.solver) {
        let Some(last) = group.last() else { continue };
        let name = format!("{}, {}", last.case, last.solver);
        let errors: Vec<(f64, f64)> =
            group.iter().filter_map(|row| Some((row.time_s, row.error?))).collect();
        if errors.len() == group.len() {
            let mean = errors.iter().map(|(_, error)| error).sum::<f64>() / errors.len() as f64;
            points.push((last.pressure_ms, mean, name.clone()));
        }
        let points = errors.into_iter().map(|(time, error)| (time, error.max(1e-9).log10()));
        curves.push(Curve::line(&name, points.collect()));
    }
    points.retain(|(time, error, _)| *time > 0.0 && *error > 0.0);
    let panel = Panel::over_time("log10 of the elevation's error", curves);
    Figure::new("Whole runs", vec![panel]).write(&folder.join("rollout.svg"))?;
    let axes = ["wall time of the pressure (ms a step)", "mean error of the elevation"];
    Ok(costs(&folder.join("rollout_cost.svg"), "Whole runs", axes, points)?)
}
