//! A column of water of 0.6 m by 0.3 m falls, runs out and hits the end wall: the experiment of
//! Lobovský et al. (2014), J. Fluids Struct. 48, 407 (`cases/reference/lobovsky2014`), up to the impact,
//! and bounds that any water keeps after it.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

use nalgebra::{Point2, Vector2};
use seakeep_coupler::interface::Component;
use seakeep_fluid::Fluid;
use seakeep_fluid::network::Network;
use seakeep_fluid::setup::{
    Discretisation, FluidSetup, InitialFlow, Integrator, Numerics, PressureSettings, Tank, Water,
};

const DEPTH: f64 = 0.3;
const SPACING: f64 = 0.015;
const STEP: f64 = 0.001;

struct Column;

impl InitialFlow for Column {
    fn elevation(&self, _x: f64) -> f64 {
        0.0
    }

    fn velocity(&self, _point: Point2<f64>) -> Vector2<f64> {
        Vector2::zeros()
    }

    fn reach(&self) -> Option<f64> {
        Some(0.6)
    }
}

fn column() -> Fluid {
    let setup = FluidSetup {
        tank: Tank { length: 1.61, height: 1.2, paddle: None },
        water: Water { depth: DEPTH, density: 1000.0, kinematic_viscosity: 0.0, gravity: 9.81 },
        boundaries: Vec::new(),
        damping_zones: Vec::new(),
        numerics: Numerics {
            particle_spacing: SPACING,
            time_step: STEP,
            discretisation: Discretisation::Quadratic,
            integrator: Integrator::Midpoint,
            density_blend: 0.01,
        },
        pressure: PressureSettings::default(),
        network: Network::shipped().unwrap(),
    };
    let mut fluid = Fluid::flowing(setup, &Column).unwrap();
    fluid.enter_initialization_mode(0.0).unwrap();
    fluid.exit_initialization_mode().unwrap();
    fluid
}

fn energy(fluid: &Fluid) -> f64 {
    let found = fluid.diagnostics();
    found.kinetic_energy + found.potential_energy
}

fn run(fluid: &mut Fluid, until: f64) {
    while fluid.time() < until - 0.5 * STEP {
        let time = fluid.time();
        fluid.do_step(time, STEP).unwrap();
    }
}

#[test]
fn the_water_runs_out_as_measured_and_keeps_its_energy() {
    let mut fluid = column();
    let start = energy(&fluid);
    // Level at x = 0.3 m, m, read off the record of gauge H1.
    for (time, level) in [(0.2, 0.272), (0.3, 0.247), (0.4, 0.222)] {
        run(&mut fluid, time);
        let found = fluid.surface_elevation(0.3).unwrap() + DEPTH;
        assert!((found / level - 1.0).abs() < 0.04, "{found} m, not {level} m, at {time} s");
        let kept = energy(&fluid) / start;
        assert!((kept - 1.0).abs() < 5e-3, "{kept} of the energy at {time} s");
    }
    assert_eq!(fluid.surface_elevation(1.605), Some(-DEPTH), "the end is still dry");
    // Sensor 1, at the foot of the end wall, feels the front at 0.427 s; the gate takes some of that.
    let arrived = |fluid: &Fluid| fluid.surface_elevation(1.605) != Some(-DEPTH);
    while !arrived(&fluid) {
        let next = fluid.time() + STEP;
        run(&mut fluid, next);
    }
    assert!((0.39..0.45).contains(&fluid.time()), "{} s", fluid.time());
}

#[test]
fn the_impact_neither_makes_energy_nor_loses_water() {
    let mut fluid = column();
    let start = energy(&fluid);
    let count = fluid.diagnostics().particles_active as f64;
    let mut highest = start;
    // To t √(g/H) = 15.
    while fluid.time() < 2.62 {
        let next = fluid.time() + 0.02;
        run(&mut fluid, next);
        highest = highest.max(energy(&fluid));
    }
    let found = fluid.diagnostics();
    assert!(highest < 1.05 * start, "{highest} J/m from {start} J/m");
    assert!(found.max_speed < 5.0, "{} m/s", found.max_speed);
    assert!(found.particles_lost as f64 <= 0.01 * count, "{found:?}");
    let added = found.particles_active as f64 / count - 1.0;
    assert!(added.abs() < 0.1, "{added} more particles");
}
