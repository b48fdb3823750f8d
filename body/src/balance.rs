//! The balance of momentum of all bodies with added mass, (M + A) a = F, on the free degrees of
//! freedom. M + A couples bodies and degrees of freedom, so it is one system.

use crate::BodyError;
use nalgebra::{DMatrix, DVector, Dyn, LU};

/// (M + A) factorized; A is held over a step, so one factorization serves all its substeps.
pub(crate) struct Balance {
    /// Rows of the free degrees of freedom.
    free: Vec<usize>,
    /// Absent if nothing is free.
    factors: Option<LU<f64, Dyn, Dyn>>,
}

impl Balance {
    /// Reduces M + A (three rows a body) to the free rows and columns and factorizes it. A held
    /// degree of freedom has no acceleration, so its column drops out; its row would give the
    /// reaction.
    pub(crate) fn new(
        mass: &DMatrix<f64>,
        added_mass: &DMatrix<f64>,
        free: &[bool],
    ) -> Result<Self, BodyError> {
        let free: Vec<usize> = (0..free.len()).filter(|row| free[*row]).collect();
        let size = free.len();
        if size == 0 {
            return Ok(Self { free, factors: None });
        }
        let reduced = DMatrix::from_fn(size, size, |row, column| {
            let place = (free[row], free[column]);
            mass[place] + added_mass[place]
        });
        let factors = reduced.lu();
        if !factors.is_invertible() {
            return Err(BodyError::SingularMass { size });
        }
        Ok(Self { free, factors: Some(factors) })
    }

    /// Writes a = (M + A)⁻¹ F, zero where held. Both slices have three values a body.
    pub(crate) fn solve(&self, loads: &[f64], accelerations: &mut [f64]) -> Result<(), BodyError> {
        accelerations.fill(0.0);
        let Some(factors) = &self.factors else { return Ok(()) };
        let size = self.free.len();
        let mut solution = DVector::from_iterator(size, self.free.iter().map(|row| loads[*row]));
        if !factors.solve_mut(&mut solution) || solution.iter().any(|value| !value.is_finite()) {
            return Err(BodyError::SingularMass { size });
        }
        for (row, value) in self.free.iter().zip(&solution) {
            accelerations[*row] = *value;
        }
        Ok(())
    }
}
