//! Checks of waves and of what makes them, and what is worth a warning.

use super::checks::{Allowed, Checker};
use super::source::Source;
use super::wave_keys::{BoardKind, WaveKeys, WaveKind};
use super::{CaseKeys, Problem, wave_plan};
use crate::waves::WaveError;
use crate::waves::plan::{WaveForm, WavePlan, WaveSource};
use seakeep_body::PrescribedMotion;

/// Ursell number H L²/D³ beyond which Stokes' expansion is not what a long wave looks like.
const STOKES_URSELL: f64 = 26.0;
/// H/D beyond which a solitary wave by Boussinesq's theory is 5 % and more off the exact one.
const BOUSSINESQ_HEIGHT: f64 = 0.2;
/// Angle beyond which the linear theory of a flap means little, rad.
const FLAP_ANGLE: f64 = 0.35;

const POSITIVE: Allowed = Allowed::above(0.0, f64::INFINITY);
const FINITE: Allowed = Allowed::from(f64::NEG_INFINITY, f64::INFINITY);

/// Every key of waves by itself, and whether the tables go together.
pub(super) fn check_wave_values(check: &mut Checker<'_>, keys: &CaseKeys) {
    let sources = [keys.wavemaker.is_some(), keys.initial_wave.is_some()];
    let Some(wave) = &keys.wave else {
        for (key, given) in ["wavemaker", "initial_wave"].into_iter().zip(sources) {
            check.require(!given, key, || "there is no [wave] that it could make".to_owned());
        }
        return;
    };
    check.require(sources != [false, false], "wave", || {
        "nothing makes it: there must be a [wavemaker] or an [initial_wave]".to_owned()
    });
    check.require(sources != [true, true], "initial_wave", || {
        "there is a [wavemaker] too: either makes the wave".to_owned()
    });
    check_kind(check, wave);
    for (key, value) in [
        ("height_m", wave.height_m),
        ("period_s", wave.period_s),
        ("significant_height_m", wave.significant_height_m),
        ("peak_period_s", wave.peak_period_s),
        ("amplitude_m", wave.amplitude_m),
        ("focus_time_s", wave.focus_time_s),
        ("lowest_frequency_hz", wave.lowest_frequency_hz),
    ] {
        if let Some(value) = value {
            check.number(&format!("wave.{key}"), value, POSITIVE);
        }
    }
    for (key, value, low, high) in [
        ("order", wave.order.map(f64::from), 5.0, 64.0),
        ("components", wave.components.map(f64::from), 10.0, 1e4),
        ("peak_enhancement", wave.peak_enhancement, 1.0, 10.0),
        ("highest_over_peak", wave.highest_over_peak, 1.2, 10.0),
    ] {
        if let Some(value) = value {
            check.number(&format!("wave.{key}"), value, Allowed::from(low, high));
        }
    }
    if let Some(seed) = wave.seed {
        // What a TOML file can hold.
        check.number("wave.seed", seed as f64, Allowed::from(0.0, i64::MAX as f64));
    }
    if let (Some(low), Some(high)) = (wave.lowest_frequency_hz, wave.highest_frequency_hz) {
        let allowed = Allowed::above(low.max(0.0), f64::INFINITY);
        check.number("wave.highest_frequency_hz", high, allowed);
    }
    if let Some(x) = wave.focus_x_m {
        check.number("wave.focus_x_m", x, Allowed::from(0.0, keys.tank.length_m.max(0.0)));
    }
    if let Some(maker) = &keys.wavemaker {
        let flap = maker.board == BoardKind::Flap;
        check.require(flap || maker.hinge_m.is_none(), "wavemaker.hinge_m", || {
            "a piston has no hinge".to_owned()
        });
        if let Some(hinge) = maker.hinge_m {
            // At the still-water level the board would be infinitely short.
            let allowed = Allowed::from(-1e3, 0.9 * keys.water.depth_m.max(0.0));
            check.number("wavemaker.hinge_m", hinge, allowed);
        }
        let own = matches!(wave.kind, WaveKind::Solitary | WaveKind::Recorded);
        check.require(!own || maker.ramp_periods.is_none(), "wavemaker.ramp_periods", || {
            format!("a {} wave has no period and needs no ramp", wave.kind.name())
        });
        if let Some(ramp) = maker.ramp_periods {
            // Without any ramp the paddle would begin off its rest or with a jump.
            check.number("wavemaker.ramp_periods", ramp, Allowed::from(0.25, 100.0));
        }
        if let Some(absorption) = &maker.active_absorption {
            check.require(wave.kind != WaveKind::Recorded, "wavemaker.active_absorption", || {
                "a recorded motion does not say which elevation it makes".to_owned()
            });
            if let Some(time) = absorption.return_time_s {
                check.number("wavemaker.active_absorption.return_time_s", time, POSITIVE);
            }
        }
    }
    if let Some(start) = &keys.initial_wave {
        check.number("initial_wave.crest_m", start.crest_m, FINITE);
        check.require(wave.kind != WaveKind::Recorded, "wave.kind", || {
            "a recorded motion needs a [wavemaker]".to_owned()
        });
        check.require(keys.water.standing_wave.is_none(), "water.standing_wave", || {
            "there is an [initial_wave] too: the water starts with either".to_owned()
        });
    }
}

/// A kind has the keys it needs and no others.
fn check_kind(check: &mut Checker<'_>, wave: &WaveKeys) {
    let (needed, allowed) = wave.kind.keys();
    let kind = wave.kind.name();
    for (name, given) in wave.given() {
        let key = format!("wave.{name}");
        check.require(given || !needed.contains(&name), &key, || {
            format!("kind = \"{kind}\" needs it")
        });
        let known = needed.contains(&name) || allowed.contains(&name);
        check.require(!given || known, &key, || format!("kind = \"{kind}\" takes no such key"));
    }
    if wave.kind == WaveKind::Recorded && wave.file.is_none() {
        let values = wave.positions_m.as_ref().or(wave.angles_rad.as_ref());
        let both = wave.positions_m.is_some() && wave.angles_rad.is_some();
        let whole = wave.times_s.is_some() && values.is_some() && !both;
        check.require(whole, "wave.file", || {
            "kind = \"recorded\" needs it, or times_s with either positions_m or angles_rad"
                .to_owned()
        });
    }
}

/// Whether the wave can be, whether the paddle can make it, and whether it fits the tank. The keys
/// are complete and in range.
pub(super) fn check_wave_fits(keys: &CaseKeys, source: &Source) -> Vec<Problem> {
    let mut check = Checker::new(source);
    if let Some(plan) = wave_plan::wave_plan(keys) {
        check_plan(&mut check, keys, &plan);
    }
    check.problems
}

fn check_plan(check: &mut Checker<'_>, keys: &CaseKeys, plan: &WavePlan) {
    let water = wave_plan::still_water(keys);
    if let WaveForm::Recorded { values, .. } = &plan.form {
        let flap = keys.wavemaker.as_ref().is_some_and(|maker| maker.board == BoardKind::Flap);
        let angles = keys.wave.as_ref().is_some_and(|wave| wave.angles_rad.is_some());
        check.require(flap == angles, "wave.kind", || {
            format!(
                "a {} needs a record of its {}",
                if flap { "flap" } else { "piston" },
                if flap { "angle_rad" } else { "position_m" }
            )
        });
        let first = values.first().copied().unwrap_or_default();
        check.require(first.abs() < 1e-9, "wave.kind", || {
            format!("the recorded motion starts at {first}: it must start at rest, at 0")
        });
    }
    let maker = match plan.theory(water).and_then(|_| plan.wavemaker(water)) {
        Ok(maker) => maker,
        Err(error) => {
            let key = match error {
                WaveError::Breaking { .. } if plan_has_height(&plan.form) => "wave.height_m",
                _ => "wave",
            };
            check.require(false, key, || error.to_string());
            return;
        }
    };
    if let Some(maker) = maker {
        let (low, high) = maker.motion().range(keys.end_time_s);
        let reach = low.abs().max(high.abs());
        let limit = 0.5 * keys.tank.length_m;
        check.require(reach <= limit, "wavemaker", || {
            format!(
                "the paddle would move by {reach:.4} m: it must be at most half the tank, {limit} m"
            )
        });
    }
}

fn plan_has_height(form: &WaveForm) -> bool {
    matches!(
        form,
        WaveForm::Linear { .. }
            | WaveForm::Stokes { .. }
            | WaveForm::StreamFunction { .. }
            | WaveForm::Solitary { .. }
    )
}

/// What can be run, but is outside the range of its theory or does not do what it seems to. The
/// keys have passed every check.
pub(super) fn warnings(keys: &CaseKeys) -> Vec<String> {
    let Some(plan) = wave_plan::wave_plan(keys) else { return Vec::new() };
    let water = wave_plan::still_water(keys);
    let mut found = Vec::new();
    let mut warn = |holds: bool, message: String| {
        if holds {
            found.push(message);
        }
    };
    let length =
        |period: f64| std::f64::consts::TAU / water.wave_number(std::f64::consts::TAU / period);
    if let Some(period) = plan.form.reference_period() {
        let wavelength = length(period);
        for (index, zone) in keys.damping_zone.iter().enumerate() {
            let extent = (zone.outer_x_m - zone.inner_x_m).abs();
            warn(
                extent < 0.5 * wavelength,
                format!(
                    "damping_zone[{index}]: {extent:.3} m is shorter than half a wavelength, \
                     {:.3} m: it reflects",
                    0.5 * wavelength
                ),
            );
        }
        warn(
            keys.tank.length_m < wavelength,
            format!("tank.length_m: shorter than a wavelength, {wavelength:.3} m"),
        );
    }
    if let Some(period) = plan.form.shortest_period() {
        let shortest = length(period);
        let spacing = keys.numerics.particle_spacing_m;
        warn(
            shortest < 8.0 * spacing,
            format!(
                "wave: its shortest component, {shortest:.4} m long, is not resolved: the particle \
                 spacing should be at most {:.4} m",
                shortest / 8.0
            ),
        );
    }
    match plan.form {
        WaveForm::Linear { height, period } => {
            let k = std::f64::consts::TAU / length(period);
            let tanh = (k * water.depth).tanh();
            let second = 0.125 * height * k * (3.0 - tanh * tanh) / tanh.powi(3);
            warn(
                second > 0.1,
                format!(
                    "wave.height_m: too high for linear theory, the second harmonic is {:.0} % of \
                     the first (limit 10 %)",
                    100.0 * second
                ),
            );
        }
        WaveForm::Stokes { height, period } => {
            let ursell = height * length(period).powi(2) / water.depth.powi(3);
            warn(
                ursell > STOKES_URSELL,
                format!(
                    "wave: too long and high for Stokes theory, the Ursell number is {ursell:.0} \
                     (limit {STOKES_URSELL})"
                ),
            );
        }
        WaveForm::Solitary {
            height,
            theory: crate::waves::solitary::SolitaryTheory::Boussinesq,
        } => {
            let relative = height / water.depth;
            warn(
                relative > BOUSSINESQ_HEIGHT,
                format!(
                    "wave.theory: at H/D = {relative:.2} Boussinesq's solitary wave is more than \
                     5 % off the exact one (limit {BOUSSINESQ_HEIGHT})"
                ),
            );
        }
        _ => {}
    }
    if let Some(again) = plan.form.repeat_period() {
        warn(
            again < keys.end_time_s,
            format!("wave.components: the group comes again after {again:.1} s"),
        );
    }
    if let WaveForm::Recorded { times, .. } = &plan.form {
        let end = times.last().copied().unwrap_or_default();
        warn(
            end < keys.end_time_s,
            format!("wave: the recorded motion ends at {end} s, the paddle stands from then on"),
        );
    }
    if let (WaveSource::Paddle { .. }, Ok(Some(maker))) = (plan.source, plan.wavemaker(water)) {
        let steepest = (0..=1000)
            .filter_map(|n| maker.kinematics(keys.end_time_s * f64::from(n) / 1000.0).ok())
            .fold(0.0, |most: f64, board| most.max(board.angle.abs()));
        warn(
            steepest > FLAP_ANGLE,
            format!(
                "wavemaker: the flap turns by {:.0} degrees, linear theory means little beyond \
                 {:.0}",
                steepest.to_degrees(),
                FLAP_ANGLE.to_degrees()
            ),
        );
    }
    found
}
