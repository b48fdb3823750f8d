//! Where the surface overturns, and the water around may be broken: jets, spray, foam.
//!
//! There no fit resolves the flow between neighbours, and the surface is no function of x. Particles
//! collide, their own density is fed back to the pressure, and gaps in the surface are left as they
//! are. Everywhere else, and in a scene where nothing overturns, none of this is done.

use nalgebra::{Point2, Vector2};

/// A surface whose normal's vertical part is below this is about to overturn.
const STEEPEST: f64 = 0.5;
/// Distance in depths from where the surface overturns within which water may be broken.
const REACH: f64 = 5.0;

/// The broken water of a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct BrokenWater {
    /// Where the surface overturns, rising, m.
    overturns: Vec<f64>,
    /// m.
    reach: f64,
}

impl BrokenWater {
    /// Looks for particles that are `on_surface`, with their outward `normal`, where the surface
    /// overturns; `depth` (m) is that of the water.
    pub(crate) fn find(
        &mut self,
        position: &[Point2<f64>],
        on_surface: &[bool],
        normal: &[Vector2<f64>],
        depth: f64,
    ) {
        self.reach = REACH * depth;
        self.overturns.clear();
        let surface = position.iter().zip(on_surface).zip(normal).filter(|((_, on), _)| **on);
        self.overturns.extend(surface.filter(|(_, n)| n.y < STEEPEST).map(|((x, _), _)| x.x));
        self.overturns.sort_unstable_by(f64::total_cmp);
    }

    /// Whether the surface overturns anywhere.
    pub(crate) fn is_anywhere(&self) -> bool {
        !self.overturns.is_empty()
    }

    /// Whether water at `x` (m) may be broken.
    pub(crate) fn is_at(&self, x: f64) -> bool {
        let next = self.overturns.partition_point(|overturns| *overturns < x - self.reach);
        self.overturns.get(next).is_some_and(|overturns| *overturns < x + self.reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn water_is_broken_around_a_surface_that_overturns() {
        let position = [0.0, 10.0, 30.0, 40.0].map(|x| Point2::new(x, 1.0));
        let up = Vector2::y();
        let mut broken = BrokenWater::default();
        broken.find(&position, &[true; 4], &[up; 4], 1.0);
        assert!(!broken.is_anywhere() && !broken.is_at(10.0));
        // The second falls over; the fourth would, but is not on the surface.
        broken.find(&position, &[true, true, true, false], &[up, Vector2::x(), up, -up], 1.0);
        assert!(broken.is_anywhere());
        let found = [4.9, 5.1, 14.9, 15.1, 40.0].map(|x| broken.is_at(x));
        assert_eq!(found, [false, true, true, false, false]);
    }
}
