//! Reading and checking references.

use super::checks::{Allowed, Checker, FINITE, NOT_NEGATIVE, POSITIVE};
use super::library::shipped;
use super::reference_keys::{MeasureName, ReferenceKeys};
use super::source::Source;
use super::{CaseKeys, Problem, TableName};
use crate::output::rows::columns;
use std::io::Read;
use std::path::Path;

/// Puts the series of files in the place of their names. `folder` is that of the case file; a file
/// that is not there may be one of those that come with the program.
///
/// # Errors
/// What is wrong with each file.
pub(super) fn read(
    keys: &mut CaseKeys,
    folder: &Path,
    source: &Source,
) -> Result<(), Vec<Problem>> {
    let mut problems = Vec::new();
    for (index, reference) in keys.reference.iter_mut().enumerate() {
        if let Err(message) = read_series(reference, folder) {
            problems.push(source.problem(&format!("reference[{index}].file"), message));
        }
    }
    if problems.is_empty() { Ok(()) } else { Err(problems) }
}

fn read_series(reference: &mut ReferenceKeys, folder: &Path) -> Result<(), String> {
    let Some(file) = reference.file.take() else { return Ok(()) };
    if reference.times_s.is_some() || reference.values.is_some() {
        return Err("times_s and values are in the case file too: either one".to_owned());
    }
    let path = folder.join(&file);
    let failed = |reason: String| format!("{}: {reason}", path.display());
    let Some(columns) = reference.file_columns.take() else {
        return Err(failed("file_columns is missing: the columns of time and value".to_owned()));
    };
    let text = match shipped(folder, &file) {
        Some(text) => text.to_owned(),
        None => {
            let mut text = String::new();
            let mut opened = std::fs::File::open(&path).map_err(|e| failed(e.to_string()))?;
            opened.read_to_string(&mut text).map_err(|e| failed(e.to_string()))?;
            text
        }
    };
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let header = reader.headers().map_err(|e| failed(e.to_string()))?.clone();
    let place = |column: &String| {
        let found = header.iter().position(|known| known == column);
        found.ok_or_else(|| failed(format!("there is no column {column:?}")))
    };
    let places = [place(&columns[0])?, place(&columns[1])?];
    let (mut times, mut values) = (Vec::new(), Vec::new());
    for row in reader.records() {
        let row = row.map_err(|e| failed(e.to_string()))?;
        let line = row.position().map_or(0, csv::Position::line);
        let [time, value] = places.map(|place| {
            let cell = row.get(place).unwrap_or_default();
            let number = cell.parse::<f64>().ok().filter(|number| number.is_finite());
            number.ok_or_else(|| failed(format!("line {line}: {cell:?} is no number")))
        });
        times.push(time?);
        values.push(value?);
    }
    let (times, values) = compared(reference, times, values);
    reference.times_s = Some(times);
    reference.values = Some(values);
    Ok(())
}

/// The part of a series that a figure is taken from, and what it is averaged over; all of a series
/// that is compared as such, whose times may be shifted.
fn compared(reference: &ReferenceKeys, times: Vec<f64>, values: Vec<f64>) -> (Vec<f64>, Vec<f64>) {
    if reference.measure == Some(MeasureName::Series) {
        return (times, values);
    }
    let margin = reference.average_s.unwrap_or(0.0);
    let from = reference.from_s.map_or(f64::NEG_INFINITY, |from| from - margin);
    let until = reference.until_s.map_or(f64::INFINITY, |until| until + margin);
    times.into_iter().zip(values).filter(|(time, _)| *time >= from && *time <= until).unzip()
}

/// Everything about the references that cannot be.
pub(super) fn check(check: &mut Checker<'_>, keys: &CaseKeys) {
    if let Some([low, high]) = keys.comparison.time_shift_s {
        check.numbers("comparison.time_shift_s", &[low, high], FINITE);
        check.require(low < high, "comparison.time_shift_s", || {
            format!("[{low}, {high}] must rise")
        });
    }
    for (index, reference) in keys.reference.iter().enumerate() {
        let key = |name: &str| format!("reference[{index}].{name}");
        for (name, value, allowed) in [
            ("period_s", reference.period_s, POSITIVE),
            ("average_s", reference.average_s, POSITIVE),
            ("level", reference.level, FINITE),
            ("from_s", reference.from_s, NOT_NEGATIVE),
            ("until_s", reference.until_s, Allowed::above(reference.from_s.unwrap_or(0.0), 1e12)),
            ("value", reference.value, FINITE),
            ("scale", Some(reference.scale), FINITE),
            ("goal", reference.goal, POSITIVE),
            ("paper_error", reference.paper_error, POSITIVE),
        ] {
            if let Some(value) = value {
                check.number(&key(name), value, allowed);
            }
        }
        check_series(check, keys, reference, &key);
    }
}

fn check_series(
    check: &mut Checker<'_>,
    keys: &CaseKeys,
    reference: &ReferenceKeys,
    key: &dyn Fn(&str) -> String,
) {
    let series = [
        ("table", reference.table.is_some()),
        ("column", reference.column.is_some()),
        ("measure", reference.measure.is_some()),
    ];
    if reference.finding.is_some() {
        for (name, given) in series {
            check.require(!given, &key(name), || "a finding needs none".to_owned());
        }
        return;
    }
    for (name, given) in series {
        check.require(given, &key(name), || "missing: there is no finding either".to_owned());
    }
    let (Some(table), Some(column), Some(measure)) =
        (reference.table, &reference.column, reference.measure)
    else {
        return;
    };
    let known = columns(table);
    check.require(known.contains(&column.as_str()) && column != "time_s", &key("column"), || {
        format!("{}.csv has no column \"{column}\" (it has: {})", table.name(), known.join(", "))
    });
    let names = names(keys, table);
    let of = reference.of.as_deref();
    match of {
        Some(of) => check.require(names.contains(&of), &key("of"), || {
            format!("nothing in {}.csv is called \"{of}\" ({})", table.name(), names.join(", "))
        }),
        None => check.require(names.len() <= 1, &key("of"), || {
            format!("missing: {}.csv is of {}", table.name(), names.join(", "))
        }),
    }
    let written = keys.output.tables.contains(&table);
    check
        .require(written, &key("table"), || format!("{} is not among output.tables", table.name()));
    let (value, times) = (reference.value.is_some(), reference.times_s.as_deref());
    for (name, given, with, only) in [
        ("period_s", reference.period_s.is_some(), "amplitude", MeasureName::Amplitude),
        ("level", reference.level.is_some(), "arrival", MeasureName::Arrival),
    ] {
        check.require(given == (measure == only), &key(name), || {
            format!("goes with measure = \"{with}\", and only with it")
        });
    }
    match measure {
        MeasureName::Series => {
            let rising = times.is_some_and(|t| t.len() > 1 && t.windows(2).all(|w| w[0] < w[1]));
            check.require(rising, &key("file"), || {
                "measure = \"series\" needs a series of at least 2 rising times".to_owned()
            });
        }
        _ => check.require(value != times.is_some(), &key("value"), || {
            "needs either a value or a file with a series".to_owned()
        }),
    }
    let matched = times.map(<[f64]>::len) == reference.values.as_ref().map(Vec::len);
    check.require(matched, &key("values"), || "must be as many as times_s".to_owned());
}

/// What the rows of a table are about.
fn names(keys: &CaseKeys, table: TableName) -> Vec<&str> {
    match table {
        TableName::Motion | TableName::Loads => {
            keys.body.iter().map(|body| body.name.as_str()).collect()
        }
        TableName::Mooring => keys.mooring.iter().map(|line| line.name.as_str()).collect(),
        TableName::Gauges => keys.gauge.iter().map(|gauge| gauge.name.as_str()).collect(),
        TableName::Probes => keys.probe.iter().map(|probe| probe.name.as_str()).collect(),
        TableName::Diagnostics => Vec::new(),
    }
}
