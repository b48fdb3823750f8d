//! Particles put into the surface where it has stretched and taken out where it has shrunk, and the
//! numbering of all along the tank.
//!
//! Surface particles stay on the surface, which grows and shrinks, and drift along it with the
//! waves. The volume of the water is that below the surface, not a number of particles, so a
//! particle more or less changes where the flow is sampled and nothing else.

use crate::fluid::Fluid;
use crate::free_surface::{self, Surroundings};
use crate::geometry::signed_distance;
use crate::particles::permute;
use nalgebra::{Point2, Vector2};

/// A wider gap between two surface particles, in spacings, gets a particle in its middle.
const WIDEST: f64 = 1.6;
/// Of two surface particles closer than this, in spacings, one is taken out.
const NARROWEST: f64 = 0.6;
/// A wider gap between the surface's end and a wall, in spacings, gets a particle.
const WIDEST_AT_WALL: f64 = 1.3;
/// Distance of the outermost particle from a wall, in spacings, as in a fresh tank.
const AT_WALL: f64 = 0.5;
/// What lies further off the surface's direction than this (cosine) is not along it.
const ALONG: f64 = 0.5;

/// A particle to be put in.
struct Added {
    position: Point2<f64>,
    /// Particles that it takes its values from, in equal parts.
    from: [usize; 2],
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
                && !taken[i]
                && !self.work.broken.is_at(self.work.position[i].x)
            {
                self.look_along(i, 1.0, &mut taken, &mut added);
                self.look_along(i, -1.0, &mut taken, &mut added);
            }
        }
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
                added.push(Added { position: middle, from: [i, j] });
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
                added.push(Added { position, from: [i, i] });
            }
        }
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
        particles.on_surface.push(true);
        particles.identity.push(self.state.next_identity);
        self.state.next_identity += 1;
        for unit in &mut self.state.unit_pressure {
            unit.push([0.0; 3]);
        }
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
        // The factors belong to the old numbering.
        self.state.pressure.forget();
        self.work.resize(self.state.particles.len());
    }
}
