//! Trials made for the tests.

use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::*;
use roxmltree::{Document, Node};
use std::path::PathBuf;

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

/// The elements of a class.
pub fn class<'a>(document: &'a Document, name: &str) -> Vec<Node<'a, 'a>> {
    document.descendants().filter(|n| n.attribute("class") == Some(name)).collect()
}

/// The value of an attribute.
pub fn number(node: Node, attribute: &str) -> f64 {
    node.attribute(attribute).unwrap().parse().unwrap()
}

/// What the lettering of a class says.
pub fn labels(document: &Document, name: &str) -> Vec<String> {
    class(document, name).iter().map(|n| n.attribute("aria-label").unwrap().to_owned()).collect()
}

/// Of all points of a path of absolute commands: left, right, top, bottom.
pub fn extent(d: &str) -> (f64, f64, f64, f64) {
    let path =
        format!("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\" height=\"9\"><path d=\"{d}\"/></svg>");
    let tree = resvg::usvg::Tree::from_str(&path, &resvg::usvg::Options::default()).unwrap();
    let b = tree.root().bounding_box();
    (b.left().into(), b.right().into(), b.top().into(), b.bottom().into())
}
