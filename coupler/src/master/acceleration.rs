//! Acceleration of the fixed-point iteration a → ã(a) of an implicit coupling, with the residual
//! r = ã − a.

use super::settings::{Acceleration, Implicit};
use serde::{Deserialize, Serialize};

/// A difference of residuals counts as a combination of newer ones if less than this part of it is
/// not: its direction is rounding then.
const DEPENDENT: f64 = 1e-4;

/// What an acceleration remembers from one communication step to the next.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Accelerator {
    /// Aitken's relaxation as it was last.
    relaxation: Option<f64>,
    /// Differences of this step and of those before, newest first.
    differences: Vec<Vec<Difference>>,
    /// The last iterate of this step.
    last: Option<Iterate>,
}

/// Residual and outcome of an evaluation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Iterate {
    residual: Vec<f64>,
    outcome: Vec<f64>,
}

/// Change of residual and outcome from one evaluation to the next.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Difference {
    residual: Vec<f64>,
    outcome: Vec<f64>,
}

impl Accelerator {
    /// Begins a communication step.
    pub(super) fn begin(&mut self) {
        self.last = None;
        self.differences.insert(0, Vec::new());
    }

    /// The accelerations to try next, after `tried` has given `outcome`.
    pub(super) fn next(&mut self, settings: &Implicit, tried: &[f64], outcome: &[f64]) -> Vec<f64> {
        let now = Iterate { residual: minus(outcome, tried), outcome: outcome.to_vec() };
        let relaxed = |factor: f64| plus(tried, factor, &now.residual);
        let next = match settings.acceleration {
            Acceleration::Constant => relaxed(settings.relaxation),
            Acceleration::Aitken => {
                let factor = self.aitken(settings.relaxation, &now.residual);
                self.relaxation = Some(factor);
                relaxed(factor)
            }
            Acceleration::IqnIls { .. } => {
                self.note_difference(&now);
                let newest_first: Vec<&Difference> = self.differences.iter().flatten().collect();
                quasi_newton(&newest_first, &now).unwrap_or_else(|| relaxed(settings.relaxation))
            }
        };
        self.last = Some(now);
        next
    }

    /// Ends a step that has converged with `outcome` for `tried`: a difference is learnt from
    /// its last evaluation too.
    pub(super) fn end(&mut self, settings: &Implicit, tried: &[f64], outcome: &[f64]) {
        if let Acceleration::IqnIls { reused_steps } = settings.acceleration {
            let residual = minus(outcome, tried);
            self.note_difference(&Iterate { residual, outcome: outcome.to_vec() });
            // A step without iterations has taught nothing, and pushes nothing out.
            self.differences.retain(|step| !step.is_empty());
            self.differences.truncate(reused_steps as usize);
        } else {
            self.differences.clear();
        }
        self.last = None;
    }

    /// ω ← −ω rₖ₋₁ · (rₖ − rₖ₋₁)/‖rₖ − rₖ₋₁‖² (Küttler and Wall 2008, Eq. 44); at the start of a
    /// step the last one, but not above the first one of all.
    fn aitken(&self, first: f64, residual: &[f64]) -> f64 {
        match (&self.last, self.relaxation) {
            (Some(last), Some(factor)) => {
                let change = minus(residual, &last.residual);
                let square = dot(&change, &change);
                if square == 0.0 { factor } else { -factor * dot(&last.residual, &change) / square }
            }
            (None, Some(factor)) => factor.abs().min(first),
            (_, None) => first,
        }
    }

    fn note_difference(&mut self, now: &Iterate) {
        let Some(last) = &self.last else { return };
        let difference = Difference {
            residual: minus(&now.residual, &last.residual),
            outcome: minus(&now.outcome, &last.outcome),
        };
        self.differences[0].insert(0, difference);
    }
}

/// ã + W c with c such that r + V c is as small as possible, where V and W are the changes of
/// residual and outcome: IQN-ILS. The changes of the residual are made orthogonal from the newest
/// on, with the same combinations of the changes of the outcome, and one that depends on newer
/// ones is left out (the QR filter of Haelterman et al., Comput. Struct. 171, 2016). `None`
/// without a difference.
fn quasi_newton(newest_first: &[&Difference], now: &Iterate) -> Option<Vec<f64>> {
    let mut basis: Vec<Difference> = Vec::new();
    for difference in newest_first {
        let Difference { mut residual, mut outcome } = (*difference).clone();
        let before = dot(&residual, &residual).sqrt();
        for Difference { residual: direction, outcome: effect } in &basis {
            let part = dot(direction, &residual);
            residual = plus(&residual, -part, direction);
            outcome = plus(&outcome, -part, effect);
        }
        let after = dot(&residual, &residual).sqrt();
        if after > DEPENDENT * before {
            residual.iter_mut().chain(&mut outcome).for_each(|value| *value /= after);
            basis.push(Difference { residual, outcome });
        }
    }
    let step = |next: Vec<f64>, Difference { residual, outcome }: &Difference| {
        plus(&next, -dot(residual, &now.residual), outcome)
    };
    (!basis.is_empty()).then(|| basis.iter().fold(now.outcome.clone(), step))
}

fn minus(left: &[f64], right: &[f64]) -> Vec<f64> {
    left.iter().zip(right).map(|(l, r)| l - r).collect()
}

fn plus(left: &[f64], factor: f64, right: &[f64]) -> Vec<f64> {
    left.iter().zip(right).map(|(l, r)| l + factor * r).collect()
}

fn dot(left: &[f64], right: &[f64]) -> f64 {
    left.iter().zip(right).map(|(l, r)| l * r).sum()
}

#[cfg(test)]
mod tests {
    use super::{Acceleration, Accelerator, Implicit};
    use nalgebra::{Matrix3, Vector3};

    /// Evaluations for ã = b − G a, an affine map that no relaxation above 0.4 can iterate.
    fn evaluations(acceleration: Acceleration, relaxation: f64) -> u32 {
        let gain = Matrix3::new(2.0, 0.3, 0.0, 0.3, 0.5, 0.1, 0.0, 0.1, 3.5);
        let constant = Vector3::new(1.0, -2.0, 0.5);
        let settings = Implicit { acceleration, relaxation, ..Implicit::default() };
        let mut accelerator = Accelerator::default();
        let mut tried = vec![0.0; 3];
        accelerator.begin();
        for count in 1..100 {
            let outcome = constant - gain * Vector3::from_column_slice(&tried);
            if (outcome - Vector3::from_column_slice(&tried)).norm() < 1e-9 {
                let exact = (Matrix3::identity() + gain).try_inverse().expect("regular") * constant;
                assert!((exact - outcome).norm() < 1e-8);
                return count;
            }
            tried = accelerator.next(&settings, &tried, outcome.as_slice());
        }
        100
    }

    #[test]
    fn an_affine_map_is_solved() {
        assert_eq!(evaluations(Acceleration::Constant, 0.5), 100);
        assert!((30..100).contains(&evaluations(Acceleration::Constant, 0.35)));
        assert!(evaluations(Acceleration::Aitken, 0.35) < 30);
        // As many differences as unknowns make the least squares exact: one evaluation for each,
        // the first, and the last, which finds that it is enough.
        assert_eq!(evaluations(Acceleration::IqnIls { reused_steps: 0 }, 0.5), 5);
    }

    #[test]
    fn differences_of_earlier_steps_are_used_again() {
        let acceleration = Acceleration::IqnIls { reused_steps: 2 };
        let settings = Implicit { acceleration, ..Implicit::default() };
        let mut accelerator = Accelerator::default();
        let mut counts = Vec::new();
        for step in 0..5 {
            let map = |a: f64| f64::from(step) + 1.0 - 2.5 * a;
            let mut tried = vec![0.0];
            accelerator.begin();
            let mut count = 1;
            while (map(tried[0]) - tried[0]).abs() > 1e-9 {
                let outcome = [map(tried[0])];
                tried = accelerator.next(&settings, &tried, &outcome);
                count += 1;
            }
            accelerator.end(&settings, &tried, &[map(tried[0])]);
            assert!(accelerator.differences.len() <= 2);
            counts.push(count);
        }
        assert_eq!(counts, [3, 2, 2, 2, 2]);
    }
}
