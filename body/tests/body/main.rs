//! Tests of the rigid bodies: alone, and coupled by the master to an analytic load.

mod common;
mod contact;
mod coupled;
mod free_motion;
mod mooring;
mod prescribed;
mod refusals;
mod state;
