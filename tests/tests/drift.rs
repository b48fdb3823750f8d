//! What steep waves carry along at the surface, against Stokes (1847): over depth the second-order drift
//! a² ω k cosh(2 k (z + D)) / (2 sinh² k D) with a return current that makes it nought on the whole.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

use seakeep::simulation::Simulation;
use seakeep::waves::StillWater;
use seakeep_tests::case;
use std::collections::HashMap;
use std::f64::consts::PI;

/// Short and steep, k a = 0.19: 50 particles to a wavelength, three to the height.
const WAVE: &str = r#"
end_time_s = 8.0

[tank]
length_m = 4.0
height_m = 0.6

[water]
depth_m = 0.4

[wave]
kind = "stream_function"
height_m = 0.06
period_s = 0.8

[wavemaker]
type = "piston"

[numerics]
particle_spacing_m = 0.02
time_step_s = 0.004

[[damping_zone]]
inner_x_m = 2.5
outer_x_m = 4.0
rate_per_s = 10.5
"#;

/// x of each particle on the surface that lies in the wave, away from paddle and damping zone.
fn on_surface(run: &Simulation) -> HashMap<u32, f64> {
    let view = run.particles();
    let all = view.identity.iter().zip(view.position).zip(view.on_surface);
    all.filter(|(_, on_surface)| **on_surface).map(|((id, x), _)| (*id, x.x)).collect()
}

#[test]
fn the_surface_drifts_along_with_steep_waves_as_stokes_has_it() {
    let case = case(WAVE, &[]);
    let scene = &case.scene;
    let mut run = Simulation::start(scene).unwrap();
    let (depth, amplitude, omega) = (0.4, 0.03, 2.0 * PI / 0.8);
    let k = StillWater { depth, gravity: 9.81 }.wave_number(omega);
    let kd = k * depth;
    let drift = amplitude * amplitude * omega * k * (2.0 * kd).cosh() / (2.0 * kd.sinh().powi(2));
    let current = amplitude * amplitude * omega / (2.0 * depth * kd.tanh());
    // Two whole periods, so that what goes back and forth is left out.
    let (from, until) = (1600, 2000);
    let mut before = HashMap::new();
    for step in 1..=until {
        run.step().unwrap();
        if step == from {
            before = on_surface(&run);
            before.retain(|_, x| (0.5..2.0).contains(x));
        }
    }
    let after = on_surface(&run);
    let time = 0.004 * f64::from(until - from);
    let moved = before.iter().filter_map(|(id, x)| Some((after.get(id)? - x) / time));
    let found = moved.clone().sum::<f64>() / moved.count() as f64;
    let exact = drift - current;
    assert!((found / exact - 1.0).abs() < 0.25, "drift {found} m/s, theory {exact} m/s");
}
