//! The fluid's step takes no memory from the allocator once it has run for a while.

#![allow(clippy::unwrap_used, reason = "a panic in a test is a report")]

use allocation_counter::measure;
use seakeep_coupler::FixedStepMaster;
use seakeep_coupler::interface::{Component, LoadComponent, MotionComponent};
use seakeep_fluid::Fluid;
use seakeep_tests::{Coupled, FLOATING_BOX, case};

/// Steps until every buffer has its size: with a body, a period of its roll, in which every piece
/// of its outline that gets wet at all has been wet.
const WARM_UP: usize = 600;
/// Longer than any interval at which the fluid renews something (numbering: 64 steps).
const COUNTED: usize = 70;

const STANDING_WAVE: &str = r#"
end_time_s = 1.0

[tank]
length_m = 1.0
height_m = 0.4

[water]
depth_m = 0.3
standing_wave = { amplitude_m = 0.01, half_waves = 2 }

[numerics]
particle_spacing_m = 0.02
"#;

/// Runs on one thread: allocations are counted on it.
fn on_one_thread<T: Send>(run: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(run)
}

#[test]
fn allocations_are_counted() {
    let info = on_one_thread(|| measure(|| drop(std::hint::black_box(vec![0u8; 100]))));
    assert_eq!((info.count_total, info.bytes_total), (1, 100));
}

#[test]
fn a_step_without_bodies_allocates_nothing() {
    let case = case(STANDING_WAVE, &[]);
    let counts = on_one_thread(|| {
        let mut fluid =
            Fluid::flowing(case.scene.fluid.clone(), &case.scene.initial_water).unwrap();
        let h = case.scene.time_step();
        let mut master = FixedStepMaster::start(0.0, h, &mut fluid, None).unwrap();
        let mut counts = Vec::new();
        for _ in 0..WARM_UP + COUNTED {
            let step = measure(|| {
                master.step(&mut fluid, None).unwrap();
            });
            counts.push(step.count_total);
        }
        counts.split_off(WARM_UP)
    });
    assert!(counts.iter().all(|count| *count == 0), "allocations, step by step: {counts:?}");
}

#[test]
fn a_step_with_a_floating_body_allocates_nothing() {
    let case = case(FLOATING_BOX, &[]);
    let counts = on_one_thread(|| {
        let Coupled { mut fluid, mut bodies, master } = Coupled::start(&case);
        let h = master.communication_step();
        let mut counts = Vec::new();
        for step in 0..WARM_UP + COUNTED {
            let now = step as f64 * h;
            let solve = measure(|| {
                fluid.set_kinematics(bodies.kinematics());
                fluid.solve_load(now, h).unwrap();
            });
            // Solved already: only hands out the response.
            bodies.set_load(fluid.solve_load(now, h).unwrap());
            bodies.do_step(now, h).unwrap();
            let complete = measure(|| {
                fluid.set_accelerations(bodies.mean_accelerations());
                fluid.do_step(now, h).unwrap();
            });
            counts.push(solve.count_total + complete.count_total);
        }
        counts.split_off(WARM_UP)
    });
    assert!(counts.iter().all(|count| *count == 0), "allocations, step by step: {counts:?}");
}
