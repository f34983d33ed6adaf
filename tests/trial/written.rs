//! Trials that are written read back.

use crate::good::{FILES, INTERACTIONS, edited, moved};
use crowd_mechanics::engine::{Vec2, vec2};
use crowd_mechanics::setup::{self};
use lemons_core::trial::*;
use lemons_verify::checks::scenes::Random;
use std::fs;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

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

    // A further file that cannot be written: nothing of a new directory is left, beside it neither.
    let place = directory.path().join("new/Trial");
    trial.write_with(&[("static", "a file in the place of a directory")], &place).unwrap_err();
    assert_eq!(fs::read_dir(directory.path().join("new")).unwrap().count(), 0);
    trial.write_with(&[("drive.csv", "t")], &place).unwrap();
    assert_eq!(fs::read_to_string(place.join("drive.csv")).unwrap(), "t");
    assert_eq!(fs::read_dir(directory.path().join("new")).unwrap().count(), 1);

    fs::write(directory.path().join("file"), "").unwrap();
    let blocked = trial.write(&directory.path().join("file")).unwrap_err().to_string();
    assert!(blocked.contains("file: cannot be written: "), "{blocked}");
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

/// Draws one of so many.
fn pick(random: &mut Random, count: usize) -> usize {
    (random.share() * count as f64) as usize
}

fn positive(random: &mut Random) -> f64 {
    let extreme = [f64::MIN_POSITIVE, f64::MAX, 5e-324, 1.0];
    if pick(random, 4) == 0 { extreme[pick(random, 4)] } else { random.within(1e-3, 1e3) }
}

/// Any finite number, zeros of both signs too.
fn number(random: &mut Random) -> f64 {
    let sign = if pick(random, 2) == 0 { 1.0 } else { -1.0 };
    let extreme = [0.0, f64::MAX, 5e-324, 10f64.powf(random.within(-300.0, 300.0))];
    sign * if pick(random, 2) == 0 { extreme[pick(random, 4)] } else { random.within(0.0, 1e3) }
}

fn vector(random: &mut Random) -> Vec2 {
    vec2(number(random), number(random))
}

/// Any place that a Trial may have.
fn point(random: &mut Random) -> Vec2 {
    let mut number = || if pick(random, 8) == 0 { 5e-324 } else { random.within(-1e9, 1e9) };
    vec2(number(), number())
}

/// Anything an Id can hold; the number makes it unique and not blank.
fn id(random: &mut Random, kind: &str, place: usize) -> String {
    const SIGNS: [char; 16] =
        [' ', '\t', '\n', '\r', '<', '>', '&', '"', '\'', ']', '~', 'A', 'à', 'ÿ', '€', '😀'];
    let start: String = (0..pick(random, 7)).map(|_| SIGNS[pick(random, 16)]).collect();
    format!("{}{kind}{place}", start.trim_start())
}

fn force(random: &mut Random) -> ContactForce {
    ContactForce { elongation: vector(random), normal: vector(random), tangential: vector(random) }
}

fn trial(random: &mut Random) -> Trial {
    let [agents, walls, kinds] = [1 + pick(random, 3), pick(random, 3), 1 + pick(random, 3)];
    let mut material = |place| {
        let young_modulus = random.within(1.0, 1e9);
        let shear_modulus = young_modulus * random.within(0.3, 9.0);
        Material { id: id(random, "m", place), young_modulus, shear_modulus }
    };
    let intrinsic: Vec<Material> = (0..kinds).map(&mut material).collect();
    let mut contact = |(i, j): (usize, usize)| Contact {
        id1: intrinsic[i].id.clone(),
        id2: intrinsic[j].id.clone(),
        gamma_normal: random.within(0.0, 1e4),
        gamma_tangential: random.within(0.0, 1e4),
        kinetic_friction: random.within(0.0, 2.0),
    };
    let binary = (0..kinds).flat_map(|i| (0..=i).map(move |j| (i, j))).map(&mut contact).collect();
    let material_id = |random: &mut Random| intrinsic[pick(random, kinds)].id.clone();
    let shape = |random: &mut Random| Shape {
        radius: positive(random),
        material_id: material_id(random),
        position: point(random),
    };
    let mut agent = |place| Agent {
        kind: (pick(random, 2) == 0).then(|| "pedestrian".to_owned()),
        id: id(random, "a", place),
        mass: positive(random),
        height: (pick(random, 2) == 0).then(|| positive(random)),
        moment_of_inertia: positive(random),
        floor_damping: random.within(0.0, 9.0),
        angular_damping: random.within(0.0, 9.0),
        shapes: (0..1 + pick(random, 3)).map(|_| shape(random)).collect(),
    };
    let people = (0..agents).map(&mut agent).collect();
    let mut dynamics = |_| AgentDynamics {
        position: point(random),
        velocity: vector(random),
        theta: number(random),
        omega: number(random),
        fp: vector(random),
        mp: number(random),
    };
    let dynamics = (0..agents).map(&mut dynamics).collect();
    // Corners apart from each other, so that no face has no length.
    let corner = |random: &mut Random, k| vec2(3.0 * f64::from(k) + random.signed(), random.signed());
    let mut wall = |place| Wall {
        id: id(random, "w", place),
        material_id: material_id(random),
        corners: (0..2 + pick(random, 4) as u32).map(|k| corner(random, k)).collect(),
    };
    let geometry_walls = (0..walls).map(&mut wall).collect();
    // Of some pairs of the agents, and of some agents with some walls, the first disk and face.
    let mut interactions = Interactions::default();
    for i in 0..agents {
        for child in (i + 1..agents).filter(|_| pick(random, 2) == 0).collect::<Vec<_>>() {
            let force = force(random);
            let contact = AgentInteraction { parent: i, child, parent_shape: 0, child_shape: 0, force };
            interactions.agents.push(contact);
        }
        for wall in (0..walls).filter(|_| pick(random, 2) == 0).collect::<Vec<_>>() {
            let force = force(random);
            interactions.walls.push(WallInteraction { agent: i, shape: 0, wall, corner: 0, force });
        }
    }
    Trial {
        name: "Trial".into(),
        directory: PathBuf::new(),
        parameters: Parameters {
            static_directory: ["./static/", "st", ".", "a/b & c"][pick(random, 4)].into(),
            dynamic_directory: "./dynamic/".into(),
            time_step: random.within(1e-3, 1.0),
            time_step_mechanical: random.within(1e-9, 1e-3),
        },
        materials: Materials { intrinsic, binary },
        geometry: Geometry {
            dimensions: (pick(random, 2) == 0).then(|| vector(random)),
            walls: geometry_walls,
        },
        agents: people,
        dynamics,
        interactions,
    }
}

#[test]
fn what_is_written_reads_back() {
    let mut random = Random(7);
    for case in 0..200 {
        let trial = trial(&mut random);
        let directory = TempDir::new().unwrap();
        trial.write(directory.path()).unwrap();
        let (back, _) = setup::read(directory.path()).unwrap_or_else(|problems| panic!("{case}: {problems}"));
        // Debug text tells −0 from 0.
        assert_eq!(format!("{back:?}"), format!("{:?}", moved(&trial, &back)), "{case}");
    }
}
