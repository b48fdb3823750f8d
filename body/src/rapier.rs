//! The rapier2d engine.
//!
//! rapier2d is a game engine, told here to be a plain integrator: no world gravity, no sleeping,
//! no substeps of its continuous collision detection, no speed limits. It does the drifts, where
//! its contacts act, as hard as the solver makes them. The kicks change velocities from outside, since with added
//! mass only the coupled system knows the acceleration; so rapier never integrates a load, and
//! the amplitude that its solver iterations add to a swinging body under `add_force` (measured:
//! 1 % a cycle with its default of four) cannot arise. One iteration is the cheapest.
//!
//! rapier2d turns a body by atan(Ω t) in a drift of t instead of Ω t. The difference, Ω³ t³/3, is
//! of second order over a run and leaves the scheme symplectic.

use crate::engine::{check_length, entry, free_mass_matrix, kicked};
use crate::{BodyError, BodyProperties, Contacts, Forcing, FreeDegrees, RigidBodyEngine};
use nalgebra::{DMatrix, Point2, Vector2};
use rapier2d_f64::prelude::{
    IntegrationParameters, LockedAxes, MassProperties, PhysicsWorld, Pose, RigidBody,
    RigidBodyBuilder, RigidBodyHandle, RigidBodyType, SpringCoefficients, Vector,
};
use seakeep_coupler::interface::BoundaryKinematics;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

const NAME: &str = "rapier2d";

/// Bodies moved by rapier2d.
pub struct RapierEngine {
    contacts: Contacts,
    world: PhysicsWorld,
    handles: Vec<RigidBodyHandle>,
    /// rapier knows angles modulo 2π only, and accelerations not at all: both are kept here.
    kinematics: Vec<BoundaryKinematics>,
    rotates: Vec<bool>,
    mass_matrix: DMatrix<f64>,
}

/// The engine's state, borrowed for saving.
#[derive(Serialize)]
struct SavedWorldRef<'a> {
    world: &'a PhysicsWorld,
    handles: &'a [RigidBodyHandle],
    kinematics: &'a [BoundaryKinematics],
}

/// The engine's state, as restored.
#[derive(Deserialize)]
struct SavedWorld {
    world: PhysicsWorld,
    handles: Vec<RigidBodyHandle>,
    kinematics: Vec<BoundaryKinematics>,
}

impl RapierEngine {
    /// An engine without bodies and tank, whose bodies touch without restitution and friction.
    #[must_use]
    pub fn new() -> Self {
        Self::with_contacts(Contacts::default())
    }

    /// An engine without bodies, whose bodies touch each other and the tank like this.
    #[must_use]
    pub fn with_contacts(contacts: Contacts) -> Self {
        Self {
            contacts,
            world: empty_world(),
            handles: Vec::new(),
            kinematics: Vec::new(),
            rotates: Vec::new(),
            mass_matrix: DMatrix::zeros(0, 0),
        }
    }

    /// r ← r + V `duration` (s), with contacts.
    fn drift(&mut self, duration: f64) -> Result<(), BodyError> {
        self.world.integration_parameters.dt = duration;
        self.world.step();
        // rapier disables a body whose pose or velocity overflows, and says so here only.
        if !self.world.quarantine().is_empty() {
            return Err(BodyError::Engine {
                engine: NAME,
                reason: "a body left the range of finite numbers".to_owned(),
            });
        }
        for ((known, handle), rotates) in
            self.kinematics.iter_mut().zip(&self.handles).zip(&self.rotates)
        {
            let body = &self.world.bodies[*handle];
            let (position, velocity) = (body.translation(), body.linvel());
            known.position = Point2::new(position.x, position.y);
            known.velocity = Vector2::new(velocity.x, velocity.y);
            known.angular_velocity = body.angvel();
            // A held angle keeps its bits: rapier normalises its rotations in every step.
            if *rotates {
                let expected = known.angle + known.angular_velocity * duration;
                let angle = body.rotation().angle();
                known.angle = angle + TAU * ((expected - angle) / TAU).round();
            }
        }
        Ok(())
    }

    /// V ← V + a `duration` (s).
    fn kick(&mut self, accelerations: &[f64], duration: f64) {
        for ((known, handle), acceleration) in
            self.kinematics.iter_mut().zip(&self.handles).zip(accelerations.chunks_exact(3))
        {
            *known = kicked(known, acceleration, duration);
            set_velocity(&mut self.world.bodies[*handle], known);
        }
    }
}

impl Default for RapierEngine {
    fn default() -> Self {
        Self::new()
    }
}

/// Contacts without compliance, whose overlap is taken back at once.
const HARD: SpringCoefficients<f64> =
    SpringCoefficients { natural_frequency: 1e6, damping_ratio: 1.0 };

/// Distance at which a contact begins, m. A collision is new only in the step in which the bodies
/// come this near, and only a new one has a restitution: it must be less than they move in a step.
/// Bodies at rest on each other stay within it.
const NEAR: f64 = 1e-5;

/// A world that only integrates: see the module's text for each setting.
fn empty_world() -> PhysicsWorld {
    PhysicsWorld {
        gravity: Vector::ZERO,
        integration_parameters: IntegrationParameters {
            num_solver_iterations: 1,
            max_ccd_substeps: 0,
            num_internal_pgs_iterations: 10,
            contact_softness: HARD,
            static_contact_softness: HARD,
            contact_recycling: false,
            normalized_prediction_distance: NEAR,
            friction_in_bias_pass: true,
            normalized_max_linear_velocity: f64::MAX,
            ..IntegrationParameters::default()
        },
        ..PhysicsWorld::default()
    }
}

fn locked_axes(free: FreeDegrees) -> LockedAxes {
    let mut locked = LockedAxes::empty();
    locked.set(LockedAxes::TRANSLATION_LOCKED_X, !free.sway);
    locked.set(LockedAxes::TRANSLATION_LOCKED_Y, !free.heave);
    locked.set(LockedAxes::ROTATION_LOCKED, !free.roll);
    locked
}

fn rapier_body(body: &BodyProperties) -> RigidBody {
    RigidBodyBuilder::dynamic()
        .translation(Vector::new(body.position.x, body.position.y))
        .rotation(body.angle)
        .linvel(Vector::new(body.velocity.x, body.velocity.y))
        .angvel(body.angular_velocity)
        .additional_mass_properties(MassProperties::new(Vector::ZERO, body.mass, body.inertia))
        .locked_axes(locked_axes(body.free))
        .allow_fast_rotation(true)
        .can_sleep(false)
        .build()
}

fn set_velocity(body: &mut RigidBody, kinematics: &BoundaryKinematics) {
    body.set_linvel(Vector::new(kinematics.velocity.x, kinematics.velocity.y), true);
    body.set_angvel(kinematics.angular_velocity, true);
}

fn place(body: &mut RigidBody, kinematics: &BoundaryKinematics) {
    let position = Vector::new(kinematics.position.x, kinematics.position.y);
    body.set_position(Pose::new(position, kinematics.angle), true);
    set_velocity(body, kinematics);
}

impl RigidBodyEngine for RapierEngine {
    fn name(&self) -> &'static str {
        NAME
    }

    fn set_bodies(&mut self, bodies: &[BodyProperties]) -> Result<(), BodyError> {
        let mut world = empty_world();
        for plane in self.contacts.tank() {
            world.insert_collider(plane, None);
        }
        let mut handles = Vec::with_capacity(bodies.len());
        for body in bodies {
            let handle = world.insert_body(rapier_body(body));
            handles.push(handle);
            if body.outline.is_empty() {
                continue;
            }
            let collider = self.contacts.body(&body.outline).ok_or(BodyError::Engine {
                engine: NAME,
                reason: format!("the outline of {} is no simple polygon", body.name),
            })?;
            world.insert_collider(collider, Some(handle));
        }
        self.handles = handles;
        self.world = world;
        self.kinematics = bodies.iter().map(BodyProperties::kinematics).collect();
        self.rotates = bodies.iter().map(|body| body.free.roll).collect();
        self.mass_matrix = free_mass_matrix(bodies);
        Ok(())
    }

    fn mass_matrix(&self) -> &DMatrix<f64> {
        &self.mass_matrix
    }

    fn kinematics(&self) -> &[BoundaryKinematics] {
        &self.kinematics
    }

    fn set_kinematics(&mut self, kinematics: &[BoundaryKinematics]) -> Result<(), BodyError> {
        check_length("kinematics", kinematics.len(), self.kinematics.len())?;
        for (new, handle) in kinematics.iter().zip(&self.handles) {
            place(&mut self.world.bodies[*handle], new);
        }
        self.kinematics.copy_from_slice(kinematics);
        Ok(())
    }

    fn steer(&mut self, body: usize, kinematics: &BoundaryKinematics) -> Result<(), BodyError> {
        *entry(&mut self.kinematics, body)? = *kinematics;
        self.rotates[body] = true;
        let steered = &mut self.world.bodies[self.handles[body]];
        steered.set_locked_axes(LockedAxes::empty(), true);
        steered.set_body_type(RigidBodyType::KinematicVelocityBased, true);
        place(steered, kinematics);
        Ok(())
    }

    fn advance(
        &mut self,
        time: f64,
        duration: f64,
        forcing: &mut dyn Forcing,
    ) -> Result<(), BodyError> {
        let middle = time + 0.5 * duration;
        let mut accelerations = vec![0.0; 3 * self.kinematics.len()];
        self.drift(0.5 * duration)?;
        forcing.accelerations(middle, &self.kinematics, &mut accelerations)?;
        if forcing.depends_on_velocity() {
            // The velocity so far is the one at the step's start.
            let predicted: Vec<_> = self
                .kinematics
                .iter()
                .zip(accelerations.chunks_exact(3))
                .map(|(body, acceleration)| kicked(body, acceleration, 0.5 * duration))
                .collect();
            forcing.accelerations(middle, &predicted, &mut accelerations)?;
        }
        self.kick(&accelerations, duration);
        self.drift(0.5 * duration)
    }

    fn save(&self) -> Result<Vec<u8>, BodyError> {
        postcard::to_stdvec(&SavedWorldRef {
            world: &self.world,
            handles: &self.handles,
            kinematics: &self.kinematics,
        })
        .map_err(|error| BodyError::Engine { engine: NAME, reason: error.to_string() })
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), BodyError> {
        let failed = |reason: String| BodyError::Engine { engine: NAME, reason };
        let saved: SavedWorld =
            postcard::from_bytes(state).map_err(|error| failed(error.to_string()))?;
        check_length("bodies in the state", saved.handles.len(), self.handles.len())?;
        check_length("bodies in the state", saved.kinematics.len(), self.handles.len())?;
        // The handles index the world from now on: a damaged state must not make that panic.
        if saved.handles.iter().any(|handle| saved.world.bodies.get(*handle).is_none()) {
            return Err(failed("the state misses a body".to_owned()));
        }
        self.world = saved.world;
        self.handles = saved.handles;
        self.kinematics = saved.kinematics;
        Ok(())
    }
}
