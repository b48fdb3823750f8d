//! Particles put into the surface where it has stretched and taken out where it has shrunk, and the
//! numbering of all along the tank.
//!
//! Surface particles stay on the surface, which grows and shrinks, and drift along it with the
//! waves. The volume of the water is that below the surface, not a number of particles, so a
//! particle more or less changes where the flow is sampled and nothing else. The same holds below:
//! where a jet leaves an edge particles may part faster than shifts bring them together, and a hole
//! with a corner of a body in it is a source that no fit around sees. It gets particles, and those that
//! come together elsewhere are taken out.

use crate::fluid::Fluid;
use crate::free_surface::{self, Surroundings};
use crate::geometry::signed_distance;
use crate::neighbours::BLOCK;
use crate::particles::permute;
use crate::regularise::crowding;
use nalgebra::{Point2, Vector2};
use rayon::prelude::*;

/// A wider gap between two surface particles, in spacings, gets a particle in its middle: before one of
/// those below comes to the surface through it, which leaves a dent.
const WIDEST: f64 = 1.4;
/// Of two surface particles closer than this, in spacings, one is taken out.
const NARROWEST: f64 = 0.6;
/// A wider gap between the surface's end and a wall, in spacings, gets a particle.
const WIDEST_AT_WALL: f64 = 1.3;
/// Distance of the outermost particle from a wall, in spacings, as in a fresh tank.
const AT_WALL: f64 = 0.5;
/// A particle put into a hole keeps this distance from all others, in spacings.
const CLEAR: f64 = 0.75;
/// Of particles below the surface that are as crowded as this, relative to a lattice, the most crowded
/// is taken out.
const CROWDED: f64 = 1.3;
/// Neighbours in an even arrangement, away from surface and walls: with no more there is no crowd.
const USUAL: usize = 20;
/// Neighbours, of water and walls: with more there is no hole.
const FEW: usize = 15;
/// What lies further off the surface's direction than this (cosine) is not along it.
const ALONG: f64 = 0.5;

/// A particle to be put in.
struct Added {
    position: Point2<f64>,
    /// Particles that it takes its values from, in equal parts.
    from: [usize; 2],
    on_surface: bool,
}

impl Fluid {
    /// Evens out the number of particles along the surface and numbers all anew, column by column
    /// along the tank.
    pub(crate) fn resample(&mut self) {
        self.neighbours(0.0);
        let work = &mut self.work;
        work.on_surface.copy_from_slice(&self.state.particles.on_surface);
        let around = Surroundings {
            position: &work.position,
            fluid: &work.fluid,
            walls: &work.wall_lists,
            spacing: self.setup.numerics.particle_spacing,
        };
        free_surface::normals(around, &work.on_surface, &mut work.normal);
        let depth = self.setup.water.depth;
        work.broken.find(&work.position, &work.on_surface, &work.normal, depth);
        let mut taken = std::mem::take(&mut self.work.taken);
        taken.clear();
        taken.resize(self.state.particles.len(), false);
        let mut added = Vec::new();
        for (i, taken) in taken.iter_mut().enumerate() {
            *taken = self.is_lost(i);
            self.state.lost += u64::from(*taken);
        }
        // Where the surface is broken, every gap filled would be water made.
        for i in 0..self.state.particles.len() {
            if self.work.on_surface[i]
                && !self.work.spray.is(i)
                && !taken[i]
                && !self.work.broken.is_at(self.work.position[i].x)
            {
                self.look_along(i, 1.0, &mut taken, &mut added);
                self.look_along(i, -1.0, &mut taken, &mut added);
            }
        }
        const { assert!(FEW < USUAL, "no particle is in a crowd and beside a hole") };
        for (i, taken) in taken.iter().enumerate() {
            if self.has_few_around(i) && !taken && self.is_deep(i) {
                added.extend(self.beside_a_hole(i, &added));
            }
        }
        let this = &*self;
        taken.par_iter_mut().with_min_len(BLOCK).enumerate().for_each(|(i, taken)| {
            *taken = *taken || (this.is_in_a_crowd(i) && this.is_deep(i));
        });
        for new in &added {
            self.add(new);
        }
        taken.resize(self.state.particles.len(), false);
        self.renumber(&taken);
        self.work.taken = taken;
    }

    /// What surface particle `i` finds along the surface in direction `sense`.
    fn look_along(&self, i: usize, sense: f64, taken: &mut [bool], added: &mut Vec<Added>) {
        let spacing = self.setup.numerics.particle_spacing;
        let (position, normal) = (&self.work.position, &self.work.normal);
        let tangent = |k: usize| sense * Vector2::new(normal[k].y, -normal[k].x);
        let mut nearest: Option<(f64, usize)> = None;
        for &j in self.work.fluid.of(i) {
            let j = j as usize;
            let d = position[j] - position[i];
            let distance = d.norm();
            if self.work.on_surface[j]
                && !taken[j]
                && d.dot(&tangent(i)) > ALONG * distance
                // A thin sheet has another surface behind it.
                && normal[i].dot(&normal[j]) > ALONG
                && nearest.is_none_or(|(least, _)| distance < least)
            {
                nearest = Some((distance, j));
            }
        }
        let Some((distance, j)) = nearest else {
            return self.look_at_wall(i, tangent(i), added);
        };
        // Each gap is seen from both ends: acted on from one.
        if sense < 0.0 {
            return;
        }
        if distance < NARROWEST * spacing {
            taken[j] = true;
        } else if distance > WIDEST * spacing {
            // The middle of the cubic that has the surface's direction at both ends.
            let bulge = (tangent(i) - tangent(j)) * (distance / 8.0);
            let middle = nalgebra::center(&position[i], &position[j]) + bulge;
            if self.is_in_the_open(middle) {
                added.push(Added { position: middle, from: [i, j], on_surface: true });
            }
        }
    }

    /// Fills the gap between the last surface particle `i` and the wall in direction `ahead`.
    fn look_at_wall(&self, i: usize, ahead: Vector2<f64>, added: &mut Vec<Added>) {
        let spacing = self.setup.numerics.particle_spacing;
        let own = self.work.position[i];
        let mut nearest: Option<(f64, Vector2<f64>)> = None;
        for &w in self.work.wall_lists.of(i) {
            let w = w as usize;
            let d = self.walls.position[w] - own;
            let facing = -ahead.dot(&self.walls.normal[w]);
            let distance = -d.dot(&self.walls.normal[w]);
            if facing > ALONG
                && d.dot(&ahead) > ALONG * d.norm()
                && nearest.is_none_or(|(least, _)| distance < least)
            {
                nearest = Some((distance, ahead / facing));
            }
        }
        if let Some((distance, path)) = nearest
            && distance > WIDEST_AT_WALL * spacing
        {
            let position = own + path * (distance - AT_WALL * spacing);
            if self.is_in_the_open(position) {
                added.push(Added { position, from: [i, i], on_surface: true });
            }
        }
    }

    /// Whether particle `i` is below the surface and the row next to it, and the water is not broken there.
    fn is_deep(&self, i: usize) -> bool {
        let work = &self.work;
        !work.on_surface[i]
            && !work.spray.is(i)
            && !work.broken.is_at(work.position[i].x)
            && !work.fluid.of(i).iter().any(|&j| work.on_surface[j as usize])
    }

    /// Whether a hole may be beside particle `i`.
    fn has_few_around(&self, i: usize) -> bool {
        self.work.fluid.of(i).len() + self.work.wall_lists.of(i).len() <= FEW
    }

    /// Whether particle `i` is the most crowded around, and too much so.
    fn is_in_a_crowd(&self, i: usize) -> bool {
        let work = &self.work;
        let list = |i: usize| work.fluid.of(i).iter().map(|&j| j as usize);
        let crowding = |i: usize| {
            let spacing = self.setup.numerics.particle_spacing;
            list(i).map(|j| crowding(work.position[j] - work.position[i], spacing)).sum::<f64>()
        };
        let own = || crowding(i);
        list(i).len() > USUAL && own() > CROWDED && list(i).all(|j| (crowding(j), j) < (own(), i))
    }

    /// The particle that the hole beside particle `i`, which has few around, gets, if there is one that
    /// none of those `added` has filled.
    fn beside_a_hole(&self, i: usize, added: &[Added]) -> Option<Added> {
        let (work, spacing) = (&self.work, self.setup.numerics.particle_spacing);
        let around = Surroundings {
            position: &work.position,
            fluid: &work.fluid,
            walls: &work.wall_lists,
            spacing,
        };
        let position = free_surface::hole(around, &self.walls, i)?;
        let is_clear = |x: &Point2<f64>| (x - position).norm() > CLEAR * spacing;
        let mut others = work.fluid.of(i).iter().map(|&j| j as usize);
        let clear = others.clone().all(|j| is_clear(&work.position[j]))
            && added.iter().all(|new| is_clear(&new.position));
        if !clear || !self.is_in_the_open(position) {
            return None;
        }
        let first = others.next()?;
        let distance = |j: usize| (work.position[j] - position).norm_squared();
        let nearest =
            others.fold(first, |near, j| if distance(j) < distance(near) { j } else { near });
        Some(Added { position, from: [i, nearest], on_surface: false })
    }

    /// Whether no boundary covers `point`.
    fn is_in_the_open(&self, point: Point2<f64>) -> bool {
        let clear = 0.5 * AT_WALL * self.setup.numerics.particle_spacing;
        (0..self.setup.boundaries.len()).all(|b| signed_distance(&self.polygon(b), point) > clear)
    }

    fn add(&mut self, new: &Added) {
        let [i, j] = new.from;
        let particles = &mut self.state.particles;
        let mean = |values: &[f64]| 0.5 * (values[i] + values[j]);
        let velocity = 0.5 * (particles.velocity[i] + particles.velocity[j]);
        let (pressure, change) = (mean(&particles.pressure), mean(&particles.pressure_change));
        particles.position.push(new.position);
        particles.velocity.push(velocity);
        particles.pressure.push(pressure);
        particles.pressure_change.push(change);
        particles.vain_divergence.push(0.0);
        particles.repeated_pressure.push([0.0]);
        particles.on_surface.push(new.on_surface);
        particles.identity.push(self.state.next_identity);
        self.state.next_identity += 1;
        for unit in &mut self.state.unit_pressure {
            unit.push([0.0; 3]);
        }
        self.state.pressure.add(new.position, self.setup.numerics.particle_spacing, i);
    }

    /// Numbers the particles that are not `taken` out.
    fn renumber(&mut self, taken: &[bool]) {
        let dx = self.setup.numerics.particle_spacing;
        let left = self.setup.behind();
        let (work, particles) = (&mut self.work, &mut self.state.particles);
        work.keys.clear();
        let kept = particles.position.iter().enumerate().filter(|(i, _)| !taken[*i]);
        work.keys.extend(kept.map(|(i, x)| {
            let column = ((x.x + left) / dx).max(0.0) as u64;
            // Heights in millionths of a spacing sort as whole numbers.
            let height = ((x.y / dx + 1e3).max(0.0) * 1e6) as u64;
            (i as u32, (column << 40) | height.min((1 << 40) - 1))
        }));
        work.keys.sort_unstable_by_key(|&(i, key)| (key, i));
        work.order.clear();
        work.order.extend(work.keys.iter().map(|&(i, _)| i));
        let order = &work.order;
        permute(&mut particles.position, order, &mut work.scratch_points);
        permute(&mut particles.velocity, order, &mut work.scratch_vectors);
        permute(&mut particles.pressure, order, &mut work.scratch_numbers);
        permute(&mut particles.pressure_change, order, &mut work.scratch_numbers);
        permute(&mut particles.vain_divergence, order, &mut work.scratch_numbers);
        permute(&mut particles.repeated_pressure, order, &mut work.scratch_pressures);
        permute(&mut particles.on_surface, order, &mut work.scratch_flags);
        permute(&mut particles.identity, order, &mut work.scratch_identities);
        for unit in &mut self.state.unit_pressure {
            permute(unit, order, &mut work.scratch_units);
        }
        self.state.pressure.renumber(order);
        self.work.resize(self.state.particles.len());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::bodies::fluid;

    /// Whether each particle is within `reach` spacings of `point`.
    fn around(fluid: &Fluid, point: Point2<f64>, reach: f64) -> Vec<bool> {
        let range = reach * fluid.setup.numerics.particle_spacing;
        fluid.state.particles.position.iter().map(|x| (x - point).norm() < range).collect()
    }

    #[test]
    fn even_water_is_left_as_it_is() {
        let mut fluid = fluid();
        let before = fluid.state.particles.position.clone();
        fluid.resample();
        assert_eq!(fluid.state.particles.position, before);
    }

    #[test]
    fn a_hole_in_the_water_is_filled() {
        let mut fluid = fluid();
        let hole = Point2::new(0.2, 0.08);
        let inside = around(&fluid, hole, 1.5);
        let count = |flags: &[bool]| flags.iter().filter(|flag| **flag).count();
        let (all, surface) = (inside.len(), count(&fluid.state.particles.on_surface));
        fluid.renumber(&inside);
        assert!(!around(&fluid, hole, 1.5).contains(&true));
        fluid.resample();
        fluid.resample();
        // Not all: those around the hole part, too.
        let added = fluid.state.particles.len() - (all - count(&inside));
        assert!((4..=6).contains(&added), "{added} where {} were taken", count(&inside));
        let widest = (-10..=10).flat_map(|x| (-10..=10).map(move |y| (x, y))).map(|(x, y)| {
            let point = hole + 0.002 * Vector2::new(f64::from(x), f64::from(y));
            let nearest = fluid.state.particles.position.iter().map(|x| (x - point).norm());
            nearest.fold(f64::INFINITY, f64::min) / fluid.setup.numerics.particle_spacing
        });
        let widest = widest.fold(0.0, f64::max);
        assert!(widest < 1.0, "{widest} spacings to the next particle");
        assert_eq!(count(&fluid.state.particles.on_surface), surface);
    }
}
