//! A body lighter than its added mass does not run away.

use seakeep_tests::{Coupled, FLOATING_BOX, case};

/// Mass of the water that the box displaces at equilibrium, kg/m.
const DISPLACED: f64 = 1000.0 * 0.16 * 0.06;

#[test]
fn a_floating_body_stays_where_it_floats() {
    let mut run = Coupled::start(&case(FLOATING_BOX, &["body.angle_deg=0"]));
    let added = run_added_mass(&mut run);
    assert!(added > DISPLACED, "heave added mass {added} kg/m, body {DISPLACED} kg/m");
    let mut largest = 0.0f64;
    for _ in 0..250 {
        run.steps(1);
        largest = largest.max(run.heave().abs());
    }
    assert!(largest < 0.1 * 0.02, "heave {largest} m, spacing 0.02 m");
}

#[test]
fn a_body_a_tenth_as_heavy_as_its_added_mass_is_stable() {
    let light = ["body.angle_deg=0", "body.density_kg_m3=100", "body.position_m=[0.5, 0.248]"];
    let mut run = Coupled::start(&case(FLOATING_BOX, &light));
    for _ in 0..250 {
        run.steps(1);
        assert!(run.heave().abs() < 0.02, "heave {} m", run.heave());
    }
}

fn run_added_mass(run: &mut Coupled) -> f64 {
    run.steps(1);
    run.fluid.added_mass()[(1, 1)]
}
