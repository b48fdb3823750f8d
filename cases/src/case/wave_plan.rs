//! From the keys of a wave to what is asked for.

use super::wave_keys::{AbsorptionKeys, BoardKind, WaveKeys, WaveKind};
use super::{CaseKeys, WavemakerKeys};
use crate::waves::StillWater;
use crate::waves::focused::Focus;
use crate::waves::paddle::Board;
use crate::waves::plan::{GroupPlan, SpectrumPlan, WaveForm, WavePlan, WaveSource};
use crate::waves::solitary::SolitaryTheory;
use crate::waves::spectrum::SpectrumForm;
use std::path::Path;

/// Ramp, in periods.
const RAMP: f64 = 2.0;
/// Return time of an absorbing paddle, in periods.
const RETURN_PERIODS: f64 = 10.0;
/// Return time where there is no period, in √(D/g).
const RETURN_TIMES: f64 = 50.0;

/// The water of a case.
pub(super) fn still_water(keys: &CaseKeys) -> StillWater {
    StillWater { depth: keys.water.depth_m, gravity: keys.water.gravity_m_s2 }
}

/// Puts the motion of a file in the place of its name. `folder` is that of the case file.
///
/// # Errors
/// What is wrong with the file.
pub(super) fn read_motion(wave: &mut WaveKeys, folder: &Path) -> Result<(), String> {
    let Some(file) = wave.file.take() else { return Ok(()) };
    if wave.times_s.is_some() || wave.positions_m.is_some() || wave.angles_rad.is_some() {
        return Err("the motion is in the case file too: either one".to_owned());
    }
    let path = folder.join(&file);
    let failed = |reason: String| format!("{}: {reason}", path.display());
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .from_path(&path)
        .map_err(|error| failed(error.to_string()))?;
    let header = reader.headers().map_err(|error| failed(error.to_string()))?.clone();
    let columns: Vec<&str> = header.iter().collect();
    let values = match columns[..] {
        ["time_s", "position_m"] => &mut wave.positions_m,
        ["time_s", "angle_rad"] => &mut wave.angles_rad,
        _ => {
            return Err(failed(format!(
                "columns {}: they must be time_s,position_m or time_s,angle_rad",
                columns.join(",")
            )));
        }
    };
    let (times, motion): (Vec<f64>, Vec<f64>) = reader
        .deserialize::<(f64, f64)>()
        .collect::<Result<Vec<_>, _>>()
        .map_err(|error| failed(error.to_string()))?
        .into_iter()
        .unzip();
    wave.times_s = Some(times);
    *values = Some(motion);
    Ok(())
}

/// Fills in the defaults of the keys of waves.
pub(super) fn resolve(keys: &mut CaseKeys) {
    let water = still_water(keys);
    if let Some(wave) = &mut keys.wave {
        let (_, optional) = wave.kind.keys();
        let takes = |key: &str| optional.contains(&key);
        if takes("order") {
            wave.order.get_or_insert(20);
        }
        if takes("components") {
            wave.components.get_or_insert(200);
        }
        if takes("seed") {
            wave.seed.get_or_insert(0);
        }
        if takes("peak_enhancement") {
            wave.peak_enhancement.get_or_insert(3.3);
        }
        if takes("highest_over_peak") {
            wave.highest_over_peak.get_or_insert(3.0);
        }
        if takes("theory") {
            wave.theory.get_or_insert(SolitaryTheory::Exact);
        }
    }
    let period = wave_plan(keys).and_then(|plan| plan.form.reference_period());
    if let Some(maker) = &mut keys.wavemaker {
        if maker.board == BoardKind::Flap {
            maker.hinge_m.get_or_insert(0.0);
        }
        if period.is_some() {
            maker.ramp_periods.get_or_insert(RAMP);
        }
        if let Some(AbsorptionKeys { return_time_s }) = &mut maker.active_absorption {
            let long = RETURN_TIMES * (water.depth / water.gravity).sqrt();
            return_time_s.get_or_insert(period.map_or(long, |period| RETURN_PERIODS * period));
        }
    }
}

/// What the case asks for; `None` where there is no wave, or keys are missing.
pub(super) fn wave_plan(keys: &CaseKeys) -> Option<WavePlan> {
    let form = wave_form(keys.wave.as_ref()?)?;
    let source = match (&keys.wavemaker, &keys.initial_wave) {
        (Some(maker), _) => paddle(maker, form.reference_period()),
        (None, Some(start)) => WaveSource::Start { crest: start.crest_m },
        (None, None) => return None,
    };
    Some(WavePlan { form, source })
}

fn paddle(maker: &WavemakerKeys, period: Option<f64>) -> WaveSource {
    WaveSource::Paddle {
        board: match maker.board {
            BoardKind::Piston => Board::Piston,
            BoardKind::Flap => Board::Flap { hinge: maker.hinge_m.unwrap_or_default() },
        },
        ramp: period.map_or(0.0, |period| maker.ramp_periods.unwrap_or(RAMP) * period),
        absorption: maker.active_absorption.as_ref().and_then(|keys| keys.return_time_s),
    }
}

fn wave_form(wave: &WaveKeys) -> Option<WaveForm> {
    let components = wave.components.unwrap_or_default() as usize;
    let spectrum = |significant_height: f64| {
        let form = match wave.kind {
            WaveKind::PiersonMoskowitz => SpectrumForm::PiersonMoskowitz,
            _ => SpectrumForm::Jonswap { peak_enhancement: wave.peak_enhancement? },
        };
        Some(SpectrumPlan {
            form,
            significant_height,
            peak_period: wave.peak_period_s?,
            highest: wave.highest_over_peak?,
        })
    };
    let focus = || {
        Some(Focus { x: wave.focus_x_m?, time: wave.focus_time_s?, amplitude: wave.amplitude_m? })
    };
    Some(match wave.kind {
        WaveKind::Linear => WaveForm::Linear { height: wave.height_m?, period: wave.period_s? },
        WaveKind::Stokes => WaveForm::Stokes { height: wave.height_m?, period: wave.period_s? },
        WaveKind::StreamFunction => WaveForm::StreamFunction {
            height: wave.height_m?,
            period: wave.period_s?,
            order: wave.order? as usize,
        },
        WaveKind::Jonswap | WaveKind::PiersonMoskowitz => WaveForm::Irregular {
            spectrum: spectrum(wave.significant_height_m?)?,
            components,
            seed: wave.seed?,
        },
        // The height of the spectrum does not matter: the group has its own amplitude.
        WaveKind::NewWave => WaveForm::Focused {
            form: GroupPlan::NewWave(spectrum(1.0)?),
            focus: focus()?,
            components,
        },
        WaveKind::EqualSteepness => WaveForm::Focused {
            form: GroupPlan::EqualSteepness {
                lowest: wave.lowest_frequency_hz?,
                highest: wave.highest_frequency_hz?,
            },
            focus: focus()?,
            components,
        },
        WaveKind::Solitary => WaveForm::Solitary { height: wave.height_m?, theory: wave.theory? },
        WaveKind::Recorded => WaveForm::Recorded {
            times: wave.times_s.clone()?,
            values: wave.positions_m.clone().or_else(|| wave.angles_rad.clone())?,
        },
    })
}
