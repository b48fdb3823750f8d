//! The string-named view of the rigid bodies: twelve variables a body, such as `box.heave`.

use crate::BodyProperties;
use seakeep_coupler::interface::{
    BoundaryKinematics, Capabilities, Causality, Description, Load, ValueReference, Variability,
    Variable,
};

/// Name after the body's, unit, what it is. The first three are the inputs.
const VARIABLES: [(&str, &str, &str); 12] = [
    ("force_x", "N/m", "load along x at zero acceleration, per metre of width"),
    ("force_y", "N/m", "load along y at zero acceleration, per metre of width"),
    ("torque", "N m/m", "torque about the centre of mass at zero acceleration, per metre of width"),
    ("sway", "m", "displacement of the centre of mass along x from equilibrium"),
    ("heave", "m", "displacement of the centre of mass along y from equilibrium"),
    ("roll", "rad", "angle, counter-clockwise"),
    ("sway_velocity", "m/s", "velocity of the centre of mass along x"),
    ("heave_velocity", "m/s", "velocity of the centre of mass along y"),
    ("roll_rate", "rad/s", "angular velocity"),
    ("sway_acceleration", "m/s2", "mean acceleration along x over the last step"),
    ("heave_acceleration", "m/s2", "mean acceleration along y over the last step"),
    ("roll_acceleration", "rad/s2", "mean angular acceleration over the last step"),
];
const INPUTS: usize = 3;

/// Describes the component `name` with these bodies.
pub(crate) fn describe(name: &str, bodies: &[BodyProperties]) -> Description {
    let variables = bodies.iter().flat_map(|body| {
        VARIABLES.iter().enumerate().map(|(place, (variable, unit, description))| {
            let input = place < INPUTS;
            (
                format!("{}.{variable}", body.name),
                if input { Causality::Input } else { Causality::Output },
                if input { Variability::Discrete } else { Variability::Continuous },
                *unit,
                *description,
            )
        })
    });
    Description {
        name: name.to_owned(),
        capabilities: Capabilities {
            can_get_and_set_state: true,
            provides_directional_derivative: false,
            can_handle_variable_step: true,
            // Poses and velocities answer to a load after a step only.
            has_direct_feedthrough: false,
        },
        variables: (0..)
            .zip(variables)
            .map(|(reference, (name, causality, variability, unit, description))| Variable {
                name,
                reference: ValueReference(reference),
                causality,
                variability,
                unit: unit.to_owned(),
                description: description.to_owned(),
            })
            .collect(),
    }
}

/// Body and place within the body of a value reference that the description holds.
pub(crate) fn locate(reference: ValueReference) -> (usize, usize) {
    let index = reference.0 as usize;
    (index / VARIABLES.len(), index % VARIABLES.len())
}

/// The load's value at an input's `place`, if it is one.
pub(crate) fn input(load: &mut Load, place: usize) -> Option<&mut f64> {
    match place {
        0 => Some(&mut load.force.x),
        1 => Some(&mut load.force.y),
        2 => Some(&mut load.torque),
        _ => None,
    }
}

/// The output at `place`.
pub(crate) fn output(body: &BodyProperties, now: &BoundaryKinematics, place: usize) -> f64 {
    let outputs = [
        now.position.x - body.equilibrium.x,
        now.position.y - body.equilibrium.y,
        now.angle,
        now.velocity.x,
        now.velocity.y,
        now.angular_velocity,
        now.acceleration.x,
        now.acceleration.y,
        now.angular_acceleration,
    ];
    outputs[place - INPUTS]
}
