//! Helpers of the tests that cross crates: small scenes, stepped in process.

pub mod model_fluid;

use seakeep::case::Case;
use seakeep_body::{BodyProperties, FreeDegrees, RapierEngine, RigidBodies};
use seakeep_coupler::interface::{Component, ComponentState, MotionComponent};
use seakeep_coupler::{FixedStepMaster, SavedState};
use seakeep_fluid::Fluid;

/// A box of half the water's density, released at an angle: 10 rows of particles, quick.
pub const FLOATING_BOX: &str = r#"
end_time_s = 1.0

[tank]
length_m = 1.0
height_m = 0.3

[water]
depth_m = 0.2

[numerics]
particle_spacing_m = 0.02

[[body]]
box = { width_m = 0.16, height_m = 0.12 }
position_m = [0.5, 0.2]
angle_deg = 5.0
density_kg_m3 = 500.0
"#;

/// The case `text` with `overrides`.
///
/// # Panics
/// When the case is refused, with the reasons.
#[must_use]
pub fn case(text: &str, overrides: &[&str]) -> Case {
    let overrides: Vec<String> = overrides.iter().map(|&set| set.to_owned()).collect();
    Case::parse("test", "test.toml", text, &overrides).unwrap_or_else(|error| panic!("{error}"))
}

/// A fluid and one body with the master, the components in reach.
pub struct Coupled {
    /// The water.
    pub fluid: Fluid,
    /// The body.
    pub bodies: RigidBodies,
    /// What couples them.
    pub master: FixedStepMaster,
}

impl Coupled {
    /// Starts the scene of `case` with its bodies.
    ///
    /// # Panics
    /// When a component refuses the scene.
    #[must_use]
    #[allow(clippy::unwrap_used, reason = "a helper of tests")]
    pub fn start(case: &Case) -> Self {
        let scene = &case.scene;
        let properties = scene.bodies.iter().zip(&scene.fluid.boundaries);
        let properties = properties.map(|(body, boundary)| BodyProperties {
            angle: boundary.angle,
            free: FreeDegrees { sway: body.free[0], heave: body.free[1], roll: body.free[2] },
            ..BodyProperties::new(&body.name, body.mass, body.inertia, boundary.position)
        });
        let gravity = scene.fluid.water.gravity;
        let engine = Box::new(RapierEngine::new());
        let mut bodies = RigidBodies::new(properties.collect(), gravity, engine).unwrap();
        let mut fluid = Fluid::flowing(scene.fluid.clone(), &scene.initial_water).unwrap();
        let step = scene.communication_step();
        let motion = Some(&mut bodies as &mut dyn MotionComponent);
        let master =
            FixedStepMaster::start_with(scene.coupling, 0.0, step, &mut fluid, motion).unwrap();
        Self { fluid, bodies, master }
    }

    /// Takes `count` steps.
    ///
    /// # Panics
    /// When a step fails.
    #[allow(clippy::unwrap_used, reason = "a helper of tests")]
    pub fn steps(&mut self, count: usize) {
        for _ in 0..count {
            self.master.step(&mut self.fluid, Some(&mut self.bodies)).unwrap();
        }
    }

    /// Saves everything.
    ///
    /// # Panics
    /// When a component cannot be saved.
    #[must_use]
    #[allow(clippy::unwrap_used, reason = "a helper of tests")]
    pub fn save(&self) -> SavedState {
        self.master.save(&self.fluid, Some(&self.bodies)).unwrap()
    }

    /// Goes back to a saved state.
    ///
    /// # Panics
    /// When a component refuses the state.
    #[allow(clippy::unwrap_used, reason = "a helper of tests")]
    pub fn restore(&mut self, saved: &SavedState) {
        self.master.restore(&mut self.fluid, Some(&mut self.bodies), saved).unwrap();
    }

    /// The states of both components, to the bit.
    ///
    /// # Panics
    /// When a component cannot be saved.
    #[must_use]
    #[allow(clippy::unwrap_used, reason = "a helper of tests")]
    pub fn states(&self) -> [ComponentState; 2] {
        [self.fluid.get_state().unwrap(), self.bodies.get_state().unwrap()]
    }

    /// Heave of the only body from its start, m.
    #[must_use]
    pub fn heave(&self) -> f64 {
        self.bodies.kinematics()[0].position.y - self.bodies.bodies()[0].position.y
    }
}
