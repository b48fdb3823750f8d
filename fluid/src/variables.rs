//! The variables of the component, by name.

use seakeep_coupler::interface::{
    Capabilities, Causality, Description, ValueReference, Variability, Variable,
};

/// Name of the component.
pub(crate) const NAME: &str = "fluid";

/// Variables of one boundary: suffix, causality, unit, description. Value references run through
/// the boundaries in this order.
pub(crate) const VARIABLES: [(&str, Causality, &str, &str); 12] = [
    ("position_x", Causality::Input, "m", "position of the reference point along the tank"),
    ("position_y", Causality::Input, "m", "height of the reference point above the bed"),
    ("angle", Causality::Input, "rad", "angle, counter-clockwise"),
    ("velocity_x", Causality::Input, "m/s", "velocity of the reference point along the tank"),
    ("velocity_y", Causality::Input, "m/s", "upward velocity of the reference point"),
    ("angular_velocity", Causality::Input, "rad/s", "angular velocity, counter-clockwise"),
    ("acceleration_x", Causality::Input, "m/s2", "mean acceleration over the coming step"),
    ("acceleration_y", Causality::Input, "m/s2", "mean upward acceleration over the coming step"),
    ("angular_acceleration", Causality::Input, "rad/s2", "mean over the coming step"),
    ("force_x", Causality::Output, "N/m", "hydrodynamic force along the tank, Eq. (19)"),
    ("force_y", Causality::Output, "N/m", "upward hydrodynamic force, Eq. (19)"),
    (
        "torque",
        Causality::Output,
        "N m/m",
        "hydrodynamic torque about the reference point, Eq. (20)",
    ),
];

/// The description of a fluid with boundaries of these names.
pub(crate) fn describe<'a>(boundaries: impl Iterator<Item = &'a str>) -> Description {
    let variables = boundaries
        .flat_map(|boundary| {
            VARIABLES.iter().map(move |(name, causality, unit, description)| Variable {
                name: format!("{boundary}.{name}"),
                reference: ValueReference(0),
                causality: *causality,
                variability: Variability::Continuous,
                unit: (*unit).to_owned(),
                description: (*description).to_owned(),
            })
        })
        .enumerate()
        .map(|(reference, variable)| Variable {
            reference: ValueReference(reference as u32),
            ..variable
        })
        .collect();
    Description {
        name: NAME.to_owned(),
        capabilities: Capabilities {
            can_get_and_set_state: true,
            provides_directional_derivative: true,
            can_handle_variable_step: true,
            has_direct_feedthrough: true,
        },
        variables,
    }
}
