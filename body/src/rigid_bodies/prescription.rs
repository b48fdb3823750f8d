//! Bodies that follow a prescribed motion.

use super::RigidBodies;
use crate::{BodyError, FreeDegrees, PrescribedMotion};
use seakeep_coupler::interface::BoundaryKinematics;

/// The motion that one body follows.
pub(super) struct Prescription {
    pub(super) body: usize,
    pub(super) motion: Box<dyn PrescribedMotion>,
}

impl Prescription {
    /// Kinematics at `time` (s), with the mean acceleration over the coming step if that has the
    /// length `step` (s): known ahead, it is what the water beside the body has to follow. The
    /// acceleration at `time` itself where `step` is 0 or the motion ends before.
    pub(super) fn outlook(&self, time: f64, step: f64) -> Result<BoundaryKinematics, BodyError> {
        let now = self.motion.kinematics(time)?;
        match self.motion.kinematics(time + step) {
            Ok(next) if step > 0.0 => Ok(with_mean_acceleration(&now, &next, step)),
            _ => Ok(now),
        }
    }

    /// Kinematics at `time` (s) with the constant velocity that leads to the pose `duration` (s)
    /// later.
    pub(super) fn chord(&self, time: f64, duration: f64) -> Result<BoundaryKinematics, BodyError> {
        let mut now = self.motion.kinematics(time)?;
        let next = self.motion.kinematics(time + duration)?;
        now.velocity = (next.position - now.position) / duration;
        now.angular_velocity = (next.angle - now.angle) / duration;
        Ok(now)
    }
}

/// `old`, with the acceleration that leads to the velocity of `new` in `duration` (s).
fn with_mean_acceleration(
    old: &BoundaryKinematics,
    new: &BoundaryKinematics,
    duration: f64,
) -> BoundaryKinematics {
    BoundaryKinematics {
        acceleration: (new.velocity - old.velocity) / duration,
        angular_acceleration: (new.angular_velocity - old.angular_velocity) / duration,
        ..*old
    }
}

impl RigidBodies {
    /// Lets the body number `body`, from 0, follow `motion` instead of the loads on it. Its pose
    /// and velocity are exactly the motion's at communication points, its mean acceleration over
    /// a step is the change of that velocity. The acceleration among its
    /// [`kinematics`](seakeep_coupler::interface::MotionComponent::kinematics) is the mean over
    /// the coming step, taken to be as long as the last, and that of the motion before the first.
    ///
    /// # Errors
    /// [`BodyError::UnknownBody`], [`BodyError::PrescribedTwice`], or a motion that does not know
    /// the start.
    pub fn prescribe(
        &mut self,
        body: usize,
        motion: Box<dyn PrescribedMotion>,
    ) -> Result<(), BodyError> {
        let count = self.bodies.len();
        let properties =
            self.bodies.get_mut(body).ok_or(BodyError::UnknownBody { index: body, count })?;
        if self.prescriptions.iter().any(|known| known.body == body) {
            return Err(BodyError::PrescribedTwice { body: properties.name.clone() });
        }
        properties.free = FreeDegrees::NONE;
        self.free[3 * body..3 * body + 3].fill(false);
        self.prescriptions.push(Prescription { body, motion });
        self.take_up_prescriptions()
    }

    /// Tells the motion of the body number `body`, if it is prescribed, the elevation of the water
    /// surface above still water (m) that was measured at it at the current communication point.
    ///
    /// # Errors
    /// When the motion does not know the present.
    pub fn observe_elevation(&mut self, body: usize, elevation: f64) -> Result<(), BodyError> {
        for known in self.prescriptions.iter_mut().filter(|known| known.body == body) {
            known.motion.observe(elevation);
        }
        self.note_prescribed()
    }

    /// Puts the prescribed bodies where their motions are now.
    pub(super) fn take_up_prescriptions(&mut self) -> Result<(), BodyError> {
        for known in &self.prescriptions {
            let now = known.motion.kinematics(self.motion.time)?;
            self.engine.steer(known.body, &now)?;
        }
        self.note_prescribed()
    }

    /// Reads the kinematics of the prescribed bodies.
    pub(super) fn note_prescribed(&mut self) -> Result<(), BodyError> {
        for known in &self.prescriptions {
            self.motion.kinematics[known.body] =
                known.outlook(self.motion.time, self.motion.last_step)?;
        }
        Ok(())
    }

    /// What the prescribed accelerations over the step of `duration` (s) from `time` (s) add to
    /// the load on each body through the added mass, −A a: three values a body.
    pub(super) fn prescribed_reaction(
        &self,
        time: f64,
        duration: f64,
    ) -> Result<Vec<f64>, BodyError> {
        let mut loads = vec![0.0; 3 * self.bodies.len()];
        for known in &self.prescriptions {
            let ahead = known.outlook(time, duration)?;
            let accelerations =
                [ahead.acceleration.x, ahead.acceleration.y, ahead.angular_acceleration];
            for (degree, acceleration) in accelerations.iter().enumerate() {
                let column = self.motion.response.added_mass.column(3 * known.body + degree);
                for (load, mass) in loads.iter_mut().zip(column.iter()) {
                    *load -= mass * acceleration;
                }
            }
        }
        Ok(loads)
    }
}
