//! Water at rest, briefly: the long run is `cases/still_tank.toml`.

use seakeep::simulation::Simulation;
use seakeep_tests::case;

const STILL: &str = r#"
end_time_s = 1.0

[tank]
length_m = 0.6
height_m = 0.3

[water]
depth_m = 0.2

[numerics]
particle_spacing_m = 0.02

[[probe]]
name = "deep"
x_m = 0.3
y_m = 0.05
"#;

#[test]
fn the_pressure_is_hydrostatic_and_nothing_moves() {
    let case = case(STILL, &[]);
    let scene = &case.scene;
    let mut run = Simulation::start(scene).unwrap();
    for _ in 0..scene.steps {
        run.step().unwrap();
    }
    let sample = run.sample(scene);
    let (rho_g, depth) = (1000.0 * 9.81, scene.depth());
    assert!(sample.max_speed < 0.01 * (9.81 * depth).sqrt(), "{} m/s", sample.max_speed);
    let worst = sample.max_hydrostatic_pressure_error;
    assert!(worst < 0.005 * rho_g * depth, "{worst} Pa");
    assert!(sample.diagnostics.volume_error.abs() < 1e-3);
    let probe = sample.pressures[0].unwrap();
    assert!((probe - rho_g * (depth - 0.05)).abs() < 0.005 * rho_g * depth, "{probe} Pa");
}

#[test]
fn a_held_box_feels_its_displacement() {
    let text = format!(
        "{STILL}\n[[body]]\nbox = {{ width_m = 0.16, height_m = 0.12 }}\n\
         position_m = [0.3, 0.2]\ndensity_kg_m3 = 500\nfree = []\n"
    );
    let case = case(&text, &["probe.x_m=0.1", "end_time_s=0.5", "tank.length_m=1.0"]);
    let scene = &case.scene;
    let mut run = Simulation::start(scene).unwrap();
    let (mut force, mut count) = (0.0, 0.0);
    for step in 0..scene.steps {
        run.step().unwrap();
        if step >= scene.steps / 2 {
            force += run.sample(scene).loads[0].force.y;
            count += 1.0;
        }
    }
    let exact = 1000.0 * 9.81 * 0.16 * 0.06;
    assert!((force / count / exact - 1.0).abs() < 0.02, "{} N/m, exact {exact}", force / count);
}
