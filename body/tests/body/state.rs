//! Saving, restoring and repeating gives the same bits.

use crate::common::{LinearLoad, NAME};
use nalgebra::{DMatrix, Point2, Vector2};
use seakeep_body::{
    BodyProperties, LinearSpring, NewtonEulerEngine, RapierEngine, RigidBodies, RigidBodyEngine,
};
use seakeep_coupler::interface::{
    BoundaryKinematics, Component, ComponentError, ComponentState, LoadComponent, MotionComponent,
};
use seakeep_coupler::{CouplerError, FixedStepMaster, SavedState};

fn bodies(engine: Box<dyn RigidBodyEngine>) -> RigidBodies {
    let mut box_body = BodyProperties::new("box", 42.0, 1.5, Point2::new(0.1, 1.03));
    box_body.angle = 0.3;
    box_body.velocity = Vector2::new(0.2, -0.1);
    box_body.angular_velocity = 9.0;
    let mut held = BodyProperties::new("sill", 1.0, 1.0, Point2::new(2.0, 0.4));
    held.angle = -0.7;
    held.free = seakeep_body::FreeDegrees::NONE;
    let mut bodies = RigidBodies::new(vec![box_body, held], 9.81, engine).expect("valid bodies");
    let spring = LinearSpring::diagonal(800.0, 3924.0, 0.3, Point2::new(0.0, 1.1));
    bodies.add_own_load(0, Box::new(spring)).expect("the body exists");
    bodies
}

fn load() -> LinearLoad {
    let stiffness = DMatrix::from_fn(6, 6, |i, j| if i == j { 20.0 } else { 0.3 });
    let added_mass = DMatrix::from_fn(6, 6, |i, j| if i == j { 70.0 } else { 0.9 });
    LinearLoad::new(stiffness, added_mass, vec![0.0, 1.0, 0.0, 2.0, 0.4, 0.0])
}

fn engines() -> [fn() -> Box<dyn RigidBodyEngine>; 2] {
    [|| Box::new(RapierEngine::new()), || Box::new(NewtonEulerEngine::new())]
}

type Bits = Vec<(u64, Vec<u64>)>;

fn run(
    master: &mut FixedStepMaster,
    load: &mut LinearLoad,
    bodies: &mut RigidBodies,
    steps: usize,
) -> Bits {
    let bits = |body: &BoundaryKinematics| {
        [
            body.position.x,
            body.position.y,
            body.angle,
            body.velocity.x,
            body.velocity.y,
            body.angular_velocity,
            body.acceleration.x,
            body.acceleration.y,
            body.angular_acceleration,
        ]
        .map(f64::to_bits)
    };
    (0..steps)
        .map(|_| {
            let report = master.step(load, Some(bodies)).expect("a good step");
            let residual = report.power_bond_residual.to_bits();
            let loads = load.loads().iter().map(|load| load.force.y.to_bits());
            let kinematics = bodies.kinematics().iter().flat_map(bits);
            (report.time.to_bits(), kinematics.chain(loads).chain([residual]).collect())
        })
        .collect()
}

#[test]
fn restored_run_repeats_to_the_bit() {
    for engine in engines() {
        let (mut load, mut bodies) = (load(), bodies(engine()));
        let mut master =
            FixedStepMaster::start(5.0, 0.003, &mut load, Some(&mut bodies)).expect("they fit");
        run(&mut master, &mut load, &mut bodies, 777);
        let saved = master.save(&load, Some(&bodies)).expect("both can");
        let first = run(&mut master, &mut load, &mut bodies, 500);
        master.restore(&mut load, Some(&mut bodies), &saved).expect("its own state");
        assert_eq!(master.step_count(), 777);
        assert_eq!(run(&mut master, &mut load, &mut bodies, 500), first);
    }
}

/// As after a stop of the program: new components, the state through bytes.
#[test]
fn restart_in_new_components_repeats_to_the_bit() {
    for engine in engines() {
        let (mut load_1, mut bodies_1) = (load(), bodies(engine()));
        let mut master =
            FixedStepMaster::start(0.0, 0.003, &mut load_1, Some(&mut bodies_1)).expect("they fit");
        run(&mut master, &mut load_1, &mut bodies_1, 777);
        let saved = master.save(&load_1, Some(&bodies_1)).expect("both can");
        let bytes = postcard::to_stdvec(&saved).expect("serializable");
        let first = run(&mut master, &mut load_1, &mut bodies_1, 500);

        let saved: SavedState = postcard::from_bytes(&bytes).expect("the same bytes");
        let (mut load_2, mut bodies_2) = (load(), bodies(engine()));
        let mut master =
            FixedStepMaster::start(0.0, 0.003, &mut load_2, Some(&mut bodies_2)).expect("they fit");
        master.restore(&mut load_2, Some(&mut bodies_2), &saved).expect("an equal set-up");
        assert_eq!(run(&mut master, &mut load_2, &mut bodies_2, 500), first);
    }
}

#[test]
fn foreign_and_damaged_states_are_refused() {
    for engine in engines() {
        let mut bodies = bodies(engine());
        let good = bodies.get_state().expect("saved");
        let mut alone = RigidBodies::new(
            vec![BodyProperties::new("box", 1.0, 1.0, Point2::origin())],
            0.0,
            engine(),
        )
        .expect("valid body");
        let foreign = ComponentState { component: NAME.to_owned(), bytes: good.bytes.clone() };
        let cut = ComponentState { bytes: good.bytes[..60].to_vec(), ..good.clone() };
        assert!(matches!(bodies.set_state(&foreign), Err(ComponentError::State { .. })));
        assert!(matches!(bodies.set_state(&cut), Err(ComponentError::State { .. })));
        assert!(matches!(alone.set_state(&good), Err(ComponentError::State { .. })));
        for place in (0..good.bytes.len()).step_by(37) {
            let mut damaged = good.clone();
            damaged.bytes[place] ^= 16;
            assert!(matches!(bodies.set_state(&damaged), Err(ComponentError::State { .. })));
        }
        bodies.set_state(&good).expect("unharmed");
    }
}

#[test]
fn a_state_of_another_clock_is_refused() {
    let (mut load, mut bodies) = (load(), bodies(Box::new(RapierEngine::new())));
    let mut master =
        FixedStepMaster::start(0.0, 0.003, &mut load, Some(&mut bodies)).expect("they fit");
    let saved = master.save(&load, Some(&bodies)).expect("both can");
    for wrong in [
        SavedState { communication_step: 0.004, ..saved.clone() },
        SavedState { start_time: 1.0, ..saved.clone() },
        SavedState { motion: None, ..saved.clone() },
    ] {
        let refused = master.restore(&mut load, Some(&mut bodies), &wrong);
        assert!(matches!(refused, Err(CouplerError::SavedState { .. })), "{refused:?}");
    }
}
