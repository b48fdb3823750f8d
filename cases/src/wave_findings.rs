//! What a run with a wave shows: how far the gauges are from theory.

use crate::analysis::comparison::relative_error;
use crate::analysis::harmonics::harmonics;
use crate::analysis::reflection;
use crate::analysis::spectrum::welch;
use crate::analysis::zero_crossing::{statistics, waves};
use crate::case::Case;
use crate::output::summary::Finding;
use crate::simulation::Sample;
use crate::waves::plan::{SpectrumPlan, WaveForm, WavePlan, WaveSource};
use crate::waves::{StillWater, WaveTheory};
use std::f64::consts::TAU;

/// Periods at the end of a run over which a regular wave is compared: those of the reference,
/// t/T = 12 to 18 (Ma et al. 2024, section 3).
const COMPARED_PERIODS: f64 = 6.0;

/// Harmonics of a regular wave that are given.
const HARMONICS: usize = 3;

/// Waves lower than this part of theory's are noise.
const NOISE: f64 = 0.05;

/// Bands of a sea whose energies are compared, by their limits over the peak frequency.
const BANDS: [f64; 6] = [0.5, 0.85, 1.15, 1.5, 2.0, 3.0];

/// A spectrum has segments of this many peak periods.
const SEGMENT_PERIODS: f64 = 20.0;

/// What a gauge has recorded, and what it should have by theory.
struct Record<'a> {
    name: &'a str,
    x: f64,
    times: Vec<f64>,
    values: Vec<f64>,
    expected: Vec<f64>,
}

impl Record<'_> {
    fn finding(&self, what: &str, value: f64, unit: &'static str, theory: Option<f64>) -> Finding {
        Finding { name: format!("{}: {what}", self.name), value, unit, theory }
    }
}

/// Adds the error of Eq. (31) at each gauge and what the kind of wave is known by: heights and
/// harmonics, energies by band, or the crest.
pub(crate) fn wave_findings(case: &Case, samples: &[Sample], found: &mut Vec<Finding>) {
    let Some(plan) = &case.scene.wave else { return };
    let water = case.scene.still_water();
    let Ok(Some(theory)) = plan.theory(water) else { return };
    let (Some(start), Some(end)) = (samples.first(), samples.last()) else { return };
    let farthest = case.scene.gauges.iter().map(|gauge| gauge.x).fold(0.0, f64::max);
    // A regular wave and a sea are compared when they are established, others over the whole run.
    let from = match &plan.form {
        WaveForm::Linear { period, .. }
        | WaveForm::Stokes { period, .. }
        | WaveForm::StreamFunction { period, .. } => end.time - COMPARED_PERIODS * period,
        WaveForm::Irregular { spectrum, .. } => {
            start.time + established(plan, spectrum, water, farthest)
        }
        _ => start.time,
    };
    if from < start.time || from >= end.time {
        return;
    }
    let within: Vec<&Sample> = samples.iter().filter(|sample| sample.time >= from - 1e-9).collect();
    let records = case.scene.gauges.iter().enumerate().map(|(index, gauge)| {
        let (times, values): (Vec<f64>, Vec<f64>) =
            within.iter().filter_map(|s| Some((s.time, s.elevations[index]?))).unzip();
        let expected = times.iter().map(|time| theory.elevation(gauge.x, *time)).collect();
        Record { name: &gauge.name, x: gauge.x, times, values, expected }
    });
    let records: Vec<Record> = records.collect();
    for record in &records {
        if let Some(error) = relative_error(&record.values, &record.expected) {
            found.push(record.finding("elevation error, Eq. (31)", error, "", None));
        }
        match &plan.form {
            WaveForm::Linear { height, period }
            | WaveForm::Stokes { height, period }
            | WaveForm::StreamFunction { height, period, .. } => {
                regular(record, *height, *period, found);
            }
            WaveForm::Irregular { spectrum, .. } => sea(record, spectrum.peak_period, found),
            _ => crest(record, found),
        }
    }
    if let WaveForm::Linear { period, .. }
    | WaveForm::Stokes { period, .. }
    | WaveForm::StreamFunction { period, .. } = plan.form
    {
        found.extend(reflected(theory.as_ref(), period, &records));
    }
}

/// When the components of a sea up to twice its peak frequency have come to `x` (m) from the
/// paddle, s after the start.
fn established(plan: &WavePlan, spectrum: &SpectrumPlan, water: StillWater, x: f64) -> f64 {
    match plan.source {
        WaveSource::Start { .. } => 0.0,
        WaveSource::Paddle { ramp, .. } => {
            let number = water.wave_number(2.0 * TAU / spectrum.peak_period);
            ramp + x / water.group_velocity(number)
        }
    }
}

/// Height, level and harmonics of a regular wave. By its phase a wave that comes early is ahead.
fn regular(record: &Record, height: f64, period: f64, found: &mut Vec<Finding>) {
    let crossings = waves(&record.times, &record.values, 0.0, 0.5 * NOISE * height);
    if let Some(statistics) = statistics(&crossings) {
        found.push(record.finding("wave height", statistics.mean_height, "m", Some(height)));
    }
    let of = |values: &[f64]| harmonics(&record.times, values, TAU / period, HARMONICS);
    let (Some(ours), Some(theory)) = (of(&record.values), of(&record.expected)) else { return };
    found.push(record.finding("mean level", ours.mean, "m", None));
    for (order, (a, b)) in (1..).zip(ours.amplitudes.iter().zip(&theory.amplitudes)) {
        let name = format!("harmonic {order}");
        found.push(record.finding(&name, a.norm(), "m", Some(b.norm())));
    }
    let ahead = -(ours.amplitudes[0] / theory.amplitudes[0]).arg();
    found.push(record.finding("phase ahead of theory", ahead, "rad", None));
}

/// Significant height 4 √m₀ of a sea, and its energy m₀ by bands.
fn sea(record: &Record, peak_period: f64, found: &mut Vec<Finding>) {
    let Some(interval) = record.times.get(1).map(|second| second - record.times[0]) else { return };
    // An even number, as the transform has it.
    let segment = 2 * (0.5 * SEGMENT_PERIODS * peak_period / interval).round() as usize;
    let of = |values: &[f64]| welch(interval, values, segment);
    let (Some(ours), Some(theory)) = (of(&record.values), of(&record.expected)) else { return };
    let deviation = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64)
            .sqrt()
    };
    let height = |values: &[f64]| 4.0 * deviation(values);
    let expected = Some(height(&record.expected));
    found.push(record.finding("significant height", height(&record.values), "m", expected));
    for limits in BANDS.windows(2) {
        let band = (limits[0] / peak_period, limits[1] / peak_period);
        let name = format!("energy, {} to {} of the peak frequency", limits[0], limits[1]);
        let expected = Some(theory.moment(0, band));
        found.push(record.finding(&name, ours.moment(0, band), "m²", expected));
    }
}

/// The highest elevation.
fn crest(record: &Record, found: &mut Vec<Finding>) {
    let highest = |values: &[f64]| values.iter().copied().reduce(f64::max);
    if let Some(value) = highest(&record.values) {
        found.push(record.finding("highest elevation", value, "m", highest(&record.expected)));
    }
}

/// The reflection coefficient of a regular wave by all gauges that have a whole record.
fn reflected(theory: &dyn WaveTheory, period: f64, records: &[Record]) -> Option<Finding> {
    let longest = records.iter().map(|record| record.times.len()).max()?;
    let whole = || records.iter().filter(|record| record.times.len() == longest);
    let gauges: Vec<(f64, &[f64])> = whole().map(|r| (r.x, r.values.as_slice())).collect();
    let times = &whole().next()?.times;
    let number = TAU / theory.wavelength()?;
    let found = reflection::regular(times, &gauges, TAU / period, number)?;
    Some(Finding {
        name: "reflection coefficient".to_owned(),
        value: found.coefficient(),
        unit: "",
        theory: None,
    })
}
