//! Cholesky factorization of the small symmetric matrices of local fits.

#![allow(clippy::needless_range_loop)] // triangles of a matrix read best by index

/// A symmetric positive definite matrix, later its factor L with L Lᵀ = A; the lower triangle
/// is used.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Symmetric<const N: usize>(pub(crate) [[f64; N]; N]);

impl<const N: usize> Symmetric<N> {
    pub(crate) fn zero() -> Self {
        Self([[0.0; N]; N])
    }

    /// Adds `weight * row rowᵀ`.
    #[inline(always)]
    pub(crate) fn add_outer(&mut self, weight: f64, row: &[f64; N]) {
        for i in 0..N {
            let scaled = weight * row[i];
            for j in 0..=i {
                self.0[i][j] += scaled * row[j];
            }
        }
    }

    /// Factorizes; `None` where a pivot falls below `threshold` times the diagonal it began as, or
    /// a tenth of that times the trace: a direction in which there is nothing to tell.
    #[inline(always)]
    pub(crate) fn factorize(mut self, threshold: f64) -> Option<Factor<N>> {
        let trace: f64 = (0..N).map(|j| self.0[j][j]).sum();
        let a = &mut self.0;
        for j in 0..N {
            let mut pivot = a[j][j];
            for k in 0..j {
                pivot -= a[j][k] * a[j][k];
            }
            if pivot.is_nan() || pivot <= threshold * a[j][j].max(0.1 * trace) {
                return None;
            }
            let inverse = 1.0 / pivot.sqrt();
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
        Some(Factor(self.0))
    }
}

/// The factor L, its diagonal inverted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Factor<const N: usize>([[f64; N]; N]);

impl<const N: usize> Factor<N> {
    /// Solves A x = b.
    #[inline(always)]
    pub(crate) fn solve(&self, b: &[f64; N]) -> [f64; N] {
        let l = &self.0;
        let mut x = *b;
        for i in 0..N {
            for k in 0..i {
                x[i] -= l[i][k] * x[k];
            }
            x[i] *= l[i][i];
        }
        for i in (0..N).rev() {
            for k in i + 1..N {
                x[i] -= l[k][i] * x[k];
            }
            x[i] *= l[i][i];
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
