//! The *Trial* directory: the XML files of the paper's section 3.1 and App. C, as typed documents.
//!
//! A [`Trial`] holds what the files say, in their own words and order, checked. It becomes an
//! engine world by [`Trial::world`]; a parameter of the FMU is an edit of this document.

use crate::engine::Vec2;
use std::path::PathBuf;

/// A Trial directory, read and checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// The directory's own name.
    pub name: String,
    /// Where it was read from.
    pub directory: PathBuf,
    /// `Parameters.xml`
    pub parameters: Parameters,
    /// `Materials.xml`
    pub materials: Materials,
    /// `Geometry.xml`
    pub geometry: Geometry,
    /// `Agents.xml`, in file order.
    pub agents: Vec<Agent>,
    /// `AgentDynamics.xml`, in the order of `agents` (whatever the order in the file).
    pub dynamics: Vec<AgentDynamics>,
    /// `AgentInteractions.xml`; empty when there is no such file.
    pub interactions: Interactions,
}

/// `Parameters.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    /// `Directories/Static`, as written; relative to the Trial directory.
    pub static_directory: String,
    /// `Directories/Dynamic`, as written; relative to the Trial directory.
    pub dynamic_directory: String,
    /// \[s\] `Times/TimeStep`: duration of one decisional loop, the communication step.
    pub time_step: f64,
    /// \[s\] `Times/TimeStepMechanical`: step of the integrator, at most `time_step`.
    pub time_step_mechanical: f64,
}

/// `Materials.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Materials {
    /// `<Intrinsic>`
    pub intrinsic: Vec<Material>,
    /// `<Binary>`
    pub binary: Vec<Contact>,
}

/// `<Material>`.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Unique among the materials.
    pub id: String,
    /// \[N/m\] 2D Young modulus.
    pub young_modulus: f64,
    /// \[N/m\] 2D shear modulus.
    pub shear_modulus: f64,
}

/// `<Contact>`: what two materials do to each other; the order of the two does not matter.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// First material.
    pub id1: String,
    /// Second material, perhaps the same.
    pub id2: String,
    /// \[kg/s\] damping along the normal.
    pub gamma_normal: f64,
    /// \[kg/s\] damping along the tangent.
    pub gamma_tangential: f64,
    /// \[1\] Coulomb's coefficient.
    pub kinetic_friction: f64,
}

/// `Geometry.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Geometry {
    /// \[m\] `<Dimensions Lx Ly>`: the size of the drawn area; the mechanics does not use it.
    pub dimensions: Option<Vec2>,
    /// In file order.
    pub walls: Vec<Wall>,
}

/// `<Wall>`: a polyline without thickness, solid from both sides.
#[derive(Debug, Clone, PartialEq)]
pub struct Wall {
    /// Unique among the walls.
    pub id: String,
    /// Id of its material.
    pub material_id: String,
    /// \[m\] at least two; closed when the first stands again at the end.
    pub corners: Vec<Vec2>,
}

/// `<Agent>` of `Agents.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct Agent {
    /// `Type`, as written ("pedestrian").
    pub kind: Option<String>,
    /// Unique among the agents.
    pub id: String,
    /// \[kg\]
    pub mass: f64,
    /// \[m\] stature; the mechanics does not use it.
    pub height: Option<f64>,
    /// \[kg.m2\] about the centre of mass.
    pub moment_of_inertia: f64,
    /// \[1/s\] relaxation rate 1/t_transl, ≥ 0.
    pub floor_damping: f64,
    /// \[1/s\] relaxation rate 1/t_rot, ≥ 0.
    pub angular_damping: f64,
    /// At least one; from the left shoulder to the right one.
    pub shapes: Vec<Shape>,
}

/// `<Shape>`: a disk.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// \[m\]
    pub radius: f64,
    /// Id of its material.
    pub material_id: String,
    /// \[m\] offset from the centre of mass, at the orientation that the shapes themselves show.
    pub position: Vec2,
}

/// `<Agent>` of `AgentDynamics.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct AgentDynamics {
    /// \[m\] centre of mass.
    pub position: Vec2,
    /// \[m/s\]
    pub velocity: Vec2,
    /// \[rad\] direction of the gaze.
    pub theta: f64,
    /// \[rad/s\]
    pub omega: f64,
    /// \[N\] propulsion force; zero where the file has no `<Dynamics>`.
    pub fp: Vec2,
    /// \[N.m\] propulsion torque.
    pub mp: f64,
}

/// `AgentInteractions.xml`: the contacts at one instant, each pair once.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Interactions {
    /// Between two agents.
    pub agents: Vec<AgentInteraction>,
    /// Between an agent and a wall.
    pub walls: Vec<WallInteraction>,
}

/// `<Interaction>`: one contact of two agents. Agents and shapes are 0-based places in `Agents.xml`.
#[derive(Debug, Clone, PartialEq)]
pub struct AgentInteraction {
    /// Place of the agent that receives the force; the lower of the two.
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

/// What a contact does to the agent that receives the force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactForce {
    /// \[m\] `TangentialRelativeDisplacement`: elongation of the tangential spring.
    pub elongation: Vec2,
    /// \[N\] `Fn`
    pub normal: Vec2,
    /// \[N\] `Ft`
    pub tangential: Vec2,
}
