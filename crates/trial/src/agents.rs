//! `Agents.xml`.

use crate::problem::Problems;
use crate::xml::{Bound, Element, Ids, Kind, document, vector};
use lemons_plane::{Rotation, Vec2, shown_orientation};
use lemons_xml::{Problem, number, quoted};

pub(crate) static AGENTS: Kind = Kind { name: "Agents", attributes: &[], children: &[&AGENT] };
static AGENT: Kind = Kind {
    name: "Agent",
    attributes: &["Type", "Id", "Mass", "Height", "MomentOfInertia", "FloorDamping", "AngularDamping"],
    children: &[&SHAPE],
};

/// `<Agent>` of `Agents.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Agent {
    /// `Type`, as written ("pedestrian").
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
    /// \[1/s\] relaxation rate 1/t_rot, ≥ 0.
    pub angular_damping: f64,
    /// The disks, at least one, in order from the left shoulder to the right one.
    pub shapes: Vec<Shape>,
}

impl Agent {
    /// Returns centre \[m\] and radius \[m\] of the disks, relative to the centre of mass, when the gaze is along x.
    pub fn disks_facing_x(&self) -> Vec<(Vec2, f64)> {
        let ends = self.shapes.first().zip(self.shapes.last());
        let turn = ends.map_or(0.0, |(first, last)| shown_orientation(first.position, last.position));
        let back = Rotation::by(-turn);
        self.shapes.iter().map(|shape| (shape.position.rotated(back), shape.radius)).collect()
    }
}

/// `<Shape>`: a disk.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// \[m\]
    pub radius: f64,
    /// Id of its material.
    pub material_id: String,
    /// \[m\] offset from the centre of mass, at the orientation that the shapes themselves define.
    pub position: Vec2,
}
static SHAPE: Kind =
    Kind { name: "Shape", attributes: &["Type", "Radius", "MaterialId", "Position"], children: &[] };

/// The agents and their Ids; `materials` is `None` where they could not be read.
pub(crate) fn read(root: Element<'_>, materials: Option<&Ids>, problems: &mut Problems) -> (Vec<Agent>, Ids) {
    let (mut agents, mut ids) = (Vec::new(), Ids::default());
    for element in root.children("Agent") {
        let id = ids.take(element, problems);
        let kind = element.optional_text("Type").map(str::to_owned);
        if kind.as_deref().is_some_and(|kind| kind != "pedestrian") {
            let message = format!("agent {}: the mechanics takes pedestrians only", quoted(&id));
            problems.push(element.wrong("Type", &message));
            // Its other attributes are another kind's, but the other files name it.
            element.leave();
            agents.push(unread(id));
            continue;
        }
        let mut number = |attribute, bound| element.number(attribute, bound, problems);
        let agent = Agent {
            kind,
            id,
            mass: number("Mass", Bound::Positive),
            height: element.has("Height").then(|| number("Height", Bound::Positive)),
            moment_of_inertia: number("MomentOfInertia", Bound::Positive),
            floor_damping: number("FloorDamping", Bound::NotNegative),
            angular_damping: number("AngularDamping", Bound::NotNegative),
            shapes: element.children("Shape").map(|shape| read_shape(shape, materials, problems)).collect(),
        };
        if agent.shapes.is_empty() {
            let problem = element.has_no("Shape");
            let message = format!("agent {} {}", quoted(&agent.id), problem.message);
            problems.push(Problem { message, ..problem });
        }
        agents.push(agent);
    }
    if agents.is_empty() {
        problems.push(root.has_no("Agent"));
    }
    (agents, ids)
}

fn read_shape(element: Element<'_>, materials: Option<&Ids>, problems: &mut Problems) -> Shape {
    let kind = element.text("Type", problems);
    if kind != "disk" && !kind.trim().is_empty() {
        problems.push(element.wrong("Type", "must be \"disk\""));
    }
    Shape {
        radius: element.number("Radius", Bound::Positive, problems),
        material_id: element.reference("MaterialId", materials, "material", problems).0,
        position: element.point("Position", problems),
    }
}

fn unread(id: String) -> Agent {
    let [mass, moment_of_inertia, floor_damping, angular_damping] = [f64::NAN; 4];
    let (kind, height, shapes) = (None, None, Vec::new());
    Agent { kind, id, mass, height, moment_of_inertia, floor_damping, angular_damping, shapes }
}

pub(crate) fn xml(agents: &[Agent]) -> String {
    document("Agents", |out| {
        for agent in agents {
            let [mass, inertia] = [agent.mass, agent.moment_of_inertia].map(number);
            let [floor, angular] = [agent.floor_damping, agent.angular_damping].map(number);
            let height = agent.height.map(number);
            let mut attributes: Vec<(&str, &str)> = Vec::new();
            attributes.extend(agent.kind.as_deref().map(|kind| ("Type", kind)));
            attributes.extend([("Id", agent.id.as_str()), ("Mass", &mass)]);
            attributes.extend(height.as_deref().map(|height| ("Height", height)));
            attributes.extend([
                ("MomentOfInertia", inertia.as_str()),
                ("FloorDamping", &floor),
                ("AngularDamping", &angular),
            ]);
            out.element("Agent", &attributes, |out| {
                for shape in &agent.shapes {
                    out.empty(
                        "Shape",
                        &[
                            ("Type", "disk"),
                            ("Radius", &number(shape.radius)),
                            ("MaterialId", &shape.material_id),
                            ("Position", &vector(shape.position)),
                        ],
                    );
                }
            });
        }
    })
}
