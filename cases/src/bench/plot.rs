//! The plot of error against time.

use super::{Trial, pareto_front};
use crate::output::OutputError;
use plotters::prelude::*;
use std::path::Path;

const SIZE: (u32, u32) = (900, 560);

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
    let mut text = String::new();
    render(&mut text, title, error, &points).map_err(|reason| OutputError::Plot {
        path: path.to_owned(),
        reason: reason.to_string(),
    })?;
    std::fs::write(path, text).map_err(OutputError::at(path))
}

fn render(
    text: &mut String,
    title: &str,
    error: &str,
    points: &[(f64, f64, String)],
) -> Result<(), Box<dyn std::error::Error>> {
    let root = SVGBackend::with_string(text, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let range = |pick: fn(&(f64, f64, String)) -> f64| {
        let low = points.iter().map(pick).fold(f64::INFINITY, f64::min);
        let high = points.iter().map(pick).fold(0.0, f64::max);
        if low.is_finite() { (low / 1.5, high * 1.5) } else { (0.1, 1.0) }
    };
    let (times, errors) = (range(|p| p.0), range(|p| p.1));
    let mut chart = ChartBuilder::on(&root)
        .caption(title, ("sans-serif", 20))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(80)
        .build_cartesian_2d((times.0..times.1).log_scale(), (errors.0..errors.1).log_scale())?;
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .x_desc("wall time (s)")
        .y_desc(error)
        .y_label_formatter(&|value| format!("{value:.1e}"))
        .draw()?;
    let costs: Vec<(f64, f64)> = points.iter().map(|(time, error, _)| (*time, *error)).collect();
    let front = pareto_front(&costs);
    let mut best: Vec<(f64, f64)> =
        costs.iter().zip(&front).filter(|(_, best)| **best).map(|(point, _)| *point).collect();
    best.sort_by(|a, b| a.0.total_cmp(&b.0));
    chart.draw_series(LineSeries::new(best, &RED))?;
    for ((time, error, label), best) in points.iter().zip(front) {
        let colour = if best { RED } else { BLACK };
        chart.draw_series([Circle::new((*time, *error), 4, colour.filled())])?;
        if best {
            let style = ("sans-serif", 13).into_font().color(&RED);
            let place = EmptyElement::at((*time, *error));
            chart.draw_series([place + Text::new(label.clone(), (6, -14), style)])?;
        }
    }
    root.present()?;
    drop(chart);
    drop(root);
    Ok(())
}
