//! Quadrature over an interval: Simpson's rule, and Gauss's with eight points.

/// ∫ f from `low` to `high` with `panels` pairs of intervals.
pub(crate) fn simpson(low: f64, high: f64, panels: usize, f: impl Fn(f64) -> f64) -> f64 {
    let count = 2 * panels.max(1);
    let width = (high - low) / count as f64;
    let inner: f64 =
        (1..count).map(|i| if i % 2 == 1 { 4.0 } else { 2.0 } * f(low + width * i as f64)).sum();
    (f(low) + inner + f(high)) * width / 3.0
}

/// Places and weights of Gauss's rule with eight points over −1 to 1, those above the middle.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_26),
];

/// The places between `low` and `high` and the weights with which a function there adds up to its
/// integral, one after the other; for functions that cost much, or many at once.
pub(crate) fn gauss(low: f64, high: f64, mut at: impl FnMut(f64, f64)) {
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    for (place, weight) in GAUSS {
        at(middle - half * place, half * weight);
        at(middle + half * place, half * weight);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_for_cubics_and_fourth_order_beyond() {
        assert!((simpson(1.0, 3.0, 1, |x| x * x * x - x) - 16.0).abs() < 1e-14);
        let error = |panels| (simpson(0.0, 1.0, panels, f64::exp) - 1f64.exp() + 1.0).abs();
        assert!(((error(4) / error(8)).log2() - 4.0).abs() < 0.05);
    }

    #[test]
    fn eight_points_are_exact_for_powers_up_to_fifteen() {
        for power in 0..16 {
            let mut sum = 0.0;
            gauss(0.5, 2.0, |x, weight| sum += weight * x.powi(power));
            let exact = (2f64.powi(power + 1) - 0.5f64.powi(power + 1)) / f64::from(power + 1);
            assert!((sum / exact - 1.0).abs() < 1e-13, "{power}");
        }
    }
}
