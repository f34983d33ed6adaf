//! What is written reads back.

use crate::good::{FILES, INTERACTIONS, edited, moved};
use crowd_mechanics::engine::{Vec2, vec2};
use crowd_mechanics::setup::{self};
use lemons_core::trial::*;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
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
