//! The plan of a step: the stages that a set-up needs, and nothing else.

use crate::setup::FluidSetup;
use serde::Serialize;
use std::fmt;

/// A stage of the time step, in the order in which they run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Surface particles added and taken away, and all numbered anew, now and then.
    Resample,
    /// Lists of neighbours among fluid and wall particles.
    Neighbours,
    /// Which particles are on the free surface, and its normal.
    FreeSurface,
    /// Which wall particles bound the water, and by how much.
    WettedWalls,
    /// Quadratic fits: divergence, pressure equations but for their source, shifts.
    Operators,
    /// The viscous term of Eq. (7).
    Viscosity,
    /// Eq. (9b) for the pressure at zero acceleration of the boundaries.
    Pressure,
    /// The pressure of unit accelerations of the free boundaries.
    AddedMass,
    /// Loads on the boundaries, Eqs. (19) and (20), and the part of the pressure that is none.
    Loads,
    /// Velocity and position, Eqs. (10) to (12).
    Correct,
    /// Damping zones.
    Damping,
    /// Shifts that keep particles regular.
    Regularise,
}

impl Stage {
    /// All stages, in order.
    pub const ALL: [Self; 12] = [
        Self::Resample,
        Self::Neighbours,
        Self::FreeSurface,
        Self::WettedWalls,
        Self::Operators,
        Self::Viscosity,
        Self::Pressure,
        Self::AddedMass,
        Self::Loads,
        Self::Correct,
        Self::Damping,
        Self::Regularise,
    ];
}

impl fmt::Display for Stage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Neighbours => "neighbours",
            Self::FreeSurface => "free surface",
            Self::WettedWalls => "wetted walls",
            Self::Operators => "operators",
            Self::Viscosity => "viscosity",
            Self::Pressure => "pressure",
            Self::AddedMass => "added mass",
            Self::Loads => "loads",
            Self::Correct => "correct",
            Self::Damping => "damping",
            Self::Regularise => "regularise",
            Self::Resample => "resample",
        })
    }
}

/// One stage of a plan.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct PlanEntry {
    /// The stage.
    pub stage: Stage,
    /// Whether the step runs it.
    pub kept: bool,
    /// Why, or why not.
    pub reason: &'static str,
}

/// Which stages a step runs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Plan {
    /// Every stage in order, kept or left out.
    pub entries: Vec<PlanEntry>,
}

impl Plan {
    /// The plan for `setup`.
    #[must_use]
    pub fn new(setup: &FluidSetup) -> Self {
        let boundaries = !setup.boundaries.is_empty();
        let free = setup.boundaries.iter().any(|boundary| boundary.free);
        let always = |reason| (true, reason);
        let when = |kept, yes, no| (kept, if kept { yes } else { no });
        let entries = Stage::ALL
            .into_iter()
            .map(|stage| {
                let (kept, reason) = match stage {
                    Stage::Neighbours => always("every operator works on neighbours"),
                    Stage::FreeSurface => always("the water has a free surface"),
                    Stage::WettedWalls => always("the tank has walls"),
                    Stage::Operators => always("assembles Eq. (9b)"),
                    Stage::Viscosity => when(
                        setup.water.kinematic_viscosity > 0.0,
                        "the kinematic viscosity is above zero",
                        "the water is inviscid",
                    ),
                    Stage::Pressure => always("the fluid is incompressible"),
                    Stage::AddedMass => when(
                        free,
                        "a boundary is free to answer the pressure",
                        "no boundary is free: its acceleration is known",
                    ),
                    Stage::Loads => {
                        when(boundaries, "there are boundaries", "there is no boundary")
                    }
                    Stage::Correct => always("moves the particles"),
                    Stage::Damping => when(
                        !setup.damping_zones.is_empty(),
                        "there are damping zones",
                        "there is no damping zone",
                    ),
                    Stage::Regularise => always("Lagrangian particles lose their order"),
                    Stage::Resample => always("the surface stretches and shrinks, and neighbours are to be close in memory"),
                };
                PlanEntry { stage, kept, reason }
            })
            .collect();
        Self { entries }
    }

    /// Whether the step runs `stage`.
    #[must_use]
    pub fn runs(&self, stage: Stage) -> bool {
        self.entries.iter().any(|entry| entry.stage == stage && entry.kept)
    }
}
