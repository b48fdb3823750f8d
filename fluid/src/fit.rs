//! Quadratic weighted least-squares fits around a particle: one fit serves divergence, gradient
//! and Laplacian (LSMPS type A; the quadric SFDI of Yan et al. 2020 is its block elimination).
//!
//! A field f near particle i is f_i + B(d)·c with d the offset in spacings dx and
//! B = [x, y, x²/2, xy, y²/2]. Walls enter as further rows: n·∇p = q for the pressure and
//! n·u = n·U for the velocity, so that no wall unknowns arise and a corner is just two rows.

#![allow(clippy::needless_range_loop)] // sums over columns and triangles read best by index

use crate::corner::Corner;
use crate::geometry::capped;
use crate::lanes::{Lanes, Number};
use crate::small_matrix::{Factor, Symmetric};
use nalgebra::Vector2;

/// Support radius of a fit in particle spacings.
pub(crate) const RADIUS: f64 = 2.6;

/// A pivot below this part of its diagonal means a direction that the neighbours do not resolve.
pub(crate) const PIVOT_THRESHOLD: f64 = 5e-3;
/// The same for the velocity at walls, whose twelve unknowns share a larger trace: 5e-3 took the
/// velocity's gradient from particles at walls that were displaced by 10 % of a spacing.
const WALL_PIVOT_THRESHOLD: f64 = 1e-5;

/// Added to the second-derivative diagonal of an unresolved fit, in parts of its trace: the fit
/// then falls back to a linear one.
const LINEAR_FALLBACK: f64 = 10.0;

/// Neighbours below which there is no fit: a few particles in the air fly freely.
pub(crate) const FEWEST: usize = 3;

/// Weight of a Neumann row relative to a value row. A small weight keeps the condition where a
/// quadratic field can meet it, and lets the fit give way where it cannot, at a corner and where
/// the surface meets a wall: with 1 the contact line becomes unstable.
pub(crate) const WALL_WEIGHT: f64 = 0.2;

/// Weight of the centre's own value where a velocity fit leaves it free.
const CENTRE_WEIGHT: f64 = 0.5;

/// Weight of a value row, (1 − q)³ (1 + 3 q) / r², q = r / radius, at squared distance `r2` in
/// spacings. A Neumann row is a slope already and takes the weight without 1/r².
#[inline(always)]
pub(crate) fn weight<T: Number>(r2: T) -> T {
    bell(r2) / (r2 + T::of(0.1))
}

/// (1 − q)³ (1 + 3 q) = 1 − 6 q² + 8 q³ − 3 q⁴.
#[inline(always)]
pub(crate) fn bell<T: Number>(r2: T) -> T {
    let one = T::of(1.0);
    let q = r2.sqrt() * T::of(1.0 / RADIUS);
    let p = (one - q).larger(T::of(0.0));
    p * p * p * (one + T::of(3.0) * q)
}

/// B(d).
#[inline(always)]
pub(crate) fn basis(d: Vector2<f64>) -> [f64; 5] {
    [d.x, d.y, 0.5 * d.x * d.x, d.x * d.y, 0.5 * d.y * d.y]
}

/// n·∇B(d), times the spacing.
#[inline(always)]
pub(crate) fn normal_derivative(d: Vector2<f64>, n: Vector2<f64>) -> [f64; 5] {
    [n.x, n.y, n.x * d.x, n.x * d.y + n.y * d.x, n.y * d.y]
}

#[inline(always)]
pub(crate) fn dot<T: Number>(a: &[T; 5], b: &[T; 5]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] + a[4] * b[4]
}

/// Value rows that a fit takes at most; a regular arrangement has 20.
pub(crate) const MOST: usize = 64;

/// What is known of the value rows around a particle, or around several side by side: a column for
/// each quantity.
#[derive(Clone, Debug)]
pub(crate) struct Columns<T> {
    pub(crate) len: usize,
    /// Offset from the centre, in spacings.
    pub(crate) x: [T; MOST],
    pub(crate) y: [T; MOST],
    /// Velocity relative to the centre's, m/s.
    pub(crate) u: [T; MOST],
    pub(crate) v: [T; MOST],
    weight: [T; MOST],
    /// Coefficient in the Laplacian.
    pub(crate) coefficient: [T; MOST],
}

impl<T: Number> Default for Columns<T> {
    fn default() -> Self {
        let zero = [T::of(0.0); MOST];
        Self { len: 0, x: zero, y: zero, u: zero, v: zero, weight: zero, coefficient: zero }
    }
}

impl<T: Number> Columns<T> {
    /// Weighs the rows, whose offsets are there.
    #[inline(always)]
    pub(crate) fn weigh(&mut self) {
        let n = self.len;
        for ((w, x), y) in self.weight[..n].iter_mut().zip(&self.x[..n]).zip(&self.y[..n]) {
            *w = weight(*x * *x + *y * *y);
        }
    }

    /// Largest speed relative to the centre, m/s: no smooth value lies further off.
    #[inline(always)]
    pub(crate) fn largest_difference(&self) -> T {
        let mut largest = T::of(0.0);
        for (u, v) in self.u[..self.len].iter().zip(&self.v[..self.len]) {
            largest = largest.larger(*u * *u + *v * *v);
        }
        largest.sqrt()
    }

    /// Sets the coefficients in the Laplacian `l` and returns their sum.
    #[inline(always)]
    pub(crate) fn laplacian(&mut self, l: &[T; 5]) -> T {
        let (n, half) = (self.len, T::of(0.5));
        let mut sum = T::of(0.0);
        let offsets = self.x[..n].iter().zip(&self.y[..n]);
        let weighted = offsets.zip(&self.weight[..n]);
        for (coefficient, ((&x, &y), &w)) in self.coefficient[..n].iter_mut().zip(weighted) {
            *coefficient =
                w * (x * (l[0] + half * l[2] * x + l[3] * y) + y * (l[1] + half * l[4] * y));
            sum += *coefficient;
        }
        sum
    }
}

/// The value rows: neighbouring particles.
#[derive(Clone, Debug)]
pub(crate) struct Values {
    pub(crate) columns: Columns<f64>,
    on_surface: [bool; MOST],
}

impl Default for Values {
    fn default() -> Self {
        Self { columns: Columns::default(), on_surface: [false; MOST] }
    }
}

impl Values {
    /// Takes the neighbours `list`: `row(j)` is the offset of j in spacings, its velocity
    /// relative to the centre's (m/s), and whether it is on the surface.
    #[inline(always)]
    pub(crate) fn gather(
        &mut self,
        list: &[u32],
        row: impl Fn(usize) -> (Vector2<f64>, Vector2<f64>, bool),
    ) {
        let columns = &mut self.columns;
        columns.len = list.len().min(MOST);
        for (k, &j) in list.iter().take(MOST).enumerate() {
            let (d, velocity, on_surface) = row(j as usize);
            columns.x[k] = d.x;
            columns.y[k] = d.y;
            columns.u[k] = velocity.x;
            columns.v[k] = velocity.y;
            self.on_surface[k] = on_surface;
        }
        columns.weigh();
    }

    /// Offset of row `k` in spacings.
    #[inline(always)]
    pub(crate) fn offset(&self, k: usize) -> Vector2<f64> {
        Vector2::new(self.columns.x[k], self.columns.y[k])
    }

    pub(crate) fn len(&self) -> usize {
        self.columns.len
    }

    /// Velocity of row `k` relative to the centre's, m/s.
    #[inline(always)]
    pub(crate) fn velocity(&self, k: usize) -> Vector2<f64> {
        Vector2::new(self.columns.u[k], self.columns.v[k])
    }

    /// Sets the coefficient of row `k` in the Laplacian.
    #[inline(always)]
    pub(crate) fn set_coefficient(&mut self, k: usize, coefficient: f64) {
        self.columns.coefficient[k] = coefficient;
    }

    /// Whether each is on the surface.
    pub(crate) fn on_surface(&self) -> &[bool] {
        &self.on_surface[..self.len()]
    }

    /// Coefficient of each in the Laplacian; see [`Rows::laplacian`].
    pub(crate) fn coefficients(&self) -> &[f64] {
        &self.columns.coefficient[..self.len()]
    }
}

/// Sums of the value rows: Σ w xᵃ yᵇ up to degree four, and Σ w u, Σ w u B and the same for v.
pub(crate) struct Moments<T> {
    /// Σ w (1, x, y, x²/2, xy, y²/2)ᵀ(1, x, y, x²/2, xy, y²/2).
    matrix: Symmetric<6, T>,
    u: [T; 6],
    v: [T; 6],
}

impl<T: Number> Moments<T> {
    #[inline(always)]
    pub(crate) fn of(columns: &Columns<T>) -> Self {
        let n = columns.len;
        let (x, y, w) = (&columns.x[..n], &columns.y[..n], &columns.weight[..n]);
        let (u, v) = (&columns.u[..n], &columns.v[..n]);
        let (zero, half, quarter) = (T::of(0.0), T::of(0.5), T::of(0.25));
        let mut m = [zero; 15];
        let (mut mu, mut mv) = ([zero; 6], [zero; 6]);
        for k in 0..n {
            let (x, y, w) = (x[k], y[k], w[k]);
            let (xx, xy, yy) = (x * x, x * y, y * y);
            let (wx, wy) = (w * x, w * y);
            let (wxx, wxy, wyy) = (w * xx, w * xy, w * yy);
            m[0] += w;
            m[1] += wx;
            m[2] += wy;
            m[3] += wxx;
            m[4] += wxy;
            m[5] += wyy;
            m[6] += wxx * x;
            m[7] += wxx * y;
            m[8] += wyy * x;
            m[9] += wyy * y;
            m[10] += wxx * xx;
            m[11] += wxx * xy;
            m[12] += wxx * yy;
            m[13] += wyy * xy;
            m[14] += wyy * yy;
            let (wu, wv) = (w * u[k], w * v[k]);
            for (i, b) in [T::of(1.0), x, y, half * xx, xy, half * yy].into_iter().enumerate() {
                mu[i] += wu * b;
                mv[i] += wv * b;
            }
        }
        let matrix = Symmetric([
            [m[0], zero, zero, zero, zero, zero],
            [m[1], m[3], zero, zero, zero, zero],
            [m[2], m[4], m[5], zero, zero, zero],
            [half * m[3], half * m[6], half * m[7], quarter * m[10], zero, zero],
            [m[4], m[7], m[8], half * m[11], m[12], zero],
            [half * m[5], half * m[8], half * m[9], quarter * m[12], half * m[13], quarter * m[14]],
        ]);
        Self { matrix, u: mu, v: mv }
    }

    /// Σ w B.
    fn basis(&self) -> [T; 5] {
        let m = &self.matrix.0;
        [m[1][0], m[2][0], m[3][0], m[4][0], m[5][0]]
    }

    /// Σ w B Bᵀ.
    pub(crate) fn about_centre(&self) -> Symmetric<5, T> {
        let mut inner = Symmetric::zero();
        for i in 0..5 {
            for j in 0..=i {
                inner.0[i][j] = self.matrix.0[i + 1][j + 1];
            }
        }
        inner
    }

    /// The velocity fit away from walls, from the `factor` of [`Self::about_centre`].
    #[inline(always)]
    pub(crate) fn velocity(&self, factor: &Factor<5, T>) -> VelocityFit<T> {
        let [_, u @ ..] = self.u;
        let [_, v @ ..] = self.v;
        let (u, v) = (factor.solve(&u), factor.solve(&v));
        // Were the value at the centre free too, with a weight of its own, it would change by what
        // the fit misses at the neighbours, after elimination of the other unknowns.
        let mean = self.basis();
        let own = T::of(CENTRE_WEIGHT);
        let pivot = own + self.matrix.0[0][0] - dot(&mean, &factor.solve(&mean));
        let misfit = [self.u[0] - dot(&mean, &u), self.v[0] - dot(&mean, &v)];
        VelocityFit { u, v, roughness: misfit.map(|misfit| misfit / pivot), singular: 0.0 }
    }
}

/// The function that is singular at a corner, in the fit around a particle; see [`crate::corner`].
#[derive(Clone, Debug)]
pub(crate) struct Singular {
    /// Number of the corner.
    pub(crate) corner: u32,
    /// Its potential at each value row less that at the centre.
    potential: [f64; MOST],
    /// Its gradient at each value row less that at the centre, per spacing.
    gradient: [Vector2<f64>; MOST],
    /// Its gradient at the centre, per spacing.
    centre: Vector2<f64>,
    /// See [`Corner::restraint`].
    restraint: f64,
}

impl Singular {
    /// The function of `corner`, number `index`, at offset `to` (spacings) from the centre.
    pub(crate) fn new(
        values: &Values,
        corner: &Corner,
        index: u32,
        to: Vector2<f64>,
        restraint: f64,
    ) -> Self {
        let mut singular = Self {
            corner: index,
            potential: [0.0; MOST],
            gradient: [Vector2::zeros(); MOST],
            centre: corner.gradient(-to),
            restraint,
        };
        let own = corner.potential(-to);
        for k in 0..values.len() {
            let d = values.offset(k) - to;
            singular.potential[k] = corner.potential(d) - own;
            singular.gradient[k] = corner.gradient(d) - singular.centre;
        }
        singular
    }
}

/// What a fit gains by one more unknown with the column `column` of normal equations whose `factor`
/// is known and the diagonal `diagonal`: the column times the inverse, and the pivot that is left.
pub(crate) fn border<const N: usize>(
    factor: &Factor<N>,
    column: &[f64; N],
    diagonal: f64,
) -> ([f64; N], f64) {
    let solved = factor.solve(column);
    let taken: f64 = column.iter().zip(&solved).map(|(a, b)| a * b).sum();
    (solved, diagonal - taken)
}

/// A wall row: an active wall particle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WallRow {
    pub(crate) basis: [f64; 5],
    pub(crate) slope: [f64; 5],
    pub(crate) normal: Vector2<f64>,
    /// Part with which it enters; see [`crate::walls::Walls::part`].
    pub(crate) part: f64,
    /// The wall particle.
    pub(crate) index: u32,
}

impl WallRow {
    /// Squared distance from the centre, in spacings squared.
    #[inline(always)]
    fn distance2(&self) -> f64 {
        self.basis[0] * self.basis[0] + self.basis[1] * self.basis[1]
    }
}

/// The rows around one particle.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    pub(crate) values: Values,
    /// Walls that bound the water here.
    pub(crate) walls: Vec<WallRow>,
    /// Walls that do not, as those above the surface: no part of any fit, but no way through.
    pub(crate) dry_walls: Vec<WallRow>,
    /// A corner nearby.
    pub(crate) singular: Option<Singular>,
}

/// Functionals of a pressure fit: each derivative is its dot product with
/// Σ w B Δp + Σ w N q dx. Derivatives are per spacing and spacing².
#[derive(Clone, Copy, Debug)]
pub(crate) struct PressureFit<T = f64> {
    pub(crate) gradient_x: [T; 5],
    pub(crate) gradient_y: [T; 5],
    pub(crate) laplacian: [T; 5],
    /// Near a corner, for gradient and Laplacian: what Σ w S Δp, with its potential S, is
    /// multiplied with besides.
    pub(crate) singular: [f64; 3],
}

/// Coefficients of a velocity fit and how far its centre lies off it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct VelocityFit<T = f64> {
    pub(crate) u: [T; 5],
    pub(crate) v: [T; 5],
    /// Smooth value minus value at the centre; zero for any quadratic field that meets the walls.
    pub(crate) roughness: [T; 2],
    /// Strength of the singular function, m/s.
    pub(crate) singular: f64,
}

impl<T: Number> Default for PressureFit<T> {
    fn default() -> Self {
        let zero = [T::of(0.0); 5];
        Self { gradient_x: zero, gradient_y: zero, laplacian: zero, singular: [0.0; 3] }
    }
}

impl<T: Number> Default for VelocityFit<T> {
    fn default() -> Self {
        let zero = T::of(0.0);
        Self { u: [zero; 5], v: [zero; 5], roughness: [zero; 2], singular: 0.0 }
    }
}

impl VelocityFit {
    /// With a roughness of `most` (m/s) at most.
    #[inline(always)]
    pub(crate) fn limited(self, most: f64) -> Self {
        let roughness = capped(Vector2::from(self.roughness), most);
        Self { roughness: roughness.into(), ..self }
    }
}

impl<T: Number> PressureFit<T> {
    /// The functionals of the fit with the normal equations' `factor`.
    #[inline(always)]
    pub(crate) fn of(factor: &Factor<5, T>) -> Self {
        let (zero, one) = (T::of(0.0), T::of(1.0));
        Self {
            gradient_x: factor.solve(&[one, zero, zero, zero, zero]),
            gradient_y: factor.solve(&[zero, one, zero, zero, zero]),
            laplacian: factor.solve(&[zero, zero, one, zero, one]),
            singular: [0.0; 3],
        }
    }
}

impl PressureFit<Lanes> {
    /// That of one particle.
    #[inline(always)]
    pub(crate) fn lane(&self, k: usize) -> PressureFit {
        let of = |row: &[Lanes; 5]| row.map(|value| value.0[k]);
        PressureFit {
            gradient_x: of(&self.gradient_x),
            gradient_y: of(&self.gradient_y),
            laplacian: of(&self.laplacian),
            singular: self.singular,
        }
    }
}

impl VelocityFit<Lanes> {
    /// That of one particle.
    #[inline(always)]
    pub(crate) fn lane(&self, k: usize) -> VelocityFit {
        VelocityFit {
            u: self.u.map(|value| value.0[k]),
            v: self.v.map(|value| value.0[k]),
            roughness: self.roughness.map(|value| value.0[k]),
            singular: self.singular,
        }
    }
}

/// Quality of a fit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Quality {
    /// All that the discretisation can: quadratic, or conventional.
    #[default]
    Full,
    /// Linear: the neighbours do not resolve second derivatives.
    Linear,
    /// No fit at all.
    None,
}

/// Factorizes `matrix`, as a quadratic fit if it can be, else as a linear one. `seconds` are the
/// indices of second derivatives.
#[inline(always)]
fn factorize<const N: usize>(
    matrix: Symmetric<N>,
    seconds: &[usize],
    threshold: f64,
) -> (Option<Factor<N>>, Quality) {
    if let Some(factor) = matrix.factorize(threshold) {
        return (Some(factor), Quality::Full);
    }
    let mut linear = matrix;
    let trace: f64 = (0..N).map(|i| matrix.0[i][i]).sum();
    for &i in seconds {
        linear.0[i][i] += LINEAR_FALLBACK * trace;
    }
    match linear.factorize(threshold) {
        Some(factor) => (Some(factor), Quality::Linear),
        None => (None, Quality::None),
    }
}

impl Rows {
    /// Fits pressure and velocity. `wall_excess(w)` is n·(U_w − u_i).
    #[inline(always)]
    pub(crate) fn fit(
        &self,
        wall_excess: impl Fn(&WallRow) -> f64,
    ) -> (PressureFit, VelocityFit, Quality) {
        if self.too_few() {
            return (PressureFit::default(), VelocityFit::default(), Quality::None);
        }
        let moments = Moments::of(&self.values.columns);
        let mut pressure = moments.about_centre();
        for row in &self.walls {
            pressure.add_outer(row.part * WALL_WEIGHT * bell(row.distance2()), &row.slope);
        }
        let (factor, quality) = factorize(pressure, &[2, 3, 4], PIVOT_THRESHOLD);
        let Some(factor) = factor else {
            return (PressureFit::default(), VelocityFit::default(), Quality::None);
        };
        let mut pressure_fit = PressureFit::of(&factor);
        if let Some(singular) = self.singular.as_ref().filter(|_| quality == Quality::Full) {
            self.add_singular(singular, &factor, &mut pressure_fit);
        }
        let velocity = if self.walls.is_empty() {
            moments.velocity(&factor)
        } else {
            self.fit_velocity_at_walls(&moments, wall_excess)
        };
        (pressure_fit, self.limited(velocity), quality)
    }

    /// Adds the singular function to a pressure fit.
    fn add_singular(&self, singular: &Singular, factor: &Factor<5>, fit: &mut PressureFit) {
        let (mut column, mut diagonal) = ([0.0; 5], 0.0);
        for k in 0..self.values.len() {
            let weighted = self.values.columns.weight[k] * singular.potential[k];
            for (sum, b) in column.iter_mut().zip(basis(self.values.offset(k))) {
                *sum += weighted * b;
            }
            diagonal += weighted * singular.potential[k];
        }
        let (solved, pivot) = border(factor, &column, diagonal * (1.0 + singular.restraint));
        let own = [singular.centre.x, singular.centre.y, 0.0];
        let rows = [&mut fit.gradient_x, &mut fit.gradient_y, &mut fit.laplacian];
        for ((row, own), strength) in rows.into_iter().zip(own).zip(&mut fit.singular) {
            *strength = (own - dot(&column, row)) / pivot;
            for (row, solved) in row.iter_mut().zip(&solved) {
                *row -= solved * *strength;
            }
        }
    }

    /// Whether there are too few neighbours for any fit.
    pub(crate) fn too_few(&self) -> bool {
        self.values.len() < FEWEST
    }

    /// `velocity` with a roughness that no smooth value exceeds.
    #[inline(always)]
    fn limited(&self, velocity: VelocityFit) -> VelocityFit {
        velocity.limited(self.values.columns.largest_difference())
    }

    /// Fits the velocity alone.
    pub(crate) fn fit_velocity(&self, wall_excess: impl Fn(&WallRow) -> f64) -> VelocityFit {
        let moments = Moments::of(&self.values.columns);
        if !self.walls.is_empty() {
            return self.limited(self.fit_velocity_at_walls(&moments, wall_excess));
        }
        match factorize(moments.about_centre(), &[2, 3, 4], PIVOT_THRESHOLD).0 {
            Some(factor) => self.limited(moments.velocity(&factor)),
            None => VelocityFit::default(),
        }
    }

    /// Both velocity components at once, since a wall's row holds both; the value at the centre
    /// is free too, so that it is drawn to what the wall demands.
    #[inline(never)]
    fn fit_velocity_at_walls(
        &self,
        moments: &Moments<f64>,
        wall_excess: impl Fn(&WallRow) -> f64,
    ) -> VelocityFit {
        let mut matrix = Symmetric::<12>::zero();
        let mut rhs = [0.0; 12];
        for i in 0..6 {
            for j in 0..=i {
                matrix.0[i][j] = moments.matrix.0[i][j];
                matrix.0[i + 6][j + 6] = moments.matrix.0[i][j];
            }
            rhs[i] = moments.u[i];
            rhs[i + 6] = moments.v[i];
        }
        matrix.0[0][0] += CENTRE_WEIGHT;
        matrix.0[6][6] += CENTRE_WEIGHT;
        for row in &self.walls {
            let full = [1.0, row.basis[0], row.basis[1], row.basis[2], row.basis[3], row.basis[4]];
            let mut both = [0.0; 12];
            for k in 0..6 {
                both[k] = row.normal.x * full[k];
                both[k + 6] = row.normal.y * full[k];
            }
            let weight = row.part * weight(row.distance2());
            matrix.add_outer(weight, &both);
            let excess = weight * wall_excess(row);
            for k in 0..12 {
                rhs[k] += both[k] * excess;
            }
        }
        match factorize(matrix, &[3, 4, 5, 9, 10, 11], WALL_PIVOT_THRESHOLD).0 {
            Some(factor) => {
                let mut c = factor.solve(&rhs);
                let mut strength = 0.0;
                if let Some(singular) = &self.singular {
                    let (mut column, mut diagonal, mut right) = ([0.0; 12], 0.0, 0.0);
                    for k in 0..self.values.len() {
                        let gradient = singular.gradient[k];
                        let weighted = self.values.columns.weight[k] * gradient;
                        let d = self.values.offset(k);
                        for (i, b) in [1.0].into_iter().chain(basis(d)).enumerate() {
                            column[i] += weighted.x * b;
                            column[i + 6] += weighted.y * b;
                        }
                        diagonal += weighted.dot(&gradient);
                        right += weighted.dot(&self.values.velocity(k));
                    }
                    let full = diagonal * (1.0 + singular.restraint);
                    let (solved, pivot) = border(&factor, &column, full);
                    let met: f64 = column.iter().zip(&c).map(|(a, c)| a * c).sum();
                    strength = (right - met) / pivot;
                    c.iter_mut().zip(&solved).for_each(|(c, solved)| *c -= solved * strength);
                }
                VelocityFit {
                    singular: strength,
                    u: [c[1], c[2], c[3], c[4], c[5]],
                    v: [c[7], c[8], c[9], c[10], c[11]],
                    roughness: [c[0], c[6]],
                }
            }
            None => VelocityFit::default(),
        }
    }

    /// Sets the coefficients of the value rows in the Laplacian `functional` and returns their
    /// sum.
    #[inline(always)]
    pub(crate) fn laplacian(&mut self, fit: &PressureFit) -> f64 {
        let columns = &mut self.values.columns;
        let sum = columns.laplacian(&fit.laplacian);
        let Some(singular) = &self.singular else { return sum };
        let n = columns.len;
        let rows = columns.coefficient[..n].iter_mut().zip(&columns.weight[..n]);
        for ((coefficient, weight), potential) in rows.zip(&singular.potential) {
            *coefficient += weight * fit.singular[2] * potential;
        }
        columns.coefficient[..n].iter().sum()
    }
}
