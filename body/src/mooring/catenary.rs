//! The elastic catenary.

use super::require;
use crate::BodyError;
use nalgebra::Vector2;

/// Iterations of the root search: enough to halve any interval down to rounding.
const ITERATIONS: usize = 200;

/// A heavy elastic line in equilibrium at every moment, after Jonkman (2007), *Dynamics modeling
/// and loads analysis of an offshore floating wind turbine*, NREL/TP-500-41958, section 2.3, with
/// w the weight in water for each metre of unstretched line and EA the axial stiffness.
///
/// If the anchor lies on the bed, the line may rest on it in part, without friction. Otherwise it
/// hangs between its ends, and nothing keeps it above the bed.
///
/// With H and V the horizontal and vertical tension at the fairlead, x and z its distances from
/// the anchor, and L the unstretched length, a line that hangs over all its length has
///
/// - x = (H/w) [asinh(V/H) − asinh((V − w L)/H)] + H L/EA,
/// - z = (H/w) [√(1 + (V/H)²) − √(1 + ((V − w L)/H)²)] + (V L − w L²/2)/EA,
///
/// and one that rests on the bed from the anchor on, V < w L,
///
/// - x = L − V/w + (H/w) asinh(V/H) + H L/EA,
/// - z = (H/w) [√(1 + (V/H)²) − 1] + V²/(2 w EA).
///
/// In each, z rises with V, and x with H along the solutions V of the second equation: two nested
/// searches for a root that is known to lie within an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Catenary {
    /// EA: tension for each strain, N/m.
    pub axial_stiffness: f64,
    /// w: weight in water of each metre of unstretched line, N/m².
    pub weight: f64,
    /// L: unstretched length, m.
    pub unstretched_length: f64,
    /// Whether the anchor lies on the bed, so that the line can rest on it.
    pub anchored_on_bed: bool,
}

impl Catenary {
    /// A line of this axial stiffness (N/m), weight in water (N/m²) and unstretched length (m).
    ///
    /// # Errors
    /// [`BodyError::Line`]: all must be positive.
    pub fn new(
        axial_stiffness: f64,
        weight: f64,
        unstretched_length: f64,
        anchored_on_bed: bool,
    ) -> Result<Self, BodyError> {
        for (property, value) in [
            ("axial stiffness (N/m)", axial_stiffness),
            ("weight in water (N/m2)", weight),
            ("unstretched length (m)", unstretched_length),
        ] {
            require(value > 0.0, property, value, "positive and finite")?;
        }
        Ok(Self { axial_stiffness, weight, unstretched_length, anchored_on_bed })
    }

    /// Force (N/m) on the fairlead, at `span` (m) from the anchor, and the stretched length (m).
    pub(super) fn pull(&self, span: Vector2<f64>) -> (Vector2<f64>, f64) {
        let (horizontal, vertical) = self.fairlead_tension(span);
        let length = self.stretched_length(horizontal, vertical);
        (Vector2::new(-horizontal * span.x.signum(), -vertical), length)
    }

    /// H and V at the fairlead, N/m.
    fn fairlead_tension(&self, span: Vector2<f64>) -> (f64, f64) {
        let x = span.x.abs();
        if self.anchored_on_bed
            && let Some(resting) = self.resting(x, span.y.max(0.0))
        {
            return resting;
        }
        self.hanging(x, span.y)
    }

    /// H and V where part of the line rests on the bed; `None` where none does.
    fn resting(&self, x: f64, z: f64) -> Option<(f64, f64)> {
        let Self { axial_stiffness: ea, weight: w, unstretched_length: length, .. } = *self;
        // The second equation, solved: T + T²/(2 EA) = H + H²/(2 EA) + w z, T² = H² + V².
        let vertical = |h: f64| {
            let tension = ea * (sqrt_1p_minus_1(2.0 * (h + h * h / (2.0 * ea) + w * z) / ea));
            ((tension - h) * (tension + h)).max(0.0).sqrt()
        };
        let excess = |h: f64| {
            let v = vertical(h);
            length - v / w + h_asinh(h, v) / w + h * length / ea - x
        };
        let lifted = w * length;
        if vertical(0.0) >= lifted {
            return None;
        }
        if excess(0.0) >= 0.0 {
            return Some((0.0, vertical(0.0)));
        }
        // Straight along the bed it would be stretched by x/L − 1.
        let h = root(0.0, ea * (x / length).max(1.0), excess);
        let v = vertical(h);
        (v < lifted).then_some((h, v))
    }

    /// H and V of a line that hangs over all its length.
    fn hanging(&self, x: f64, z: f64) -> (f64, f64) {
        let Self { axial_stiffness: ea, weight: w, unstretched_length: length, .. } = *self;
        let half = 0.5 * w * length;
        let vertical = |h: f64| {
            let rise = |v: f64| {
                let inextensible = (h.hypot(v) - h.hypot(v - 2.0 * half)) / w;
                inextensible + (v - half) * length / ea - z
            };
            // The first term lies within ± L.
            let middle = half + ea * z / length;
            root(middle - ea, middle + ea, rise)
        };
        let reach = |h: f64| {
            let v = vertical(h);
            (h_asinh(h, v) - h_asinh(h, v - 2.0 * half)) / w + h * length / ea - x
        };
        let h = if reach(0.0) >= 0.0 { 0.0 } else { root(0.0, ea * x / length, reach) };
        (h, vertical(h))
    }

    /// L + ∫ T ds/EA over the unstretched line, m.
    fn stretched_length(&self, h: f64, v: f64) -> f64 {
        let Self { axial_stiffness: ea, weight: w, unstretched_length: length, .. } = *self;
        // ∫ √(H² + v²) dv, from the end of the part that hangs to the fairlead.
        let integral = |v: f64| 0.5 * (v * h.hypot(v) + h * h_asinh(h, v));
        let low = v - w * length;
        let resting = if self.anchored_on_bed { (-low).max(0.0) / w } else { 0.0 };
        let start = if resting > 0.0 { 0.0 } else { low };
        length + (h * resting + (integral(v) - integral(start)) / w) / ea
    }
}

/// H asinh(V/H), which tends to 0 with H.
fn h_asinh(h: f64, v: f64) -> f64 {
    if h > 0.0 { h * (v / h).asinh() } else { 0.0 }
}

/// √(1 + x) − 1 without loss of digits.
fn sqrt_1p_minus_1(x: f64) -> f64 {
    x / ((1.0 + x).sqrt() + 1.0)
}

/// Root of a function that rises through zero between `low` and `high`, to rounding: regula falsi
/// with the value at the end that stays halved (Illinois; Dowell and Jarratt 1971), and a bisection
/// every third time or where it stands still. The nearer end where there is no root.
fn root(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut f_low, mut f_high) = (f(low), f(high));
    if f_low >= 0.0 {
        return low;
    }
    if f_high <= 0.0 {
        return high;
    }
    for iteration in 0..ITERATIONS {
        let middle = low + 0.5 * (high - low);
        let secant = low - f_low * (high - low) / (f_high - f_low);
        let inside = secant > low && secant < high;
        let x = if inside && iteration % 3 != 2 { secant } else { middle };
        if x <= low || x >= high {
            break;
        }
        let value = f(x);
        if value < 0.0 {
            (low, f_low) = (x, value);
            f_high *= 0.5;
        } else {
            (high, f_high) = (x, value);
            f_low *= 0.5;
        }
        if high - low <= 4.0 * f64::EPSILON * (low.abs() + high.abs()) {
            break;
        }
    }
    0.5 * (low + high)
}
