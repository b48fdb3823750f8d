//! Bad input: one clear line a problem, naming the key; exit code 2; nothing written.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

mod common;

use common::{SMALL, directory, entries, run, stderr};

/// Runs a case `text` with `arguments`, and expects one line of error for each of `expected`,
/// with all the parts listed in it.
fn refused(text: &str, arguments: &[&str], expected: &[&[&str]]) {
    let directory = directory();
    std::fs::write(directory.path().join("bad.toml"), text).unwrap();
    for command in ["run", "check"] {
        let output = run(directory.path(), &[&[command, "bad.toml"], arguments].concat());
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{message}");
        assert!(output.stdout.is_empty());
        assert_eq!(message.lines().count(), expected.len(), "{message}");
        for parts in expected {
            let found = message.lines().any(|line| parts.iter().all(|part| line.contains(part)));
            assert!(found, "{parts:?} not in one line of:\n{message}");
        }
        assert_eq!(entries(directory.path()), ["bad.toml", "small.toml"]);
    }
}

/// Line of the small case that holds `part`.
fn line_of(part: &str) -> usize {
    1 + SMALL.lines().position(|line| line.contains(part)).unwrap()
}

#[test]
fn a_missing_file() {
    let directory = directory();
    let output = run(directory.path(), &["run", "absent.toml"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(stderr(&output).lines().count(), 1);
    assert!(stderr(&output).contains("absent.toml: no such file"));
    assert_eq!(entries(directory.path()), ["small.toml"]);
}

#[test]
fn an_unknown_key() {
    let text = SMALL.replace("depth_m", "dept_m");
    let place = format!("bad.toml:{}", line_of("depth_m"));
    refused(&text, &[], &[&[&place, "unknown field `dept_m`"]]);
    refused(SMALL, &["--set", "numerics.order=3"], &[&["--set numerics.order=3", "`order`"]]);
}

#[test]
fn a_missing_key_a_wrong_type_and_no_toml() {
    refused(&SMALL.replace("depth_m = 0.2", ""), &[], &[&["water", "missing field `depth_m`"]]);
    refused(
        &SMALL.replace("depth_m = 0.2", "depth_m = \"deep\""),
        &[],
        &[&["water.depth_m", "invalid type: string \"deep\", expected a number"]],
    );
    refused(&SMALL.replace("[water]", "[water"), &[], &[&["bad.toml:"]]);
    refused(SMALL, &["--set", "water.depth_m"], &[&["--set water.depth_m", "key=value"]]);
}

#[test]
fn every_number_out_of_range_is_reported_at_once() {
    let text = SMALL
        .replace("particle_spacing_m = 0.02", "particle_spacing_m = -0.02")
        .replace("depth_m = 0.2", "depth_m = nan")
        .replace("density_kg_m3 = 500.0", "density_kg_m3 = 0");
    refused(
        &text,
        &["--set", "end_time_s=inf"],
        &[
            &["numerics.particle_spacing_m", "-0.02 must be above 0", "bad.toml:"],
            &["water.depth_m", "NaN must be above 0 and at most 10000"],
            &["body[0].density_kg_m3", "0 must be above 0"],
            &["--set end_time_s=inf", "inf must be above 0"],
        ],
    );
}

#[test]
fn a_coupling_that_cannot_be() {
    refused(
        SMALL,
        &["--set", "coupling.scheme='chaotic'"],
        &[&["--set coupling.scheme", "unknown variant `chaotic`", "interface_jacobian"]],
    );
    refused(
        SMALL,
        &["--set", "coupling.fluid_substeps=0", "--set", "coupling.relaxation=0.5"],
        &[
            &["coupling.fluid_substeps", "0 must be at least 1 and at most 1000"],
            &["coupling.relaxation", "only the scheme \"implicit\" has it"],
        ],
    );
    let implicit = |key| ["--set", "coupling.scheme='implicit'", "--set", key];
    for (key, words) in [
        ("coupling.relaxation=1.5", "1.5 must be above 0 and at most 1"),
        ("coupling.tolerance=0", "0 must be at least 0.000000000001 and at most 0.1"),
        ("coupling.max_iterations=0", "0 must be at least 1"),
        ("coupling.extrapolation='cubic'", "unknown variant `cubic`"),
    ] {
        refused(SMALL, &implicit(key), &[&[key.split('=').next().unwrap(), words]]);
    }
    let mut aitken = implicit("coupling.acceleration='aitken'").to_vec();
    aitken.extend(["--set", "coupling.reused_steps=2"]);
    refused(SMALL, &aitken, &[&["coupling.reused_steps", "only the acceleration \"iqn_ils\""]]);
}

#[test]
fn a_spacing_that_gives_no_particle() {
    let place = format!("bad.toml:{}", line_of("particle_spacing_m"));
    let text = SMALL.replace("particle_spacing_m = 0.02", "particle_spacing_m = 0.5");
    refused(&text, &[], &[&[&place, "numerics.particle_spacing_m", "0.5 must be", "0.05"]]);
}

#[test]
fn a_body_where_it_cannot_be() {
    let place = format!("bad.toml:{}: body[0].position_m", line_of("position_m"));
    let at = |position: &str| SMALL.replace("[0.4, 0.2]", position);
    refused(&at("[0.4, 0.28]"), &[], &[&[&place, "outside the water"]]);
    refused(&at("[0.05, 0.2]"), &[], &[&[&place, "overlaps a wall"]]);
    refused(&at("[0.75, 0.2]"), &[], &[&[&place, "overlaps a wall"]]);
    refused(&at("[0.4, 0.05]"), &[], &[&[&place, "overlaps the bed"]]);
    refused(&at("[0.4, nan]"), &[], &[&["body[0].position_m[1]", "NaN must be a finite number"]]);
}

#[test]
fn bodies_that_overlap_or_share_a_name() {
    let second = "\n[[body]]\nbox = { width_m = 0.1, height_m = 0.1 }\n\
                  position_m = [0.45, 0.2]\ndensity_kg_m3 = 500\n";
    refused(&format!("{SMALL}{second}"), &[], &[&["body[1].position_m", "overlaps pontoon"]]);
    let text = format!("{SMALL}{second}name = \"pontoon\"\n");
    refused(&text, &[], &[&["body[1].name", "\"pontoon\" is the name of another body"]]);
}

#[test]
fn a_shape_or_a_mass_given_twice_or_not_at_all() {
    let shape = "box = { width_m = 0.16, height_m = 0.12 }";
    let twice = format!("{shape}\ncorners_m = [[0, 0], [1, 0], [0, 1]]");
    refused(&SMALL.replace(shape, &twice), &[], &[&["body[0].corners_m", "given once"]]);
    refused(&SMALL.replace(shape, ""), &[], &[&["body[0].box", "given once"]]);
    let text = SMALL.replace("density_kg_m3 = 500.0", "");
    refused(&text, &[], &[&["body[0].mass_kg_m", "given once"]]);
    let crossed = "corners_m = [[-0.05, -0.05], [0.05, 0.05], [0.05, -0.05], [-0.05, 0.05]]";
    refused(&SMALL.replace(shape, crossed), &[], &[&["body[0].corners_m", "must not meet itself"]]);
    let centre = ["--set", "body.centre_of_mass_m=[0, -0.01]"];
    refused(SMALL, &centre, &[&["body[0].centre_of_mass_m", "at its centroid"]]);
}

#[test]
fn a_mass_of_zero_and_engines_that_do_not_fit() {
    let text = SMALL.replace("density_kg_m3 = 500.0", "mass_kg_m = 0\ninertia_kg_m2_m = 0.1");
    refused(&text, &[], &[&["body[0].mass_kg_m", "0 must be above 0"]]);
    refused(
        SMALL,
        &["--set", "body.engine=\"chrono\""],
        &[&["body[0].engine", "unknown variant `chrono`"]],
    );
    let second = "\n[[body]]\nname = \"other\"\nengine = \"newton_euler\"\n\
                  box = { width_m = 0.05, height_m = 0.1 }\n\
                  position_m = [0.7, 0.2]\ndensity_kg_m3 = 500\n";
    refused(&format!("{SMALL}{second}"), &[], &[&["body[1].engine", "share one engine"]]);
    refused(SMALL, &["--set", "contact.restitution=2"], &[&["contact.restitution", "2 must be"]]);
}

#[test]
fn gauges_and_probes_outside_the_tank_and_inside_a_body() {
    refused(SMALL, &["--set", "gauge.x_m=0.9"], &[&["gauge[0].x_m", "at most 0.8"]]);
    refused(SMALL, &["--set", "probe.y_m=-0.1"], &[&["probe[0].y_m", "at least 0"]]);
    let inside = ["--set", "probe.x_m=0.4", "--set", "probe.y_m=0.2"];
    refused(SMALL, &inside, &[&["probe[0].x_m", "inside pontoon"]]);
    let on = ["--set", "probe.body=\"pontoon\"", "--set", "probe.x_m=0"];
    let point = |y| [&on[..], &["--set", y]].concat();
    refused(SMALL, &point("probe.y_m=0.05"), &[&["probe[0].x_m", "inside pontoon"]]);
    let body = ["--set", "probe.body=\"hull\""];
    refused(SMALL, &body, &[&["probe[0].body", "there is no body \"hull\""]]);
}

#[test]
fn a_tank_that_is_lower_than_the_water() {
    refused(SMALL, &["--set", "tank.height_m=0.1"], &[&["tank.height_m", "must be above 0.2"]]);
}

#[test]
fn weights_that_are_none() {
    let weights = |path: &str| format!("pressure.weights=\"{path}\"");
    let (absent, damaged) = (weights("absent.safetensors"), weights("bad.toml"));
    refused(SMALL, &["--set", &absent], &[&["absent.safetensors", "cannot be read"]]);
    refused(SMALL, &["--set", &damaged], &[&["bad.toml", "weights cannot be read"]]);
    refused(SMALL, &["--set", "pressure.solver=\"oracle\""], &[&["oracle", "guarded"]]);
}

#[test]
fn a_device_where_none_can_be() {
    let set = |key: &'static str| ["--set", key];
    let device = set("pressure.device=\"cpu\"");
    let mut without_network = vec![&["pressure.device", "evaluates a network"][..]];
    if cfg!(not(feature = "torch")) {
        let network = [&device[..], &set("pressure.solver=\"network\"")].concat();
        let built = &["pressure.device", "built without the feature torch"][..];
        refused(SMALL, &network, &[built]);
        without_network.push(built);
    }
    refused(SMALL, &device, &without_network);
    refused(SMALL, &set("pressure.device=\"abacus\""), &[&["pressure.device", "abacus"]]);
}
