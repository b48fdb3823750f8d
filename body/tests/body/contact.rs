//! Contacts through rapier2d: between bodies, and with the tank.

use nalgebra::{Point2, Vector2};
use seakeep_body::{BodyProperties, Contacts, LinearSpring, RapierEngine, RigidBodies};
use seakeep_coupler::interface::{BoundaryKinematics, Component, Load, MotionComponent};

/// A rectangle of this width and height about the centre of mass.
fn rectangle(width: f64, height: f64) -> Vec<Vector2<f64>> {
    let (x, y) = (0.5 * width, 0.5 * height);
    [(-x, -y), (x, -y), (x, y), (-x, y)].map(|(x, y)| Vector2::new(x, y)).to_vec()
}

/// A homogeneous box of side 0.2 m.
fn cube(name: &str, mass: f64, position: Point2<f64>) -> BodyProperties {
    let mut body = BodyProperties::new(name, mass, mass * 0.04 / 6.0, position);
    body.outline = rectangle(0.2, 0.2);
    body
}

fn start(bodies: Vec<BodyProperties>, gravity: f64, contacts: Contacts) -> RigidBodies {
    let engine = Box::new(RapierEngine::with_contacts(contacts));
    let mut bodies = RigidBodies::new(bodies, gravity, engine).expect("valid bodies");
    bodies.enter_initialization_mode(0.0).expect("finite start");
    bodies.exit_initialization_mode().expect("initialized");
    bodies
}

fn go(bodies: &mut RigidBodies, h: f64, steps: u32) {
    for step in 0..steps {
        bodies.do_step(f64::from(step) * h, h).expect("a good step");
    }
}

/// Momentum after a head-on collision of two boxes (3 and 5 kg/m at 2 and −1 m/s), the left one
/// at this angle, and the speed at which they part over that at which they met.
fn collide(restitution: f64, angle: f64) -> (Vector2<f64>, f64) {
    let (m1, m2, v1, v2) = (3.0, 5.0, 2.0, -1.0);
    let mut left = cube("left", m1, Point2::new(0.0, 0.0));
    let mut right = cube("right", m2, Point2::new(0.5, 0.0));
    (left.angle, left.velocity.x, right.velocity.x) = (angle, v1, v2);
    let contacts = Contacts { restitution, ..Contacts::default() };
    let mut bodies = start(vec![left, right], 0.0, contacts);
    go(&mut bodies, 1e-3, 200);
    let [left, right] = [0, 1].map(|index| bodies.kinematics()[index]);
    let parted = (right.velocity.x - left.velocity.x) / (v1 - v2);
    (m1 * left.velocity + m2 * right.velocity, parted)
}

#[test]
fn two_boxes_collide_and_keep_momentum() {
    let momentum = Vector2::new(3.0 * 2.0 - 5.0, 0.0);
    for restitution in [0.0, 0.5, 1.0] {
        // A corner against a side: Newton's law of restitution.
        let (found, parted) = collide(restitution, std::f64::consts::FRAC_PI_4);
        assert!((found - momentum).norm() < 1e-12, "{found:?}");
        assert!((parted - restitution).abs() < 1e-3, "{parted}");
        // Side against side rapier lets the two corners bounce one after the other, and up to an
        // eighth of the restitution is lost.
        let (found, parted) = collide(restitution, 0.0);
        println!("restitution {restitution}: side against side {parted}");
        assert!((found - momentum).norm() < 1e-12, "{found:?}");
        assert!(parted > 0.87 * restitution - 1e-9 && parted < restitution + 1e-9, "{parted}");
    }
}

/// An eccentric hit keeps momentum and angular momentum, and makes no energy.
#[test]
fn an_eccentric_collision_keeps_angular_momentum() {
    let mut left = cube("left", 3.0, Point2::new(0.0, 0.07));
    left.velocity.x = 2.0;
    let mut right = cube("right", 5.0, Point2::new(0.5, 0.0));
    right.angle = 0.5;
    let bodies = vec![left, right];
    let inertia: Vec<f64> = bodies.iter().map(|body| body.inertia).collect();
    let mass = [3.0, 5.0];
    let sums = |bodies: &[BoundaryKinematics]| {
        let mut momentum = Vector2::zeros();
        let (mut angular, mut energy) = (0.0, 0.0);
        for ((body, m), i) in bodies.iter().zip(mass).zip(&inertia) {
            momentum += m * body.velocity;
            angular += i * body.angular_velocity + m * body.position.coords.perp(&body.velocity);
            energy += 0.5 * m * body.velocity.norm_squared();
            energy += 0.5 * i * body.angular_velocity.powi(2);
        }
        (momentum, angular, energy)
    };
    let mut bodies = start(bodies, 0.0, Contacts { restitution: 1.0, ..Contacts::default() });
    let before = sums(bodies.kinematics());
    go(&mut bodies, 2e-4, 2000);
    let after = sums(bodies.kinematics());
    println!("{before:?} {after:?}");
    assert!(bodies.kinematics()[1].angular_velocity.abs() > 0.1, "they have not met");
    assert!((after.0 - before.0).norm() < 1e-12);
    // rapier evaluates the arms at the start of the step in which they meet.
    assert!((after.1 / before.1 - 1.0).abs() < 5e-3, "{} {}", before.1, after.1);
    assert!(after.2 < before.2 * 1.001 && after.2 > 0.9 * before.2);
}

/// Pushed against the wall and down onto the bed, a box stays where it touches them.
#[test]
fn a_box_pushed_against_a_wall_stays() {
    let contacts = Contacts { tank_length: Some(1.0), ..Contacts::default() };
    let body = cube("box", 40.0, Point2::new(0.85, 0.15));
    let mut bodies = start(vec![body], 9.81, contacts);
    let push = |_: f64, _: &BoundaryKinematics| Load { force: Vector2::x() * 500.0, torque: 0.0 };
    bodies.add_own_load(0, Box::new(push)).expect("the body exists");
    go(&mut bodies, 1e-3, 1000);
    let settled = bodies.kinematics()[0];
    for step in 1000..3000 {
        bodies.do_step(f64::from(step) * 1e-3, 1e-3).expect("a good step");
        let now = bodies.kinematics()[0];
        let moved = (now.position - Point2::new(0.9, 0.1)).norm();
        assert!(moved < 1e-4, "{moved} m off the corner");
        assert!(now.angle.abs() < 1e-3, "{}", now.angle);
        // A step of free fall would bring 0.01 m/s.
        assert!(now.velocity.norm() < 1e-3, "{:?}", now.velocity);
    }
    println!("{settled:?}");
}

/// With friction a box on the bed withstands a push up to the coefficient times its weight.
#[test]
fn friction_holds_a_box_on_the_bed() {
    let weight = 40.0 * 9.81;
    for (part, slides) in [(0.35, false), (0.45, true)] {
        let contacts = Contacts { friction: 0.4, tank_length: Some(3.0), restitution: 0.0 };
        let mut bodies = start(vec![cube("box", 40.0, Point2::new(0.5, 0.1))], 9.81, contacts);
        let push = move |_: f64, _: &BoundaryKinematics| Load {
            force: Vector2::new(part * weight, 0.0),
            torque: 0.0,
        };
        bodies.add_own_load(0, Box::new(push)).expect("the body exists");
        go(&mut bodies, 1e-3, 1000);
        let moved = bodies.kinematics()[0].position.x - 0.5;
        println!("pushed with {part} of the weight: {moved} m in 1 s");
        // (0.45 − 0.4) g t²/2
        let free = if slides { 0.05 * 9.81 * 0.5 } else { 0.0 };
        assert!((moved - free).abs() < 0.02, "{part}: {moved}, Coulomb {free}");
    }
}

/// An outline that touches nothing changes nothing but rounding; one that is not convex has a
/// notch that another body fits into.
#[test]
fn an_outline_is_no_load_and_a_notch_is_a_notch() {
    let run = |outline| {
        let mut body = BodyProperties::new("box", 42.0, 1.5, Point2::new(2.0, 1.05));
        body.angle = 0.2;
        body.outline = outline;
        let contacts = Contacts { tank_length: Some(4.0), ..Contacts::default() };
        let mut bodies = start(vec![body], 0.0, contacts);
        let spring = LinearSpring::diagonal(50.0, 3924.0, 60.0, Point2::new(2.1, 1.0));
        bodies.add_own_load(0, Box::new(spring)).expect("the body exists");
        go(&mut bodies, 5e-3, 1000);
        bodies.kinematics()[0]
    };
    let (bare, clad) = (run(Vec::new()), run(rectangle(0.3, 0.2)));
    assert!((bare.position - clad.position).norm() < 1e-12);
    assert!((bare.angle - clad.angle).abs() < 1e-12);

    let u = [
        [-0.3, -0.2],
        [0.3, -0.2],
        [0.3, 0.2],
        [0.15, 0.2],
        [0.15, 0.0],
        [-0.15, 0.0],
        [-0.15, 0.2],
        [-0.3, 0.2],
    ];
    let mut dock = BodyProperties::new("dock", 9.0, 1.0, Point2::new(0.0, 0.0));
    dock.outline = u.map(Vector2::from).to_vec();
    dock.free = seakeep_body::FreeDegrees::NONE;
    let mut bodies =
        start(vec![dock, cube("box", 1.0, Point2::new(0.0, 0.3))], 9.81, Contacts::default());
    go(&mut bodies, 1e-3, 2000);
    let rest = bodies.kinematics()[1].position;
    assert!((rest - Point2::new(0.0, 0.1)).norm() < 1e-3, "{rest:?}");
}

/// Contacts are part of the state: a run through a collision repeats to the bit.
#[test]
fn a_collision_repeats_to_the_bit() {
    let mut left = cube("left", 3.0, Point2::new(0.3, 0.17));
    left.velocity.x = 2.0;
    let right = cube("right", 5.0, Point2::new(0.56, 0.1));
    let contacts = Contacts { restitution: 0.3, friction: 0.2, tank_length: Some(1.0) };
    let mut bodies = start(vec![left, right], 9.81, contacts);
    go(&mut bodies, 1e-3, 25);
    let saved = bodies.get_state().expect("saved");
    let run = |bodies: &mut RigidBodies| {
        (25..400)
            .map(|step| {
                bodies.do_step(f64::from(step) * 1e-3, 1e-3).expect("a good step");
                bodies.kinematics().iter().map(|b| (b.position, b.angle)).collect::<Vec<_>>()
            })
            .collect::<Vec<_>>()
    };
    let first = run(&mut bodies);
    bodies.set_state(&saved).expect("its own");
    assert_eq!(run(&mut bodies), first);
}
