//! Water at a body: none of it stays inside, and few particles by a wall say no more than they know.

use crate::fields::Fields;
use crate::fluid::Fluid;
use crate::geometry::signed_distance;
use crate::loads::PointPressure;
use crate::neighbours::Neighbours;
use crate::network::Network;
use crate::setup::{
    Discretisation, FluidSetup, Integrator, Numerics, PressureSettings, RigidBoundary, Tank, Water,
};
use crate::walls::{Owner, Walls};
use nalgebra::{Point2, Vector2};
use seakeep_coupler::interface::BoundaryKinematics;

const SPACING: f64 = 0.02;

/// A small tank of water, 0.2 m deep.
fn tank(boundaries: Vec<RigidBoundary>, paddle: Option<usize>) -> Fluid {
    let setup = FluidSetup {
        tank: Tank { length: 1.0, height: 0.4, paddle },
        water: Water { depth: 0.2, density: 1000.0, kinematic_viscosity: 0.0, gravity: 9.81 },
        boundaries,
        damping_zones: Vec::new(),
        numerics: Numerics {
            particle_spacing: SPACING,
            time_step: 0.002,
            discretisation: Discretisation::Quadratic,
            integrator: Integrator::Midpoint,
            density_blend: 0.01,
        },
        pressure: PressureSettings::default(),
        network: Network::shipped().expect("the shipped network"),
    };
    Fluid::new(setup).expect("a case that can be")
}

/// A rectangle from `low` to `high` (m, from its position) that is held.
fn rectangle(name: &str, position: [f64; 2], low: [f64; 2], high: [f64; 2]) -> RigidBoundary {
    let corners = [low, [high[0], low[1]], high, [low[0], high[1]]];
    RigidBoundary {
        name: name.to_owned(),
        corners: corners.map(Vector2::from).to_vec(),
        position: Point2::from(position),
        angle: 0.0,
        free: false,
    }
}

/// A box of 0.2 m by 0.12 m that floats in a small tank, at an angle and moving.
pub(crate) fn fluid() -> Fluid {
    let held = rectangle("box", [0.5, 0.2], [-0.1, -0.06], [0.1, 0.06]);
    let mut fluid = tank(vec![RigidBoundary { angle: 0.1, free: true, ..held }], None);
    fluid.state.kinematics[0] = BoundaryKinematics {
        velocity: Vector2::new(0.3, -0.1),
        angular_velocity: 0.5,
        ..BoundaryKinematics::at_rest(Point2::new(0.5, 0.2), 0.1)
    };
    fluid
}

#[test]
fn what_has_got_into_a_body_is_put_back_on_its_outline() {
    let h = 0.002;
    let mut fluid = fluid();
    let before = fluid.state.particles.position.clone();
    fluid.keep_out(h);
    assert_eq!(fluid.state.particles.position, before, "none was inside");

    let now = fluid.state.kinematics[0].drifted(h);
    // Off the middle of the right face, falling further in, and one that is on its way out.
    let normal = Vector2::new(now.angle.cos(), now.angle.sin());
    let along = Vector2::new(-normal.y, normal.x);
    let inside = now.position + normal * 0.08 + along * 0.01;
    let fastest = Vector2::new(-3.0, -1.0);
    let particles = &mut fluid.state.particles;
    (particles.position[0], particles.velocity[0]) = (inside, fastest);
    (particles.position[1], particles.velocity[1]) = (inside, normal * 2.0);
    fluid.keep_out(h);
    let particles = &fluid.state.particles;
    let foot = now.position + normal * 0.1 + along * 0.01;
    let wall = now.velocity_at(foot);
    for i in 0..2 {
        assert!((particles.position[i] - foot).norm() < 1e-12, "{}", particles.position[i]);
    }
    let u = particles.velocity[0];
    assert!(((u - wall).dot(&normal)).abs() < 1e-12, "it goes with the wall along its normal");
    assert!(((u - fastest).dot(&along)).abs() < 1e-12, "and slides along it as it did");
    assert_eq!(particles.velocity[1], normal * 2.0, "what leaves, leaves");
    assert_eq!(particles.position[2..], before[2..], "nothing else has moved");
    let outline =
        crate::geometry::placed(&fluid.setup().boundaries[0].corners, now.position, now.angle);
    assert!(particles.position.iter().all(|x| signed_distance(&outline, *x) > -1e-12));
}

#[test]
fn the_water_before_a_flap_is_that_between_the_walls() {
    let (hinge, depth) = (0.05, 0.2);
    let flap = rectangle("paddle", [0.0, hinge], [-0.3, 0.0], [0.0, 0.4 - hinge]);
    let foot = rectangle("paddle_foot", [0.0, 0.0], [-0.3, 0.0], [0.0, hinge]);
    let mut fluid = tank(vec![flap, foot], Some(0));
    for stroke in [0.03, 0.004, 0.0, -0.004, -0.03_f64] {
        let angle = -(stroke / (depth - hinge)).atan();
        fluid.state.kinematics[0] = BoundaryKinematics::at_rest(Point2::new(0.0, hinge), angle);
        // The first particles of the surface stand behind x = 0 where the flap leans back.
        let spacing = (1.0 - stroke) / 50.0;
        let surface = |i: i32| Point2::new(stroke + spacing * (f64::from(i) + 0.5), depth);
        let line: Vec<_> = (0..50).map(surface).collect();
        let exact = depth - 0.5 * stroke * (depth - hinge);
        let found = fluid.volume_below(&line);
        assert!((found - exact).abs() < 1e-12, "{stroke} m: {found}, not {exact} m2");
    }
}

#[test]
fn the_water_in_a_container_stays_where_it_is() {
    let mut setup = fluid().setup().clone();
    let tank = &mut setup.boundaries[0];
    tank.corners.iter_mut().for_each(|corner| *corner *= 2.0);
    tank.corners.reverse();
    tank.free = false;
    assert!(tank.holds_water());
    let mut fluid = Fluid::new(setup).expect("a case that can be");
    let before = fluid.state.particles.position.clone();
    assert!(before.len() > 20);
    fluid.keep_out(0.002);
    assert_eq!(fluid.state.particles.position, before);
}

/// Few particles at `places` (spacings) before a wall along x = 0: what they make of 100 Pa on all
/// of them at the middle of the wall's first piece, and the most of 1 Pa more or less on each, Pa.
fn beside_a_wall(places: &[[f64; 2]]) -> (f64, f64) {
    let point = |x: f64, y: f64| Point2::new(x * SPACING, y * SPACING);
    let position: Vec<_> = places.iter().map(|[x, y]| point(*x, *y)).collect();
    let mut walls = Walls::default();
    for piece in 0..3 {
        walls.position.push(point(0.0, f64::from(piece) + 0.5));
        walls.normal.push(Vector2::x());
        walls.owner.push(Owner::Boundary(0));
        walls.activity.push(1.0);
    }
    let count = places.len();
    let (velocity, normal) = (vec![Vector2::zeros(); count], vec![Vector2::y(); count]);
    let (lists, flags) = (Neighbours::default(), vec![true; count]);
    let fields = Fields {
        position: &position,
        velocity: &velocity,
        on_surface: &flags,
        normal: &normal,
        fluid: &lists,
        wall_lists: &lists,
        walls: &walls,
        spacing: SPACING,
        discretisation: Discretisation::Quadratic,
    };
    let mut functional = PointPressure::default();
    functional.build(fields, walls.position[0], 0..count as u32, 0..3);
    let level = functional.evaluate(|_| 100.0, |_| 0.0);
    let change = |k: usize| functional.evaluate(|j| f64::from(u8::from(j == k)), |_| 0.0).abs();
    (level, (0..count).map(change).sum())
}

#[test]
fn few_particles_by_a_wall_do_not_make_a_pressure_of_their_own() {
    // Spray, which a fit alone would magnify 109 times; a film; a single particle; water.
    let water = (0..12).map(|k| [0.5 + f64::from(k % 3), f64::from(k / 3) - 0.5]);
    let arrangements = [
        vec![[0.6, 1.3], [1.0, 1.4], [0.3, 1.3], [2.1, 0.8], [1.6, 0.9]],
        vec![[0.8, 0.5], [1.8, 0.5], [2.4, 0.52]],
        vec![[0.7, 0.4]],
        water.collect(),
    ];
    for places in arrangements {
        let (level, magnified) = beside_a_wall(&places);
        assert!((level - 100.0).abs() < 1e-6, "{places:?}: {level}");
        assert!(magnified < 8.01, "{places:?}: {magnified}");
    }
}
