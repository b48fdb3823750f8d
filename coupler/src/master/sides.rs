//! The two sides of a coupling over one communication step, each in its own number of steps.

use super::clock::Clock;
use super::history::Span;
use crate::CouplerError;
use crate::interface::{BoundaryKinematics, Load, LoadComponent, LoadResponse, MotionComponent};
use nalgebra::Vector2;

/// What a side has made of a communication step.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Outcome {
    /// Mean over the step, three values (x, y, angle) a boundary: the load (N/m, N m/m) of the
    /// load side, the acceleration (m/s², rad/s²) of the motion side.
    pub(super) mean: Vec<f64>,
    /// Work of the load on the boundaries, as this side saw both, J/m.
    pub(super) work: f64,
}

/// Takes the load component over the step in `substeps` steps, from the boundaries' kinematics
/// `before`, which move with the accelerations that `accelerations` gives for each stretch. With
/// `solved`, the first step has been begun with `solve_load` already.
pub(super) fn step_load(
    clock: Clock,
    load: &mut dyn LoadComponent,
    substeps: u32,
    before: &[BoundaryKinematics],
    solved: bool,
    accelerations: impl Fn(Span) -> Vec<f64>,
) -> Result<Outcome, CouplerError> {
    let h = clock.communication_step / f64::from(substeps);
    let mut kinematics = before.to_vec();
    let mut outcome = Outcome { mean: vec![0.0; 3 * before.len()], work: 0.0 };
    for number in 0..substeps {
        let span = Span::of(number, substeps);
        let told = accelerations(span);
        if number > 0 || !solved {
            load.set_kinematics(&kinematics);
        }
        load.set_accelerations(&told);
        load.do_step(clock.at(span.from), h).map_err(|source| clock.failed(source))?;
        clock.check(load, "loads", load.loads().len(), before.len())?;
        for (body, (boundary, reported)) in kinematics.iter_mut().zip(load.loads()).enumerate() {
            let acceleration = &told[3 * body..3 * body + 3];
            let next = advanced(boundary, acceleration, h);
            let mean = &mut outcome.mean[3 * body..3 * body + 3];
            outcome.work += account(mean, values(reported), substeps, boundary, &next, reported);
            *boundary = next;
        }
    }
    Ok(outcome)
}

/// Takes the motion component over the step in `substeps` steps, under the load that `response`
/// gives for each stretch.
pub(super) fn step_motion(
    clock: Clock,
    motion: &mut dyn MotionComponent,
    substeps: u32,
    response: impl Fn(Span) -> LoadResponse,
) -> Result<Outcome, CouplerError> {
    let h = clock.communication_step / f64::from(substeps);
    let boundaries = motion.body_count();
    let mut felt = vec![Load::zero(); boundaries];
    let mut outcome = Outcome { mean: vec![0.0; 3 * boundaries], work: 0.0 };
    let mut before = motion.kinematics().to_vec();
    for number in 0..substeps {
        let span = Span::of(number, substeps);
        let response = response(span);
        motion.set_load(&response);
        motion.do_step(clock.at(span.from), h).map_err(|source| clock.failed(source))?;
        let accelerations = motion.mean_accelerations();
        clock.check(motion, "accelerations", accelerations.len(), 3 * boundaries)?;
        clock.check(motion, "kinematics", motion.kinematics().len(), boundaries)?;
        response.at(accelerations, &mut felt);
        for (body, (before, after)) in before.iter_mut().zip(motion.kinematics()).enumerate() {
            let part = 3 * body..3 * body + 3;
            let acceleration = [0, 1, 2].map(|degree| accelerations[part.start + degree]);
            let mean = &mut outcome.mean[part];
            outcome.work += account(mean, acceleration, substeps, before, after, &felt[body]);
            *before = *after;
        }
    }
    Ok(outcome)
}

/// Adds the value of one of `substeps` steps to a mean. Returns the work of `load` on the
/// displacement, J/m.
fn account(
    mean: &mut [f64],
    value: [f64; 3],
    substeps: u32,
    before: &BoundaryKinematics,
    after: &BoundaryKinematics,
    load: &Load,
) -> f64 {
    for (mean, value) in mean.iter_mut().zip(value) {
        *mean += value / f64::from(substeps);
    }
    let moved = after.position - before.position;
    load.force.dot(&moved) + load.torque * (after.angle - before.angle)
}

/// The boundary `duration` (s) later at a constant acceleration: r + V h + a h²/2, V + a h.
fn advanced(
    boundary: &BoundaryKinematics,
    acceleration: &[f64],
    duration: f64,
) -> BoundaryKinematics {
    let (linear, angular) = (Vector2::new(acceleration[0], acceleration[1]), acceleration[2]);
    let mean_velocity = boundary.velocity + linear * (0.5 * duration);
    let mean_rate = boundary.angular_velocity + angular * (0.5 * duration);
    BoundaryKinematics {
        position: boundary.position + mean_velocity * duration,
        angle: boundary.angle + mean_rate * duration,
        velocity: boundary.velocity + linear * duration,
        angular_velocity: boundary.angular_velocity + angular * duration,
        acceleration: linear,
        angular_acceleration: angular,
    }
}

fn values(load: &Load) -> [f64; 3] {
    [load.force.x, load.force.y, load.torque]
}

/// Loads as three values a boundary.
pub(super) fn flat(loads: &[Load]) -> Vec<f64> {
    loads.iter().flat_map(values).collect()
}

/// Loads of three values a boundary.
pub(super) fn loads(flat: &[f64]) -> Vec<Load> {
    let load = |v: &[f64]| Load { force: Vector2::new(v[0], v[1]), torque: v[2] };
    flat.chunks_exact(3).map(load).collect()
}
