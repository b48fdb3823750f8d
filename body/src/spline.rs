//! Interpolation of samples by a cubic spline.

/// A cubic spline with two continuous derivatives through samples at rising abscissae, its third
/// derivative continuous at the second and the last but one ("not a knot"; de Boor 1978,
/// chapter IV), so that it is of fourth order up to its ends.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CubicSpline {
    values: Vec<f64>,
    /// Second derivative at each sample.
    curvatures: Vec<f64>,
}

impl CubicSpline {
    /// Through `values` at `abscissae`: as many of either, at least four, the latter rising.
    pub(crate) fn new(abscissae: &[f64], values: Vec<f64>) -> Self {
        let count = values.len();
        let width: Vec<f64> = abscissae.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let slope: Vec<f64> =
            values.windows(2).zip(&width).map(|(pair, h)| (pair[1] - pair[0]) / h).collect();
        let inner = count - 2;
        let mut diagonal: Vec<f64> = (0..inner).map(|i| 2.0 * (width[i] + width[i + 1])).collect();
        let mut lower = width[..inner].to_vec();
        let mut upper = width[1..].to_vec();
        let mut curvature: Vec<f64> = (0..inner).map(|i| 6.0 * (slope[i + 1] - slope[i])).collect();
        // The end curvatures continue the line through their two neighbours.
        let (first, last) = (width[0] / width[1], width[count - 2] / width[count - 3]);
        diagonal[0] += width[0] * (1.0 + first);
        upper[0] -= width[0] * first;
        diagonal[inner - 1] += width[count - 2] * (1.0 + last);
        lower[inner - 1] -= width[count - 2] * last;
        // The system is tridiagonal and diagonally dominant.
        for i in 1..inner {
            let factor = lower[i] / diagonal[i - 1];
            diagonal[i] -= factor * upper[i - 1];
            curvature[i] -= factor * curvature[i - 1];
        }
        for i in (0..inner).rev() {
            let known = if i + 1 < inner { upper[i] * curvature[i + 1] } else { 0.0 };
            curvature[i] = (curvature[i] - known) / diagonal[i];
        }
        let (left, right) = (&curvature[..2], &curvature[inner - 2..]);
        let start = left[0] - first * (left[1] - left[0]);
        let end = right[1] + last * (right[1] - right[0]);
        let curvatures = [&[start], &curvature[..], &[end]].concat();
        Self { values, curvatures }
    }

    /// Value, first and second derivative at `x` between the samples `left` and `left + 1`.
    pub(crate) fn at(&self, abscissae: &[f64], left: usize, x: f64) -> [f64; 3] {
        let right = left + 1;
        let h = abscissae[right] - abscissae[left];
        let (a, b) = ((abscissae[right] - x) / h, (x - abscissae[left]) / h);
        let (y0, y1) = (self.values[left], self.values[right]);
        let (m0, m1) = (self.curvatures[left], self.curvatures[right]);
        [
            a * y0 + b * y1 + ((a * a * a - a) * m0 + (b * b * b - b) * m1) * h * h / 6.0,
            (y1 - y0) / h + ((3.0 * b * b - 1.0) * m1 - (3.0 * a * a - 1.0) * m0) * h / 6.0,
            a * m0 + b * m1,
        ]
    }
}
