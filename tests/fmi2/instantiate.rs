//! Instances that cannot be made: NULL, and a message that names what is wrong.

use crate::fmu::*;
use std::ffi::{CString, c_char, c_int, c_void};
use std::fs;
use std::ptr::{null, null_mut};

/// Asserts a refusal with one message that holds all the words.
#[track_caller]
fn refused(guid: &str, uri: &str, words: &[&str]) {
    let Err(log) = instantiate(Fmu::get(), guid, uri) else { panic!("{uri:?} made an instance") };
    check(&log, words);
}

#[track_caller]
fn check(log: &[Message], words: &[&str]) {
    let [message] = log else { panic!("one message, not {log:?}") };
    assert_eq!((message.status, &*message.category), (ERROR, "logStatusError"), "{message:?}");
    for word in words {
        assert!(message.text.contains(word), "no {word:?} in {:?}", message.text);
    }
}

fn own_guid() -> &'static str {
    &Model::paper().guid
}

/// The words of an XML mistake.
#[track_caller]
fn refused_file(resources: &Resources, words: &[&str]) {
    refused(own_guid(), &resources.uri(), words);
}

#[test]
fn guids_must_match_in_their_digits() {
    let bare = own_guid().trim_matches(['{', '}']);
    for guid in [bare.to_owned(), bare.to_uppercase(), format!("{{{bare}}}")] {
        assert!(instantiate(Fmu::get(), &guid, shared_uri()).is_ok(), "{guid}");
    }
    for guid in ["", "{}", "{00000000-0000-0000-0000-000000000000}", &bare[1..], "%s"] {
        refused(guid, shared_uri(), &["GUID", guid, bare]);
    }
}

#[test]
fn resource_locations_that_lead_nowhere() {
    let empty = tempfile::tempdir().unwrap();
    let path = empty.path().to_str().unwrap();
    refused(own_guid(), "", &["resource location"]);
    refused(own_guid(), "  ", &["resource location"]);
    refused(own_guid(), "http://host/resources", &["resource location", "http://host/resources"]);
    refused(own_guid(), "file://elsewhere/resources", &["resource location", "elsewhere"]);
    refused(
        own_guid(),
        &format!("file://{path}/no%20such"),
        &["resource location", &format!("{path}/no such")],
    );
    refused(own_guid(), &format!("file://{path}"), &["resource location", path, "Trial"]);
    refused(own_guid(), "file://", &["resource location"]);
    refused(own_guid(), "%", &["resource location"]);
    let file = empty.path().join("file");
    fs::write(&file, "").unwrap();
    refused(own_guid(), &format!("file://{}", file.display()), &["resource location", "file"]);
}

/// The host waited for ever, or lost its memory.
#[test]
fn pipes_and_devices_in_the_resources_are_refused() {
    for file in ["Parameters.xml", "static/Agents.xml", "dynamic/AgentDynamics.xml", "../trials.txt"] {
        let resources = Resources::new();
        let path = resources.trial().join(file);
        let _ = fs::remove_file(&path);
        std::os::unix::fs::symlink("/dev/zero", &path).unwrap();
        let name = file.trim_start_matches("../");
        refused_file(&resources, &[name, "it is a device, not a regular file"]);
        fs::remove_file(&path).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        refused_file(&resources, &[name, "it is a pipe, not a regular file"]);
    }
}

/// 40 000 took 2 s, 300 000 over a minute.
#[test]
fn an_element_with_many_attributes_is_refused_before_it_is_parsed() {
    let many: String = (0..300_000).map(|k| format!(" a{k}=''")).collect();
    let resources = Resources::new();
    fs::write(resources.trial().join("static/Agents.xml"), format!("<Agents>\n<Agent{many}/></Agents>"))
        .unwrap();
    refused_file(
        &resources,
        &["static/Agents.xml:2: <Agent>: has 300000 attributes; at most 256 are allowed"],
    );
}

#[test]
fn files_that_are_missing_or_no_xml() {
    for file in
        ["static/Materials.xml", "static/Geometry.xml", "static/Agents.xml", "dynamic/AgentDynamics.xml"]
    {
        let resources = Resources::new();
        fs::remove_file(resources.trial().join(file)).unwrap();
        refused_file(&resources, &["Trial_push", file, "cannot be read"]);
        fs::create_dir(resources.trial().join(file)).unwrap();
        refused_file(&resources, &[file, "cannot be read"]);
    }
    for file in ["Parameters.xml", "static/Materials.xml", "static/Geometry.xml", "static/Agents.xml"] {
        for (content, line) in [(&b"<a>\n</b>\n"[..], 2), (b"", 1), (b"<?xml version=\"1.0\"?>\n\n\xff", 3)] {
            let resources = Resources::new();
            fs::write(resources.trial().join(file), content).unwrap();
            refused_file(&resources, &[&format!("{file}:{line}")]);
        }
    }
    let resources = Resources::edited("static/Geometry.xml", "</Wall>", "</Wal>");
    refused_file(&resources, &["static/Geometry.xml:10", "well-formed"]);
}

#[test]
fn values_that_are_malformed() {
    for (file, from, to, words) in [
        ("static/Agents.xml", "89.0", "much", ["Agents.xml:3", "<Agent>", "Mass", "much"]),
        ("static/Agents.xml", "0.13058", "-0.1", ["Agents.xml:5", "<Shape>", "Radius", "-0.1"]),
        ("static/Materials.xml", "1.70e+9", "inf", ["Materials.xml:4", "<Material>", "YoungModulus", "inf"]),
        ("static/Materials.xml", "0.4\"", "-4\"", ["Materials.xml:14", "<Contact>", "KineticFriction", "-4"]),
        ("static/Geometry.xml", "-0.2,-0.57395", "1;2", ["Geometry.xml:5", "<Corner>", "Coordinates", "1;2"]),
        ("Parameters.xml", "2e-6", "%s", ["Parameters.xml:4", "<Times>", "TimeStepMechanical", "%s"]),
        (
            "dynamic/AgentDynamics.xml",
            "0.279,0.030",
            "NaN,0",
            ["AgentDynamics.xml:6", "<Kinematics>", "Position", "NaN,0"],
        ),
    ] {
        refused_file(&Resources::edited(file, from, to), &words);
    }
}

#[test]
fn lists_of_trials() {
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
    assert!(instantiate(Fmu::get(), own_guid(), &resources.uri()).is_ok());
}

/// The raw arguments of `fmi2Instantiate`.
struct Arguments {
    name: *const c_char,
    kind: c_int,
    guid: *const c_char,
    uri: *const c_char,
}

#[test]
fn nulls_and_other_arguments() {
    let fmu = Fmu::get();
    let (guid, uri) = (CString::new(own_guid()).unwrap(), CString::new(shared_uri()).unwrap());
    let good = || Arguments { name: c"crowd".as_ptr(), kind: 1, guid: guid.as_ptr(), uri: uri.as_ptr() };
    let make = |a: &Arguments, callbacks: *const Callbacks| -> *mut c_void {
        unsafe { (fmu.c.fmi2Instantiate)(a.name, a.kind, a.guid, a.uri, callbacks, 0, 1) }
    };
    let log = Log::default();
    for (bad, word) in [
        (Arguments { name: null(), ..good() }, "instanceName"),
        (Arguments { name: c"".as_ptr(), ..good() }, "instanceName"),
        (Arguments { name: c"\xff".as_ptr(), ..good() }, "instanceName"),
        (Arguments { kind: 0, ..good() }, "co-simulation"),
        (Arguments { kind: 2, ..good() }, "co-simulation"),
        (Arguments { guid: null(), ..good() }, "fmuGUID"),
        (Arguments { guid: c"\xff".as_ptr(), ..good() }, "fmuGUID"),
        (Arguments { uri: null(), ..good() }, "fmuResourceLocation"),
        (Arguments { uri: c"\xff".as_ptr(), ..good() }, "fmuResourceLocation"),
    ] {
        assert!(make(&bad, &log.callbacks()).is_null(), "{word}");
        check(&log.take(), &[word]);
        assert!(make(&bad, null()).is_null(), "{word}");
        assert!(make(&bad, &Callbacks { logger: None, ..log.callbacks() }).is_null(), "{word}");
    }
    assert!(make(&good(), null()).is_null(), "callbacks are not optional");

    // A logger is, and so is an environment.
    let silent = make(&good(), &Callbacks { logger: None, environment: null_mut(), ..log.callbacks() });
    assert!(!silent.is_null());
    unsafe {
        assert_eq!((fmu.c.fmi2DoStep)(silent, 0.0, 1.0, 1), ERROR);
        (fmu.c.fmi2FreeInstance)(silent);
    }
    assert!(log.take().is_empty());
}
