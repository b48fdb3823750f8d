//! Where the surface overturns, and the water around may be broken: jets, spray, foam.
//!
//! There no fit resolves the flow between neighbours, and the surface is no function of x. Particles
//! collide, their own density is fed back to the pressure, and gaps in the surface are left as they
//! are. Everywhere else, and in a scene where nothing overturns, none of this is done.
//!
//! Spray flies: it is no part of any fit, falls freely, and meets other water in collisions alone.

use crate::neighbours::{BLOCK, Neighbours};
use crate::regularise::COLLISION_RANGE;
use nalgebra::{Point2, Vector2};
use rayon::prelude::*;

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

/// A particle with fewer others, of water or walls, within [`SIGHT`] spacings is spray. On an even
/// surface there are seven, in its corner with a wall three and the wall's. One that passes over the
/// surface without touching it has three; were it water, what it passes would count as covered, a
/// step too late, and the pressure behind would drive it on.
const FEWEST_AROUND: usize = 4;
const SIGHT: f64 = 2.0;

/// The spray of a step.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spray {
    is_spray: Vec<bool>,
    /// Spray, and a particle that it may collide with.
    pub(crate) pairs: Vec<[u32; 2]>,
}

impl Spray {
    /// Finds the spray among the particles at `position` and takes it out of all lists of neighbours:
    /// `fluid` and `walls` around each particle, fluid around each wall particle.
    pub(crate) fn part(
        &mut self,
        position: &[Point2<f64>],
        spacing: f64,
        fluid: &mut Neighbours,
        walls: &Neighbours,
        fluid_of_walls: &mut Neighbours,
    ) {
        let is_near = |i: usize, j: usize, range: f64| {
            (position[j] - position[i]).norm_squared() < (range * spacing).powi(2)
        };
        self.is_spray.resize(position.len(), false);
        self.is_spray.par_iter_mut().with_min_len(BLOCK).enumerate().for_each(|(i, is_spray)| {
            let near = fluid.of(i).iter().filter(|&&j| is_near(i, j as usize, SIGHT));
            *is_spray = walls.of(i).len() + near.take(FEWEST_AROUND).count() < FEWEST_AROUND;
        });
        self.pairs.clear();
        if !self.is_spray.contains(&true) {
            return;
        }
        for i in (0..position.len()).filter(|&i| self.is_spray[i]) {
            let met = fluid
                .of(i)
                .iter()
                .map(|&j| j as usize)
                .filter(|&j| is_near(i, j, COLLISION_RANGE) && (i < j || !self.is_spray[j]));
            self.pairs.extend(met.map(|j| [i as u32, j as u32]));
        }
        fluid.retain(|i, j| !self.is_spray[i] && !self.is_spray[j]);
        fluid_of_walls.retain(|_, i| !self.is_spray[i]);
    }

    /// Whether particle `i` is spray.
    pub(crate) fn is(&self, i: usize) -> bool {
        self.is_spray.get(i).is_some_and(|is_spray| *is_spray)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::neighbours::CellGrid;

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

    #[test]
    fn what_flies_over_the_surface_is_no_part_of_it() {
        let lattice = (0..40).map(|i| Point2::new(f64::from(i % 10) + 0.5, f64::from(i / 10)));
        let mut position: Vec<_> = lattice.collect();
        // Skimming, and one further up on the surface's end, where it belongs to it.
        position.extend([Point2::new(5.2, 4.4), Point2::new(1.0, 3.9)]);
        let mut grid = CellGrid::new(Point2::origin(), Point2::new(10.0, 6.0), 2.6);
        grid.sort(&position);
        let (mut fluid, mut walls) = (Neighbours::default(), Neighbours::default());
        fluid.find(&position, &grid, 2.6, |i, j| i != j);
        let mut no_walls = grid.clone();
        no_walls.sort(&[]);
        walls.find(&position, &no_walls, 2.6, |_, _| true);
        let mut of_walls = fluid.clone();
        let mut spray = Spray::default();
        spray.part(&position, 1.0, &mut fluid, &walls, &mut of_walls);
        assert_eq!([34, 35, 40, 41].map(|i| spray.is(i)), [false, false, true, false]);
        assert!(fluid.of(40).is_empty() && !fluid.of(35).contains(&40));
        assert!(!of_walls.of(35).contains(&40) && fluid.of(30).contains(&41));
        let met: Vec<_> = spray.pairs.iter().filter(|pair| pair[0] == 40).collect();
        assert_eq!(met, [&[40, 35]]);
    }
}
