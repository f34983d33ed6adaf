//! `AgentInteractions.xml`.

use crate::plane::Vec2;
use crate::trial::agents::Agent;
use crate::trial::geometry::Geometry;
use crate::trial::schema::{AttributeValue, Schema};
use crate::trial::xml::{Element, document, empty, ids_of, vector};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

pub(crate) static INTERACTIONS: Schema =
    Schema { name: "Interactions", attributes: &[], children: &[&PARENT] };
static PARENT: Schema = Schema {
    name: "Agent",
    attributes: &[("Id", AttributeValue::IdOf("agent"))],
    children: &[&CHILD, &WALL],
};
static CHILD: Schema =
    Schema { name: "Agent", attributes: &[("Id", AttributeValue::IdOf("agent"))], children: &[&INTERACTION] };
static INTERACTION: Schema = Schema {
    name: "Interaction",
    attributes: &[
        ("ParentShape", AttributeValue::Place),
        ("ChildShape", AttributeValue::Place),
        ("TangentialRelativeDisplacement", AttributeValue::Vector),
        ("Fn", AttributeValue::Vector),
        ("Ft", AttributeValue::Vector),
    ],
    children: &[],
};
static WALL: Schema = Schema {
    name: "Wall",
    attributes: &[
        ("ShapeId", AttributeValue::Place),
        ("WallId", AttributeValue::IdOf("wall")),
        ("CornerId", AttributeValue::Place),
        ("TangentialRelativeDisplacement", AttributeValue::Vector),
        ("Fn", AttributeValue::Vector),
        ("Ft", AttributeValue::Vector),
    ],
    children: &[],
};

/// `AgentInteractions.xml`: the contacts at one time, each pair once.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Interactions {
    /// Contacts between two agents.
    pub agents: Vec<AgentInteraction>,
    /// Contacts between an agent and a wall.
    pub walls: Vec<WallInteraction>,
}

/// `<Interaction>`: one contact of two agents. Agents and shapes are 0-based places in `Agents.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct AgentInteraction {
    /// Place of the agent that receives the force; the lower of the two places.
    pub parent: usize,
    /// Place of the other agent.
    pub child: usize,
    /// Place of the parent's disk among its shapes.
    pub parent_shape: usize,
    /// Place of the child's disk among its shapes.
    pub child_shape: usize,
    /// Forces on the parent and its spring.
    pub force: ContactForce,
}

/// `<Wall>` of `AgentInteractions.xml`: one contact of an agent with a wall.
#[derive(Debug, Clone, PartialEq)]
pub struct WallInteraction {
    /// Place of the agent, which receives the force.
    pub agent: usize,
    /// `ShapeId`: place of the disk among the agent's shapes.
    pub shape: usize,
    /// Place of the wall in `Geometry.xml` (the file holds its Id).
    pub wall: usize,
    /// `CornerId`: place, among the wall's corners, of the corner where the touched face begins.
    pub corner: usize,
    /// Forces on the agent and its spring.
    pub force: ContactForce,
}

/// Forces of a contact on the agent that receives the force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactForce {
    /// \[m\] `TangentialRelativeDisplacement`: elongation of the tangential spring.
    pub elongation: Vec2,
    /// \[N\] `Fn`
    pub normal: Vec2,
    /// \[N\] `Ft`
    pub tangential: Vec2,
}

/// Returns the contacts, sorted by the places of those who touch: the file's order means nothing.
pub(crate) fn read(root: Element<'_>, agents: &[Agent], geometry: &Geometry) -> Interactions {
    let agent_ids = ids_of(agents.iter().map(|agent| &agent.id));
    let wall_ids = ids_of(geometry.walls.iter().map(|wall| &wall.id));
    let (mut among_agents, mut with_walls) = (BTreeMap::new(), BTreeMap::new());
    let disks = |agent: usize| agents.get(agent).map_or(0, |agent| agent.shapes.len());
    for parent_element in root.children("Agent") {
        let (_, parent) = parent_element.reference("Id", Some(&agent_ids));
        for child_element in parent_element.children("Agent") {
            let (_, child) = child_element.reference("Id", Some(&agent_ids));
            if parent.is_some() && parent == child {
                child_element.wrong("Id", "an agent does not touch itself");
            }
            for element in child_element.children("Interaction") {
                let force = read_force(element);
                let (Some(parent), Some(child)) = (parent, child) else { continue };
                let parent_shape = element.place("ParentShape", disks(parent), "parent's shapes");
                let child_shape = element.place("ChildShape", disks(child), "child's shapes");
                let (Some(parent_shape), Some(child_shape)) = (parent_shape, child_shape) else { continue };
                let contact = AgentInteraction { parent, child, parent_shape, child_shape, force }.ordered();
                let key = [contact.parent, contact.child, contact.parent_shape, contact.child_shape];
                put(&mut among_agents, key, contact, element);
            }
        }
        for element in parent_element.children("Wall") {
            let (_, wall) = element.reference("WallId", Some(&wall_ids));
            let corners = wall.and_then(|wall| geometry.walls.get(wall)).map(|wall| wall.corners.len());
            // No face begins at the last corner.
            let corner = corners.and_then(|n| element.place("CornerId", n.saturating_sub(1), "faces"));
            let shape = parent.and_then(|agent| element.place("ShapeId", disks(agent), "agent's shapes"));
            let force = read_force(element);
            if let (Some(agent), Some(shape), Some(wall), Some(corner)) = (parent, shape, wall, corner) {
                let contact = WallInteraction { agent, shape, wall, corner, force };
                put(&mut with_walls, [agent, shape, wall, corner], contact, element);
            }
        }
    }
    Interactions {
        agents: among_agents.into_values().map(|(_, contact)| contact).collect(),
        walls: with_walls.into_values().map(|(_, contact)| contact).collect(),
    }
}

/// Keeps a contact with its line; one that was given before is an error.
fn put<T>(all: &mut BTreeMap<[usize; 4], (u32, T)>, key: [usize; 4], contact: T, element: Element<'_>) {
    match all.entry(key) {
        Entry::Occupied(first) => {
            element.error(format!("duplicate contact, first given at line {}", first.get().0));
        }
        Entry::Vacant(free) => {
            free.insert((element.line(), contact));
        }
    }
}

fn read_force(element: Element<'_>) -> ContactForce {
    ContactForce {
        elongation: element.vector("TangentialRelativeDisplacement"),
        normal: element.vector("Fn"),
        tangential: element.vector("Ft"),
    }
}

impl ContactForce {
    fn texts(&self) -> [String; 3] {
        [self.elongation, self.normal, self.tangential].map(vector)
    }
}

impl AgentInteraction {
    /// Returns the same contact with the lower agent as parent: what acts on the one is the opposite of what acts on the other.
    fn ordered(self) -> AgentInteraction {
        if self.parent <= self.child {
            return self;
        }
        let ContactForce { elongation, normal, tangential } = self.force;
        AgentInteraction {
            parent: self.child,
            child: self.parent,
            parent_shape: self.child_shape,
            child_shape: self.parent_shape,
            force: ContactForce { elongation: -elongation, normal: -normal, tangential: -tangential },
        }
    }
}

/// Returns the text of `AgentInteractions.xml`; agents and geometry give the Ids.
pub fn interactions_xml(agents: &[Agent], geometry: &Geometry, interactions: &Interactions) -> String {
    type OfParent<'a> = (BTreeMap<usize, Vec<&'a AgentInteraction>>, Vec<&'a WallInteraction>);
    let mut parents: BTreeMap<usize, OfParent<'_>> = BTreeMap::new();
    for contact in &interactions.agents {
        parents.entry(contact.parent).or_default().0.entry(contact.child).or_default().push(contact);
    }
    for contact in &interactions.walls {
        parents.entry(contact.agent).or_default().1.push(contact);
    }
    let agent_id = |place: usize| agents.get(place).map_or("", |agent| &agent.id);
    document("Interactions", |out| {
        for (&parent, (children, walls)) in &parents {
            out.element("Agent", &[("Id", agent_id(parent))], |out| {
                for (&child, contacts) in children {
                    out.element("Agent", &[("Id", agent_id(child))], |out| {
                        for contact in contacts {
                            let shapes = [contact.parent_shape, contact.child_shape];
                            let [parent, child] = shapes.map(|shape| shape.to_string());
                            let [elongation, normal, tangential] = contact.force.texts();
                            empty(out, &INTERACTION, &[&parent, &child, &elongation, &normal, &tangential]);
                        }
                    });
                }
                for contact in walls {
                    let wall = geometry.walls.get(contact.wall).map_or("", |wall| &wall.id);
                    let [shape, corner] = [contact.shape, contact.corner].map(|place| place.to_string());
                    let [elongation, normal, tangential] = contact.force.texts();
                    empty(out, &WALL, &[&shape, wall, &corner, &elongation, &normal, &tangential]);
                }
            });
        }
    })
}
