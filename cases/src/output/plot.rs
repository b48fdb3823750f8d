//! The plot beside the tables.

use super::OutputError;
use plotters::prelude::*;
use std::path::Path;

/// Width of a plot and height of each of its panels, px.
const SIZE: (u32, u32) = (900, 260);

/// One panel: a curve for each name over a common time axis.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Label of the vertical axis, with the unit.
    pub label: String,
    /// Name and points (time in s, value) of each curve.
    pub curves: Vec<(String, Vec<(f64, f64)>)>,
}

/// Draws panels one below the other into an SVG file.
///
/// # Errors
/// When the file cannot be written.
pub fn draw(path: &Path, title: &str, panels: &[Panel]) -> Result<(), OutputError> {
    // The back end reports a file that cannot be created only at the end.
    let mut text = String::new();
    render(&mut text, title, panels).map_err(|reason| OutputError::Plot {
        path: path.to_owned(),
        reason: reason.to_string(),
    })?;
    std::fs::write(path, text).map_err(OutputError::at(path))
}

fn render(
    text: &mut String,
    title: &str,
    panels: &[Panel],
) -> Result<(), Box<dyn std::error::Error>> {
    let size = (SIZE.0, SIZE.1 * panels.len().max(1) as u32 + 40);
    let root = SVGBackend::with_string(text, size).into_drawing_area();
    root.fill(&WHITE)?;
    let root = root.titled(title, ("sans-serif", 20))?;
    for (area, panel) in root.split_evenly((panels.len().max(1), 1)).iter().zip(panels) {
        let points = || panel.curves.iter().flat_map(|(_, points)| points);
        let end = points().map(|point| point.0).fold(0.0, f64::max);
        let low = points().map(|point| point.1).fold(f64::INFINITY, f64::min);
        let high = points().map(|point| point.1).fold(f64::NEG_INFINITY, f64::max);
        if !(low.is_finite() && high.is_finite() && end > 0.0) {
            continue;
        }
        // A curve that is flat to rounding is drawn flat.
        let margin = (0.05 * (high - low)).max(1e-6);
        let mut chart = ChartBuilder::on(area)
            .margin(8)
            .x_label_area_size(32)
            .y_label_area_size(72)
            .build_cartesian_2d(0.0..end, low - margin..high + margin)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_desc("time (s)")
            .y_desc(&panel.label)
            .y_label_formatter(&|value| format!("{value:.4}"))
            .draw()?;
        for (index, (name, points)) in panel.curves.iter().enumerate() {
            let colour = Palette99::pick(index).to_rgba();
            let series = chart.draw_series(LineSeries::new(points.iter().copied(), &colour))?;
            if panel.curves.len() > 1 {
                series
                    .label(name)
                    .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 16, y)], colour));
            }
        }
        if panel.curves.len() > 1 {
            chart.configure_series_labels().background_style(WHITE).draw()?;
        }
    }
    root.present()?;
    drop(root);
    Ok(())
}
