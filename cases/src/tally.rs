//! What the coupling of a run has cost and made.

use seakeep_coupler::StepReport;
use serde::Serialize;

/// The reports of a number of communication steps, added up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct CouplingTally {
    /// Communication steps.
    pub steps: u64,
    /// Evaluations of the load on the bodies.
    pub load_evaluations: u64,
    /// Most of them in a step.
    pub load_evaluations_largest: u32,
    /// Largest relative difference of the accelerations on either side of the interface.
    pub residual_largest: f64,
    /// Work of the water on the bodies, J/m.
    pub interface_work_j_per_m: f64,
    /// Energy that the coupling has made, J/m.
    pub power_bond_residual_j_per_m: f64,
    /// Sum of its magnitudes from step to step, J/m.
    pub power_bond_residual_magnitude_j_per_m: f64,
}

impl CouplingTally {
    /// Adds a step.
    pub fn add(&mut self, report: &StepReport) {
        self.steps += 1;
        self.load_evaluations += u64::from(report.load_evaluations);
        self.load_evaluations_largest = self.load_evaluations_largest.max(report.load_evaluations);
        self.residual_largest = self.residual_largest.max(report.residual);
        self.interface_work_j_per_m += report.interface_work;
        self.power_bond_residual_j_per_m += report.power_bond_residual;
        self.power_bond_residual_magnitude_j_per_m += report.power_bond_residual.abs();
    }
}
