//! Waves from a piston against linear wavemaker theory (Biésel & Suquet 1951; Dean & Dalrymple,
//! Water Wave Mechanics, section 6.2): H/S = 2 sinh² kD / (sinh kD cosh kD + kD).

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

use nalgebra::{Point2, Vector2};
use seakeep_body::{BodyProperties, FreeDegrees, RapierEngine, RigidBodies};
use seakeep_coupler::FixedStepMaster;
use seakeep_coupler::interface::{BoundaryKinematics, MotionComponent};
use seakeep_fluid::Fluid;
use seakeep_fluid::network::Network;
use seakeep_fluid::setup::{
    DampingZone, Discretisation, FluidSetup, Integrator, Numerics, PressureSettings, RigidBoundary,
    Tank, Water,
};
use std::f64::consts::PI;

const DEPTH: f64 = 0.4;
const PERIOD: f64 = 1.2;
/// Steepness of the order of 1 %, so that linear theory holds.
const HEIGHT: f64 = 0.02;
/// Periods over which the paddle starts.
const RAMP: f64 = 2.0;

/// Wave number of the linear dispersion relation, 1/m.
fn wave_number() -> f64 {
    let omega = 2.0 * PI / PERIOD;
    let mut k = omega * omega / 9.81;
    for _ in 0..200 {
        k = omega * omega / (9.81 * (k * DEPTH).tanh());
    }
    k
}

/// X = S/2 sin ωt, started smoothly.
fn piston(time: f64) -> BoundaryKinematics {
    let (k, omega) = (wave_number() * DEPTH, 2.0 * PI / PERIOD);
    let stroke = HEIGHT * (k.sinh() * k.cosh() + k) / (2.0 * k.sinh() * k.sinh());
    let s = (time / (RAMP * PERIOD)).clamp(0.0, 1.0);
    let ds = if s < 1.0 { 1.0 / (RAMP * PERIOD) } else { 0.0 };
    // Quintic step, with its first two derivatives.
    let ramp = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
    let ramp1 = 30.0 * s * s * (1.0 - s) * (1.0 - s) * ds;
    let ramp2 = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) * ds * ds;
    let (sin, cos) = (omega * time).sin_cos();
    let a = 0.5 * stroke;
    let mut motion = BoundaryKinematics::at_rest(Point2::new(a * ramp * sin, 0.0), 0.0);
    motion.velocity.x = a * (ramp1 * sin + ramp * omega * cos);
    motion.acceleration.x =
        a * (ramp2 * sin + 2.0 * ramp1 * omega * cos - ramp * omega * omega * sin);
    motion
}

fn set_up(length: f64, spacing: f64, time_step: f64) -> (Fluid, RigidBodies, FixedStepMaster) {
    let corners = [(-0.3, 0.0), (0.0, 0.0), (0.0, 0.6), (-0.3, 0.6)];
    let setup = FluidSetup {
        tank: Tank { length, height: 0.6, paddle: Some(0) },
        water: Water { depth: DEPTH, density: 1000.0, kinematic_viscosity: 0.0, gravity: 9.81 },
        boundaries: vec![RigidBoundary {
            name: "paddle".to_owned(),
            corners: corners.map(|(x, y)| Vector2::new(x, y)).to_vec(),
            position: Point2::origin(),
            angle: 0.0,
            free: false,
        }],
        damping_zones: vec![DampingZone { inner_x: length - 4.0, outer_x: length, rate: 10.0 }],
        numerics: Numerics {
            particle_spacing: spacing,
            time_step,
            discretisation: Discretisation::Quadratic,
            integrator: Integrator::Midpoint,
            density_blend: 0.01,
        },
        pressure: PressureSettings::default(),
        network: Network::shipped().unwrap(),
    };
    let held = FreeDegrees { sway: false, heave: false, roll: false };
    let paddle =
        BodyProperties { free: held, ..BodyProperties::new("paddle", 1.0, 1.0, Point2::origin()) };
    let engine = Box::new(RapierEngine::new());
    let mut bodies = RigidBodies::new(vec![paddle], 9.81, engine).unwrap();
    bodies.prescribe(0, Box::new(piston)).unwrap();
    let mut fluid = Fluid::new(setup).unwrap();
    let motion: Option<&mut dyn MotionComponent> = Some(&mut bodies);
    let master = FixedStepMaster::start(0.0, time_step, &mut fluid, motion).unwrap();
    (fluid, bodies, master)
}

#[test]
fn a_piston_makes_the_wave_of_linear_theory() {
    const GAUGES: [f64; 3] = [1.6, 2.4, 3.2];
    let (spacing, step) = (0.04, 0.004);
    let (mut fluid, mut bodies, mut master) = set_up(8.0, spacing, step);
    let (from, to) = (7.0 * PERIOD, 9.0 * PERIOD);
    let omega = 2.0 * PI / PERIOD;
    let mut sums = [(0.0, 0.0); 3];
    while master.time() < to - 0.5 * step {
        master.step(&mut fluid, Some(&mut bodies)).unwrap();
        let t = master.time();
        if t > from + 0.5 * step {
            for (sum, x) in sums.iter_mut().zip(GAUGES) {
                let eta = fluid.surface_elevation(x).unwrap();
                sum.0 += eta * (omega * t).cos();
                sum.1 += eta * (omega * t).sin();
            }
        }
    }
    for ((c, s), x) in sums.into_iter().zip(GAUGES) {
        let amplitude = 2.0 * step / (to - from) * f64::hypot(c, s);
        let ratio = amplitude / (0.5 * HEIGHT);
        let lag = (s.atan2(c) - wave_number() * x + PI).rem_euclid(2.0 * PI) - PI;
        println!("x = {x} m: amplitude {ratio:.4} of theory's, phase {lag:+.4} rad off");
        assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
        assert!(lag.abs() < 0.05, "{lag}");
    }
}
