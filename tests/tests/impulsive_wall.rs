//! The pressure equation against an exact solution: a wall from bed to surface that is set in
//! motion in water at rest (Westergaard 1933; Lamb, Hydrodynamics, § 231 has the series).
//!
//! With p = 0 on the surface, ∂p/∂x = −ρ at the wall and no flux through bed and far end at
//! distance ℓ, its added mass is Σ 2 ρ / (k³ D) coth(k ℓ), k = (n − ½) π / D: 0.5427 ρ D² a side.
//! Where wall and surface meet, the pressure goes as r log r: first order at worst.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

use nalgebra::{Point2, Vector2};
use seakeep_coupler::interface::{Component, LoadComponent};
use seakeep_fluid::Fluid;
use seakeep_fluid::network::Network;
use seakeep_fluid::setup::{
    Discretisation, FluidSetup, Integrator, Numerics, PressureSettings, RigidBoundary, Tank, Water,
};
use std::f64::consts::PI;

const DEPTH: f64 = 0.4;
const HALF_WIDTH: f64 = 0.1;
const LENGTH: f64 = 2.2;

fn exact() -> f64 {
    let side = LENGTH / 2.0 - HALF_WIDTH;
    let terms = (1..200).map(|n| {
        let k = (f64::from(n) - 0.5) * PI / DEPTH;
        2.0 * 1000.0 / (k.powi(3) * DEPTH) / (k * side).tanh()
    });
    2.0 * terms.sum::<f64>()
}

/// The added mass in sway of a block that stands on the bed and out of the water, kg/m.
fn found(spacing: f64) -> f64 {
    let corners = [(-1.0, 0.0), (1.0, 0.0), (1.0, 0.5), (-1.0, 0.5)];
    let setup = FluidSetup {
        tank: Tank { length: LENGTH, height: 0.6, paddle: None },
        water: Water { depth: DEPTH, density: 1000.0, kinematic_viscosity: 0.0, gravity: 9.81 },
        boundaries: vec![RigidBoundary {
            name: "wall".to_owned(),
            corners: corners.map(|(x, y)| Vector2::new(x * HALF_WIDTH, y)).to_vec(),
            position: Point2::new(0.5 * LENGTH, 0.0),
            angle: 0.0,
            free: true,
        }],
        damping_zones: Vec::new(),
        numerics: Numerics {
            particle_spacing: spacing,
            time_step: 0.1 * spacing,
            discretisation: Discretisation::Quadratic,
            integrator: Integrator::Midpoint,
            density_blend: 0.01,
        },
        pressure: PressureSettings { tolerance: 1e-8, ..PressureSettings::default() },
        network: Network::shipped().unwrap(),
    };
    let mut fluid = Fluid::new(setup).unwrap();
    fluid.enter_initialization_mode(0.0).unwrap();
    fluid.exit_initialization_mode().unwrap();
    let response = fluid.solve_load(0.0, 0.1 * spacing).unwrap();
    response.added_mass[(0, 0)]
}

#[test]
fn the_added_mass_of_a_wall_converges_to_the_exact_one() {
    let errors = [0.04, 0.02, 0.01].map(|spacing| found(spacing) / exact() - 1.0);
    // Far from the ends the series is 0.5427 (16 ζ(3) (1 − 2⁻³) / π³).
    assert!((exact() / (2.0 * 0.5427 * 1000.0 * DEPTH * DEPTH) - 1.0).abs() < 1e-3);
    // Measured: 0.26 %, 0.25 %, 0.064 %.
    for (error, bound) in errors.iter().zip([0.005, 0.004, 0.0015]) {
        assert!(error.abs() < bound, "{errors:?}");
    }
    assert!(errors[2].abs() < 0.5 * errors[0].abs(), "{errors:?}");
}
