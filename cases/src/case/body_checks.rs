//! Range checks of bodies.

use super::checks::{Allowed, Checker, FINITE, NOT_NEGATIVE, POSITIVE};
use super::{BodyKeys, CaseKeys, EngineName};
use std::collections::HashSet;

pub(super) fn check_bodies(check: &mut Checker<'_>, keys: &CaseKeys) {
    for (index, body) in keys.body.iter().enumerate() {
        check_body(check, &format!("body[{index}]"), body);
    }
    check.names("body", keys.body.iter().map(|body| body.name.as_str()));
    check.number("contact.restitution", keys.contact.restitution, Allowed::from(0.0, 1.0));
    check.number("contact.friction", keys.contact.friction, NOT_NEGATIVE);
    let free = |body: &&BodyKeys| body.engine != EngineName::Prescribed;
    let mut engines = keys.body.iter().enumerate().filter(|(_, body)| free(body));
    if let Some((_, first)) = engines.next() {
        for (index, body) in engines {
            check.require(body.engine == first.engine, &format!("body[{index}].engine"), || {
                format!(
                    "bodies that are not prescribed share one engine: {} has another",
                    first.name
                )
            });
        }
    }
}

fn check_body(check: &mut Checker<'_>, prefix: &str, body: &BodyKeys) {
    let key = |name: &str| format!("{prefix}.{name}");
    check.numbers(&key("position_m"), &body.position_m, FINITE);
    if let Some(equilibrium) = &body.equilibrium_m {
        check.numbers(&key("equilibrium_m"), equilibrium, FINITE);
    }
    check.number(&key("angle_deg"), body.angle_deg, Allowed::from(-360.0, 360.0));
    check.require(
        body.rectangle.is_some() != body.corners_m.is_some(),
        &key(if body.corners_m.is_some() { "corners_m" } else { "box" }),
        || "the shape must be given once: either box or corners_m".to_owned(),
    );
    if let Some(rectangle) = &body.rectangle {
        check.number(&key("box.width_m"), rectangle.width_m, POSITIVE);
        check.number(&key("box.height_m"), rectangle.height_m, POSITIVE);
    }
    if let Some(corners) = &body.corners_m {
        check.require(corners.len() >= 3, &key("corners_m"), || {
            format!("{} corners, there must be at least 3", corners.len())
        });
        for (index, corner) in corners.iter().enumerate() {
            check.numbers(&format!("{prefix}.corners_m[{index}]"), corner, FINITE);
        }
    }
    let optional = [
        ("mass_kg_m", body.mass_kg_m),
        ("inertia_kg_m2_m", body.inertia_kg_m2_m),
        ("density_kg_m3", body.density_kg_m3),
    ];
    for (name, value) in optional {
        if let Some(value) = value {
            check.number(&key(name), value, POSITIVE);
        }
    }
    if let Some(centre) = &body.centre_of_mass_m {
        check.numbers(&key("centre_of_mass_m"), centre, FINITE);
        check.require(body.density_kg_m3.is_none(), &key("centre_of_mass_m"), || {
            "a body of uniform density has its centre of mass at its centroid".to_owned()
        });
    }
    let (mass, inertia) = (body.mass_kg_m.is_some(), body.inertia_kg_m2_m.is_some());
    let once = match body.density_kg_m3 {
        Some(_) => !mass && !inertia,
        // A prescribed body moves whatever its mass.
        None => mass && inertia || body.engine == EngineName::Prescribed && !mass && !inertia,
    };
    let at = if body.density_kg_m3.is_some() { "density_kg_m3" } else { "mass_kg_m" };
    check.require(once, &key(at), || {
        "the mass must be given once: either mass_kg_m and inertia_kg_m2_m, or density_kg_m3"
            .to_owned()
    });
    let distinct: HashSet<_> = body.free.iter().map(|d| format!("{d:?}")).collect();
    check.require(distinct.len() == body.free.len(), &key("free"), || {
        "a direction is named twice".to_owned()
    });
    check_motion(check, &key("motion"), body);
}

fn check_motion(check: &mut Checker<'_>, prefix: &str, body: &BodyKeys) {
    let key = |name: &str| format!("{prefix}.{name}");
    let prescribed = body.engine == EngineName::Prescribed;
    check.require(prescribed || !body.holds_water, prefix, || {
        "a container, holds_water = true, moves by engine = \"prescribed\" only".to_owned()
    });
    check.require(prescribed == body.motion.is_some(), prefix, || match prescribed {
        true => "engine = \"prescribed\" needs a motion".to_owned(),
        false => "only a body with engine = \"prescribed\" follows a motion".to_owned(),
    });
    let Some(motion) = &body.motion else { return };
    let swings = [("sway", motion.sway), ("heave", motion.heave)];
    for (name, swing) in swings {
        if let Some(swing) = swing {
            check.number(&key(&format!("{name}.amplitude_m")), swing.amplitude_m, FINITE);
            check.number(&key(&format!("{name}.period_s")), swing.period_s, POSITIVE);
            check.number(&key(&format!("{name}.phase_deg")), swing.phase_deg, FINITE);
        }
    }
    if let Some(roll) = &motion.roll {
        check.number(&key("roll.amplitude_deg"), roll.amplitude_deg, FINITE);
        check.number(&key("roll.period_s"), roll.period_s, POSITIVE);
        check.number(&key("roll.phase_deg"), roll.phase_deg, FINITE);
    }
    check.number(&key("ramp_s"), motion.ramp_s, NOT_NEGATIVE);
    let formula = swings.iter().any(|(_, swing)| swing.is_some()) || motion.roll.is_some();
    check.require(formula != motion.file.is_some(), prefix, || {
        "the motion must be given once: either file, or some of sway, heave and roll".to_owned()
    });
    check.require(motion.file.is_none() || motion.ramp_s == 0.0, &key("ramp_s"), || {
        "a motion from a file has no ramp".to_owned()
    });
}
