//! Loads on rigid boundaries: pressure at the wall particles, integrated over the wetted wall.

use crate::error::FluidError;
use crate::fields::Fields;
use crate::fit;
use crate::fluid::Fluid;
use crate::geometry::cross;
use crate::small_matrix::Symmetric;
use crate::walls::Owner;
use nalgebra::{Point2, Vector2};
use rayon::prelude::*;
use seakeep_coupler::interface::{Load, LoadResponse};

/// Largest sum of the sizes of the coefficients of a fit, those of slopes in spacings. Around a point
/// that water encloses or that lies on its edge it is 1 to 3; a fit with a larger one carries what
/// few particles say on to where they say nothing, as of a film of water to the wall before it.
const LARGEST_SUM: f64 = 8.0;

/// Fewest particles that are fitted to: as many as a quadratic has coefficients.
const FEWEST: usize = 6;

/// Pressure at a point as a linear functional of the pressures around it: a quadratic
/// least-squares fit about the point itself, with the walls' Neumann data as rows.
#[derive(Clone, Debug)]
pub(crate) struct PointPressure {
    /// Fluid particle and its coefficient.
    values: Vec<(u32, f64)>,
    /// Wall particle and the coefficient of its ∂p/∂n.
    slopes: Vec<(u32, f64)>,
}

impl Default for PointPressure {
    /// With room for a neighbourhood, so that no later step needs to make it.
    fn default() -> Self {
        Self { values: Vec::with_capacity(64), slopes: Vec::with_capacity(16) }
    }
}

impl PointPressure {
    /// Builds the functional at `centre` from the fluid particles `around` it and those of the
    /// wall particles `walls` that bound the water.
    pub(crate) fn build(
        &mut self,
        fields: Fields,
        centre: Point2<f64>,
        around: impl Iterator<Item = u32>,
        walls: impl Iterator<Item = usize>,
    ) {
        self.values.clear();
        self.slopes.clear();
        let scale = 1.0 / fields.spacing;
        let mut matrix = Symmetric::<6>::zero();
        let full = |b: [f64; 5], one: f64| [one, b[0], b[1], b[2], b[3], b[4]];
        for j in around {
            let d = (fields.position[j as usize] - centre) * scale;
            // The centre is no particle: the weight must not be singular there.
            let weight = fit::bell(d.norm_squared()) / (d.norm_squared() + 0.25);
            matrix.add_outer(weight, &full(fit::basis(d), 1.0));
            self.values.push((j, weight));
        }
        for v in walls {
            let d = (fields.walls.position[v] - centre) * scale;
            if fields.walls.activity[v] > 0.0 && d.norm_squared() < fit::RADIUS * fit::RADIUS {
                let weight = fields.walls.activity[v] * fit::bell(d.norm_squared());
                let row = full(fit::normal_derivative(d, fields.walls.normal[v]), 0.0);
                matrix.add_outer(weight, &row);
                self.slopes.push((v as u32, weight));
            }
        }
        let corner = (fields.walls.corner(centre, fields.spacing)).map(|(index, restraint)| {
            let corner = &fields.walls.corners[index as usize];
            let from = |x: Point2<f64>| corner.potential((x - corner.position) * scale);
            let own = from(centre);
            (move |j: u32| from(fields.position[j as usize]) - own, restraint)
        });
        // A quadratic fit; where it cannot be, one whose curvature is kept small.
        let trace: f64 = (0..6).map(|i| matrix.0[i][i]).sum();
        let fits = if self.values.len() < FEWEST { &[][..] } else { &[0.0, 10.0] };
        for penalty in fits.iter().map(|penalty| penalty * trace) {
            let mut matrix = matrix;
            for i in 3..6 {
                matrix.0[i][i] += penalty;
            }
            let Some(factor) = matrix.factorize(1e-5) else { continue };
            let mut value = factor.solve(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            let mut strength = 0.0;
            if let Some((potential, restraint)) = &corner {
                let (mut column, mut diagonal) = ([0.0; 6], 0.0);
                for &(j, weight) in &self.values {
                    let d = (fields.position[j as usize] - centre) * scale;
                    let weighted = weight * potential(j);
                    for (sum, b) in column.iter_mut().zip(full(fit::basis(d), 1.0)) {
                        *sum += weighted * b;
                    }
                    diagonal += weighted * potential(j);
                }
                let (solved, pivot) = fit::border(&factor, &column, diagonal * (1.0 + restraint));
                let met: f64 = column.iter().zip(&value).map(|(a, b)| a * b).sum();
                strength = -met / pivot;
                value.iter_mut().zip(&solved).for_each(|(value, s)| *value -= s * strength);
            }
            let apply = |row: [f64; 6]| -> f64 { row.iter().zip(&value).map(|(a, b)| a * b).sum() };
            let of_value = |j: u32| {
                let d = (fields.position[j as usize] - centre) * scale;
                let singular = corner.as_ref().map_or(0.0, |(potential, _)| potential(j));
                apply(full(fit::basis(d), 1.0)) + strength * singular
            };
            let of_slope = |v: u32| {
                let d = (fields.walls.position[v as usize] - centre) * scale;
                apply(full(fit::normal_derivative(d, fields.walls.normal[v as usize]), 0.0))
            };
            let values: f64 = self.values.iter().map(|&(j, c)| (c * of_value(j)).abs()).sum();
            let slopes: f64 = self.slopes.iter().map(|&(v, c)| (c * of_slope(v)).abs()).sum();
            if values.max(slopes) > LARGEST_SUM {
                continue;
            }
            self.values.iter_mut().for_each(|(j, c)| *c *= of_value(*j));
            self.slopes.iter_mut().for_each(|(v, c)| *c *= of_slope(*v) * fields.spacing);
            return;
        }
        // Too few particles for a fit: their mean.
        let total: f64 = self.values.iter().map(|(_, weight)| weight).sum();
        self.values.iter_mut().for_each(|(_, weight)| *weight /= total);
        self.slopes.clear();
    }

    /// Whether there was a particle to build on.
    pub(crate) fn is_some(&self) -> bool {
        !self.values.is_empty()
    }

    /// The pressure for particle pressures `value(j)` and wall slopes `slope(w)`, Pa.
    #[inline]
    pub(crate) fn evaluate(
        &self,
        value: impl Fn(usize) -> f64,
        slope: impl Fn(usize) -> f64,
    ) -> f64 {
        let values: f64 = self.values.iter().map(|&(j, c)| c * value(j as usize)).sum();
        let slopes: f64 = self.slopes.iter().map(|&(w, c)| c * slope(w as usize)).sum();
        values + slopes
    }
}

/// Load of a pressure `pressure` (Pa) on wall particle `w`, its wetted part of `length` (m)
/// centred at `point`: one term of Eqs. (19) and (20), the torque about `centre`.
pub(crate) fn load_on_piece(
    normal: Vector2<f64>,
    length: f64,
    point: Point2<f64>,
    centre: Point2<f64>,
    pressure: f64,
) -> Load {
    let force = -normal * (pressure * length);
    Load { force, torque: cross(point - centre, force) }
}

impl Fluid {
    /// F_0 and A of F = F_0 − A a in a step of `h` (s), Eqs. (19) and (20).
    ///
    /// # Errors
    /// [`FluidError::PressureNotConverged`].
    pub(crate) fn loads_at_zero_acceleration(&mut self, h: f64) -> Result<(), FluidError> {
        self.solve_repeated_pressure(h)?;
        let mut wall_pressure = std::mem::take(&mut self.work.wall_pressure);
        let fields = Self::fields(&self.setup, &self.state.particles, &self.walls, &self.work);
        let water = &self.setup.water;
        let mut response = std::mem::replace(&mut self.response, LoadResponse::zero(0));
        let (at_zero, added_mass) = (&mut response.at_zero_acceleration, &mut response.added_mass);
        at_zero.fill(Load::zero());
        added_mass.fill(0.0);
        for (b, total) in at_zero.iter_mut().enumerate() {
            let range = self.walls.of_boundary(b);
            let centre = self.walls.centre[b];
            wall_pressure.resize_with(range.len().max(wall_pressure.len()), Default::default);
            wall_pressure[..range.len()].par_iter_mut().enumerate().for_each(|(k, functional)| {
                let w = range.start + k;
                if self.walls.wetted[w] > 0.0 {
                    let around = self.work.fluid_of_walls.of(w).iter().copied();
                    functional.build(fields, self.walls.position[w], around, range.clone());
                }
            });
            for (w, functional) in range.clone().zip(&wall_pressure) {
                let wetted = self.walls.wetted[w];
                if wetted == 0.0 {
                    continue;
                }
                let value = |i: usize| {
                    if fields.on_surface[i] {
                        self.surface_pressure(i)
                    } else {
                        self.work.solution[i][0] - self.work.repeated[i][0]
                    }
                };
                let dynamic = functional.evaluate(value, |w| self.known_slope(w));
                let (normal, length) = (self.walls.normal[w], self.walls.length[w] * wetted);
                let point = self.walls.wetted_middle[w];
                let hydrostatic = water.density * water.gravity * (water.depth - point.y);
                let mut pressure = dynamic + hydrostatic;
                // Air gets behind a film that would pull at a wall.
                if self.work.broken.is_at(point.x) {
                    pressure = pressure.max(0.0);
                }
                let load = load_on_piece(normal, length, point, centre, pressure);
                total.force += load.force;
                total.torque += load.torque;
                for (slot, &other) in self.free.iter().enumerate() {
                    for mode in 0..3 {
                        let unit = functional.evaluate(
                            |i| self.work.unit_solution[slot][i][mode],
                            |w| {
                                if self.walls.owner[w] == Owner::Boundary(other) {
                                    self.slope(w, other, |k| f64::from(u8::from(k == mode)))
                                } else {
                                    0.0
                                }
                            },
                        );
                        let reaction = load_on_piece(normal, length, point, centre, unit);
                        let column = 3 * other + mode;
                        added_mass[(3 * b, column)] -= reaction.force.x;
                        added_mass[(3 * b + 1, column)] -= reaction.force.y;
                        added_mass[(3 * b + 2, column)] -= reaction.torque;
                    }
                }
            }
        }
        self.response = response;
        self.work.wall_pressure = wall_pressure;
        Ok(())
    }
}
