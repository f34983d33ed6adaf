//! Uploads and files to keep.

use crate::*;
use lemons_core::files::source::LocalFiles;
use lemons_scenario::{MOST_PEOPLE, Scenario};
use std::collections::BTreeSet;
use std::io::Read as _;
use std::path::Path;

/// The files of the example "push" under a directory, one of them changed.
fn push_with(directory: &str, changed: &str, change: impl Fn(&str) -> String) -> Vec<u8> {
    let files = upload::EXAMPLES[0].1.iter().map(|(name, text)| {
        let text = if *name == changed { change(text) } else { (*text).to_owned() };
        (format!("{directory}{name}"), text)
    });
    zipped(&files.collect::<Vec<_>>())
}

#[test]
fn a_trial_that_is_taken_is_opened_again_with_its_drive() {
    let mut lab = Lab::default();
    let (scene, first) = ok(&mut lab, push());
    let (_, moved) = ok(&mut lab, advance(1, 9));
    let (name, zip) = ok(&mut lab, take(1, json!({"file": "trial"})));
    assert_eq!(name["name"], "push.zip");
    let archive = ZipArchive::new(Cursor::new(&zip)).unwrap();
    let names: BTreeSet<String> = archive.file_names().map(|name| name.unwrap().into_owned()).collect();
    let files = upload::EXAMPLES[0].1.iter().map(|(name, _)| format!("push/{name}"));
    assert_eq!(names, files.collect());
    let (value, bytes) = ask(&mut lab, &opened("push.zip", &zip), &zip);
    let mut known = scene["scene"].clone();
    known["run"] = 2.into();
    assert_eq!((&value["ok"]["scene"], &bytes), (&known, &first));
    assert_eq!(ok(&mut lab, advance(2, 9)).1, moved);
    // What is not used is told.
    let more = zipped_with(&zip, "push/notes.txt", b"[]");
    let notes = texts(&open(&mut lab, "push.zip", &more)["notes"]);
    assert_eq!(notes, ["not used here, and not taken along: push/notes.txt"]);
    // Without a directory of its own: called as its zip.
    let flat = push_with("", "", str::to_owned);
    assert_eq!(open(&mut lab, "mine.zip", &flat)["scene"]["name"], "mine");
}

#[test]
fn uploads_are_bounded_and_errors_name_file_element_attribute_and_value() {
    let mut lab = Lab::default();
    let mut message_of = |bytes: &[u8]| refused(&mut lab, opened("u.zip", bytes), bytes);
    for (bytes, words) in [
        (vec![0; 100], "u.zip: it is no zip: invalid Zip archive"),
        (vec![0; upload::LARGEST_UPLOAD + 1], "more than 50 MB"),
        (zipped(&[("a/b.xml", b"<a/>")]), "no Parameters.xml"),
        (zipped(&[("../Parameters.xml", b"<a/>")]), "leads out of it"),
        (
            zipped(&[("a/Parameters.xml", b"<a/>"), ("b/Parameters.xml", b"<a/>")]),
            "several Trials in it: a, b",
        ),
    ] {
        let message = message_of(&bytes);
        assert!(message.contains(words), "{message}");
    }
    // A megabyte of nothing in a kilobyte, in two files.
    let nothing = vec![b' '; 500_000];
    let bomb = zipped(&[("a/Parameters.xml", &nothing), ("a/b.xml", &nothing), ("a/c.xml", &nothing)]);
    let message = upload::open("u.zip", &[("u.zip", &bomb)], 1_200_000).unwrap_err().0;
    assert!(message.contains("a/c.xml: it is larger than"), "{message}");
    let radius = push_with("P/", "static/Agents.xml", |text| text.replacen("Radius=\"", "Radius=\"-", 1));
    let message = message_of(&radius);
    for word in ["P/static/Agents.xml", "<Shape>", "Radius", "-0."] {
        assert!(message.contains(word), "{word}: {message}");
    }
    let drive = push_with("P/", "drive.csv", |text| text.replace("0.02,0,", "0.02,Bob,"));
    let message = message_of(&drive);
    assert!(message.contains("P/drive.csv") && message.contains("no agent \"Bob\""), "{message}");
    // A step of hours.
    let long =
        push_with("P/", "Parameters.xml", |text| text.replace("TimeStep=\"0.05\"", "TimeStep=\"5000\""));
    open(&mut lab, "u.zip", &long);
    let message = refused(&mut lab, advance(1, 1), &[]);
    assert!(message.contains("TimeStep of 5000 s"), "{message}");
}

#[test]
fn a_folder_is_read_as_a_zip_is_and_one_without_parameters_gets_them() {
    let mut lab = Lab::default();
    let (known, _) = ok(&mut lab, push());
    let files = upload::EXAMPLES[0].1;
    let folder = |of: &[(&str, &str)]| {
        let list: Vec<Value> =
            of.iter().map(|(name, text)| json!([format!("push/{name}"), text.len()])).collect();
        let bytes: Vec<u8> = of.iter().flat_map(|(_, text)| text.bytes()).collect();
        (own(json!({"kind": "upload", "name": "push", "files": list})), bytes)
    };
    let (request, bytes) = folder(files);
    let (value, _) = ask(&mut lab, &request, &bytes);
    assert_eq!(value["ok"]["scene"]["agents"], known["scene"]["agents"], "{value}");
    // As the published platform gives it.
    let without: Vec<(&str, &str)> =
        files.iter().filter(|(name, _)| !["Parameters.xml", "drive.csv"].contains(name)).copied().collect();
    let (request, bytes) = folder(&without);
    let (value, _) = ask(&mut lab, &request, &bytes);
    let message = value["ok"]["notes"][0]["text"].as_str().unwrap_or_else(|| panic!("{value}"));
    assert!(message.contains("no Parameters.xml") && message.contains("0.01 s"), "{message}");
    assert_eq!(value["ok"]["scene"]["step"], 0.01);
    for directory in ["", "X & \"Y\"/"] {
        let name = |path: &str| format!("{directory}{}", path.rsplit('/').next().unwrap());
        let zip = zipped(&without.iter().map(|(path, text)| (name(path), *text)).collect::<Vec<_>>());
        let scene = &open(&mut lab, "platform.zip", &zip)["scene"];
        assert_eq!(scene["name"], "platform");
        assert_eq!(scene["agents"].as_array().unwrap().len(), 5);
    }
}

#[test]
fn disks_may_be_given_at_any_orientation() {
    let mut lab = Lab::default();
    let (known, _) = ok(&mut lab, push());
    let (_, moved) = ok(&mut lab, advance(1, 9));
    // A quarter turn of all disks: the same people.
    let turned = push_with("P/", "static/Agents.xml", |text| {
        let parts = text.split("Position=\"").enumerate().map(|(k, part)| {
            let Some((place, rest)) = part.split_once('"').filter(|_| k > 0) else { return part.to_owned() };
            let (x, y) = place.split_once(',').unwrap();
            let (x, y): (f64, f64) = (x.trim().parse().unwrap(), y.trim().parse().unwrap());
            format!("Position=\"{:?},{:?}\"{rest}", -y, x)
        });
        parts.collect::<String>()
    });
    let shown = open(&mut lab, "P.zip", &turned);
    let disks = |scene: &Value| -> Vec<f64> {
        let agents = scene["agents"].as_array().unwrap().iter();
        agents.flat_map(|agent| read::<Vec<[f64; 3]>>(&agent["disks"])).flatten().collect()
    };
    // Without legs there are no feet.
    let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-9 || a.is_nan() && b.is_nan();
    let close = |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(near);
    assert!(close(&disks(&shown["scene"]), &disks(&known["scene"])), "{shown}");
    let (_, again) = ok(&mut lab, advance(2, 9));
    assert!(close(&numbers(&again), &numbers(&moved)));
    let (cut, _) = ok(&mut lab, json!({"ask": "sections", "run": 2, "altitude": 1.4}));
    let outlines: Vec<Vec<Vec<[f64; 2]>>> = read(&cut["bodies"]);
    // Bodies are as broad as their disks: the first person's reach along y is that of the section.
    let reach = |numbers: Vec<f64>| numbers.into_iter().fold(0.0, f64::max);
    let broad: Vec<[f64; 3]> = read(&known["scene"]["agents"][0]["disks"]);
    let body: Vec<f64> = outlines[0].iter().flatten().map(|point| point[1]).collect();
    assert!((reach(broad.iter().map(|disk| disk[1] + disk[2]).collect()) - reach(body)).abs() < 0.02);
}

#[test]
fn pictures_bodies_and_measures_are_files() {
    let mut lab = Lab::default();
    let (_, frame) = ok(&mut lab, own(crowd(2, square(3.0, 3.0))));
    let values: Vec<u8> = [5.0_f64, 10.0].iter().flat_map(|value| value.to_le_bytes()).collect();
    let look = json!({"file": "svg", "range": [0.0, 10.0], "beyond": true, "from_grey": true, "label": "squeeze", "unit": "N", "time": 0.5, "forces": true});
    let look = take(1, look);
    let (name, svg) = ask(&mut lab, &look, &[frame.clone(), values].concat());
    let text = String::from_utf8(svg).unwrap();
    assert_eq!(name["ok"]["name"], "crowd_2_seed_3.svg");
    assert!(text.starts_with("<svg") && text.contains("squeeze"), "{}", &text[..200]);
    assert!(refused(&mut lab, look, &frame).contains("a frame of 2 people"));
    let (_, people) = ok(&mut lab, take(1, json!({"file": "population"})));
    assert_eq!(String::from_utf8(people).unwrap().lines().count(), 3);
    let (name, obj) = ask(&mut lab, &take(1, json!({"file": "mesh", "format": "obj"})), &frame);
    assert_eq!(name["ok"]["name"], "crowd_2_seed_3.obj");
    assert!(String::from_utf8(obj).unwrap().contains("g agent_1_left_leg"));
    let (_, stl) = ask(&mut lab, &take(1, json!({"file": "mesh", "format": "stl"})), &frame);
    let triangles = u32::from_le_bytes(stl[80..84].try_into().unwrap()) as usize;
    assert_eq!(stl.len(), 84 + 50 * triangles);
    assert!(numbers(&frame).len() == 2 * COLUMNS);
}

#[test]
fn changed_materials_of_things_wait_until_somebody_of_a_crowd_has_them() {
    let mut lab = Lab::default();
    let changed = |id: &str| {
        let contact = json!({"id1": "concrete", "id2": id, "gamma_normal": 10.0, "gamma_tangential": 20.0, "kinetic_friction": 0.25});
        json!({
            "time_step": null, "time_step_mechanical": null,
            "materials": [{"id": id, "young_modulus": 8e6, "shear_modulus": 2.5e6}], "contacts": [contact],
        })
    };
    let shown = |mix: Value, id: &str| {
        let mut wanted = own(with(crowd(6, square(5.0, 5.0)), "mix", mix));
        wanted["mechanics"] = changed(id);
        wanted
    };
    let of_frames = |scene: &Value| -> Vec<f64> {
        let all = scene["materials"].as_array().unwrap();
        all.iter().filter(|of| of["id"] == "frame").map(|of| of["young_modulus"].as_f64().unwrap()).collect()
    };
    let (all, _) = ok(&mut lab, shown(json!({"wheelchair": 1}), "frame"));
    assert_eq!(of_frames(&all["scene"]), [8e6]);
    let (nobody, _) = ok(&mut lab, shown(json!({"adult": 1}), "frame"));
    assert!(of_frames(&nobody["scene"]).is_empty());
    let message = refused(&mut lab, shown(json!({"adult": 1}), "steel"), &[]);
    assert!(message.contains("no material \"steel\""), "{message}");
    // Files of a Trial do not change by chance.
    let mut of_trial = push();
    of_trial["mechanics"] = changed("frame");
    assert!(refused(&mut lab, of_trial, &[]).contains("no material \"frame\""));
}

#[test]
fn materials_and_steps_are_changed_as_the_files_have_them() {
    let mut lab = Lab::default();
    let nothing = json!({"time_step": null, "time_step_mechanical": null, "materials": [], "contacts": []});
    let (before, _) = ok(&mut lab, push());
    let of = |scene: &Value, id: &str| {
        scene["materials"].as_array().unwrap().iter().find(|of| of["id"] == id).unwrap().clone()
    };
    assert_eq!(of(&before["scene"], "human_naked")["young_modulus"], 4e6);
    let mut wanted = push();
    let with = |key: &str, value: Value| {
        let mut mechanics = nothing.clone();
        mechanics[key] = value;
        mechanics
    };
    wanted["mechanics"] = json!({
        "time_step": 0.02, "time_step_mechanical": 5e-5,
        "materials": [{"id": "human_naked", "young_modulus": 8e6, "shear_modulus": 2.5e6}],
        // Their order does not matter.
        "contacts": [{"id1": "human_naked", "id2": "concrete", "gamma_normal": 10.0, "gamma_tangential": 20.0, "kinetic_friction": null}],
    });
    let (made, _) = ok(&mut lab, wanted.clone());
    assert_eq!((&made["scene"]["step"], &made["scene"]["mechanical_step"]), (&json!(0.02), &json!(5e-5)));
    assert!(made["scene"]["stable"].as_f64().unwrap() < before["scene"]["stable"].as_f64().unwrap());
    let zip = ok(&mut lab, take(2, json!({"file": "trial"}))).1;
    let materials = file_in(&zip, "Materials.xml");
    assert!(materials.contains("YoungModulus=\"8000000.0\" ShearModulus=\"2500000.0\""), "{materials}");
    assert!(
        materials.contains("GammaNormal=\"10.0\" GammaTangential=\"20.0\" KineticFriction=\"0.5\""),
        "{materials}"
    );
    let parameters = file_in(&zip, "Parameters.xml");
    assert!(parameters.contains("TimeStep=\"0.02\" TimeStepMechanical=\"5e-5\""), "{parameters}");
    // What is not changed stays to the last bit.
    let unchanged = ok(&mut lab, {
        wanted["mechanics"] = nothing.clone();
        wanted.clone()
    })
    .0;
    assert_eq!(unchanged["scene"]["materials"], before["scene"]["materials"]);
    // A step that is too long is warned of in the words of `lemons check`.
    wanted["mechanics"] = with("time_step_mechanical", json!(0.005));
    let warned = ok(&mut lab, wanted.clone()).0["scene"].take();
    let words = warned["warnings"][0]["text"].as_str().unwrap();
    assert!(words.contains("TimeStepMechanical=\"0.005\"") && words.contains("not stable"), "{words}");
    assert!(warned["longest"].as_f64() < Some(0.005) && warned["advised"] == 1e-4, "{warned}");
    for (key, value, words) in [
        ("time_step_mechanical", json!(0.5), "must be at most TimeStep"),
        ("time_step_mechanical", json!(0.0), "Parameters.xml"),
        (
            "materials",
            json!([{"id": "steel", "young_modulus": 1.0, "shear_modulus": 1.0}]),
            "no material \"steel\"",
        ),
        (
            "materials",
            json!([{"id": "human_naked", "young_modulus": 4e6, "shear_modulus": 5e5}]),
            "must be positive and finite",
        ),
        (
            "contacts",
            json!([{"id1": "concrete", "id2": "steel", "gamma_normal": 1.0, "gamma_tangential": 1.0, "kinetic_friction": null}]),
            "no contact of \"concrete\" and \"steel\"",
        ),
        (
            "contacts",
            json!([{"id1": "concrete", "id2": "human_naked", "gamma_normal": -1.0, "gamma_tangential": 1.0, "kinetic_friction": null}]),
            "GammaNormal=\"-1.0\"",
        ),
    ] {
        wanted["mechanics"] = with(key, value);
        let message = refused(&mut lab, wanted.clone(), &[]);
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn a_scenario_is_made_as_elsewhere() {
    for (stem, file) in lemons_testing::scenarios() {
        let (bytes, name) = (std::fs::read(&file).unwrap(), file.file_name().unwrap().to_str().unwrap());
        let base = json!({"kind": "upload", "name": name, "files": [[name, bytes.len()]]});
        let mut lab = Lab::default();
        ok_of(&mut lab, show(base, json!({"kind": "own"})), &bytes);
        let (_, zip) = ok(&mut lab, take(1, json!({"file": "trial"})));
        let scenario = Scenario::read(&LocalFiles, &file).unwrap();
        let mut watch = |_: &_| ControlFlow::Continue(());
        let made = scenario.documents(&stem, MOST_PEOPLE, &LocalFiles, &mut watch).unwrap();
        let mut expected = made.trial.texts(Path::new(&stem));
        expected.extend(
            made.beside().unwrap().into_iter().map(|(name, text)| (Path::new(&stem).join(name), text)),
        );
        let mut archive = ZipArchive::new(Cursor::new(zip)).unwrap();
        assert_eq!(archive.len(), expected.len(), "{name}");
        for (path, text) in expected {
            let mut own = String::new();
            archive.by_name(path.to_str().unwrap()).unwrap().read_to_string(&mut own).unwrap();
            assert_eq!(own, text, "{name}: {}", path.display());
        }
    }
}
