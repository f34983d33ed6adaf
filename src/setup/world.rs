//! Makes an engine world from documents, and documents from a world.

use super::Setup;
use crate::engine::{
    AdvanceError, BodySpec, Contact, Crowded, DiskId, DiskSpec, FaceId, LawTable, Pair, PairLaw, Scene,
    SceneError, State, WallSpec, World, Wrench, elongation_vector,
};
use lemons_core::plane::Motion;
use lemons_core::trial::quoted;
use lemons_core::trial::{
    AgentDynamics, AgentInteraction, ContactForce, Interactions, Material, WallInteraction, stiffness,
};
use std::collections::HashMap;
use thiserror::Error;

/// Why no world can be built from a Trial's documents. A Trial that was read from files can always be built; one whose
/// numbers were edited perhaps cannot.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum WorldError {
    /// Two materials can touch, but their moduli give no stiffness, or they have no `<Contact>`.
    #[error(
        "materials \"{first}\" and \"{second}\" can touch, but have no usable contact: k_n = {normal:?} N/m, \
         k_t = {tangential:?} N/m (both must be positive; is E < 4 G, and is there a <Contact>?)"
    )]
    Contact {
        /// Id of the first material.
        first: String,
        /// Id of the second material.
        second: String,
        /// \[N/m\] k_n, which follows from the moduli.
        normal: f64,
        /// \[N/m\] k_t, which follows from the moduli.
        tangential: f64,
    },
    /// More pairs are near each other than the limit of memory allows.
    #[error("agent {agent:?}: {crowded}")]
    Crowded {
        /// Id of an agent in the middle of them.
        agent: String,
        /// Number of agents and faces near it.
        crowded: Crowded,
    },
    /// There are more bodies, disks or faces than the engine's indices can represent.
    #[error("{0}")]
    Size(SceneError),
}

impl Setup<'_> {
    /// Indices in the table of laws for the Ids of the materials that shapes and walls have. Files may list thousands
    /// of other materials, and the table has a row and a column for each.
    pub(super) fn material_places(&self) -> HashMap<&str, usize> {
        let shapes =
            self.agents.iter().flat_map(|agent| &agent.shapes).map(|shape| shape.material_id.as_str());
        let mut places = HashMap::new();
        for id in shapes.chain(self.geometry.walls.iter().map(|wall| wall.material_id.as_str())) {
            let next = places.len();
            places.entry(id).or_insert(next);
        }
        places
    }

    /// The materials in the order of these indices.
    pub(super) fn materials_placed(&self, places: &HashMap<&str, usize>) -> Vec<&Material> {
        let known = self.materials.intrinsic.iter();
        let mut placed: Vec<(usize, &Material)> =
            known.filter_map(|material| Some((*places.get(material.id.as_str())?, material))).collect();
        placed.sort_by_key(|(place, _)| *place);
        placed.into_iter().map(|(_, material)| material).collect()
    }

    fn laws(&self, places: &HashMap<&str, usize>) -> LawTable {
        let intrinsic = self.materials_placed(places);
        let mut laws = LawTable::new(intrinsic.len());
        for contact in &self.materials.binary {
            let (Some(&first), Some(&second)) = (places.get(&*contact.id1), places.get(&*contact.id2)) else {
                continue;
            };
            let (normal_stiffness, tangential_stiffness) = stiffness(intrinsic[first], intrinsic[second]);
            let usable = |k: f64| k > 0.0 && k.is_finite();
            if usable(normal_stiffness) && usable(tangential_stiffness) {
                laws.set(
                    first,
                    second,
                    PairLaw {
                        normal_stiffness,
                        tangential_stiffness,
                        normal_damping: contact.gamma_normal,
                        tangential_damping: contact.gamma_tangential,
                        friction: contact.kinetic_friction,
                    },
                );
            }
        }
        laws
    }

    /// Returns bodies, walls and laws.
    ///
    /// # Errors
    /// Materials that can touch have no usable contact.
    pub fn scene(&self) -> Result<Scene, WorldError> {
        let places = self.material_places();
        // A Trial uses only known materials; that was checked when it was read.
        let place = |id: &str| places.get(id).copied().unwrap_or(0);
        let bodies: Vec<BodySpec> = self
            .agents
            .iter()
            .map(|agent| BodySpec {
                mass: agent.mass,
                inertia: agent.moment_of_inertia,
                translation_rate: agent.floor_damping,
                rotation_rate: agent.angular_damping,
                disks: agent
                    .shapes
                    .iter()
                    .map(|shape| DiskSpec {
                        radius: shape.radius,
                        position: shape.position,
                        material: place(&shape.material_id),
                    })
                    .collect(),
            })
            .collect();
        let walls: Vec<WallSpec> = self
            .geometry
            .walls
            .iter()
            .map(|wall| WallSpec { material: place(&wall.material_id), corners: wall.corners.clone() })
            .collect();
        Scene::new(&bodies, &walls, &self.laws(&places)).map_err(|error| match error {
            SceneError::MissingLaw { first, second } => {
                let placed = self.materials_placed(&places);
                let (first, second) = (placed[first], placed[second]);
                let (normal, tangential) = stiffness(first, second);
                WorldError::Contact { first: first.id.clone(), second: second.id.clone(), normal, tangential }
            }
            other => WorldError::Size(other),
        })
    }

    /// Returns the state in `AgentDynamics.xml`, with the springs of `AgentInteractions.xml`.
    pub fn state(&self, scene: &Scene) -> State {
        let motions = self.dynamics.iter().map(AgentDynamics::motion);
        let (poses, twists) = motions.map(|motion| (motion.pose, motion.twist)).unzip();
        let mut state = State::new(poses, twists);
        let disk = |agent: usize, shape: usize| DiskId::from(scene.bodies[agent].disks.start + shape);
        state.disk_springs = self
            .interactions
            .agents
            .iter()
            .map(|i| {
                let (first, second) = (disk(i.parent, i.parent_shape), disk(i.child, i.child_shape));
                scene.disk_spring(first, second, i.force.elongation, &state.poses)
            })
            .collect();
        state.disk_springs.sort_by_key(|spring| (spring.first, spring.second));
        state.face_springs = self
            .interactions
            .walls
            .iter()
            .map(|i| {
                let face = FaceId::from(scene.wall_faces[i.wall].start + i.corner);
                scene.face_spring(disk(i.agent, i.shape), face, i.force.elongation, &state.poses)
            })
            .collect();
        state.face_springs.sort_by_key(|spring| (spring.disk, spring.face));
        state
    }

    /// Returns `Fp` and `Mp` of `AgentDynamics.xml`.
    pub fn drive(&self) -> Vec<Wrench> {
        self.dynamics.iter().map(|d| Wrench { force: d.fp, torque: d.mp }).collect()
    }

    /// Returns the error for a world that is too crowded, with the Id of an agent concerned.
    pub fn too_crowded(&self, crowded: Crowded) -> WorldError {
        WorldError::Crowded { agent: self.agents[crowded.body.index()].id.clone(), crowded }
    }

    /// Returns the message of a failed step, with the Id of the agent concerned.
    pub fn name_body(&self, error: &AdvanceError) -> String {
        match error {
            AdvanceError::NotFinite { body } | AdvanceError::Crowded(Crowded { body, .. }) => {
                match self.agents.get(body.index()) {
                    Some(agent) => format!("agent {:?}: {error}", agent.id),
                    None => error.to_string(),
                }
            }
            _ => error.to_string(),
        }
    }

    /// Returns the names of a pair: the Ids of agents and walls.
    pub fn name_pair(&self, scene: &Scene, pair: Pair) -> String {
        let agent = |disk: DiskId| &self.agents[scene.body_of(disk).index()].id;
        match pair {
            Pair::Disks { first, second } => {
                format!("agents {} and {}", quoted(agent(first)), quoted(agent(second)))
            }
            Pair::Face { disk, face, .. } => {
                let wall = &self.geometry.walls[scene.faces[face.index()].wall.index()];
                format!("agent {} and a corner of wall {}", quoted(agent(disk)), quoted(&wall.id))
            }
        }
    }

    /// Describes pairs whose centres coincide: the first pair and the number of the others; `None` without pairs.
    pub fn name_coincident(&self, scene: &Scene, pairs: &[Pair]) -> Option<String> {
        let whose = self.name_pair(scene, *pairs.first()?);
        let others = match pairs.len() {
            1 => String::new(),
            2 => ", and one more pair".to_owned(),
            count => format!(", and {} more pairs", count - 1),
        };
        Some(format!(
            "{whose} have their centres at one place{others}: no force acts between them as long as this is so"
        ))
    }

    /// Returns the engine's world at the start of this Trial.
    ///
    /// # Errors
    /// Materials that can touch have no usable contact, or too many agents are at one place.
    pub fn world(&self) -> Result<World, WorldError> {
        let scene = self.scene()?;
        let state = self.state(&scene);
        let world = World::new(scene, state, self.parameters.time_step_mechanical);
        let mut world = world.map_err(|crowded| self.too_crowded(crowded))?;
        world.drive = self.drive();
        Ok(world)
    }
}

/// Returns the content of `AgentDynamics.xml` for a world, including the drive.
pub fn dynamics_of(world: &World) -> Vec<AgentDynamics> {
    let state = world.state();
    let motions = state.poses.iter().zip(&state.twists).zip(&world.drive);
    motions
        .map(|((&pose, &twist), drive)| AgentDynamics {
            fp: drive.force,
            mp: drive.torque,
            ..AgentDynamics::of(&Motion { pose, twist })
        })
        .collect()
}

/// Returns the content of `AgentInteractions.xml` for a world: each pair once, with the lower agent as parent.
pub fn interactions_of(world: &World) -> Interactions {
    let scene = world.scene();
    let owner = |disk: DiskId| {
        let body = scene.body_of(disk).index();
        (body, disk.index() - scene.bodies[body].disks.start)
    };
    let mut interactions = Interactions::default();
    for contact in &world.contacts().contacts {
        let force = force_of(contact);
        match contact.pair {
            Pair::Disks { first, second } => {
                let ((parent, parent_shape), (child, child_shape)) = (owner(first), owner(second));
                let interaction = AgentInteraction { parent, child, parent_shape, child_shape, force };
                interactions.agents.push(interaction);
            }
            Pair::Face { disk, face, .. } => {
                let (agent, shape) = owner(disk);
                let wall = scene.faces[face.index()].wall.index();
                let corner = face.index() - scene.wall_faces[wall].start;
                interactions.walls.push(WallInteraction { agent, shape, wall, corner, force });
            }
        }
    }
    interactions
}

fn force_of(contact: &Contact) -> ContactForce {
    let tangent = contact.normal.perp();
    ContactForce {
        elongation: elongation_vector(tangent, contact.elongation),
        normal: contact.normal * contact.normal_force,
        tangential: tangent * contact.tangential_force,
    }
}
