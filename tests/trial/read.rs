//! Trials that are read as they are written.

use crate::good::{INTERACTIONS, edited, good, moved, put};
use crowd_mechanics::engine::{Vec2, vec2};
use crowd_mechanics::setup;
use lemons_core::files::source::LocalFiles;
use lemons_core::trial::*;
use lemons_testing::trial_push as paper;
use std::fs;
use tempfile::TempDir;

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
    assert_eq!((trial.dynamics[1].fp, trial.dynamics[1].mp), (Vec2::zeros(), 0.0));
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
    let (trial, _) = setup::read_from(&LocalFiles, &elsewhere.path().join("here"), &names).unwrap();
    assert_eq!(trial.name, "here");

    // The copy stands alone.
    let copy = TempDir::new().unwrap();
    trial.write(&copy.path().join("in/copy")).unwrap();
    let (back, _) = setup::read(&copy.path().join("in/copy")).unwrap();
    assert_eq!(back.parameters.static_directory, "./static/");
    assert_eq!((back.agents, back.dynamics), (trial.agents, trial.dynamics));
}
