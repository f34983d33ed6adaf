//! What is wrong in a Trial is named with its file and line.

use crate::good::{FILES, INTERACTIONS, edited, good, put};
use crowd_mechanics::setup::{self};
use lemons_core::trial::*;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// What a reader may find without an error.
#[test]
fn latitude() {
    let [parameters, materials, geometry, agents, dynamics] = FILES;
    for (file, old, new) in [
        (parameters, "<Parameters>", "\u{feff}<?xml version=\"1.0\"?>\n<!-- x --><Parameters New='1'><New/>"),
        (parameters, "\"0.05\"", "\" 0.05\n\""),
        (materials, "\"1230\"", "\"0\""),
        (geometry, "<Dimensions Lx=\"4\" Ly=\"2\"/>", ""),
        (geometry, "\"4,2\"", "\" 4 ,\t2 \""),
        (agents, "Type=\"pedestrian\" ", ""),
        (agents, "Id=\"Ann\"", "Id=\"Ann\" Colour=\"red\""),
        (agents, "0,-0.1\"/>", "0,-0.1\"><Deep/></Shape><Hat/>"),
        (dynamics, "</Agents>", "<Bicycle Id='1'/>\n</Agents>"),
    ] {
        let read = edited(&[(file, old, new)]);
        let told =
            |warnings: &Problems| warnings.iter().all(|warning| warning.message.contains("is not read"));
        assert!(matches!(&read, Ok((_, warnings)) if told(warnings)), "{old} -> {new}: {read:?}");
    }
    // One mechanical step in each decisional loop is allowed, and warned of.
    let (_, warnings) = edited(&[(parameters, "1e-5", "0.05")]).unwrap();
    assert!(warnings.to_string().contains("TimeStepMechanical"), "{warnings}");
}

#[test]
fn every_mistake_is_named_with_its_line() {
    let number = "must be a finite decimal number";
    let table = include_str!("mistakes.txt").lines().filter(|line| !line.starts_with('#'));
    let table: Vec<Vec<&str>> = table.map(|line| line.split(" | ").collect()).collect();
    assert!(table.len() >= 80);
    for row in table {
        let [file, old, new, message] = row[..] else { panic!("{row:?}") };
        let problems =
            edited(&[(file, old, new)]).expect_err(&format!("{file}: {old} -> {new} was accepted"));
        let text = problems.to_string();
        let expected = format!("{}{message}", Path::new(file).display());
        assert!(text.contains(&expected), "{file}: {old} -> {new}:\n{text}\nexpected: {expected}");
    }
    // Every number and pair of numbers says the same of nonsense.
    for (file, text) in good() {
        for (start, _) in
            text.match_indices("=\"").filter(|(at, _)| text[at + 2..].starts_with(|c: char| c.is_numeric()))
        {
            let value = &text[start + 2..start + 2 + text[start + 2..].find('"').unwrap()];
            let wrong = format!("{}=\"x{value}\"{}", &text[..start], &text[start + 3 + value.len()..]);
            let problems = edited(&[(file, &text, &wrong)]).unwrap_err();
            let problem = problems.iter().next().unwrap();
            let expected = [number, "must be two finite decimal", "must be the place"];
            assert!(
                expected.iter().any(|part| problem.message.starts_with(part)),
                "{file} {value}: {problems}"
            );
            assert_eq!(problem.value, Some(format!("x{value}")));
            let line = 1 + text[..start].matches('\n').count();
            assert_eq!(problem.line, u32::try_from(line).ok(), "{problem}");
        }
    }
}

#[test]
fn a_wrong_root_or_nobody_in_it_is_named() {
    for (file, text) in good() {
        let problems = edited(&[(file, &text, "<Crowd/>")]).unwrap_err().to_string();
        assert!(problems.contains(&format!("{file}:1: <Crowd>: the root element must be <")), "{problems}");
    }
    let (agents, text) = &good()[3];
    let problems = edited(&[(agents, text, "<Agents/>")]).unwrap_err().to_string();
    assert!(problems.contains("Agents.xml:1: <Agents>: has no <Agent>"), "{problems}");
}

#[test]
fn a_pair_that_cannot_touch_needs_no_contact() {
    let [_, materials, _, agents, _] = FILES;
    let skin_on_skin = good()[1].1.lines().nth(7).unwrap().to_owned();
    let leather = "<Material Id='leather' YoungModulus='4e6' ShearModulus='1.4e6'/></Intrinsic>";
    let on_wall = "<Contact Id1='concrete' Id2='leather' GammaNormal='1' GammaTangential='1' KineticFriction='0'/></Binary>";
    let with_skin = "<Contact Id1='leather' Id2='skin' GammaNormal='1' GammaTangential='1' KineticFriction='0'/></Binary>";
    // Ann in skin alone, Bob in leather alone: neither meets one's like.
    let apart = [
        (materials, skin_on_skin.as_str(), ""),
        (materials, "</Intrinsic>", leather),
        (materials, "</Binary>", on_wall),
        (materials, "</Binary>", with_skin),
        (agents, "Radius=\"0.25\" MaterialId=\"skin\"", "Radius=\"0.25\" MaterialId=\"leather\""),
    ];
    edited(&apart).unwrap_or_else(|problems| panic!("{problems}"));
    // A disk of leather on Ann meets Bob's.
    let met = [&apart[..], &[(agents, "\"skin\"", "\"leather\"")]].concat();
    let problems = edited(&met).unwrap_err().to_string();
    assert!(problems.contains("no <Contact> of \"leather\" and \"leather\""), "{problems}");
    assert_eq!(problems.lines().count(), 1, "{problems}");
}

#[test]
fn all_mistakes_are_reported_at_once() {
    let [parameters, materials, geometry, agents, dynamics] = FILES;
    let problems = edited(&[
        (parameters, "0.05", "x"),
        (materials, "\"0.4\"", "\"-1\""),
        (geometry, "4,2", "4"),
        (agents, "\"0.22\"", "\"-0.1\""),
        (agents, "\"63\"", "\"0\""),
        (dynamics, "Id=\"Bob\"", "Id=\"Eve\""),
        (INTERACTIONS, "\"room\"", "\"roof\""),
    ])
    .unwrap_err();
    // Eve is one too many and Bob is missing.
    assert_eq!(problems.errors().count(), 8, "{problems}");
}

#[test]
fn a_face_drawn_twice_is_a_warning() {
    let (_, warnings) = edited(&[(
        FILES[2],
        "<Corner Coordinates=\"2,1.5\"/>",
        "<Corner Coordinates=\"2,1.5\"/>\n<Corner Coordinates=\"1,1\"/>",
    )])
    .unwrap();
    let text = warnings.to_string();
    assert!(
        text.starts_with("warning: ")
            && text.contains(
                "Geometry.xml: wall \"bar\" from 1.0,1.0 to 2.0,1.5 and wall \"bar\" from 2.0,1.5 to 1.0,1.0"
            ),
        "{text}"
    );
    assert_eq!((warnings.warnings().count(), warnings.has_errors()), (1, false));
}

#[test]
fn a_missing_file_is_named_unless_it_is_the_interactions() {
    for (missing, _) in good() {
        let directory = TempDir::new().unwrap();
        put(directory.path(), &good());
        fs::remove_file(directory.path().join(missing)).unwrap();
        let read = setup::read(directory.path());
        if missing == INTERACTIONS {
            assert_eq!(read.unwrap().0.interactions, Interactions::default());
        } else {
            let text = read.unwrap_err().to_string();
            let path = directory.path().join(missing);
            assert_eq!(text.lines().count(), 1, "{text}");
            assert!(text.starts_with(&format!("{}: cannot be read", path.display())), "{text}");
        }
    }
    let nowhere = setup::read(Path::new("no such directory")).unwrap_err().to_string();
    assert!(nowhere.contains("Parameters.xml: cannot be read"), "{nowhere}");
}

/// A misspelt `<Dynamics>` left its agent without a drive, and nobody said so.
#[test]
fn what_nobody_reads_is_warned_of_once_for_each_name() {
    let of = |edits: &[(&str, &str, &str)]| -> Vec<String> {
        let (_, warnings) = edited(edits).unwrap();
        let message = |warning: &Problem| warning.to_string().split_once(".xml:").unwrap().1.to_owned();
        warnings.iter().map(message).collect()
    };
    let (agents, dynamics) = ("static/Agents.xml", "dynamic/AgentDynamics.xml");
    assert_eq!(
        of(&[(dynamics, "<Dynamics", "<Dynamcs")]),
        ["7: <Dynamcs>: is not read in <Agent>; is <Dynamics> meant?"]
    );
    assert_eq!(
        of(&[(agents, "Height=\"1.8\"", "Heigth=\"1.8\"")]),
        ["2: <Agent> Heigth=\"1.8\": is not read; is Height meant?"]
    );
    assert_eq!(
        of(&[(agents, "Radius", "Colour=\"red\" Radius"), (agents, "\"0.22\"", "\"0.22\" Colour=\"blue\"")]),
        ["3: <Shape> Colour=\"red\": is not read (2 times)"]
    );
    assert_eq!(
        of(&[("static/Geometry.xml", "<Dimensions", "<Note>a b</Note>wide <Dimensions")]),
        ["2: <Note>: is not read in <Geometry>", "2: <Geometry>: the text in it is not read: \"wide\""]
    );
    // Namespaces are others' words, and comments nobody's.
    let schema = "<Agents xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:schemaLocation=\"a.xsd\" \
                  xmlns:my=\"urn:my\"><!-- a <Shap> --><my:Note of=\"\"/>";
    assert_eq!(of(&[(agents, "<Agents>", schema)]), [""; 0]);
    // A name for each of many elements.
    let many: String = (0..100).map(|k| format!("<Note{k}/>")).collect();
    let (_, warnings) = edited(&[(agents, "<Agents>", &format!("<Agents>{many}"))]).unwrap();
    assert!(warnings.to_string().ends_with("more than 20 names of attributes and elements are not read"));
    assert_eq!(warnings.iter().count(), 21);
}
