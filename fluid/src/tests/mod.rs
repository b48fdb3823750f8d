//! Tests of the inner parts that the crate does not show.

pub(crate) mod bodies;
mod corner;
mod fit;
mod krylov;
mod manufactured;
mod network;
mod regularise;
mod standing_wave;

/// A number in (−1, 1) that looks random and is the same in every run: the digits of a sine.
pub(crate) fn scatter(i: i64, j: i64) -> f64 {
    ((i as f64 * 12.9898 + j as f64 * 78.233).sin() * 43_758.545_3).fract()
}
