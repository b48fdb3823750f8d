//! Prescribed motion: the formulas themselves, and bodies that follow them.

use crate::common::{largest, order_of};
use nalgebra::{Point2, Vector2};
use seakeep_body::{
    BodyError, BodyProperties, Harmonic, NewtonEulerEngine, Oscillation, PrescribedMotion,
    RapierEngine, RigidBodies, RigidBodyEngine, TimeSeries,
};
use seakeep_coupler::interface::{
    BoundaryKinematics, Component, Load, LoadResponse, MotionComponent,
};

const REST: Point2<f64> = Point2::new(2.0, 0.6);

fn engines() -> [Box<dyn RigidBodyEngine>; 2] {
    [Box::new(RapierEngine::new()), Box::new(NewtonEulerEngine::new())]
}

/// Uneven times from 0 to 2 s.
fn times(count: usize) -> Vec<f64> {
    (0..count)
        .map(|i| {
            let s = i as f64 / (count - 1) as f64;
            2.0 * s + 0.1 * (9.0 * s).sin() * s * (1.0 - s)
        })
        .collect()
}

fn series(times: Vec<f64>, sample: impl Fn(f64) -> [f64; 3]) -> Result<TimeSeries, BodyError> {
    let samples: Vec<_> = times.iter().map(|t| sample(*t)).collect();
    TimeSeries::new(REST, times, &samples)
}

fn harmonic() -> Harmonic {
    let swing = |amplitude, period, phase| Some(Oscillation { amplitude, period, phase });
    let degrees = [swing(0.1, 0.8, 0.3), None, swing(0.2, 1.1, -1.0)];
    Harmonic::new(REST, 0.05, degrees, 0.5).expect("valid")
}

/// Pose, velocity and acceleration as nine numbers.
fn numbers(body: &BoundaryKinematics) -> [f64; 9] {
    let (r, v, a) = (body.position, body.velocity, body.acceleration);
    let (w, b) = (body.angular_velocity, body.angular_acceleration);
    [r.x, r.y, body.angle, v.x, v.y, w, a.x, a.y, b]
}

#[test]
fn a_series_reproduces_cubics_with_their_derivatives() {
    let cubic = |t: f64| [1.0 - t + 0.5 * t * t * t, t * t, 0.3 * t];
    for count in [4, 5, 17] {
        let motion = series(times(count), cubic).expect("valid");
        for step in 0..=40 {
            let t = f64::from(step) / 20.0;
            let [x, y, angle] = cubic(t);
            let exact = BoundaryKinematics {
                position: REST + Vector2::new(x, y),
                angle,
                velocity: Vector2::new(-1.0 + 1.5 * t * t, 2.0 * t),
                angular_velocity: 0.3,
                acceleration: Vector2::new(3.0 * t, 2.0),
                angular_acceleration: 0.0,
            };
            let found = motion.kinematics(t).expect("within");
            let error = numbers(&found).into_iter().zip(numbers(&exact)).map(|(a, b)| a - b);
            assert!(largest(error) < 1e-12, "{count} samples, t = {t}: {found:?}");
        }
    }
}

#[test]
fn a_series_is_of_fourth_order_and_its_acceleration_continuous() {
    let errors = [21, 41, 81, 161].map(|count| {
        let known = times(count);
        let motion = series(known.clone(), |t| [(4.0 * t).sin(), 0.0, 0.0]).expect("valid");
        for knot in &known[1..count - 1] {
            let [left, right] = [-1e-9, 1e-9]
                .map(|side| motion.kinematics(knot + side).expect("within").acceleration.x);
            assert!((left - right).abs() < 1e-5, "t = {knot}: {left}, {right}");
        }
        largest((0..2000).map(|step| {
            let t = f64::from(step) / 1000.0;
            motion.kinematics(t).expect("within").position.x - REST.x - (4.0 * t).sin()
        }))
    });
    println!("errors {errors:?}, order {:.3}", order_of(&errors));
    assert!(order_of(&errors) > 3.5);
}

#[test]
fn bad_series_are_refused_with_the_sample() {
    let still = |_: f64| [0.0; 3];
    let reason = |times: Vec<f64>| series(times, still).expect_err("bad").to_string();
    assert!(reason(vec![0.0, 1.0, 2.0]).contains("3 samples"));
    let unsorted = reason(vec![0.0, 1.0, 0.5, 2.0]);
    assert!(unsorted.contains("sample 3 at 0.5 s follows one at 1 s"), "{unsorted}");
    assert!(reason(vec![0.0, 1.0, 1.0, 2.0]).contains("must rise"));
    assert!(reason(vec![0.0, f64::NAN, 1.0, 2.0]).contains("time of sample 2"));
    let gap = series(times(5), |t| [0.0, if t > 1.9 { f64::NAN } else { 0.0 }, 0.0]);
    let gap = gap.expect_err("bad").to_string();
    assert!(gap.contains("a gap: heave of sample 5 (t = 2 s) is NaN"), "{gap}");
    let motion = series(times(5), still).expect("valid");
    for time in [-0.1, 2.1, f64::NAN] {
        assert!(matches!(motion.kinematics(time), Err(BodyError::OutsideMotion { .. })));
    }
}

#[test]
fn harmonic_motion_starts_at_rest_and_is_differentiated_exactly() {
    let motion = harmonic();
    let at = |t: f64| numbers(&motion.kinematics(t).expect("always"));
    assert_eq!(at(0.0), [REST.x, REST.y, 0.05, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    for t in [0.05, 0.2, 0.45, 0.7, 3.0] {
        let h = 1e-5;
        let (before, now, after) = (at(t - h), at(t), at(t + h));
        for i in 0..6 {
            let difference = (after[i] - before[i]) / (2.0 * h);
            assert!((difference - now[i + 3]).abs() < 1e-6, "t = {t}, {i}: {difference}");
        }
    }
    let roll = 0.2 * (std::f64::consts::TAU * 3.0 / 1.1 - 1.0).sin();
    assert!((at(3.0)[2] - 0.05 - roll).abs() < 1e-14);
    let bad = |amplitude, period, ramp| {
        let swing = Oscillation { amplitude, period, phase: 0.0 };
        Harmonic::new(REST, 0.0, [Some(swing), None, None], ramp).is_err()
    };
    assert!(bad(f64::NAN, 1.0, 0.0) && bad(1.0, 0.0, 0.0) && bad(1.0, 1.0, -1.0));
}

/// A body that follows `motion` beside a free one.
fn followed(engine: Box<dyn RigidBodyEngine>, motion: Box<dyn PrescribedMotion>) -> RigidBodies {
    let led = BodyProperties::new("led", 1.0, 1.0, Point2::new(9.0, 9.0));
    let free = BodyProperties::new("free", 5.0, 2.0, Point2::new(4.0, 0.5));
    let mut bodies = RigidBodies::new(vec![led, free], 9.81, engine).expect("valid");
    let pull = |_: f64, _: &BoundaryKinematics| Load { force: Vector2::new(1e3, 1e3), torque: 1e3 };
    bodies.add_own_load(0, Box::new(pull)).expect("the body exists");
    bodies.prescribe(0, motion).expect("it knows the start");
    bodies.enter_initialization_mode(0.0).expect("finite start");
    bodies.exit_initialization_mode().expect("initialized");
    bodies
}

#[test]
fn a_body_follows_exactly_whatever_the_loads() {
    for engine in engines() {
        let mut bodies = followed(engine, Box::new(harmonic())).with_substeps(3).expect("substeps");
        let h = 0.01;
        let mut time = 0.0;
        for _ in 0..300 {
            let before = bodies.kinematics()[0];
            bodies.do_step(time, h).expect("a good step");
            time += h;
            let now = bodies.kinematics()[0];
            let exact = harmonic().kinematics(time).expect("always");
            assert_eq!(numbers(&now)[..6], numbers(&exact)[..6]);
            let next = harmonic().kinematics(time + h).expect("always");
            // The velocity change is that of the mean acceleration, after the step and, among
            // the kinematics, before it.
            let mean = (now.velocity - before.velocity) / h;
            assert_eq!(bodies.mean_accelerations()[..2], [mean.x, mean.y]);
            let coming = (next.angular_velocity - now.angular_velocity) / h;
            assert!((now.angular_acceleration - coming).abs() < 1e-9);
        }
        // The free one beside it falls.
        let fallen = bodies.kinematics()[1].position.y;
        assert!((fallen - 0.5 + 0.5 * 9.81 * 9.0).abs() < 1e-9, "{fallen}");
    }
}

#[test]
fn a_free_body_feels_the_prescribed_acceleration_through_added_mass() {
    for engine in engines() {
        let motion = |t: f64| BoundaryKinematics {
            velocity: Vector2::new(3.0 * t, 0.0),
            acceleration: Vector2::new(3.0, 0.0),
            ..BoundaryKinematics::at_rest(REST + Vector2::new(1.5 * t * t, 0.0), 0.0)
        };
        let mut bodies = followed(engine, Box::new(motion));
        let mut response = LoadResponse::zero(2);
        response.added_mass[(3, 3)] = 10.0;
        response.added_mass[(3, 0)] = -4.0;
        bodies.set_load(&response);
        bodies.do_step(0.0, 0.01).expect("a good step");
        // (5 + 10) a = 4 · 3
        assert!((bodies.mean_accelerations()[3] - 0.8).abs() < 1e-12);
    }
}

/// A machine with a state: its speed follows what it observes.
#[derive(Default)]
struct Follower {
    time: f64,
    place: f64,
    speed: f64,
    acceleration: f64,
}

impl PrescribedMotion for Follower {
    fn kinematics(&self, time: f64) -> Result<BoundaryKinematics, BodyError> {
        let t = time - self.time;
        let x = self.place + self.speed * t + 0.5 * self.acceleration * t * t;
        Ok(BoundaryKinematics {
            velocity: Vector2::new(self.speed + self.acceleration * t, 0.0),
            acceleration: Vector2::new(self.acceleration, 0.0),
            ..BoundaryKinematics::at_rest(Point2::new(x, 0.0), 0.0)
        })
    }
    fn observe(&mut self, elevation: f64) {
        self.acceleration = 5.0 * elevation - self.speed;
    }
    fn advance(&mut self, time: f64, duration: f64) -> Result<(), BodyError> {
        self.place += self.speed * duration + 0.5 * self.acceleration * duration * duration;
        self.speed += self.acceleration * duration;
        self.time = time + duration;
        Ok(())
    }
    fn save(&self) -> Result<Vec<u8>, BodyError> {
        let numbers = [self.time, self.place, self.speed, self.acceleration];
        Ok(numbers.iter().flat_map(|number| number.to_le_bytes()).collect())
    }
    fn restore(&mut self, state: &[u8]) -> Result<(), BodyError> {
        let numbers: Vec<f64> = state
            .chunks_exact(8)
            .filter_map(|bytes| bytes.try_into().ok().map(f64::from_le_bytes))
            .collect();
        let [time, place, speed, acceleration] = numbers[..] else {
            return Err(BodyError::MotionState);
        };
        *self = Self { time, place, speed, acceleration };
        Ok(())
    }
}

#[test]
fn a_motion_with_a_state_is_steered_saved_and_repeated() {
    for engine in engines() {
        let mut bodies = followed(engine, Box::<Follower>::default());
        let run = |bodies: &mut RigidBodies, from: u32| -> Vec<[f64; 9]> {
            (from..from + 40)
                .map(|step| {
                    let time = f64::from(step) * 0.01;
                    bodies.observe_elevation(0, (7.0 * time).sin()).expect("known");
                    let told = bodies.kinematics()[0].acceleration.x;
                    bodies.do_step(time, 0.01).expect("a good step");
                    assert!((bodies.mean_accelerations()[0] - told).abs() < 1e-10);
                    numbers(&bodies.kinematics()[0])
                })
                .collect()
        };
        run(&mut bodies, 0);
        let saved = bodies.get_state().expect("saved");
        let first = run(&mut bodies, 40);
        bodies.set_state(&saved).expect("its own");
        assert_eq!(run(&mut bodies, 40), first);
        assert!(first[39][0].abs() > 0.01);
    }
}

#[test]
fn what_cannot_be_prescribed() {
    let mut bodies = followed(Box::new(RapierEngine::new()), Box::new(harmonic()));
    let twice = bodies.prescribe(0, Box::new(harmonic()));
    assert_eq!(twice, Err(BodyError::PrescribedTwice { body: "led".to_owned() }));
    let unknown = bodies.prescribe(2, Box::new(harmonic()));
    assert_eq!(unknown, Err(BodyError::UnknownBody { index: 2, count: 2 }));
    // A series that ends ends the run, with its time.
    let short = series(times(5), |t| [t, 0.0, 0.0]).expect("valid");
    let mut bodies = followed(Box::new(RapierEngine::new()), Box::new(short));
    for step in 0..4 {
        bodies.do_step(f64::from(step) * 0.5, 0.5).expect("within");
    }
    let error = bodies.do_step(2.0, 0.5).expect_err("outside").to_string();
    assert!(error.contains("lasts from 0 to 2 s: nothing is known at 2.5 s"), "{error}");
}
