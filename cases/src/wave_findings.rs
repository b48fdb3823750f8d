//! What a run with a wave shows: how far the gauges are from theory.

use crate::analysis::comparison::relative_error;
use crate::analysis::reflection;
use crate::analysis::zero_crossing::{statistics, waves};
use crate::case::Case;
use crate::output::summary::Finding;
use crate::simulation::Sample;
use crate::waves::WaveTheory;
use crate::waves::plan::WaveForm;
use std::f64::consts::TAU;

/// Periods at the end of a run over which a regular wave is compared: those of the reference,
/// t/T = 12 to 18 (Ma et al. 2024, section 3).
const COMPARED_PERIODS: f64 = 6.0;

/// Waves lower than this part of theory's are noise.
const NOISE: f64 = 0.05;

/// Adds the error of Eq. (31) and the height at each gauge, and the reflection between them.
pub(crate) fn wave_findings(case: &Case, samples: &[Sample], found: &mut Vec<Finding>) {
    let Some(plan) = &case.scene.wave else { return };
    let Ok(Some(theory)) = plan.theory(case.scene.still_water()) else { return };
    let (Some(start), Some(end)) = (samples.first(), samples.last()) else { return };
    let regular = match plan.form {
        WaveForm::Linear { height, period }
        | WaveForm::Stokes { height, period }
        | WaveForm::StreamFunction { height, period, .. } => Some((height, period)),
        _ => None,
    };
    // A regular wave is compared when it is established, any other over the whole run.
    let from = regular.map_or(start.time, |(_, period)| end.time - COMPARED_PERIODS * period);
    if from < start.time {
        return;
    }
    let within: Vec<&Sample> = samples.iter().filter(|sample| sample.time >= from - 1e-9).collect();
    let mut records = Vec::new();
    for (index, gauge) in case.scene.gauges.iter().enumerate() {
        let (times, values): (Vec<f64>, Vec<f64>) =
            within.iter().filter_map(|s| Some((s.time, s.elevations[index]?))).unzip();
        let expected: Vec<f64> =
            times.iter().map(|time| theory.elevation(gauge.x, *time)).collect();
        let named = |what: &str, value: f64, unit, theory| Finding {
            name: format!("{}: {what}", gauge.name),
            value,
            unit,
            theory,
        };
        if let Some(error) = relative_error(&values, &expected) {
            found.push(named("elevation error, Eq. (31)", error, "", None));
        }
        if let Some((height, _)) = regular {
            let record = waves(&times, &values, 0.0, 0.5 * NOISE * height);
            if let Some(statistics) = statistics(&record) {
                found.push(named("wave height", statistics.mean_height, "m", Some(height)));
            }
        } else if let Some(highest) = values.iter().copied().reduce(f64::max) {
            let theory = expected.iter().copied().reduce(f64::max);
            found.push(named("highest elevation", highest, "m", theory));
        }
        records.push((gauge.x, times, values));
    }
    if let Some((_, period)) = regular {
        found.extend(reflected(theory.as_ref(), period, &records));
    }
}

/// The reflection coefficient of a regular wave by all gauges that have a whole record.
fn reflected(
    theory: &dyn WaveTheory,
    period: f64,
    records: &[(f64, Vec<f64>, Vec<f64>)],
) -> Option<Finding> {
    let longest = records.iter().map(|(_, times, _)| times.len()).max()?;
    let whole = || records.iter().filter(|(_, times, _)| times.len() == longest);
    let gauges: Vec<(f64, &[f64])> = whole().map(|(x, _, v)| (*x, v.as_slice())).collect();
    let (_, times, _) = whole().next()?;
    let number = TAU / theory.wavelength()?;
    let found = reflection::regular(times, &gauges, TAU / period, number)?;
    Some(Finding {
        name: "reflection coefficient".to_owned(),
        value: found.coefficient(),
        unit: "",
        theory: None,
    })
}
