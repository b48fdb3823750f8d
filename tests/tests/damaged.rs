//! Values that are not finite end a run with an error that names them.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

use nalgebra::{Point2, Vector2};
use seakeep_coupler::interface::{
    BoundaryKinematics, Component, ComponentError, LoadComponent, MotionComponent,
};
use seakeep_fluid::FluidError;
use seakeep_tests::{Coupled, FLOATING_BOX, case};

/// The fluid's own error in that of its component.
fn cause(error: ComponentError) -> FluidError {
    let ComponentError::Step { component, step, source, .. } = error else {
        panic!("not the error of a step: {error}")
    };
    assert_eq!((component.as_str(), step), ("fluid", 3));
    *source.downcast().expect("an error of the fluid")
}

/// A run after two steps, with the time and the length of the next.
fn run() -> (Coupled, f64, f64) {
    let mut run = Coupled::start(&case(FLOATING_BOX, &[]));
    run.steps(2);
    let (now, h) = (run.master.time(), run.master.communication_step());
    (run, now, h)
}

#[test]
fn kinematics_that_are_not_finite_are_refused() {
    let (mut run, now, h) = run();
    let good = run.bodies.kinematics()[0];
    let nan = f64::NAN;
    for bad in [nan, f64::INFINITY, f64::NEG_INFINITY] {
        for broken in [
            BoundaryKinematics { angle: bad, ..good },
            BoundaryKinematics { angular_velocity: bad, ..good },
            BoundaryKinematics { position: Point2::new(0.5, bad), ..good },
            BoundaryKinematics { velocity: Vector2::new(bad, 0.0), ..good },
        ] {
            run.fluid.set_kinematics(&[broken]);
            let error = run.fluid.solve_load(now, h).unwrap_err();
            let boundary = run.fluid.setup().boundaries[0].name.clone();
            assert_eq!(cause(error), FluidError::Kinematics { boundary });
        }
    }
    // Nothing has happened: with sound kinematics the run goes on.
    run.fluid.set_kinematics(&[good]);
    assert!(run.fluid.solve_load(now, h).is_ok());
}

#[test]
fn a_variable_that_is_not_finite_is_refused() {
    let (mut run, ..) = run();
    let inputs = run.fluid.description().variables.clone();
    for variable in
        inputs.iter().filter(|v| !v.name.contains("force") && !v.name.contains("torque"))
    {
        let before = run.fluid.get_float64(variable.reference).unwrap();
        let error = run.fluid.set_float64(variable.reference, f64::NAN).unwrap_err();
        assert!(
            matches!(&error, ComponentError::NotFinite { variable: name, .. } if *name == variable.name),
            "{error}"
        );
        assert_eq!(run.fluid.get_float64(variable.reference).unwrap(), before);
    }
}

#[test]
fn a_particle_that_is_not_finite_ends_the_run() {
    let (mut run, now, h) = run();
    run.fluid.set_kinematics(run.bodies.kinematics());
    run.fluid.solve_load(now, h).unwrap();
    run.fluid.set_accelerations(&[0.0, f64::NAN, 0.0]);
    let error = cause(run.fluid.do_step(now, h).unwrap_err());
    let FluidError::Unstable { particle, v, .. } = error else { panic!("{error}") };
    assert!(v.is_nan());
    assert!((particle as usize) < run.fluid.particle_counts().fluid);
}

#[test]
fn a_particle_that_leaves_the_tank_ends_the_run() {
    let (mut run, now, h) = run();
    run.fluid.set_kinematics(run.bodies.kinematics());
    run.fluid.solve_load(now, h).unwrap();
    // Fifty metres in a step.
    run.fluid.set_accelerations(&[100.0 / (h * h), 0.0, 0.0]);
    let error = cause(run.fluid.do_step(now, h).unwrap_err());
    assert!(matches!(error, FluidError::Unstable { .. }), "{error}");
}
