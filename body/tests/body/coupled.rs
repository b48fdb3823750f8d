//! The added-mass master with rapier2d bodies and an analytic load F = −K x − A a: the exact
//! solution is that of (M + A) x'' = −K x.

use crate::common::{LinearLoad, largest, order_of, weightless};
use nalgebra::{Cholesky, DMatrix, DVector, Point2, SymmetricEigen};
use seakeep_body::{BodyProperties, FreeDegrees, RapierEngine, RigidBodies};
use seakeep_coupler::FixedStepMaster;
use seakeep_coupler::interface::{Component, MotionComponent};
use std::f64::consts::TAU;

const MASS: f64 = 42.0;
const STIFFNESS: f64 = 3924.0;
const AMPLITUDE: f64 = 0.05;
/// Added mass over mass: two eigenvalues of the paper's box in its tank, and one far beyond.
const RATIOS: [f64; 3] = [0.24, 1.86, 10.0];

fn heaving_body() -> RigidBodies {
    let mut body = BodyProperties::new("box", MASS, MASS, Point2::new(0.0, AMPLITUDE));
    body.equilibrium = Point2::origin();
    weightless(vec![body])
}

/// Time and heave after each step, and the largest relative change of the energy.
fn run(ratio: f64, steps_a_period: usize, steps: usize) -> (Vec<(f64, f64)>, f64) {
    let total_mass = MASS * (1.0 + ratio);
    let h = TAU * (total_mass / STIFFNESS).sqrt() / steps_a_period as f64;
    let mut load = LinearLoad::isotropic(STIFFNESS, MASS * ratio);
    let mut bodies = heaving_body();
    let mut master =
        FixedStepMaster::start(0.0, h, &mut load, Some(&mut bodies)).expect("they fit");
    let energy = |y: f64, v: f64| 0.5 * total_mass * v * v + 0.5 * STIFFNESS * y * y;
    let mut change = 0.0_f64;
    let heave = (0..steps)
        .map(|_| {
            let report = master.step(&mut load, Some(&mut bodies)).expect("a good step");
            let body = bodies.kinematics()[0];
            let now = energy(body.position.y, body.velocity.y);
            change = change.max((now / energy(AMPLITUDE, 0.0) - 1.0).abs());
            let scale = report.interface_work.abs() + 1e-12;
            assert!(report.power_bond_residual.abs() < 1e-9 * scale, "{report:?}");
            (report.time, body.position.y)
        })
        .collect();
    (heave, change)
}

/// Angular frequency from the first to the last downward crossing of zero.
fn frequency(heave: &[(f64, f64)]) -> f64 {
    let crossings: Vec<f64> = heave
        .windows(2)
        .filter(|pair| pair[0].1 > 0.0 && pair[1].1 <= 0.0)
        .map(|pair| {
            let ((t0, y0), (t1, y1)) = (pair[0], pair[1]);
            t0 + (t1 - t0) * y0 / (y0 - y1)
        })
        .collect();
    TAU * (crossings.len() - 1) as f64 / (crossings[crossings.len() - 1] - crossings[0])
}

#[test]
fn any_added_mass_is_stable_for_ten_thousand_steps() {
    for ratio in RATIOS {
        let (heave, change) = run(ratio, 100, 10_000);
        let highest = largest(heave.iter().map(|(_, y)| *y)) / AMPLITUDE;
        println!("A/M = {ratio}: energy within {change:.2e}, highest {highest:.6}");
        // The scheme's own energy differs from the exact one by (ω h)²/4 = 1e-3.
        assert!(change < 1.1e-3, "A/M = {ratio}: energy changes by {change}");
        assert!(highest < 1.001, "A/M = {ratio}: {highest}");
    }
}

#[test]
fn frequency_is_that_of_body_and_added_mass() {
    for ratio in RATIOS {
        let exact = (STIFFNESS / (MASS * (1.0 + ratio))).sqrt();
        let errors =
            [50, 100, 200].map(|steps| frequency(&run(ratio, steps, 50 * steps).0) / exact - 1.0);
        let order = order_of(&errors.map(f64::abs));
        println!("A/M = {ratio}: relative errors {errors:?}, order {order:.4}");
        assert!(order > 1.9);
    }
}

/// Largest heave of an exchange that takes the added-mass load from the last acceleration.
fn highest_lagged(ratio: f64, steps: usize) -> f64 {
    let added_mass = MASS * ratio;
    let h = TAU * ((MASS + added_mass) / STIFFNESS).sqrt() / 100.0;
    let (mut y, mut v, mut a) = (AMPLITUDE, 0.0, 0.0);
    let mut highest = 0.0_f64;
    for _ in 0..steps {
        y += 0.5 * h * v;
        a = (-STIFFNESS * y - added_mass * a) / MASS;
        v += h * a;
        y += 0.5 * h * v;
        highest = if y.is_finite() { highest.max(y.abs()) } else { f64::INFINITY };
    }
    highest
}

/// Why the master needs the derivative: the exchange without it is lost beyond A/M = 1.
#[test]
fn a_lagged_exchange_diverges() {
    assert!(highest_lagged(0.24, 300) < 2.0 * AMPLITUDE);
    assert!(highest_lagged(1.86, 100) > 1e6);
    assert!(highest_lagged(10.0, 100) > 1e6);
}

/// Two bodies with full 6 × 6 stiffness and added mass, against the modal solution.
#[test]
fn two_coupled_bodies_converge_with_second_order() {
    let masses = DVector::from_row_slice(&[42.0, 42.0, 1.5, 20.0, 20.0, 0.8]);
    let scale = DMatrix::from_diagonal(&masses.map(f64::sqrt));
    // Any symmetric positive definite matrices will do: 1 on the diagonal, decaying off it.
    let full = |shift: f64| {
        DMatrix::from_fn(6, 6, |i, j| {
            let distance = i.abs_diff(j) as f64;
            (-0.9 * distance).exp() * (shift * distance).cos()
        })
    };
    let added_mass = &scale * full(0.7) * 1.86 * &scale;
    let stiffness = &scale * full(1.9) * 90.0 * &scale;
    let start = DVector::from_row_slice(&[0.03, -0.05, 0.1, 0.02, 0.04, -0.2]);

    let total = DMatrix::from_diagonal(&masses) + &added_mass;
    let lower = Cholesky::new(total).expect("positive definite").l();
    let inverse = lower.clone().try_inverse().expect("invertible");
    let modes = SymmetricEigen::new(&inverse * &stiffness * inverse.transpose());
    let exact = |t: f64| {
        let amplitudes = modes.eigenvectors.transpose() * lower.transpose() * &start;
        let now = amplitudes.zip_map(&modes.eigenvalues, |a, square| a * (square.sqrt() * t).cos());
        inverse.transpose() * &modes.eigenvectors * now
    };

    let errors = [200, 400, 800].map(|steps| {
        let bodies = (0..2).map(|number| {
            let row = 3 * number;
            let position = Point2::new(start[row], start[row + 1]);
            let mut body =
                BodyProperties::new(format!("box{number}"), masses[row], masses[row + 2], position);
            body.angle = start[row + 2];
            body
        });
        let mut bodies = weightless(bodies.collect());
        let mut load = LinearLoad::new(stiffness.clone(), added_mass.clone(), vec![0.0; 6]);
        let h = 2.0 / f64::from(steps);
        let mut master =
            FixedStepMaster::start(0.0, h, &mut load, Some(&mut bodies)).expect("they fit");
        largest((0..steps).map(|_| {
            let time = master.step(&mut load, Some(&mut bodies)).expect("a good step").time;
            let pose = bodies
                .kinematics()
                .iter()
                .flat_map(|body| [body.position.x, body.position.y, body.angle]);
            (DVector::from_iterator(6, pose) - exact(time)).norm()
        }))
    });
    let order = order_of(&errors);
    println!("observed order {order:.4}, errors {errors:?}");
    assert!(order > 1.9);
}

/// A boundary that is held is a body without free degrees of freedom; it feels the load, F₀.
#[test]
fn held_boundary_feels_the_load_and_stays() {
    let mut body = BodyProperties::new("box", MASS, MASS, Point2::new(0.0, AMPLITUDE));
    body.free = FreeDegrees::NONE;
    let mut bodies = weightless(vec![body]);
    let mut load = LinearLoad::isotropic(STIFFNESS, 1.86 * MASS);
    let mut master =
        FixedStepMaster::start(0.0, 0.01, &mut load, Some(&mut bodies)).expect("they fit");
    for _ in 0..100 {
        let report = master.step(&mut load, Some(&mut bodies)).expect("a good step");
        assert_eq!((report.interface_work, report.power_bond_residual), (0.0, 0.0));
    }
    assert_eq!(bodies.kinematics()[0].position.y, AMPLITUDE);
    let heave_force = bodies.description().variable("box.force_y").expect("it exists").reference;
    assert_eq!(bodies.get_float64(heave_force).expect("known"), -STIFFNESS * AMPLITUDE);
}

/// A load that is not what was promised shows as energy made by the coupling.
#[test]
fn power_bond_residual_shows_a_wrong_derivative() {
    let mut load = LinearLoad::isotropic(STIFFNESS, MASS);
    load.dishonesty = 2.0;
    let mut bodies = heaving_body();
    let mut master =
        FixedStepMaster::start(0.0, 0.01, &mut load, Some(&mut bodies)).expect("they fit");
    for _ in 0..20 {
        let before = bodies.kinematics()[0].position.y;
        let report = master.step(&mut load, Some(&mut bodies)).expect("a good step");
        let moved = bodies.kinematics()[0].position.y - before;
        // The bodies do not get what the load component says that it gives.
        assert!((report.power_bond_residual + 2.0 * moved).abs() < 1e-12);
    }
}

/// Not a check: what a step costs, in µs. Run with `--ignored --nocapture`.
#[test]
#[ignore = "a timing"]
fn cost_of_a_step() {
    let steps = 200_000;
    let body = BodyProperties::new("box", MASS, MASS, Point2::new(0.0, AMPLITUDE));
    let mut bodies =
        RigidBodies::new(vec![body], 9.81, Box::new(RapierEngine::new())).expect("valid body");
    let mut load = LinearLoad::isotropic(STIFFNESS, MASS);
    let mut master =
        FixedStepMaster::start(0.0, 1e-3, &mut load, Some(&mut bodies)).expect("they fit");
    let clock = std::time::Instant::now();
    for _ in 0..steps {
        master.step(&mut load, Some(&mut bodies)).expect("a good step");
    }
    println!("coupled step: {:.2} µs", clock.elapsed().as_secs_f64() / f64::from(steps) * 1e6);
    let mut time = master.time();
    let clock = std::time::Instant::now();
    for _ in 0..steps {
        bodies.do_step(time, 1e-3).expect("a good step");
        time += 1e-3;
    }
    println!("bodies alone: {:.2} µs", clock.elapsed().as_secs_f64() / f64::from(steps) * 1e6);
    let state = bodies.get_state().expect("saved");
    let clock = std::time::Instant::now();
    for _ in 0..10_000 {
        bodies.set_state(&bodies.get_state().expect("saved")).expect("restored");
    }
    let cost = clock.elapsed().as_secs_f64() / 1e4 * 1e6;
    println!("save and restore: {cost:.2} µs, {} bytes", state.bytes.len());
}
