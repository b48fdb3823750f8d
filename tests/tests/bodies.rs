//! The paper's box against linear potential theory and hydrostatics, mostly at 20 particles over the
//! depth: the finer runs are `cases/heave_decay.toml` and `cases/buoyancy.toml`.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

use nalgebra::Vector2;
use seakeep::analysis::hydrostatics::buoyancy;
use seakeep::geometry::placed;
use seakeep::simulation::Simulation;
use seakeep_coupler::interface::{BoundaryKinematics, Component, LoadComponent};
use seakeep_fluid::Fluid;
use seakeep_tests::{Coupled, case};
use std::f64::consts::{FRAC_2_PI, TAU};

const BOX: &str = r#"
end_time_s = 1.0

[tank]
length_m = 4.0
height_m = 0.6

[water]
depth_m = 0.4

[numerics]
particle_spacing_m = 0.02

[[body]]
box = { width_m = 0.30, height_m = 0.20 }
position_m = [2.0, 0.4]
mass_kg_m = 30.0
inertia_kg_m2_m = 0.325
"#;

/// Columns of the reference: frequency (rad/s), A11, A33, A55, A15, B33.
const REFERENCE: &str = include_str!("../reference/box_linear_potential.csv");

fn reference() -> Vec<[f64; 6]> {
    let rows = REFERENCE.lines().filter(|line| !line.starts_with('#')).skip(1);
    rows.map(|row| {
        let numbers: Vec<f64> = row.split(',').map(|number| number.parse().unwrap()).collect();
        numbers.try_into().unwrap()
    })
    .collect()
}

#[test]
fn the_added_mass_is_that_of_potential_flow() {
    let mut run = Coupled::start(&case(BOX, &["numerics.particle_spacing_m=0.01"]));
    run.steps(1);
    let found = run.fluid.added_mass();
    let [frequency, a11, a33, a55, a15, _] = *reference().last().unwrap();
    assert!(frequency.is_infinite());
    // At 40 particles over the depth. The corners of the box are singular: p goes as r^(2/3)
    // there, with which a second-order scheme loses 1 % in heave, 3 % in roll and 6 % or more in the
    // coupling of sway and roll, the small difference of two sides. Measured with the corners'
    // own function in the fits: +0.2 %, +0.1 %, -0.1 %, -2.1 % (without: -1.1, -0.4, -4.5, -16 %).
    for (name, found, exact, tolerance) in [
        ("sway", found[(0, 0)], a11, 0.01),
        ("heave", found[(1, 1)], a33, 0.01),
        ("roll", found[(2, 2)], a55, 0.02),
        ("sway from roll", found[(0, 2)], a15, 0.05),
    ] {
        assert!((found / exact - 1.0).abs() < tolerance, "{name}: {found}, theory {exact}");
    }
    // The scheme is not symmetric by construction: an error like those above. Measured: 0.008
    // between sway and roll, 1e-7 with heave, which symmetry about the middle keeps apart.
    for (i, j, bound) in [(0, 1, 1e-4), (1, 2, 1e-4), (0, 2, 0.02)] {
        let scale = (found[(i, i)] * found[(j, j)]).sqrt();
        let asymmetry = (found[(i, j)] - found[(j, i)]).abs() / scale;
        assert!(asymmetry < bound, "{i} {j}: {asymmetry}")
    }
}

#[test]
fn a_tilted_box_feels_hydrostatics() {
    for angle in [5.0, 15.0] {
        let angle_key = format!("body.angle_deg={angle}");
        let case = case(
            BOX,
            &[
                &angle_key,
                "body.free=[]",
                "tank.length_m=2.0",
                "body.position_m=[1.0, 0.4]",
                "end_time_s=0.5",
            ],
        );
        let scene = &case.scene;
        let boundary = &scene.fluid.boundaries[0];
        let corners = placed(&boundary.corners, boundary.position, boundary.angle);
        let exact = buoyancy(&corners, 0.4, 1000.0, 9.81, boundary.position);
        let mut run = Simulation::start(scene).unwrap();
        let (mut force, mut moment, mut count) = (0.0, 0.0, 0.0);
        for step in 0..scene.steps {
            run.step().unwrap();
            let load = run.sample(scene).loads[0];
            if step >= scene.steps / 2 {
                force += load.force.y;
                moment += load.torque;
                count += 1.0;
            }
        }
        let (force, moment) = (force / count / exact.force, moment / count / exact.moment);
        // Water at rest has no dynamic pressure, and wall particles with their wetted parts add up
        // to the outline exactly but for the pieces that the surface cuts. Measured: 1e-15 in
        // force, 7e-4 in moment.
        assert!((force - 1.0).abs() < 0.01, "{angle} degrees: force {force} of the exact one");
        assert!((moment - 1.0).abs() < 0.03, "{angle} degrees: moment {moment} of the exact one");
    }
}

/// Amplitude of the first harmonic of `values` at times (s) over whole periods of `period` (s).
fn amplitude(values: impl Iterator<Item = (f64, f64)>, period: f64) -> f64 {
    let (mut sum, mut count) = (Vector2::zeros(), 0.0);
    for (t, value) in values {
        let phase = TAU * t / period;
        sum += Vector2::new(phase.cos(), phase.sin()) * value;
        count += 1.0;
    }
    2.0 / count * sum.norm()
}

/// The moment is the small difference of the bottom's and the sides', 80 N m/m each: a pressure
/// that asks in vain for what earlier steps have left would add 10 to it.
#[test]
fn a_held_box_in_small_waves_feels_the_loads_of_linear_theory() {
    let (height, period) = (0.004, 1.2);
    let case = case(
        BOX,
        &[
            "tank.length_m=6.0",
            "body.position_m=[2.5, 0.4]",
            "body.free=[]",
            "wave.kind=\"stream_function\"",
            "wave.height_m=0.004",
            "wave.period_s=1.2",
            "wavemaker.type=\"piston\"",
            "wavemaker.active_absorption={}",
            "damping_zone=[{ inner_x_m = 3.4, outer_x_m = 6.0, rate_per_s = 10.5 }]",
            "numerics.particle_spacing_m=0.025",
            "numerics.time_step_s=0.005",
            "end_time_s=7.2",
        ],
    );
    let scene = &case.scene;
    let mut run = Simulation::start(scene).unwrap();
    let mut loads = Vec::new();
    for step in 1..=scene.steps {
        run.step().unwrap();
        let now = step as f64 * scene.time_step();
        if now > 7.2 - 2.0 * period + 1e-9 {
            let load = run.sample(scene).loads[0];
            loads.push((now, [load.force.x, load.force.y, load.torque]));
        }
    }
    // The wave's exciting loads per metre of its amplitude on the box held in place, of the
    // reference's solution at this period; sides and bottom are equally far from it.
    for (k, name, theory, tolerance) in [
        (0, "horizontal force, N/m²", 1517.94, 60.0),
        (1, "vertical force, N/m²", 1919.38, 40.0),
        (2, "moment, N/m", 2.5746, 1.2),
    ] {
        let found = amplitude(loads.iter().map(|(t, load)| (*t, load[k])), period) / (0.5 * height);
        // Measured at 16 particles over the depth: 1560, 1923 and 3.4; with the whole pressure 1594,
        // 1889 and 12.7.
        assert!((found - theory).abs() < tolerance, "{name}: {found}, theory {theory}");
    }
}

/// Heave (m) at `times` steps of `h` (s) after a release at rest 10 mm above equilibrium, by
/// linear theory with memory (Cummins 1962): (M + A∞) x″ + ∫ K(t − τ) x′(τ) dτ + ρ g b x = 0,
/// K(t) = 2/π ∫ B33 cos ωt dω. Leapfrog, the integrals by the midpoint and trapezoidal rules.
fn heave_of_linear_theory(steps: usize, h: f64) -> Vec<f64> {
    let rows = reference();
    let (limit, rows) = rows.split_last().unwrap();
    let memory = |t: f64| -> f64 {
        let value = |row: &[f64; 6]| row[5] * (row[0] * t).cos();
        // B33 is level below the first frequency.
        let low = rows[0][5] * rows[0][0];
        let pairs = rows.windows(2);
        let sum: f64 =
            pairs.map(|p| 0.5 * (value(&p[0]) + value(&p[1])) * (p[1][0] - p[0][0])).sum();
        FRAC_2_PI * (low + sum)
    };
    let kernel: Vec<f64> = (0..steps).map(|k| memory((k as f64 + 0.5) * h)).collect();
    let (mass, stiffness) = (30.0 + limit[2], 1000.0 * 9.81 * 0.3);
    let mut heave = vec![0.01];
    let mut speeds: Vec<f64> = Vec::new();
    for n in 0..steps {
        let past: f64 = speeds.iter().rev().zip(&kernel).map(|(v, k)| v * k * h).sum();
        let acceleration = -(stiffness * heave[n] + past) / mass;
        // At rest at the start: half a step of acceleration to the first half step.
        let part = if n == 0 { 0.5 } else { 1.0 };
        let speed = speeds.last().unwrap_or(&0.0) + part * h * acceleration;
        speeds.push(speed);
        heave.push(heave[n] + h * speed);
    }
    heave
}

/// Number (with a fraction) of the first sample below zero, and number and value of the least.
fn swing(heave: &[f64]) -> (f64, f64, f64) {
    let first = heave.iter().position(|x| *x < 0.0).unwrap();
    let crossing = first as f64 - heave[first] / (heave[first] - heave[first - 1]);
    let (lowest, least) = heave.iter().enumerate().min_by(|a, b| a.1.total_cmp(b.1)).unwrap();
    (crossing, lowest as f64, *least)
}

#[test]
fn a_box_released_above_its_equilibrium_heaves_as_linear_theory_says() {
    let case = case(
        BOX,
        &["body.position_m=[2.0, 0.41]", "body.equilibrium_m=[2.0, 0.4]", "body.free=[\"heave\"]"],
    );
    let mut run = Coupled::start(&case);
    let (steps, h) = (case.scene.steps as usize, case.scene.time_step());
    let exact = heave_of_linear_theory(steps, h);
    let mut heave = vec![0.01];
    for _ in 0..steps {
        run.steps(1);
        heave.push(0.01 + run.heave());
    }
    let (found, theory) = (swing(&heave), swing(&exact));
    // At half a spacing of amplitude and 20 particles over the depth. Measured: 3.2 % late at the
    // crossing, 3.7 % at the trough, 5.5 % less deep, 1.1 mm apart at most (at 40 over the depth:
    // 2.3 %, 2.2 %, 4.7 %); the heave added mass alone is 2.4 % off.
    for (name, found, theory, tolerance) in [
        ("steps to the crossing", found.0, theory.0, 0.05),
        ("steps to the trough", found.1, theory.1, 0.05),
        ("trough in m", found.2, theory.2, 0.08),
    ] {
        assert!((found / theory - 1.0).abs() < tolerance, "{name}: {found}, theory {theory}");
    }
    let worst = heave.iter().zip(&exact).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(worst < 0.13 * heave[0], "up to {worst} m apart");
}

/// A held box that is drawn up at 1 m/s² until it has left the water: the load goes to zero, and
/// the solve for a pressure that is zero then ends at once.
#[test]
fn a_box_may_leave_the_water() {
    let narrow = [
        "tank.length_m=0.8",
        "body.position_m=[0.4, 0.49]",
        "body.box={ width_m = 0.06, height_m = 0.20 }",
        "tank.height_m=1.0",
    ];
    let case = case(BOX, &narrow);
    let mut fluid = Fluid::flowing(case.scene.fluid.clone(), &case.scene.initial_water).unwrap();
    let h = case.scene.time_step();
    fluid.enter_initialization_mode(0.0).unwrap();
    fluid.exit_initialization_mode().unwrap();
    let start = BoundaryKinematics::at_rest(case.scene.fluid.boundaries[0].position, 0.0);
    let mut dry = 0;
    for step in 0..200 {
        let now = f64::from(step) * h;
        let mut kinematics = start;
        kinematics.position.y += 0.5 * now * now;
        kinematics.velocity.y = now;
        kinematics.acceleration.y = 1.0;
        fluid.set_kinematics(&[kinematics]);
        let added_mass = fluid.solve_load(now, h).unwrap().added_mass[(1, 1)];
        fluid.set_accelerations(&[0.0, 1.0, 0.0]);
        fluid.do_step(now, h).unwrap();
        if added_mass == 0.0 {
            dry += 1;
            assert_eq!(fluid.loads()[0].force.norm(), 0.0);
        }
    }
    assert!(dry > 20, "dry for {dry} steps");
}
