//! The packed drive, which an instance plays by itself.

use crate::fmu::*;
use lemons_trial::{DriveChoice, DriveTable};

fn drive() -> DriveTable {
    let (trial, _) = crowd_mechanics::setup::read(&lemons_testing::trial_push()).unwrap();
    DriveTable::of(Some(&trial), &DriveChoice::Own).unwrap()
}

/// Ready to step; it plays the drive or not, with intermediate updates or not.
fn ready(play: bool, updates: i32) -> Instance<'static> {
    let instance =
        if updates > 0 { Instance::of(Fmu::get(), Some(ignore), false).unwrap() } else { Instance::new() };
    instance.must(unsafe { (instance.c.fmi3SetBoolean)(instance.raw, &reference("PlayDrive"), 1, &play, 1) });
    instance.must(instance.try_set_integer("IntermediateSteps", updates));
    instance.set("TimeStepMechanical", &[1e-5]);
    instance.initialize();
    instance
}

unsafe extern "C" fn ignore(
    _: *mut std::ffi::c_void,
    _: f64,
    _: bool,
    _: bool,
    _: bool,
    _: bool,
    _: *mut bool,
    _: *mut f64,
) {
}

fn forces(x: f64) -> [f64; 2 * AGENTS] {
    let mut forces = [0.0; 2 * AGENTS];
    forces[0] = x;
    forces
}

/// The outside: an importer that reads the file and sets the inputs.
#[test]
fn it_is_what_an_importer_sends_who_has_read_the_file() {
    let drive = drive();
    let (plays, updated, sent) = (ready(true, 0), ready(true, 700), ready(false, 0));
    for k in 0..14 {
        sent.set("Fp", &forces(drive.at("0", f64::from(k) * STEP).unwrap()[0]));
        for instance in [&plays, &updated] {
            assert_eq!(instance.get("Fp", 2 * AGENTS), sent.get("Fp", 2 * AGENTS), "step {k}");
        }
        for instance in [&plays, &updated, &sent] {
            instance.steps(k, k + 1);
        }
        assert_eq!(plays.motion(), sent.motion(), "step {k}");
        // Parts of a step make other mechanical steps, but the same drive.
        let (x, y) = (updated.get("Position", 2 * AGENTS)[0], sent.get("Position", 2 * AGENTS)[0]);
        assert!((x - y).abs() < 1e-9, "step {k}: {x} {y}");
    }
    assert!(plays.get("Position", 2 * AGENTS)[0] > 0.2);
}

/// An array is set for all agents at once.
#[test]
fn arrays_that_are_set_replace_it() {
    let (plays, sent) = (ready(true, 0), ready(false, 0));
    plays.steps(0, 3);
    sent.must(sent.restore(&plays.bytes()));
    plays.set("Mp", &[0.0; AGENTS]);
    sent.set("Fp", &forces(0.0));
    for instance in [&plays, &sent] {
        instance.steps(3, 9);
        assert_eq!(instance.get("Fp", 2 * AGENTS), forces(0.0));
    }
    assert_eq!(plays.motion(), sent.motion());
    // Equal start values do not replace it; another value does, of the same agent.
    for (value, pushed) in [(0.0, true), (0.5, false)] {
        let instance = Instance::new();
        let mut torques = [0.0; AGENTS];
        torques[0] = value;
        instance.set("Mp", &torques);
        instance.initialize();
        instance.steps(0, 9);
        assert_eq!(instance.get("Position", 2 * AGENTS)[0] > 0.1, pushed);
    }
}
