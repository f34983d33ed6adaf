//! Makes an engine world from documents, and documents from a world.

use super::Setup;
use crate::engine::{
    AdvanceError, BodyId, BodySpec, Contact, Crowded, DiskId, DiskSpec, FaceId, LawTable, Levels, Pair,
    PairLaw, Scene, State, WallId, WallSpec, World, Wrench, elongation_vector,
};
use lemons_core::message::{Message, message};
use lemons_core::plane::{InPlane, Motion, Pose, Twist, Vec2, segments_touch};
use lemons_core::rule::sentences::*;
use lemons_core::trial::{
    Agent, AgentDynamics, AgentInteraction, ContactForce, Interactions, Link, LinkPassage, Material,
    ShapeElement, Wall, WallInteraction, pairs_that_touch, stiffness,
};
use std::collections::{HashMap, HashSet};
use thiserror::Error;

/// Part of a disk's radius that no wall which is there reaches into: contacts are less deep.
const DEEP: f64 = 0.9;

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
}

impl Setup<'_> {
    /// Returns the materials that shapes and walls have, in the order of the table of laws. Files may list thousands of
    /// others, and the table has a row and a column for each.
    pub(super) fn used_materials(&self) -> Vec<&Material> {
        let shapes = self.agents.iter().flat_map(|agent| &agent.shapes).map(|shape| &*shape.material_id);
        let ids = shapes.chain(self.geometry.walls.iter().map(|wall| &*wall.material_id));
        let known: HashMap<&str, &Material> =
            self.materials.intrinsic.iter().map(|material| (&*material.id, material)).collect();
        let mut used = HashSet::new();
        ids.filter(|id| used.insert(*id)).filter_map(|id| known.get(id).copied()).collect()
    }

    /// Returns bodies, walls and laws.
    ///
    /// # Errors
    /// Materials that can touch have no usable contact.
    pub fn scene(&self) -> Result<Scene, WorldError> {
        let materials = self.used_materials();
        let places: HashMap<&str, usize> =
            materials.iter().enumerate().map(|(place, material)| (&*material.id, place)).collect();
        // A Trial uses only known materials; that was checked when it was read.
        let place = |id: &str| places.get(id).copied().unwrap_or(0);
        let disk = |shape: &ShapeElement| DiskSpec {
            radius: shape.radius,
            position: shape.position,
            material: place(&shape.material_id),
        };
        let body = |agent: &Agent| BodySpec {
            mass: agent.mass,
            inertia: agent.moment_of_inertia,
            translation_rate: agent.floor_damping,
            across_rate: agent.floor_damping_across,
            rotation_rate: agent.angular_damping,
            disks: agent.shapes.iter().map(disk).collect(),
        };
        let bodies: Vec<BodySpec> = self.agents.iter().map(body).collect();
        let wall =
            |wall: &Wall| WallSpec { material: place(&wall.material_id), corners: wall.corners.clone() };
        let walls: Vec<WallSpec> = self.geometry.walls.iter().map(wall).collect();

        let contacts = self.materials.binary.iter().filter_map(|contact| {
            let (one, other) = (*places.get(&*contact.id1)?, *places.get(&*contact.id2)?);
            Some(((one.min(other), one.max(other)), contact))
        });
        let contacts: HashMap<_, _> = contacts.collect();
        let shapes = bodies.iter().enumerate();
        let shapes: Vec<_> =
            shapes.flat_map(|(b, body)| body.disks.iter().map(move |disk| (b, disk.material))).collect();
        let mut laws = LawTable::new(materials.len());
        for pair in pairs_that_touch(&shapes, &walls.iter().map(|wall| wall.material).collect()) {
            let (first, second) = (materials[pair.0], materials[pair.1]);
            let (normal, tangential) = stiffness(first, second);
            let usable = [normal, tangential].iter().all(|&k| k > 0.0 && k.is_finite());
            let Some(contact) = contacts.get(&pair).filter(|_| usable) else {
                let (first, second) = (first.id.clone(), second.id.clone());
                return Err(WorldError::Contact { first, second, normal, tangential });
            };
            let law = PairLaw {
                normal_stiffness: normal,
                tangential_stiffness: tangential,
                normal_damping: contact.gamma_normal,
                tangential_damping: contact.gamma_tangential,
                friction: contact.kinetic_friction,
            };
            laws.set(pair.0, pair.1, law);
        }
        let longest: Vec<_> = self.geometry.walls.iter().map(|wall| wall.panel_length).collect();
        let scene = Scene::new(&bodies, &walls, laws).with_panels(&longest);
        let scene = scene.with_grounds(&self.geometry.grounds);
        Ok(match self.levels() {
            Some(levels) => scene.with_levels(levels),
            None => scene,
        })
    }

    /// Returns the heights of disks and walls; none in a plan view in which no load on a chest is to be found.
    fn levels(&self) -> Option<Levels> {
        let disks = || self.agents.iter().map(|agent| agent.shapes.iter().map(|shape| shape.heights));
        let walls = || self.geometry.walls.iter().map(|wall| wall.heights);
        let is_plan = disks().flatten().chain(walls()).all(|heights| heights.is_all());
        let chests: Vec<_> = self.agents.iter().map(|agent| agent.chest_height).collect();
        if is_plan && !self.agents.iter().any(Agent::has_chest) {
            return None;
        }
        let bodies: Vec<Vec<_>> = disks().map(Iterator::collect).collect();
        Some(Levels::new(self.materials.load_length, &bodies, walls().collect(), &chests))
    }

    /// Returns the state in `AgentDynamics.xml`, with the springs of `AgentInteractions.xml`.
    pub fn state(&self, scene: &Scene) -> State {
        let motions = self.dynamics.iter().map(AgentDynamics::motion);
        let (poses, twists) = motions.map(|motion| (motion.pose, motion.twist)).unzip();
        let mut state = State::new(poses, twists);
        let disk = |agent: usize, shape: usize| DiskId::from(scene.bodies[agent].disks.start + shape);
        let among_agents = self.interactions.agents.iter().map(|i| {
            let (first, second) = (disk(i.parent, i.parent_shape), disk(i.child, i.child_shape));
            scene.disk_spring(first, second, i.force.elongation, &state.poses)
        });
        let with_walls = self.interactions.walls.iter().map(|i| {
            let face = FaceId::from(scene.wall_faces[i.wall].start + i.corner);
            scene.face_spring(disk(i.agent, i.shape), face, i.force.elongation, &state.poses)
        });
        (state.disk_springs, state.face_springs) = (among_agents.collect(), with_walls.collect());
        state.disk_springs.sort_by_key(|spring| (spring.first, spring.second));
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
        let agent = match error {
            AdvanceError::NotFinite { body } | AdvanceError::Crowded(Crowded { body, .. }) => {
                self.agents.get(body.index())
            }
            _ => None,
        };
        agent.map_or(error.to_string(), |agent| format!("agent {:?}: {error}", agent.id))
    }

    /// Returns the Id of the agent whose body has a disk.
    fn name_of(&self, scene: &Scene, disk: DiskId) -> &str {
        &self.agents[scene.body_of(disk).index()].id
    }

    /// Returns the Id of the wall that has a face.
    pub(super) fn name_of_wall(&self, scene: &Scene, face: FaceId) -> &str {
        &self.geometry.walls[scene.faces[face.index()].wall.index()].id
    }

    /// Returns the names of a pair: the Ids of agents and walls; `corner`: of a wall it is one.
    pub(super) fn name_pair(&self, scene: &Scene, pair: Pair, corner: bool) -> Message {
        match pair {
            Pair::Disks { first, second } => {
                message!(TWO_AGENTS, one = self.name_of(scene, first), other = self.name_of(scene, second))
            }
            Pair::Face { disk, face, .. } => {
                let (agent, wall) = (self.name_of(scene, disk), self.name_of_wall(scene, face));
                if corner {
                    message!(AGENT_AND_CORNER, agent, wall)
                } else {
                    message!(AGENT_AND_WALL, agent, wall)
                }
            }
        }
    }

    /// Describes pairs whose centres coincide: the first pair and the number of the others; `None` without pairs.
    pub fn name_coincident(&self, scene: &Scene, pairs: &[Pair]) -> Option<Message> {
        let whose = self.name_pair(scene, *pairs.first()?, true);
        let others = match pairs.len() {
            1 => None,
            2 => Some(message!(ONE_PAIR_MORE)),
            count => Some(message!(PAIRS_MORE, count = count - 1)),
        };
        Some(message!(SAME_PLACE, whose, others))
    }

    /// Opens and closes the walls of a world: a door is open if the Trial says so for a time \[s\], and it is not `shut`,
    /// by its place among the doors. A wall that closes waits until nobody is in it.
    ///
    /// # Errors
    /// Too many agents are at one place.
    pub fn open_and_close(
        &self,
        time: f64,
        shut: impl Fn(usize) -> bool,
        world: &mut World,
    ) -> Result<(), WorldError> {
        let mut present = world.present_walls().to_vec();
        for (door, (w, wall)) in self.geometry.doors().enumerate() {
            let open = wall.is_open(time) && !shut(door);
            present[w] = !open && (present[w] || world.is_free(WallId::from(w), 1.0));
        }
        if present == world.present_walls() {
            return Ok(());
        }
        world.set_present_walls(&present).map_err(|crowded| self.too_crowded(crowded))
    }

    /// Moves who has walked over a link to its other side, if there is room; else they wait. It is the end of a step: who
    /// decides sees people where they are in the next one.
    ///
    /// # Errors
    /// Too many agents are at one place.
    pub fn carry_over_links(&self, world: &mut World) -> Result<(), WorldError> {
        let passages: Vec<LinkPassage> = self.geometry.links.iter().flat_map(Link::passages).collect();
        if passages.is_empty() {
            return Ok(());
        }
        let over = |b: &usize| {
            let pose = world.state().poses[*b];
            // Behind a wall is another room.
            let is_open = |passage: &&LinkPassage| {
                let (at, foot) = (pose.position, passage.foot(pose.position));
                !world.scene().faces.iter().any(|face| segments_touch(at, foot, face.start, face.end))
            };
            let beyond = passages.iter().filter(|passage| passage.is_beyond(pose.position));
            let passage = beyond.into_iter().find(is_open)?;
            let twist = world.state().twists[*b];
            let line = passage.place(passage.foot(pose.position));
            Some((BodyId::from(*b), passage.carried(Motion { pose, twist }), line))
        };
        let there = (0..self.agents.len()).filter(|&b| world.present()[b]);
        let moved: Vec<(BodyId, Motion, Vec2)> = there.filter_map(|b| over(&b)).collect();
        world.relocate(&moved).map_err(|crowded| self.too_crowded(crowded))
    }

    /// Returns which walls are there at a time \[s\], of doors those that are closed or `shut`, if nothing is known of before:
    /// a closed one is not there, if somebody is in it deeper than who leans on it.
    pub fn walls_at(&self, time: f64, shut: impl Fn(usize) -> bool, world: &World) -> Vec<bool> {
        let mut present = vec![true; self.geometry.walls.len()];
        for (door, (w, wall)) in self.geometry.doors().enumerate() {
            present[w] = (!wall.is_open(time) || shut(door)) && world.is_free(WallId::from(w), DEEP);
        }
        present
    }

    /// Returns the engine's world at the start of this Trial, with the people and walls that are there at 0 s.
    ///
    /// # Errors
    /// Materials that can touch have no usable contact, or too many agents are at one place.
    pub fn world(&self) -> Result<World, WorldError> {
        let scene = self.scene()?;
        let state = self.state(&scene);
        let present = self.dynamics.iter().map(|own| !own.absent).collect();
        let world = World::of_present(scene, state, self.parameters.time_step_mechanical, present);
        let mut world = world.map_err(|crowded| self.too_crowded(crowded))?;
        world.drive = self.drive();
        self.begin(0.0, |_| false, &mut world)?;
        Ok(world)
    }

    /// Opens and closes the walls of a world that begins at a time \[s\]: see [`Setup::walls_at`].
    ///
    /// # Errors
    /// Too many agents are at one place.
    pub fn begin(
        &self,
        time: f64,
        shut: impl Fn(usize) -> bool,
        world: &mut World,
    ) -> Result<(), WorldError> {
        let present = self.walls_at(time, shut, world);
        if present == world.present_walls() {
            return Ok(());
        }
        let crowded = |crowded| self.too_crowded(crowded);
        world.set_present_walls(&present).map_err(crowded)?;
        // Nobody was exposed to a door that is open.
        world.restore(world.state().clone()).map_err(crowded)
    }
}

/// Returns the content of `AgentDynamics.xml` for a world, including the drive.
pub fn dynamics_of(world: &World) -> Vec<AgentDynamics> {
    let state = world.state();
    let one = |((&pose, &twist), drive): ((&Pose, &Twist), &Wrench)| AgentDynamics {
        fp: drive.force,
        mp: drive.torque,
        ..AgentDynamics::of(&Motion { pose, twist })
    };
    state.poses.iter().zip(&state.twists).zip(&world.drive).map(one).collect()
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
    let tangent = contact.normal.left();
    ContactForce {
        elongation: elongation_vector(tangent, contact.elongation),
        normal: contact.normal * contact.normal_force,
        tangential: tangent * contact.tangential_force,
    }
}
