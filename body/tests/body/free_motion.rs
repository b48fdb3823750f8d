//! The rigid bodies alone, on springs and without, against analytic solutions.

use crate::common::{largest, order_of, weightless};
use nalgebra::{Point2, Vector2};
use seakeep_body::{
    BodyProperties, FreeDegrees, LinearSpring, NewtonEulerEngine, RapierEngine, RigidBodies,
    RigidBodyEngine,
};
use seakeep_coupler::interface::{BoundaryKinematics, Component, Load, MotionComponent};
use std::f64::consts::TAU;

/// The paper's box: 42 kg/m on its hydrostatic stiffness of 3924 N/m² has a period of 0.65 s.
const MASS: f64 = 42.0;
const STIFFNESS: f64 = 3924.0;
const GRAVITY: f64 = 9.81;
const AMPLITUDE: f64 = 0.05;

fn period() -> f64 {
    TAU * (MASS / STIFFNESS).sqrt()
}

/// A body in heave on a spring at rest at y = 1 + weight/stiffness, so that it swings about 1.
fn heaving(engine: Box<dyn RigidBodyEngine>) -> RigidBodies {
    let mut body = BodyProperties::new("box", MASS, 1.0, Point2::new(2.0, 1.0 + AMPLITUDE));
    body.equilibrium.y = 1.0;
    let rest = Point2::new(2.0, 1.0 + MASS * GRAVITY / STIFFNESS);
    let mut bodies = RigidBodies::new(vec![body], GRAVITY, engine).expect("valid body");
    let spring = LinearSpring::diagonal(0.0, STIFFNESS, 0.0, rest);
    bodies.add_own_load(0, Box::new(spring)).expect("the body exists");
    start(bodies)
}

fn start(mut bodies: RigidBodies) -> RigidBodies {
    bodies.enter_initialization_mode(0.0).expect("finite start");
    bodies.exit_initialization_mode().expect("initialized");
    bodies
}

/// Steps and returns the time and the kinematics of the first body after each step.
fn record(bodies: &mut RigidBodies, h: f64, steps: usize) -> Vec<(f64, BoundaryKinematics)> {
    (0..steps)
        .map(|step| {
            bodies.do_step(step as f64 * h, h).expect("a good step");
            ((step + 1) as f64 * h, bodies.kinematics()[0])
        })
        .collect()
}

/// Half the distance from the lowest to the highest point, each refined by a parabola.
fn amplitude(values: &[f64]) -> f64 {
    let extremum = |sign: f64| {
        (1..values.len() - 1)
            .filter(|i| {
                sign * values[*i] >= sign * values[i - 1]
                    && sign * values[*i] >= sign * values[i + 1]
            })
            .map(|i| {
                let (left, middle, right) = (values[i - 1], values[i], values[i + 1]);
                let slope = 0.5 * (right - left);
                sign * (middle - 0.5 * slope * slope / (left - 2.0 * middle + right))
            })
            .fold(f64::NEG_INFINITY, f64::max)
    };
    0.5 * (extremum(1.0) + extremum(-1.0))
}

#[test]
fn amplitude_on_a_spring_is_kept() {
    let (cycles, steps) = (200, 100);
    let mut bodies = heaving(Box::new(RapierEngine::new()));
    let heave: Vec<f64> = record(&mut bodies, period() / steps as f64, cycles * steps)
        .iter()
        .map(|(_, body)| body.position.y - 1.0)
        .collect();
    let (first, last) = (&heave[..2 * steps], &heave[(cycles - 2) * steps..]);
    let change = (amplitude(last) / amplitude(first) - 1.0) / (cycles - 2) as f64;
    println!("amplitude change a cycle: {change:.2e}");
    assert!(change.abs() < 1e-6, "amplitude changes by {change:e} a cycle");
    assert!((amplitude(first) / AMPLITUDE - 1.0).abs() < 1e-3, "{}", amplitude(first));
}

/// Largest errors of the heave over three periods at 50, 100, 200 and 400 steps a period.
fn heave_errors(engine: impl Fn() -> Box<dyn RigidBodyEngine>) -> [f64; 4] {
    let omega = TAU / period();
    [50, 100, 200, 400].map(|steps| {
        let mut bodies = heaving(engine());
        let run = record(&mut bodies, period() / f64::from(steps), 3 * steps as usize);
        largest(run.iter().map(|(t, body)| body.position.y - 1.0 - AMPLITUDE * (omega * t).cos()))
    })
}

#[test]
fn heave_converges_with_second_order() {
    let errors = heave_errors(|| Box::new(RapierEngine::new()));
    println!("observed order {:.4}, errors {errors:?}", order_of(&errors));
    assert!(order_of(&errors) > 1.9);
}

#[test]
fn heave_converges_with_fourth_order_by_newton_and_euler() {
    let errors = heave_errors(|| Box::new(NewtonEulerEngine::new()));
    println!("observed order {:.4}, errors {errors:?}", order_of(&errors));
    assert!(order_of(&errors) > 3.9);
}

#[test]
fn roll_converges_with_second_order() {
    let (inertia, stiffness, angle) = (1.5_f64, 60.0_f64, 0.4);
    let omega = (stiffness / inertia).sqrt();
    let errors = [50, 100, 200, 400].map(|steps| {
        let mut body = BodyProperties::new("box", MASS, inertia, Point2::new(0.0, 0.0));
        body.angle = angle;
        let mut bodies = weightless(vec![body]);
        let spring = LinearSpring::diagonal(0.0, 0.0, stiffness, Point2::origin());
        bodies.add_own_load(0, Box::new(spring)).expect("the body exists");
        let run = record(&mut start(bodies), TAU / omega / f64::from(steps), 3 * steps as usize);
        largest(run.iter().map(|(t, body)| body.angle - angle * (omega * t).cos()))
    });
    let order = order_of(&errors);
    println!("observed order {order:.4}, errors {errors:?}");
    assert!(order > 1.9);
}

/// Largest errors of a damped heave over three periods at 50, 100, 200 and 400 steps a period.
fn damped_errors(engine: impl Fn() -> Box<dyn RigidBodyEngine>) -> [f64; 4] {
    let (omega, damping) = (TAU / period(), 0.1 * TAU / period());
    let damped = (omega * omega - damping * damping).sqrt();
    [50, 100, 200, 400].map(|steps| {
        let mut body = BodyProperties::new("box", MASS, 1.0, Point2::new(0.0, AMPLITUDE));
        body.velocity.y = -damping * AMPLITUDE;
        let mut bodies = RigidBodies::new(vec![body], 0.0, engine()).expect("valid body");
        let load = move |_: f64, body: &BoundaryKinematics| Load {
            force: -MASS * (omega * omega * body.position.coords + 2.0 * damping * body.velocity),
            torque: 0.0,
        };
        bodies.add_own_load(0, Box::new(load)).expect("the body exists");
        let run = record(&mut start(bodies), period() / f64::from(steps), 3 * steps as usize);
        let exact = |t: f64| AMPLITUDE * (-damping * t).exp() * (damped * t).cos();
        largest(run.iter().map(|(t, body)| body.position.y - exact(*t)))
    })
}

/// A load that depends on the velocity is second order too, through its second evaluation.
#[test]
fn damped_heave_converges_with_second_order() {
    let errors = damped_errors(|| Box::new(RapierEngine::new()));
    println!("observed order {:.4}, errors {errors:?}", order_of(&errors));
    assert!(order_of(&errors) > 1.9);
}

#[test]
fn damped_heave_converges_with_fourth_order_by_newton_and_euler() {
    let errors = damped_errors(|| Box::new(NewtonEulerEngine::new()));
    println!("observed order {:.4}, errors {errors:?}", order_of(&errors));
    assert!(order_of(&errors) > 3.9);
}

/// Without load a body flies straight and spins evenly, through more turns than rapier counts.
#[test]
fn free_spinning_flight() {
    let (velocity, rate) = (Vector2::new(1.3, -0.4), 7.0_f64);
    let errors = [500, 1000, 2000].map(|steps| {
        let mut body = BodyProperties::new("box", MASS, 1.5, Point2::new(0.5, 2.0));
        body.velocity = velocity;
        body.angular_velocity = rate;
        let mut bodies = start(weightless(vec![body]));
        let h = 5.0 / f64::from(steps);
        let run = record(&mut bodies, h, steps as usize);
        for (t, body) in &run {
            let straight = Point2::new(0.5, 2.0) + velocity * *t;
            assert!((body.position - straight).norm() < 1e-11);
            assert_eq!((body.velocity, body.angular_velocity), (velocity, rate));
            assert_eq!(body.acceleration, Vector2::zeros());
        }
        largest(run.iter().map(|(t, body)| body.angle - rate * t))
    });
    let order = order_of(&errors);
    println!("observed order {order:.4}, errors {errors:?}");
    assert!(order > 1.9);
    assert!(errors[2] < 2e-3, "35 rad at 57 steps a radian: {errors:?}");
}

/// Free fall under a constant weight has no error but rounding: position is exact in t².
#[test]
fn free_fall_is_exact() {
    let body = BodyProperties::new("box", MASS, 1.5, Point2::new(0.0, 0.0));
    let bodies = RigidBodies::new(vec![body], GRAVITY, Box::new(RapierEngine::new()));
    let run = record(&mut start(bodies.expect("valid")), 0.01, 1000);
    for (t, body) in run {
        assert!((body.position.y + 0.5 * GRAVITY * t * t).abs() < 1e-9);
        assert!((body.acceleration.y + GRAVITY).abs() < 1e-9);
    }
}

/// The engines differ by the frequency of the second-order one, (ω h)²/24 too high, and nothing
/// else: 0.04 % of the amplitude over five periods at 400 steps a period.
#[test]
fn engines_agree() {
    let differences = [100, 200, 400].map(|steps| {
        let engines: [Box<dyn RigidBodyEngine>; 2] =
            [Box::new(RapierEngine::new()), Box::new(NewtonEulerEngine::new())];
        let h = period() / f64::from(steps);
        let runs = engines.map(|engine| record(&mut heaving(engine), h, 5 * steps as usize));
        let pairs = runs[0].iter().zip(&runs[1]);
        largest(pairs.map(|((_, a), (_, b))| (a.position - b.position).norm())) / AMPLITUDE
    });
    println!("relative differences {differences:?}, order {:.4}", order_of(&differences));
    assert!(order_of(&differences) > 1.9);
    assert!(differences[2] < 4e-4);
}

/// Substeps resolve a stiff spring that the communication step alone would make unstable
/// (ω h = 3 > 2).
#[test]
fn substeps_carry_a_stiff_spring() {
    let omega = TAU / period();
    let run = |substeps| {
        let mut bodies =
            heaving(Box::new(RapierEngine::new())).with_substeps(substeps).expect("substeps");
        let run = record(&mut bodies, 3.0 / omega, 100);
        largest(run.iter().map(|(_, body)| body.position.y - 1.0))
    };
    assert!(run(1) > 1e3);
    let bounded = run(20);
    assert!(bounded < 1.01 * AMPLITUDE, "{bounded}");
}

/// Held degrees of freedom stay to the bit, whatever pulls at them.
#[test]
fn held_degrees_stay() {
    for pattern in 0..8 {
        let free =
            FreeDegrees { sway: pattern & 1 > 0, heave: pattern & 2 > 0, roll: pattern & 4 > 0 };
        let mut body = BodyProperties::new("box", MASS, 1.5, Point2::new(0.3, 0.7));
        body.angle = 0.123_456_789;
        body.free = free;
        let first = body.kinematics();
        let mut bodies =
            RigidBodies::new(vec![body], GRAVITY, Box::new(RapierEngine::new())).expect("valid");
        let pull =
            |_: f64, _: &BoundaryKinematics| Load { force: Vector2::new(30.0, 80.0), torque: 5.0 };
        bodies.add_own_load(0, Box::new(pull)).expect("the body exists");
        let (_, last) = record(&mut start(bodies), 0.001, 1000)[999];
        let moved = [
            last.position.x != first.position.x,
            last.position.y != first.position.y,
            last.angle != first.angle,
        ];
        assert_eq!(moved, free.as_array(), "{free:?}");
        let speeds = [last.velocity.x, last.velocity.y, last.angular_velocity];
        let accelerations = [last.acceleration.x, last.acceleration.y, last.angular_acceleration];
        for degree in (0..3).filter(|degree| !free.as_array()[*degree]) {
            assert_eq!((speeds[degree], accelerations[degree]), (0.0, 0.0));
        }
    }
}
