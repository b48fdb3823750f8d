//! Bad input is an error that names it, never a panic.

use crate::common::weightless;
use nalgebra::{DMatrix, Point2, Vector2};
use seakeep_body::{BodyError, BodyProperties, FreeDegrees, RapierEngine, RigidBodies};
use seakeep_coupler::interface::{
    BoundaryKinematics, Causality, Component, ComponentError, Load, LoadResponse, MotionComponent,
    ValueReference,
};

fn body() -> BodyProperties {
    BodyProperties::new("box", 42.0, 1.5, Point2::new(0.0, 1.0))
}

fn refused(bodies: Vec<BodyProperties>, gravity: f64) -> BodyError {
    RigidBodies::new(bodies, gravity, Box::new(RapierEngine::new())).err().expect("bad input")
}

fn started() -> RigidBodies {
    let mut bodies = weightless(vec![body()]);
    bodies.enter_initialization_mode(0.0).expect("finite start");
    bodies.exit_initialization_mode().expect("initialized");
    bodies
}

/// The error of one step, by its words.
fn step_error(bodies: &mut RigidBodies) -> String {
    let error = bodies.do_step(0.0, 0.01).expect_err("a bad step");
    assert!(matches!(error, ComponentError::Step { step: 1, .. }), "{error:?}");
    error.to_string()
}

#[test]
fn bad_properties() {
    type Change = fn(&mut BodyProperties);
    let changes: [(&str, Change); 7] = [
        ("mass", |body| body.mass = 0.0),
        ("mass", |body| body.mass = f64::NAN),
        ("inertia", |body| body.inertia = -1.0),
        ("inertia", |body| body.inertia = f64::INFINITY),
        ("position x", |body| body.position.x = f64::NAN),
        ("angular velocity", |body| body.angular_velocity = f64::INFINITY),
        ("equilibrium y", |body| body.equilibrium.y = f64::NAN),
    ];
    for (property, change) in changes {
        let mut bad = body();
        change(&mut bad);
        let error = refused(vec![bad], 9.81);
        assert!(matches!(error, BodyError::Property { .. }), "{error:?}");
        assert!(error.to_string().starts_with(&format!("body box: {property}")), "{error}");
    }
    assert!(matches!(refused(vec![body()], f64::NAN), BodyError::Gravity { .. }));
    assert!(matches!(refused(vec![body(), body()], 9.81), BodyError::Name { .. }));
    let nameless = BodyProperties { name: String::new(), ..body() };
    assert!(matches!(refused(vec![nameless], 9.81), BodyError::Name { .. }));
    let sliding = BodyProperties {
        velocity: Vector2::new(1.0, 0.0),
        free: FreeDegrees { sway: false, ..FreeDegrees::ALL },
        ..body()
    };
    assert!(matches!(
        refused(vec![sliding], 9.81),
        BodyError::HeldVelocity { degree: "sway", value: 1.0, .. }
    ));
}

#[test]
fn bad_set_up() {
    let zero = weightless(vec![body()]).with_substeps(0);
    assert_eq!(zero.err(), Some(BodyError::NoSubsteps));
    let pull = |_: f64, _: &BoundaryKinematics| Load::zero();
    let unknown = weightless(vec![body()]).add_own_load(1, Box::new(pull));
    assert_eq!(unknown, Err(BodyError::UnknownBody { index: 1, count: 1 }));
}

#[test]
fn bad_loads() {
    let zero = LoadResponse::zero(1);
    let cases = [
        ("load = NaN", {
            let mut response = zero.clone();
            response.at_zero_acceleration[0].force.y = f64::NAN;
            response
        }),
        ("added mass = inf", {
            let mut response = zero.clone();
            response.added_mass[(1, 2)] = f64::INFINITY;
            response
        }),
        ("load response for 2 bodies", LoadResponse::zero(2)),
        ("load response for 0 bodies", LoadResponse::zero(0)),
        ("3 x 2 added mass", LoadResponse { added_mass: DMatrix::zeros(3, 2), ..zero.clone() }),
        ("singular", LoadResponse { added_mass: DMatrix::identity(3, 3) * -42.0, ..zero.clone() }),
    ];
    for (words, response) in cases {
        let mut bodies = started();
        bodies.set_load(&response);
        let error = step_error(&mut bodies);
        assert!(error.contains(words), "{error}");
        // Nothing has moved, and the component goes on with a good load.
        assert_eq!(bodies.kinematics()[0], body().kinematics());
        bodies.set_load(&zero);
        bodies.do_step(0.0, 0.01).expect("a good step");
    }
}

#[test]
fn bad_own_load_and_overflow() {
    let mut bodies = started();
    let broken =
        |_: f64, _: &BoundaryKinematics| Load { force: Vector2::zeros(), torque: f64::NAN };
    bodies.add_own_load(0, Box::new(broken)).expect("the body exists");
    assert!(step_error(&mut bodies).contains("own load = NaN"));

    let mut bodies = started();
    let mut response = LoadResponse::zero(1);
    response.at_zero_acceleration[0].force.x = f64::MAX;
    response.added_mass[(0, 0)] = -41.999_999;
    bodies.set_load(&response);
    step_error(&mut bodies);
}

#[test]
fn bad_calls() {
    let mut bodies = weightless(vec![body()]);
    assert!(matches!(bodies.do_step(0.0, 0.01), Err(ComponentError::CallSequence { .. })));
    assert!(matches!(
        bodies.enter_initialization_mode(f64::NAN),
        Err(ComponentError::NotFinite { .. })
    ));
    let mut bodies = started();
    for (now, expected) in [(0.5, "stands at"), (f64::NAN, "stands at")] {
        let error = bodies.do_step(now, 0.01).expect_err("another time").to_string();
        assert!(error.contains(expected), "{error}");
    }
    for step in [0.0, -0.01, f64::NAN, f64::INFINITY] {
        bodies.do_step(0.0, step).expect_err("a bad step length");
    }
    bodies.terminate();
    assert!(matches!(bodies.do_step(0.0, 0.01), Err(ComponentError::CallSequence { .. })));
}

#[test]
fn variables_by_name() {
    let mut start = body();
    start.equilibrium = Point2::new(0.0, 0.9);
    start.angle = 0.2;
    let mut bodies = weightless(vec![start]);
    let reference = |bodies: &RigidBodies, name: &str| {
        bodies.description().variable(name).expect("it exists").reference
    };
    bodies.enter_initialization_mode(0.0).expect("finite start");
    bodies.exit_initialization_mode().expect("initialized");
    let (force, heave) = (reference(&bodies, "box.force_y"), reference(&bodies, "box.heave"));
    assert!((bodies.get_float64(heave).expect("known") - 0.1).abs() < 1e-15);
    let roll = reference(&bodies, "box.roll");
    assert_eq!(bodies.get_float64(roll).expect("known"), 0.2);

    bodies.set_float64(force, 84.0).expect("an input");
    assert_eq!(bodies.get_float64(force).expect("known"), 84.0);
    bodies.do_step(0.0, 0.01).expect("a good step");
    let acceleration = reference(&bodies, "box.heave_acceleration");
    assert!((bodies.get_float64(acceleration).expect("known") - 2.0).abs() < 1e-12);

    assert!(matches!(bodies.set_float64(force, f64::NAN), Err(ComponentError::NotFinite { .. })));
    assert!(matches!(bodies.set_float64(heave, 1.0), Err(ComponentError::NotAnInput { .. })));
    let unknown = ValueReference(12);
    assert!(matches!(bodies.get_float64(unknown), Err(ComponentError::UnknownVariable { .. })));
    let unknown = bodies.set_float64(unknown, 1.0);
    assert!(matches!(unknown, Err(ComponentError::UnknownVariable { .. })));

    for (index, variable) in (0..).zip(&bodies.description().variables) {
        assert_eq!(variable.reference, ValueReference(index));
        assert_eq!(variable.causality == Causality::Input, index < 3);
        assert!(!variable.unit.is_empty() && !variable.description.is_empty());
    }
}
