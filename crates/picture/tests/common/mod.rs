//! Trials made for the tests, and an ad-hoc reader of the two files that matter here.

use crowd_mechanics::engine::{Vec2, vec2};
use crowd_mechanics::trial::*;
use std::path::{Path, PathBuf};

/// A pedestrian in the manner of the paper, facing +x at θ = 0.
pub fn pedestrian(id: &str) -> Agent {
    let shapes = [
        (0.095, -0.015, 0.154),
        (0.131, 0.009, 0.067),
        (0.137, 0.014, 0.0),
        (0.131, 0.009, -0.067),
        (0.095, -0.015, -0.154),
    ];
    let shape = |(radius, x, y): &(f64, f64, f64)| Shape {
        radius: *radius,
        material_id: "human".into(),
        position: vec2(*x, *y),
    };
    agent(id, shapes.iter().map(shape).collect())
}

pub fn agent(id: &str, shapes: Vec<Shape>) -> Agent {
    let kind = Some("pedestrian".into());
    Agent {
        kind,
        id: id.into(),
        mass: 80.0,
        height: None,
        moment_of_inertia: 1.5,
        floor_damping: 4.5,
        angular_damping: 4.5,
        shapes,
    }
}

pub fn trial(agents: Vec<(Agent, Vec2, f64)>, walls: Vec<Vec<Vec2>>) -> Trial {
    let dynamics = |&(_, position, theta): &(Agent, Vec2, f64)| AgentDynamics {
        position,
        velocity: Vec2::ZERO,
        theta,
        omega: 0.0,
        fp: Vec2::ZERO,
        mp: 0.0,
    };
    let wall = |(k, corners): (usize, Vec<Vec2>)| Wall {
        id: k.to_string(),
        material_id: "concrete".into(),
        corners,
    };
    Trial {
        name: "test".into(),
        directory: PathBuf::new(),
        parameters: Parameters {
            static_directory: String::new(),
            dynamic_directory: String::new(),
            time_step: 0.05,
            time_step_mechanical: 2e-6,
        },
        materials: Materials { intrinsic: vec![], binary: vec![] },
        geometry: Geometry { dimensions: None, walls: walls.into_iter().enumerate().map(wall).collect() },
        dynamics: agents.iter().map(dynamics).collect(),
        agents: agents.into_iter().map(|a| a.0).collect(),
        interactions: Interactions::default(),
    }
}

/// A Trial of the shared data; `None`, and a message, where the data are not there.
#[allow(dead_code)]
pub fn shared(name: &str) -> Option<Trial> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data").join(name);
    let Ok(agents) = std::fs::read_to_string(directory.join("static/Agents.xml")) else {
        eprintln!("skipped: no {}", directory.display());
        return None;
    };
    let geometry = std::fs::read_to_string(directory.join("static/Geometry.xml")).unwrap();
    let dynamics = std::fs::read_to_string(directory.join("dynamic/AgentDynamics.xml")).unwrap();
    let [agents, geometry, dynamics] =
        [&agents, &geometry, &dynamics].map(|t| roxmltree::Document::parse(t).unwrap());
    let real = |n: roxmltree::Node, a: &str| n.attribute(a).unwrap().parse::<f64>().unwrap();
    let pair = |n: roxmltree::Node, a: &str| {
        let (x, y) = n.attribute(a).unwrap().split_once(',').unwrap();
        vec2(x.trim().parse().unwrap(), y.trim().parse().unwrap())
    };
    let tagged = |n: roxmltree::Node<'_, '_>, t: &str| {
        n.descendants().filter(|n| n.has_tag_name(t)).map(|n| n.id()).collect::<Vec<_>>()
    };
    let shape = |n: roxmltree::Node| Shape {
        radius: real(n, "Radius"),
        material_id: String::new(),
        position: pair(n, "Position"),
    };
    let poses = tagged(dynamics.root(), "Kinematics");
    let people = tagged(agents.root(), "Agent").into_iter().zip(poses).map(|(a, k)| {
        let (a, k) = (agents.get_node(a).unwrap(), dynamics.get_node(k).unwrap());
        let shapes = tagged(a, "Shape").into_iter().map(|s| shape(agents.get_node(s).unwrap())).collect();
        (agent(a.attribute("Id").unwrap(), shapes), pair(k, "Position"), real(k, "Theta"))
    });
    let corners = |w| {
        tagged(geometry.get_node(w).unwrap(), "Corner")
            .into_iter()
            .map(|c| pair(geometry.get_node(c).unwrap(), "Coordinates"))
            .collect()
    };
    let walls = tagged(geometry.root(), "Wall").into_iter().map(corners).collect();
    Some(Trial { name: name.into(), ..trial(people.collect(), walls) })
}
