//! Coupling schemes compared: which are stable, what they cost and how far they are from the
//! converged solution. `cargo run --release --example coupling` prints the tables of
//! `docs/validation.md`.
//!
//! The converged solution is that of an iteration to a residual of 1e-10 with the same water at the
//! same time steps, so that an error here is one of the coupling alone.

#![allow(clippy::print_stdout, reason = "a program that prints tables")]

use seakeep::case::Case;
use seakeep::simulation::{Simulation, SimulationError};
use seakeep::tally::CouplingTally;
use seakeep_coupler::CouplerError;
use std::error::Error;
use std::time::Instant;

const CONVERGED: [&str; 2] = ["scheme='implicit'", "tolerance=1e-10"];

/// Schemes with a communication step for a time step.
const SCHEMES: [(&str, &[&str]); 10] = [
    ("interface Jacobian (default)", &[]),
    ("Jacobi, hold", &["scheme='jacobi'"]),
    ("Jacobi, linear", &["scheme='jacobi'", "extrapolation='linear'"]),
    ("Gauss-Seidel, hold", &["scheme='gauss_seidel'"]),
    ("Gauss-Seidel, linear", &["scheme='gauss_seidel'", "extrapolation='linear'"]),
    ("Gauss-Seidel, quadratic", &["scheme='gauss_seidel'", "extrapolation='quadratic'"]),
    ("implicit, constant 0.5", &["scheme='implicit'", "acceleration='constant'"]),
    (
        "implicit, constant 0.1",
        &["scheme='implicit'", "acceleration='constant'", "relaxation=0.1", "max_iterations=500"],
    ),
    ("implicit, Aitken", &["scheme='implicit'", "acceleration='aitken'"]),
    ("implicit, IQN-ILS", &["scheme='implicit'"]),
];

/// Schemes that any added mass leaves stable, for the table of rates.
const SUBCYCLED: [(&str, &[&str]); 4] = [
    ("interface Jacobian, hold", &[]),
    ("interface Jacobian, linear", &["extrapolation='linear'"]),
    ("implicit, hold", &["scheme='implicit'"]),
    ("implicit, linear", &["scheme='implicit'", "extrapolation='linear'"]),
];

/// Steps of the water and of the bodies in a communication step.
const RATES: [(usize, usize); 7] = [(1, 1), (1, 2), (1, 5), (1, 10), (2, 1), (5, 1), (10, 1)];

/// A body in water, let go at rest away from its equilibrium.
struct Scene {
    name: String,
    /// Overrides of the case `roll_decay`.
    overrides: Vec<String>,
    /// The degree of freedom that is compared: 1 for heave, 2 for roll.
    degree: usize,
}

impl Scene {
    fn new(name: &str, degree: usize, overrides: &[String]) -> Self {
        let coarse = ["numerics.particle_spacing_m=0.02", "output.mcap=false", "output.plot=false"];
        let coarse = coarse.into_iter().map(str::to_owned);
        Self {
            name: name.to_owned(),
            overrides: coarse.chain(overrides.iter().cloned()).collect(),
            degree,
        }
    }

    /// The roll decay at D/dx = 20, one swing to the other side and back.
    fn roll_decay() -> Self {
        let overrides = ["numerics.time_step_s=0.004", "end_time_s=1.6"].map(str::to_owned);
        Self::new("roll decay", 2, &overrides)
    }

    /// The box upright, of a density (kg/m³), let go 20 mm too deep; the heaviest, which would be
    /// under water altogether, 20 mm too high.
    fn impulsive_start(density: f64) -> Self {
        let (depth, width, height) = (0.4, 0.3, 0.2);
        let offset = if density < 1000.0 { -0.02 } else { 0.02 };
        let mass = density * width * height;
        let inertia = mass * (width * width + height * height) / 12.0;
        let centre = depth + height * (0.5 - density / 1000.0) + offset;
        let overrides = [
            "end_time_s=0.4".to_owned(),
            "tank.length_m=1.5".to_owned(),
            "gauge.x_m=0.3".to_owned(),
            "body.angle_deg=0".to_owned(),
            format!("body.position_m=[0.75,{centre}]"),
            format!("body.mass_kg_m={mass}"),
            format!("body.inertia_kg_m2_m={inertia}"),
        ];
        Self::new(&format!("{density} kg/m³"), 1, &overrides)
    }
}

/// A run: the motion in the degree of freedom compared, at every communication step.
struct Record {
    motion: Vec<f64>,
    tally: CouplingTally,
    wall_time: f64,
    /// Why it ended early.
    failure: Option<String>,
}

/// Runs `scene` with the keys `coupling` of `[coupling]`, until the end or until the motion has
/// left `bound`.
fn run(scene: &Scene, coupling: &[String], bound: f64) -> Result<Record, Box<dyn Error>> {
    let coupling = coupling.iter().map(|key| format!("coupling.{key}"));
    let overrides: Vec<String> = scene.overrides.iter().cloned().chain(coupling).collect();
    let case = Case::load("roll_decay", &overrides)?;
    let mut simulation = Simulation::start(&case.scene)?;
    let position = |simulation: &Simulation| {
        let body = &simulation.kinematics()[0];
        [body.position.x, body.position.y, body.angle][scene.degree]
    };
    let mut motion = vec![position(&simulation)];
    let mut failure = None;
    let clock = Instant::now();
    for _ in 0..case.scene.steps {
        if let Err(error) = simulation.step() {
            // If not the scheme itself, it is the water, thrown about by the body, that gives up.
            let reason = match error {
                SimulationError::Coupling(CouplerError::NotConverged { .. }) => "does not converge",
                _ => "diverges",
            };
            failure = Some(format!("{reason}, t = {:.3} s", simulation.time()));
            break;
        }
        motion.push(position(&simulation));
        let moved = (motion[motion.len() - 1] - motion[0]).abs();
        if moved.is_nan() || moved >= bound {
            failure = Some(format!("diverges, t = {:.3} s", simulation.time()));
            break;
        }
    }
    let (tally, wall_time) = (*simulation.coupling_tally(), clock.elapsed().as_secs_f64());
    Ok(Record { motion, tally, wall_time, failure })
}

fn owned(keys: &[&str]) -> Vec<String> {
    keys.iter().map(|&key| key.to_owned()).collect()
}

/// Largest difference to the `reference`, which has a value for each of the water's steps, over
/// the largest motion in it.
fn error(record: &Record, substeps: usize, reference: &[f64]) -> f64 {
    let pairs = record.motion.iter().zip(reference.iter().step_by(substeps));
    let difference = pairs.map(|(found, wanted)| (found - wanted).abs()).fold(0.0, f64::max);
    difference / range(reference)
}

fn range(motion: &[f64]) -> f64 {
    motion.iter().map(|value| (value - motion[0]).abs()).fold(0.0, f64::max)
}

/// The converged motion of `scene`.
fn converged(scene: &Scene) -> Result<Vec<f64>, Box<dyn Error>> {
    let record = run(scene, &owned(&CONVERGED), f64::INFINITY)?;
    match record.failure {
        None => Ok(record.motion),
        Some(reason) => Err(format!("{}: {reason}", scene.name).into()),
    }
}

fn schemes() -> Result<(), Box<dyn Error>> {
    println!(
        "| scene | scheme | stable | evaluations a step, mean/largest | error | wall time, s |"
    );
    println!("|---|---|---|---|---|---|");
    let boxes = [100.0, 250.0, 500.0, 1000.0].map(Scene::impulsive_start);
    for scene in std::iter::once(Scene::roll_decay()).chain(boxes) {
        let reference = converged(&scene)?;
        for (name, keys) in SCHEMES {
            let record = run(&scene, &owned(keys), 10.0 * range(&reference))?;
            let CouplingTally { steps, load_evaluations, load_evaluations_largest, .. } =
                record.tally;
            let mean = load_evaluations as f64 / steps.max(1) as f64;
            let row = match &record.failure {
                Some(reason) => format!("no: {reason} | | |"),
                None => format!(
                    "yes | {mean:.1}/{load_evaluations_largest} | {:.1e} | {:.1}",
                    error(&record, 1, &reference),
                    record.wall_time
                ),
            };
            println!("| {} | {name} | {row} |", scene.name);
        }
    }
    Ok(())
}

fn rates() -> Result<(), Box<dyn Error>> {
    println!(
        "| scheme | steps of water : bodies | evaluations a step | steps of the water | error | wall time, s |"
    );
    println!("|---|---|---|---|---|---|");
    let scene = Scene::roll_decay();
    let reference = converged(&scene)?;
    for (name, keys) in SUBCYCLED {
        for (water, bodies) in RATES {
            let rates = [format!("fluid_substeps={water}"), format!("body_substeps={bodies}")];
            let keys: Vec<String> = owned(keys).into_iter().chain(rates).collect();
            let record = run(&scene, &keys, 10.0 * range(&reference))?;
            let CouplingTally { steps, load_evaluations, .. } = record.tally;
            let mean = load_evaluations as f64 / steps.max(1) as f64;
            // The response of a single step holds for all evaluations in it.
            let single = if water == 1 { steps } else { load_evaluations };
            let row = match &record.failure {
                Some(reason) => format!("{reason} | | |"),
                None => format!(
                    "{mean:.1} | {} | {:.1e} | {:.1}",
                    single * water as u64,
                    error(&record, water, &reference),
                    record.wall_time
                ),
            };
            println!("| {name} | {water} : {bodies} | {row} |");
        }
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    schemes()?;
    println!();
    rates()
}
