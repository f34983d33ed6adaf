//! A Trial runs, its series is read back, the Trial of its end is what the run was then.

use crowd_mechanics::engine::{State, World};
use crowd_mechanics::model::CrowdModel;
use crowd_mechanics::quantities::CrowdQuantity;
use crowd_mechanics::setup::{self, Setup};
use lemons_core::plane::vec2;
use lemons_core::trial::Trial;
use lemons_fmi::location::Location;
use lemons_fmi::{Model, Step};
use lemons_results::columns::Effect;
use lemons_results::{KeptFrames, Record, RecordError, Run, series, trial_at_end};
use std::collections::BTreeSet;
use std::f64::consts::PI;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

fn resources() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../resources")
}

/// The default Trial, pressed together from both ends, and to the walls.
fn pushed(at: &Path) -> Trial {
    let (mut trial, _) = setup::read(&resources().join("Trial_push")).unwrap();
    trial.dynamics[0].fp = vec2(900.0, -300.0);
    trial.dynamics[0].mp = 3.0;
    trial.dynamics[2].fp = vec2(0.0, 600.0);
    trial.dynamics[4].fp = vec2(-900.0, 300.0);
    trial.write(&at.join("trials/pushed")).unwrap();
    trial
}

/// Records 30 steps by the FMU, and returns a world that did the same, after each.
fn run(at: &Path, trial: &Trial) -> Vec<World> {
    let mut crowd = CrowdModel::load(Location::Path(at.join("trials").to_str().unwrap())).unwrap();
    crowd.set_texts(&[(CrowdQuantity::OutputDirectory, at.join("out").to_str().unwrap())]).unwrap();
    crowd.initialize(0.0).unwrap();
    let mut world = Setup::of(trial).world().unwrap();
    (1..=30)
        .map(|k| {
            crowd.advance(Step::of(f64::from(k - 1) * 0.05, 0.05)).unwrap_or_else(|_| panic!("step {k}"));
            world.advance(0.05).unwrap();
            let mut seen = Setup::of(trial).world().unwrap();
            seen.restore(world.state().clone()).unwrap();
            seen
        })
        .collect()
}

/// All but the count of steps, which begins anew.
#[track_caller]
fn same(seen: &State, wanted: &State) {
    assert_eq!(*seen, State { steps: seen.steps, ..wanted.clone() });
}

fn read_series(directory: &Path, trial: &Trial) -> Result<Run, RecordError> {
    Record::series(directory, trial)?.read_wanted(KeptFrames::All)
}

#[test]
fn the_end_of_a_series_is_where_the_run_was() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let trial = pushed(at);
    let worlds = run(at, &trial);
    let series = read_series(&at.join("out"), &trial).unwrap();
    assert_eq!(series.frames.len(), 30);
    assert_eq!(Record::from(series.clone()).frame_rate().unwrap(), 20.0);
    let (mut rubbed_agents, mut rubbed_walls) = (0, 0);
    for (k, mut world) in worlds.into_iter().enumerate() {
        let frames = series.frames[..=k].to_vec();
        for (agent, wanted) in world.contacts().bodies.iter().enumerate() {
            let seen = |effect| frames[k].effects.get(effect, agent).unwrap();
            let counts = [Effect::AgentContacts, Effect::WallContacts, Effect::ContactingAgents].map(seen);
            let counted = [wanted.agent_contacts, wanted.wall_contacts, wanted.touching_bodies];
            assert_eq!(counts, counted.map(f64::from));
            assert!((seen(Effect::NormalForce) - wanted.squeeze).abs() <= 1e-12 * wanted.squeeze);
        }
        let until = Run { frames, ..series.clone() };
        trial_at_end(&until.into(), &trial).unwrap().0.write(&at.join("end")).unwrap();
        let (end, _) = setup::read(&at.join("end")).unwrap();
        let mut again = Setup::of(&end).world().unwrap();
        assert_eq!(again.drive, world.drive);
        same(again.state(), world.state());
        let state = world.state();
        rubbed_agents += state.disk_springs.iter().filter(|spring| spring.elongation != 0.0).count();
        rubbed_walls += state.face_springs.iter().filter(|spring| spring.elongation != 0.0).count();
        // And so it goes on.
        world.advance(0.05).unwrap();
        again.advance(0.05).unwrap();
        same(again.state(), world.state());
    }
    // A body that has turned more than twice: it was asked of whether it is in degrees.
    for (turned, theta) in [(15.0, 15.0 - 4.0 * PI), (-4.0, 2.0 * PI - 4.0), (-PI, PI), (3.0, 3.0)] {
        let mut until = series.clone();
        until.frames[29].agents[0].pose.orientation = turned;
        let (end, _) = trial_at_end(&until.clone().into(), &trial).unwrap();
        assert!((end.dynamics[0].theta - theta).abs() < 1e-14, "{turned}: {}", end.dynamics[0].theta);
    }
    assert!(rubbed_agents > 0 && rubbed_walls > 0, "{rubbed_agents} and {rubbed_walls} springs");
}

#[test]
fn a_series_is_the_same_files_again_or_says_what_is_broken() {
    let directory = TempDir::new().unwrap();
    let at = directory.path();
    let trial = pushed(at);
    run(at, &trial);
    let read = Record::series(&at.join("out"), &trial).unwrap();
    series(&read, &trial, &at.join("copy")).unwrap();
    let names = |part: &str| {
        let files = std::fs::read_dir(at.join(part)).unwrap();
        files.map(|entry| entry.unwrap().file_name()).collect::<BTreeSet<_>>()
    };
    assert!(names("out").len() > 30, "contacts too");
    assert_eq!(names("out"), names("copy"));
    for name in &names("out") {
        let text = |part: &str| std::fs::read_to_string(at.join(part).join(name)).unwrap();
        assert!(text("out") == text("copy"), "{name:?}");
    }
    // A shorter run beside what is left of a longer one would be read as one.
    let message = series(&read.every(2), &trial, &at.join("copy")).unwrap_err().to_string();
    assert!(message.contains("of another run"), "{message}");

    let out = at.join("out");
    let message = |directory: &Path| read_series(directory, &trial).unwrap_err().to_string();
    assert!(message(at).contains("holds no series"));
    assert!(message(&at.join("none")).contains("none: cannot be read"));
    let first = out.join("AgentDynamics output t=0.05.xml");
    let text = std::fs::read_to_string(&first).unwrap();
    std::fs::write(&first, text.replacen("Theta=\"", "Theta=\"x", 1)).unwrap();
    assert!(message(&out).contains("t=0.05.xml:4: <Kinematics> Theta="), "{}", message(&out));
    std::fs::write(&first, &text).unwrap();
    for (name, expected) in [
        ("AgentDynamics output t=soon.xml", "t=soon.xml: the name holds no time"),
        ("AgentDynamics output t=0.050.xml", "is the same time"),
        ("AgentInteractions t=7.0.xml", "there is no \"AgentDynamics output t=7.0.xml\""),
    ] {
        std::fs::write(out.join(name), &text).unwrap();
        assert!(message(&out).contains(expected), "{}", message(&out));
        std::fs::remove_file(out.join(name)).unwrap();
    }
    std::fs::remove_file(out.join("AgentDynamics output t=0.3.xml")).unwrap();
    let _ = std::fs::remove_file(out.join("AgentInteractions t=0.3.xml"));
    let message = Record::series(&out, &trial).unwrap().frame_rate().unwrap_err().to_string();
    assert!(message.contains("AgentDynamics output t=0.35.xml: column t"), "{message}");
}
