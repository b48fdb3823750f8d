//! Wave paddles: what they look like, how they move to make a wave, and how they absorb one.
//!
//! The stroke X(t) is the displacement of the paddle at the still-water level from its rest
//! position. A wave goes through the linear transfer function of the paddle, component by
//! component; what each kind of wave adds to that stands with its constructor in
//! [`PaddleMotion`].

mod absorption;
mod board;
mod motion;
mod projection;
mod second_harmonic;
mod solitary_stroke;
mod stroke;
mod wavemaker;

pub use absorption::{AbsorptionState, ActiveAbsorption};
pub use board::Board;
pub use motion::PaddleMotion;
pub use stroke::StrokeMotion;
pub use wavemaker::Wavemaker;
