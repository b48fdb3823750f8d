//! Harmonics of a series by least squares: mean + Re Σ A_j exp(−i j ω t).

use nalgebra::{Complex, DMatrix, DVector};
use std::f64::consts::TAU;

/// What a series of one fundamental frequency consists of.
#[derive(Clone, Debug, PartialEq)]
pub struct Harmonics {
    /// Fundamental angular frequency ω, rad/s.
    pub frequency: f64,
    /// Mean.
    pub mean: f64,
    /// A_1, A_2, …: modulus and phase of a_j cos(j ω t − arg A_j).
    pub amplitudes: Vec<Complex<f64>>,
    /// Root mean square of what is left.
    pub residual: f64,
}

/// The mean and `count` harmonics of `frequency` (rad/s) in a series, which need not be sampled
/// evenly nor over whole periods. `None` for fewer samples than unknowns, or when the samples
/// cannot tell the harmonics apart.
#[must_use]
pub fn harmonics(times: &[f64], values: &[f64], frequency: f64, count: usize) -> Option<Harmonics> {
    let unknowns = 1 + 2 * count;
    let samples = times.len().min(values.len());
    if samples < unknowns + 3 {
        return None;
    }
    // Phases from the middle of the record keep the columns nearly orthogonal.
    let origin = 0.5 * (times[0] + times[samples - 1]);
    let matrix = DMatrix::from_fn(samples, unknowns, |row, column| {
        let angle = column.div_ceil(2) as f64 * frequency * (times[row] - origin);
        if column % 2 == 0 && column > 0 { angle.sin() } else { angle.cos() }
    });
    let right = DVector::from_fn(samples, |row, _| values[row]);
    let normal = matrix.tr_mul(&matrix);
    let eigenvalues = normal.clone().symmetric_eigen().eigenvalues;
    if eigenvalues.min() <= 1e-8 * eigenvalues.max() {
        return None;
    }
    let fit = normal.cholesky()?.solve(&matrix.tr_mul(&right));
    let residual = (right - matrix * &fit).norm() / (samples as f64).sqrt();
    let amplitudes = (1..=count).map(|j| {
        let turn = Complex::from_polar(1.0, j as f64 * frequency * origin);
        Complex::new(fit[2 * j - 1], fit[2 * j]) * turn
    });
    Some(Harmonics { frequency, mean: fit[0], amplitudes: amplitudes.collect(), residual })
}

/// The angular frequency (rad/s) within `tolerance` (a fraction) of `guess` that, with `count`
/// harmonics, leaves the least of a series. `None` where [`harmonics`] is.
#[must_use]
pub fn find_frequency(
    times: &[f64],
    values: &[f64],
    guess: f64,
    tolerance: f64,
    count: usize,
) -> Option<f64> {
    let left = |frequency: f64| Some(harmonics(times, values, frequency, count)?.residual);
    // Minima are as wide as 1 / duration: a scan finds the lowest, a golden section its bottom.
    let duration = times.last()? - times.first()?;
    let span = tolerance * guess;
    let steps = (2.0 * span * duration / TAU * 8.0).ceil().max(8.0) as usize;
    let width = 2.0 * span / steps as f64;
    let mut best = (f64::INFINITY, guess);
    for n in 0..=steps {
        let frequency = guess - span + width * n as f64;
        let residual = left(frequency)?;
        if residual < best.0 {
            best = (residual, frequency);
        }
    }
    let ratio = 0.5 * (5f64.sqrt() - 1.0);
    let (mut low, mut high) = (best.1 - width, best.1 + width);
    while high - low > 1e-9 * guess {
        let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
        if left(a)? < left(b)? { high = b } else { low = a }
    }
    Some(0.5 * (low + high))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(frequency: f64) -> (Vec<f64>, Vec<f64>) {
        let times: Vec<f64> = (0..1537).map(|i| 3.0 + f64::from(i) * 0.0101).collect();
        let value = |t: f64| {
            0.01 + 0.05 * (frequency * t - 0.7).cos()
                + 0.004 * (2.0 * frequency * t + 1.1).cos()
                + 0.001 * (3.0 * frequency * t).cos()
        };
        let values = times.iter().map(|t| value(*t)).collect();
        (times, values)
    }

    #[test]
    fn amplitudes_and_phases() {
        let (times, values) = series(5.2);
        let found = harmonics(&times, &values, 5.2, 3).unwrap();
        assert!((found.mean - 0.01).abs() < 1e-12 && found.residual < 1e-12);
        for (amplitude, (size, phase)) in
            found.amplitudes.iter().zip([(0.05, 0.7), (0.004, -1.1), (0.001, 0.0)])
        {
            assert!((amplitude - Complex::from_polar(size, phase)).norm() < 1e-12);
        }
    }

    #[test]
    fn a_frequency_is_found() {
        let (times, values) = series(5.2);
        let found = find_frequency(&times, &values, 5.0, 0.1, 3).unwrap();
        assert!((found - 5.2).abs() < 1e-6, "{found}");
    }

    #[test]
    fn what_cannot_be_told_apart_is_not() {
        assert_eq!(harmonics(&[0.0, 1.0, 2.0], &[0.0; 3], 1.0, 1), None);
        // Sampled once a period, a wave is a constant.
        let times: Vec<f64> = (0..50).map(f64::from).collect();
        assert_eq!(harmonics(&times, &[1.0; 50], TAU, 1), None);
    }
}
