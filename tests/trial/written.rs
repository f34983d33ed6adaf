//! Trials that are written read back.

use crate::good::{FILES, INTERACTIONS, edited, moved};
use crowd_mechanics::engine::{Vec2, vec2};
use crowd_mechanics::scenes::Random;
use crowd_mechanics::setup::{self};
use lemons_core::trial::*;
use std::fs;
use std::path::Path;
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

/// The good Trial with other numbers and Ids.
fn varied(random: &mut Random) -> Trial {
    let (mut trial, _) = edited(&[]).unwrap();
    trial.parameters = Parameters {
        static_directory: ["./static/", "st", ".", "a/b & c"][pick(random, 4)].into(),
        dynamic_directory: "./dynamic/".into(),
        time_step: random.within(1e-3, 1.0),
        time_step_mechanical: random.within(1e-9, 1e-3),
    };
    for (place, material) in trial.materials.intrinsic.iter_mut().enumerate() {
        let now = id(random, "m", place);
        let before = std::mem::replace(&mut material.id, now.clone());
        material.young_modulus = random.within(1.0, 1e9);
        material.shear_modulus = material.young_modulus * random.within(0.3, 9.0);
        let contacts = trial.materials.binary.iter_mut().flat_map(|of| [&mut of.id1, &mut of.id2]);
        let shapes = trial.agents.iter_mut().flat_map(|agent| &mut agent.shapes);
        let walls = trial.geometry.walls.iter_mut().map(|wall| &mut wall.material_id);
        let ids = contacts.chain(shapes.map(|shape| &mut shape.material_id)).chain(walls);
        ids.filter(|id| **id == before).for_each(|id| id.clone_from(&now));
    }
    for contact in &mut trial.materials.binary {
        contact.gamma_normal = random.within(0.0, 1e4);
        contact.gamma_tangential = random.within(0.0, 1e4);
        contact.kinetic_friction = random.within(0.0, 2.0);
    }
    trial.geometry.dimensions = (pick(random, 2) == 0).then(|| vector(random));
    for (place, wall) in trial.geometry.walls.iter_mut().enumerate() {
        wall.id = id(random, "w", place);
        // Corners apart from each other, so that no face has no length.
        for (corner, k) in wall.corners.iter_mut().zip(0..) {
            *corner = vec2(3.0 * f64::from(k) + random.signed(), random.signed());
        }
    }
    for (place, agent) in trial.agents.iter_mut().enumerate() {
        agent.id = id(random, "a", place);
        agent.mass = positive(random);
        agent.height = (pick(random, 2) == 0).then(|| positive(random));
        agent.moment_of_inertia = positive(random);
        (agent.floor_damping, agent.angular_damping) = (random.within(0.0, 9.0), random.within(0.0, 9.0));
        for shape in &mut agent.shapes {
            (shape.radius, shape.position) = (positive(random), point(random));
        }
    }
    for moving in &mut trial.dynamics {
        (moving.position, moving.velocity, moving.fp) = (point(random), vector(random), vector(random));
        (moving.theta, moving.omega, moving.mp) = (number(random), number(random), number(random));
    }
    let contacts = trial.interactions.agents.iter_mut().map(|contact| &mut contact.force);
    for of in contacts.chain(trial.interactions.walls.iter_mut().map(|contact| &mut contact.force)) {
        (of.elongation, of.normal, of.tangential) = (vector(random), vector(random), vector(random));
    }
    trial
}

#[test]
fn what_is_written_reads_back() {
    let mut random = Random(7);
    for case in 0..200 {
        let trial = varied(&mut random);
        let directory = TempDir::new().unwrap();
        trial.write(directory.path()).unwrap();
        let (back, _) = setup::read(directory.path()).unwrap_or_else(|problems| panic!("{case}: {problems}"));
        // Debug text tells −0 from 0.
        assert_eq!(format!("{back:?}"), format!("{:?}", moved(&trial, &back)), "{case}");
    }
}
