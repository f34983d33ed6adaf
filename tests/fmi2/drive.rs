//! The packed drive, which an instance plays by itself.

use crate::fmu::*;
use lemons_trial::{DriveChoice, DriveTable};
use std::fs;

const INPUTS: [&str; 3] = ["Fp.x", "Fp.y", "Mp"];
/// \[s\] Communication points that are not those of the rows, and lie before, within and after the push.
const POINTS: [f64; 8] = [0.0, 0.013, 0.02, 0.15, 0.2, 0.31, 0.59, 0.7];

/// Ready to step on a Trial's resources, from a time \[s\] on; with mechanical steps of 10 µs.
fn ready(resources: &Resources, start: f64, prepare: impl Fn(&Instance)) -> Instance<'static> {
    let instance = instantiate(Fmu::get(), &Model::paper().guid, &resources.uri())
        .unwrap_or_else(|log| panic!("{log:?}"));
    instance.must(instance.set("TimeStepMechanical", 1e-5));
    prepare(&instance);
    unsafe {
        instance.must((instance.fmu.c.fmi2SetupExperiment)(instance.raw, 0, 0.0, start, 0, 0.0));
        instance.must((instance.fmu.c.fmi2EnterInitializationMode)(instance.raw));
        instance.must((instance.fmu.c.fmi2ExitInitializationMode)(instance.raw));
    }
    instance
}

fn table(resources: &Resources) -> DriveTable {
    let (trial, _) = crowd_mechanics::setup::read(&resources.trial()).unwrap();
    DriveTable::of(Some(&trial), &DriveChoice::Own).unwrap()
}

/// Sets what drives an agent whose Id is its place, as an importer that has read the file.
fn send(instance: &Instance, drive: &DriveTable, agent: usize, time: f64) {
    let push = drive.at(&agent.to_string(), time).unwrap();
    let names = INPUTS.map(|input| format!("agent[{agent}].{input}"));
    let values: Vec<(&str, f64)> = names.iter().map(String::as_str).zip(push).collect();
    instance.must(instance.set_all(&values));
}

/// The push on agent 0, and another one on agent 3 in all directions, which begins in the middle of its rows.
fn two_pushes() -> Resources {
    let resources = Resources::new();
    let file = resources.trial().join("drive.csv");
    let text = fs::read_to_string(&file).unwrap() + "-0.1,3,10,-20,0.5\n0.3,3,-90,400,-7\n0.41,3,60,0,3\n";
    fs::write(file, text).unwrap();
    resources
}

/// The outside: an importer that reads the file and sets the inputs, of an FMU that plays nothing.
#[test]
fn it_is_what_an_importer_sends_who_has_read_the_file() {
    let resources = two_pushes();
    let drive = table(&resources);
    for start in [0.0, 0.1] {
        let plays = ready(&resources, start, |_| ());
        let sent =
            ready(&resources, start, |instance| instance.must(instance.set_boolean("PlayDrive", false)));
        assert_eq!(sent.get("agent[3].Fp.y"), 0.0);
        for (k, step) in POINTS.windows(2).enumerate() {
            let (from, to) = (start + step[0], start + step[1]);
            for agent in [0, 3] {
                send(&sent, &drive, agent, from);
            }
            // Before each step the inputs say what drives.
            assert_eq!(plays.everything(), sent.everything(), "step {k} from {start}");
            for instance in [&plays, &sent] {
                instance.must(instance.try_step(from, to - from));
            }
        }
        assert!(plays.get("agent[0].Position.x") > 0.2, "it was pushed");
        assert!(plays.get("agent[3].Position.y").abs() > 0.03, "so was this one");
    }
}

/// The time of a step is the importer's, which its own sum of steps may miss by rounding.
#[test]
fn the_drive_is_that_of_the_importers_time() {
    let resources = Resources::new();
    let drive = table(&resources);
    let plays = ready(&resources, 0.0, |_| ());
    let sent = ready(&resources, 0.0, |instance| instance.must(instance.set_boolean("PlayDrive", false)));
    let mut missed = 0;
    let mut sum = 0.0;
    for k in 0..40 {
        let from = f64::from(k) * 0.01;
        missed += u32::from(from != sum);
        send(&sent, &drive, 0, from);
        for instance in [&plays, &sent] {
            instance.must(instance.try_step(from, 0.01));
        }
        sum = from + 0.01;
    }
    assert!(missed > 0);
    assert_eq!(plays.get("agent[0].Position.x").to_bits(), sent.get("agent[0].Position.x").to_bits());
}

#[test]
fn an_agent_whose_input_is_set_is_no_longer_driven_by_it() {
    let resources = two_pushes();
    let drive = table(&resources);
    /// Before initialization, and at the first communication point.
    type Way = (fn(&Instance), fn(&Instance));
    // Another value than the Trial's; any value; a rate alone.
    let ways: [Way; 4] = [
        (|instance| instance.must(instance.set("agent[0].Fp.x", 30.0)), |_| ()),
        (|_| (), |instance| instance.must(instance.set("agent[0].Fp.x", 0.0))),
        (|_| (), |instance| instance.must(instance.set("agent[0].Mp", 1.0))),
        (
            |_| (),
            |instance| {
                let reference = instance.model.reference("agent[0].Fp.y");
                let set = instance.fmu.c.fmi2SetRealInputDerivatives;
                instance.must(unsafe { set(instance.raw, &reference, 1, &1, &2.0) });
            },
        ),
    ];
    for (way, (before, after)) in ways.into_iter().enumerate() {
        let plays = ready(&resources, 0.1, before);
        let sent = ready(&resources, 0.1, |instance| {
            before(instance);
            instance.must(instance.set_boolean("PlayDrive", false));
        });
        assert_eq!(plays.get("agent[0].Fp.x") > 100.0, way > 0);
        for instance in [&plays, &sent] {
            after(instance);
        }
        let mut from = 0.1;
        for k in 0..20 {
            send(&sent, &drive, 3, from);
            assert_eq!(plays.everything(), sent.everything(), "way {way}, step {k}");
            for instance in [&plays, &sent] {
                instance.must(instance.try_step(from, STEP));
            }
            from += STEP;
        }
        assert!(plays.get("agent[0].Position.x") < 0.02, "way {way}");
    }
}

/// Some importers set all start values of the model description.
#[test]
fn start_values_that_are_set_again_change_nothing() {
    let resources = Resources::new();
    let plays = ready(&resources, 0.0, |_| ());
    let again = ready(&resources, 0.0, |instance| {
        instance.must(instance.set_all(&[
            ("agent[0].Fp.x", 0.0),
            ("agent[0].Fp.y", 0.0),
            ("agent[0].Mp", 0.0),
        ]));
        instance.must(instance.set_boolean("PlayDrive", true));
    });
    for instance in [&plays, &again] {
        instance.steps(0, 30);
    }
    assert_eq!(plays.everything(), again.everything());
    assert!(plays.get("agent[0].Position.x") > 0.1);
}

#[test]
fn a_state_knows_whom_it_drives_and_when() {
    let resources = two_pushes();
    let instance = ready(&resources, 0.0, |_| ());
    instance.steps(0, 10);
    instance.must(instance.set("agent[3].Fp.x", 5.0));
    let state = instance.bytes();
    instance.steps(10, 40);
    let expected = instance.everything();
    // In others: fresh, of which nobody is played, further.
    let others: [fn(&Instance); 3] = [
        |_| (),
        |other| other.must(other.set_boolean("PlayDrive", false)),
        |other| {
            other.initialize();
            other.steps(0, 1);
        },
    ];
    for prepare in others {
        let other = instantiate(Fmu::get(), &Model::paper().guid, &resources.uri())
            .unwrap_or_else(|log| panic!("{log:?}"));
        prepare(&other);
        other.must(other.restore_bytes(&state));
        assert!(other.bytes() == state);
        other.steps(10, 40);
        assert_eq!(other.everything(), expected);
        // A reset plays the whole drive again.
        other.must(unsafe { (other.fmu.c.fmi2Reset)(other.raw) });
        other.must(other.set("TimeStepMechanical", 1e-5));
        other.initialize();
        other.steps(0, 10);
        assert_eq!(other.get("agent[3].Fp.x"), table(&resources).at("3", 10.0 * STEP).unwrap()[0]);
    }
    // The push of another Trial would be another future.
    let other = instantiate(Fmu::get(), &Model::paper().guid, &Resources::new().uri());
    let other = other.unwrap_or_else(|log| panic!("{log:?}"));
    let said = other.refused(other.restore_bytes(&state));
    assert!(said.contains("\"Trial_push\" has changed"), "{said}");
}

#[test]
fn each_trial_has_its_own() {
    let resources = two_pushes();
    let still = resources.directory().join("Trial_still");
    copy_tree(&paper(), &still);
    fs::remove_file(still.join("drive.csv")).unwrap();
    copy_tree(&paper(), &resources.directory().join("Trial_wrong"));
    let wrong = resources.directory().join("Trial_wrong/drive.csv");
    fs::write(wrong, "t,agent,Fp.x,Fp.y,Mp\n0,0,x,0,0\n").unwrap();

    let choose =
        |name: &'static str| move |instance: &Instance| instance.must(instance.set_string("Trial", name));
    let instance = ready(&resources, 0.0, choose("Trial_still"));
    instance.steps(0, 30);
    assert_eq!(instance.get("agent[0].Velocity.x"), 0.0);
    let instance = ready(&resources, 0.0, choose("Trial_push"));
    instance.steps(0, 30);
    assert!(instance.get("agent[0].Position.x") > 0.1 && instance.get("agent[3].Position.y") != 0.0);

    // A wrong one is an error only if it is played.
    let instance = instantiate(Fmu::get(), &Model::paper().guid, &resources.uri())
        .unwrap_or_else(|log| panic!("{log:?}"));
    choose("Trial_wrong")(&instance);
    instance.enter_initialization();
    let said = instance.refused(unsafe { (instance.fmu.c.fmi2ExitInitializationMode)(instance.raw) });
    assert!(said.contains("drive.csv:2: Fp.x=\"x\": not a finite number"), "{said}");
    instance.must(instance.set_boolean("PlayDrive", false));
    instance.must(unsafe { (instance.fmu.c.fmi2ExitInitializationMode)(instance.raw) });
    instance.steps(0, 2);
}
