//! Numbers one at a time or a few side by side, so that the same code fits around one particle
//! or around several at once. Each lane sees the operations, in their order, that a number
//! alone would: results do not depend on how many go together.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Numbers side by side: as many as a vector register of common processors holds.
pub(crate) const LANES: usize = 4;

/// A real number, or several.
pub(crate) trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// `value`, in every lane.
    fn of(value: f64) -> Self;
    fn sqrt(self) -> Self;
    /// The larger; `other` where one is not a number.
    fn larger(self, other: Self) -> Self;
    /// The smaller; `other` where one is not a number.
    fn smaller(self, other: Self) -> Self;
}

impl Number for f64 {
    #[inline(always)]
    fn of(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self::sqrt(self)
    }
    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        if self > other { self } else { other }
    }
    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        if self < other { self } else { other }
    }
}

/// [`LANES`] numbers.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub(crate) struct Lanes(pub(crate) [f64; LANES]);

impl Lanes {
    #[inline(always)]
    fn with(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        Self(std::array::from_fn(|k| f(self.0[k], other.0[k])))
    }
}

impl Number for Lanes {
    #[inline(always)]
    fn of(value: f64) -> Self {
        Self([value; LANES])
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(f64::sqrt))
    }
    #[inline(always)]
    fn larger(self, other: Self) -> Self {
        self.with(other, Number::larger)
    }
    #[inline(always)]
    fn smaller(self, other: Self) -> Self {
        self.with(other, Number::smaller)
    }
}

impl Neg for Lanes {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|a| -a))
    }
}

macro_rules! operator {
    ($trait:ident, $name:ident, $symbol:tt) => {
        impl $trait for Lanes {
            type Output = Self;
            #[inline(always)]
            fn $name(self, other: Self) -> Self {
                self.with(other, |a, b| a $symbol b)
            }
        }
    };
}

operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl AddAssign for Lanes {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Lanes {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}
