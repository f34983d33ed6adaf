//! The packed drive, which an instance plays by itself.

use crate::fmu::*;
use lemons_core::trial::{DriveChoice, DriveTable};
use std::fs;

const INPUTS: [&str; 3] = ["Fp.x", "Fp.y", "Mp"];
/// \[s\] Communication points that are not those of the rows, and lie before, within and after the push.
const POINTS: [f64; 8] = [0.0, 0.013, 0.02, 0.15, 0.2, 0.31, 0.59, 0.7];

/// Ready to step on a Trial's resources, from a time \[s\] on; with mechanical steps of 10 µs.
fn ready(version: Version, resources: &Resources, start: f64, prepare: impl Fn(&Crowd)) -> Crowd {
    let crowd = Crowd::on(version, resources);
    crowd.must(crowd.set("TimeStepMechanical", 1e-5));
    prepare(&crowd);
    crowd.must(crowd.enter(None, start, None));
    crowd.must(crowd.exit());
    crowd
}

fn table(resources: &Resources) -> DriveTable {
    let (trial, _) = crowd_mechanics::setup::read(&resources.trial()).unwrap();
    DriveTable::of(Some(&trial), &DriveChoice::Own).unwrap()
}

fn silent(crowd: &Crowd) {
    crowd.set_flag("PlayDrive", false);
}

/// Sets what drives an agent whose Id is its place, as an importer that has read the file.
fn send(crowd: &Crowd, drive: &DriveTable, agent: usize, time: f64) {
    let push = drive.at(&agent.to_string(), time).unwrap();
    let names = INPUTS.map(|input| format!("agent[{agent}].{input}"));
    let values: Vec<(&str, f64)> = names.iter().map(String::as_str).zip(push).collect();
    crowd.must(crowd.set_all(&values));
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
    for version in BOTH {
        for start in [0.0, 0.1] {
            let plays = ready(version, &resources, start, |_| ());
            let sent = ready(version, &resources, start, silent);
            assert_eq!(sent.get("agent[3].Fp.y"), 0.0);
            for (k, step) in POINTS.windows(2).enumerate() {
                let (from, to) = (start + step[0], start + step[1]);
                send(&sent, &drive, 0, from);
                send(&sent, &drive, 3, from);
                // Before each step the inputs say what drives.
                assert_eq!(plays.everything(), sent.everything(), "step {k} from {start}");
                for crowd in [&plays, &sent] {
                    crowd.must(crowd.try_step(from, to - from));
                }
            }
            assert!(plays.get("agent[0].Position.x") > 0.2, "it was pushed");
            assert!(plays.get("agent[3].Position.y").abs() > 0.03, "so was this one");
        }
    }
}

/// The time of a step is the importer's, which its own sum of steps may miss by rounding.
#[test]
fn the_drive_is_that_of_the_importers_time() {
    let resources = Resources::new();
    let drive = table(&resources);
    let (plays, sent) = (ready(V2, &resources, 0.0, |_| ()), ready(V2, &resources, 0.0, silent));
    let (mut missed, mut sum) = (0, 0.0);
    for k in 0..40 {
        let from = f64::from(k) * 0.01;
        missed += u32::from(from != sum);
        send(&sent, &drive, 0, from);
        for crowd in [&plays, &sent] {
            crowd.must(crowd.try_step(from, 0.01));
        }
        sum = from + 0.01;
    }
    assert!(missed > 0);
    assert_eq!(plays.get("agent[0].Position.x").to_bits(), sent.get("agent[0].Position.x").to_bits());
}

#[test]
fn an_agent_whose_input_is_set_is_no_longer_driven_by_it() {
    /// Before initialization, and at the first communication point.
    type Way = (fn(&Crowd), fn(&Crowd));
    // Another value than the Trial's; any value; a rate alone.
    const WAYS: [Way; 4] = [
        (|crowd| crowd.must(crowd.set("agent[0].Fp.x", 30.0)), |_| ()),
        (|_| (), |crowd| crowd.must(crowd.set("agent[0].Fp.x", 0.0))),
        (|_| (), |crowd| crowd.must(crowd.set("agent[0].Mp", 1.0))),
        (
            |_| (),
            |crowd| {
                let reference = crowd.model.reference("agent[0].Fp.y");
                crowd.must(crowd.set_input_derivatives(&[reference], &[1], &[2.0]));
            },
        ),
    ];
    let resources = two_pushes();
    let drive = table(&resources);
    for (way, (before, after)) in WAYS.into_iter().enumerate() {
        let plays = ready(V2, &resources, 0.1, before);
        let sent = ready(V2, &resources, 0.1, |crowd| {
            before(crowd);
            silent(crowd);
        });
        assert_eq!(plays.get("agent[0].Fp.x") > 100.0, way > 0);
        after(&plays);
        after(&sent);
        let mut from = 0.1;
        for k in 0..20 {
            send(&sent, &drive, 3, from);
            assert_eq!(plays.everything(), sent.everything(), "way {way}, step {k}");
            for crowd in [&plays, &sent] {
                crowd.must(crowd.try_step(from, STEP));
            }
            from += STEP;
        }
        assert!(plays.get("agent[0].Position.x") < 0.02, "way {way}");
    }
}

/// Some importers set all start values of the model description. In FMI 3.0 an array is set for all agents at once.
#[test]
fn start_values_that_are_set_again_change_nothing() {
    for version in BOTH {
        let resources = Resources::new();
        let plays = ready(version, &resources, 0.0, |_| ());
        let again = ready(version, &resources, 0.0, |crowd| {
            crowd.must(crowd.set_all(&INPUTS.map(|name| (&*format!("agent[0].{name}").leak(), 0.0))));
            crowd.set_flag("PlayDrive", true);
        });
        let other = ready(version, &resources, 0.0, |crowd| crowd.must(crowd.set("agent[0].Mp", 0.5)));
        for crowd in [&plays, &again, &other] {
            crowd.steps(0, 30);
        }
        assert_eq!(plays.everything(), again.everything());
        assert!(plays.get("agent[0].Position.x") > 0.1 && other.get("agent[0].Position.x") < 0.1);
    }
    // At a communication point an array that is set replaces it, whatever its values.
    let resources = Resources::new();
    let crowd = ready(V3, &resources, 0.0, |_| ());
    crowd.steps(0, 15);
    assert!(crowd.get("agent[0].Fp.x") > 0.0);
    crowd.must(crowd.set_values("Mp", &[0.0; AGENTS]));
    crowd.steps(15, 16);
    assert_eq!(crowd.values("Fp"), [0.0; 2 * AGENTS]);
}

/// A step that is refused after the drive was looked up leaves the drive as it was.
#[test]
fn a_refused_step_plays_nothing() {
    let resources = Resources::new();
    let rows = "t,agent,Fp.x,Fp.y,Mp\n0,0,50,0,0\n1,0,50,0,0\n";
    fs::write(resources.trial().join("drive.csv"), rows).unwrap();
    let crowd = ready(V2, &resources, 0.0, |crowd| crowd.must(crowd.set("MostMechanicalSteps", 1e300)));
    assert_eq!(crowd.get("agent[0].Fp.x"), 50.0);
    let before = (crowd.bytes(), crowd.everything());
    // Just before the first row nothing is played.
    let message = crowd.refused(crowd.try_step(-f64::MIN_POSITIVE, 1e300));
    assert!(message.contains("too many steps"), "{message}");
    assert!((crowd.bytes(), crowd.everything()) == before);
}

#[test]
fn a_state_knows_whom_it_drives_and_when() {
    let resources = two_pushes();
    for version in BOTH {
        let crowd = ready(version, &resources, 0.0, |_| ());
        crowd.steps(0, 10);
        if version == V2 {
            crowd.must(crowd.set("agent[3].Fp.x", 5.0));
        }
        let state = crowd.bytes();
        crowd.steps(10, 40);
        let expected = crowd.everything();
        // In others: fresh, of which nobody is played, further.
        let others: [fn(&Crowd); 3] = [
            |_| (),
            silent,
            |other| {
                other.initialize();
                other.steps(0, 1);
            },
        ];
        for prepare in others {
            let other = Crowd::on(version, &resources);
            prepare(&other);
            other.must(other.restore(&state));
            assert!(other.bytes() == state);
            other.steps(10, 40);
            assert_eq!(other.everything(), expected);
            // A reset plays the whole drive again.
            other.reset();
            other.must(other.set("TimeStepMechanical", 1e-5));
            other.initialize();
            other.steps(0, 10);
            assert_eq!(other.get("agent[3].Fp.x"), table(&resources).at("3", 10.0 * STEP).unwrap()[0]);
        }
        // The push of another Trial would be another future.
        let other = Crowd::on(version, &Resources::new());
        let message = other.refused(other.restore(&state));
        assert!(message.contains("\"Trial_push\" has changed"), "{message}");
    }
}

#[test]
fn each_trial_has_its_own() {
    let resources = two_pushes();
    for name in ["Trial_still", "Trial_wrong"] {
        copy_tree(&paper(), &resources.directory().join(name));
    }
    fs::remove_file(resources.directory().join("Trial_still/drive.csv")).unwrap();
    let wrong = resources.directory().join("Trial_wrong/drive.csv");
    fs::write(wrong, "t,agent,Fp.x,Fp.y,Mp\n0,0,x,0,0\n").unwrap();
    let choose = |name: &'static str| move |crowd: &Crowd| crowd.must(crowd.set_text("Trial", name));

    let crowd = ready(V2, &resources, 0.0, choose("Trial_still"));
    crowd.steps(0, 30);
    assert_eq!(crowd.get("agent[0].Velocity.x"), 0.0);
    let crowd = ready(V2, &resources, 0.0, choose("Trial_push"));
    crowd.steps(0, 30);
    assert!(crowd.get("agent[0].Position.x") > 0.1 && crowd.get("agent[3].Position.y") != 0.0);

    // A wrong one is an error only if it is played.
    let crowd = Crowd::on(V2, &resources);
    choose("Trial_wrong")(&crowd);
    crowd.enter_initialization();
    let message = crowd.refused(crowd.exit());
    assert!(message.contains("drive.csv:2: Fp.x=\"x\": not a finite number"), "{message}");
    silent(&crowd);
    crowd.must(crowd.exit());
    crowd.steps(0, 2);
}
