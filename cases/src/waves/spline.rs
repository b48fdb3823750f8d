//! Interpolation that is smooth enough for a paddle: cubic splines with two continuous
//! derivatives.

use super::{WaveError, require};

/// A natural cubic spline: twice continuously differentiable, no curvature at its ends, constant
/// beyond them.
#[derive(Clone, Debug, PartialEq)]
pub struct Spline {
    abscissae: Vec<f64>,
    ordinates: Vec<f64>,
    /// Second derivative at every point.
    curvatures: Vec<f64>,
}

impl Spline {
    /// The spline through `ordinates` at `abscissae`, which rise strictly.
    ///
    /// # Errors
    /// Fewer than two points, lists of different length, abscissae that do not rise, values that
    /// are not finite.
    pub fn new(abscissae: Vec<f64>, ordinates: Vec<f64>) -> Result<Self, WaveError> {
        let count = abscissae.len();
        let sound = count >= 2 && ordinates.len() == count;
        require(sound, "points of a series", count as f64, "at least 2, with as many values")?;
        for pair in abscissae.windows(2) {
            require(pair[1] > pair[0], "time of a series (s)", pair[1], "after the one before")?;
        }
        for value in &ordinates {
            require(value.is_finite(), "value of a series", *value, "a finite number")?;
        }
        let curvatures = curvatures(&abscissae, &ordinates);
        Ok(Self { abscissae, ordinates, curvatures })
    }

    /// First and last abscissa.
    #[must_use]
    pub fn range(&self) -> (f64, f64) {
        (self.abscissae[0], self.abscissae[self.abscissae.len() - 1])
    }

    /// Value, first and second derivative at `x`.
    #[must_use]
    pub fn at(&self, x: f64) -> [f64; 3] {
        let last = self.abscissae.len() - 1;
        if x <= self.abscissae[0] {
            return [self.ordinates[0], 0.0, 0.0];
        }
        if x >= self.abscissae[last] {
            return [self.ordinates[last], 0.0, 0.0];
        }
        let right = self.abscissae.partition_point(|a| *a <= x).clamp(1, last);
        let left = right - 1;
        let width = self.abscissae[right] - self.abscissae[left];
        let (a, b) = ((self.abscissae[right] - x) / width, (x - self.abscissae[left]) / width);
        let (y0, y1) = (self.ordinates[left], self.ordinates[right]);
        let (m0, m1) = (self.curvatures[left], self.curvatures[right]);
        let square = width * width / 6.0;
        [
            a * y0 + b * y1 + ((a * a * a - a) * m0 + (b * b * b - b) * m1) * square,
            (y1 - y0) / width + ((3.0 * b * b - 1.0) * m1 - (3.0 * a * a - 1.0) * m0) * width / 6.0,
            a * m0 + b * m1,
        ]
    }
}

/// Second derivatives of the natural spline: a tridiagonal system, solved by elimination.
fn curvatures(x: &[f64], y: &[f64]) -> Vec<f64> {
    let count = x.len();
    let mut upper = vec![0.0; count];
    let mut right = vec![0.0; count];
    for i in 1..count.saturating_sub(1) {
        let (before, after) = (x[i] - x[i - 1], x[i + 1] - x[i]);
        let slopes = (y[i + 1] - y[i]) / after - (y[i] - y[i - 1]) / before;
        let pivot = 2.0 * (before + after) - before * upper[i - 1];
        upper[i] = after / pivot;
        right[i] = (6.0 * slopes - before * right[i - 1]) / pivot;
    }
    for i in (1..count.saturating_sub(1)).rev() {
        right[i] -= upper[i] * right[i + 1];
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_and_its_derivatives() {
        let x: Vec<f64> = (0..=200).map(|i| f64::from(i) * 0.05).collect();
        let y = x.iter().map(|x| x.sin()).collect();
        let spline = Spline::new(x, y).unwrap();
        for x in [2.013, 4.5, 7.77] {
            let [value, first, second] = spline.at(x);
            assert!((value - x.sin()).abs() < 1e-7);
            assert!((first - x.cos()).abs() < 1e-5);
            assert!((second + x.sin()).abs() < 1e-3);
        }
    }

    #[test]
    fn second_derivative_is_continuous_and_zero_at_the_ends() {
        let spline = Spline::new(vec![0.0, 0.3, 1.0, 1.1], vec![0.0, 1.0, -1.0, 0.5]).unwrap();
        for knot in [0.3, 1.0] {
            let (below, above) = (spline.at(knot - 1e-9), spline.at(knot + 1e-9));
            for order in 0..3 {
                assert!((below[order] - above[order]).abs() < 1e-5, "{below:?} {above:?}");
            }
        }
        assert_eq!(spline.at(-1.0), [0.0, 0.0, 0.0]);
        assert_eq!(spline.at(2.0), [0.5, 0.0, 0.0]);
        assert!(spline.at(1e-9)[2].abs() < 1e-5);
    }

    #[test]
    fn bad_points_are_refused() {
        assert!(Spline::new(vec![0.0], vec![0.0]).is_err());
        assert!(Spline::new(vec![0.0, 0.0], vec![0.0, 1.0]).is_err());
        assert!(Spline::new(vec![0.0, 1.0], vec![0.0, f64::NAN]).is_err());
        assert!(Spline::new(vec![0.0, 1.0], vec![0.0]).is_err());
    }
}
