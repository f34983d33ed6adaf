//! Several Trials in one FMU, files that it writes, and resources that disappear.

use crate::fmu::*;
use std::fs;

/// The paper's Trial, and another in which agent 1 stands a centimetre further.
fn two_trials() -> Resources {
    Resources::with_other("Trial_wider", "0.289,0.030")
}

#[test]
fn a_trial_is_chosen_before_or_after_other_parameters() {
    let resources = two_trials();
    for version in BOTH {
        let (before, after) = (Crowd::on(version, &resources), Crowd::on(version, &resources));
        let set = |crowd: &Crowd| crowd.must(crowd.set("agent[0].Mass", 60.0));
        before.must(before.set_text("Trial", "Trial_wider"));
        set(&before);
        set(&after);
        after.must(after.set_text("Trial", "Trial_wider"));
        for crowd in [&before, &after] {
            crowd.push_and_initialize();
            assert_eq!(crowd.text("Trial"), "Trial_wider");
            assert_eq!((crowd.get("agent[1].Position.x"), crowd.get("agent[0].Mass")), (0.289, 60.0));
            crowd.steps(0, 14);
        }
        assert_eq!(before.everything(), after.everything());
        // A state brings its Trial along.
        let other = Crowd::on(version, &resources);
        other.push_and_initialize();
        other.must(other.restore(&before.bytes()));
        assert_eq!(other.text("Trial"), "Trial_wider");
        before.steps(14, 20);
        other.steps(14, 20);
        assert_eq!(before.everything(), other.everything());

        before.reset();
        before.initialize();
        assert_eq!(before.text("Trial"), "Trial_push");
        assert_eq!((before.get("agent[1].Position.x"), before.get("agent[0].Mass")), (0.279, 89.0));
    }
}

#[test]
fn a_trial_that_is_broken_or_has_other_variables_cannot_be_chosen() {
    let resources = two_trials();
    let materials = resources.directory().join("Trial_wider/static/Materials.xml");
    let good = fs::read_to_string(&materials).unwrap();
    for (text, words) in [
        (good.replace("0.7e3", "x"), ["Trial_wider", "Materials.xml:14"]),
        (good.replace("human_clothes", "coat"), ["Trial_wider", "other variables"]),
    ] {
        fs::write(&materials, text).unwrap();
        let crowd = Crowd::on(V2, &resources);
        let before = crowd.bytes();
        // Together with another text, which is not kept either.
        let status = crowd.try_texts(&[("OutputDirectory", "/tmp"), ("Trial", "Trial_wider")]);
        let message = crowd.refused(status);
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
        assert!(crowd.bytes() == before);
    }
}

/// The force on agent 4 by walls, and on the pieces of walls that an FMU has, when another Trial is chosen whose walls are
/// changed so. FMI 2.0 has the pieces of the first Trial's walls; FMI 3.0 needs their number.
fn wall_forces(version: Version, from: &str, to: &str, pieces: usize) -> (f64, Vec<f64>) {
    let resources = two_trials();
    edit(&resources.directory().join("Trial_wider/static/Geometry.xml"), from, to);
    let crowd = Crowd::on(version, &resources);
    if version == V3 {
        crowd.must(crowd.enter_configuration());
        crowd.must(crowd.set_size(&[crowd.model.reference("WallSegments")], &[pieces as u64]));
        crowd.must(crowd.exit_configuration());
    }
    crowd.must(crowd.set_text("Trial", "Trial_wider"));
    crowd.must(crowd.set("agent[4].Position.x", 1.7));
    crowd.initialize();
    crowd.must(crowd.try_step(0.0, 0.01));
    let forces = if version == V3 {
        let (status, forces) = crowd.get_real(&[crowd.model.reference("WallMeanNormalForce")], pieces);
        crowd.must(status);
        forces
    } else {
        (0..4).map(|k| crowd.get(&format!("wall[{k}].MeanNormalForce"))).collect()
    };
    (crowd.get("agent[4].MeanWallForce"), forces)
}

#[test]
fn a_trial_with_fewer_walls_can_be_chosen() {
    let corners = "<Corner Coordinates=\"-0.2,0.543710\"/>\n        <Corner Coordinates=\"-0.2,-0.57395\"/>";
    let [(force, all), (_, own)] = BOTH.map(|version| wall_forces(version, corners, "", 2));
    assert!(force > 100.0 && own == [0.0, force] && all == [0.0, force, 0.0, 0.0], "{own:?} {all:?}");
}

#[test]
fn a_trial_with_more_walls_can_be_chosen() {
    let wall = "<Wall Id=\"1\" MaterialId=\"concrete\"><Corner Coordinates=\"1.65,-0.5\"/>\
                <Corner Coordinates=\"1.65,0.5\"/></Wall></Geometry>";
    let [(same, first), (force, all)] = BOTH.map(|version| wall_forces(version, "</Geometry>", wall, 5));
    assert_eq!((same, &first[..]), (force, &all[..4]));
    let [before, behind] = [all[1], all[4]];
    assert!(before > 100.0 && behind > 100.0 && (before + behind - force).abs() < 1e-9 * force, "{all:?}");
}

#[test]
fn output_goes_where_it_is_told() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("ü and space");
    fs::create_dir(&path).unwrap();
    let (writing, silent) = (Crowd::new(V2), Crowd::pushed(V2));
    writing.must(writing.set_text("OutputDirectory", path.to_str().unwrap()));
    writing.push_and_initialize();
    for crowd in [&writing, &silent] {
        crowd.steps(0, 10);
    }
    assert_eq!(writing.everything(), silent.everything());
    let written = |name: &str| path.join(name).is_file();
    assert!((1..10).all(|k| written(&format!("AgentDynamics output t=0.0{k}.xml"))));
    // The only step that ends in a contact.
    assert!(written("AgentDynamics output t=0.1.xml") && written("AgentInteractions t=0.1.xml"));
    assert_eq!(fs::read_dir(&path).unwrap().count(), 11);
}

/// Importers delete what they unpacked when they like.
#[test]
fn resources_may_disappear() {
    let resources = Resources::new();
    let (crowd, control) = (Crowd::on(V2, &resources), Crowd::pushed(V2));
    drop(resources);
    crowd.push_and_initialize();
    crowd.steps(0, 3);
    let bytes = crowd.bytes();
    crowd.reset();
    crowd.must(crowd.restore(&bytes));
    crowd.steps(3, 14);
    control.steps(0, 14);
    assert_eq!(crowd.everything(), control.everything());
}
