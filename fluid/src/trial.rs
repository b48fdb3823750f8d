//! Trials: other pressure solvers on the equation of a step of a run, measured against its exact
//! solution.

use crate::error::FluidError;
use crate::fluid::Fluid;
use crate::pressure::solver::{PressureReport, PressureSettings, Start};
use crate::walls::Owner;
use std::f64::consts::TAU;

/// Where the water is looked at separately.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Region {
    /// All of it.
    All,
    /// Particles with neighbours on the surface.
    Surface,
    /// Particles near the walls of the tank, not at the surface.
    Walls,
    /// Particles near a rigid boundary, not at the surface.
    Body,
    /// The others.
    Bulk,
}

impl Region {
    /// All regions.
    pub const ALL: [Self; 5] = [Self::All, Self::Surface, Self::Walls, Self::Body, Self::Bulk];
}

/// What a solver starts from in a trial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Guess {
    /// The pressure of the step before.
    Last,
    /// The exact pressure with an error of this wavelength (m) on it: cos(k x), uniform over the
    /// depth but for a quarter of a wave below the surface, over which it rises from zero.
    Mode(f64),
}

/// A solver to be tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// The solver.
    pub settings: PressureSettings,
    /// What it starts from.
    pub guess: Guess,
}

/// What came of a trial.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// What the solver reports.
    pub report: PressureReport,
    /// Σ (p_guess − p)² over each of [`Region::ALL`], Pa².
    pub before: [f64; 5],
    /// Σ (p_found − p)², Pa².
    pub after: [f64; 5],
    /// Σ (p_found − p) (p_guess − p) over all, Pa²: over `before` the part of the error that is
    /// left of itself.
    pub along: f64,
}

impl Fluid {
    /// Asks for `trials` in the next step that is solved; [`Self::take_outcomes`] hands over what
    /// came of them. The run is not changed by them.
    pub fn try_at_next_step(&mut self, trials: Vec<Trial>) {
        self.trials = trials;
    }

    /// What came of the trials that were asked for, in their order, once the step is solved.
    pub fn take_outcomes(&mut self) -> Vec<Outcome> {
        std::mem::take(&mut self.outcomes)
    }

    /// Does the trials that were asked for on the equation of the step of `h` (s).
    pub(crate) fn try_solvers(&mut self, h: f64) -> Result<(), FluidError> {
        let trials = std::mem::take(&mut self.trials);
        if trials.is_empty() {
            return Ok(());
        }
        let exact = self.exact_pressure(h)?;
        let last = self.last_pressure();
        let region: Vec<Region> = (0..exact.len()).map(|i| self.region(i)).collect();
        for trial in trials {
            let (guess, start) = match trial.guess {
                Guess::Last => (last.clone(), trial.settings.start),
                Guess::Mode(wavelength) => (self.with_mode(&exact, wavelength), Start::Given),
            };
            let mut rival = self.rival(PressureSettings { start, ..trial.settings }, None);
            let (report, found) = self.solve_again(h, guess.clone(), &mut rival)?;
            let mut outcome = Outcome { report, ..Outcome::default() };
            for (i, exact) in exact.iter().enumerate() {
                let (before, after) = (guess[i][0] - exact[0], found[i][0] - exact[0]);
                for (slot, of) in Region::ALL.into_iter().enumerate() {
                    if of == Region::All || of == region[i] {
                        outcome.before[slot] += before * before;
                        outcome.after[slot] += after * after;
                    }
                }
                outcome.along += before * after;
            }
            self.outcomes.push(outcome);
        }
        Ok(())
    }

    fn region(&self, i: usize) -> Region {
        let on_surface = |j: &u32| self.work.on_surface[*j as usize];
        let walls = self.work.wall_lists.of(i);
        if self.work.on_surface[i] || self.work.fluid.of(i).iter().any(on_surface) {
            return Region::Surface;
        }
        let of_body = |w: &u32| match self.walls.owner[*w as usize] {
            Owner::Boundary(boundary) => self.setup.boundaries[boundary].free,
            Owner::Tank => false,
        };
        match walls {
            [] => Region::Bulk,
            walls if walls.iter().any(of_body) => Region::Body,
            _ => Region::Walls,
        }
    }

    /// The `exact` pressure with the error of [`Guess::Mode`].
    fn with_mode(&self, exact: &[[f64; 1]], wavelength: f64) -> Vec<[f64; 1]> {
        let k = TAU / wavelength;
        let size =
            1e-3 * self.setup.water.density * self.setup.water.gravity * self.setup.water.depth;
        let depth = self.setup.water.depth;
        let quarter = depth.min(0.25 * wavelength);
        let error = |i: usize| {
            let x = self.work.position[i];
            let below = ((depth - x.y) / quarter).clamp(0.0, 1.0);
            size * (k * x.x).cos() * (0.25 * TAU * below).sin()
        };
        exact
            .iter()
            .enumerate()
            .map(|(i, p)| [if self.work.on_surface[i] { 0.0 } else { p[0] + error(i) }])
            .collect()
    }
}
