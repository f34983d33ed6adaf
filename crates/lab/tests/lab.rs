//! What a page may ask for, as it asks: bytes in, bytes out.

use lemons_lab::boundary::answer;
use lemons_lab::run::COLUMNS;
use lemons_lab::{Lab, upload};
use lemons_master::{Error, Observer, Prepared, Reached, Settings, System, own_binary};
use serde_json::{Value, json};
use std::io::{Cursor, Write};
use std::ops::ControlFlow;
use std::path::Path;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

/// The answer's JSON and bytes.
fn ask(lab: &mut Lab, request: &Value, bytes: &[u8]) -> (Value, Vec<u8>) {
    let text = request.to_string();
    let request = [&(text.len() as u32).to_le_bytes(), text.as_bytes(), bytes].concat();
    let answer = answer(lab, &request, &mut |_| ControlFlow::Continue(()));
    let length = u32::from_le_bytes(answer[..4].try_into().unwrap()) as usize;
    (serde_json::from_slice(&answer[4..4 + length]).unwrap(), answer[4 + length..].to_vec())
}

fn ok(lab: &mut Lab, request: Value) -> (Value, Vec<u8>) {
    let (mut value, bytes) = ask(lab, &request, &[]);
    assert!(value.get("ok").is_some(), "{request}: {value}");
    (value["ok"].take(), bytes)
}

fn refused(lab: &mut Lab, request: Value, bytes: &[u8]) -> String {
    let (value, nothing) = ask(lab, &request, bytes);
    assert!(nothing.is_empty());
    value["refused"].as_str().unwrap_or_else(|| panic!("{request}: {value}")).to_owned()
}

fn numbers(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).map(|number| f64::from_le_bytes(number.try_into().unwrap())).collect()
}

fn zipped(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in files {
        archive.start_file(*name, SimpleFileOptions::default()).unwrap();
        archive.write_all(content).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// The same zip with one more file.
fn zipped_with(zip: &[u8], name: &str, content: &[u8]) -> Vec<u8> {
    let mut archive = ZipWriter::new_append(Cursor::new(zip.to_vec())).unwrap();
    archive.start_file(name, SimpleFileOptions::default()).unwrap();
    archive.write_all(content).unwrap();
    archive.finish().unwrap().into_inner()
}

/// The files of the example "push" under a directory, one of them changed.
fn push_with(directory: &str, changed: &str, change: impl Fn(&str) -> String) -> Vec<u8> {
    let files = upload::EXAMPLES[0].1.iter().map(|(name, text)| {
        let text = if *name == changed { change(text) } else { (*text).to_owned() };
        (format!("{directory}{name}"), text)
    });
    let files: Vec<(String, String)> = files.collect();
    let files: Vec<(&str, &[u8])> = files.iter().map(|(name, text)| (&**name, text.as_bytes())).collect();
    zipped(&files)
}

#[test]
fn a_person_has_the_breadth_and_depth_that_are_asked_for_and_a_rank() {
    let mut lab = Lab::default();
    let person =
        json!({"ask": "person", "sex": "male", "breadth": 0.5, "depth": 0.3, "stature": 1.8, "mass": null});
    let (is, _) = ok(&mut lab, person);
    let disks: Vec<[f64; 3]> = serde_json::from_value(is["disks"].clone()).unwrap();
    let most =
        |along: fn(&[f64; 3]) -> f64| disks.iter().map(|disk| along(disk) + disk[2]).fold(0.0, f64::max);
    assert!((most(|disk| disk[1]) - 0.25).abs() < 1e-12);
    let depth = most(|disk| disk[0]) + most(|disk| -disk[0]);
    assert!((depth - 0.3).abs() < 1e-12, "{depth}");
    let rank = |k: usize| is["measures"][k]["rank"].as_f64().unwrap();
    // ANSUR II: men are 1.756 m tall on average, with a standard deviation of 0.069 m, and about normally distributed.
    assert!((rank(2) - 0.74).abs() < 0.02, "{}", rank(2));
    assert!((rank(3) - 0.5).abs() < 0.01);
    let said = refused(
        &mut lab,
        json!({"ask": "person", "sex": "male", "breadth": 50, "depth": null, "stature": null, "mass": null}),
        &[],
    );
    assert!(said.contains("50") && said.contains("breadth"), "{said}");
}

#[test]
fn a_crowd_is_placed_without_overlap_with_progress_and_the_same_for_the_same_seed() {
    let crowd = json!({"ask": "crowd", "number": 40, "seed": 3, "room": [4.0, 4.0], "direction": null});
    let (made, first) = ok(&mut Lab::default(), crowd.clone());
    assert!(made["largest_overlap"].as_f64().unwrap() <= 1e-4);
    let agents = made["scene"]["agents"].as_array().unwrap();
    let poses = numbers(&first);
    assert_eq!((agents.len(), poses.len()), (40, 40 * COLUMNS));
    // By the page's own numbers: no two disks of different people overlap, none is beyond the walls.
    let disks = |a: usize| {
        let [x, y, turn] = [0, 1, 2].map(|k| poses[COLUMNS * a + k]);
        let disks: Vec<[f64; 3]> = serde_json::from_value(agents[a]["disks"].clone()).unwrap();
        disks.into_iter().map(move |[u, v, r]| {
            [x + u * turn.cos() - v * turn.sin(), y + u * turn.sin() + v * turn.cos(), r]
        })
    };
    for a in 0..40 {
        for [x, y, r] in disks(a) {
            assert!([x, y].iter().all(|place| (r - 1e-4..=4.0 - r + 1e-4).contains(place)));
            for b in 0..a {
                assert!(disks(b).all(|[u, v, s]| (u - x).hypot(v - y) >= r + s - 1e-4), "{a} {b}");
            }
        }
    }
    assert_eq!(ok(&mut Lab::default(), crowd).1, first);
    let mut lab = Lab::default();
    let text =
        json!({"ask": "crowd", "number": 100, "seed": 3, "room": [4.0, 4.0], "direction": null}).to_string();
    let request = [&(text.len() as u32).to_le_bytes(), text.as_bytes()].concat();
    let mut heard = 0;
    let stopped = answer(&mut lab, &request, &mut |_| {
        heard += 1;
        if heard == 3 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    assert!(heard == 3 && String::from_utf8_lossy(&stopped).contains("the placing was stopped"));
    assert!(
        refused(&mut lab, json!({"ask": "take", "run": 0, "wanted": {"file": "trial"}}), &[])
            .contains("no Trial")
    );
}

#[test]
fn the_push_moves_as_the_fmu_moves_to_the_last_bit() {
    let mut lab = Lab::default();
    ok(&mut lab, json!({"ask": "example", "name": "push"}));
    let (value, frames) = ok(&mut lab, json!({"ask": "advance", "run": 1, "steps": 20}));
    assert_eq!(value["time"], 1.0);
    let shown = numbers(&frames);
    assert_eq!(shown.len(), 20 * 5 * COLUMNS);

    let binary = own_binary().unwrap();
    let library = std::fs::read(&binary.path).unwrap();
    let wanted = json!({"ask": "take", "run": 1, "wanted": {
        "file": "fmu", "version": 2, "binaries": [[binary.platform, library.len()]]
    }});
    let (value, fmu) = ask(&mut lab, &wanted, &library);
    assert_eq!(value["ok"]["name"], "push.fmu");
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("push.fmu");
    std::fs::write(&path, fmu).unwrap();
    let frames = run(&path, 1.0);
    assert_eq!(frames.len(), 20);
    for (frame, shown) in frames.iter().zip(shown.chunks(5 * COLUMNS)) {
        for (a, pose) in frame.iter().enumerate() {
            assert_eq!(pose, &shown[COLUMNS * a..COLUMNS * a + 3], "agent {a}");
        }
    }
    // It reached the last of the row.
    assert!((frames[19][4][0] - frames[0][4][0]).abs() > 0.01);
    // And from the beginning again: the former run is over.
    ok(&mut lab, json!({"ask": "example", "name": "push"}));
    assert!(
        refused(&mut lab, json!({"ask": "advance", "run": 1, "steps": 1}), &[]).contains("run 1 is over")
    );
    let (_, again) = ok(&mut lab, json!({"ask": "advance", "run": 2, "steps": 20}));
    assert_eq!(numbers(&again), shown);
}

#[test]
fn a_trial_that_is_taken_is_opened_again_with_its_drive() {
    let mut lab = Lab::default();
    let (scene, first) = ok(&mut lab, json!({"ask": "example", "name": "push"}));
    let (_, moved) = ok(&mut lab, json!({"ask": "advance", "run": 1, "steps": 9}));
    let (name, zip) = ok(&mut lab, json!({"ask": "take", "run": 1, "wanted": {"file": "trial"}}));
    assert_eq!(name["name"], "push.zip");
    let archive = zip::ZipArchive::new(Cursor::new(&zip)).unwrap();
    let mut names: Vec<String> = archive.file_names().map(|name| name.unwrap().into_owned()).collect();
    names.sort();
    let files = ["Parameters.xml", "drive.csv", "dynamic/AgentDynamics.xml", "static/Agents.xml"];
    let files = files.into_iter().chain(["static/Geometry.xml", "static/Materials.xml"]);
    assert_eq!(names, files.map(|name| format!("push/{name}")).collect::<Vec<_>>());
    let (value, bytes) = ask(&mut lab, &json!({"ask": "open", "name": "push.zip"}), &zip);
    let mut known = scene["scene"].clone();
    known["run"] = 2.into();
    assert_eq!((&value["ok"]["scene"], &bytes), (&known, &first));
    assert_eq!(ok(&mut lab, json!({"ask": "advance", "run": 2, "steps": 9})).1, moved);
    // What is not used is told.
    let more = zipped_with(&zip, "push/decision.toml", b"[]");
    let (value, _) = ask(&mut lab, &json!({"ask": "open", "name": "push.zip"}), &more);
    assert_eq!(value["ok"]["notes"], json!(["not used here, and not taken along: push/decision.toml"]));
    // Without a directory of its own: called as its zip.
    let flat = push_with("", "", str::to_owned);
    let (value, _) = ask(&mut lab, &json!({"ask": "open", "name": "mine.zip"}), &flat);
    assert_eq!(value["ok"]["scene"]["name"], "mine");
}

#[test]
fn uploads_are_bounded_and_errors_name_file_element_attribute_and_value() {
    let mut lab = Lab::default();
    let mut open = |bytes: &[u8]| refused(&mut lab, json!({"ask": "open", "name": "u.zip"}), bytes);
    for (bytes, words) in [
        (vec![0; 100], "u.zip: invalid Zip archive"),
        (vec![0; upload::LARGEST_ZIP + 1], "more than 50 MB"),
        (zipped(&[("a/b.xml", b"<a/>")]), "no Parameters.xml"),
        (zipped(&[("../Parameters.xml", b"<a/>")]), "leads out of it"),
        (
            zipped(&[("a/Parameters.xml", b"<a/>"), ("b/Parameters.xml", b"<a/>")]),
            "several Trials in it: a, b",
        ),
    ] {
        let said = open(&bytes);
        assert!(said.contains(words), "{said}");
    }
    // A megabyte of nothing in a kilobyte, in two files.
    let nothing = vec![b' '; 500_000];
    let bomb = zipped(&[("a/Parameters.xml", &nothing), ("a/b.xml", &nothing), ("a/c.xml", &nothing)]);
    let said = upload::open_within("u.zip", &bomb, 1_200_000).unwrap_err().0;
    assert!(said.contains("a/c.xml: it is larger than"), "{said}");
    let radius = push_with("P/", "static/Agents.xml", |text| text.replacen("Radius=\"", "Radius=\"-", 1));
    let said = open(&radius);
    for word in ["P/static/Agents.xml", "<Shape>", "Radius", "-0."] {
        assert!(said.contains(word), "{word}: {said}");
    }
    // A step of hours.
    let long =
        push_with("P/", "Parameters.xml", |text| text.replace("TimeStep=\"0.05\"", "TimeStep=\"5000\""));
    assert!(ask(&mut lab, &json!({"ask": "open", "name": "u.zip"}), &long).0.get("ok").is_some());
    let said = refused(&mut lab, json!({"ask": "advance", "run": 1, "steps": 1}), &[]);
    assert!(said.contains("TimeStep of 5000 s"), "{said}");
    let mut open = |bytes: &[u8]| refused(&mut lab, json!({"ask": "open", "name": "u.zip"}), bytes);
    let drive = push_with("P/", "drive.csv", |text| text.replace("0.02,0,", "0.02,Bob,"));
    let said = open(&drive);
    assert!(said.contains("P/drive.csv") && said.contains("no agent \"Bob\""), "{said}");
}

#[test]
fn requests_that_are_none_are_refused() {
    let mut lab = Lab::default();
    for request in [&b""[..], b"\xff\xff\xff\x7f{}", b"\x02\0\0\0{}", b"\x03\0\0\0{]}"] {
        let answer = answer(&mut lab, request, &mut |_| ControlFlow::Continue(()));
        assert!(String::from_utf8_lossy(&answer).contains("refused"));
    }
    assert!(refused(&mut lab, json!({"ask": "advance", "run": 0, "steps": 1}), &[]).contains("no Trial yet"));
    ok(&mut lab, json!({"ask": "example", "name": "door"}));
    assert!(
        refused(&mut lab, json!({"ask": "advance", "run": 1, "steps": 1001}), &[]).contains("at most 1000")
    );
    let short = json!({"ask": "take", "run": 1, "wanted": {"file": "fmu", "version": 2, "binaries": [["linux64", 5]]}});
    assert!(refused(&mut lab, short, b"1234").contains("shorter"));
    let many = json!({"ask": "crowd", "number": 40, "seed": 3, "room": [1.0, 1.0], "direction": null});
    let said = refused(&mut lab, many, &[]);
    assert!(said.contains("40 shapes") && said.contains("without overlap"), "{said}");
    assert!(refused(&mut lab, json!({"ask": "example", "name": "moon"}), &[]).contains("moon"));
}

/// Notes poses of five people.
struct Poses(Vec<Vec<[f64; 3]>>);

impl Observer<System> for Poses {
    type Error = Error;

    fn look(&mut self, system: &mut System, _: Reached) -> Result<(), Error> {
        let instance = &system.components()[0].instance;
        let quantities = ["Position.x", "Position.y", "Theta"];
        let names = (0..5).flat_map(|a| quantities.map(|quantity| format!("agent[{a}].{quantity}")));
        let selection = instance.select(names)?;
        let mut values = vec![0.0; selection.len()];
        instance.get_real(&selection, &mut values)?;
        self.0.push(values.chunks(3).map(|pose| [pose[0], pose[1], pose[2]]).collect());
        Ok(())
    }
}

/// Poses at the communication points after the first.
fn run(fmu: &Path, until: f64) -> Vec<Vec<[f64; 3]>> {
    let settings = Settings { until: Some(until), ..Settings::of(fmu.to_owned()) };
    let mut poses = Poses(Vec::new());
    assert!(Prepared::of(&settings).unwrap().simulate(&mut poses).unwrap().is_continue());
    poses.0
}
