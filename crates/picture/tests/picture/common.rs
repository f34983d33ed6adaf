//! Trials made for the tests.

use lemons_core::plane::{Motion, Pose, Vec2, vec2};
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
    agent(id, shapes.map(|(radius, x, y)| disk(radius, vec2(x, y))).to_vec())
}

pub fn disk(radius: f64, position: Vec2) -> ShapeElement {
    ShapeElement { radius, material_id: "human".into(), position, heights: Default::default() }
}

pub fn agent(id: &str, shapes: Vec<ShapeElement>) -> Agent {
    Agent { id: id.into(), shapes, ..Agent::default() }
}

pub fn trial(agents: Vec<(Agent, Vec2, f64)>, walls: Vec<Vec<Vec2>>) -> Trial {
    let dynamics = |&(_, position, orientation): &(Agent, Vec2, f64)| {
        AgentDynamics::of(&Motion { pose: Pose { position, orientation }, ..Motion::default() })
    };
    let wall = |corners: Vec<Vec2>| Wall::new("", "concrete", corners);
    Trial {
        name: "test".into(),
        directory: PathBuf::new(),
        parameters: Parameters::default(),
        materials: Materials::default(),
        geometry: Geometry { walls: walls.into_iter().map(wall).collect(), ..Geometry::default() },
        dynamics: agents.iter().map(dynamics).collect(),
        agents: agents.into_iter().map(|a| a.0).collect(),
        interactions: Interactions::default(),
    }
}

/// Pedestrians 1 m apart, with these Ids.
pub fn row<I: ToString>(ids: impl IntoIterator<Item = I>) -> Trial {
    let ids = ids.into_iter().enumerate();
    let people = ids.map(|(k, id)| (pedestrian(&id.to_string()), vec2(k as f64, 0.0), 0.0));
    trial(people.collect(), vec![vec![vec2(-1.0, -1.0), vec2(6.0, -1.0)]])
}

/// The elements of a class.
pub fn class<'a>(document: &'a Document, name: &str) -> Vec<Node<'a, 'a>> {
    document.descendants().filter(|n| n.attribute("class") == Some(name)).collect()
}

/// The value of an attribute.
pub fn number(node: Node, attribute: &str) -> f64 {
    node.attribute(attribute).unwrap().parse().unwrap()
}

/// Returns the lettering of a class.
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
