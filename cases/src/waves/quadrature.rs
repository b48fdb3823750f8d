//! Simpson's rule.

/// ∫ f from `low` to `high` with `panels` pairs of intervals.
pub(crate) fn simpson(low: f64, high: f64, panels: usize, f: impl Fn(f64) -> f64) -> f64 {
    let count = 2 * panels.max(1);
    let width = (high - low) / count as f64;
    let inner: f64 =
        (1..count).map(|i| if i % 2 == 1 { 4.0 } else { 2.0 } * f(low + width * i as f64)).sum();
    (f(low) + inner + f(high)) * width / 3.0
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
}
