//! What is wrong in a Trial is named with its file and line.

use crate::good::{FILES, INTERACTIONS, edited, good, put};
use crowd_mechanics::setup::{self};
use lemons_trial::*;
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
    let [parameters, materials, geometry, agents, dynamics] = FILES;
    let number = "must be a finite decimal number";
    let mistakes: &[(&str, &str, &str, &str)] = &[
        (parameters, "<Parameters>", "<Foo>", ":4: is not well-formed XML"),
        (parameters, "Directories ", "Folders ", ":1: <Parameters>: has no <Directories>"),
        (parameters, "Static=", "Static_=", ":2: <Directories> Static: is missing"),
        (parameters, "\"./static/\"", "\" \"", ":2: <Directories> Static=\" \": must not be empty"),
        (parameters, "Dynamic=", "Dyn=", ":2: <Directories> Dynamic: is missing"),
        (parameters, "<Times ", "<Tmes ", ":1: <Parameters>: has no <Times>"),
        (
            parameters,
            "</Param",
            "<Times/></Param",
            ":4: <Times>: duplicate element, first used at line 3; it may appear only once",
        ),
        (parameters, "</Param", "<Directories/></Param", ":4: <Directories>: duplicate element"),
        (parameters, "0.05", "-0.05", ":3: <Times> TimeStep=\"-0.05\": must be positive"),
        (parameters, "0.05", "nan", ":3: <Times> TimeStep=\"nan\": must be a finite decimal number"),
        (parameters, "1e-5", "0", ":3: <Times> TimeStepMechanical=\"0\": must be positive"),
        (
            parameters,
            "1e-5",
            "0.06",
            ":3: <Times> TimeStepMechanical=\"0.06\": must be at most TimeStep, 0.05",
        ),
        (materials, "<Intrinsic>", "<Intrinsic/><Intrinsic>", ":2: <Intrinsic>: duplicate element"),
        (materials, "<Binary>", "<Binary/><Binary>", ":6: <Binary>: duplicate element"),
        (
            materials,
            "Id=\"skin\"",
            "Id=\"concrete\"",
            ":4: <Material> Id=\"concrete\": duplicate Id, first used at line 3",
        ),
        (materials, "Id=\"skin\"", "Id=\"\"", ":4: <Material> Id=\"\": must not be empty"),
        (materials, "Id=\"skin\"", "", ":4: <Material> Id: is missing"),
        (materials, "4e6", "0", ":4: <Material> YoungModulus=\"0\": must be positive"),
        (materials, "4e6", "inf", ":4: <Material> YoungModulus=\"inf\": must be a finite decimal number"),
        (materials, "7.1e8", "-1", ":3: <Material> ShearModulus=\"-1\": must be positive"),
        (materials, "Id1=\"skin\"", "Id1=\"fur\"", ":8: <Contact> Id1=\"fur\": there is no such material"),
        (
            materials,
            "Id1=\"skin\"",
            "Id1=\"fur\"",
            ":6: <Binary>: no <Contact> of \"skin\" and \"skin\", which can touch",
        ),
        (materials, "Id2=\"skin\"", "Id2=\"fur\"", ":6: <Binary>: no <Contact> of \"concrete\" and \"skin\""),
        (
            materials,
            "</Binary>",
            "<Contact Id1='skin' Id2='concrete' GammaNormal='1' GammaTangential='1' KineticFriction='0'/></Binary>",
            ":9: <Contact>: duplicate pair \"skin\" and \"concrete\", first given at line 7",
        ),
        (materials, "\"1230\"", "\"-1\"", ":7: <Contact> GammaNormal=\"-1\": must not be negative"),
        (materials, "\"701\"", "\"0x1\"", ":8: <Contact> GammaTangential=\"0x1\": must be a finite"),
        (materials, "\"0.4\"", "\"-0.4\"", ":8: <Contact> KineticFriction=\"-0.4\": must not be negative"),
        (
            materials,
            "4e6",
            "6e6",
            ":4: <Material>: \"skin\" (YoungModulus 6000000.0, ShearModulus 1379310.3) and \"skin\"",
        ),
        (geometry, "<Dimensions", "<Dimensions/><Dimensions", ":2: <Dimensions>: duplicate element"),
        (geometry, "Lx=\"4\"", "", ":2: <Dimensions> Lx: is missing"),
        (geometry, "Id=\"bar\"", "Id=\"room\"", ":9: <Wall> Id=\"room\": duplicate Id, first used at line 3"),
        (geometry, "\"concrete\"", "\"jelly\"", ":3: <Wall> MaterialId=\"jelly\": there is no such material"),
        (
            geometry,
            "<Corner Coordinates=\"1,1\"/>",
            "",
            ":9: <Wall>: wall \"bar\" has 1 corners: it needs two",
        ),
        (
            geometry,
            "2,1.5",
            "1,1",
            ":11: <Corner> Coordinates=\"1,1\": corner 1 of wall \"bar\" is where corner 0 is",
        ),
        (
            geometry,
            "2,1.5",
            "2;1.5",
            ":11: <Corner> Coordinates=\"2;1.5\": must be two finite decimal numbers",
        ),
        (
            geometry,
            "2,1.5",
            "2,1.5,3",
            ":11: <Corner> Coordinates=\"2,1.5,3\": must be two finite decimal numbers",
        ),
        (geometry, "Coordinates=\"1,1\"", "", ":10: <Corner> Coordinates: is missing"),
        (
            geometry,
            "2,1.5",
            "2,-1e155",
            ":11: <Corner> Coordinates=\"2,-1e155\": x and y must be from -1e9 to 1e9 m",
        ),
        (
            geometry,
            "Id=\"room\"",
            "Id=\"room \"",
            ":3: <Wall> Id=\"room \": must not begin or end with white space",
        ),
        (
            agents,
            "pedestrian",
            "bike",
            ":2: <Agent> Type=\"bike\": agent \"Ann\": the mechanics takes pedestrians only",
        ),
        (agents, "Id=\"Bob\"", "Id=\"Ann\"", ":6: <Agent> Id=\"Ann\": duplicate Id, first used at line 2"),
        (agents, "Mass=\"63\"", "", ":6: <Agent> Mass: is missing"),
        (agents, "\"63\"", "\"0\"", ":6: <Agent> Mass=\"0\": must be positive"),
        (agents, "\"1.8\"", "\"-1.8\"", ":2: <Agent> Height=\"-1.8\": must be positive"),
        (agents, "\"1.02\"", "\"-0\"", ":6: <Agent> MomentOfInertia=\"-0\": must be positive"),
        (agents, "\"4.5\"", "\"-4.5\"", ":2: <Agent> FloorDamping=\"-4.5\": must not be negative"),
        (agents, "\"4.25\"", "\"-1\"", ":2: <Agent> AngularDamping=\"-1\": must not be negative"),
        (agents, "\"0.22\"", "\"-0.1\"", ":4: <Shape> Radius=\"-0.1\": must be positive"),
        (agents, "\"0.22\"", "\"0.22 m\"", ":4: <Shape> Radius=\"0.22 m\": must be a finite decimal number"),
        (agents, "\"disk\"", "\"square\"", ":3: <Shape> Type=\"square\": must be \"disk\""),
        (agents, "Type=\"disk\"", "", ":3: <Shape> Type: is missing"),
        (agents, "\"skin\"", "\"fur\"", ":3: <Shape> MaterialId=\"fur\": there is no such material"),
        (agents, "0,-0.1", "0,1e300", ":4: <Shape> Position=\"0,1e300\": x and y must be from -1e9 to"),
        (agents, "Id=\"Bob\"", "Id=\" Bob\"", ":6: <Agent> Id=\" Bob\": must not begin or end with white"),
        (agents, "0,-0.1", "0", ":4: <Shape> Position=\"0\": must be two finite decimal numbers"),
        (
            agents,
            "<Shape Type=\"disk\" Radius=\"0.25\" MaterialId=\"skin\" Position=\"0,0\"/>",
            "",
            ":6: <Agent>: agent \"Bob\" has no <Shape>",
        ),
        (dynamics, "Id=\"Bob\"", "Id=\"Eve\"", ":2: <Agent> Id=\"Eve\": there is no such agent"),
        (dynamics, "Id=\"Bob\"", "Id=\"Eve\"", ":1: <Agents>: has no <Agent> of Id \"Bob\""),
        (
            dynamics,
            "Id=\"Ann\"",
            "Id=\"Bob\"",
            ":5: <Agent> Id=\"Bob\": duplicate agent, first given at line 2",
        ),
        (dynamics, "<Kinematics ", "<Kin ", ":2: <Agent>: has no <Kinematics>"),
        (dynamics, "<Dynamics ", "<Dynamics/><Dynamics ", ":7: <Dynamics>: duplicate element"),
        (dynamics, "2.5,0.5", "2.5,nan", ":3: <Kinematics> Position=\"2.5,nan\": must be two finite"),
        (dynamics, "2.5,0.5", "2.5,2e9", ":3: <Kinematics> Position=\"2.5,2e9\": x and y must be from"),
        (dynamics, "0,1", "0 1", ":3: <Kinematics> Velocity=\"0 1\": must be two finite"),
        (dynamics, "Theta=\"0.5\"", "", ":3: <Kinematics> Theta: is missing"),
        (dynamics, "-0.25", "1e400", ":3: <Kinematics> Omega=\"1e400\": must be a finite decimal number"),
        (dynamics, "Fp=", "fp=", ":7: <Dynamics> Fp: is missing"),
        (dynamics, "0.125", "", ":7: <Dynamics> Mp=\"\": must be a finite decimal number"),
        (INTERACTIONS, "Id=\"Bob\"", "Id=\"Eve\"", ":2: <Agent> Id=\"Eve\": there is no such agent"),
        (INTERACTIONS, "Id=\"Ann\"", "Id=\"Eve\"", ":3: <Agent> Id=\"Eve\": there is no such agent"),
        (INTERACTIONS, "Id=\"Ann\"", "Id=\"Bob\"", ":3: <Agent> Id=\"Bob\": an agent does not touch itself"),
        (
            INTERACTIONS,
            "ParentShape=\"0\"",
            "ParentShape=\"1\"",
            ":4: <Interaction> ParentShape=\"1\": must be the place of",
        ),
        (
            INTERACTIONS,
            "ChildShape=\"1\"",
            "ChildShape=\"-1\"",
            ":4: <Interaction> ChildShape=\"-1\": must be the place of",
        ),
        (INTERACTIONS, "3,4", "3,inf", ":4: <Interaction> Fn=\"3,inf\": must be two finite"),
        (INTERACTIONS, "Ft=\"5,6\"", "", ":4: <Interaction> Ft: is missing"),
        (INTERACTIONS, "\"room\"", "\"roof\"", ":6: <Wall> WallId=\"roof\": there is no such wall"),
        (
            INTERACTIONS,
            "CornerId=\"2\"",
            "CornerId=\"3\"",
            ":6: <Wall> CornerId=\"3\": must be the place of one of the 3 faces",
        ),
        (INTERACTIONS, "ShapeId=\"0\"", "ShapeId=\"9\"", ":6: <Wall> ShapeId=\"9\": must be the place of"),
        (
            INTERACTIONS,
            "\"7,8\"",
            "\"7\"",
            ":6: <Wall> TangentialRelativeDisplacement=\"7\": must be two finite",
        ),
        (
            INTERACTIONS,
            "</Interactions>",
            "<Agent Id='Ann'><Agent Id='Bob'>\
             <Interaction ParentShape='1' ChildShape='0' TangentialRelativeDisplacement='0,0' Fn='0,0' Ft='0,0'/>\
             </Agent></Agent></Interactions>",
            ":8: <Interaction>: duplicate contact, first given at line 4",
        ),
    ];
    for &(file, old, new, message) in mistakes {
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
fn a_wrong_root_is_named() {
    for (file, text) in good() {
        let problems = edited(&[(file, &text, "<Crowd/>")]).unwrap_err().to_string();
        assert!(problems.contains(&format!("{file}:1: <Crowd>: the root element must be <")), "{problems}");
    }
}

#[test]
fn nobody_is_an_error() {
    let files = good();
    let problems = edited(&[(FILES[3], &files[3].1, "<Agents/>")]).unwrap_err().to_string();
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
            && text.contains("Geometry.xml:12: <Corner> Coordinates=\"1,1\": wall \"bar\""),
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

/// Only "Radius: is missing" was said.
#[test]
fn a_misspelt_name_is_told_where_the_right_one_is_missing() {
    let agents = "static/Agents.xml";
    for (file, old, new, said) in [
        (
            agents,
            "Radius",
            "Raduis",
            "Agents.xml:3: <Shape> Radius: is missing; there is \"Raduis\": is it misspelt?",
        ),
        (
            agents,
            "Mass=",
            "mass=",
            "Agents.xml:2: <Agent> Mass: is missing; there is \"mass\": is it misspelt?",
        ),
        (
            "static/Materials.xml",
            "YoungModulus",
            "YoungsModulus",
            "Materials.xml:3: <Material> YoungModulus: is missing; there is \"YoungsModulus\": is it misspelt?",
        ),
        (
            "Parameters.xml",
            "<Times",
            "<Tmies",
            "Parameters.xml:1: <Parameters>: has no <Times>; there is <Tmies>: is it misspelt?",
        ),
        (
            "dynamic/AgentDynamics.xml",
            "<Kinematics",
            "<Kinematic",
            "AgentDynamics.xml:2: <Agent>: has no <Kinematics>; there is <Kinematic>: is it misspelt?",
        ),
        // What is known is not another one misspelt.
        ("static/Geometry.xml", " Lx=\"4\"", "", "Geometry.xml:2: <Dimensions> Lx: is missing"),
    ] {
        let problems = edited(&[(file, old, new)]).unwrap_err();
        let lines: Vec<String> = problems.iter().map(ToString::to_string).collect();
        assert!(lines.len() == 1 && lines[0].ends_with(said), "{said}\n{problems}");
    }
}

/// A misspelt `<Dynamics>` left its agent without a drive, and nobody said so.
#[test]
fn what_nobody_reads_is_warned_of_once_for_each_name() {
    let of = |edits: &[(&str, &str, &str)]| -> Vec<String> {
        let (_, warnings) = edited(edits).unwrap();
        let said = |warning: &Problem| warning.to_string().split_once(".xml:").unwrap().1.to_owned();
        warnings.iter().map(said).collect()
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
