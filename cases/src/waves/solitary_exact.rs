//! The exact solitary wave: the Babenko equation on a conformal strip, solved by Petviashvili's
//! iteration (Clamond & Dutykh 2013). Lengths in depths, velocities in √(g D).
//!
//! The strip −∞ < ξ < ∞, 0 < Y < 1 is mapped to the fluid in the frame of the wave; η(ξ) is the
//! elevation over the strip's upper side, 𝒞 the operator with symbol k coth k, and
//! (F² 𝒞 − 1) η = η 𝒞η + 𝒞(η²/2). The velocity in the frame of the wave is −F / (dz/dζ).

use super::spline::Spline;
use super::{WaveError, solitary};
use nalgebra::{Complex, Vector2};
use realfft::RealFftPlanner;
use std::f64::consts::PI;

/// Points over the strip.
const POINTS: usize = 4096;
/// Half length of the strip over the length in which the tail falls by e.
const DECADES: f64 = 32.0;
/// Relative residual of the Babenko equation at which the iteration stops.
const TOLERANCE: f64 = 1e-13;
/// Steps of Petviashvili's iteration for one Froude number.
const MAX_ITERATIONS: usize = 4000;

/// A solitary wave with its crest at x = 0.
#[derive(Clone, Debug)]
pub(super) struct ExactSolitary {
    froude: f64,
    height: f64,
    /// Rate at which the tails fall, 1/depth.
    tail_rate: f64,
    /// k₁, the smallest wave number of the strip.
    wave_number: f64,
    /// 2 η̂_j / (1 − exp(−2 k_j)) of the modes that matter, j from 1.
    modes: Vec<f64>,
    /// η̂_0.
    mean: f64,
    /// Elevation over x ≥ 0, to where the tail is a plain exponential.
    profile: Spline,
}

impl ExactSolitary {
    /// The wave of `height` depths.
    pub(super) fn new(height: f64) -> Result<Self, WaveError> {
        // The crest of a wave of given Froude number is found, so a secant looks for the number.
        let first_guess = solitary::froude_of_third_order(height);
        let mut strip = Strip::new(tail_rate(first_guess));
        let mut surface: Vec<f64> =
            strip.places().map(|x| height / ((0.75 * height).sqrt() * x).cosh().powi(2)).collect();
        let mut froude = first_guess;
        let mut before: Option<(f64, f64)> = None;
        let mut crest = 0.0;
        for _ in 0..30 {
            strip.iterate(froude, &mut surface)?;
            crest = surface[0];
            let error = crest - height;
            if error.abs() < 1e-11 {
                return Self::from_surface(froude, &mut strip, &surface);
            }
            let slope = match before {
                Some((f, e)) if f != froude => (error - e) / (froude - f),
                // dH/dF of Boussinesq.
                _ => 2.0 * froude,
            };
            before = Some((froude, error));
            froude = (froude - error / slope).max(1.0 + 0.1 * height);
        }
        Err(WaveError::NoConvergence {
            theory: "exact solitary wave",
            height: crest,
            residual: (crest - height).abs(),
            iterations: 30,
        })
    }

    fn from_surface(froude: f64, strip: &mut Strip, surface: &[f64]) -> Result<Self, WaveError> {
        let spectrum = strip.spectrum(surface);
        let mean = spectrum[0];
        let largest = spectrum.iter().skip(1).fold(0.0f64, |a, b| a.max(b.abs()));
        let last = spectrum.iter().rposition(|a| a.abs() > 1e-15 * largest).unwrap_or(0);
        let modes = (1..=last).map(|j| {
            let k = strip.wave_number * j as f64;
            2.0 * spectrum[j] / (1.0 - (-2.0 * k).exp())
        });
        let mut wave = Self {
            froude,
            height: surface[0],
            tail_rate: tail_rate(froude),
            wave_number: strip.wave_number,
            modes: modes.collect(),
            mean,
            profile: Spline::new(vec![0.0, 1.0], vec![0.0, 0.0])?,
        };
        // The profile over x, finer than the grid of the strip, up to a tail of 1e-6 of the crest
        // and symmetric about it, so that the spline is smooth there.
        let end = (1e6f64).ln() / wave.tail_rate;
        let count = 2000;
        let half: Vec<(f64, f64)> =
            (1..=count).map(|i| wave.surface_at(end * f64::from(i) / f64::from(count))).collect();
        let mut points: Vec<(f64, f64)> = half.iter().rev().map(|(x, y)| (-x, *y)).collect();
        points.push((0.0, wave.height));
        points.extend(half);
        let (x, y) = points.into_iter().unzip();
        wave.profile = Spline::new(x, y)?;
        Ok(wave)
    }

    pub(super) fn froude(&self) -> f64 {
        self.froude
    }

    pub(super) fn tail_rate(&self) -> f64 {
        self.tail_rate
    }

    /// Elevation at `x` from the crest.
    pub(super) fn elevation(&self, x: f64) -> f64 {
        let (_, end) = self.profile.range();
        // Within the tail the spline ends without curvature: leave its last tenth out.
        let joint = 0.9 * end;
        if x.abs() <= joint {
            self.profile.at(x)[0]
        } else {
            self.profile.at(joint)[0] * (-self.tail_rate * (x.abs() - joint)).exp()
        }
    }

    /// Velocity at `x` from the crest and `y` above the bed, with respect to the water at rest.
    pub(super) fn velocity(&self, x: f64, y: f64) -> Vector2<f64> {
        let (_, end) = self.profile.range();
        if x.abs() > end {
            // The linear tail: η exp(∓κ x) on a flow with cos κy and sin κy over the depth.
            let (k, sign) = (self.tail_rate, x.signum());
            let scale = self.froude * k * self.elevation(x) / k.sin();
            return scale * Vector2::new((k * y).cos(), sign * (k * y).sin());
        }
        let surface = 1.0 + self.elevation(x);
        let target = Complex::new(x, y.min(surface));
        let mut strip = Complex::new(x, target.im / surface);
        let mut slope = Complex::new(1.0, 0.0);
        for _ in 0..30 {
            let (place, by) = self.map(strip);
            slope = by;
            let change = (place - target) / slope;
            strip -= change;
            if change.norm() < 1e-13 {
                break;
            }
        }
        let velocity = self.froude - self.froude / slope;
        Vector2::new(velocity.re, -velocity.im)
    }

    /// The surface point over `xi`.
    fn surface_at(&self, xi: f64) -> (f64, f64) {
        let place = self.map(Complex::new(xi, 1.0)).0;
        (place.re, place.im - 1.0)
    }

    /// z(ζ) and dz/dζ: y = Y (1 + η̂_0) + Σ 2 η̂ sinh kY / sinh k cos kξ.
    fn map(&self, zeta: Complex<f64>) -> (Complex<f64>, Complex<f64>) {
        let k = self.wave_number;
        let turn = Complex::new((k * zeta.re).cos(), (k * zeta.re).sin());
        let (up, down) = (turn * (k * (zeta.im - 1.0)).exp(), turn * (-k * (zeta.im + 1.0)).exp());
        let (mut rising, mut falling) = (Complex::new(1.0, 0.0), Complex::new(1.0, 0.0));
        let mut place = zeta * (1.0 + self.mean);
        let mut slope = Complex::new(1.0 + self.mean, 0.0);
        for (index, mode) in self.modes.iter().enumerate() {
            rising *= up;
            falling *= down;
            let (sum, difference) = (rising + falling, rising - falling);
            let number = k * (index + 1) as f64;
            place += mode * Complex::new(sum.im, difference.re);
            slope += mode * number * Complex::new(sum.re, -difference.im);
        }
        (place, slope)
    }
}

/// Rate κ at which the tails of a wave of Froude number `froude` fall: tan κ = F² κ, κ < π/2.
fn tail_rate(froude: f64) -> f64 {
    let (mut low, mut high) = (1e-9, 0.5 * PI - 1e-12);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if middle.tan() < froude * froude * middle {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

/// The periodic strip that stands for the infinite one, with its Fourier transforms.
struct Strip {
    half_length: f64,
    wave_number: f64,
    forward: std::sync::Arc<dyn realfft::RealToComplex<f64>>,
    backward: std::sync::Arc<dyn realfft::ComplexToReal<f64>>,
}

impl Strip {
    fn new(tail_rate: f64) -> Self {
        let half_length = DECADES / tail_rate;
        let mut planner = RealFftPlanner::new();
        Self {
            half_length,
            wave_number: PI / half_length,
            forward: planner.plan_fft_forward(POINTS),
            backward: planner.plan_fft_inverse(POINTS),
        }
    }

    /// ξ of the points: from the crest to the end, then from the other end back to the crest.
    fn places(&self) -> impl Iterator<Item = f64> {
        let spacing = 2.0 * self.half_length / POINTS as f64;
        (0..POINTS).map(move |i| {
            let signed = if i <= POINTS / 2 { i as f64 } else { i as f64 - POINTS as f64 };
            signed * spacing
        })
    }

    /// Real Fourier coefficients of an even function.
    fn spectrum(&mut self, values: &[f64]) -> Vec<f64> {
        self.transform(values).iter().map(|c| c.re / POINTS as f64).collect()
    }

    fn transform(&self, values: &[f64]) -> Vec<Complex<f64>> {
        let mut input = values.to_vec();
        let mut output = self.forward.make_output_vec();
        // The lengths are the planner's own.
        let _ = self.forward.process(&mut input, &mut output);
        output
    }

    fn inverse(&self, mut spectrum: Vec<Complex<f64>>) -> Vec<f64> {
        let mut output = self.backward.make_output_vec();
        for value in &mut spectrum {
            // The functions are even: what is left beside the real part is rounding.
            value.im = 0.0;
        }
        let _ = self.backward.process(&mut spectrum, &mut output);
        output.iter_mut().for_each(|value| *value /= POINTS as f64);
        output
    }

    /// Symbol of 𝒞 at mode `index`.
    fn symbol(&self, index: usize) -> f64 {
        let k = self.wave_number * index as f64;
        if index == 0 { 1.0 } else { k / k.tanh() }
    }

    /// Petviashvili's iteration at a fixed Froude number, from and into `surface`.
    fn iterate(&mut self, froude: f64, surface: &mut Vec<f64>) -> Result<(), WaveError> {
        let mut residual = f64::INFINITY;
        for _ in 0..MAX_ITERATIONS {
            let spectrum = self.transform(surface);
            let squares: Vec<f64> = surface.iter().map(|eta| 0.5 * eta * eta).collect();
            let of_squares = self.transform(&squares);
            let applied = self.inverse(
                spectrum.iter().enumerate().map(|(j, value)| value * self.symbol(j)).collect(),
            );
            let products: Vec<f64> = surface.iter().zip(&applied).map(|(a, b)| a * b).collect();
            let of_products = self.transform(&products);
            let (mut linear, mut nonlinear, mut difference) = (0.0, 0.0, 0.0);
            let mut next = Vec::with_capacity(spectrum.len());
            for (j, eta) in spectrum.iter().enumerate() {
                let operator = froude * froude * self.symbol(j) - 1.0;
                let right = of_products[j].re + self.symbol(j) * of_squares[j].re;
                let weight = if j == 0 { 1.0 } else { 2.0 };
                linear += weight * eta.re * operator * eta.re;
                nonlinear += weight * eta.re * right;
                difference += weight * (operator * eta.re - right).powi(2) / operator;
                next.push(right / operator);
            }
            let factor = linear / nonlinear;
            residual = (difference / linear).sqrt();
            *surface = self.inverse(
                next.into_iter().map(|value| Complex::new(value * factor * factor, 0.0)).collect(),
            );
            if residual < TOLERANCE {
                return Ok(());
            }
        }
        Err(WaveError::NoConvergence {
            theory: "exact solitary wave",
            height: surface[0],
            residual,
            iterations: MAX_ITERATIONS,
        })
    }
}
