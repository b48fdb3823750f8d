//! A standing wave with either discretisation and either integrator, against linear theory: period,
//! and the energy that the paper's step takes from a wave, π ω dt a period; and what the guard of the
//! network makes of it.
//!
//! One wavelength in a tank of 2 m, depth 0.5 m, amplitude 0.02 m, D/dx = 20, dt = 2.5 ms.

use crate::error::FluidError;
use crate::fluid::Fluid;
use crate::network::Network;
use crate::pressure;
use crate::pressure::solver::{PressureReport, PressureSettings, SolverKind};
use crate::setup::{Discretisation, FluidSetup, InitialFlow, Integrator, Numerics, Tank, Water};
use nalgebra::{Point2, Vector2};
use std::f64::consts::PI;

const DEPTH: f64 = 0.5;
const LENGTH: f64 = 2.0;
const AMPLITUDE: f64 = 0.02;
const WAVE_NUMBER: f64 = 2.0 * PI / LENGTH;
const GRAVITY: f64 = 9.81;
const TIME_STEP: f64 = 0.0025;

struct StandingWave;

impl InitialFlow for StandingWave {
    fn elevation(&self, x: f64) -> f64 {
        AMPLITUDE * (WAVE_NUMBER * x).cos()
    }

    fn velocity(&self, _point: Point2<f64>) -> Vector2<f64> {
        Vector2::zeros()
    }
}

/// ω of linear theory, rad/s.
fn frequency() -> f64 {
    (GRAVITY * WAVE_NUMBER * (WAVE_NUMBER * DEPTH).tanh()).sqrt()
}

/// Energy, J/m, and amplitude of the wave, m.
fn energy_and_amplitude(fluid: &Fluid) -> (f64, f64) {
    let found = fluid.diagnostics();
    let particles = &fluid.state.particles;
    let surface = particles.position.iter().zip(&particles.on_surface).filter(|(_, on)| **on);
    let (sum, count) = surface.fold((0.0, 0.0), |(sum, count), (x, _)| {
        (sum + (x.y - DEPTH) * (WAVE_NUMBER * x.x).cos(), count + 1.0)
    });
    (found.kinetic_energy + found.potential_energy, 2.0 * sum / count)
}

/// Relative energy loss a period and relative error of the period over `periods` periods.
fn setup(discretisation: Discretisation, integrator: Integrator) -> FluidSetup {
    FluidSetup {
        tank: Tank { length: LENGTH, height: 0.6, paddle: None },
        water: Water { depth: DEPTH, density: 1000.0, kinematic_viscosity: 0.0, gravity: GRAVITY },
        boundaries: Vec::new(),
        damping_zones: Vec::new(),
        numerics: Numerics {
            particle_spacing: 0.025,
            time_step: TIME_STEP,
            discretisation,
            integrator,
            density_blend: 0.01,
        },
        pressure: PressureSettings::default(),
        network: Network::shipped().expect("the shipped network"),
    }
}

fn run(
    discretisation: Discretisation,
    integrator: Integrator,
    periods: usize,
) -> Result<(f64, f64), FluidError> {
    let mut fluid = Fluid::flowing(setup(discretisation, integrator), &StandingWave)?;
    let exact = 2.0 * PI / frequency();
    let steps = (periods as f64 * exact / TIME_STEP).round() as usize;
    let (start, mut last) = energy_and_amplitude(&fluid);
    let mut crossings = Vec::new();
    for step in 0..steps {
        fluid.solve(TIME_STEP)?;
        fluid.finish(TIME_STEP)?;
        let (_, amplitude) = energy_and_amplitude(&fluid);
        if last * amplitude < 0.0 {
            crossings.push((step as f64 + last / (last - amplitude)) * TIME_STEP);
        }
        last = amplitude;
    }
    let (end, _) = energy_and_amplitude(&fluid);
    let half_periods = (crossings.len() - 1) as f64;
    let period = 2.0 * (crossings[crossings.len() - 1] - crossings[0]) / half_periods;
    Ok(((start / end).ln() / periods as f64, period / exact - 1.0))
}

const BOTH: [Discretisation; 2] = [Discretisation::Quadratic, Discretisation::Conventional];

#[test]
fn the_papers_step_damps_a_wave_as_theory_has_it() {
    for discretisation in BOTH {
        let (midpoint, _) = run(discretisation, Integrator::Midpoint, 3).expect("it lasts");
        let (paper, _) = run(discretisation, Integrator::Paper, 3).expect("it lasts");
        let at = |integrator| setup(discretisation, integrator).assembly_time(TIME_STEP);
        let between = at(Integrator::Paper) - at(Integrator::Midpoint);
        let exact = 2.0 * PI * frequency() * between;
        println!("{discretisation:?}: paper {paper}, midpoint {midpoint}, theory {exact} between");
        assert!(((paper - midpoint) / exact - 1.0).abs() < 0.1);
    }
}

/// What the pressure solver says of the 21st step of the wave when it may leave a divergence of
/// `tolerance` sqrt(g/D) in that step.
fn report_of_a_step(solver: SolverKind, tolerance: f64) -> PressureReport {
    let mut setup = setup(Discretisation::Quadratic, Integrator::Midpoint);
    setup.pressure.solver = SolverKind::Network;
    let mut fluid = Fluid::flowing(setup, &StandingWave).unwrap();
    for _ in 0..20 {
        fluid.solve(TIME_STEP).unwrap();
        fluid.finish(TIME_STEP).unwrap();
    }
    let settings = &mut fluid.setup.pressure;
    *settings =
        PressureSettings { solver, guard_tolerance: tolerance, tolerance: 1e-6, ..*settings };
    fluid.solver = pressure::solver(*settings, &fluid.setup.network, None);
    fluid.solve(TIME_STEP).unwrap();
    fluid.report
}

#[test]
fn the_guard_looks_twice_before_a_step_falls_back() {
    let unit = (GRAVITY / DEPTH).sqrt();
    let first = report_of_a_step(SolverKind::Network, 0.0).divergence_left / unit;
    let looks_once = report_of_a_step(SolverKind::Guarded, 1.01 * first);
    assert!(!looks_once.fell_back);
    assert_eq!(looks_once.divergence_left / unit, first);
    let looks_twice = report_of_a_step(SolverKind::Guarded, 0.99 * first);
    let second = looks_twice.divergence_left / unit;
    assert!(!looks_twice.fell_back && second < 0.9 * first, "{second} after {first}");
    let falls_back = report_of_a_step(SolverKind::Guarded, 0.99 * second);
    assert!(falls_back.fell_back);
    assert!(falls_back.divergence_left / unit < 0.99 * second);
}

/// The table in `docs/validation.md`:
/// `cargo test --release -p seakeep-fluid ten_periods -- --ignored --nocapture`.
#[test]
#[ignore = "long"]
fn ten_periods() {
    for discretisation in BOTH {
        for integrator in [Integrator::Midpoint, Integrator::Paper] {
            match run(discretisation, integrator, 10) {
                Ok((loss, period)) => println!(
                    "| {discretisation:?} | {integrator:?} | {:.2} % | {:+.2} % |",
                    100.0 * loss,
                    100.0 * period
                ),
                Err(error) => println!("| {discretisation:?} | {integrator:?} | {error} |"),
            }
        }
    }
}
