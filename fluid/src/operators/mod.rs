//! The operators of a step: around each particle the divergence of the velocity, the pressure equation
//! but for its source, the gradient functional and the shift.
//!
//! Two discretisations give them, second-order fits ([`quadratic`]) and conventional kernel sums
//! ([`conventional`]). Either says with which weight and row of five numbers a neighbour's
//! pressure and a wall's ∂p/∂n enter, and gives functionals by which the sum over these rows
//! becomes a gradient or a Laplacian; the later stages need not know which it is.

mod conventional;
mod plain;
mod quadratic;

use crate::fields::Fields;
use crate::fit::{self, PressureFit, Quality, Rows, Singular, VelocityFit, WallRow};
use crate::neighbours::BLOCK;
use crate::regularise;
use crate::setup::Discretisation;
use crate::sparse::SparseMatrix;
use nalgebra::{Matrix2, Vector2};
use rayon::prelude::*;

/// What the operators give for one particle.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Local {
    /// Pressure functionals; see [`PressureFit`].
    pub(crate) pressure: PressureFit,
    /// ∇u, 1/s: a row for each component of the velocity.
    pub(crate) velocity_gradient: Matrix2<f64>,
    /// ∇²u, 1/(m s).
    pub(crate) laplacian_of_velocity: Vector2<f64>,
    /// Smooth velocity minus velocity, m/s; on the surface as it is along it.
    pub(crate) roughness: Vector2<f64>,
    /// Shift towards a regular arrangement, m, and what it does to the velocity, m/s.
    pub(crate) shift: Vector2<f64>,
    pub(crate) shift_velocity: Vector2<f64>,
    pub(crate) quality: Quality,
    /// Part of the filter's rate that applies here.
    pub(crate) filter: f64,
    /// From the particle to the smooth surface, m; zero below the surface.
    pub(crate) surface_roughness: Vector2<f64>,
    /// The walls that it stands before: the nearest, and another in a corner.
    pub(crate) contacts: [Option<regularise::Contact>; 2],
    /// The corner whose function its fits take, if there is one.
    pub(crate) corner: Option<u32>,
}

/// What a particle's pressure equation has beside its row: all that is read of every particle where
/// right-hand sides are made, and so kept apart from the much larger [`Local`].
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Equation {
    /// Sum of the off-diagonal coefficients before the row was scaled by it; zero for a particle
    /// without an equation.
    pub(crate) diagonal: f64,
    /// ∇·u, 1/s.
    pub(crate) divergence: f64,
    /// Density of the particles around it relative to a lattice's; 1 on the surface.
    pub(crate) crowding: f64,
    /// What the known ∂p/∂n of the walls adds to dx² ∇²p, Pa; not divided by the diagonal yet.
    pub(crate) walls: f64,
    /// What the pressure of the surface neighbours adds to the particle's own, Pa; divided by it.
    pub(crate) surface: f64,
}

/// A particle whose row has a smaller diagonal has no equation of its own: its neighbours, a few in
/// the air or in line, say nothing of its pressure, which is that of the air. In the bulk the
/// diagonal is 5 and next to walls seldom below 1.
const LEAST_DIAGONAL: f64 = 0.3;

/// Scratch of a block of particles.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    rows: Rows,
    plain: plain::Scratch,
}

/// Computes everything local and assembles the pressure matrix: for an inner particle i
/// p_i − Σ a_ij p_j = −dx² f_i / d_i + (walls), for a surface particle p_i = 0.
/// Surface neighbours are left out of the matrix: their known pressure, `surface_pressure(j)` (Pa),
/// goes to the right-hand side, as does the known ∂p/∂n of the walls, `slope(w)` (Pa/m).
pub(crate) fn assemble(
    fields: Fields,
    slope: impl Fn(usize) -> f64 + Sync,
    surface_pressure: impl Fn(usize) -> f64 + Sync,
    scratch: &mut Vec<Scratch>,
    locals: &mut [Local],
    equations: &mut [Equation],
    matrix: &mut SparseMatrix,
) {
    let blocks = fields.position.len().div_ceil(BLOCK);
    scratch.resize_with(blocks, Scratch::default);
    matrix.blocks.resize_with(blocks, Default::default);
    let arch = pulp::Arch::new();
    let particles = locals.par_chunks_mut(BLOCK).zip(equations.par_chunks_mut(BLOCK));
    particles.zip(scratch.par_iter_mut().zip(&mut matrix.blocks)).enumerate().for_each(
        |(block, ((locals, equations), (scratch, matrix)))| {
            let plain = &mut scratch.plain;
            // With the widest instructions that the processor has.
            arch.dispatch(plain::Task { fields, block, locals, equations, scratch: plain });
            matrix.clear();
            let rows = &mut scratch.rows;
            for (offset, (local, equation)) in locals.iter_mut().zip(equations).enumerate() {
                let i = block * BLOCK + offset;
                let coefficients = match scratch.plain.coefficients(fields, block, offset) {
                    Some(coefficients) => coefficients,
                    None => {
                        gather(fields, i, rows);
                        (*local, *equation) = evaluate(fields, i, rows);
                        rows.values.coefficients()
                    }
                };
                if fields.on_surface[i] || equation.diagonal <= 0.0 {
                    matrix.add_row(std::iter::empty(), equation.diagonal);
                } else {
                    let scale = -1.0 / equation.diagonal;
                    let list = fields.fluid.of(i);
                    let entries = list.iter().zip(coefficients).map(|(&j, a)| (j, a * scale));
                    let inner = entries.filter(|(j, _)| !fields.on_surface[*j as usize]);
                    let below_surface = matrix.add_row(inner, equation.diagonal) < list.len();
                    let walls = neumann(fields, i, &slope);
                    equation.walls = fit::dot(&local.pressure.laplacian, &walls);
                    if below_surface {
                        let sum = dirichlet(fields, i, local, &surface_pressure);
                        equation.surface = sum / equation.diagonal;
                    }
                }
            }
        },
    );
}

/// Collects the rows of the fit around particle `i`.
#[inline(always)]
fn gather(fields: Fields, i: usize, rows: &mut Rows) {
    let centre = fields.position[i];
    let own = fields.velocity[i];
    let scale = 1.0 / fields.spacing;
    rows.values.gather(fields.fluid.of(i), |j| {
        ((fields.position[j] - centre) * scale, fields.velocity[j] - own, fields.on_surface[j])
    });
    rows.walls.clear();
    rows.dry_walls.clear();
    for &w in fields.wall_lists.of(i) {
        let part = fields.walls.part(w as usize, centre, fields.spacing);
        let d = (fields.walls.position[w as usize] - centre) * scale;
        let normal = fields.walls.normal[w as usize];
        let row = WallRow {
            basis: fit::basis(d),
            slope: fit::normal_derivative(d, normal),
            normal,
            part,
            index: w,
        };
        if part > 0.0 { rows.walls.push(row) } else { rows.dry_walls.push(row) }
    }
    rows.singular = None;
    if rows.walls.is_empty() || fields.discretisation != Discretisation::Quadratic {
        return;
    }
    let Some((index, restraint)) = fields.walls.corner(centre, fields.spacing) else { return };
    let corner = &fields.walls.corners[index as usize];
    // Its function goes through any other wall.
    let owner = |w: u32| fields.walls.owner[w as usize];
    if rows.walls.iter().all(|row| owner(row.index) == owner(corner.faces[0])) {
        let to = (corner.position - centre) * scale;
        rows.singular = Some(Singular::new(&rows.values, corner, index, to, restraint));
    }
}

/// What a discretisation gives around one particle, lengths in spacings; by default, for a
/// particle without an equation.
struct Derivatives {
    pressure: PressureFit,
    /// ∇u: a row for each component of the velocity.
    velocity_gradient: Matrix2<f64>,
    /// Quadratic fit of the velocity, which regularisation works with in any case.
    velocity: VelocityFit,
    /// Sum of the coefficients of the Laplacian, which are left in the rows.
    diagonal: f64,
    quality: Quality,
}

impl Default for Derivatives {
    fn default() -> Self {
        Self {
            pressure: PressureFit::default(),
            velocity_gradient: Matrix2::zeros(),
            velocity: VelocityFit::default(),
            diagonal: 0.0,
            quality: Quality::None,
        }
    }
}

#[inline(always)]
fn evaluate(fields: Fields, i: usize, rows: &mut Rows) -> (Local, Equation) {
    let own = fields.velocity[i];
    let excess = |row: &WallRow| row.normal.dot(&(fields.walls.velocity[row.index as usize] - own));
    let derivatives = match fields.discretisation {
        Discretisation::Quadratic => quadratic::derive(rows, excess),
        Discretisation::Conventional => conventional::derive(fields, rows, excess),
    };
    let velocity = derivatives.velocity;
    let (shift, crowding) = regularise::shift(fields, i, rows);
    let (mut local, equation) = in_units(fields, derivatives, shift, crowding);
    if let Some(singular) = &rows.singular {
        let corner = &fields.walls.corners[singular.corner as usize];
        let scale = 1.0 / fields.spacing;
        let from = (fields.position[i] - corner.position) * scale;
        local.shift_velocity +=
            (corner.gradient(from + shift) - corner.gradient(from)) * velocity.singular;
        local.corner = Some(singular.corner);
    }
    local.filter = regularise::filter(fields, i, rows);
    local.contacts = regularise::contacts(fields, rows);
    if fields.on_surface[i]
        && let Some(smooth) = regularise::along_surface(fields, i, rows)
    {
        local.surface_roughness = fields.normal[i] * (smooth.height * fields.spacing);
        local.roughness = smooth.velocity;
    }
    (local, equation)
}

/// What follows from the `derivatives` and the `shift` (both in spacings), away from walls and surface.
#[inline(always)]
fn in_units(
    fields: Fields,
    derivatives: Derivatives,
    shift: Vector2<f64>,
    crowding: f64,
) -> (Local, Equation) {
    let Derivatives { pressure, velocity_gradient, velocity, diagonal, quality } = derivatives;
    let scale = 1.0 / fields.spacing;
    let basis = fit::basis(shift);
    let velocity_gradient = velocity_gradient * scale;
    let diagonal = if diagonal > LEAST_DIAGONAL { diagonal } else { 0.0 };
    let divergence = velocity_gradient.trace();
    let equation = Equation { diagonal, divergence, crowding, ..Equation::default() };
    let local = Local {
        pressure,
        velocity_gradient,
        laplacian_of_velocity: Vector2::new(
            velocity.u[2] + velocity.u[4],
            velocity.v[2] + velocity.v[4],
        ) * (scale * scale),
        roughness: velocity.roughness.into(),
        shift: shift * fields.spacing,
        shift_velocity: Vector2::new(fit::dot(&basis, &velocity.u), fit::dot(&basis, &velocity.v)),
        quality,
        filter: 1.0,
        contacts: [None; 2],
        corner: None,
        surface_roughness: Vector2::zeros(),
    };
    (local, equation)
}

/// The `divergence` of the velocity at the `wanted` particles, 1/s, where wall particle w moves with
/// `wall(w)` along its normal (m/s); nought at all others.
pub(crate) fn divergences(
    fields: Fields,
    scratch: &mut [Scratch],
    wanted: &[bool],
    wall: impl Fn(usize) -> f64 + Sync,
    divergence: &mut [f64],
) {
    let blocks = divergence.par_chunks_mut(BLOCK).zip(scratch).enumerate();
    blocks.for_each(|(block, (divergence, scratch))| {
        for (offset, divergence) in divergence.iter_mut().enumerate() {
            let i = block * BLOCK + offset;
            *divergence = 0.0;
            if wanted[i] {
                let rows = &mut scratch.rows;
                gather(fields, i, rows);
                let own = fields.velocity[i];
                let excess = |row: &WallRow| wall(row.index as usize) - row.normal.dot(&own);
                *divergence = match fields.discretisation {
                    Discretisation::Quadratic => {
                        let fit = rows.fit_velocity(excess);
                        fit.u[0] + fit.v[1]
                    }
                    Discretisation::Conventional => {
                        conventional::derive(fields, rows, excess).velocity_gradient.trace()
                    }
                } / fields.spacing;
            }
        }
    });
}

/// Standard deviation of the particle density away from surface and walls, relative to its mean.
pub(crate) fn density_deviation(fields: Fields) -> f64 {
    let density = |i: usize| {
        let list = fields.fluid.of(i);
        let surface = list.iter().any(|&j| fields.on_surface[j as usize]);
        if surface || fields.on_surface[i] || !fields.wall_lists.of(i).is_empty() {
            return None;
        }
        let distance2 = |j: &u32| {
            (fields.position[*j as usize] - fields.position[i]).norm_squared()
                / (fields.spacing * fields.spacing)
        };
        Some(fit::bell(0.0) + list.iter().map(|j| fit::bell(distance2(j))).sum::<f64>())
    };
    let particles = (0..fields.position.len()).into_par_iter().with_min_len(BLOCK);
    let densities: Vec<Option<f64>> = particles.map(density).collect();
    let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
    for density in densities.into_iter().flatten() {
        sum += density;
        squares += density * density;
        count += 1.0;
    }
    if count == 0.0 { 0.0 } else { (squares * count / (sum * sum) - 1.0).max(0.0).sqrt() }
}

/// Sum over the surface neighbours of inner particle `i` of their `surface_pressure(j)` times its
/// coefficient.
#[inline(always)]
fn dirichlet(
    fields: Fields,
    i: usize,
    local: &Local,
    surface_pressure: impl Fn(usize) -> f64,
) -> f64 {
    match fields.discretisation {
        Discretisation::Quadratic => {
            surface_sum(fields, i, local, surface_pressure, quadratic::value_row)
        }
        Discretisation::Conventional => {
            surface_sum(fields, i, local, surface_pressure, conventional::value_row)
        }
    }
}

/// [`dirichlet`] with the `row` of a discretisation.
#[inline(always)]
fn surface_sum(
    fields: Fields,
    i: usize,
    local: &Local,
    surface_pressure: impl Fn(usize) -> f64,
    row: impl Fn(Vector2<f64>) -> (f64, [f64; 5]),
) -> f64 {
    let scale = 1.0 / fields.spacing;
    let mut sum = 0.0;
    let potential = potential_from(fields, i, local);
    for &j in fields.fluid.of(i) {
        let j = j as usize;
        if fields.on_surface[j] {
            let (weight, row) = row((fields.position[j] - fields.position[i]) * scale);
            let a = weight
                * (fit::dot(&local.pressure.laplacian, &row)
                    + local.pressure.singular[2] * potential(j));
            sum += a * surface_pressure(j);
        }
    }
    sum
}

/// Sum over the active walls around particle `i` of the Neumann datum `slope(w)` (∂p/∂n, Pa/m)
/// times its row: what a pressure functional of the particle is multiplied with.
#[inline(always)]
pub(crate) fn neumann(fields: Fields, i: usize, slope: impl Fn(usize) -> f64) -> [f64; 5] {
    let scale = 1.0 / fields.spacing;
    let mut sum = [0.0; 5];
    for &w in fields.wall_lists.of(i) {
        let w = w as usize;
        let part = fields.walls.part(w, fields.position[i], fields.spacing);
        if part > 0.0 {
            let datum = slope(w) * fields.spacing;
            if datum != 0.0 {
                let d = (fields.walls.position[w] - fields.position[i]) * scale;
                let normal = fields.walls.normal[w];
                let (weight, row) = match fields.discretisation {
                    Discretisation::Quadratic => quadratic::wall_row(part, d, normal),
                    Discretisation::Conventional => {
                        conventional::wall_row(part, d, normal, fields.walls.length[w] * scale)
                    }
                };
                let weighted = weight * datum;
                for k in 0..5 {
                    sum[k] += weighted * row[k];
                }
            }
        }
    }
    sum
}

/// Gradient of `pressure` at particle `i`, Pa/m, with the Neumann sum of [`neumann`].
#[inline(always)]
pub(crate) fn gradient(
    fields: Fields,
    i: usize,
    local: &Local,
    pressure: &[f64],
    neumann: &[f64; 5],
) -> Vector2<f64> {
    let [x, y, _] = derivatives_of(fields, i, local, pressure, neumann);
    Vector2::new(x, y) / fields.spacing
}

/// Laplacian of `pressure` at particle `i`, Pa/m², as [`gradient`].
#[inline(always)]
pub(crate) fn laplacian(
    fields: Fields,
    i: usize,
    local: &Local,
    pressure: &[f64],
    neumann: &[f64; 5],
) -> f64 {
    let [_, _, laplacian] = derivatives_of(fields, i, local, pressure, neumann);
    laplacian / (fields.spacing * fields.spacing)
}

/// ∂p/∂x and ∂p/∂y per spacing and ∇²p per spacing² at particle `i`.
#[inline(always)]
fn derivatives_of(
    fields: Fields,
    i: usize,
    local: &Local,
    pressure: &[f64],
    neumann: &[f64; 5],
) -> [f64; 3] {
    let scale = 1.0 / fields.spacing;
    let sum = match fields.discretisation {
        Discretisation::Quadratic => add_values(fields, i, pressure, neumann, quadratic::value_row),
        Discretisation::Conventional => {
            add_values(fields, i, pressure, neumann, conventional::value_row)
        }
    };
    let fit = &local.pressure;
    let mut found =
        [&fit.gradient_x, &fit.gradient_y, &fit.laplacian].map(|row| fit::dot(row, &sum));
    if local.corner.is_some() {
        let potential = potential_from(fields, i, local);
        for &j in fields.fluid.of(i) {
            let j = j as usize;
            let d = (fields.position[j] - fields.position[i]) * scale;
            let weight = fit::weight(d.norm_squared());
            let weighted = weight * potential(j) * (pressure[j] - pressure[i]);
            for (found, strength) in found.iter_mut().zip(fit.singular) {
                *found += strength * weighted;
            }
        }
    }
    found
}

/// Potential of the corner near particle `i` at a particle less that at `i`; nought without one.
#[inline(always)]
fn potential_from<'a>(fields: Fields<'a>, i: usize, local: &Local) -> impl Fn(usize) -> f64 + 'a {
    let corner = local.corner.map(|index| &fields.walls.corners[index as usize]);
    let at = move |j: usize| {
        corner.map_or(0.0, |corner| {
            corner.potential((fields.position[j] - corner.position) / fields.spacing)
        })
    };
    let own = at(i);
    move |j| at(j) - own
}

/// `sum` plus, over the neighbours of particle `i`, their pressure above its own times their row.
#[inline(always)]
fn add_values(
    fields: Fields,
    i: usize,
    pressure: &[f64],
    sum: &[f64; 5],
    row: impl Fn(Vector2<f64>) -> (f64, [f64; 5]),
) -> [f64; 5] {
    let scale = 1.0 / fields.spacing;
    let mut sum = *sum;
    for &j in fields.fluid.of(i) {
        let j = j as usize;
        let (weight, row) = row((fields.position[j] - fields.position[i]) * scale);
        let weighted = weight * (pressure[j] - pressure[i]);
        for k in 0..5 {
            sum[k] += weighted * row[k];
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fluid::Fluid;
    use crate::tests::{bodies, scatter};

    /// All numbers of what is found around a particle.
    fn numbers(local: &Local, equation: &Equation, coefficients: &[f64]) -> Vec<u64> {
        let fit = &local.pressure;
        let vectors = [local.laplacian_of_velocity, local.roughness, local.shift];
        let single = [equation.diagonal, equation.crowding, equation.divergence, local.filter];
        let all = fit.gradient_x.iter().chain(&fit.gradient_y).chain(&fit.laplacian);
        let all = all.chain(local.velocity_gradient.iter()).chain(local.shift_velocity.iter());
        let all = all.chain(vectors.iter().flatten()).chain(&single).chain(coefficients);
        all.map(|number| number.to_bits()).collect()
    }

    #[test]
    fn particles_side_by_side_get_the_bits_that_each_gets_alone() {
        let mut fluid = bodies::fluid();
        for (i, x) in fluid.state.particles.position.iter_mut().enumerate() {
            let i = i as i64;
            *x += Vector2::new(scatter(i, 1), scatter(1, i)) * 0.002;
            fluid.state.particles.velocity[i as usize] = Vector2::new(scatter(i, 2), scatter(2, i));
        }
        fluid.neighbours(0.0);
        fluid.operators();
        let fields = Fluid::fields(&fluid.setup, &fluid.state.particles, &fluid.walls, &fluid.work);
        let mut rows = Rows::default();
        let mut together = 0;
        for (i, local) in fluid.work.locals.iter().enumerate() {
            let equation = &fluid.work.equations[i];
            let (block, offset) = (i / BLOCK, i % BLOCK);
            let plain = &fluid.work.scratch[block].plain;
            let Some(coefficients) = plain.coefficients(fields, block, offset) else { continue };
            gather(fields, i, &mut rows);
            let (alone, of_equation) = evaluate(fields, i, &mut rows);
            let of_alone = numbers(&alone, &of_equation, rows.values.coefficients());
            assert_eq!(numbers(local, equation, coefficients), of_alone, "particle {i}");
            together += 1;
        }
        assert!(together > 100, "{together} of {}", fluid.work.locals.len());
        assert_ne!(together % crate::lanes::LANES, 0, "one batch is to be short");
    }
}
