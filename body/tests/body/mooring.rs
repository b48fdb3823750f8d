//! Mooring lines against series and tables of other programs.
//!
//! The data and their provenance are in `cases/reference/mooring/`.

use crate::common::largest;
use nalgebra::{Point2, Vector2};
use seakeep_body::{
    BodyError, BodyProperties, Catenary, LineLaw, MooringLine, NewtonEulerEngine, RapierEngine,
    RigidBodies, RigidBodyEngine, Spring, UnknownTension, static_tensions,
};
use seakeep_coupler::interface::{BoundaryKinematics, Component, Load, MotionComponent};

const TWO_LINES: &str =
    include_str!("../../../cases/reference/mooring/two_line_vertical_moordyn.csv");
const CATENARY: &str = include_str!("../../../cases/reference/mooring/catenary.csv");

/// The header and the rows of a table, comments passed over.
fn table(text: &str) -> (Vec<&str>, Vec<Vec<f64>>) {
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let header = lines.next().expect("a header").split(',').collect();
    let row = |line: &str| line.split(',').map(|cell| cell.parse().expect("a number")).collect();
    (header, lines.map(row).collect())
}

/// The two lines of the reference: depth 0.6 m, still-water line at y = 0.6 m.
fn two_lines() -> [MooringLine; 2] {
    [-0.2, 0.2].map(|x| MooringLine {
        fairlead: Vector2::new(x, -0.075),
        anchor: Point2::new(x, 0.0),
        law: LineLaw::Spring(Spring::pretensioned(1.2e5, 0.45, 88.29, 0.0).expect("valid")),
    })
}

/// MoorDyn 2.7.2 with one segment a line, over a prescribed motion, slack included.
#[test]
fn light_springs_follow_moordyn() {
    let (header, rows) = table(TWO_LINES);
    let place = |name: &str| header.iter().position(|column| *column == name).expect("there");
    let columns = ["sway", "heave", "roll"].map(place);
    let tensions = ["T1_moordyn", "T2_moordyn"].map(place);
    let loads = ["Fx_moordyn", "Fz_moordyn", "My_moordyn"].map(place);
    let lines = two_lines();
    let (mut squares, mut sum, mut worst, mut slack) = (0.0, 0.0, 0.0_f64, 0);
    let mut load_errors = [0.0_f64; 3];
    for row in &rows {
        let [sway, heave, roll] = columns.map(|column| row[column]);
        // The reference's roll is clockwise.
        let pose = BoundaryKinematics::at_rest(Point2::new(sway, 0.525 + heave), -roll);
        for (line, tension) in lines.iter().zip(tensions) {
            let (found, known) = (line.at(&pose).tension, row[tension]);
            squares += (found - known).powi(2);
            sum += known.powi(2);
            worst = worst.max((found - known).abs());
            slack += usize::from(found == 0.0);
        }
        let total = lines.map(|line| line.load_on(&pose));
        let found = [
            total[0].force.x + total[1].force.x,
            total[0].force.y + total[1].force.y,
            -(total[0].torque + total[1].torque),
        ];
        for ((error, found), column) in load_errors.iter_mut().zip(found).zip(loads) {
            *error = error.max((found - row[column]).abs());
        }
    }
    let relative = f64::sqrt(squares / sum);
    println!(
        "tension: {relative:.2e} rms of its rms, {worst:.2e} N/m at most; {slack} of {} samples \
         slack; Fx, Fy, torque: {load_errors:?} at most",
        2 * rows.len()
    );
    assert!(relative < 1e-4 && worst < 0.01);
    assert!((100..130).contains(&slack), "4.5 and 9.7 % of the time they are slack: {slack}");
    // MoorDyn's line weighs 0.01 N, a part of which it adds to the vertical force.
    assert!(load_errors[0] < 1e-3 && load_errors[1] < 0.02 && load_errors[2] < 2e-3);
}

/// MoorPy 1.3.0, and an independent elastic catenary, to all their digits.
#[test]
fn catenary_agrees_with_moorpy() {
    let (header, rows) = table(CATENARY);
    let place = |name: &str| header.iter().position(|column| *column == name).expect("there");
    // Submerged weight of a chain of 0.1 kg/m and 4 mm in water of 1000 kg/m3.
    let weight = (0.1 - 1000.0 * std::f64::consts::FRAC_PI_4 * 0.004 * 0.004) * 9.81;
    let law = LineLaw::Catenary(Catenary::new(1e4, weight, 1.55, true).expect("valid"));
    let mut worst = [0.0_f64; 3];
    for row in &rows {
        let span = Vector2::new(row[place("X_m")], row[place("Z_m")]);
        for side in [-1.0, 1.0] {
            let anchor = Point2::new(3.0 - side * span.x, 0.0);
            let line = MooringLine { fairlead: Vector2::zeros(), anchor, law };
            let body = BoundaryKinematics::at_rest(Point2::new(3.0, span.y), 0.0);
            let found = line.at(&body);
            assert!(found.force.x * side < 0.0 && found.force.y < 0.0);
            for (worst, (value, name)) in worst.iter_mut().zip([
                (found.force.x.abs(), "H_moorpy"),
                (found.force.y.abs(), "V_moorpy"),
                (found.tension, "T_moorpy"),
            ]) {
                *worst = worst.max((value / row[place(name)].abs() - 1.0).abs());
            }
        }
    }
    println!("H, V, T: relative errors {worst:?} at most");
    assert!(worst.iter().all(|error| *error < 1e-6));
}

/// The catenary's ends, found by following the line from the fairlead down with its tension:
/// dx = (H/T)(1 + T/EA) ds, dv = −w ds, in small pieces.
fn followed(law: &Catenary, force: Vector2<f64>) -> (Vector2<f64>, f64) {
    let pieces = 200_000;
    let ds = law.unstretched_length / f64::from(pieces);
    let (h, mut v) = (force.x.abs(), force.y);
    let (mut end, mut length) = (Vector2::zeros(), 0.0);
    for _ in 0..pieces {
        let middle = v - 0.5 * law.weight * ds;
        let middle = if law.anchored_on_bed { middle.max(0.0) } else { middle };
        let tension = h.hypot(middle);
        let stretched = ds * (1.0 + tension / law.axial_stiffness);
        let direction =
            if tension > 0.0 { Vector2::new(h, middle) / tension } else { Vector2::x() };
        end += direction * stretched;
        length += stretched;
        v -= law.weight * ds;
    }
    (end, length)
}

#[test]
fn every_shape_of_a_catenary_is_in_equilibrium() {
    for (x, z, axial, length, on_bed, shape) in [
        (1.4, 0.45, 1e4, 1.55, true, "partly on the bed"),
        (1.0, 0.45, 1e4, 1.55, true, "straight down, the rest on the bed"),
        (1.53, 0.45, 1e4, 1.55, true, "just lifted"),
        (1.6, 0.45, 2e2, 1.55, true, "stretched"),
        (1.0, 0.3, 1e3, 1.55, false, "sagging below both ends"),
        (1.0, -0.6, 1e3, 1.55, false, "fairlead below the anchor"),
        (0.0, 0.9, 1e3, 0.88, false, "upright and taut"),
        (0.0, 0.5, 1e3, 1.55, false, "upright and slack"),
        (1e-9, 0.9, 1e3, 0.88, true, "almost upright"),
        (50.0, 8.0, 1e9, 50.9, true, "long and stiff"),
    ] {
        let catenary = Catenary::new(axial, 0.858, length, on_bed).expect("valid");
        let line = MooringLine {
            fairlead: Vector2::zeros(),
            anchor: Point2::new(0.0, 0.0),
            law: LineLaw::Catenary(catenary),
        };
        let found = line.at(&BoundaryKinematics::at_rest(Point2::new(x, z), 0.0));
        let (end, along) = followed(&catenary, -found.force);
        println!("{shape}: {found:?}, off by {:?}", end - Vector2::new(x, z));
        // What lies slack on the bed may lie anywhere there.
        let slack = found.force.x == 0.0 && on_bed;
        if !slack {
            assert!((end.x - x).abs() < 2e-5 * length, "{shape}: x = {}", end.x);
        }
        assert!((end.y - z).abs() < 2e-5 * length, "{shape}: z = {}", end.y);
        assert!((along - found.length).abs() < 2e-5 * length, "{shape}: {along}");
    }
}

#[test]
fn a_spring_meets_its_pretension() {
    let spring = Spring::pretensioned(100.0, 2.0, 50.0, 0.0).expect("valid");
    assert_eq!(spring.unstretched_length, 1.5);
}

#[test]
fn bad_lines_are_refused() {
    let bad = [
        Spring::new(0.0, 1.0, 0.0).map(|_| ()),
        Spring::new(1.0, -1.0, 0.0).map(|_| ()),
        Spring::new(1.0, 1.0, f64::NAN).map(|_| ()),
        Spring::pretensioned(100.0, 1.0, 100.0, 0.0).map(|_| ()),
        Catenary::new(1e4, 0.0, 1.0, true).map(|_| ()),
        Catenary::new(f64::INFINITY, 1.0, 1.0, true).map(|_| ()),
    ];
    for result in bad {
        assert!(matches!(result, Err(BodyError::Line { .. })), "{result:?}");
    }
}

/// A spring of stiffness k with damping c on a mass m: x″ + (c/m) x′ + (k/m) x = 0 while taut.
#[test]
fn a_damped_line_swings_as_an_oscillator() {
    let (mass, k, c) = (42.0_f64, 3924.0_f64, 80.0_f64);
    let (rate, omega) = (0.5 * c / mass, f64::sqrt(k / mass - (0.5 * c / mass).powi(2)));
    for engine in engines() {
        let line = MooringLine {
            fairlead: Vector2::new(0.0, -0.1),
            anchor: Point2::new(0.0, 0.0),
            law: LineLaw::Spring(Spring::pretensioned(k, 0.9, 500.0, c).expect("valid")),
        };
        let mut body = BodyProperties::new("box", mass, 1.5, Point2::new(0.0, 1.05));
        body.velocity.y = -rate * 0.05;
        let mut bodies = RigidBodies::new(vec![body], 0.0, engine).expect("valid");
        bodies.add_own_load(0, Box::new(line)).expect("the body exists");
        let up = |_: f64, _: &BoundaryKinematics| Load { force: Vector2::y() * 500.0, torque: 0.0 };
        bodies.add_own_load(0, Box::new(up)).expect("the body exists");
        bodies.enter_initialization_mode(0.0).expect("finite");
        bodies.exit_initialization_mode().expect("initialized");
        let h = 1e-3;
        let error = largest((0..2000).map(|step| {
            bodies.do_step(f64::from(step) * h, h).expect("a good step");
            let t = f64::from(step + 1) * h;
            let exact = 1.0 + 0.05 * (-rate * t).exp() * (omega * t).cos();
            bodies.kinematics()[0].position.y - exact
        }));
        println!("{error:e} m of 0.05 m");
        assert!(error < 1e-5);
    }
}

fn engines() -> [Box<dyn RigidBodyEngine>; 2] {
    [Box::new(RapierEngine::new()), Box::new(NewtonEulerEngine::new())]
}

/// The breakwater of the paper on its two lines, without water, its buoyancy held: the engines
/// move it alike, in sway, heave and roll, through slack lines too.
#[test]
fn swapping_the_engine_changes_little() {
    let run = |engine: Box<dyn RigidBodyEngine>, substeps: usize| -> Vec<[f64; 3]> {
        let mut body = BodyProperties::new("box", 42.0, 0.64, Point2::new(0.01, 0.526));
        body.velocity.y = 0.08;
        body.angular_velocity = 0.05;
        let mut bodies = RigidBodies::new(vec![body], 9.81, engine)
            .expect("valid")
            .with_substeps(substeps)
            .expect("substeps");
        for line in two_lines() {
            bodies.add_own_load(0, Box::new(line)).expect("the body exists");
        }
        let buoyancy = |_: f64, _: &BoundaryKinematics| Load {
            force: Vector2::y() * (42.0 * 9.81 + 2.0 * 88.29),
            torque: 0.0,
        };
        bodies.add_own_load(0, Box::new(buoyancy)).expect("the body exists");
        bodies.enter_initialization_mode(0.0).expect("finite");
        bodies.exit_initialization_mode().expect("initialized");
        (0..600)
            .map(|step| {
                bodies.do_step(f64::from(step) * 1.5e-3, 1.5e-3).expect("a good step");
                let now = bodies.kinematics()[0];
                [now.position.x, now.position.y - 0.525, now.angle]
            })
            .collect()
    };
    let amplitude = |record: &[[f64; 3]], degree: usize| largest(record.iter().map(|p| p[degree]));
    let mut last = [f64::INFINITY; 3];
    for substeps in [2, 8] {
        let [rapier, newton] = engines().map(|engine| run(engine, substeps));
        let difference: [f64; 3] = std::array::from_fn(|degree| {
            let pairs = rapier.iter().zip(&newton);
            largest(pairs.map(|(a, b)| a[degree] - b[degree])) / amplitude(&newton, degree)
        });
        println!("{substeps} substeps: sway, heave, roll differ by {difference:?}");
        assert!(difference.iter().zip(last).all(|(now, before)| *now < before));
        last = difference;
    }
    assert!(last.iter().all(|difference| *difference < 0.003), "{last:?}");
}

#[test]
fn static_tensions_balance_the_load() {
    let line = |x: f64, anchor: f64| UnknownTension {
        arm: Vector2::new(x, -0.075),
        direction: Vector2::new(anchor - x, -0.45),
    };
    let up = |force: f64, torque: f64| Load { force: Vector2::y() * force, torque };
    let free = [true; 3];
    // The paper's: half the buoyancy that is left over on each.
    let found = static_tensions(&[line(-0.2, -0.2), line(0.2, 0.2)], &up(176.58, 0.0), free);
    let found = found.expect("they hold it");
    assert!(found.iter().all(|tension| (tension - 88.29).abs() < 1e-9), "{found:?}");
    // Off the middle the moment makes the difference.
    let found = static_tensions(&[line(-0.2, -0.2), line(0.2, 0.2)], &up(100.0, 4.0), free);
    assert!((found.expect("they hold it")[0] - 40.0).abs() < 1e-9);
    // Four lines share, with the least sum of squares.
    let four = [line(-0.2, -0.2), line(-0.2, -0.2), line(0.2, 0.2), line(0.2, 0.2)];
    let found = static_tensions(&four, &up(176.58, 0.0), free).expect("they hold it");
    assert!(found.iter().all(|tension| (tension - 44.145).abs() < 1e-9), "{found:?}");
    // One slanted line cannot; a body that sinks would have to be pushed.
    assert_eq!(static_tensions(&[line(0.2, 0.6)], &up(50.0, 0.0), free), None);
    assert_eq!(static_tensions(&[line(0.0, 0.0)], &up(-50.0, 0.0), free), None);
    assert!(static_tensions(&[line(0.2, 0.6)], &up(50.0, 0.0), [false, true, false]).is_some());
}
