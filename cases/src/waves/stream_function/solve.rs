//! The nonlinear equations of a stream-function wave: Newton's method with continuation in the
//! height. Lengths in depths, velocities in √(g D).
//!
//! Unknowns: η_0 … η_N from crest to trough (above the bed), B_1 … B_N, Ū, k, Q, R.
//! Equations: ψ = −Q and Bernoulli at every place, the mean level, the height, and the length.

use super::{Current, Extent, highest_wave};
use crate::waves::StillWater;
use crate::waves::WaveError;
use crate::waves::dispersion::{cosh_over_cosh, sinh_over_cosh};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::{PI, TAU};

/// Largest residual of a solution.
const TOLERANCE: f64 = 1e-11;
/// Newton steps before an attempt is given up.
const MAX_ITERATIONS: usize = 25;
/// Part of the height below which the continuation gives up.
const SMALLEST_STEP: f64 = 1e-4;
/// Ursell number H L²/D³ of the first wave: nearly linear.
const FIRST_URSELL: f64 = 4.0;

/// A wave that is looked for.
pub(super) struct Problem {
    pub(super) height: f64,
    pub(super) extent: Extent,
    pub(super) current: Current,
    pub(super) order: usize,
}

/// A wave that was found.
pub(super) struct Solution {
    /// Height of the surface above the bed, from crest to trough.
    pub(super) surface: Vec<f64>,
    /// B_1 … B_N.
    pub(super) coefficients: Vec<f64>,
    pub(super) mean_speed: f64,
    pub(super) wave_number: f64,
    pub(super) celerity: f64,
}

/// Why there is none.
pub(super) enum Failure {
    Breaking { height: f64, limit: f64, length: f64 },
    NoConvergence { height: f64, residual: f64, iterations: usize },
}

impl Failure {
    /// The same in metres.
    pub(super) fn in_units(self, depth: f64) -> WaveError {
        match self {
            Self::Breaking { height, limit, length } => WaveError::Breaking {
                height: height * depth,
                limit: limit * depth,
                length: Some(length * depth),
                depth,
            },
            Self::NoConvergence { height, residual, iterations } => WaveError::NoConvergence {
                theory: "stream-function wave",
                height: height * depth,
                residual,
                iterations,
            },
        }
    }
}

/// Where each unknown stands.
struct Layout {
    order: usize,
}

impl Layout {
    fn coefficient(&self, j: usize) -> usize {
        self.order + j
    }
    fn mean_speed(&self) -> usize {
        2 * self.order + 1
    }
    fn wave_number(&self) -> usize {
        2 * self.order + 2
    }
    fn flux(&self) -> usize {
        2 * self.order + 3
    }
    fn energy(&self) -> usize {
        2 * self.order + 4
    }
    fn len(&self) -> usize {
        2 * self.order + 5
    }
}

impl Problem {
    /// Raises the height from a nearly linear wave to the one asked for.
    pub(super) fn solve(&self) -> Result<Solution, Failure> {
        let layout = Layout { order: self.order };
        let linear = self.linear_length();
        self.refuse_breaking(0.0, linear)?;
        let first = (FIRST_URSELL / linear.powi(2)).min(0.02 * linear).min(self.height);
        let (mut height, mut solved) = (0.0, self.linear_wave(&layout, first));
        let mut before: Option<(f64, DVector<f64>)> = None;
        let mut step = first;
        loop {
            let next = (height + step).min(self.height);
            // The first guess extrapolates the last two waves.
            let guess = match &before {
                Some((earlier, wave)) => {
                    &solved + (&solved - wave) * ((next - height) / (height - earlier))
                }
                None => solved.clone(),
            };
            match self.newton(&layout, next, guess) {
                Ok(found) => {
                    if height > 0.0 {
                        before = Some((height, solved));
                    }
                    (height, solved) = (next, found);
                    let length = TAU / solved[layout.wave_number()];
                    self.refuse_breaking(height, length)?;
                    if height >= self.height {
                        return Ok(self.solution(&layout, &solved));
                    }
                    step *= 2.0;
                }
                Err((residual, iterations)) => {
                    step *= 0.25;
                    if step < SMALLEST_STEP * self.height {
                        return Err(Failure::NoConvergence { height, residual, iterations });
                    }
                }
            }
        }
    }

    /// Refuses the wave if waves of `length`, where `height` has been reached, are lower.
    fn refuse_breaking(&self, height: f64, length: f64) -> Result<(), Failure> {
        // A wave of given period grows longer with its height, by less than a fifth.
        let longest = match self.extent {
            Extent::Period(_) if height < self.height => 1.2 * length,
            _ => length,
        };
        let limit = highest_wave(1.0, longest);
        if self.height > limit {
            return Err(Failure::Breaking { height: self.height, limit, length: longest });
        }
        Ok(())
    }

    fn linear_length(&self) -> f64 {
        match self.extent {
            Extent::Wavelength(length) => length,
            Extent::Period(period) => {
                TAU / StillWater { depth: 1.0, gravity: 1.0 }.wave_number(TAU / period)
            }
        }
    }

    fn linear_wave(&self, layout: &Layout, height: f64) -> DVector<f64> {
        let k = TAU / self.linear_length();
        let celerity = (k.tanh() / k).sqrt();
        let mut unknowns = DVector::zeros(layout.len());
        for m in 0..=self.order {
            unknowns[m] = 1.0 + 0.5 * height * (PI * m as f64 / self.order as f64).cos();
        }
        unknowns[layout.coefficient(1)] = 0.5 * height / (celerity * k);
        unknowns[layout.mean_speed()] = celerity;
        unknowns[layout.wave_number()] = k;
        unknowns[layout.flux()] = celerity;
        unknowns[layout.energy()] = 1.0 + 0.5 * celerity * celerity;
        unknowns
    }

    /// Newton's method at one height; the residual and iterations where it fails.
    fn newton(
        &self,
        layout: &Layout,
        height: f64,
        mut unknowns: DVector<f64>,
    ) -> Result<DVector<f64>, (f64, usize)> {
        let mut largest = f64::INFINITY;
        for iteration in 0..MAX_ITERATIONS {
            let (residual, jacobian) = self.equations(layout, height, &unknowns);
            largest = residual.amax();
            if largest < TOLERANCE {
                return if self.is_one_wave(&unknowns) {
                    Ok(unknowns)
                } else {
                    Err((largest, iteration))
                };
            }
            match jacobian.lu().solve(&residual) {
                Some(change) if change.iter().all(|c| c.is_finite()) => unknowns -= change,
                _ => return Err((largest, iteration)),
            }
        }
        Err((largest, MAX_ITERATIONS))
    }

    /// Whether the surface falls from crest to trough: the equations have other solutions too,
    /// waves of a third of the length.
    fn is_one_wave(&self, unknowns: &DVector<f64>) -> bool {
        let surface = &unknowns.as_slice()[..=self.order];
        surface[0] > 1.0 && surface.windows(2).all(|pair| pair[1] < pair[0] + 1e-4)
    }

    /// Residuals of all equations and their derivatives.
    fn equations(
        &self,
        layout: &Layout,
        height: f64,
        unknowns: &DVector<f64>,
    ) -> (DVector<f64>, DMatrix<f64>) {
        let order = self.order;
        let mut residual = DVector::zeros(layout.len());
        let mut jacobian = DMatrix::zeros(layout.len(), layout.len());
        let mean = unknowns[layout.mean_speed()];
        let k = unknowns[layout.wave_number()];
        let (flux, energy) = (unknowns[layout.flux()], unknowns[layout.energy()]);

        for m in 0..=order {
            let (stream, bernoulli) = (m, order + 1 + m);
            let y = unknowns[m];
            let (mut sum, mut sum_by_k) = (0.0, 0.0);
            let (mut u, mut v) = (-mean, 0.0);
            let (mut u_by_y, mut v_by_y, mut u_by_k, mut v_by_k) = (0.0, 0.0, 0.0, 0.0);
            let mut by_coefficient = Vec::with_capacity(order);
            for j in 1..=order {
                let (number, b) = (j as f64, unknowns[layout.coefficient(j)]);
                let jk = number * k;
                let (sin, cos) = (PI * (j * m) as f64 / order as f64).sin_cos();
                let (c, s) = (cosh_over_cosh(jk * y, jk), sinh_over_cosh(jk * y, jk));
                let tanh = jk.tanh();
                let (c_by_k, s_by_k) = (number * (y * s - tanh * c), number * (y * c - tanh * s));
                sum += b * s * cos;
                sum_by_k += b * s_by_k * cos;
                u += jk * b * c * cos;
                v += jk * b * s * sin;
                u_by_y += jk * jk * b * s * cos;
                v_by_y += jk * jk * b * c * sin;
                u_by_k += number * b * (c + k * c_by_k) * cos;
                v_by_k += number * b * (s + k * s_by_k) * sin;
                by_coefficient.push((s * cos, jk * c * cos, jk * s * sin));
            }
            // ψ = −Q.
            residual[stream] = -mean * y + sum + flux;
            jacobian[(stream, m)] = u;
            jacobian[(stream, layout.mean_speed())] = -y;
            jacobian[(stream, layout.wave_number())] = sum_by_k;
            jacobian[(stream, layout.flux())] = 1.0;
            // (u² + v²)/2 + η = R.
            residual[bernoulli] = 0.5 * (u * u + v * v) + y - energy;
            jacobian[(bernoulli, m)] = u * u_by_y + v * v_by_y + 1.0;
            jacobian[(bernoulli, layout.mean_speed())] = -u;
            jacobian[(bernoulli, layout.wave_number())] = u * u_by_k + v * v_by_k;
            jacobian[(bernoulli, layout.energy())] = -1.0;
            for (index, (psi, along, up)) in by_coefficient.into_iter().enumerate() {
                let column = layout.coefficient(index + 1);
                jacobian[(stream, column)] = psi;
                jacobian[(bernoulli, column)] = u * along + v * up;
            }
        }

        let (level, difference, length) = (2 * order + 2, 2 * order + 3, 2 * order + 4);
        for m in 0..=order {
            let weight = if m == 0 || m == order { 0.5 } else { 1.0 } / order as f64;
            residual[level] += weight * unknowns[m];
            jacobian[(level, m)] = weight;
        }
        residual[level] -= 1.0;
        residual[difference] = unknowns[0] - unknowns[order] - height;
        jacobian[(difference, 0)] = 1.0;
        jacobian[(difference, order)] = -1.0;
        match self.extent {
            Extent::Wavelength(wavelength) => {
                residual[length] = k * wavelength - TAU;
                jacobian[(length, layout.wave_number())] = wavelength;
            }
            Extent::Period(period) => {
                let celerity = self.celerity(layout, unknowns);
                residual[length] = k * celerity * period - TAU;
                jacobian[(length, layout.wave_number())] = celerity * period;
                let with = match self.current {
                    Current::Eulerian(_) => layout.mean_speed(),
                    Current::MassTransport(_) => layout.flux(),
                };
                jacobian[(length, with)] = k * period;
            }
        }
        (residual, jacobian)
    }

    fn celerity(&self, layout: &Layout, unknowns: &DVector<f64>) -> f64 {
        match self.current {
            Current::Eulerian(flow) => unknowns[layout.mean_speed()] + flow,
            Current::MassTransport(flow) => unknowns[layout.flux()] + flow,
        }
    }

    fn solution(&self, layout: &Layout, unknowns: &DVector<f64>) -> Solution {
        Solution {
            surface: unknowns.as_slice()[..=self.order].to_vec(),
            coefficients: unknowns.as_slice()[layout.coefficient(1)..=2 * self.order].to_vec(),
            mean_speed: unknowns[layout.mean_speed()],
            wave_number: unknowns[layout.wave_number()],
            celerity: self.celerity(layout, unknowns),
        }
    }
}
