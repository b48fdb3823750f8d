//! Range checks: every number of a case on its own.

use super::body_checks::check_bodies;
use super::source::Source;
use super::wave_checks::check_wave_values;
use super::{CaseKeys, Device, Problem, moorings, references};
use seakeep_fluid::setup::SolverKind;
use std::collections::HashSet;
use std::fmt;

/// Time steps that a run may have: beyond this the case is a mistake.
const MAX_STEPS: f64 = 1e9;

/// An allowed range of a finite number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Allowed {
    low: f64,
    low_included: bool,
    high: f64,
}

impl Allowed {
    /// `low < value <= high`
    pub(super) const fn above(low: f64, high: f64) -> Self {
        Self { low, low_included: false, high }
    }

    /// `low <= value <= high`
    pub(super) const fn from(low: f64, high: f64) -> Self {
        Self { low, low_included: true, high }
    }

    pub(super) fn holds(self, value: f64) -> bool {
        let low = if self.low_included { value >= self.low } else { value > self.low };
        low && value <= self.high && value.is_finite()
    }
}

impl fmt::Display for Allowed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (low, high) = (rounded(self.low), rounded(self.high));
        let least = if self.low_included { "at least" } else { "above" };
        match (low.is_finite(), high.is_finite()) {
            (true, true) => write!(f, "{least} {low} and at most {high}"),
            (true, false) => write!(f, "{least} {low}"),
            (false, true) => write!(f, "at most {high}"),
            (false, false) => write!(f, "a finite number"),
        }
    }
}

/// Four significant digits: enough to tell what is allowed.
fn rounded(limit: f64) -> f64 {
    format!("{limit:.3e}").parse().unwrap_or(limit)
}

pub(super) const POSITIVE: Allowed = Allowed::above(0.0, f64::INFINITY);
pub(super) const NOT_NEGATIVE: Allowed = Allowed::from(0.0, f64::INFINITY);
pub(super) const FINITE: Allowed = Allowed::from(f64::NEG_INFINITY, f64::INFINITY);

/// Collects problems.
pub(super) struct Checker<'a> {
    source: &'a Source,
    pub(super) problems: Vec<Problem>,
}

impl<'a> Checker<'a> {
    pub(super) fn new(source: &'a Source) -> Self {
        Self { source, problems: Vec::new() }
    }

    /// Reports `message` for `key` unless `holds`.
    pub(super) fn require(&mut self, holds: bool, key: &str, message: impl FnOnce() -> String) {
        if !holds {
            self.problems.push(self.source.problem(key, message()));
        }
    }

    /// Reports a number outside its range.
    pub(super) fn number(&mut self, key: &str, value: f64, allowed: Allowed) {
        self.require(allowed.holds(value), key, || format!("{value} must be {allowed}"));
    }

    pub(super) fn numbers(&mut self, key: &str, values: &[f64], allowed: Allowed) {
        for (index, value) in values.iter().enumerate() {
            self.number(&format!("{key}[{index}]"), *value, allowed);
        }
    }

    /// Names become table cells and topics.
    pub(super) fn names<'n>(&mut self, list: &str, names: impl Iterator<Item = &'n str>) {
        let mut seen = HashSet::new();
        for (index, name) in names.enumerate() {
            let key = format!("{list}[{index}].name");
            let plain = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
            self.require(!name.is_empty() && name.chars().all(plain), &key, || {
                format!("\"{name}\" must consist of letters, digits, _ and -")
            });
            self.require(seen.insert(name), &key, || {
                format!("\"{name}\" is the name of another {list} too")
            });
        }
    }
}

/// All numbers outside their ranges, and names that cannot be used.
pub(super) fn check_values(keys: &CaseKeys, source: &Source) -> Vec<Problem> {
    let mut check = Checker::new(source);
    let (tank, water, numerics) = (&keys.tank, &keys.water, &keys.numerics);
    // One problem is reported once: a wrong tank is no reason to complain of what stands in it.
    let within_tank = |size: f64| Allowed::from(0.0, if size > 0.0 { size } else { f64::INFINITY });
    check.number("tank.length_m", tank.length_m, Allowed::above(0.0, 1e4));
    check.number("tank.height_m", tank.height_m, Allowed::above(0.0, 1e4));
    check.number("water.depth_m", water.depth_m, Allowed::above(0.0, 1e4));
    check.number("water.density_kg_m3", water.density_kg_m3, POSITIVE);
    check.number("water.kinematic_viscosity_m2_s", water.kinematic_viscosity_m2_s, NOT_NEGATIVE);
    check.number("water.gravity_m_s2", water.gravity_m_s2, POSITIVE);
    if let Some(width) = water.width_m {
        check.number("water.width_m", width, within_tank(tank.length_m));
        check.require(water.standing_wave.is_none(), "water.width_m", || {
            "a column of water with a free face cannot have a standing wave too".to_owned()
        });
    }
    if let Some(wave) = &water.standing_wave {
        let allowed = Allowed::above(0.0, 0.5 * water.depth_m.max(0.0));
        check.number("water.standing_wave.amplitude_m", wave.amplitude_m, allowed);
        let allowed = Allowed::from(1.0, 1000.0);
        check.number("water.standing_wave.half_waves", f64::from(wave.half_waves), allowed);
    }
    let spacing = numerics.particle_spacing_m;
    check.number("numerics.particle_spacing_m", spacing, POSITIVE);
    if let Some(step) = numerics.time_step_s {
        // The stiffest surface mode has ω² = π g / dx; explicit stepping needs ω dt < 2.
        let stiffest = (std::f64::consts::PI * water.gravity_m_s2 / spacing).sqrt();
        let limit = if stiffest > 0.0 { 2.0 / stiffest } else { f64::INFINITY };
        check.number("numerics.time_step_s", step, Allowed::above(0.0, limit));
    }
    check.number("numerics.density_blend", numerics.density_blend, Allowed::from(0.0, 1.0));
    check.number("numerics.displacement", numerics.displacement, Allowed::from(0.0, 0.25));
    let allowed = Allowed::from(1e-14, 0.1);
    check.number("pressure.tolerance", keys.pressure.tolerance, allowed);
    let divergence = keys.pressure.divergence_tolerance;
    check.number("pressure.divergence_tolerance", divergence, Allowed::from(0.0, 0.01));
    let guard = keys.pressure.guard_tolerance;
    check.number("pressure.guard_tolerance", guard, Allowed::above(0.0, 1.0));
    let (device, solver) = (keys.pressure.device, keys.pressure.solver);
    let by_network = matches!(solver, SolverKind::Network | SolverKind::Guarded);
    check.require(device == Device::Own || by_network, "pressure.device", || {
        "a device evaluates a network: pressure.solver must be \"network\" or \"guarded\""
            .to_owned()
    });
    check.require(device == Device::Own || cfg!(feature = "torch"), "pressure.device", || {
        "this program was built without the feature torch: there is \"own\"".to_owned()
    });
    check.number("pressure.sweeps", f64::from(keys.pressure.sweeps), Allowed::from(0.0, 100.0));
    let iterations = f64::from(keys.pressure.max_iterations);
    check.number("pressure.max_iterations", iterations, Allowed::from(1.0, 1e6));
    keys.coupling.check(&mut check);
    let step = numerics.time_step_s.unwrap_or(super::resolve::default_time_step(spacing));
    let allowed = if step > 0.0 { Allowed::above(0.0, MAX_STEPS * step) } else { POSITIVE };
    check.number("end_time_s", keys.end_time_s, allowed);
    check.number("output.series_interval_s", keys.output.series_interval_s, NOT_NEGATIVE);
    check.number("output.frame_interval_s", keys.output.frame_interval_s, NOT_NEGATIVE);
    check_wave_values(&mut check, keys);
    check_bodies(&mut check, keys);
    moorings::check_values(&mut check, keys);
    check.names("gauge", keys.gauge.iter().map(|gauge| gauge.name.as_str()));
    check.names("probe", keys.probe.iter().map(|probe| probe.name.as_str()));
    for (index, gauge) in keys.gauge.iter().enumerate() {
        let key = format!("gauge[{index}].x_m");
        check.number(&key, gauge.x_m, within_tank(tank.length_m));
    }
    for (index, probe) in keys.probe.iter().enumerate() {
        let (across, up) = match &probe.body {
            None => (within_tank(tank.length_m), within_tank(tank.height_m)),
            Some(_) => (FINITE, FINITE),
        };
        check.number(&format!("probe[{index}].x_m"), probe.x_m, across);
        check.number(&format!("probe[{index}].y_m"), probe.y_m, up);
        if let Some(name) = &probe.body {
            let known = keys.body.iter().any(|body| body.name == *name);
            check.require(known, &format!("probe[{index}].body"), || {
                format!("there is no body \"{name}\"")
            });
        }
    }
    references::check(&mut check, keys);
    for (index, zone) in keys.damping_zone.iter().enumerate() {
        let key = |name: &str| format!("damping_zone[{index}].{name}");
        let allowed = within_tank(tank.length_m);
        check.number(&key("inner_x_m"), zone.inner_x_m, allowed);
        check.number(&key("outer_x_m"), zone.outer_x_m, allowed);
        check.number(&key("rate_per_s"), zone.rate_per_s, POSITIVE);
        check.require(zone.inner_x_m != zone.outer_x_m, &key("outer_x_m"), || {
            format!("{} must differ from inner_x_m", zone.outer_x_m)
        });
    }
    check.problems
}
