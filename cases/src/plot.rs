//! Figures as SVG: panels of curves and dots, one below the other.

use crate::output::OutputError;
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;
use std::error::Error;
use std::ops::Range;
use std::path::Path;

/// How the points of a curve are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// Joined by a line.
    Line,
    /// A dot each.
    Dots,
}

/// Points of one kind.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name in the legend; without one it is not in it.
    pub name: String,
    /// Points.
    pub points: Vec<(f64, f64)>,
    /// How they are drawn.
    pub style: Style,
}

impl Curve {
    /// A line through `points`.
    #[must_use]
    pub fn line(name: &str, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.to_owned(), points, style: Style::Line }
    }

    /// Dots at `points`.
    #[must_use]
    pub fn dots(name: &str, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.to_owned(), points, style: Style::Dots }
    }
}

/// A pair of axes with what is drawn between them.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Label of the horizontal axis, with the unit.
    pub x_label: String,
    /// Label of the vertical axis, with the unit.
    pub y_label: String,
    /// Whether both axes are logarithmic; every coordinate must be above 0 then.
    pub logarithmic: bool,
    /// Curves, in the order of their colours.
    pub curves: Vec<Curve>,
    /// Texts and where they stand.
    pub notes: Vec<((f64, f64), String)>,
}

impl Panel {
    /// Curves over time (s).
    #[must_use]
    pub fn over_time(y_label: &str, curves: Vec<Curve>) -> Self {
        Self {
            x_label: "time (s)".to_owned(),
            y_label: y_label.to_owned(),
            logarithmic: false,
            curves,
            notes: Vec::new(),
        }
    }
}

/// A titled column of panels.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Title.
    pub title: String,
    /// Panels, from the top.
    pub panels: Vec<Panel>,
    /// Height of each panel, px.
    pub panel_height: u32,
}

/// Width of a figure, px.
const WIDTH: u32 = 900;
/// Height of the title, px.
const TITLE: u32 = 40;

impl Figure {
    /// A figure of panels 260 px high.
    #[must_use]
    pub fn new(title: &str, panels: Vec<Panel>) -> Self {
        Self { title: title.to_owned(), panels, panel_height: 260 }
    }

    /// The figure as the text of an SVG file.
    ///
    /// # Errors
    /// What the back end says.
    pub fn svg(&self) -> Result<String, Box<dyn Error>> {
        let mut text = String::new();
        let rows = self.panels.len().max(1);
        let size = (WIDTH, self.panel_height * rows as u32 + TITLE);
        let root = SVGBackend::with_string(&mut text, size).into_drawing_area();
        root.fill(&WHITE)?;
        let areas = root.titled(&self.title, ("sans-serif", 20))?.split_evenly((rows, 1));
        for (area, panel) in areas.iter().zip(&self.panels) {
            panel.draw(area)?;
        }
        root.present()?;
        drop((root, areas));
        Ok(text)
    }

    /// Writes the figure to `path`.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: &Path) -> Result<(), OutputError> {
        // The back end reports a file that cannot be created only at the end.
        let text = self.svg().map_err(|reason| OutputError::Plot {
            path: path.to_owned(),
            reason: reason.to_string(),
        })?;
        std::fs::write(path, text).map_err(OutputError::at(path))
    }
}

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

impl Panel {
    fn draw(&self, area: &Area<'_>) -> Result<(), Box<dyn Error>> {
        let points = || self.curves.iter().flat_map(|curve| &curve.points);
        let range = |pick: fn(&(f64, f64)) -> f64| {
            let low = points().map(pick).fold(f64::INFINITY, f64::min);
            let high = points().map(pick).fold(f64::NEG_INFINITY, f64::max);
            (low <= high && low.is_finite() && high.is_finite()).then_some((low, high))
        };
        let (Some(x), Some(y)) = (range(|p| p.0), range(|p| p.1)) else { return Ok(()) };
        if self.logarithmic {
            let wide = |(low, high): (f64, f64)| (low / 1.5..high * 1.5).log_scale();
            self.draw_on(area, wide(x), wide(y), &|value| format!("{value:.1e}"))
        } else {
            // A curve that is flat to rounding is drawn flat.
            let margin = (0.05 * (y.1 - y.0)).max(1e-6);
            let (x, y): (Range<f64>, Range<f64>) =
                (x.0..x.1.max(x.0 + 1e-9), y.0 - margin..y.1 + margin);
            self.draw_on(area, x, y, &|value| format!("{value:.4}"))
        }
    }

    fn draw_on<X, Y>(
        &self,
        area: &Area<'_>,
        x: X,
        y: Y,
        format: &dyn Fn(&f64) -> String,
    ) -> Result<(), Box<dyn Error>>
    where
        X: AsRangedCoord<Value = f64>,
        Y: AsRangedCoord<Value = f64>,
        X::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
        Y::CoordDescType: ValueFormatter<f64> + Ranged<ValueType = f64>,
    {
        let mut chart = ChartBuilder::on(area)
            .margin(8)
            .x_label_area_size(32)
            .y_label_area_size(80)
            .build_cartesian_2d(x, y)?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .y_label_formatter(format)
            .draw()?;
        for (index, curve) in self.curves.iter().enumerate() {
            let colour = Palette99::pick(index).to_rgba();
            let points = curve.points.iter().copied();
            let series = match curve.style {
                Style::Line => chart.draw_series(LineSeries::new(points, &colour))?,
                Style::Dots => {
                    chart.draw_series(points.map(|point| Circle::new(point, 3, colour.filled())))?
                }
            };
            if !curve.name.is_empty() && self.curves.len() > 1 {
                series
                    .label(&curve.name)
                    .legend(move |(x, y)| PathElement::new(vec![(x, y), (x + 16, y)], colour));
            }
        }
        for (place, text) in &self.notes {
            let note = Text::new(text.clone(), (6, -14), ("sans-serif", 13));
            chart.draw_series([EmptyElement::at(*place) + note])?;
        }
        if self.curves.iter().filter(|curve| !curve.name.is_empty()).count() > 1 {
            chart.configure_series_labels().background_style(WHITE).border_style(BLACK).draw()?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_holds_its_lines_dots_names_and_notes() {
        let line = Curve::line("ours", vec![(0.0, 0.0), (1.0, 2.0), (2.0, 1.0)]);
        let dots = Curve::dots("measured", vec![(0.5, 1.0), (1.5, 1.5)]);
        let mut panel = Panel::over_time("heave (m)", vec![line, dots]);
        panel.notes.push(((1.0, 1.0), "here".to_owned()));
        let text = Figure::new("a case", vec![panel]).svg().unwrap();
        assert_eq!(text.matches("<circle").count(), 2);
        for part in ["a case", "ours", "measured", "here", "heave (m)", "time (s)"] {
            assert!(text.contains(part), "{part}");
        }
    }

    #[test]
    fn empty_and_flat_curves_can_be_drawn() {
        for points in [vec![], vec![(1.0, 3.0)], vec![(0.0, 3.0), (1.0, 3.0)]] {
            for logarithmic in [false, true] {
                let curves = vec![Curve::line("", points.clone())];
                let curves = if logarithmic && points.len() > 1 { Vec::new() } else { curves };
                let panel = Panel { logarithmic, ..Panel::over_time("", curves) };
                assert!(Figure::new("", vec![panel]).svg().unwrap().contains("</svg>"));
            }
        }
    }
}
