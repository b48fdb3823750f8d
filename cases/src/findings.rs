//! What a run shows: the figures that its kind of case is run for.

use crate::analysis::{decay, hydrostatics, wave};
use crate::case::Case;
use crate::geometry;
use crate::initial_water::InitialWater;
use crate::output::summary::Finding;
use crate::scene::{Body, Scene};
use crate::simulation::{Sample, displacement};
use crate::wave_findings::wave_findings;
use nalgebra::DMatrix;
use seakeep_coupler::interface::BoundaryKinematics;

/// The three directions of motion, with the unit of a displacement.
const DIRECTIONS: [(&str, &str); 3] = [("sway", "m"), ("heave", "m"), ("roll", "rad")];

/// Everything that the series of a run show.
///
/// `added_mass` is the matrix of the first step.
#[must_use]
pub(crate) fn findings(
    case: &Case,
    samples: &[Sample],
    added_mass: Option<&DMatrix<f64>>,
) -> Vec<Finding> {
    let scene = &case.scene;
    let mut found = Vec::new();
    if let InitialWater::StandingWave { half_waves, .. } = scene.initial_water {
        standing_wave(scene, samples, half_waves, &mut found);
        energy(samples, &mut found);
    }
    wave_findings(case, samples, &mut found);
    if scene.is_still() {
        still_water(scene, samples, &mut found);
    }
    for (index, body) in scene.bodies.iter().enumerate() {
        if body.is_held() && scene.is_still() {
            buoyancy(scene, samples, index, &mut found);
        }
        if body.is_free() {
            body_motion(body, samples, index, &mut found);
            if let Some(matrix) = added_mass {
                body_added_mass(body, matrix, index, &mut found);
            }
        }
    }
    let volume = largest(samples.iter().map(|sample| sample.diagnostics.volume_error.abs()));
    found.extend(volume.map(|value| plain("volume error, largest", value, "")));
    found
}

/// Change of the water's mechanical energy over the run, relative to the start. `None` for a
/// start without energy and with bodies, which exchange energy with the water.
#[must_use]
pub(crate) fn energy_error(scene: &Scene, samples: &[Sample]) -> Option<f64> {
    let (first, last) = (samples.first()?, samples.last()?);
    let start = mechanical_energy(first);
    (scene.bodies.is_empty() && start > 0.0 && !scene.is_still())
        .then(|| mechanical_energy(last) / start - 1.0)
}

fn mechanical_energy(sample: &Sample) -> f64 {
    sample.diagnostics.kinetic_energy_j_per_m + sample.diagnostics.potential_energy_j_per_m
}

fn plain(name: &str, value: f64, unit: &'static str) -> Finding {
    Finding { name: name.to_owned(), value, unit, theory: None }
}

fn largest(values: impl Iterator<Item = f64>) -> Option<f64> {
    values.reduce(f64::max)
}

fn standing_wave(scene: &Scene, samples: &[Sample], half_waves: u32, found: &mut Vec<Finding>) {
    let water = &scene.fluid.water;
    let number = wave::standing_wave_number(half_waves, scene.fluid.tank.length);
    let theory = wave::linear_period(number, water.depth, water.gravity);
    for (index, gauge) in scene.gauges.iter().enumerate() {
        // A gauge near a node sees little but the second harmonic.
        if (number * gauge.x).cos().abs() < 0.5 {
            continue;
        }
        let (times, elevation) = series(samples, |sample| sample.elevations[index]);
        let Some(wave) = wave::standing_wave(&times, &elevation) else { continue };
        let name = |what: &str| format!("{}: {what}", gauge.name);
        let period = Finding { theory: Some(theory), ..plain(&name("period"), wave.period, "s") };
        found.push(period);
        found.push(plain(&name("first amplitude"), wave.first_amplitude, "m"));
        found.push(plain(&name("amplitude loss"), wave.amplitude_loss(), ""));
        found.push(plain(&name("periods"), wave.periods, ""));
    }
}

fn energy(samples: &[Sample], found: &mut Vec<Finding>) {
    let Some(start) = samples.first().map(mechanical_energy).filter(|start| *start > 0.0) else {
        return;
    };
    let relative = |sample: &Sample| mechanical_energy(sample) / start - 1.0;
    if let (Some(last), Some(peak)) = (samples.last(), largest(samples.iter().map(relative))) {
        found.push(plain("energy change", relative(last), ""));
        found.push(plain("energy above start, largest", peak, ""));
    }
}

fn still_water(scene: &Scene, samples: &[Sample], found: &mut Vec<Finding>) {
    let water = &scene.fluid.water;
    let (speed, pressure) =
        ((water.gravity * water.depth).sqrt(), water.density * water.gravity * water.depth);
    let fastest = largest(samples.iter().map(|sample| sample.max_speed / speed));
    found.extend(fastest.map(|value| plain("speed / sqrt(g D), largest", value, "")));
    let errors = samples.iter().map(|sample| sample.max_hydrostatic_pressure_error / pressure);
    let worst = largest(errors);
    found.extend(worst.map(|value| plain("pressure error / (rho g D), largest", value, "")));
}

/// Mean load over the second half of the run against the exact one.
fn buoyancy(scene: &Scene, samples: &[Sample], index: usize, found: &mut Vec<Finding>) {
    let (boundary, water) = (&scene.fluid.boundaries[index], &scene.fluid.water);
    let corners = geometry::placed(&boundary.corners, boundary.position, boundary.angle);
    let exact = hydrostatics::buoyancy(
        &corners,
        water.depth,
        water.density,
        water.gravity,
        boundary.position,
    );
    let half = &samples[samples.len() / 2..];
    let loads: Vec<_> = half.iter().filter_map(|sample| sample.loads.get(index)).collect();
    if loads.is_empty() {
        return;
    }
    let mean = |pick: fn(&seakeep_coupler::interface::Load) -> f64| {
        loads.iter().map(|load| pick(load)).sum::<f64>() / loads.len() as f64
    };
    let name = |what: &str| format!("{}: {what}", boundary.name);
    found.push(Finding {
        theory: Some(exact.force),
        ..plain(&name("buoyancy"), mean(|load| load.force.y), "N/m")
    });
    found.push(Finding {
        theory: Some(exact.moment),
        ..plain(&name("righting moment"), mean(|load| load.torque), "N m/m")
    });
}

/// The decay in every direction in which the body starts off its equilibrium, and where it is
/// on average in the others.
fn body_motion(body: &Body, samples: &[Sample], index: usize, found: &mut Vec<Finding>) {
    let moved = |kinematics: &BoundaryKinematics| displacement(kinematics, body.equilibrium);
    for (direction, (label, unit)) in DIRECTIONS.into_iter().enumerate() {
        if !body.free[direction] {
            continue;
        }
        let (times, values) =
            series(samples, |sample| sample.motion.get(index).map(|k| moved(k)[direction]));
        let name = |what: &str| format!("{}: {label} {what}", body.name);
        let starts_off = values.first().is_some_and(|value| value.abs() > 1e-12);
        if let Some(decay) = starts_off.then(|| decay::decay(&times, &values)).flatten() {
            found.push(plain(&name("damped period"), decay.damped_period, "s"));
            found.push(plain(&name("natural period"), decay.natural_period(), "s"));
            found.push(plain(&name("damping ratio"), decay.damping_ratio, ""));
            found.push(plain(&name("level"), decay.level, unit));
        } else if !values.is_empty() {
            let tail = &values[values.len() * 3 / 4..];
            let mean = tail.iter().sum::<f64>() / tail.len() as f64;
            found.push(plain(&name("mean of last quarter"), mean, unit));
        }
    }
}

/// Diagonal and sway-roll term of a body's own added mass at the start.
fn body_added_mass(body: &Body, matrix: &DMatrix<f64>, index: usize, found: &mut Vec<Finding>) {
    let entries = [
        ("sway", 0, 0, "kg/m"),
        ("heave", 1, 1, "kg/m"),
        ("roll", 2, 2, "kg m2/m"),
        ("sway-roll", 0, 2, "kg"),
    ];
    for (label, row, column, unit) in entries {
        if let Some(value) = matrix.get((3 * index + row, 3 * index + column)) {
            found.push(plain(&format!("{}: added mass, {label}", body.name), *value, unit));
        }
    }
}

/// Times and values of the samples that have one.
fn series(samples: &[Sample], value: impl Fn(&Sample) -> Option<f64>) -> (Vec<f64>, Vec<f64>) {
    samples.iter().filter_map(|sample| value(sample).map(|value| (sample.time, value))).unzip()
}
