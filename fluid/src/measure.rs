//! What gauges and probes read: elevation at a place, pressure and velocity at a point.

use crate::fields::Fields;
use crate::fit;
use crate::fluid::Fluid;
use crate::geometry::signed_distance;
use crate::loads::PointPressure;
use crate::small_matrix::Symmetric;
use nalgebra::{Point2, Vector2};

/// A surface particle with fewer neighbours than this is spray, not surface.
const CONNECTED: usize = 6;
/// Surface particles that lie further below the highest than this, in spacings, belong to another
/// sheet of an overturning wave.
const SAME_SHEET: f64 = 3.0;
/// A point that lies no further inside a boundary than this, in spacings, lies on its outline, but
/// for rounding.
const ON_OUTLINE: f64 = 1e-6;

impl Fluid {
    /// Elevation of the free surface above still water at `x`, m: a quadratic fit to the surface
    /// particles around; the bed where it is dry. `None` inside a boundary.
    ///
    /// Where the wave overturns this is the highest surface that hangs together; single particles
    /// in the air do not count.
    #[must_use]
    pub fn surface_elevation(&self, x: f64) -> Option<f64> {
        let dx = self.setup.numerics.particle_spacing;
        let particles = &self.state.particles;
        let polygons: Vec<_> = (0..self.setup.boundaries.len()).map(|b| self.polygon(b)).collect();
        let covered = |point| polygons.iter().any(|polygon| signed_distance(polygon, point) < 0.0);
        let connected = |i: usize| self.work.fluid.count(i).is_none_or(|n| n >= CONNECTED);
        let around: Vec<(f64, f64)> = (0..particles.len())
            .filter(|&i| particles.on_surface[i])
            .map(|i| (i, particles.position[i]))
            .filter(|(_, point)| (point.x - x).abs() < fit::RADIUS * dx)
            .filter(|&(i, point)| {
                connected(i) && !covered(Point2::new(0.5 * (x + point.x), point.y))
            })
            .map(|(_, point)| ((point.x - x) / dx, point.y))
            .collect();
        let Some(nearest) = around.iter().map(|(d, _)| d.abs()).reduce(f64::min) else {
            let dry = particles.position.iter().all(|point| (point.x - x).abs() > fit::RADIUS * dx);
            return (dry && !covered(Point2::new(x, 0.0))).then_some(-self.setup.water.depth);
        };
        let above = around.iter().filter(|(d, _)| d.abs() <= nearest.max(1.0));
        let top = above.map(|(_, y)| *y).reduce(f64::max)?;
        let mut matrix = Symmetric::<3>::zero();
        let mut rhs = [0.0; 3];
        for (d, y) in around.iter().filter(|(_, y)| top - y < SAME_SHEET * dx) {
            let row = [1.0, *d, d * d];
            let weight = fit::bell(d * d);
            matrix.add_outer(weight, &row);
            for (sum, value) in rhs.iter_mut().zip(row) {
                *sum += weight * value * y;
            }
        }
        let height = matrix.factorize(1e-4).map_or(top, |factor| factor.solve(&rhs)[0]);
        (!covered(Point2::new(x, height))).then_some(height - self.setup.water.depth)
    }

    /// Total pressure at `point` over the last step, Pa, near bodies less what is no load: a quadratic
    /// fit to the particles around. `None` outside the water.
    #[must_use]
    pub fn pressure_at(&self, point: Point2<f64>) -> Option<f64> {
        let water = &self.setup.water;
        let functional = self.functional_at(point)?;
        let particles = &self.state.particles;
        let of_particle = |j: usize| particles.pressure[j] - particles.repeated_pressure[j][0];
        let dynamic = functional.evaluate(of_particle, |_| 0.0);
        Some(dynamic + water.density * water.gravity * (water.depth - point.y))
    }

    /// Velocity at `point`, m/s, as [`Self::pressure_at`].
    #[must_use]
    pub fn velocity_at(&self, point: Point2<f64>) -> Option<Vector2<f64>> {
        let functional = self.functional_at(point)?;
        let component =
            |k: usize| functional.evaluate(|j| self.state.particles.velocity[j][k], |_| 0.0);
        Some(Vector2::new(component(0), component(1)))
    }

    /// The value at `point` of a field that the particles around carry.
    fn functional_at(&self, point: Point2<f64>) -> Option<PointPressure> {
        let depth = self.setup.water.depth;
        let spacing = self.setup.numerics.particle_spacing;
        // Without a surface above it a point may still lie in the water under a boundary.
        if self.surface_elevation(point.x).is_some_and(|eta| point.y > depth + eta)
            || (0..self.setup.boundaries.len())
                .any(|b| signed_distance(&self.polygon(b), point) < -ON_OUTLINE * spacing)
        {
            return None;
        }
        let radius = fit::RADIUS * spacing;
        let particles = &self.state.particles;
        let fields = Fields {
            position: &particles.position,
            ..Self::fields(&self.setup, particles, &self.walls, &self.work)
        };
        let near = |other: &Point2<f64>| (other - point).norm_squared() < radius * radius;
        let around = (0..particles.len()).filter(|&j| near(&particles.position[j]));
        let mut functional = PointPressure::default();
        // Walls are left out: their data is that of the step, not of the present.
        functional.build(fields, point, around.map(|j| j as u32), std::iter::empty());
        functional.is_some().then_some(functional)
    }
}
