//! The measures.

use super::Found;
use super::results::{Results, ResultsError, Series};
use crate::analysis::comparison::relative_error;
use crate::analysis::harmonics::harmonics;
use crate::case::{Case, MeasureName, ReferenceKeys};
use crate::plot::{Curve, Panel};
use std::f64::consts::TAU;

/// Steps of the search for the time shift, of its range.
const SHIFT_STEPS: usize = 2000;

/// What a run made of each reference of its case, in their order.
pub type Comparison = Vec<(ReferenceKeys, Found)>;

/// Holds `results` against the references of `case`.
///
/// # Errors
/// When the results cannot be read. A figure that the run does not have is no error: what was
/// found says so.
pub fn compare(case: &Case, results: &Results) -> Result<Comparison, ResultsError> {
    let (mut references, mut runs) = (case.keys.reference.clone(), Vec::new());
    for reference in &mut references {
        let mut run = match (reference.table, &reference.column) {
            (Some(table), Some(column)) => {
                results.series(table, reference.of.as_deref(), column)?
            }
            _ => Series::default(),
        };
        if let Some(width) = reference.average_s {
            run = moving_mean(&run, width);
            if let (Some(times), Some(values)) = (reference.times_s.take(), reference.values.take())
            {
                let (times, values) = moving_mean(&(times, values), width);
                (reference.times_s, reference.values) = (Some(times), Some(values));
            }
        }
        runs.push(run);
    }
    let with_series: Vec<(&ReferenceKeys, &Series)> = references
        .iter()
        .zip(&runs)
        .filter(|(reference, _)| reference.measure == Some(MeasureName::Series))
        .collect();
    let shift = case.keys.comparison.time_shift_s.map(|range| best_shift(range, &with_series));
    let found = references.iter().zip(&runs).map(|(reference, run)| {
        let found = match (&reference.finding, reference.measure) {
            (Some(finding), _) => by_finding(reference, results.finding(finding)),
            (None, Some(MeasureName::Series)) => by_series(reference, run, shift),
            (None, measure) => by_figure(reference, run, measure),
        };
        (reference.clone(), found)
    });
    Ok(found.collect())
}

fn nothing(reason: &str) -> Found {
    Found {
        value: None,
        reference: None,
        error: None,
        missing: Some(reason.to_owned()),
        shift: None,
        panel: None,
    }
}

fn relative(value: f64, reference: f64) -> Option<f64> {
    (reference != 0.0).then(|| (value / reference - 1.0).abs())
}

/// A finding against the reference's value, else its own theory; one that has neither is an error
/// by itself.
fn by_finding(reference: &ReferenceKeys, finding: Option<(f64, Option<f64>)>) -> Found {
    let Some((value, theory)) = finding else { return nothing("the run has no such finding") };
    let target = reference.value.map(|value| value * reference.scale).or(theory);
    let error = match target {
        Some(target) => relative(value, target),
        None => Some(value.abs()),
    };
    Found { value: Some(value), reference: target, error, ..nothing("") }.complete()
}

/// The part of a series that is compared.
fn window(reference: &ReferenceKeys, (times, values): &Series) -> Series {
    let (from, until) =
        (reference.from_s.unwrap_or(f64::NEG_INFINITY), reference.until_s.unwrap_or(f64::INFINITY));
    let pairs = times.iter().copied().zip(values.iter().copied());
    pairs.filter(|(time, _)| *time >= from - 1e-9 && *time <= until + 1e-9).unzip()
}

fn by_figure(reference: &ReferenceKeys, run: &Series, measure: Option<MeasureName>) -> Found {
    let (times, values) = window(reference, run);
    let ended = run.0.last().copied().unwrap_or_default();
    if values.len() < 2 || reference.until_s.is_some_and(|until| ended < until - 1e-6) {
        return nothing("the run is too short");
    }
    let figure = |times: &[f64], values: &[f64]| match measure {
        Some(MeasureName::Amplitude) => amplitude(times, values, reference.period_s?),
        Some(MeasureName::Mean) => Some(values.iter().sum::<f64>() / values.len() as f64),
        Some(MeasureName::Arrival) => arrival(times, values, reference.level?),
        _ => values.iter().copied().reduce(f64::max),
    };
    let theirs = series_of(reference).map(|series| window(reference, &series));
    let Some(value) = figure(&times, &values) else { return nothing("the run has no such figure") };
    let target = match (reference.value, &theirs) {
        (Some(value), _) => Some(value * reference.scale),
        (None, Some((times, values))) => figure(times, values),
        (None, None) => None,
    };
    let Some(target) = target else { return nothing("the reference has no such figure") };
    let ours = times.iter().copied().zip(values.iter().copied()).collect();
    let mut curves = vec![Curve::line("seakeep", ours)];
    if let Some((times, values)) = theirs {
        curves.push(Curve::dots("reference", times.into_iter().zip(values).collect()));
    }
    // The figure that it should be, as a level; of an oscillation, about its mean.
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let level = match measure {
        Some(MeasureName::Amplitude) => mean + target,
        Some(MeasureName::Arrival) => reference.level.unwrap_or_default(),
        _ => target,
    };
    if let (Some(start), Some(end)) = (times.first(), times.last()) {
        curves.push(Curve::line("level of the reference", vec![(*start, level), (*end, level)]));
    }
    Found {
        value: Some(value),
        reference: Some(target),
        error: relative(value, target),
        panel: Some(Panel::over_time(&label(reference), curves)),
        ..nothing("")
    }
    .complete()
}

/// The mean over `width` (s) around each sample, by the trapezoidal rule; none where the samples do
/// not fill it, at the ends and where a probe falls dry.
fn moving_mean((times, values): &Series, width: f64) -> Series {
    /// Part of the width that is filled.
    const FILLED: f64 = 0.8;
    let mut integral = vec![0.0; values.len()];
    for i in 1..values.len() {
        let area = 0.5 * (values[i] + values[i - 1]) * (times[i] - times[i - 1]);
        integral[i] = integral[i - 1] + area;
    }
    let mean = |(i, time): (usize, &f64)| {
        let first = times.partition_point(|t| *t < time - 0.5 * width - 1e-9);
        let last = times.partition_point(|t| *t <= time + 0.5 * width + 1e-9) - 1;
        match times[last] - times[first] {
            // Samples further apart than the width stand for themselves.
            0.0 => Some((*time, values[i])),
            span if span < FILLED * width - 1e-9 => None,
            span => Some((*time, (integral[last] - integral[first]) / span)),
        }
    };
    times.iter().enumerate().filter_map(mean).unzip()
}

/// When the values first reach `level`, linearly between the samples.
fn arrival(times: &[f64], values: &[f64], level: f64) -> Option<f64> {
    let first = values.iter().position(|value| *value >= level)?;
    let Some(before) = first.checked_sub(1) else { return times.first().copied() };
    let part = (level - values[before]) / (values[first] - values[before]);
    Some(times[before] + part * (times[first] - times[before]))
}

/// Amplitude of the first harmonic, two more and a trend beside it: a drifting body has one.
fn amplitude(times: &[f64], values: &[f64], period: f64) -> Option<f64> {
    let (start, end) = (*times.first()?, *times.last()?);
    if end - start < 0.999 * period {
        return None;
    }
    // The trend of whole periods: the mean of the last less that of the first, over the time
    // between them.
    let mean = |from: f64, until: f64| {
        let part: Vec<f64> = times
            .iter()
            .zip(values)
            .filter(|(time, _)| **time >= from && **time < until)
            .map(|(_, value)| *value)
            .collect();
        (!part.is_empty()).then(|| part.iter().sum::<f64>() / part.len() as f64)
    };
    let slope = match end - start > 1.999 * period {
        true => {
            let lag = end - start - period;
            (mean(end - period, end)? - mean(start, start + period)?) / lag
        }
        false => 0.0,
    };
    let level: Vec<f64> =
        times.iter().zip(values).map(|(time, value)| value - slope * (time - start)).collect();
    let found = harmonics(times, &level, TAU / period, 3)?;
    found.amplitudes.first().map(|amplitude| amplitude.norm())
}

/// The series of a reference in the unit and sign of the table.
fn series_of(reference: &ReferenceKeys) -> Option<Series> {
    let values = reference.values.as_ref()?;
    let scaled = values.iter().map(|value| value * reference.scale).collect();
    Some((reference.times_s.clone()?, scaled))
}

fn label(reference: &ReferenceKeys) -> String {
    let unit = reference.column.as_deref().unwrap_or_default();
    format!("{} ({unit})", reference.name)
}

fn by_series(reference: &ReferenceKeys, run: &Series, shift: Option<f64>) -> Found {
    let Some(matched) = Matched::new(reference, run, shift.unwrap_or(0.0)) else {
        return nothing("the run is too short");
    };
    let ours = window(reference, run);
    let shown = |time: f64| {
        let (first, last) = (matched.times[0], matched.times[matched.times.len() - 1]);
        time >= first - 1.0 && time <= last + 1.0
    };
    let line = ours.0.into_iter().zip(ours.1).filter(|(time, _)| shown(*time)).collect();
    let dots = matched.times.iter().copied().zip(matched.reference.iter().copied()).collect();
    let curves = vec![Curve::line("seakeep", line), Curve::dots("reference", dots)];
    Found {
        error: relative_error(&matched.found, &matched.reference),
        shift,
        panel: Some(Panel::over_time(&label(reference), curves)),
        ..nothing("")
    }
    .complete()
}

/// A run read at the times of its reference.
struct Matched {
    times: Vec<f64>,
    found: Vec<f64>,
    reference: Vec<f64>,
}

impl Matched {
    /// `None` if the run does not cover the times of the reference, later by `shift` (s), within
    /// the window of the comparison.
    fn new(reference: &ReferenceKeys, run: &Series, shift: f64) -> Option<Self> {
        let (times, values) = series_of(reference)?;
        let (from, until) =
            (reference.from_s.unwrap_or(0.0), reference.until_s.unwrap_or(f64::INFINITY));
        let (times, mut values): (Vec<f64>, Vec<f64>) = times
            .iter()
            .map(|time| time + shift)
            .zip(values)
            .filter(|(time, _)| *time >= from && *time <= until)
            .unzip();
        let found = times.iter().map(|time| interpolate(run, *time)).collect::<Option<Vec<_>>>()?;
        if found.is_empty() {
            return None;
        }
        if reference.free_level {
            let pairs = found.iter().zip(&values);
            let mean = pairs.map(|(a, b)| a - b).sum::<f64>() / found.len() as f64;
            values.iter_mut().for_each(|value| *value += mean);
        }
        Some(Self { times, found, reference: values })
    }
}

/// The value of a series at `time`, linearly between its rows; `None` outside of it.
fn interpolate((times, values): &Series, time: f64) -> Option<f64> {
    let after = times.partition_point(|known| *known < time);
    match after {
        0 => (times.first()? - time < 1e-9).then(|| values[0]),
        _ if after == times.len() => (time - times.last()? < 1e-9).then(|| values[after - 1]),
        _ => {
            let part = (time - times[after - 1]) / (times[after] - times[after - 1]);
            Some(values[after - 1] + part * (values[after] - values[after - 1]))
        }
    }
}

/// The shift within `range` with the least sum of squared errors of Eq. (31); its middle where no
/// shift lets the run cover all references.
fn best_shift([low, high]: [f64; 2], series: &[(&ReferenceKeys, &Series)]) -> f64 {
    let cost = |shift: f64| {
        let errors = series.iter().map(|(reference, run)| {
            let matched = Matched::new(reference, run, shift)?;
            Some(relative_error(&matched.found, &matched.reference)?.powi(2))
        });
        errors.sum::<Option<f64>>()
    };
    let shifts =
        (0..=SHIFT_STEPS).map(|step| low + (high - low) * step as f64 / SHIFT_STEPS as f64);
    let costs = shifts.filter_map(|shift| Some((shift, cost(shift)?)));
    costs.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0.5 * (low + high), |(shift, _)| shift)
}

impl Found {
    /// Nothing is missing.
    fn complete(self) -> Self {
        Self { missing: None, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn moving_mean_of_a_line_is_the_line_and_of_a_spike_its_area() {
        let times: Vec<f64> = (0..=100).map(|i| f64::from(i) * 0.01).collect();
        let line: Vec<f64> = times.iter().map(|t| 3.0 * t + 1.0).collect();
        let (at, mean) = moving_mean(&(times.clone(), line), 0.1);
        // No mean where a fifth of the width is missing, at the ends.
        assert_eq!(at, times[3..98]);
        assert!((2..93).all(|i| (mean[i] - 3.0 * at[i] - 1.0).abs() < 1e-12));
        let spike: Vec<f64> = (0..=100).map(|i| if i == 50 { 7.0 } else { 0.0 }).collect();
        let highest = moving_mean(&(times.clone(), spike.clone()), 0.1).1;
        let highest = highest.into_iter().fold(0.0, f64::max);
        assert!((highest - 0.7).abs() < 1e-12, "{highest}");
        assert_eq!(moving_mean(&(times.clone(), spike.clone()), 1e-3), (times, spike));
    }

    #[test]
    fn arrival_is_between_the_samples_around_it() {
        let times = [1.0, 2.0, 3.0, 4.0];
        let values = [0.0, 1.0, 5.0, 2.0];
        assert_eq!(arrival(&times, &values, 3.0), Some(2.5));
        assert_eq!(arrival(&times, &values, -1.0), Some(1.0));
        assert_eq!(arrival(&times, &values, 6.0), None);
    }
}
