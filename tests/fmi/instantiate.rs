//! Instances that cannot be made; where importers say that resources are, in all the ways they say it; and what is told,
//! to whom, and that it arrives as it is.

use crate::fmu::*;
use std::ffi::{CStr, CString};
use std::fs;
use std::ptr::null;

/// Asserts one message that holds all the words.
#[track_caller]
fn check(result: Result<Crowd, Vec<LoggedMessage>>, words: &[&str]) {
    let Err(log) = result else { panic!("{words:?}: an instance") };
    let [message] = &*log else { panic!("one message, not {log:?}") };
    assert_eq!((message.status, &*message.category), (ERROR, "logStatusError"), "{message:?}");
    for word in words {
        assert!(message.text.contains(word), "no {word:?} in {:?}", message.text);
    }
}

fn open(location: &str) -> Result<Crowd, Vec<LoggedMessage>> {
    instantiate(Fmu::get(), V2, &Model::paper(V2).token, location)
}

/// The words of an XML mistake.
#[track_caller]
fn refused_file(resources: &Resources, words: &[&str]) {
    for version in BOTH {
        check(Crowd::try_of(Fmu::get(), version, &resources.directory()), words);
    }
}

#[test]
fn tokens_must_match_in_their_digits() {
    for (version, word) in [(V2, "GUID"), (V3, "instantiationToken")] {
        let location = version.location(&packed().join("resources"));
        let make = |token: &str| instantiate(Fmu::get(), version, token, &location);
        let bare = Model::paper(version).token.trim_matches(['{', '}']);
        for token in [bare.to_owned(), bare.to_uppercase(), format!("{{{bare}}}")] {
            assert!(make(&token).is_ok(), "{token}");
        }
        for token in ["", "{}", "{00000000-0000-0000-0000-000000000000}", &bare[1..], "%s"] {
            check(make(token), &[word, token, bare]);
        }
    }
}

#[test]
fn resource_locations_that_lead_nowhere() {
    let empty = tempfile::tempdir().unwrap();
    let path = empty.path().to_str().unwrap();
    fs::write(empty.path().join("file"), "").unwrap();
    for (location, word) in [
        ("", ""),
        ("  ", ""),
        ("http://host/resources", "http://host/resources"),
        ("file://elsewhere/resources", "elsewhere"),
        (&format!("file://{path}/no%20such"), &*format!("{path}/no such")),
        (&format!("file://{path}"), path),
        ("file://", ""),
        ("%", ""),
        (&format!("file://{path}/file"), "file"),
    ] {
        check(open(location), &["resource location", word]);
    }
    check(Crowd::try_of(Fmu::get(), V3, &empty.path().join("no such")), &["no such"]);
}

/// The host waited for ever, or lost its memory.
#[test]
fn files_that_are_missing_or_none_are_refused() {
    for file in ["Parameters.xml", "static/Agents.xml", "dynamic/AgentDynamics.xml", "../trials.txt"] {
        let resources = Resources::new();
        let path = resources.trial().join(file);
        let _ = fs::remove_file(&path);
        let name = file.trim_start_matches("../");
        if !file.starts_with("..") && file != "Parameters.xml" {
            refused_file(&resources, &["Trial_push", name, "cannot be read"]);
        }
        std::os::unix::fs::symlink("/dev/zero", &path).unwrap();
        refused_file(&resources, &[name, "it is a device, not a regular file"]);
    }
}

/// Each reader's mistakes are in tests/trial.
#[test]
fn mistakes_in_files_are_named() {
    for (file, from, to, words) in [
        ("static/Agents.xml", "89.0", "much", ["Agents.xml:3", "<Agent>", "Mass", "much"]),
        ("Parameters.xml", "2e-6", "%s", ["Parameters.xml:4", "<Times>", "TimeStepMechanical", "%s"]),
        ("static/Geometry.xml", "</Wall>", "</Wal>", ["Trial_push", "Geometry.xml:10", "well-formed", ""]),
    ] {
        refused_file(&Resources::edited(file, from, to), &words);
    }
    let resources = Resources::new();
    let list = resources.directory().join("trials.txt");
    for (content, words) in [
        ("Trial_pull\n", ["Trial_pull", "Parameters.xml"]),
        ("Trial_push\n\n../x\n", ["trials.txt", "line 3"]),
        ("..\n", ["trials.txt", "line 1"]),
        ("", ["resource location", "Trial"]),
    ] {
        fs::write(&list, content).unwrap();
        refused_file(&resources, &words);
    }
    fs::write(&list, "Trial_push\n").unwrap();
    assert!(Crowd::try_of(Fmu::get(), V2, &resources.directory()).is_ok());
}

#[test]
fn nulls_and_other_arguments() {
    for version in BOTH {
        let token = CString::new(&*Model::paper(version).token).unwrap();
        let location = CString::new(version.location(&packed().join("resources"))).unwrap();
        let good = Arguments::new(&token, &location);
        let (of_token, of_location) = if version == V2 {
            ("fmuGUID", "fmuResourceLocation")
        } else {
            ("instantiationToken", "resourcePath")
        };
        let mut bad: Vec<(Arguments, &str)> = Vec::new();
        for text in [None, Some(c"\xff")] {
            bad.push((Arguments { name: text, ..good }, "instanceName"));
            bad.push((Arguments { token: text, ..good }, of_token));
            bad.push((Arguments { location: text, ..good }, of_location));
        }
        bad.push((Arguments { name: Some(c""), ..good }, "instanceName"));
        bad.push((Arguments { name: Some(c" \t "), ..good }, "instanceName"));
        if version == V2 {
            bad.extend([0, 2].map(|fmu_type| (Arguments { fmu_type, ..good }, "co-simulation")));
        } else {
            bad.push((Arguments { event_mode: true, ..good }, "hasEventMode"));
        }
        for (arguments, word) in bad {
            check(Crowd::with(Fmu::get(), version, &arguments), &[word]);
        }
    }
    // Callbacks of FMI 2.0 are not optional; a logger and an environment are.
    use lemons_fmi::testing::fmi2::{CO_SIMULATION, NO_CALLBACKS};
    let (token, crowd) = (CString::new(&*Model::paper(V2).token).unwrap(), Crowd::new(V2));
    let location = CString::new(V2.location(&packed().join("resources"))).unwrap();
    let (c, name) = (crowd.v2(), c"crowd".as_ptr());
    unsafe {
        let make = |callbacks| {
            (c.fmi2Instantiate)(name, CO_SIMULATION, token.as_ptr(), location.as_ptr(), callbacks, 0, 1)
        };
        assert!(make(null()).is_null());
        let silent = make(&NO_CALLBACKS);
        assert_eq!((c.fmi2DoStep)(silent, 0.0, 1.0, 1), ERROR);
        (c.fmi2FreeInstance)(silent);
    }
}

/// What a location says is in crates/fmi/src/location.rs; here, that the directories are found.
#[test]
fn locations_in_all_the_ways_that_importers_write_them() {
    let root = tempfile::tempdir().unwrap();
    for place in ["fmu/resources/Trial_push", "a%20b ü/resources/Trial_push", "a b/resources/Trial_push"] {
        copy_tree(&paper(), &root.path().join(place));
    }
    copy_tree(&paper(), &root.path().join("a%20b/resources/Other"));
    std::os::unix::fs::symlink(root.path().join("fmu"), root.path().join("link")).unwrap();
    // From where cargo runs tests, up to the root and down again.
    let up = "../".repeat(std::env::current_dir().unwrap().components().count());
    let path = root.path().to_str().unwrap();
    for begin in [format!("file://{path}"), path.to_owned(), format!("{up}{path}"), format!("./{up}{path}")] {
        for directory in ["fmu", "link", "a%20b ü", "a%2520b%20%C3%BC", "a b", "a%20b"] {
            for end in ["/resources", "/resources/", "", "/"] {
                let location = format!("{begin}/{directory}{end}");
                let crowd = open(&location).unwrap_or_else(|log| panic!("{location}: {log:?}"));
                // Encoded and raw mean different directories: the standard's reading goes first.
                crowd.initialize();
                assert_eq!(crowd.text("Trial"), "Trial_push", "{location}");
            }
        }
    }
}

/// One error and one warning.
fn complain(crowd: &Crowd) -> Vec<Status> {
    assert_eq!(crowd.get_real(&[u32::MAX], 1).0, ERROR);
    // SAFETY: an instance and the place of a value.
    unsafe { (crowd.v2().fmi2GetStatus)(crowd.raw, 0, &mut 0) };
    crowd.take_messages().into_iter().map(|message| message.status).collect()
}

#[test]
fn categories_filter_and_errors_are_told_by_default() {
    let crowd = Crowd::pushed(V2);
    assert_eq!(complain(&crowd), [ERROR, DISCARD]);
    let (warning, error, fatal) = (c"logStatusWarning", c"logStatusError", c"logStatusFatal");
    for (on, categories, expected) in [
        (true, vec![], vec![ERROR, DISCARD]),
        (true, vec![error], vec![ERROR, DISCARD]),
        (true, vec![warning], vec![]),
        (true, vec![warning, error], vec![ERROR, DISCARD]),
        (true, vec![fatal], vec![]),
        (true, vec![c"logAll"], vec![ERROR, DISCARD]),
        // Why a call failed is told in any case.
        (false, vec![], vec![ERROR, DISCARD]),
        (false, vec![fatal], vec![ERROR, DISCARD]),
    ] {
        let some: Vec<Option<&CStr>> = categories.into_iter().map(Some).collect();
        crowd.must(crowd.debug_logging(on, &some));
        assert_eq!(complain(&crowd), expected, "{on} {some:?}");
    }
    // An unknown one is refused, and the filter stays.
    let message = crowd.refused(crowd.debug_logging(true, &[Some(warning), Some(c"logGossip")]));
    assert!(message.contains("logGossip") && message.contains("logStatusFatal"), "{message}");
    assert_eq!(complain(&crowd), [ERROR, DISCARD]);
}

/// Percent signs are themselves. Importers replace `#r6#` by the name of a variable (FMI 2.0.5, section 2.1.5), in FMI 3.0
/// `#6#` (section 2.3.1), so that number signs are doubled.
#[test]
fn texts_arrive_as_they_are() {
    for version in BOTH {
        let crowd = Crowd::new(version);
        let message = crowd.refused(crowd.set_text("Trial", "100%s%n%d %"));
        assert!(message.contains("100%s%n%d %"), "{message}");
        let message = crowd.refused(crowd.set_text("Trial", "#6# of 2"));
        assert!(message.contains("\"##6## of 2\""), "{message}");
    }
}

#[test]
fn warnings_of_the_trial_are_told_if_they_are_wanted() {
    // The wall goes over its first face again.
    let again = r#"<Corner Coordinates="1.7526750,-0.57395"/></Wall>"#;
    let resources = Resources::edited("static/Geometry.xml", "</Wall>", again);
    for version in BOTH {
        let token = CString::new(Model::of(&resources.trial(), version).token).unwrap();
        let location = CString::new(version.location(&resources.directory())).unwrap();
        for logging_on in [false, true] {
            let arguments = Arguments { logging_on, ..Arguments::new(&token, &location) };
            let crowd = Crowd::with(Fmu::get(), version, &arguments).unwrap_or_else(|log| panic!("{log:?}"));
            let log = crowd.take_messages();
            assert_eq!(log.len(), usize::from(logging_on), "{log:?}");
            for message in log {
                assert_eq!(
                    (message.status, &*message.category),
                    (WARNING, "logStatusWarning"),
                    "{message:?}"
                );
                // The status says that it is a warning.
                let text = &message.text;
                assert!(text.contains("Geometry.xml: wall") && !text.contains("warning"), "{text}");
            }
        }
    }
}
