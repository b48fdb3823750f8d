//! The plot of error against time.

use super::{Trial, pareto_front};
use crate::output::OutputError;
use crate::plot::{Curve, Figure, Panel};
use std::path::Path;

/// Draws the error called `error` over the wall time of each trial that has one, both axes
/// logarithmic, with the Pareto front as a line and each of its points named by its settings.
///
/// # Errors
/// When the file cannot be written.
pub fn draw(path: &Path, title: &str, error: &str, trials: &[Trial]) -> Result<(), OutputError> {
    let points: Vec<(f64, f64, String)> = (1..)
        .zip(trials)
        .filter_map(|(number, trial)| {
            let found = trial.error(error).filter(|error| *error > 0.0)?;
            let short = |setting: &String| {
                let (key, value) = setting.split_once('=')?;
                Some(format!("{} {}", key.rsplit('.').next()?, value.trim()))
            };
            let values: Vec<String> = trial.settings.iter().filter_map(short).collect();
            Some((trial.summary.wall_time_s, found, format!("{number}: {}", values.join(", "))))
        })
        .collect();
    let costs: Vec<(f64, f64)> = points.iter().map(|(time, error, _)| (*time, *error)).collect();
    let best = pareto_front(&costs);
    let mut front: Vec<_> = points.iter().zip(best).filter(|p| p.1).map(|p| p.0).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    let line = front.iter().map(|(time, error, _)| (*time, *error)).collect();
    let notes = front.into_iter().map(|(time, error, label)| ((*time, *error), label.clone()));
    let panel = Panel {
        x_label: "wall time (s)".to_owned(),
        y_label: error.to_owned(),
        logarithmic: true,
        curves: vec![Curve::line("Pareto front", line), Curve::dots("trials", costs)],
        notes: notes.collect(),
    };
    Figure { panel_height: 520, ..Figure::new(title, vec![panel]) }.write(path)
}
