//! What a fluid remembers from step to step, and what it works on within one.

use crate::broken_water::{BrokenWater, Spray};
use crate::krylov::Krylov;
use crate::loads::PointPressure;
use crate::neighbours::{CellGrid, Neighbours};
use crate::operators::{Equation, Local, Scratch};
use crate::particles::Particles;
use crate::pressure::solver::PressureMemory;
use crate::sparse::SparseMatrix;
use nalgebra::{Point2, Vector2};
use seakeep_coupler::interface::{BoundaryKinematics, Load};
use serde::{Deserialize, Serialize};

/// Where a component stands in its life cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Phase {
    Instantiated,
    Initializing,
    Stepping,
    Terminated,
}

impl Phase {
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Instantiated => "before initialization",
            Self::Initializing => "during initialization",
            Self::Stepping => "between initialization and termination",
            Self::Terminated => "after termination",
        }
    }
}

/// What a saved state holds: everything that the coming steps depend on.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct State {
    pub(crate) start_time: f64,
    pub(crate) time: f64,
    pub(crate) step: u64,
    pub(crate) particles: Particles,
    /// Particles taken out because they were lost.
    pub(crate) lost: u64,
    /// Identity of the next particle that is added.
    pub(crate) next_identity: u32,
    pub(crate) kinematics: Vec<BoundaryKinematics>,
    pub(crate) accelerations: Vec<f64>,
    /// Pressure of unit accelerations of each free boundary, Pa per m/s² and rad/s².
    pub(crate) unit_pressure: Vec<Vec<[f64; 3]>>,
    pub(crate) wall_activity: Vec<f64>,
    pub(crate) pressure: PressureMemory,
    pub(crate) loads: Vec<Load>,
}

/// What a step works on; nothing of it outlives the step but its memory.
#[derive(Default)]
pub(crate) struct Work {
    pub(crate) position: Vec<Point2<f64>>,
    pub(crate) on_surface: Vec<bool>,
    pub(crate) normal: Vec<Vector2<f64>>,
    pub(crate) broken: BrokenWater,
    pub(crate) spray: Spray,
    pub(crate) grid: CellGrid,
    pub(crate) wall_grid: CellGrid,
    pub(crate) fluid: Neighbours,
    pub(crate) wall_lists: Neighbours,
    pub(crate) fluid_of_walls: Neighbours,
    pub(crate) scratch: Vec<Scratch>,
    pub(crate) locals: Vec<Local>,
    pub(crate) equations: Vec<Equation>,
    pub(crate) matrix: SparseMatrix,
    /// Ψ of Eq. (9b), kg/(m³ s).
    pub(crate) source: Vec<f64>,
    pub(crate) rhs: Vec<[f64; 1]>,
    pub(crate) solution: Vec<[f64; 1]>,
    /// Part of the pressure that is no load, Pa; see [`crate::pressure::repeated`].
    pub(crate) repeated: Vec<[f64; 1]>,
    pub(crate) repeated_rhs: Vec<[f64; 1]>,
    pub(crate) krylov: Krylov<1>,
    /// Inner particles that walls reach, directly or over a neighbour; see [`crate::pressure::repeated`].
    pub(crate) near_walls: Vec<bool>,
    pub(crate) unit_rhs: Vec<[f64; 3]>,
    pub(crate) unit_solution: Vec<Vec<[f64; 3]>>,
    pub(crate) unit_krylov: Krylov<3>,
    pub(crate) wall_pressure: Vec<PointPressure>,
    /// Dynamic pressure of the step, Pa.
    pub(crate) pressure: Vec<f64>,
    pub(crate) order: Vec<u32>,
    pub(crate) keys: Vec<(u32, u64)>,
    pub(crate) line: Vec<Point2<f64>>,
    pub(crate) scratch_points: Vec<Point2<f64>>,
    /// Outline of a boundary, m.
    pub(crate) polygon: Vec<Point2<f64>>,
    pub(crate) scratch_vectors: Vec<Vector2<f64>>,
    pub(crate) scratch_numbers: Vec<f64>,
    /// Particles that resampling takes out.
    pub(crate) taken: Vec<bool>,
    pub(crate) scratch_flags: Vec<bool>,
    pub(crate) scratch_identities: Vec<u32>,
    pub(crate) scratch_pressures: Vec<[f64; 1]>,
    pub(crate) scratch_units: Vec<[f64; 3]>,
}

impl Work {
    /// Makes room for `count` particles.
    pub(crate) fn resize(&mut self, count: usize) {
        self.position.resize(count, Point2::origin());
        self.on_surface.resize(count, false);
        self.normal.resize(count, Vector2::zeros());
        self.locals.resize(count, Local::default());
        self.equations.resize(count, Equation::default());
        self.source.resize(count, 0.0);
        self.rhs.resize(count, [0.0]);
        self.solution.resize(count, [0.0]);
        self.repeated.resize(count, [0.0]);
        self.repeated_rhs.resize(count, [0.0]);
        self.near_walls.resize(count, false);
        self.pressure.resize(count, 0.0);
        if !self.unit_solution.is_empty() {
            self.unit_rhs.resize(count, [0.0; 3]);
        }
        for unit in &mut self.unit_solution {
            unit.resize(count, [0.0; 3]);
        }
    }
}
