//! The table of a bench: a row for each trial.

use super::Trial;
use crate::output::OutputError;
use std::collections::BTreeSet;
use std::path::Path;

/// Writes `path`: the settings, how the run ended, its errors, times and effort. Columns of errors
/// and stages are those that any trial has.
///
/// # Errors
/// When the file cannot be written.
pub fn write(path: &Path, trials: &[Trial]) -> Result<(), OutputError> {
    let failed = |error: csv::Error| OutputError::at(path)(error.into());
    let mut writer = csv::Writer::from_path(path).map_err(failed)?;
    let keys: Vec<&str> = trials.first().map_or(Vec::new(), |trial| {
        trial.settings.iter().filter_map(|s| Some(s.split_once('=')?.0)).collect()
    });
    let mut errors: Vec<&str> = Vec::new();
    for (name, _) in trials.iter().flat_map(|trial| &trial.errors) {
        if !errors.contains(&name.as_str()) {
            errors.push(name);
        }
    }
    let stages: BTreeSet<&String> =
        trials.iter().flat_map(|trial| trial.summary.stage_time_s.keys()).collect();

    let mut header: Vec<String> = vec!["trial".to_owned()];
    header.extend(keys.iter().map(|key| (*key).to_owned()));
    header.push("status".to_owned());
    header.extend(errors.iter().map(|name| format!("error: {name}")));
    header.extend(
        ["wall_time_s", "time_per_step_s", "particles", "steps", "iterations_per_solve"]
            .map(str::to_owned),
    );
    header.extend(stages.iter().map(|stage| format!("{stage}_s")));
    writer.write_record(&header).map_err(failed)?;

    for (number, trial) in (1..).zip(trials) {
        let summary = &trial.summary;
        let mut row = vec![number.to_string()];
        row.extend(
            trial.settings.iter().filter_map(|s| Some(s.split_once('=')?.1.trim().to_owned())),
        );
        row.push(format!("{:?}", summary.status).to_lowercase());
        let text = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        row.extend(errors.iter().map(|name| text(trial.error(name))));
        row.push(summary.wall_time_s.to_string());
        row.push(text((summary.steps > 0).then(|| summary.wall_time_s / summary.steps as f64)));
        row.push(summary.particles.map_or(String::new(), |count| count.fluid.to_string()));
        row.push(summary.steps.to_string());
        row.push(text(summary.pressure_iterations_mean));
        row.extend(stages.iter().map(|stage| text(summary.stage_time_s.get(*stage).copied())));
        writer.write_record(&row).map_err(failed)?;
    }
    writer.flush().map_err(OutputError::at(path))
}
