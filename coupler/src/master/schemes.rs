//! One communication step in each scheme.

use super::FixedStepMaster;
use super::acceleration::Accelerator;
use super::capabilities::is_affine;
use super::clock::Clock;
use super::history::{History, Span};
use super::settings::{Implicit, Scheme};
use super::sides::{Outcome, flat, loads, step_load, step_motion};
use crate::CouplerError;
use crate::interface::{
    BoundaryKinematics, ComponentState, LoadComponent, LoadResponse, MotionComponent,
};
use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

/// Residual below which an iteration has converged whatever the accelerations, m/s² and rad/s²:
/// for bodies at rest, whose accelerations are rounding.
const ABSOLUTE_TOLERANCE: f64 = 1e-9;
/// The whole communication step.
const WHOLE: Span = Span { from: 0.0, to: 1.0 };

/// What a scheme remembers from one communication step to the next.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SchemeMemory {
    /// Mean accelerations that the bodies made.
    accelerations: History,
    /// Mean loads, with an interface Jacobian the loads at zero acceleration.
    loads: History,
    accelerator: Accelerator,
}

/// Work of the load on the boundaries as each side of the interface saw it, J/m.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Exchange {
    /// The load that the load component reported on the displacement that it was told.
    pub(super) told_work: f64,
    /// The load that the bodies felt on the displacement that they made.
    pub(super) felt_work: f64,
}

impl FixedStepMaster {
    /// A step without boundaries: there is no work.
    pub(super) fn step_alone(
        &mut self,
        load: &mut dyn LoadComponent,
    ) -> Result<Exchange, CouplerError> {
        let substeps = self.coupling.load_substeps;
        step_load(self.clock, load, substeps, &[], false, |_| Vec::new())?;
        self.residuals.push(0.0);
        Ok(Exchange::default())
    }

    /// A step with bodies.
    pub(super) fn step_coupled(
        &mut self,
        load: &mut dyn LoadComponent,
        motion: &mut dyn MotionComponent,
    ) -> Result<Exchange, CouplerError> {
        let before = motion.kinematics().to_vec();
        self.clock.check(motion, "kinematics", before.len(), load.boundary_count())?;
        match self.coupling.scheme {
            Scheme::InterfaceJacobian => self.step_with_jacobian(load, motion, &before),
            Scheme::Jacobi => self.step_explicitly(load, motion, &before, false),
            Scheme::GaussSeidel => self.step_explicitly(load, motion, &before, true),
            Scheme::Implicit(settings) => self.iterate(load, motion, &before, &settings),
        }
    }

    /// The bodies solve with the response of the load component, and it steps with what they
    /// found. If it takes several steps, the response is that of the first.
    fn step_with_jacobian(
        &mut self,
        load: &mut dyn LoadComponent,
        motion: &mut dyn MotionComponent,
        before: &[BoundaryKinematics],
    ) -> Result<Exchange, CouplerError> {
        let (coupling, clock) = (self.coupling, self.clock);
        let response = solve(clock, load, coupling.load_substeps, before)?;
        let at_zero = flat(&response.at_zero_acceleration);
        // F₀ is known for the middle of the first of the load component's steps, not for that of
        // the communication step.
        let late = 0.5 * (1.0 - 1.0 / f64::from(coupling.load_substeps));
        let known = &self.memory.loads;
        let made = step_motion(clock, motion, coupling.motion_substeps, |span| LoadResponse {
            at_zero_acceleration: loads(&known.interpolate(
                &at_zero,
                coupling.extrapolation,
                span.shifted(late),
            )),
            added_mass: response.added_mass.clone(),
        })?;
        let known = &self.memory.accelerations;
        let told = step_load(clock, load, coupling.load_substeps, before, true, |span| {
            known.interpolate(&made.mean, coupling.extrapolation, span)
        })?;
        self.residuals.push(0.0);
        self.memory.loads.push(&at_zero);
        self.memory.accelerations.push(&made.mean);
        Ok(Exchange { told_work: told.work, felt_work: made.work })
    }

    /// The load component steps with predicted accelerations; the bodies step with the load that
    /// follows (`serial`) or with a predicted load. There is no load to predict the first one
    /// from, so that the first step is serial in any case.
    fn step_explicitly(
        &mut self,
        load: &mut dyn LoadComponent,
        motion: &mut dyn MotionComponent,
        before: &[BoundaryKinematics],
        serial: bool,
    ) -> Result<Exchange, CouplerError> {
        let (coupling, clock) = (self.coupling, self.clock);
        let SchemeMemory { accelerations, loads: past_loads, .. } = &self.memory;
        let predicted = |span: Span| {
            let ahead = accelerations.extrapolate(coupling.extrapolation, span);
            ahead.unwrap_or_else(|| vec![0.0; 3 * before.len()])
        };
        let told = step_load(clock, load, coupling.load_substeps, before, false, predicted)?;
        let made = step_motion(clock, motion, coupling.motion_substeps, |span| {
            let ahead = past_loads.extrapolate(coupling.extrapolation, span);
            let given = ahead.filter(|_| !serial).unwrap_or_else(|| {
                past_loads.interpolate(&told.mean, coupling.extrapolation, span)
            });
            held(&given)
        })?;
        let (residual, size) = compare(&predicted(WHOLE), &made.mean);
        self.residuals.push(relative(residual, size));
        self.memory.loads.push(&told.mean);
        self.memory.accelerations.push(&made.mean);
        Ok(Exchange { told_work: told.work, felt_work: made.work })
    }

    /// Repeats the step until the accelerations that the load component is told are those that
    /// its load makes.
    fn iterate(
        &mut self,
        load: &mut dyn LoadComponent,
        motion: &mut dyn MotionComponent,
        before: &[BoundaryKinematics],
        settings: &Implicit,
    ) -> Result<Exchange, CouplerError> {
        let (coupling, clock) = (self.coupling, self.clock);
        let evaluation = Evaluation::begin(self, load, before)?;
        let motion_state = motion.get_state().map_err(|source| clock.failed(source))?;
        let first = self.memory.accelerations.extrapolate(coupling.extrapolation, WHOLE);
        let mut tried = first.unwrap_or_else(|| vec![0.0; 3 * before.len()]);
        self.memory.accelerator.begin();
        for iteration in 1..=settings.max_iterations {
            let SchemeMemory { accelerations, loads: past_loads, accelerator } = &mut self.memory;
            let told = |span: Span| accelerations.interpolate(&tried, coupling.extrapolation, span);
            let given = evaluation.evaluate(load, iteration > 1, &tried, &told)?;
            if iteration > 1 {
                motion.set_state(&motion_state).map_err(|source| clock.failed(source))?;
            }
            let made = step_motion(clock, motion, coupling.motion_substeps, |span| {
                held(&past_loads.interpolate(&given.mean, coupling.extrapolation, span))
            })?;
            let (residual, size) = compare(&tried, &made.mean);
            self.residuals.push(relative(residual, size));
            if residual <= settings.tolerance * size + ABSOLUTE_TOLERANCE {
                let told = evaluation.complete(load, given, &told)?;
                accelerator.end(settings, &tried, &made.mean);
                past_loads.push(&told.mean);
                accelerations.push(&made.mean);
                return Ok(Exchange { told_work: told.work, felt_work: made.work });
            }
            tried = accelerator.next(settings, &tried, &made.mean);
        }
        Err(CouplerError::NotConverged {
            time: clock.time(),
            step: clock.step + 1,
            iterations: settings.max_iterations,
            residual: self.residuals.last().copied().unwrap_or_default(),
            tolerance: settings.tolerance,
        })
    }
}

/// The load component in an iteration.
struct Evaluation<'a> {
    clock: Clock,
    substeps: u32,
    before: &'a [BoundaryKinematics],
    kind: Kind,
}

enum Kind {
    /// The load is an affine function of the accelerations: the component steps once, at the end.
    Affine(LoadResponse),
    /// The component steps for each evaluation, from this state.
    Repeated(ComponentState),
}

impl<'a> Evaluation<'a> {
    fn begin(
        master: &FixedStepMaster,
        load: &mut dyn LoadComponent,
        before: &'a [BoundaryKinematics],
    ) -> Result<Self, CouplerError> {
        let (clock, substeps) = (master.clock, master.coupling.load_substeps);
        let kind = if is_affine(&master.coupling, load) {
            Kind::Affine(solve(clock, load, substeps, before)?)
        } else {
            Kind::Repeated(load.get_state().map_err(|source| clock.failed(source))?)
        };
        Ok(Self { clock, substeps, before, kind })
    }

    /// Load over the step for the mean accelerations `mean`, which vary as `told`. Without work
    /// if the component has not stepped. `again` if this is not the first evaluation.
    fn evaluate(
        &self,
        load: &mut dyn LoadComponent,
        again: bool,
        mean: &[f64],
        told: &impl Fn(Span) -> Vec<f64>,
    ) -> Result<Outcome, CouplerError> {
        match &self.kind {
            Kind::Affine(response) => {
                let mut loads = response.at_zero_acceleration.clone();
                response.at(mean, &mut loads);
                Ok(Outcome { mean: flat(&loads), work: 0.0 })
            }
            Kind::Repeated(state) => {
                if again {
                    load.set_state(state).map_err(|source| self.clock.failed(source))?;
                }
                step_load(self.clock, load, self.substeps, self.before, false, told)
            }
        }
    }

    /// Ends the step, whose last evaluation was `evaluated` with `told`.
    fn complete(
        self,
        load: &mut dyn LoadComponent,
        evaluated: Outcome,
        told: &impl Fn(Span) -> Vec<f64>,
    ) -> Result<Outcome, CouplerError> {
        match self.kind {
            Kind::Affine(_) => step_load(self.clock, load, self.substeps, self.before, true, told),
            Kind::Repeated(_) => Ok(evaluated),
        }
    }
}

/// The response of the load component over the first of its `substeps` steps.
fn solve(
    clock: Clock,
    load: &mut dyn LoadComponent,
    substeps: u32,
    before: &[BoundaryKinematics],
) -> Result<LoadResponse, CouplerError> {
    load.set_kinematics(before);
    let h = clock.communication_step / f64::from(substeps);
    let response = load.solve_load(clock.time(), h).map_err(|source| clock.failed(source))?;
    let response = response.clone();
    let (loads, matrix) = (&response.at_zero_acceleration, &response.added_mass);
    clock.check(load, "loads", loads.len(), before.len())?;
    clock.check(load, "rows of added mass", matrix.nrows(), 3 * before.len())?;
    clock.check(load, "columns of added mass", matrix.ncols(), 3 * before.len())?;
    Ok(response)
}

/// A load that does not depend on the accelerations.
fn held(flat: &[f64]) -> LoadResponse {
    LoadResponse {
        at_zero_acceleration: loads(flat),
        added_mass: DMatrix::zeros(flat.len(), flat.len()),
    }
}

/// Norm of the difference of two vectors, and the larger of their norms.
fn compare(left: &[f64], right: &[f64]) -> (f64, f64) {
    let norm = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>().sqrt();
    let difference = norm(&mut left.iter().zip(right).map(|(l, r)| l - r));
    let (left, right) = (norm(&mut left.iter().copied()), norm(&mut right.iter().copied()));
    (difference, left.max(right))
}

/// A residual relative to `size`; no residual is none of nothing, too.
fn relative(residual: f64, size: f64) -> f64 {
    if residual == 0.0 { 0.0 } else { residual / size }
}
