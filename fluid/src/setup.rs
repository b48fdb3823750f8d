//! What a fluid is asked to be: geometry, water, numerics. Plain data, validated elsewhere.

use crate::error::FluidError;
use crate::geometry::{cross, crosses_itself, placed, signed_area};
use crate::network::Network;
pub use crate::pressure::solver::{PreconditionerKind, PressureSettings, SolverKind, Start};
use nalgebra::{Point2, Vector2};
use serde::{Deserialize, Serialize};

/// The set-up of a [`crate::Fluid`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FluidSetup {
    /// The tank: fixed walls at x = 0 and x = `length`, a bed at y = 0.
    pub tank: Tank,
    /// The water in it.
    pub water: Water,
    /// Rigid boundaries, in the order of the component's interface.
    pub boundaries: Vec<RigidBoundary>,
    /// Zones in which the velocity is damped.
    pub damping_zones: Vec<DampingZone>,
    /// Numerical parameters.
    pub numerics: Numerics,
    /// How the pressure is found.
    pub pressure: PressureSettings,
    /// The network, where one finds the pressure.
    pub network: Network,
}

/// A rectangular tank, from x = 0.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tank {
    /// Length, m.
    pub length: f64,
    /// Height of the side walls, m.
    pub height: f64,
    /// The boundary that closes the tank at the left in place of a wall, if there is one: a
    /// wavemaker's paddle. It stands at x = 0 at the start, upright; its face is its own line
    /// x = 0, upwards from its reference point, and what else its corners enclose lies behind.
    pub paddle: Option<usize>,
}

/// The water at the start.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Water {
    /// Still-water depth D, m.
    pub depth: f64,
    /// Density ρ, kg/m³.
    pub density: f64,
    /// Kinematic viscosity ν, m²/s; 0 for an inviscid fluid.
    pub kinematic_viscosity: f64,
    /// Gravitational acceleration g, m/s², downwards.
    pub gravity: f64,
}

/// The water at the start: where its surface is and how it moves.
pub trait InitialFlow {
    /// Elevation of the surface above still water at `x` (m), m.
    fn elevation(&self, x: f64) -> f64;

    /// Velocity at a point in the water, m/s.
    fn velocity(&self, point: Point2<f64>) -> Vector2<f64>;

    /// How far from x = 0 the water reaches, m: there it ends in a vertical free face. `None` where
    /// it fills the length of the tank.
    fn reach(&self) -> Option<f64> {
        None
    }

    /// How far the particle of the lattice's `place` is off it, m: less than half a spacing, and
    /// on the surface along it.
    fn displacement(&self, _place: u64) -> Vector2<f64> {
        Vector2::zeros()
    }
}

/// Water at rest under a flat surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StillWater;

impl InitialFlow for StillWater {
    fn elevation(&self, _x: f64) -> f64 {
        0.0
    }

    fn velocity(&self, _point: Point2<f64>) -> Vector2<f64> {
        Vector2::zeros()
    }
}

/// A rigid boundary: a simple polygon that moves as a rigid body.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RigidBoundary {
    /// Name, used in variable names.
    pub name: String,
    /// Corners relative to the reference point at angle 0, m: counter-clockwise around a body,
    /// clockwise around a container that holds the water.
    pub corners: Vec<Vector2<f64>>,
    /// Reference point (centre of mass) at the start, m.
    pub position: Point2<f64>,
    /// Angle at the start, rad.
    pub angle: f64,
    /// Whether its acceleration is unknown before the step is solved. A held or prescribed
    /// boundary needs no added mass.
    pub free: bool,
}

impl RigidBoundary {
    /// Whether it is a container.
    #[must_use]
    pub fn holds_water(&self) -> bool {
        // Every step asks: nothing is put aside for it.
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).map(|(a, b)| cross(*a, *b)).sum::<f64>() < 0.0
    }
}

/// A zone with u ← u / (1 + γ(x) dt), γ rising from 0 at `inner_x` to its maximum at `outer_x`
/// in the shape of Wei & Kirby (1995), (exp(s²) − 1)/(e − 1).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct DampingZone {
    /// Where the damping begins, m.
    pub inner_x: f64,
    /// Where it is strongest, m.
    pub outer_x: f64,
    /// Maximum damping rate γ, 1/s.
    pub rate: f64,
}

/// How derivatives are formed from the values of particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Discretisation {
    /// Quadratic weighted least-squares fits, second order (ISPH_CQ of the paper).
    #[default]
    Quadratic,
    /// Conventional ISPH: the symmetric Laplacian of Shao & Lo (2003), kernel sums for gradient
    /// and divergence.
    Conventional,
}

/// Where within a step its pressure equation is assembled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Integrator {
    /// Halfway, at r + u dt/2: second order, neutral for linear waves.
    #[default]
    Midpoint,
    /// At r* = r + u* dt, Eqs. (6) to (8): first order, damps a wave by π ω dt of its energy a
    /// period. The equations being those of the dynamic pressure, gravity is no part of u*; what
    /// viscosity adds to r*, ν ∇²u dt², is left out.
    Paper,
}

/// Numerical parameters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Numerics {
    /// Initial particle spacing dx, m.
    pub particle_spacing: f64,
    /// Time step dt, s.
    pub time_step: f64,
    /// How derivatives are formed.
    pub discretisation: Discretisation,
    /// Where within a step its pressure equation is assembled.
    pub integrator: Integrator,
    /// Blending coefficient α of Eq. (9b).
    pub density_blend: f64,
}

impl FluidSetup {
    /// How far the bed reaches behind x = 0, m: as far as the paddle.
    pub(crate) fn behind(&self) -> f64 {
        let paddle = self.tank.paddle.map(|index| &self.boundaries[index]);
        let corners = paddle.into_iter().flat_map(|paddle| &paddle.corners);
        -corners.map(|corner| corner.x).fold(0.0, f64::min)
    }

    /// How long after its start a step of `h` (s) is assembled, s: a whole step for the paper's
    /// integrator; for the midpoint, half a step and a little more. A wave loses the part 2 π ω τ of
    /// its energy a period by a time τ beyond the half, as in off-centred implicit schemes. That
    /// makes up for the energy that the operators feed in, some of it whatever the step and more by
    /// long ones: with quadratic fits at D/dx = 20 and a default step 0.07 % a period for a low
    /// standing wave and 0.3 % for one of k a = 0.13 after some tens of periods, with conventional
    /// operators 0.3 to 0.6 %, more where walls are near.
    pub(crate) fn assembly_time(&self, h: f64) -> f64 {
        let (of_step, of_passage) = match self.numerics.discretisation {
            Discretisation::Quadratic => (0.02, 0.004),
            Discretisation::Conventional => (0.04, 0.012),
        };
        let passage =
            self.numerics.particle_spacing / (self.water.gravity * self.water.depth).sqrt();
        match self.numerics.integrator {
            Integrator::Midpoint => ((0.5 + of_step) * h + of_passage * passage).min(h),
            Integrator::Paper => h,
        }
    }

    /// Checks what the fluid itself depends on.
    pub(crate) fn validate(&self) -> Result<(), FluidError> {
        let positive = "a finite number above 0";
        let not_negative = "a finite number, 0 or above";
        for (parameter, value, may_be_zero) in [
            ("tank length", self.tank.length, false),
            ("tank height", self.tank.height, false),
            ("water depth", self.water.depth, false),
            ("density", self.water.density, false),
            ("gravity", self.water.gravity, false),
            ("kinematic viscosity", self.water.kinematic_viscosity, true),
            ("particle spacing", self.numerics.particle_spacing, false),
            ("time step", self.numerics.time_step, false),
            ("density blend", self.numerics.density_blend, true),
            ("pressure tolerance", self.pressure.tolerance, false),
            ("divergence tolerance", self.pressure.divergence_tolerance, true),
        ] {
            if !(value.is_finite() && (value > 0.0 || (may_be_zero && value == 0.0))) {
                let allowed = if may_be_zero { not_negative } else { positive };
                return Err(FluidError::Parameter { parameter, value, allowed });
            }
        }
        if let Some(paddle) = self.tank.paddle
            && self.boundaries.get(paddle).is_none_or(|boundary| boundary.free)
        {
            return Err(FluidError::Parameter {
                parameter: "index of the paddle",
                value: paddle as f64,
                allowed: "that of a boundary whose motion is prescribed",
            });
        }
        for zone in &self.damping_zones {
            let sound = zone.inner_x.is_finite()
                && zone.outer_x.is_finite()
                && zone.rate.is_finite()
                && zone.inner_x != zone.outer_x
                && zone.rate >= 0.0;
            if !sound {
                return Err(FluidError::Parameter {
                    parameter: "damping rate",
                    value: zone.rate,
                    allowed: "0 or above, over a zone of some length",
                });
            }
        }
        for boundary in &self.boundaries {
            let polygon = placed(&boundary.corners, boundary.position, boundary.angle);
            let reason = if polygon.len() < 3 {
                "needs at least three corners"
            } else if !polygon.iter().all(|p| p.x.is_finite() && p.y.is_finite()) {
                "has a corner that is not finite"
            } else if crosses_itself(&polygon) {
                "crosses itself"
            } else if signed_area(&polygon) == 0.0 {
                "must enclose an area"
            } else {
                continue;
            };
            return Err(FluidError::Boundary {
                boundary: boundary.name.clone(),
                reason: reason.to_owned(),
            });
        }
        Ok(())
    }
}
