//! `Agents.xml`.

use super::problem::{Problems, quoted};
use super::xml::{Bound, Element, Ids, Out, number, vector};
use super::{Agent, Shape};

/// The agents and their Ids; `materials` is `None` where they could not be read.
pub(super) fn read(root: Element<'_>, materials: Option<&Ids>, problems: &mut Problems) -> (Vec<Agent>, Ids) {
    let (mut agents, mut ids) = (Vec::new(), Ids::default());
    for element in root.children("Agent") {
        let id = ids.take(element, problems);
        let kind = element.optional_text("Type").map(str::to_owned);
        if kind.as_deref().is_some_and(|kind| kind != "pedestrian") {
            let message = format!("agent {}: the mechanics takes pedestrians only", quoted(&id));
            problems.push(element.wrong("Type", &message));
            // Its other attributes are another kind's, but the other files name it.
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
            problems.push(element.problem(format!("agent {} has no <Shape>", quoted(&agent.id))));
        }
        agents.push(agent);
    }
    if agents.is_empty() {
        problems.push(root.problem("has no <Agent>"));
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
        position: element.vector("Position", problems),
    }
}

fn unread(id: String) -> Agent {
    let [mass, moment_of_inertia, floor_damping, angular_damping] = [f64::NAN; 4];
    let (kind, height, shapes) = (None, None, Vec::new());
    Agent { kind, id, mass, height, moment_of_inertia, floor_damping, angular_damping, shapes }
}

pub(super) fn xml(agents: &[Agent]) -> String {
    Out::document("Agents", |out| {
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
