//! `Agents.xml`.

use crate::plane::{Vec2, rotation, shown_orientation, vec2};
use crate::trial::heights::{HEIGHTS, Heights};
use crate::trial::schema::{AttributeValue, Schema};
use crate::trial::xml::{Element, Ids, document, read_id, vector};
use crate::xml::{number, quoted};
use std::collections::HashMap;

pub(crate) static AGENTS: Schema = Schema { name: "Agents", attributes: &[], children: &[&AGENT] };
static AGENT: Schema = Schema {
    name: "Agent",
    attributes: &[
        ("Type", AttributeValue::Word("pedestrian")),
        ("Id", AttributeValue::Id),
        ("Mass", AttributeValue::Positive),
        ("Height", AttributeValue::Positive),
        ("MomentOfInertia", AttributeValue::Positive),
        ("FloorDamping", AttributeValue::NotNegative),
        ("AngularDamping", AttributeValue::NotNegative),
        ("Kind", AttributeValue::Text),
        ("FloorDampingAcross", AttributeValue::NotNegative),
        ("ChestHeight", AttributeValue::Positive),
    ],
    children: &[&SHAPE],
};
static SHAPE: Schema = Schema {
    name: "Shape",
    attributes: &[
        ("Type", AttributeValue::Word("disk")),
        ("Radius", AttributeValue::Positive),
        ("MaterialId", AttributeValue::IdOf("material")),
        ("Position", AttributeValue::Point),
        HEIGHTS[0],
        HEIGHTS[1],
    ],
    children: &[],
};

/// \[kg/m²\] Mass over the square of the stature: least and greatest of people. Those who starve have 11, the heaviest man
/// whose stature is known had 105. Less or more is a mass in another unit.
pub const BODY_MASS_INDEX: [f64; 2] = [10.0, 110.0];

/// `<Agent>` of `Agents.xml`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Agent {
    /// `Type`, as written ("pedestrian").
    pub agent_type: Option<String>,
    /// `Kind`: what kind of person it is, such as "wheelchair"; not used by the mechanics.
    pub kind: Option<String>,
    /// Id, unique among the agents.
    pub id: String,
    /// \[kg\]
    pub mass: f64,
    /// \[m\] stature; not used by the mechanics.
    pub height: Option<f64>,
    /// \[kg.m2\] moment of inertia about the centre of mass.
    pub moment_of_inertia: f64,
    /// \[1/s\] relaxation rate 1/t_transl, ≥ 0.
    pub floor_damping: f64,
    /// \[1/s\] `FloorDampingAcross`: relaxation rate of the velocity across the gaze, ≥ 0, if it is not
    /// `floor_damping`.
    pub floor_damping_across: Option<f64>,
    /// \[1/s\] relaxation rate 1/t_rot, ≥ 0.
    pub angular_damping: f64,
    /// \[m\] `ChestHeight`: the disks at this height are those of the chest, whose load is found in every step; `None`: it
    /// is not found.
    pub chest_height: Option<f64>,
    /// The disks, at least one, in order from the left shoulder to the right one.
    pub shapes: Vec<ShapeElement>,
}

impl Agent {
    /// Makes an agent without disks: Id, mass \[kg\], moment of inertia \[kg.m2\], relaxation rates 1/t_transl and
    /// 1/t_rot \[1/s\].
    pub fn new(id: impl Into<String>, mass: f64, moment_of_inertia: f64, damping: [f64; 2]) -> Agent {
        let [floor_damping, angular_damping] = damping;
        Agent { id: id.into(), mass, moment_of_inertia, floor_damping, angular_damping, ..Agent::default() }
    }

    /// Returns the same with disks: x, y, radius \[m\], from the left shoulder to the right one.
    #[must_use]
    pub fn with_disks(self, disks: &[[f64; 3]]) -> Agent {
        let shape = |&[x, y, radius]: &[f64; 3]| ShapeElement {
            radius,
            position: vec2(x, y),
            material_id: String::new(),
            heights: Heights::default(),
        };
        Agent { shapes: disks.iter().map(shape).collect(), ..self }
    }

    /// Returns whether the load on its chest is found: whether it has disks at `chest_height`.
    pub fn has_chest(&self) -> bool {
        self.chest_height.is_some_and(|at| self.shapes.iter().any(|shape| shape.heights.hold(at)))
    }

    /// Returns centre \[m\] and radius \[m\] of the disks, relative to the centre of mass, when the gaze is along x.
    pub fn disks_facing_x(&self) -> Vec<(Vec2, f64)> {
        let ends = self.shapes.first().zip(self.shapes.last());
        let turn = ends.map_or(0.0, |(first, last)| shown_orientation(first.position, last.position));
        let back = rotation(-turn);
        self.shapes.iter().map(|shape| (back * shape.position, shape.radius)).collect()
    }
}

/// `<Shape>`: a disk.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeElement {
    /// \[m\]
    pub radius: f64,
    /// Id of its material.
    pub material_id: String,
    /// \[m\] offset from the centre of mass, at the orientation that the shapes themselves define.
    pub position: Vec2,
    /// Where it is above the floor.
    pub heights: Heights,
}

/// Reads the agents; `materials` is `None` where they could not be read.
pub(crate) fn read(root: Element<'_>, materials: Option<&Ids<'_>>) -> Vec<Agent> {
    let (mut agents, mut lines) = (Vec::new(), HashMap::new());
    for element in root.children("Agent") {
        let id = read_id(element, &mut lines);
        let agent_type = element.node.optional("Type").map(str::to_owned);
        if agent_type.as_deref().is_some_and(|name| name != "pedestrian") {
            element.wrong("Type", format!("agent {}: the mechanics takes pedestrians only", quoted(&id)));
            // Its other attributes are another kind's, but the other files name it.
            agents.push(Agent { agent_type, id, ..Agent::default() });
            continue;
        }
        let agent = Agent {
            agent_type,
            kind: element.node.has("Kind").then(|| element.text("Kind")),
            id,
            mass: element.number("Mass"),
            height: element.node.has("Height").then(|| element.number("Height")),
            moment_of_inertia: element.number("MomentOfInertia"),
            floor_damping: element.number("FloorDamping"),
            floor_damping_across: (element.node.has("FloorDampingAcross"))
                .then(|| element.number("FloorDampingAcross")),
            angular_damping: element.number("AngularDamping"),
            chest_height: element.node.has("ChestHeight").then(|| element.number("ChestHeight")),
            shapes: element.children("Shape").map(|shape| read_shape(shape, materials)).collect(),
        };
        if agent.shapes.is_empty() {
            element.error(format!("agent {} {}", quoted(&agent.id), element.has_no("Shape")));
        }
        agents.push(agent);
    }
    if agents.is_empty() {
        root.error(root.has_no("Agent"));
    }
    agents
}

fn read_shape(element: Element<'_>, materials: Option<&Ids<'_>>) -> ShapeElement {
    element.text("Type");
    ShapeElement {
        radius: element.number("Radius"),
        material_id: element.reference("MaterialId", materials).0,
        position: element.vector("Position"),
        heights: Heights::read(element),
    }
}

pub(crate) fn xml(agents: &[Agent]) -> String {
    document("Agents", |out| {
        for agent in agents {
            let numbers = [agent.moment_of_inertia, agent.floor_damping, agent.angular_damping];
            let [inertia, floor, angular] = numbers.map(|value| Some(number(value)));
            let (id, mass, height) = (agent.id.clone(), number(agent.mass), agent.height.map(number));
            let (name, kind) = (agent.agent_type.clone(), agent.kind.clone());
            let (across, chest) = (agent.floor_damping_across.map(number), agent.chest_height.map(number));
            let values = [name, Some(id), Some(mass), height, inertia, floor, angular, kind, across, chest];
            out.element("Agent", &AGENT.values(&values.each_ref().map(Option::as_deref)), |out| {
                for ShapeElement { radius, material_id, position, heights } in &agent.shapes {
                    let [bottom, top] = heights.values();
                    let values = [Some("disk".into()), Some(number(*radius)), Some(material_id.clone())];
                    let values: Vec<_> =
                        values.into_iter().chain([Some(vector(*position)), bottom, top]).collect();
                    let values: Vec<_> = values.iter().map(Option::as_deref).collect();
                    out.empty(SHAPE.name, &SHAPE.values(&values));
                }
            });
        }
    })
}
