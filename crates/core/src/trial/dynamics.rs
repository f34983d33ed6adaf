//! `AgentDynamics.xml`.

use crate::plane::{Motion, Pose, Twist, Vec2};
use crate::trial::agents::Agent;
use crate::trial::schema::{AttributeValue, Schema};
use crate::trial::xml::{Element, document, empty, given_before, ids_of, vector};
use crate::xml::{number, quoted};
use std::collections::{BTreeMap, HashMap};

/// `<Agent>` of `AgentDynamics.xml`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct AgentDynamics {
    /// \[m\] centre of mass.
    pub position: Vec2,
    /// \[m/s\]
    pub velocity: Vec2,
    /// \[rad\] direction of the gaze.
    pub theta: f64,
    /// \[rad/s\]
    pub omega: f64,
    /// \[N\] propulsion force; zero if the file has no `<Dynamics>`.
    pub fp: Vec2,
    /// \[N.m\] propulsion torque.
    pub mp: f64,
    /// `Active="false"`: it is not there at the start. When it comes, it moves as said here.
    pub absent: bool,
}

pub(crate) static AGENTS: Schema = Schema { name: "Agents", attributes: &[], children: &[&AGENT] };
static AGENT: Schema = Schema {
    name: "Agent",
    attributes: &[("Id", AttributeValue::IdOf("agent")), ("Active", AttributeValue::Word("false"))],
    children: &[&KINEMATICS, &DYNAMICS],
};
static KINEMATICS: Schema = Schema {
    name: "Kinematics",
    attributes: &[
        ("Position", AttributeValue::Point),
        ("Velocity", AttributeValue::Vector),
        ("Theta", AttributeValue::Number),
        ("Omega", AttributeValue::Number),
    ],
    children: &[],
};
static DYNAMICS: Schema = Schema {
    name: "Dynamics",
    attributes: &[("Fp", AttributeValue::Vector), ("Mp", AttributeValue::Number)],
    children: &[],
};

/// Reads the file, in the order of `agents`, which is `None` where they could not be read.
pub(crate) fn read(root: Element<'_>, agents: Option<&[Agent]>) -> Vec<AgentDynamics> {
    let ids = agents.map(|agents| ids_of(agents.iter().map(|agent| &agent.id)));
    let mut lines = HashMap::new();
    let mut found = BTreeMap::new();
    for element in root.children("Agent") {
        let (_, place) = element.reference("Id", ids.as_ref());
        let dynamics = read_agent(element);
        let Some(place) = place else { continue };
        match given_before(&mut lines, place, element) {
            Some(line) => element.wrong("Id", format!("duplicate agent, first given at line {line}")),
            None => drop(found.insert(place, dynamics)),
        }
    }
    for (place, agent) in agents.unwrap_or_default().iter().enumerate() {
        // The second of two equal Ids can find nothing; it is reported where it stands.
        let is_first = ids.as_ref().and_then(|ids| ids.get(&*agent.id)) == Some(&place);
        if is_first && !found.contains_key(&place) {
            root.error(format!("has no <Agent> of Id {}", quoted(&agent.id)));
        }
    }
    found.into_values().collect()
}

fn read_agent(element: Element<'_>) -> AgentDynamics {
    let mut agent = AgentDynamics::of(&Motion::default());
    agent.absent = element.node.has("Active") && element.text("Active") == "false";
    if let Some(kinematics) = element.only("Kinematics") {
        agent.position = kinematics.vector("Position");
        agent.velocity = kinematics.vector("Velocity");
        agent.theta = kinematics.number("Theta");
        agent.omega = kinematics.number("Omega");
    }
    if let Some(drive) = element.at_most_one("Dynamics") {
        agent.fp = drive.vector("Fp");
        agent.mp = drive.number("Mp");
    }
    agent
}

impl AgentDynamics {
    /// Makes those of a body that nobody drives.
    pub fn of(motion: &Motion) -> AgentDynamics {
        let Motion { pose, twist } = motion;
        AgentDynamics {
            position: pose.position,
            velocity: twist.velocity,
            theta: pose.orientation,
            omega: twist.angular_velocity,
            fp: Vec2::zeros(),
            mp: 0.0,
            absent: false,
        }
    }

    /// Returns where it is and how it moves.
    pub fn motion(&self) -> Motion {
        Motion {
            pose: Pose { position: self.position, orientation: self.theta },
            twist: Twist { velocity: self.velocity, angular_velocity: self.omega },
        }
    }
}

/// Choice whether `<Dynamics>` is written. Input files have it; output files of the paper's engine do not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DynamicsElement {
    /// With `<Dynamics Fp Mp>`.
    Written,
    /// `<Kinematics>` only.
    Omitted,
}

/// Returns the text of `AgentDynamics.xml`; `dynamics` in the order of `agents`.
pub fn dynamics_xml(agents: &[Agent], dynamics: &[AgentDynamics], element: DynamicsElement) -> String {
    document("Agents", |out| {
        for (agent, state) in agents.iter().zip(dynamics) {
            let active = state.absent.then_some("false");
            out.element("Agent", &AGENT.values(&[Some(&agent.id), active]), |out| {
                let [position, velocity, fp] = [state.position, state.velocity, state.fp].map(vector);
                let [theta, omega, mp] = [state.theta, state.omega, state.mp].map(number);
                empty(out, &KINEMATICS, &[&position, &velocity, &theta, &omega]);
                if element == DynamicsElement::Written {
                    empty(out, &DYNAMICS, &[&fp, &mp]);
                }
            });
        }
    })
}
