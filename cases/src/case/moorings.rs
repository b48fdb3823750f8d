//! Mooring lines: their checks, and what follows from the static equilibrium.

use super::checks::{Allowed, Checker, FINITE, NOT_NEGATIVE, POSITIVE};
use super::resolve::{centre_of_mass, corners};
use super::source::Source;
use super::{BodyKeys, CaseKeys, LineKind, MooringKeys, Problem};
use crate::analysis::hydrostatics::buoyancy;
use crate::geometry::{contains, distance_to_outline};
use crate::scene::Line;
use nalgebra::{Point2, Rotation2, Vector2};
use seakeep_body::{
    BodyError, Catenary, LineLaw, MooringLine, Spring, UnknownTension, static_tensions,
};
use seakeep_coupler::interface::{BoundaryKinematics, Load};

/// Most that a catenary may be stretched at the start: chains and ropes break before.
const MAX_STRAIN: f64 = 0.05;

/// Range checks.
pub(super) fn check_values(check: &mut Checker<'_>, keys: &CaseKeys) {
    check.names("mooring", keys.mooring.iter().map(|line| line.name.as_str()));
    for (index, line) in keys.mooring.iter().enumerate() {
        let key = |name: &str| format!("mooring[{index}].{name}");
        check.require(body_of(keys, line).is_some(), &key("body"), || {
            format!("there is no body \"{}\"", line.body)
        });
        check.numbers(&key("fairlead_m"), &line.fairlead_m, FINITE);
        let [x, y] = line.anchor_m;
        let within = |size: f64| Allowed::from(0.0, if size > 0.0 { size } else { f64::INFINITY });
        check.number(&key("anchor_m[0]"), x, within(keys.tank.length_m));
        check.number(&key("anchor_m[1]"), y, within(keys.tank.height_m));
        let spring = line.kind == LineKind::Spring;
        // Value, range, whether it is needed, and by which kind alone, if not by both.
        for (name, value, allowed, needed, of_spring) in [
            ("stiffness_n_m2", line.stiffness_n_m2, POSITIVE, true, Some(true)),
            ("damping_n_s_m2", line.damping_n_s_m2, NOT_NEGATIVE, false, Some(true)),
            ("pretension_n_m", line.pretension_n_m, NOT_NEGATIVE, false, Some(true)),
            ("unstretched_length_m", line.unstretched_length_m, POSITIVE, !spring, None),
            ("axial_stiffness_n_m", line.axial_stiffness_n_m, POSITIVE, true, Some(false)),
            ("weight_n_m2", line.weight_n_m2, POSITIVE, true, Some(false)),
        ] {
            let kind = if spring { "spring" } else { "catenary" };
            let belongs = of_spring.is_none_or(|of_spring| of_spring == spring);
            match value {
                Some(value) if belongs => check.number(&key(name), value, allowed),
                Some(_) => check.require(false, &key(name), || format!("a {kind} has none")),
                None => {
                    check.require(!(belongs && needed), &key(name), || format!("a {kind} needs it"))
                }
            }
        }
        let twice = line.pretension_n_m.is_some() && line.unstretched_length_m.is_some();
        check.require(!twice, &key("pretension_n_m"), || {
            "given once: either pretension_n_m or unstretched_length_m".to_owned()
        });
    }
}

/// Checks of how the lines fit the bodies, whose shapes are as they were given.
pub(super) fn check_geometry(check: &mut Checker<'_>, keys: &CaseKeys) {
    for (index, line) in keys.mooring.iter().enumerate() {
        let Some(body) = body_of(keys, line) else { continue };
        let key = |name: &str| format!("mooring[{index}].{name}");
        let outline = corners(body);
        let place = Point2::from(Vector2::from(line.fairlead_m) - centre_of_mass(body));
        let off = distance_to_outline(&outline, place);
        let size = outline.iter().map(|corner| corner.coords.norm()).fold(0.0, f64::max);
        check.require(contains(&outline, place) || off <= 1e-6 * size, &key("fairlead_m"), || {
            format!("{:?} m lies {off:.4} m off {}", line.fairlead_m, body.name)
        });
        let fairlead = Point2::from(body.position_m)
            + Rotation2::new(body.angle_deg.to_radians()) * place.coords;
        let distance = (fairlead - Point2::from(line.anchor_m)).norm();
        if let (LineKind::Catenary, Some(length)) = (line.kind, line.unstretched_length_m) {
            let strain = distance / length - 1.0;
            check.require(strain <= MAX_STRAIN, &key("unstretched_length_m"), || {
                format!(
                    "{length} m is too short: {} is {distance:.4} m from its anchor at the start, \
                     which would stretch it by {:.0} %, at most {:.0} % is allowed",
                    line.name,
                    100.0 * strain,
                    100.0 * MAX_STRAIN
                )
            });
        }
        check.require(distance > 0.0, &key("anchor_m"), || {
            "the anchor lies at the fairlead".to_owned()
        });
    }
}

/// The lines of resolved keys. Writes the unstretched lengths that follow from pretensions, given
/// or found, into the keys.
///
/// # Errors
/// A pretension that needs a line of no length, or a body that its lines cannot hold.
pub(super) fn lines(keys: &mut CaseKeys, source: &Source) -> Result<Vec<Line>, Vec<Problem>> {
    let mut check = Checker::new(source);
    for number in 0..keys.body.len() {
        find_pretensions(&mut check, keys, number);
    }
    let mut lines = Vec::new();
    for index in 0..keys.mooring.len() {
        let pose = body_of(keys, &keys.mooring[index]).map(equilibrium);
        let body = keys.body.iter().position(|body| body.name == keys.mooring[index].body);
        let (Some(pose), Some(body), true) = (pose, body, check.problems.is_empty()) else {
            continue;
        };
        match line(&keys.mooring[index], &pose) {
            Ok(line) => {
                let keys = &mut keys.mooring[index];
                if let LineLaw::Spring(spring) = line.law {
                    keys.unstretched_length_m = Some(spring.unstretched_length);
                    keys.pretension_n_m = None;
                }
                lines.push(Line { name: keys.name.clone(), body, line });
            }
            Err(error) => {
                check.require(false, &format!("mooring[{index}]"), || error.to_string());
            }
        }
    }
    if check.problems.is_empty() { Ok(lines) } else { Err(check.problems) }
}

fn body_of<'a>(keys: &'a CaseKeys, line: &MooringKeys) -> Option<&'a BodyKeys> {
    keys.body.iter().find(|body| body.name == line.body)
}

/// A body upright in its equilibrium.
fn equilibrium(body: &BodyKeys) -> BoundaryKinematics {
    BoundaryKinematics::at_rest(body.equilibrium_m.unwrap_or(body.position_m).into(), 0.0)
}

/// The line, whose pretension is that at the pose of equilibrium `pose`.
fn line(keys: &MooringKeys, pose: &BoundaryKinematics) -> Result<MooringLine, BodyError> {
    let anchor = Point2::from(keys.anchor_m);
    let fairlead = Vector2::from(keys.fairlead_m);
    let number = |value: Option<f64>| value.unwrap_or_default();
    let law = match keys.kind {
        LineKind::Spring => {
            let (stiffness, damping) = (number(keys.stiffness_n_m2), number(keys.damping_n_s_m2));
            LineLaw::Spring(match keys.unstretched_length_m {
                Some(length) => Spring::new(stiffness, length, damping)?,
                None => {
                    let length = (fairlead_at(keys, pose) - anchor).norm();
                    let pretension = number(keys.pretension_n_m);
                    Spring::pretensioned(stiffness, length, pretension, damping)?
                }
            })
        }
        LineKind::Catenary => LineLaw::Catenary(Catenary::new(
            number(keys.axial_stiffness_n_m),
            number(keys.weight_n_m2),
            number(keys.unstretched_length_m),
            anchor.y == 0.0,
        )?),
    };
    Ok(MooringLine { fairlead, anchor, law })
}

fn fairlead_at(keys: &MooringKeys, pose: &BoundaryKinematics) -> Point2<f64> {
    pose.position + Rotation2::new(pose.angle) * Vector2::from(keys.fairlead_m)
}

/// Finds the pretensions of the springs of the body number `number` for which nothing is given:
/// those that hold it in its equilibrium in still water.
fn find_pretensions(check: &mut Checker<'_>, keys: &mut CaseKeys, number: usize) {
    let body = &keys.body[number];
    let pose = equilibrium(body);
    let unknown = |line: &MooringKeys| {
        line.kind == LineKind::Spring
            && line.unstretched_length_m.is_none()
            && line.pretension_n_m.is_none()
    };
    let of_body: Vec<usize> =
        (0..keys.mooring.len()).filter(|index| keys.mooring[*index].body == body.name).collect();
    let (asked, known): (Vec<usize>, Vec<usize>) =
        of_body.into_iter().partition(|index| unknown(&keys.mooring[*index]));
    let Some(first) = asked.first() else { return };
    let at = format!("mooring[{first}].pretension_n_m");
    let Some(mass) = body.mass_kg_m else {
        check.require(false, &at, || {
            format!("{} has no mass, from which it could be found: give it", body.name)
        });
        return;
    };
    let (water, position) = (&keys.water, pose.position);
    let corners: Vec<_> =
        body.corners_m.iter().flatten().map(|[x, y]| position + Vector2::new(*x, *y)).collect();
    let (density, gravity) = (water.density_kg_m3, water.gravity_m_s2);
    let floating = buoyancy(&corners, water.depth_m, density, gravity, position);
    let mut load =
        Load { force: Vector2::new(0.0, floating.force - mass * gravity), torque: floating.moment };
    for index in known {
        // A line that cannot be is reported where the lines are made.
        let Ok(line) = line(&keys.mooring[index], &pose) else { return };
        let pull = line.load_on(&pose);
        load.force += pull.force;
        load.torque += pull.torque;
    }
    let unknowns: Vec<_> = asked
        .iter()
        .map(|index| {
            let fairlead = fairlead_at(&keys.mooring[*index], &pose);
            UnknownTension {
                arm: fairlead - position,
                direction: Point2::from(keys.mooring[*index].anchor_m) - fairlead,
            }
        })
        .collect();
    let free = body.free_directions();
    match static_tensions(&unknowns, &load, free) {
        Some(tensions) => {
            for (index, tension) in asked.iter().zip(tensions) {
                keys.mooring[*index].pretension_n_m = Some(tension);
            }
        }
        None => check.require(false, &at, || {
            format!(
                "no pull of these lines holds {} in its equilibrium at {:?} m, where buoyancy, \
                 weight and other lines give ({:.2}, {:.2}) N/m and {:.2} N m/m: give the pretension",
                body.name,
                [position.x, position.y],
                load.force.x,
                load.force.y,
                load.torque
            )
        }),
    }
}
