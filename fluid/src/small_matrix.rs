//! Cholesky factorization of the small symmetric matrices of local fits.

#![allow(clippy::needless_range_loop)] // triangles of a matrix read best by index

use crate::lanes::Number;

/// A symmetric positive definite matrix, later its factor L with L Lᵀ = A; the lower triangle
/// is used.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Symmetric<const N: usize, T = f64>(pub(crate) [[T; N]; N]);

impl<const N: usize, T: Number> Symmetric<N, T> {
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        Self([[T::of(0.0); N]; N])
    }

    /// Adds `weight * row rowᵀ`.
    #[inline(always)]
    pub(crate) fn add_outer(&mut self, weight: T, row: &[T; N]) {
        for i in 0..N {
            let scaled = weight * row[i];
            for j in 0..=i {
                self.0[i][j] += scaled * row[j];
            }
        }
    }

    /// Factorizes, and tells by how much the pivot that comes nearest to it stays above `threshold`
    /// times the diagonal it began as or a tenth of that times the trace: not above zero, or no
    /// number, where there is a direction in which there is nothing to tell.
    #[inline(always)]
    pub(crate) fn factorize_with_margin(mut self, threshold: f64) -> (Factor<N, T>, T) {
        let mut trace = self.0[0][0];
        for j in 1..N {
            trace += self.0[j][j];
        }
        let mut margin = trace;
        let a = &mut self.0;
        for j in 0..N {
            let mut pivot = a[j][j];
            for k in 0..j {
                pivot -= a[j][k] * a[j][k];
            }
            let least = T::of(threshold) * a[j][j].larger(T::of(0.1) * trace);
            // A pivot that is no number makes all that follow none, the last of which decides.
            margin = margin.smaller(pivot - least);
            let inverse = T::of(1.0) / pivot.sqrt();
            // The diagonal holds 1 / L_jj: solving then needs no division.
            a[j][j] = inverse;
            for i in j + 1..N {
                let mut value = a[i][j];
                for k in 0..j {
                    value -= a[i][k] * a[j][k];
                }
                a[i][j] = value * inverse;
            }
        }
        (Factor(self.0), margin)
    }
}

impl<const N: usize> Symmetric<N> {
    /// Factorizes; `None` where the margin is not above zero.
    #[inline(always)]
    pub(crate) fn factorize(self, threshold: f64) -> Option<Factor<N>> {
        let (factor, margin) = self.factorize_with_margin(threshold);
        (margin > 0.0).then_some(factor)
    }
}

/// The factor L, its diagonal inverted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factor<const N: usize, T = f64>([[T; N]; N]);

impl<const N: usize, T: Number> Factor<N, T> {
    /// Solves A x = b.
    #[inline(always)]
    pub(crate) fn solve(&self, b: &[T; N]) -> [T; N] {
        let l = &self.0;
        let mut x = *b;
        for i in 0..N {
            for k in 0..i {
                x[i] -= l[i][k] * x[k];
            }
            x[i] = x[i] * l[i][i];
        }
        for i in (0..N).rev() {
            for k in i + 1..N {
                x[i] -= l[k][i] * x[k];
            }
            x[i] = x[i] * l[i][i];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_known_system() {
        // Hilbert matrix of order 4: the inverse is known in integers.
        let mut a = Symmetric::<4>::zero();
        for i in 0..4 {
            for j in 0..4 {
                a.0[i][j] = 1.0 / (i + j + 1) as f64;
            }
        }
        let x = a.factorize(1e-12).expect("positive definite").solve(&[1.0, 0.0, 0.0, 0.0]);
        for (value, exact) in x.iter().zip([16.0, -120.0, 240.0, -140.0]) {
            assert!((value - exact).abs() < 1e-8 * exact.abs(), "{x:?}");
        }
    }

    #[test]
    fn refuses_a_singular_matrix() {
        let mut a = Symmetric::<3>::zero();
        a.add_outer(1.0, &[1.0, 2.0, 3.0]);
        a.add_outer(1.0, &[0.0, 1.0, 1.0]);
        assert!(a.factorize(1e-10).is_none());
    }
}
