//! The Trial directory, read, checked and written.

use crowd_mechanics::engine::{Vec2, vec2};
use crowd_mechanics::setup::WorldError;
use crowd_mechanics::setup::{self, Setup};
use lemons_testing::{shared, trial_push as paper};
use lemons_trial::*;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

const FILES: [&str; 5] = [
    "Parameters.xml",
    "static/Materials.xml",
    "static/Geometry.xml",
    "static/Agents.xml",
    "dynamic/AgentDynamics.xml",
];
const INTERACTIONS: &str = "dynamic/AgentInteractions.xml";

/// Two agents of one disk in a room; each file short enough to know its lines.
fn good() -> Vec<(&'static str, String)> {
    let texts = [
        r#"<Parameters>
    <Directories Static="./static/" Dynamic="dynamic"/>
    <Times TimeStep="0.05" TimeStepMechanical="1e-5"/>
</Parameters>"#,
        r#"<Materials>
    <Intrinsic>
        <Material Id="concrete" YoungModulus="1.7e9" ShearModulus="7.1e8"/>
        <Material Id="skin" YoungModulus="4e6" ShearModulus="1379310.3"/>
    </Intrinsic>
    <Binary>
        <Contact Id1="concrete" Id2="skin" GammaNormal="1230" GammaTangential="1231" KineticFriction="0.5"/>
        <Contact Id1="skin" Id2="skin" GammaNormal="700" GammaTangential="701" KineticFriction="0.4"/>
    </Binary>
</Materials>"#,
        r#"<Geometry>
    <Dimensions Lx="4" Ly="2"/>
    <Wall Id="room" MaterialId="concrete">
        <Corner Coordinates="0,0"/>
        <Corner Coordinates="4,0"/>
        <Corner Coordinates="4,2"/>
        <Corner Coordinates="0,0"/>
    </Wall>
    <Wall Id="bar" MaterialId="concrete">
        <Corner Coordinates="1,1"/>
        <Corner Coordinates="2,1.5"/>
    </Wall>
</Geometry>"#,
        r#"<Agents>
    <Agent Type="pedestrian" Id="Ann" Mass="89" Height="1.8" MomentOfInertia="1.85" FloorDamping="4.5" AngularDamping="4.25">
        <Shape Type="disk" Radius="0.21" MaterialId="skin" Position="0,0.1"/>
        <Shape Type="disk" Radius="0.22" MaterialId="skin" Position="0,-0.1"/>
    </Agent>
    <Agent Id="Bob" Mass="63" MomentOfInertia="1.02" FloorDamping="0" AngularDamping="0">
        <Shape Type="disk" Radius="0.25" MaterialId="skin" Position="0,0"/>
    </Agent>
</Agents>"#,
        r#"<Agents>
    <Agent Id="Bob">
        <Kinematics Position="2.5,0.5" Velocity="0,1" Theta="0.5" Omega="-0.25"/>
    </Agent>
    <Agent Id="Ann">
        <Kinematics Position="3.1,0.6" Velocity="-1,0" Theta="3" Omega="0.75"/>
        <Dynamics Fp="-160,1" Mp="0.125"/>
    </Agent>
</Agents>"#,
        r#"<Interactions>
    <Agent Id="Bob">
        <Agent Id="Ann">
            <Interaction ParentShape="0" ChildShape="1" TangentialRelativeDisplacement="1,2" Fn="3,4" Ft="5,6"/>
        </Agent>
        <Wall ShapeId="0" WallId="room" CornerId="2" TangentialRelativeDisplacement="7,8" Fn="9,10" Ft="11,12"/>
    </Agent>
</Interactions>"#,
    ];
    FILES.into_iter().chain([INTERACTIONS]).zip(texts.map(str::to_owned)).collect()
}

fn put(directory: &Path, files: &[(&str, String)]) {
    for (file, text) in files {
        let path = directory.join(file);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
}

/// What reading the good Trial says after the first occurrence of `old` in `file` became `new`.
fn edited(edits: &[(&str, &str, &str)]) -> Result<(Trial, Problems), Problems> {
    let mut files = good();
    for &(file, old, new) in edits {
        let (_, text) = files.iter_mut().find(|(name, _)| *name == file).unwrap();
        assert!(text.contains(old), "{file} has no {old}");
        *text = text.replacen(old, new, 1);
    }
    let directory = TempDir::new().unwrap();
    put(directory.path(), &files);
    setup::read(directory.path())
}

/// The same Trial but for where it lies.
fn moved(trial: &Trial, to: &Trial) -> Trial {
    Trial { name: to.name.clone(), directory: to.directory.clone(), ..trial.clone() }
}

#[test]
fn the_paper_s_trial_reads_and_round_trips() {
    let (trial, warnings) = setup::read(&paper()).unwrap();
    assert!(warnings.is_empty(), "{warnings}");
    assert_eq!(trial.name, "Trial_push");
    assert_eq!((trial.parameters.time_step, trial.parameters.time_step_mechanical), (0.05, 2e-6));
    assert_eq!((trial.materials.intrinsic.len(), trial.materials.binary.len()), (3, 6));
    assert_eq!(trial.geometry.dimensions, Some(vec2(2.052675, 1.11766)));
    assert_eq!(trial.geometry.walls[0].corners.len(), 5);
    assert_eq!((trial.agents.len(), trial.dynamics.len()), (5, 5));
    assert_eq!(trial.agents[2].shapes[4].position, vec2(-0.013986, -0.168086));
    assert_eq!(trial.dynamics[4].position, vec2(1.448, 0.012));

    let copy = TempDir::new().unwrap();
    trial.write(copy.path()).unwrap();
    let (back, _) = setup::read(copy.path()).unwrap();
    assert_eq!(back, moved(&trial, &back));
    assert!(!copy.path().join(INTERACTIONS).exists());
}

#[test]
fn the_good_trial_is_good() {
    let (trial, warnings) = edited(&[]).unwrap();
    assert!(warnings.is_empty(), "{warnings}");
    // The order of Agents.xml, not of AgentDynamics.xml.
    assert_eq!(trial.dynamics[0].fp, vec2(-160.0, 1.0));
    assert_eq!((trial.dynamics[1].fp, trial.dynamics[1].mp), (Vec2::ZERO, 0.0));
    assert_eq!((&trial.agents[1].kind, trial.agents[1].height), (&None, None));
    // Written from Bob's side, kept from Ann's.
    let contact = &trial.interactions.agents[0];
    let place = (contact.parent, contact.child, contact.parent_shape, contact.child_shape);
    assert_eq!(place, (0, 1, 1, 0));
    let force =
        ContactForce { elongation: vec2(-1.0, -2.0), normal: vec2(-3.0, -4.0), tangential: vec2(-5.0, -6.0) };
    assert_eq!(contact.force, force);
    let wall = &trial.interactions.walls[0];
    assert_eq!((wall.agent, wall.shape, wall.wall, wall.corner), (1, 0, 0, 2));
    assert_eq!(wall.force.normal, vec2(9.0, 10.0));
}

#[test]
fn the_shared_trials_read() {
    let Some(shared) = shared("") else { return };
    for (name, agents) in [("push_wed/Trial", 5), ("crowds/dense_100", 100), ("crowds/sparse_100", 100)] {
        let (trial, _) = setup::read(&shared.join(name)).unwrap_or_else(|problems| panic!("{problems}"));
        assert_eq!(trial.agents.len(), agents, "{name}");
        let copy = TempDir::new().unwrap();
        trial.write(copy.path()).unwrap();
        let (back, _) = setup::read(copy.path()).unwrap();
        assert_eq!(back, moved(&trial, &back));
    }
    let push = setup::read(&shared.join("push_wed/Trial")).unwrap().0;
    let paper = setup::read(&paper()).unwrap().0;
    assert_eq!(push, moved(&paper, &push));
}

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

/// `count` agents of five disks, all at the origin, as where their positions were forgotten.
fn all_at_one_point(count: usize) -> Result<(Trial, Problems), Problems> {
    let directory = TempDir::new().unwrap();
    lemons_bench::fmu::write_trial(count, vec2(0.5, 0.5), directory.path()).unwrap();
    let file = directory.path().join(FILES[4]);
    let positions = fs::read_to_string(&file).unwrap();
    let forgotten: String = positions
        .split_inclusive("Position=\"")
        .enumerate()
        .map(
            |(k, part)| {
                if k == 0 { part.to_owned() } else { format!("0,0{}", &part[part.find('"').unwrap()..]) }
            },
        )
        .collect();
    fs::write(file, forgotten).unwrap();
    setup::read(directory.path())
}

/// Twelve pairs of disks for each two agents: three thousand would take 25 GB.
#[test]
fn everybody_at_one_point_is_refused_by_name_before_memory_is_taken() {
    for count in [1000, 3000] {
        let problems = all_at_one_point(count).unwrap_err().to_string();
        assert_eq!(problems.lines().count(), 1, "{problems}");
        let words = [
            "AgentDynamics.xml: agent \"0\": ",
            &format!("{} others and ", count - 1),
            "more than 2000000 pairs",
            "are positions missing?",
        ];
        assert!(words.iter().all(|word| problems.contains(word)), "{problems}");
    }
    // Few enough are held, and counted in one line.
    let (trial, warnings) = all_at_one_point(200).unwrap();
    assert!(Setup::of(&trial).world().is_ok());
    assert!(warnings.to_string().contains("pairs of disks of different agents overlap"), "{warnings}");
    assert!(warnings.iter().count() <= 4, "{warnings}");
}

/// The same by parameters, after the Trial was read.
#[test]
fn everybody_moved_to_one_point_makes_no_world() {
    let directory = TempDir::new().unwrap();
    lemons_bench::fmu::write_trial(1000, vec2(0.5, 0.5), directory.path()).unwrap();
    let (mut trial, _) = setup::read(directory.path()).unwrap();
    for dynamics in &mut trial.dynamics {
        dynamics.position = vec2(1.0, 1.0);
    }
    let error = Setup::of(&trial).world().unwrap_err();
    assert!(
        matches!(&error, WorldError::Crowded { agent, crowded } if agent == "0" && crowded.others == 999),
        "{error}"
    );
}

/// A body of one disk for each material, and all their contacts but the last `missing`.
fn of_materials(count: usize, missing: usize) -> Result<(Trial, Problems), Problems> {
    let directory = TempDir::new().unwrap();
    let mut files = good();
    let each = |text: &dyn Fn(usize) -> String| (0..count).map(text).collect::<String>();
    let pairs = (0..count).flat_map(|a| (a..count).map(move |b| (a, b)));
    let contacts: Vec<String> = pairs
        .map(|(a, b)| {
            format!(
                r#"<Contact Id1="m{a}" Id2="m{b}" GammaNormal="1" GammaTangential="1" KineticFriction="1"/>"#
            )
        })
        .collect();
    files[1].1 = format!(
        "<Materials><Intrinsic>{}</Intrinsic><Binary>{}</Binary></Materials>",
        each(&|k| format!(r#"<Material Id="m{k}" YoungModulus="4e6" ShearModulus="1379310.3"/>"#)),
        contacts[..contacts.len() - missing].concat()
    );
    files[2].1 = "<Geometry><Dimensions Lx=\"1\" Ly=\"1\"/></Geometry>".into();
    files[3].1 = format!(
        "<Agents>{}</Agents>",
        each(&|k| format!(
            r#"<Agent Id="{k}" Mass="63" MomentOfInertia="1" FloorDamping="0" AngularDamping="0">
            <Shape Type="disk" Radius="0.2" MaterialId="m{k}" Position="0,0"/></Agent>"#
        ))
    );
    files[4].1 = format!(
        "<Agents>{}</Agents>",
        each(&|k| format!(
            r#"<Agent Id="{k}"><Kinematics Position="{k},0" Velocity="0,0" Theta="0" Omega="0"/></Agent>"#
        ))
    );
    files.truncate(5);
    put(directory.path(), &files);
    setup::read(directory.path())
}

/// Each of 80 000 contacts was looked for among all: 400 materials took 9 s, now a second in a development build.
#[test]
fn hundreds_of_materials_are_checked_in_the_time_of_their_contacts() {
    let seconds = |count| {
        let begun = std::time::Instant::now();
        let (_, warnings) = of_materials(count, 0).unwrap();
        assert!(warnings.is_empty(), "{warnings}");
        begun.elapsed().as_secs_f64()
    };
    // Four times the contacts; sixteen times the pairs of contacts. The best of three: machines are shared.
    let best = |count| (0..3).map(|_| seconds(count)).fold(f64::INFINITY, f64::min);
    let (few, many) = (best(200), best(400));
    assert!(many < 10.0 * few + 0.5, "{few} s, then {many} s");
}

#[test]
fn more_materials_than_can_be_used_are_refused() {
    let problems = of_materials(3, 2).unwrap_err().to_string();
    assert!(problems.contains("no <Contact> of \"m1\" and \"m2\""), "{problems}");
    let contacts = 1001 * 1002 / 2;
    let problems = of_materials(1001, contacts).unwrap_err().to_string();
    let message = "Materials.xml: agents and walls are of 1001 materials: at most 1000 can be used";
    assert!(problems.lines().count() == 1 && problems.ends_with(message), "{problems}");
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

/// 40 000 took 2 s, 300 000 over a minute.
#[test]
fn elements_with_many_attributes_are_refused_before_they_are_parsed() {
    for prefix in ["", "xmlns:"] {
        let many: String = (0..300_000).map(|k| format!(" {prefix}a{k}='{k}'")).collect();
        for (file, _) in good() {
            let directory = TempDir::new().unwrap();
            put(directory.path(), &good());
            fs::write(directory.path().join(file), format!("<!-- <a> -->\n<A{many}/>")).unwrap();
            let said = setup::read(directory.path()).unwrap_err().to_string();
            assert!(said.contains(":2: <A>: has 300000 attributes; at most 256 are allowed"), "{said}");
        }
    }
}

#[test]
fn hostile_files_are_errors() {
    let deep = format!("{}{}", "<a>".repeat(1_000_000), "</a>".repeat(1_000_000));
    let deep_unclosed = "<Agents>".repeat(1_000_000);
    let bomb = "<!DOCTYPE a [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;&a;&a;'>]><Agents>&b;</Agents>";
    let hostile: Vec<Vec<u8>> = vec![
        deep.into_bytes(),
        deep_unclosed.into_bytes(),
        bomb.into(),
        (0..=255).cycle().take(10_000).collect(),
        Vec::new(),
        b"\xef\xbb\xbf".to_vec(),
        b"<Agents Name=\"\xff\xfe\"/>".to_vec(),
        b"\0\0\0\0".to_vec(),
        b"<Agents>&lol;</Agents>".to_vec(),
        b"<x:Agents/>".to_vec(),
    ];
    for (file, _) in good() {
        let directory = TempDir::new().unwrap();
        put(directory.path(), &good());
        for content in &hostile {
            fs::write(directory.path().join(file), content).unwrap();
            let problems = setup::read(directory.path()).unwrap_err();
            let named = problems.errors().any(|problem| problem.file == directory.path().join(file));
            assert!(named && problems.to_string().len() < 4000, "{problems}");
        }
    }
    for (file, text) in good() {
        for end in (0..text.len()).step_by(7) {
            assert!(edited(&[(file, &text, &text[..end])]).is_err(), "{file} cut at {end}");
        }
    }
}

#[test]
fn other_names_and_absolute_directories() {
    let directory = TempDir::new().unwrap();
    put(directory.path(), &good());
    let fixed = directory.path().join("static");
    let elsewhere = TempDir::new().unwrap();
    let parameters =
        good()[0].1.replace("./static/", fixed.to_str().unwrap()).replace("\"dynamic\"", "\"..\"");
    fs::create_dir(elsewhere.path().join("here")).unwrap();
    put(elsewhere.path(), &[("here/P.xml", parameters), ("D.xml", good()[4].1.clone())]);
    let names = FileNames { parameters: "P.xml".into(), dynamics: "D.xml".into(), ..FileNames::default() };
    let (trial, _) = setup::read_named(&elsewhere.path().join("here"), &names).unwrap();
    assert_eq!(trial.name, "here");

    // The copy stands alone.
    let copy = TempDir::new().unwrap();
    trial.write(&copy.path().join("in/copy")).unwrap();
    let (back, _) = setup::read(&copy.path().join("in/copy")).unwrap();
    assert_eq!(back.parameters.static_directory, "./static/");
    assert_eq!((back.agents, back.dynamics), (trial.agents, trial.dynamics));
}

#[test]
fn writing_leaves_nothing_behind() {
    let directory = TempDir::new().unwrap();
    let (mut trial, _) = edited(&[]).unwrap();
    trial.write(directory.path()).unwrap();
    assert!(directory.path().join(INTERACTIONS).exists());
    trial.interactions = Interactions::default();
    trial.write(directory.path()).unwrap();
    let mut files: Vec<String> = Vec::new();
    for folder in ["", "static", "dynamic"] {
        for entry in fs::read_dir(directory.path().join(folder)).unwrap() {
            let path = entry.unwrap().path();
            files.extend(
                path.is_file().then(|| path.strip_prefix(directory.path()).unwrap().display().to_string()),
            );
        }
    }
    files.sort();
    let mut expected = FILES.map(|file| Path::new(file).display().to_string());
    expected.sort();
    assert_eq!(files, expected);

    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let plain = directory.path().join("plain");
        fs::write(&plain, "").unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&directory.path().join(FILES[0])), mode(&plain));
    }

    let blocked =
        lemons_files::write_atomically(&directory.path().join("none/x.xml"), "").unwrap_err().to_string();
    assert!(blocked.contains("x.xml: cannot be written: "), "{blocked}");
}

#[test]
fn an_output_omits_the_drive() {
    let (trial, _) = edited(&[]).unwrap();
    let text = dynamics_xml(&trial.agents, &trial.dynamics, DynamicsElement::Omitted);
    let expected = r#"<?xml version="1.0" encoding="utf-8"?>
<Agents>
    <Agent Id="Ann">
        <Kinematics Position="3.1,0.6" Velocity="-1.0,0.0" Theta="3.0" Omega="0.75"/>
    </Agent>
"#;
    assert!(text.starts_with(expected) && !text.contains("Dynamics"), "{text}");
    let text = interactions_xml(&trial.agents, &trial.geometry, &trial.interactions);
    let expected = r#"<?xml version="1.0" encoding="utf-8"?>
<Interactions>
    <Agent Id="Ann">
        <Agent Id="Bob">
            <Interaction ParentShape="1" ChildShape="0" TangentialRelativeDisplacement="-1.0,-2.0" Fn="-3.0,-4.0" Ft="-5.0,-6.0"/>
        </Agent>
    </Agent>
    <Agent Id="Bob">
        <Wall ShapeId="0" WallId="room" CornerId="2" TangentialRelativeDisplacement="7.0,8.0" Fn="9.0,10.0" Ft="11.0,12.0"/>
    </Agent>
</Interactions>
"#;
    assert_eq!(text, expected);
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![-1e3..1e3, any::<f64>().prop_filter("finite", |x| x.is_finite())]
}

fn positive() -> impl Strategy<Value = f64> {
    prop_oneof![1e-3..1e3, Just(f64::MIN_POSITIVE), Just(f64::MAX), Just(5e-324)]
}

fn vector() -> impl Strategy<Value = Vec2> {
    (number(), number()).prop_map(|(x, y)| vec2(x, y))
}

/// Any place that a Trial may have.
fn point() -> impl Strategy<Value = Vec2> {
    let number = || prop_oneof![-1e3..1e3, -1e9..=1e9, Just(5e-324)];
    (number(), number()).prop_map(|(x, y)| vec2(x, y))
}

/// Anything an Id can hold; the number makes it unique and not blank.
fn id(kind: &str, place: usize) -> impl Strategy<Value = String> + use<> {
    let end = format!("{kind}{place}");
    "[ -~\t\n\rà-ÿ€😀]{0,6}".prop_map(move |start| start.trim_start().to_owned() + &end)
}

fn force() -> impl Strategy<Value = ContactForce> {
    (vector(), vector(), vector()).prop_map(|(elongation, normal, tangential)| ContactForce {
        elongation,
        normal,
        tangential,
    })
}

fn agent(place: usize, materials: Vec<String>) -> impl Strategy<Value = Agent> {
    let shape = (positive(), prop::sample::select(materials), point());
    let shape = shape.prop_map(|(radius, material_id, position)| Shape { radius, material_id, position });
    let kind = prop::option::of(Just("pedestrian".to_owned()));
    let numbers = (positive(), prop::option::of(positive()), positive(), 0.0..9.0, 0.0..9.0);
    (kind, id("a", place), numbers, prop::collection::vec(shape, 1..4)).prop_map(
        |(kind, id, (mass, height, moment_of_inertia, floor_damping, angular_damping), shapes)| Agent {
            kind,
            id,
            mass,
            height,
            moment_of_inertia,
            floor_damping,
            angular_damping,
            shapes,
        },
    )
}

fn dynamics() -> impl Strategy<Value = AgentDynamics> {
    (point(), vector(), number(), number(), vector(), number()).prop_map(
        |(position, velocity, theta, omega, fp, mp)| AgentDynamics {
            position,
            velocity,
            theta,
            omega,
            fp,
            mp,
        },
    )
}

/// Corners apart from each other, so that no face has no length.
fn wall(place: usize, materials: Vec<String>) -> impl Strategy<Value = Wall> {
    (id("w", place), prop::sample::select(materials), prop::collection::vec((-1.0..1.0, -1.0..1.0), 2..6))
        .prop_map(|(id, material_id, offsets)| {
            let corners =
                offsets.iter().zip(0..).map(|(&(x, y), k)| vec2(x + 3.0 * f64::from(k), y)).collect();
            Wall { id, material_id, corners }
        })
}

fn materials(count: usize) -> impl Strategy<Value = Materials> {
    let ids: Vec<_> = (0..count).map(|place| id("m", place)).collect();
    let pairs = count * (count + 1) / 2;
    (
        ids,
        prop::collection::vec((1.0..1e9, 0.3..9.0), count),
        prop::collection::vec((0.0..1e4, 0.0..1e4, 0.0..2.0), pairs),
    )
        .prop_map(move |(ids, moduli, laws)| {
            let order = (0..count).flat_map(|i| (0..=i).map(move |j| (i, j)));
            let binary =
                order.zip(laws).map(|((i, j), (gamma_normal, gamma_tangential, kinetic_friction))| Contact {
                    id1: ids[i].clone(),
                    id2: ids[j].clone(),
                    gamma_normal,
                    gamma_tangential,
                    kinetic_friction,
                });
            let binary = binary.collect();
            let intrinsic = ids.iter().zip(moduli).map(|(id, (young_modulus, ratio))| Material {
                id: id.clone(),
                young_modulus,
                shear_modulus: young_modulus * ratio,
            });
            Materials { intrinsic: intrinsic.collect(), binary }
        })
}

/// Contacts of every pair of the agents, and of every agent with every wall, first disk and face alone.
fn interactions(agents: usize, walls: usize) -> impl Strategy<Value = Interactions> {
    let pairs: Vec<_> = (0..agents).flat_map(|i| (i + 1..agents).map(move |j| (i, j))).collect();
    let touches: Vec<_> = (0..agents).flat_map(|i| (0..walls).map(move |wall| (i, wall))).collect();
    let of = |count| prop::collection::vec(prop::option::of(force()), count);
    (of(pairs.len()), of(touches.len())).prop_map(move |(on_agents, on_walls)| Interactions {
        agents: (pairs.iter().zip(on_agents))
            .filter_map(|(&(parent, child), force)| {
                Some(AgentInteraction { parent, child, parent_shape: 0, child_shape: 0, force: force? })
            })
            .collect(),
        walls: (touches.iter().zip(on_walls))
            .filter_map(|(&(agent, wall), force)| {
                Some(WallInteraction { agent, shape: 0, wall, corner: 0, force: force? })
            })
            .collect(),
    })
}

fn trial() -> impl Strategy<Value = Trial> {
    (1..4usize, 0..3usize, 1..4usize)
        .prop_flat_map(|(agents, walls, kinds)| (Just((agents, walls)), materials(kinds)))
        .prop_flat_map(|((agents, walls), materials)| {
            let ids: Vec<String> = materials.intrinsic.iter().map(|material| material.id.clone()).collect();
            (
                Just(materials),
                (0..agents).map(|place| agent(place, ids.clone())).collect::<Vec<_>>(),
                prop::collection::vec(dynamics(), agents),
                (0..walls).map(|place| wall(place, ids.clone())).collect::<Vec<_>>(),
                prop::option::of(vector()),
                interactions(agents, walls),
                (1e-3..1.0, 1e-9..1e-3),
                prop::sample::select(vec!["./static/", "st", ".", "a/b & c"]),
            )
        })
        .prop_map(|(materials, agents, dynamics, walls, dimensions, interactions, times, directory)| Trial {
            name: "Trial".into(),
            directory: PathBuf::new(),
            parameters: Parameters {
                static_directory: directory.into(),
                dynamic_directory: "./dynamic/".into(),
                time_step: times.0,
                time_step_mechanical: times.1,
            },
            materials,
            geometry: Geometry { dimensions, walls },
            agents,
            dynamics,
            interactions,
        })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_reads_back(trial in trial()) {
        let directory = TempDir::new().unwrap();
        trial.write(directory.path()).unwrap();
        let (back, _) = match setup::read(directory.path()) {
            Ok(read) => read,
            Err(problems) => return Err(TestCaseError::fail(problems.to_string())),
        };
        // Debug text tells −0 from 0.
        prop_assert_eq!(format!("{back:?}"), format!("{:?}", moved(&trial, &back)));
    }
}

/// The table of laws has a row and a column for each material that something is made of, not for each listed.
#[test]
fn many_idle_materials_cost_nothing() {
    let idle: String = (0..50_000)
        .map(|k| format!("<Material Id=\"m{k}\" YoungModulus=\"4e6\" ShearModulus=\"1.4e6\"/>"))
        .collect();
    let (trial, _) = edited(&[(FILES[1], "</Intrinsic>", &format!("{idle}</Intrinsic>"))]).unwrap();
    assert_eq!(trial.materials.intrinsic.len(), 50_002);
    assert!(Setup::of(&trial).world().is_ok());
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
