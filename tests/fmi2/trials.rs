//! Several Trials in one FMU, files that it writes, and resources that disappear.

use crate::fmu::*;
use std::fs;

/// The paper's Trial, and another in which agent 1 stands a centimetre further.
fn two_trials() -> Resources {
    let resources = Resources::new();
    let other = resources.directory().join("Trial_wider");
    copy_tree(&paper(), &other);
    let dynamics = other.join("dynamic/AgentDynamics.xml");
    let text = fs::read_to_string(&dynamics).unwrap();
    fs::write(dynamics, text.replace("0.279,0.030", "0.289,0.030")).unwrap();
    resources
}

fn on(resources: &Resources) -> Instance<'static> {
    instantiate(Fmu::get(), &Model::paper().guid, &resources.uri()).unwrap_or_else(|log| panic!("{log:?}"))
}

#[test]
fn a_trial_is_chosen_before_or_after_other_parameters() {
    let resources = two_trials();
    let (before, after) = (on(&resources), on(&resources));
    let set = |instance: &Instance| {
        instance.must(instance.set_all(&[("agent[0].Mass", 60.0), ("agent[2].Position.x", 0.7)]));
    };
    before.must(before.set_string("Trial", "Trial_wider"));
    set(&before);
    set(&after);
    after.must(after.set_string("Trial", "Trial_wider"));
    for instance in [&before, &after] {
        instance.push_and_initialize();
        assert_eq!(instance.get_string("Trial"), "Trial_wider");
        assert_eq!(instance.get("agent[1].Position.x"), 0.289);
        assert_eq!(instance.get("agent[2].Position.x"), 0.7);
        assert_eq!(instance.get("agent[0].Mass"), 60.0);
        instance.steps(0, 14);
    }
    assert_eq!(before.everything(), after.everything());

    before.must(unsafe { (before.fmu.c.fmi2Reset)(before.raw) });
    before.initialize();
    assert_eq!(before.get_string("Trial"), "Trial_push");
    assert_eq!((before.get("agent[1].Position.x"), before.get("agent[0].Mass")), (0.279, 89.0));
}

#[test]
fn a_state_brings_its_trial_along() {
    let resources = two_trials();
    let (saved, other) = (on(&resources), on(&resources));
    saved.must(saved.set_string("Trial", "Trial_wider"));
    saved.push_and_initialize();
    saved.steps(0, 10);
    let bytes = saved.bytes();
    other.push_and_initialize();
    other.must(other.restore_bytes(&bytes));
    assert_eq!(other.get_string("Trial"), "Trial_wider");
    saved.steps(10, 20);
    other.steps(10, 20);
    assert_eq!(saved.everything(), other.everything());

    // Where that Trial is not packed, the state is of no use.
    let elsewhere = Instance::pushed(Fmu::get());
    let before = elsewhere.bytes();
    let message = elsewhere.refused(elsewhere.restore_bytes(&bytes));
    assert!(message.contains("Trial_wider"), "{message}");
    assert!(elsewhere.bytes() == before);
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
        let instance = on(&resources);
        let before = instance.bytes();
        // Together with another text, which is not kept either.
        let references = ["OutputDirectory", "Trial"].map(|name| instance.model.reference(name));
        let texts = [c"/tmp".as_ptr(), c"Trial_wider".as_ptr()];
        let message = instance.refused(unsafe {
            (instance.fmu.c.fmi2SetString)(instance.raw, references.as_ptr(), 2, texts.as_ptr())
        });
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
        assert!(instance.bytes() == before);
    }
}

#[test]
fn output_goes_where_it_is_told() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("ü and space");
    fs::create_dir(&path).unwrap();
    let (writing, silent) = (Instance::new(Fmu::get()), Instance::pushed(Fmu::get()));
    writing.must(writing.set_string("OutputDirectory", path.to_str().unwrap()));
    writing.push_and_initialize();
    for instance in [&writing, &silent] {
        instance.steps(0, 10);
    }
    assert_eq!(writing.everything(), silent.everything());
    let written = |name: &str| path.join(name).is_file();
    assert!((1..10).all(|k| written(&format!("AgentDynamics output t=0.0{k}.xml"))));
    assert!(written("AgentDynamics output t=0.1.xml"));
    // The only step that ends in a contact.
    assert!(written("AgentInteractions t=0.1.xml"));
    assert_eq!(fs::read_dir(&path).unwrap().count(), 11);
}

/// Importers delete what they unpacked when they like.
#[test]
fn resources_may_disappear() {
    let resources = Resources::new();
    let (instance, control) = (on(&resources), Instance::pushed(Fmu::get()));
    drop(resources);
    instance.push_and_initialize();
    instance.steps(0, 3);
    let bytes = instance.bytes();
    instance.must(unsafe { (instance.fmu.c.fmi2Reset)(instance.raw) });
    instance.must(instance.restore_bytes(&bytes));
    instance.steps(3, 14);
    control.steps(0, 14);
    assert_eq!(instance.everything(), control.everything());
}
