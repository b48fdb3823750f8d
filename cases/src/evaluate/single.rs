//! Single steps of the test cases of a campaign.

use super::{EvaluateError, solvers};
use crate::case::Case;
use crate::dataset::{Campaign, Split};
use crate::simulation::Simulation;
use seakeep_fluid::setup::PressureSettings;
use seakeep_fluid::trial::{Guess, Outcome, Region, Trial};
use serde::Serialize;

/// Wavelengths of modal errors, in spacings.
const WAVELENGTHS: [f64; 9] = [2.0, 3.0, 4.0, 6.0, 8.0, 16.0, 32.0, 64.0, 128.0];

/// A solver's skill over all steps: 1 − Σ (p̂ − p)² / Σ (p_t − p)², p_t the pressure of the step
/// before and p the exact one.
#[derive(Clone, Debug, Serialize)]
pub struct SkillRow {
    /// The solver.
    pub solver: &'static str,
    /// Skill over all particles.
    pub skill: f64,
    /// Near the surface.
    pub skill_surface: f64,
    /// Near bed and side walls.
    pub skill_walls: f64,
    /// Elsewhere.
    pub skill_bulk: f64,
    /// Residual left over the right-hand side, mean.
    pub residual: f64,
    /// Wall time a step and thousand particles, median, ms.
    pub time_ms: f64,
    /// Steps looked at.
    pub steps: usize,
}

/// What is left of an error of one wavelength, mean over the cases.
#[derive(Clone, Debug, Serialize)]
pub struct FactorRow {
    /// The solver.
    pub solver: &'static str,
    /// Wavelength over spacing.
    pub wavelength_spacings: f64,
    /// e: the part of the error that is left of itself.
    pub factor: f64,
    /// Norm of all that is left over that of the error.
    pub left: f64,
}

/// Runs each test case of `campaign` with the Poisson equation and tries every solver in `steps`
/// steps of it, evenly spread over its frames. `overrides` go to each case, the weights among them.
/// `observe` is called with the name of each case before it.
///
/// # Errors
/// [`EvaluateError`].
pub fn single_steps(
    campaign: &Campaign,
    steps: usize,
    overrides: &[String],
    threads: usize,
    observe: &mut (dyn FnMut(&str) + Send),
) -> Result<(Vec<SkillRow>, Vec<FactorRow>), EvaluateError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build()?;
    let planned: Vec<_> =
        campaign.plan().into_iter().filter(|case| case.split == Split::Test).collect();
    if planned.is_empty() {
        return Err(EvaluateError::NoTest);
    }
    let solvers = solvers(PressureSettings::default().tolerance);
    let mut found: Vec<Vec<(Outcome, usize)>> = vec![Vec::new(); solvers.len()];
    let mut modes: Vec<Vec<Outcome>> = vec![Vec::new(); solvers.len() * WAVELENGTHS.len()];
    pool.install(|| {
        for planned in &planned {
            observe(&planned.name);
            let file = format!("{}.toml", planned.name);
            let case = Case::parse(&planned.name, &file, &planned.text, overrides)?;
            let spacing = case.scene.fluid.numerics.particle_spacing;
            let mut simulation = Simulation::start(&case.scene)?;
            for number in 0..steps.min(planned.frames) {
                let frame = number * planned.frames / steps.min(planned.frames);
                let at = planned.first_frame + planned.frame_interval * frame as f64;
                let before = (at / case.scene.communication_step()).round() as u64;
                while simulation.steps() < before {
                    simulation.step()?;
                }
                let trial = |settings, guess| Trial { settings, guess };
                let mut trials: Vec<_> =
                    solvers.iter().map(|(_, settings)| trial(*settings, Guess::Last)).collect();
                if number == 0 {
                    for (_, settings) in &solvers {
                        let mode = |l| trial(*settings, Guess::Mode(l * spacing));
                        trials.extend(WAVELENGTHS.map(mode));
                    }
                }
                simulation.try_at_next_step(trials);
                let particles = simulation.particle_counts().fluid;
                simulation.step()?;
                for (index, outcome) in simulation.take_outcomes().into_iter().enumerate() {
                    match found.get_mut(index) {
                        Some(found) => found.push((outcome, particles)),
                        None => modes[index - solvers.len()].push(outcome),
                    }
                }
            }
        }
        Ok::<(), EvaluateError>(())
    })?;
    let skills = solvers.iter().zip(&mut found).map(|((name, _), found)| skill(name, found));
    let factors = modes.iter().enumerate().map(|(index, outcomes)| {
        let solver = solvers[index / WAVELENGTHS.len()].0;
        factor(solver, WAVELENGTHS[index % WAVELENGTHS.len()], outcomes)
    });
    Ok((skills.collect(), factors.collect()))
}

fn skill(solver: &'static str, found: &mut [(Outcome, usize)]) -> SkillRow {
    let skill = |region: Region| {
        let slot = Region::ALL.iter().position(|of| *of == region).unwrap_or(0);
        let sum = |pick: fn(&Outcome) -> &[f64; 5]| -> f64 {
            found.iter().map(|(outcome, _)| pick(outcome)[slot]).sum()
        };
        1.0 - sum(|o| &o.after) / sum(|o| &o.before)
    };
    let [all, surface, walls, bulk] =
        [Region::All, Region::Surface, Region::Walls, Region::Bulk].map(skill);
    let count = found.len().max(1) as f64;
    let residual = found.iter().map(|(o, _)| o.report.residual).sum::<f64>() / count;
    let mut times: Vec<f64> =
        found.iter().map(|(o, n)| o.report.time.as_secs_f64() * 1e6 / *n as f64).collect();
    times.sort_by(f64::total_cmp);
    SkillRow {
        solver,
        skill: all,
        skill_surface: surface,
        skill_walls: walls,
        skill_bulk: bulk,
        residual,
        time_ms: times.get(times.len() / 2).copied().unwrap_or(0.0),
        steps: found.len(),
    }
}

fn factor(solver: &'static str, wavelength: f64, outcomes: &[Outcome]) -> FactorRow {
    let count = outcomes.len().max(1) as f64;
    let mean = |value: &dyn Fn(&Outcome) -> f64| outcomes.iter().map(value).sum::<f64>() / count;
    FactorRow {
        solver,
        wavelength_spacings: wavelength,
        factor: mean(&|o| o.along / o.before[0]),
        left: mean(&|o| (o.after[0] / o.before[0]).sqrt()),
    }
}
