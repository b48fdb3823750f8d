//! How far a series is from its reference, and how fast a wave goes from one gauge to another.

/// Relative error of Eq. (31), √Σ(found − reference)² / √Σ reference², over the samples that both
/// have. `None` without any, or for a reference that is zero.
#[must_use]
pub fn relative_error(found: &[f64], reference: &[f64]) -> Option<f64> {
    let (mut difference, mut size) = (0.0, 0.0);
    for (a, b) in found.iter().zip(reference) {
        difference += (a - b).powi(2);
        size += b * b;
    }
    (size > 0.0).then(|| (difference / size).sqrt())
}

/// Time (s) by which `second` follows `first`, both sampled every `interval` (s): the lag of the
/// greatest correlation within `window` (s) of `guess` (s). The speed of the wave is the distance
/// of the gauges over it. A window of half a period or less keeps a regular wave unambiguous.
/// `None` if the records do not hold lags on both sides of it.
#[must_use]
pub fn travel_time(
    interval: f64,
    first: &[f64],
    second: &[f64],
    guess: f64,
    window: f64,
) -> Option<f64> {
    let samples = first.len().min(second.len());
    let low = ((guess - window) / interval).round().max(0.0) as usize;
    let high = ((guess + window) / interval).round().max(0.0) as usize;
    if low >= high || high + 8 > samples {
        return None;
    }
    // Every lag compares as many samples, and each is normalized: otherwise a record that begins
    // or ends within a wave would pull the maximum.
    let compared = samples - high;
    let correlation = |lag: usize| {
        let pairs = first[..compared].iter().zip(&second[lag..lag + compared]);
        let (ab, bb) = pairs.fold((0.0, 0.0), |(ab, bb), (a, b)| (ab + a * b, bb + b * b));
        if bb > 0.0 { ab / f64::sqrt(bb) } else { 0.0 }
    };
    let values: Vec<f64> = (low..=high).map(correlation).collect();
    let best = (0..values.len()).max_by(|a, b| values[*a].total_cmp(&values[*b]))?;
    if best == 0 || best + 1 == values.len() {
        return None;
    }
    let (before, at, after) = (values[best - 1], values[best], values[best + 1]);
    let curvature = before - 2.0 * at + after;
    let offset = if curvature < 0.0 { 0.5 * (before - after) / curvature } else { 0.0 };
    Some((low as f64 + best as f64 + offset) * interval)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::waves::solitary::{SolitaryTheory, SolitaryWave};
    use crate::waves::stream_function::{Current, Extent, StreamFunctionWave};
    use crate::waves::{StillWater, WaveTheory};

    #[test]
    fn relative_error_of_a_shift_and_a_factor() {
        let reference: Vec<f64> = (0..1000).map(|i| (f64::from(i) * 0.0628).sin()).collect();
        let larger: Vec<f64> = reference.iter().map(|value| 1.07 * value).collect();
        assert!((relative_error(&larger, &reference).unwrap() - 0.07).abs() < 1e-12);
        // A phase of φ gives 2 sin(φ/2).
        let late: Vec<f64> = (0..1000).map(|i| (f64::from(i) * 0.0628 - 0.08).sin()).collect();
        let error = relative_error(&late, &reference).unwrap();
        assert!((error - 2.0 * 0.04f64.sin()).abs() < 1e-4, "{error}");
        assert_eq!(relative_error(&[], &[]), None);
    }

    #[test]
    fn celerity_of_a_regular_and_of_a_solitary_wave() {
        let water = StillWater { depth: 0.4, gravity: 9.81 };
        let (extent, current) = (Extent::Period(1.2), Current::MassTransport(0.0));
        let regular = StreamFunctionWave::new(water, 0.06, extent, current, 12).unwrap();
        let theory = SolitaryTheory::Exact;
        let solitary = SolitaryWave::new(water, 0.1, theory, -4.0).unwrap();
        let waves: [(&dyn WaveTheory, f64); 2] = [(&regular, 0.5), (&solitary, 2.0)];
        for (wave, window) in waves {
            let record = |x: f64| -> Vec<f64> {
                (0..1200).map(|i| wave.elevation(x, f64::from(i) * 0.01)).collect()
            };
            let exact = wave.celerity().unwrap();
            let time = travel_time(0.01, &record(1.0), &record(4.0), 1.8, window).unwrap();
            assert!((3.0 / time / exact - 1.0).abs() < 1e-3, "{} {exact}", 3.0 / time);
        }
        assert_eq!(travel_time(0.01, &[0.0; 20], &[0.0; 20], 1.0, 0.5), None);
    }
}
