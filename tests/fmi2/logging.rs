//! What is told, to whom, and that it arrives as it is.

use crate::fmu::*;
use std::ffi::c_int;

/// One error and one warning.
fn complain(instance: &Instance) -> Vec<(c_int, String)> {
    let reference = instance.model.reference("Threads");
    unsafe {
        (instance.fmu.c.fmi2GetReal)(instance.raw, &reference, 1, &mut 0.0);
        (instance.fmu.c.fmi2GetStatus)(instance.raw, 0, &mut 0);
    }
    instance.log.take().into_iter().map(|message| (message.status, message.category)).collect()
}

#[test]
fn categories_filter_and_errors_are_told_by_default() {
    // `Instance` passes loggingOn = true.
    let instance = Instance::pushed(Fmu::get());
    let error = (ERROR, "logStatusError".to_owned());
    let warning = (DISCARD, "logStatusWarning".to_owned());
    let both = [error.clone(), warning.clone()];
    assert_eq!(complain(&instance), both);
    for (on, categories, expected) in [
        (true, &[][..], &both[..]),
        (true, &["logStatusError"], &both[..1]),
        (true, &["logStatusWarning"], &both[1..]),
        (true, &["logStatusWarning", "logStatusError"], &both),
        (true, &["logStatusFatal"], &[]),
        (true, &["logAll"], &both),
        // Why a call failed is told in any case.
        (false, &[], &both[..1]),
        (false, &["logStatusFatal"], &both[..1]),
    ] {
        instance.must(instance.log_on(on, categories));
        assert_eq!(complain(&instance), expected, "{on} {categories:?}");
    }
}

#[test]
fn unknown_categories_are_refused_and_the_filter_stays() {
    let instance = Instance::pushed(Fmu::get());
    instance.must(instance.log_on(true, &["logStatusError"]));
    let message = instance.refused(instance.log_on(true, &["logStatusWarning", "logGossip"]));
    assert!(message.contains("logGossip") && message.contains("logStatusFatal"), "{message}");
    assert_eq!(complain(&instance), [(ERROR, "logStatusError".to_owned())]);
}

#[test]
fn percent_signs_are_themselves() {
    let instance = Instance::new(Fmu::get());
    let name = "100%s%n%d %";
    let message = instance.refused(instance.set_string("Trial", name));
    assert!(message.contains(name), "{message}");
}

/// Importers replace `#r6#` by the name of a variable (FMI 2.0.5, section 2.1.5).
#[test]
fn number_signs_are_doubled() {
    let instance = Instance::new(Fmu::get());
    let message = instance.refused(instance.set_string("Trial", "#r6# of 2"));
    assert!(message.contains("\"##r6## of 2\""), "{message}");
}

#[test]
fn without_logging_there_are_no_warnings() {
    let again = r#"<Corner Coordinates="1.7526750,-0.57395"/></Wall>"#;
    let resources = Resources::edited("static/Geometry.xml", "</Wall>", again);
    let instance = instantiate_with(Fmu::get(), &Model::paper().guid, &resources.uri(), false).unwrap();
    assert_eq!(instance.log.take(), []);
}

#[test]
fn warnings_of_the_trial_are_told() {
    // The wall goes over its first face again.
    let again = r#"<Corner Coordinates="1.7526750,-0.57395"/></Wall>"#;
    let resources = Resources::edited("static/Geometry.xml", "</Wall>", again);
    let instance = instantiate(Fmu::get(), &Model::paper().guid, &resources.uri()).expect("only a warning");
    let log = instance.log.take();
    let [message] = &*log else { panic!("{log:?}") };
    assert_eq!((message.status, &*message.category), (WARNING, "logStatusWarning"), "{message:?}");
    assert!(message.text.contains("Geometry.xml:10"), "{message:?}");
    // The status says that it is a warning.
    assert!(!message.text.contains("warning"), "{message:?}");
}
