//! What touches: outlines of bodies and the tank, for rapier2d.

use nalgebra::Vector2;
use rapier2d_f64::parry::shape::TriMesh;
use rapier2d_f64::parry::transformation::hertel_mehlhorn;
use rapier2d_f64::prelude::{Collider, ColliderBuilder, Pose, SharedShape, Vector};

/// How bodies touch each other, the side walls and the bed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contacts {
    /// Speed along the normal after over before a collision, 0 to 1.
    pub restitution: f64,
    /// Coefficient of Coulomb friction.
    pub friction: f64,
    /// Distance of the tank's side walls, at x = 0 and there, m; its bed is at y = 0. Without it
    /// there is no tank.
    pub tank_length: Option<f64>,
}

impl Contacts {
    /// The side walls and the bed, if there is a tank.
    pub(crate) fn tank(&self) -> Vec<Collider> {
        let plane = |x: f64, normal: Vector2<f64>| {
            let shape = SharedShape::halfspace(Vector::new(normal.x, normal.y));
            self.collider(shape).translation(Vector::new(x, 0.0)).build()
        };
        self.tank_length.map_or(Vec::new(), |length| {
            vec![plane(0.0, Vector2::x()), plane(length, -Vector2::x()), plane(0.0, Vector2::y())]
        })
    }

    /// A body's outline, if it is a simple polygon. It has no mass of its own.
    pub(crate) fn body(&self, outline: &[Vector2<f64>]) -> Option<Collider> {
        let corners: Vec<Vector> = outline.iter().map(|c| Vector::new(c.x, c.y)).collect();
        let triangles = TriMesh::from_polygon(corners)?;
        let parts = hertel_mehlhorn(triangles.vertices(), triangles.indices());
        let convex = |part| Some((Pose::IDENTITY, SharedShape::convex_polyline(part)?));
        let parts: Vec<_> = parts.into_iter().map(convex).collect::<Option<_>>()?;
        Some(self.collider(SharedShape::compound(parts)).density(0.0).build())
    }

    fn collider(&self, shape: SharedShape) -> ColliderBuilder {
        // Two of a kind have the mean of their coefficients, which is the coefficient.
        ColliderBuilder::new(shape).restitution(self.restitution).friction(self.friction)
    }
}
