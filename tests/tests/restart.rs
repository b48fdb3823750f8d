//! Save, restore, repeat: the same bits.

use seakeep_tests::{Coupled, FLOATING_BOX, case};

#[test]
fn a_repeated_stretch_has_the_same_bits() {
    let mut run = Coupled::start(&case(FLOATING_BOX, &[]));
    // Not a multiple of any interval at which the fluid renews something.
    run.steps(37);
    let saved = run.save();
    run.steps(90);
    let first = run.states();
    run.restore(&saved);
    assert_eq!(run.master.step_count(), 37);
    run.steps(90);
    assert!(run.states() == first, "a repeated stretch differs");
}

#[test]
fn a_new_process_goes_on_from_a_saved_state() {
    let case = case(FLOATING_BOX, &[]);
    let mut run = Coupled::start(&case);
    run.steps(21);
    let saved = run.save();
    run.steps(40);
    let mut other = Coupled::start(&case);
    other.restore(&saved);
    other.steps(40);
    assert!(run.states() == other.states(), "a restart differs");
}
