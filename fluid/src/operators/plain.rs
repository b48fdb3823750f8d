//! The operators away from walls and off the surface, where nothing but the neighbours counts: a few
//! particles at a time, side by side in the processor's vector registers.

use super::{Derivatives, Equation, Local, in_units};
use crate::fields::Fields;
use crate::fit::{self, Columns, Moments, PressureFit, Quality};
use crate::lanes::{LANES, Lanes, Number};
use crate::neighbours::BLOCK;
use crate::regularise;
use crate::setup::Discretisation;
use nalgebra::{Matrix2, Vector2};

/// Offset of what stands for no neighbour, in spacings: out of reach.
const NOWHERE: f64 = 10.0;

/// Scratch of a block.
#[derive(Clone, Debug, Default)]
pub(super) struct Scratch {
    columns: Columns<Lanes>,
    /// The block's plain particles.
    plain: Vec<usize>,
    /// Whether a particle has been dealt with.
    done: Vec<bool>,
    /// Coefficients of the Laplacian, in the order of the block's neighbour lists.
    coefficient: Vec<f64>,
}

impl Scratch {
    /// Coefficients of the Laplacian of the block's particle `offset`; `None` where it is left to the
    /// general case.
    #[inline(always)]
    pub(super) fn coefficients(
        &self,
        fields: Fields,
        block: usize,
        offset: usize,
    ) -> Option<&[f64]> {
        let lists = &fields.fluid.blocks[block];
        self.done[offset].then(|| &self.coefficient[lists.range(offset)])
    }
}

/// The plain particles of a block.
pub(super) struct Task<'a> {
    pub(super) fields: Fields<'a>,
    pub(super) block: usize,
    pub(super) locals: &'a mut [Local],
    pub(super) equations: &'a mut [Equation],
    pub(super) scratch: &'a mut Scratch,
}

impl pulp::NullaryFnOnce for Task<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        evaluate(self.fields, self.block, self.locals, self.equations, self.scratch);
    }
}

/// Evaluates the plain particles of `block` with second-order fits.
#[inline(always)]
fn evaluate(
    fields: Fields,
    block: usize,
    locals: &mut [Local],
    equations: &mut [Equation],
    scratch: &mut Scratch,
) {
    let Scratch { columns, plain, done, coefficient } = scratch;
    plain.clear();
    done.clear();
    done.resize(locals.len(), false);
    if fields.discretisation != Discretisation::Quadratic {
        return;
    }
    let lists = &fields.fluid.blocks[block];
    coefficient.resize(lists.len(), 0.0);
    let is_plain = |offset: &usize| {
        let i = block * BLOCK + offset;
        let enough = (fit::FEWEST..=fit::MOST).contains(&lists.of(*offset).len());
        enough && !fields.on_surface[i] && fields.wall_lists.of(i).is_empty()
    };
    plain.extend((0..locals.len()).filter(is_plain));
    for batch in plain.chunks(LANES) {
        // A short batch repeats its last particle.
        let offsets: [usize; LANES] = std::array::from_fn(|k| batch[k.min(batch.len() - 1)]);
        gather(fields, block, offsets, columns);
        let moments = Moments::of(columns);
        let (factor, margin) = moments.about_centre().factorize_with_margin(fit::PIVOT_THRESHOLD);
        let pressure = PressureFit::of(&factor);
        let velocity = moments.velocity(&factor);
        let fastest = columns.largest_difference();
        let diagonal = columns.laplacian(&pressure.laplacian);
        let (mut push, mut closeness) = ([Lanes::of(0.0); 2], Lanes::of(0.0));
        for (x, y) in columns.x[..columns.len].iter().zip(&columns.y[..columns.len]) {
            let (force, close) = regularise::push(*x, *y);
            push[0] += force[0];
            push[1] += force[1];
            closeness += close;
        }
        for (k, &offset) in offsets.iter().enumerate().take(batch.len()) {
            // What the neighbours do not resolve is fitted otherwise.
            done[offset] = margin.0[k] > 0.0;
            let of_list = coefficient[lists.range(offset)].iter_mut();
            for (coefficient, found) in of_list.zip(&columns.coefficient) {
                *coefficient = found.0[k];
            }
            let velocity = velocity.lane(k).limited(fastest.0[k]);
            let (u, v) = (velocity.u, velocity.v);
            let derivatives = Derivatives {
                pressure: pressure.lane(k),
                velocity_gradient: Matrix2::new(u[0], u[1], v[0], v[1]),
                velocity,
                diagonal: diagonal.0[k],
                quality: Quality::Full,
            };
            let push = Vector2::new(push[0].0[k], push[1].0[k]);
            let (shift, crowding) = regularise::inner_shift(push, closeness.0[k]);
            (locals[offset], equations[offset]) = in_units(fields, derivatives, shift, crowding);
        }
    }
}

/// Collects the rows around the block's particles `offsets`, one to a lane.
#[inline(always)]
fn gather(fields: Fields, block: usize, offsets: [usize; LANES], columns: &mut Columns<Lanes>) {
    let lists = offsets.map(|offset| fields.fluid.blocks[block].of(offset));
    let scale = 1.0 / fields.spacing;
    columns.len = lists.iter().map(|list| list.len()).max().unwrap_or(0);
    for (k, (list, offset)) in lists.iter().zip(offsets).enumerate() {
        let i = block * BLOCK + offset;
        let (centre, own) = (fields.position[i], fields.velocity[i]);
        for (row, &j) in list.iter().enumerate() {
            let d = (fields.position[j as usize] - centre) * scale;
            let jump = fields.velocity[j as usize] - own;
            columns.x[row].0[k] = d.x;
            columns.y[row].0[k] = d.y;
            columns.u[row].0[k] = jump.x;
            columns.v[row].0[k] = jump.y;
        }
        for row in list.len()..columns.len {
            columns.x[row].0[k] = NOWHERE;
            columns.y[row].0[k] = 0.0;
            columns.u[row].0[k] = 0.0;
            columns.v[row].0[k] = 0.0;
        }
    }
    columns.weigh();
}
