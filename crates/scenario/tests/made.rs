//! Scenarios of `crowds/` are made, written and read again. Tests of command, sweep, lab and Python compare with them.

use crowd_mechanics::setup::Setup;
use lemons_core::files::source::{LocalFiles, Memory};
use lemons_decision::{DecisionConfig, Spread};
use lemons_scenario::{MOST_PEOPLE, RegionForm, Scenario, ScenarioDocuments, ScenarioError};
use std::ops::ControlFlow;
use std::path::Path;

fn crowds() -> Vec<(String, Scenario)> {
    let read = |(name, file): (_, std::path::PathBuf)| (name, Scenario::read(&LocalFiles, &file).unwrap());
    lemons_testing::scenarios().into_iter().map(read).collect()
}

fn documents(scenario: &Scenario) -> Result<ScenarioDocuments, ScenarioError> {
    scenario.documents("T", MOST_PEOPLE, &LocalFiles, &mut |_| ControlFlow::Continue(()))
}

#[test]
fn what_is_written_and_read_again_makes_the_same_files() {
    for (name, scenario) in crowds() {
        let again = Scenario::from_toml(&scenario.to_toml().unwrap()).unwrap();
        assert_eq!(again, scenario, "{name}");
        let (first, second) = (documents(&scenario).unwrap(), documents(&again).unwrap());
        let directory = Path::new("T");
        assert_eq!(first.trial.texts(directory), second.trial.texts(directory), "{name}");
        let beside = first.beside().unwrap();
        assert_eq!(beside, second.beside().unwrap(), "{name}");
        assert_eq!(
            first.decision.is_some(),
            scenario.leave || ["legs_stand", "goals"].contains(&&*name),
            "{name}"
        );
        // What is written is what was decided.
        if let Some((config, _)) = &first.decision {
            assert_eq!(DecisionConfig::from_toml(&beside[0].1).unwrap(), *config, "{name}");
        }
    }
}

#[test]
fn the_speed_of_kinds_yields_to_that_of_all_only() {
    let all = crowds();
    let of = |name: &str| all.iter().find(|(known, _)| known == name).unwrap().1.clone();
    let decided = |scenario: &Scenario| documents(scenario).unwrap().decision.unwrap().0;
    // 20 % children and 10 % wheelchairs have a speed of their own; who has none has the usual one.
    let own = decided(&of("mix"));
    assert_eq!((own.agents.len(), own.desired_speed), (40, Some(Spread::Same(1.34))));
    let mut usual = of("mix");
    usual.decision.desired_speed = Some(Spread::Same(1.0));
    let given = decided(&usual);
    assert_eq!((&given.agents, given.desired_speed), (&own.agents, Some(Spread::Same(1.0))));
    let same = decided(&of("mix_speed"));
    assert_eq!((same.agents.len(), same.desired_speed), (0, Some(Spread::Same(1.1))));
}

#[test]
fn keys_are_set_by_name() {
    let scenario = Scenario::from_toml("number = 9\nbox = [5, 5]").unwrap();
    let set = scenario.with("mix.child", "10").unwrap().with("decision.groups.share", "0.5").unwrap();
    assert_eq!(set.mix.len(), 1);
    assert_eq!(set.decision.groups.unwrap().share, Some(0.5));
    assert_eq!(scenario.with("material", "human_soft").unwrap().material.unwrap(), "human_soft");
    let dotted = scenario.with("decision.agents.\"a.b\".desired_speed", "1.5").unwrap();
    assert_eq!(dotted.decision.agents["a.b"].desired_speed, Some(1.5));
    for (key, value, words) in [
        ("number = 3\nseed", "3", "must be a key"),
        ("seed = 5 #", "3", "must be a key"),
        ("[decision]\npush", "3", "must be a key"),
        ("number", "3\nseed = 4", "invalid type: string"),
        ("wheels", "3", "unknown field `wheels`"),
        ("doros", "[]", "did you mean `doors`?"),
        ("number", "many", "invalid type: string \"many\""),
        ("number.more", "3", "number is no table"),
        ("decision.speed", "3", "unknown field `speed`"),
    ] {
        let message = scenario.with(key, value).unwrap_err().to_string();
        assert!(message.contains(words), "{key}: {message}");
    }
}

#[test]
fn what_cannot_be_is_said_with_its_key() {
    for (text, words) in [
        ("box = [5, 5, 5]", "must be two numbers, not 3"),
        ("doors = [[1, 2]]", "must be x, y and a width"),
        ("nubmer = 3", "did you mean `number`?"),
        ("number = 0\nbox = [5, 5]", "`number` = 0: must be from 1"),
        ("number = 3\nbox = [5, 5]\ngeometry = \"a.xml\"", "`box` and `geometry`: a scenario has one room"),
        ("number = 3\nbox = [5, 5]\nleave = true", "`leave`: there is no way out"),
        ("number = 3\nbox = [5, 5]\n[decision]\npush = 9", "`push`: nobody walks without `leave`"),
        ("number = 3\nbox = [5, 5]\nmix = { adlt = 1 }", "`mix`: there is no kind \"adlt\""),
        ("number = 3\ngeometry = \"gone.xml\"", "gone.xml"),
        (
            "number = 3\nbox = [5, 5]\npeople = { kind = \"tables\", male = \"no.csv\" }",
            "no.csv: cannot be read",
        ),
        ("number = 3\ndrawing = { origin = true }\nbox = [5, 5]", "`drawing.origin` is for drawings"),
        ("number = 3\nbox = [5, 5]\nfriction = 3", "`friction` = 3: must be from 0 to 2"),
        ("number = 90\nbox = [3, 3]", "90 people do not fit on 9.00 m² without overlap; about "),
        ("box = [5, 5]", "the number of people is missing in a box of 5 m x 5 m"),
        (
            "number = 3\nbox = [5, 5]\ndoors = [[2.5, 2.5, 1]]\nleave = true",
            "`doors`: door 0 at (2.5, 2.5) m is 2.50 m",
        ),
        (
            "number = 3\nbox = [5, 5]\n[[pushes]]\nat = [50, 50]\nradius = 1\ndirection = 0\nforce = 9\nstart = 0\nduration = 1",
            "push 1: nobody stands in its circle",
        ),
    ] {
        let message =
            Scenario::from_toml(text).and_then(|scenario| documents(&scenario)).unwrap_err().to_string();
        assert!(message.contains(words), "{text}: {message}");
    }
    // Round bodies have no luggage, and a room has the doors of both lists.
    let room = &crowds().into_iter().find(|(name, _)| name == "room").unwrap().1;
    let both = documents(room).unwrap();
    assert_eq!((both.place.doors.len(), both.decision.unwrap().0.exits.unwrap().len()), (2, 2));
    let mut outside = room.clone();
    outside.regions[0] = RegionForm::of(&[[7.0, 0.0], [12.0, 0.0], [12.0, 6.0]].map(Into::into));
    assert!(documents(&outside).unwrap_err().to_string().contains("outside the room"));
    let many = format!("number = 3\nbox = [5, 5]\ndoors = [{}]", "[5, 2, 1],".repeat(2000));
    assert!(
        documents(&Scenario::from_toml(&many).unwrap()).unwrap_err().to_string().contains("2000 are more")
    );
    // Files are looked for beside the scenario.
    let mut files = Memory::default();
    files.put(Path::new("a/b.toml"), b"number = 3\ngeometry = \"c.xml\"".to_vec());
    let read = Scenario::read(&files, Path::new("a/b.toml")).unwrap();
    assert_eq!(read.geometry.as_deref(), Some(Path::new("a/c.xml")));
}

/// Fifty people in levels are apart at the start; nobody is round in levels.
#[test]
fn people_in_levels_are_apart() {
    let text = "number = 50\nbox = [6, 5]\nlevels = 3\nmix = { adult = 80, child = 20 }";
    let made = documents(&Scenario::from_toml(text).unwrap()).unwrap();
    let mut world = Setup::of(&made.trial).world().unwrap();
    assert!(world.contacts().contacts.is_empty(), "{:?}", world.contacts().contacts);
    world.advance(2.0).unwrap();
    assert!(world.state().twists.iter().all(|twist| twist.velocity.norm() == 0.0));
    for (levels, words) in [
        ("0", "`levels`: 0: must be 1 to 10"),
        ("[1.0]", "must be 2 to 10 heights"),
        ("[1.3, 1.0]", "each must be at least 0.02 m above the one before"),
        ("[1.0, 3.0]", "must be from 0.1 to 2.2 m"),
        ("\"many\"", "expected a number of levels, or their heights in m"),
        ("3\nround = true", "`levels` and `round`"),
        ("[1.9, 2.1]", "m does not reach the lowest level, which begins at 1.8 m"),
    ] {
        let text = format!("number = 3\nbox = [5, 5]\nlevels = {levels}");
        let message =
            Scenario::from_toml(&text).and_then(|scenario| documents(&scenario)).unwrap_err().to_string();
        assert!(message.contains(words), "{levels}: {message}");
    }
}
