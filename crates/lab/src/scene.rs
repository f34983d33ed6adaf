//! The scene that a page draws of a Trial: everything that does not move.

use crate::frame::overlapping;
use crate::kinds;
use crate::mechanics::{Contact, Material2d};
use crate::run::LabRun;
use crowd_mechanics::setup::Setup;
use lemons_core::message::Message;
use lemons_core::plane::{Ring, Vec2, segments_cross, turn, vec2};
use lemons_core::trial::{self, Trial};
use lemons_decision::rule::Waypoint;
use lemons_decision::target::Target;
use lemons_people::{Person, Sex, mechanical_step_for};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// \[m\] Above all people.
const HIGHEST: f64 = 3.0;

/// A scene.
#[derive(Default, Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct Scene {
    /// The number of its run.
    pub run: u32,
    name: String,
    agents: Vec<AgentShown>,
    /// Things that go along with people of each kind.
    kinds: BTreeMap<String, Vec<String>>,
    walls: Vec<WallShown>,
    /// Lines with which slopes and stairs are drawn.
    grounds: Vec<Vec<[f64; 2]>>,
    /// Lines of links.
    links: Vec<Vec<[f64; 2]>>,
    step: f64,
    mechanical_step: f64,
    /// The longest stable mechanical step; `None` if nothing can touch.
    stable: Option<f64>,
    /// The longest mechanical step without a warning.
    longest: Option<f64>,
    /// The one that a crowd gets.
    advised: Option<f64>,
    /// About how large errors of positions are with the mechanical step.
    error: Option<f64>,
    /// Of changed materials and steps.
    #[cfg_attr(feature = "typescript", ts(as = "Vec<crate::reply::MessageShown>"))]
    pub warnings: Vec<Message>,
    materials: Vec<Material2d>,
    contacts: Vec<Contact<f64>>,
    /// Whether the load on chests is found.
    chests: bool,
    /// \[m\] Levels of people, from the lowest: bottom and top. None in the plan.
    levels: Vec<[f64; 2]>,
    /// How many numbers a frame has of each agent besides ([`crate::loads`]).
    further: usize,
    /// Agents that overlap others or walls at the start.
    overlapping: BTreeSet<usize>,
    /// The deepest overlap at the start.
    overlap: f64,
    /// Ids of those who get a force of their own over time.
    pushed: Vec<String>,
    /// Whether people walk, on ways or to exits and goals.
    walk: bool,
    ways: Vec<Vec<Waypoint>>,
    /// Where ways cross walls that never open, with the place of each way: people walk straight from point to point.
    crossed: Vec<(usize, [f64; 2])>,
    /// Exits, then goals.
    targets: Vec<Target>,
    /// How many have an exit.
    leaving: usize,
    /// A line 1 m beyond each door of a crowd's room.
    pub beyond_doors: Vec<[[f64; 2]; 2]>,
    /// How the people of a crowd were drawn; `None` if only their disks are known.
    people: Option<Vec<Option<PersonDrawn>>>,
}

/// An agent of a scene.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
struct AgentShown {
    id: String,
    /// \[kg\] Of all, with what goes along.
    mass: f64,
    disks: Vec<[f64; 3]>,
    /// \[m\] Bottom and top of each disk, in levels.
    #[cfg_attr(feature = "typescript", ts(optional))]
    #[serde(skip_serializing_if = "Option::is_none")]
    heights: Option<Vec<[f64; 2]>>,
    kind: Option<String>,
    /// \[m/s\] Desired speed, if somebody says it.
    speed: Option<f64>,
    things: Option<kinds::Things>,
    seated: Option<Vec<[f64; 3]>>,
}

/// A wall of a scene.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
struct WallShown {
    id: String,
    corners: Vec<[f64; 2]>,
    /// Closed, with nobody in it at the start, and not around all other walls.
    obstacle: bool,
    /// \[s\] Times from which to which it is open; without, never.
    #[cfg_attr(feature = "typescript", ts(as = "Option<Vec<[f64; 2]>>", optional))]
    #[serde(skip_serializing_if = "Option::is_none")]
    open: Option<trial::OpeningTimes>,
    /// \[m\] Bottom and top; without, it has no end.
    #[cfg_attr(feature = "typescript", ts(optional))]
    #[serde(skip_serializing_if = "Option::is_none")]
    heights: Option<[f64; 2]>,
}

/// Returns whether a closed line \[m\] of a Trial has nobody in it at the start, and is not around all walls.
fn is_obstacle(trial: &Trial, line: &[Vec2]) -> bool {
    let Some(ring) = Ring::of_closed(line) else { return false };
    let bounds = ring.bounds();
    let within = |place: Vec2| bounds.contains(place) && ring.contains(place);
    let beyond = |wall: &trial::Wall| !wall.corners.iter().all(|corner| bounds.contains(*corner));
    trial.geometry.walls.iter().any(beyond) && !trial.dynamics.iter().any(|here| within(here.position))
}

/// Returns where the legs of ways \[m\] cross walls of a Trial that never open.
fn crossed(trial: &Trial, ways: &[Vec<Waypoint>]) -> Vec<(usize, [f64; 2])> {
    let walls: Vec<&[Vec2]> =
        trial.geometry.walls.iter().filter(|wall| wall.open.is_none()).map(|wall| &*wall.corners).collect();
    let sides = || walls.iter().flat_map(|corners| corners.windows(2));
    let mut found = Vec::new();
    for (way, points) in ways.iter().enumerate() {
        for leg in points.windows(2) {
            let [a, b] = [0, 1].map(|k| vec2(leg[k].x, leg[k].y));
            for side in sides().filter(|side| segments_cross(a, b, side[0], side[1])) {
                let [from, to] = [a, b].map(|end| turn(side[0], side[1], end));
                found.push((way, (a + (b - a) * (from / (from - to))).into()));
            }
        }
    }
    found
}

/// Measures of somebody in a crowd.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
struct PersonDrawn {
    sex: Sex,
    breadth: f64,
    depth: f64,
    stature: f64,
    mass: f64,
}

/// \[m\] Bottom and top, as numbers: what has no top ends above all people.
fn ends(of: &trial::Heights) -> [f64; 2] {
    [of.bottom, of.top.min(HIGHEST)]
}

/// Returns the walls' corners \[m\]; each agent's Id, mass \[kg\] and disks (x, y, radius \[m\], in the body's frame), its
/// kind with what goes along ([`kinds`]), its desired speed \[m/s\], and measures where they are known; who overlaps; who
/// is pushed; ways, exits and goals of those who walk, and how many leave; the steps, materials and contacts. Of a run at
/// its start; [`crate::Lab`] adds its number, warnings, and lines beyond doors.
pub(crate) fn of(run: &LabRun) -> Scene {
    let loaded = &run.loaded;
    let trial = &loaded.trial;
    let in_levels = !run.loads.levels.is_empty();
    let agent = |(k, agent): (usize, &trial::Agent)| {
        // A Trial may show its disks at another orientation than 0.
        let disks = agent.disks_facing_x().into_iter();
        let made = loaded.people.as_ref().and_then(|people| people[k].member());
        let planned = loaded.plan.as_ref().map(|plan| plan.agents[k].walker.desired_speed);
        AgentShown {
            id: agent.id.clone(),
            mass: agent.mass,
            disks: disks.map(|(place, radius)| [place.x, place.y, radius]).collect(),
            heights: in_levels.then(|| agent.shapes.iter().map(|disk| ends(&disk.heights)).collect()),
            kind: agent.kind.clone(),
            speed: planned.or_else(|| made.map(|member| member.speed)),
            things: kinds::things(agent),
            seated: kinds::seated(agent, made),
        }
    };
    let corners = |line: &[Vec2]| line.iter().copied().map(Into::into).collect();
    let wall = |wall: &trial::Wall| WallShown {
        id: wall.id.clone(),
        corners: corners(&wall.corners),
        obstacle: is_obstacle(trial, &wall.corners),
        open: wall.open.clone(),
        heights: Some(ends(&wall.heights)).filter(|_| !wall.heights.is_all()),
    };
    let person = |agent: &lemons_people::CrowdMember| {
        let Person { sex, breadth, depth, stature, mass } = *agent.everybody().first()?;
        Some(PersonDrawn { sex, breadth, depth, stature, mass })
    };
    let plan = loaded.plan.as_ref();
    let ways: Vec<Vec<Waypoint>> =
        plan.map_or_else(Vec::new, |plan| plan.ways_of_points(100).into_iter().map(<[_]>::to_vec).collect());
    let mut pushed: Vec<String> = loaded.table.agents().map(str::to_owned).collect();
    pushed.sort_unstable();
    let of_people: BTreeSet<&str> =
        trial.agents.iter().flat_map(|agent| &agent.shapes).map(|disk| &*disk.material_id).collect();
    let of_walls = trial.geometry.walls.iter().map(|wall| &*wall.material_id);
    let used: BTreeSet<&str> = of_people.iter().copied().chain(of_walls).collect();
    let materials = trial.materials.intrinsic.iter().filter(|of| used.contains(&*of.id));
    let material = |of: &trial::Material| Material2d {
        id: of.id.clone(),
        young_modulus: of.young_modulus,
        shear_modulus: of.shear_modulus,
    };
    let contacts = trial.materials.binary.iter().filter(|of| {
        let pair = [&*of.id1, &*of.id2];
        pair.iter().all(|id| used.contains(id)) && pair.iter().any(|id| of_people.contains(id))
    });
    let contact = |of: &trial::ContactCoefficients| Contact {
        id1: of.id1.clone(),
        id2: of.id2.clone(),
        gamma_normal: of.gamma_normal,
        gamma_tangential: of.gamma_tangential,
        kinetic_friction: of.kinetic_friction,
    };
    let steps = Setup::of(trial).steps();
    let steps = steps.as_ref();
    let (overlapping, _, overlap) = overlapping(run.world(), None);
    Scene {
        name: trial.name.clone(),
        agents: trial.agents.iter().enumerate().map(agent).collect(),
        kinds: kinds::parts(trial),
        walls: trial.geometry.walls.iter().map(wall).collect(),
        grounds: trial
            .geometry
            .grounds
            .iter()
            .flat_map(trial::Ground::lines)
            .map(|line| corners(&line))
            .collect(),
        links: trial.geometry.links.iter().flat_map(|link| link.lines).map(|line| corners(&line)).collect(),
        step: trial.parameters.time_step,
        mechanical_step: trial.parameters.time_step_mechanical,
        stable: steps.map(|steps| steps.stable()),
        longest: steps.map(|steps| steps.longest()),
        advised: steps.and_then(|steps| steps.proposed()).map(|_| mechanical_step_for(trial)),
        error: steps.map(|steps| steps.error(trial.parameters.time_step_mechanical)),
        materials: materials.map(material).collect(),
        contacts: contacts.map(contact).collect(),
        chests: run.loads.chests,
        levels: run.loads.levels.iter().map(ends).collect(),
        further: run.loads.columns(),
        overlapping,
        overlap,
        pushed,
        walk: plan.is_some(),
        crossed: crossed(trial, &ways),
        ways,
        targets: plan.map_or_else(Vec::new, |plan| plan.targets.clone()),
        leaving: plan.map_or(0, |plan| plan.leaving().into_iter().filter(|leaves| *leaves).count()),
        people: loaded.people.as_ref().map(|people| people.iter().map(person).collect()),
        ..Scene::default()
    }
}
