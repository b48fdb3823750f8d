//! The coupling schemes on a rigid body in a model fluid, against the exact solution.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

use nalgebra::{Matrix3, Point2, Vector3};
use seakeep_body::{BodyProperties, RapierEngine, RigidBodies};
use seakeep_coupler::interface::{Component, MotionComponent};
use seakeep_coupler::{
    Acceleration, CouplerError, Coupling, Extrapolation, FixedStepMaster, Implicit, SavedState,
    Scheme, StepReport,
};
use seakeep_tests::model_fluid::{Coefficients, ModelFluid};

/// The paper's box in heave: 42 kg/m on 3924 N/m².
const MASS: f64 = 42.0;
const INERTIA: f64 = 0.5;
const STIFFNESS: f64 = 3924.0;

fn mass() -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vector3::new(MASS, MASS, INERTIA))
}

/// How the body is let go.
#[derive(Clone, Copy)]
struct Start {
    pose: Vector3<f64>,
    velocity: Vector3<f64>,
}

/// Size of the motion in each direction, m, m and rad.
fn amplitudes() -> Vector3<f64> {
    Vector3::new(0.02, 0.05, 0.2)
}

fn released() -> Start {
    Start { pose: amplitudes(), velocity: Vector3::zeros() }
}

/// At rest no longer, but without acceleration yet.
fn pushed() -> Start {
    Start { pose: Vector3::zeros(), velocity: amplitudes() * 7.0 }
}

/// A fluid whose added mass in heave is `ratio` times the mass, and less in sway and roll.
fn fluid(ratio: f64) -> Coefficients {
    let coupled = 0.2 * (MASS * INERTIA).sqrt();
    let shape = Matrix3::new(
        0.3 * MASS,
        0.0,
        0.5 * coupled, //
        0.0,
        MASS,
        0.0, //
        0.5 * coupled,
        0.0,
        0.5 * INERTIA,
    );
    let stiffness = Matrix3::from_diagonal(&Vector3::new(0.3 * STIFFNESS, STIFFNESS, 30.0));
    Coefficients {
        added_mass: shape * ratio,
        damping: stiffness * 0.01,
        stiffness,
        memory: stiffness * 0.2,
        memory_time: 0.3,
    }
}

struct Run {
    fluid: ModelFluid,
    bodies: RigidBodies,
    master: FixedStepMaster,
    start: Start,
}

impl Run {
    fn start(coefficients: Coefficients, derivative: bool, coupling: Coupling, h: f64) -> Self {
        Self::start_from(released(), coefficients, derivative, coupling, h)
    }

    fn start_from(
        start: Start,
        coefficients: Coefficients,
        derivative: bool,
        coupling: Coupling,
        h: f64,
    ) -> Self {
        let body = BodyProperties {
            angle: start.pose.z,
            velocity: start.velocity.xy(),
            angular_velocity: start.velocity.z,
            ..BodyProperties::new("box", MASS, INERTIA, Point2::from(start.pose.xy()))
        };
        let mut bodies = RigidBodies::new(vec![body], 0.0, Box::new(RapierEngine::new())).unwrap();
        let mut fluid = ModelFluid::new(coefficients, derivative);
        let master =
            FixedStepMaster::start_with(coupling, 0.0, h, &mut fluid, Some(&mut bodies)).unwrap();
        Self { fluid, bodies, master, start }
    }

    fn step(&mut self) -> Result<StepReport, CouplerError> {
        self.master.step(&mut self.fluid, Some(&mut self.bodies))
    }

    fn pose(&self) -> Vector3<f64> {
        let body = &self.bodies.kinematics()[0];
        Vector3::new(body.position.x, body.position.y, body.angle)
    }

    /// Scaled so that the three directions count alike.
    fn error(&self, coefficients: &Coefficients) -> f64 {
        let Start { pose, velocity } = self.start;
        let exact = coefficients.exact(&mass(), &pose, &velocity, self.master.time());
        (self.pose() - exact).component_div(&amplitudes()).amax()
    }
}

fn explicit(scheme: Scheme, extrapolation: Extrapolation) -> Coupling {
    Coupling { scheme, extrapolation, ..Coupling::default() }
}

fn implicit(acceleration: Acceleration, relaxation: f64) -> Coupling {
    let implicit = Implicit { acceleration, relaxation, ..Implicit::default() };
    Coupling { scheme: Scheme::Implicit(implicit), ..Coupling::default() }
}

const IQN_ILS: Acceleration = Acceleration::IqnIls { reused_steps: 2 };

/// Largest error over the run, or `None` if it diverged; mean and largest number of evaluations.
fn measure(ratio: f64, derivative: bool, coupling: Coupling) -> (Option<f64>, f64, u32) {
    let coefficients = fluid(ratio);
    let mut run = Run::start(coefficients.clone(), derivative, coupling, 0.005);
    let (mut error, mut sum, mut most) = (0.0_f64, 0, 0);
    for step in 1..=400 {
        let Ok(report) = run.step() else { return (None, 0.0, 0) };
        error = error.max(run.error(&coefficients));
        if error.is_nan() || error >= 10.0 {
            return (None, 0.0, 0);
        }
        // The first steps have no past to start from.
        if step > 3 {
            sum += report.load_evaluations;
            most = most.max(report.load_evaluations);
        }
    }
    (Some(error), f64::from(sum) / 397.0, most)
}

/// The table of masters by added mass over mass: who is stable, and at what cost.
#[test]
fn schemes_by_added_mass() {
    use Extrapolation::{Hold, Linear};
    let ratios = [0.3, 0.8, 1.2, 2.0];
    let rows = [
        ("Gauss-Seidel, hold", explicit(Scheme::GaussSeidel, Hold)),
        ("Gauss-Seidel, linear", explicit(Scheme::GaussSeidel, Linear)),
        ("Jacobi, hold", explicit(Scheme::Jacobi, Hold)),
        ("constant relaxation 0.4", implicit(Acceleration::Constant, 0.4)),
        ("Aitken", implicit(Acceleration::Aitken, 0.4)),
        ("IQN-ILS, 2 steps reused", implicit(IQN_ILS, 0.4)),
        ("interface Jacobian", Coupling::default()),
    ];
    let mut table = Vec::new();
    for (name, coupling) in rows {
        let cells = ratios.map(|ratio| measure(ratio, true, coupling));
        let text = cells.map(|(error, mean, most)| match error {
            Some(error) => format!("{mean:.1}/{most}, {error:.1e}"),
            None => "diverged".to_owned(),
        });
        println!("{name:<25} {}", text.map(|cell| format!("{cell:>18}")).concat());
        table.push(cells);
    }
    let stable = |row: usize| table[row].map(|(error, ..)| error.is_some());
    // Explicit: |−μ| < 1 held, |z² + 2 μ z − μ| has roots within the unit circle for μ < 1/3.
    assert_eq!(stable(0), [true, true, false, false]);
    assert_eq!(stable(1), [true, false, false, false]);
    assert_eq!(stable(2), [true, true, false, false]);
    let [_, _, _, constant, aitken, iqn_ils, jacobian] = table.try_into().unwrap();
    for (column, (error, mean, most)) in jacobian.into_iter().enumerate() {
        let exact = error.unwrap();
        assert_eq!((mean, most), (1.0, 1), "{}", ratios[column]);
        for (row, mean_bound, most_bound) in
            [(constant, 20.0, 25), (aitken, 10.0, 12), (iqn_ils, 3.0, 5)]
        {
            let (error, mean, most) = row[column];
            assert!((error.unwrap() - exact).abs() < 5e-3 * exact, "{error:?}, {exact}");
            assert!(mean < mean_bound && most < most_bound, "{mean}/{most}");
        }
    }
}

/// Observed order of the largest error from the last two of three steps, and the error of the
/// first.
///
/// The body starts without acceleration: an explicit scheme has no past to predict the first one
/// from, and a sudden one costs it a velocity of the order of the step. The added mass is less than
/// 1/49 of the mass, so that all are stable (Jacobi with parabolas: |√μ (3 z² − 3 z + 1)| < 1).
fn order(coupling: Coupling) -> (f64, f64) {
    let coefficients = Coefficients { damping: Matrix3::zeros(), ..fluid(0.01) };
    let errors = [100, 200, 400].map(|steps| {
        let h = 1.0 / f64::from(steps);
        let mut run = Run::start_from(pushed(), coefficients.clone(), true, coupling, h);
        (0..steps)
            .map(|_| {
                run.step().unwrap();
                run.error(&coefficients)
            })
            .fold(0.0, f64::max)
    });
    ((errors[1] / errors[2]).log2(), errors[0])
}

/// Every scheme converges to the exact solution in its order, whatever the rates of the sides.
#[test]
fn order_of_accuracy_under_subcycling() {
    use Extrapolation::{Hold, Linear, Quadratic};
    let rates = [(1, 1), (4, 1), (1, 4), (3, 2)];
    let schemes = [
        ("interface Jacobian", Scheme::InterfaceJacobian),
        ("Jacobi", Scheme::Jacobi),
        ("Gauss-Seidel", Scheme::GaussSeidel),
        ("implicit", Scheme::Implicit(Implicit { tolerance: 1e-9, ..Implicit::default() })),
    ];
    for (name, scheme) in schemes {
        for extrapolation in [Hold, Linear, Quadratic] {
            for (load_substeps, motion_substeps) in rates {
                let (order, error) =
                    order(Coupling { scheme, load_substeps, motion_substeps, extrapolation });
                println!(
                    "{name:<19} {extrapolation:<9?} {load_substeps}:{motion_substeps} \
                     order {order:.2}, error {error:.1e}"
                );
                // A prediction that is held is late by a step, or by a part of it.
                let late = match scheme {
                    Scheme::Jacobi | Scheme::GaussSeidel => true,
                    Scheme::InterfaceJacobian => load_substeps > 1,
                    Scheme::Implicit(_) => false,
                };
                let least = if late && extrapolation == Hold { 0.9 } else { 1.85 };
                assert!(order > least, "{name} {extrapolation:?}: order {order}");
            }
        }
    }
}

/// Every scheme, with what it remembers in play.
fn all() -> Vec<Coupling> {
    let schemes = [
        Scheme::InterfaceJacobian,
        Scheme::Jacobi,
        Scheme::GaussSeidel,
        Scheme::Implicit(Implicit { acceleration: Acceleration::Constant, ..Implicit::default() }),
        Scheme::Implicit(Implicit { acceleration: Acceleration::Aitken, ..Implicit::default() }),
        Scheme::Implicit(Implicit::default()),
    ];
    let rates = [(1, 1), (3, 2)];
    let with = |scheme| {
        rates.map(|(load_substeps, motion_substeps)| Coupling {
            scheme,
            load_substeps,
            motion_substeps,
            extrapolation: Extrapolation::Quadratic,
        })
    };
    schemes.into_iter().flat_map(with).collect()
}

/// The reports of `count` steps and the state they end in, to the bit.
fn record(run: &mut Run, count: usize) -> (Vec<String>, SavedState) {
    let reports = (0..count).map(|_| format!("{:?}", run.step().unwrap())).collect();
    (reports, run.master.save(&run.fluid, Some(&run.bodies)).unwrap())
}

#[test]
fn save_and_restore_repeat_every_scheme_to_the_bit() {
    for coupling in all() {
        let begin = || Run::start(fluid(0.1), true, coupling, 0.01);
        let mut run = begin();
        let (_, saved) = record(&mut run, 7);
        let first = record(&mut run, 9);
        run.master.restore(&mut run.fluid, Some(&mut run.bodies), &saved).unwrap();
        assert!(record(&mut run, 9) == first, "{coupling:?}");
        // Through bytes, into new components.
        let bytes = ComponentBytes::of(&saved);
        let mut other = begin();
        other.master.restore(&mut other.fluid, Some(&mut other.bodies), &bytes.back()).unwrap();
        assert!(record(&mut other, 9) == first, "{coupling:?}");
    }
}

/// A saved state as a file would hold it.
struct ComponentBytes(seakeep_coupler::interface::ComponentState);

impl ComponentBytes {
    fn of(saved: &SavedState) -> Self {
        Self(seakeep_coupler::interface::ComponentState::save("all", saved).unwrap())
    }

    fn back(&self) -> SavedState {
        self.0.load("all").unwrap()
    }
}

#[test]
fn a_state_of_another_scheme_is_refused() {
    let start = |coupling| Run::start(fluid(0.1), true, coupling, 0.01);
    let mut run = start(Coupling::default());
    let (_, saved) = record(&mut run, 3);
    let mut other = start(explicit(Scheme::Jacobi, Extrapolation::Hold));
    let refused = other.master.restore(&mut other.fluid, Some(&mut other.bodies), &saved);
    assert!(matches!(refused, Err(CouplerError::SavedState { .. })), "{refused:?}");
}

/// A fluid that cannot tell its added mass is repeated from its saved state instead; the
/// iteration is the same to the bit. Explicit schemes do not ask for it either.
#[test]
fn a_fluid_without_derivative_moves_the_body_alike() {
    for coupling in all().into_iter().filter(|c| c.scheme != Scheme::InterfaceJacobian) {
        let runs = [true, false].map(|derivative| {
            let mut run = Run::start(fluid(0.1), derivative, coupling, 0.01);
            let reports = record(&mut run, 20).0;
            (reports, run.bodies.get_state().unwrap())
        });
        assert!(runs[0] == runs[1], "{coupling:?}");
    }
}

/// What the interface makes is what the whole system gains: a load that is late by a step feeds
/// an oscillator that should keep its energy.
#[test]
fn power_bond_residual_is_the_energy_that_the_coupling_makes() {
    let mut coefficients = fluid(0.0);
    coefficients.damping = Matrix3::zeros();
    coefficients.memory = Matrix3::zeros();
    let energy = |run: &Run| {
        let body = &run.bodies.kinematics()[0];
        let velocity = Vector3::new(body.velocity.x, body.velocity.y, body.angular_velocity);
        let elastic = run.pose().dot(&(coefficients.stiffness * run.pose()));
        0.5 * (velocity.dot(&(mass() * velocity)) + elastic)
    };
    let gain = |scheme: Scheme, h: f64| {
        let coupling = explicit(scheme, Extrapolation::Hold);
        let mut run = Run::start(coefficients.clone(), true, coupling, h);
        let before = energy(&run);
        let steps = (1.0 / h).round() as usize;
        let made: f64 = (0..steps).map(|_| run.step().unwrap().power_bond_residual).sum();
        (made / before, energy(&run) / before - 1.0)
    };
    for h in [2e-3, 1e-3] {
        let (made, gained) = gain(Scheme::Jacobi, h);
        println!("step {h} s: coupling made {made:.4}, system gained {gained:.4}");
        assert!(gained > 0.05 * h / 1e-3);
        assert!((made / gained - 1.0).abs() < 10.0 * h, "{made}, {gained}");
    }
    let (made, gained) = gain(Scheme::InterfaceJacobian, 1e-3);
    // What is left of it is the angle, which rapier2d turns by an arc tangent.
    assert!(made.abs() < 1e-7 && gained.abs() < 1e-3, "{made}, {gained}");
}

/// An iteration that cannot converge says so, with its residuals in the log.
#[test]
fn no_convergence_is_an_error() {
    let mut coupling = implicit(Acceleration::Constant, 1.0);
    coupling.scheme = match coupling.scheme {
        Scheme::Implicit(settings) => Scheme::Implicit(Implicit { max_iterations: 6, ..settings }),
        other => other,
    };
    let mut run = Run::start(fluid(2.0), true, coupling, 0.01);
    let error = run.step().unwrap_err();
    assert!(matches!(error, CouplerError::NotConverged { step: 1, iterations: 6, .. }), "{error}");
    let residuals = run.master.residuals();
    assert_eq!(residuals.len(), 6);
    assert!(residuals[5] > 0.5, "{residuals:?}");
}
