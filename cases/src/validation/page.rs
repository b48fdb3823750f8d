//! The page: the table and, for each run, its curves over the references'. One HTML file that
//! needs nothing beside it.

use super::Compared;
use super::table::{cells, head};
use crate::plot::Figure;
use std::error::Error;
use std::fmt::Write;

const STYLE: &str = "body{font:15px/1.5 sans-serif;max-width:75em;margin:2em auto;padding:0 1em}\
table{border-collapse:collapse;margin:1em 0}th,td{border:1px solid #bbb;padding:.2em .6em;\
text-align:left;font-size:14px}th{background:#eee}tr.missed td.error{background:#fdd}\
tr.met td.error{background:#dfd}svg{max-width:100%;height:auto}";

/// The page on `runs`.
///
/// # Errors
/// When a figure cannot be drawn.
pub fn page(runs: &[Compared]) -> Result<String, Box<dyn Error>> {
    let mut text = String::new();
    write!(
        text,
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <title>seakeep: validation</title><style>{STYLE}</style></head><body>\n\
         <h1>Validation</h1>\n<p>seakeep {}. Errors are relative: of a series that of Eq. (31) of \
         Ma, Zhang, Yan and Li (2024), √Σ(found − reference)² / √Σ reference². Goals and the \
         paper's errors are for the spacing of the case file, not for its coarse variant.</p>\n",
        env!("CARGO_PKG_VERSION")
    )?;
    write_table(&mut text, runs)?;
    for run in runs {
        write_run(&mut text, run)?;
    }
    text.push_str("</body></html>\n");
    Ok(text)
}

fn write_table(text: &mut String, runs: &[Compared]) -> std::fmt::Result {
    text.push_str("<table><thead><tr>");
    for title in head() {
        write!(text, "<th>{}</th>", escaped(title))?;
    }
    text.push_str("</tr></thead><tbody>\n");
    let found = runs.iter().flat_map(|run| &run.found);
    for (row, (reference, found)) in cells(runs).iter().zip(found) {
        let class = match (found.error, reference.goal) {
            (Some(error), Some(goal)) if error <= goal => "met",
            (Some(_), Some(_)) => "missed",
            _ => "",
        };
        write!(text, "<tr class=\"{class}\">")?;
        for (title, cell) in head().iter().zip(row) {
            write!(text, "<td class=\"{}\">{}</td>", title.replace(' ', "-"), escaped(cell))?;
        }
        text.push_str("</tr>\n");
    }
    text.push_str("</tbody></table>\n");
    Ok(())
}

fn write_run(text: &mut String, run: &Compared) -> Result<(), Box<dyn Error>> {
    writeln!(text, "<h2>{}, {}</h2>", escaped(&run.case), escaped(&run.solver))?;
    writeln!(
        text,
        "<p>{}. Particle spacing {} m, {:.0} s on {} thread(s).</p>",
        escaped(&run.description),
        run.spacing,
        run.wall_time,
        run.threads
    )?;
    if let Some(failure) = &run.failure {
        writeln!(text, "<p><b>The run ended before its time: {}</b></p>", escaped(failure))?;
    }
    text.push_str("<ul>\n");
    for (reference, found) in &run.found {
        let shift =
            found.shift.map_or(String::new(), |shift| format!("; {shift:.3} s added to its times"));
        let (name, source) = (escaped(&reference.name), escaped(&reference.source));
        writeln!(text, "<li>{name}: {source}{shift}</li>")?;
    }
    text.push_str("</ul>\n");
    let panels: Vec<_> = run.found.iter().filter_map(|(_, found)| found.panel.clone()).collect();
    if !panels.is_empty() {
        text.push_str(&Figure::new(&run.case, panels).svg()?);
    }
    Ok(())
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
