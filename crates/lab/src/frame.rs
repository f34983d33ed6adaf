//! Frames: what pages keep of a run, and send back to ask about; who overlaps and who crosses a line.

use crate::{Refused, Reply, require};
use crowd_mechanics::engine::{Pair, World};
use crowd_mechanics::setup::Setup;
use lemons_core::plane::{InPlane, Motion, Pose, Twist, Vec2, vec2};
use lemons_core::trial::{Interactions, Link, Trial, carried_from};
use lemons_people::placing::TOLERANCE;
use lemons_results::Frame;
use lemons_results::columns::Effect;
use lemons_results::measure::{CountingLine, Way};
use serde::Serialize;
use std::collections::BTreeSet;

/// Numbers of an agent in a frame: x, y \[m\], orientation \[rad\], velocity along x and y \[m/s\], angular velocity
/// \[rad/s\], mean squeeze of the last communication step \[N\], number of contacts, the part of the squeeze by walls
/// \[N\], x and y of the middle of the feet \[m\], 1 for who wants to get on and else 0. The place of who has left is not
/// a number, nor are place and velocity of who has not come yet, nor feet where people have no legs.
pub const COLUMNS: usize = 12;

/// Returns a frame as bytes: [`COLUMNS`] doubles for each agent, little-endian, then further ones
/// ([`crate::loads::Loads::numbers`]), which pages do not send back. `going`: who wants to get on.
pub fn bytes(frame: &Frame, going: &[bool], further: &[f64]) -> Vec<u8> {
    let numbers = (0..frame.agents.len()).flat_map(|agent| {
        const NOWHERE: Vec2 = vec2(f64::NAN, f64::NAN);
        let Motion { pose, twist: Twist { velocity, angular_velocity } } = frame.agents[agent];
        let at = if frame.is_there(agent) { pose.position } else { NOWHERE };
        let velocity = if frame.is_outside(agent) { NOWHERE } else { velocity };
        let effect = |effect| frame.effects.get(effect, agent).unwrap_or_default();
        let contacts = effect(Effect::AgentContacts) + effect(Effect::WallContacts);
        let feet = frame.legs.as_ref().map_or(NOWHERE, |legs| legs[agent].feet);
        let [mean, by_walls] = [Effect::MeanNormalForce, Effect::MeanWallForce].map(effect);
        let goes = f64::from(going[agent]);
        let [x, y, vx, vy] = [at.x, at.y, velocity.x, velocity.y];
        [x, y, pose.orientation, vx, vy, angular_velocity, mean, contacts, by_walls, feet.x, feet.y, goes]
    });
    numbers.chain(further.iter().copied()).flat_map(f64::to_le_bytes).collect()
}

/// Reads a frame of so many people: where they are, how they move, and who is there.
///
/// # Errors
/// The bytes are of another length.
pub fn frame(bytes: &[u8], people: usize) -> Result<Frame, Refused> {
    require(bytes.len() == 8 * COLUMNS * people, || {
        format!("a frame of {people} people has not {} bytes", bytes.len())
    })?;
    let numbers = numbers(bytes);
    let (rows, _) = numbers.as_chunks::<COLUMNS>();
    let motion = |&[x, y, orientation, vx, vy, angular_velocity, ..]: &[f64; COLUMNS]| Motion {
        pose: Pose { position: vec2(x, y), orientation },
        twist: Twist { velocity: vec2(vx, vy), angular_velocity },
    };
    let agents: Vec<Motion> = rows.iter().map(motion).collect();
    let active = agents.iter().map(|motion| motion.pose.position.is_finite()).collect();
    Ok(Frame { agents, active: Some(active), ..Frame::default() })
}

/// \[m\] Returns the middle of everybody's feet in a frame; not numbers where people have no legs.
pub fn feet(bytes: &[u8]) -> Vec<Vec2> {
    numbers(bytes).as_chunks::<COLUMNS>().0.iter().map(|&[.., x, y, _]| vec2(x, y)).collect()
}

/// Reads doubles, little-endian.
pub fn numbers(bytes: &[u8]) -> Vec<f64> {
    bytes.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect()
}

/// Returns who overlaps now, by more than [`TOLERANCE`]: their places, whether walls are among them, and the deepest overlap
/// \[m\]. Of one agent only those that it overlaps.
pub fn overlapping(world: &World, of: Option<usize>) -> (BTreeSet<usize>, bool, f64) {
    let body = |disk| Some(world.scene().body_of(disk).index());
    let (mut found, mut wall, mut deepest) = (BTreeSet::new(), false, 0.0_f64);
    for contact in world.contacts().contacts.iter().filter(|contact| contact.depth > TOLERANCE) {
        let bodies = match contact.pair {
            Pair::Disks { first, second } => [body(first), body(second)],
            Pair::Face { disk, .. } => [body(disk), None],
        };
        if of.is_none() || bodies.contains(&of) {
            found.extend(bodies.into_iter().flatten().filter(|body| Some(*body) != of));
            wall |= bodies[1].is_none();
            deepest = deepest.max(contact.depth);
        }
    }
    (found, wall, deepest)
}

/// Whom an agent would overlap.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct Overlaps {
    agents: BTreeSet<usize>,
    wall: bool,
    depth: f64,
}

/// Returns whom an agent would overlap at another pose (x, y \[m\], angle \[rad\]).
///
/// # Errors
/// There is no such agent, or a number is not finite.
pub fn overlaps(trial: &Trial, agent: usize, [x, y, theta]: [f64; 3]) -> Result<Reply, Refused> {
    let mut trial = trial.clone();
    let here =
        trial.dynamics.get_mut(agent).filter(|_| [x, y, theta].iter().all(|number| number.is_finite()));
    let here = here.ok_or_else(|| Refused::from(format!("there is no agent {agent} there")))?;
    (here.position, here.theta) = (vec2(x, y), theta);
    // Springs that the Trial remembers are of other places.
    trial.interactions = Interactions::default();
    let world = Setup::of(&trial).world()?;
    let (agents, wall, depth) = overlapping(&world, Some(agent));
    Reply::of(Overlaps { agents, wall, depth })
}

/// People who cross a line.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct Flow {
    #[cfg_attr(feature = "typescript", ts(type = "[number, number, 1 | -1][]"))]
    crossings: Vec<(usize, usize, i8)>,
}

/// Returns who crosses a line \[m\] between successive frames: place of the later frame, agent, 1 from left to right of
/// the line, -1 from right to left.
///
/// # Errors
/// The bytes are no frames, or there are none.
pub fn flow(people: usize, links: &[Link], line: [[f64; 2]; 2], bytes: &[u8]) -> Result<Reply, Refused> {
    let size = 8 * COLUMNS * people;
    require(!bytes.is_empty() && bytes.len().is_multiple_of(size), || {
        format!("{} bytes are not frames of {people} people", bytes.len())
    })?;
    let [from, to] = line.map(Vec2::from);
    let line = CountingLine { from, to };
    let frames = bytes.chunks_exact(size).map(|bytes| frame(bytes, people)).collect::<Result<Vec<_>, _>>()?;
    let mut crossings = Vec::new();
    for (k, pair) in frames.windows(2).enumerate() {
        for (agent, (before, after)) in pair[0].agents.iter().zip(&pair[1].agents).enumerate() {
            let [before, after] = [before, after].map(|motion| motion.pose.position);
            let crossing =
                line.crossing(before, after).filter(|_| carried_from(links, before, after).is_none());
            if let Some(crossing) = crossing {
                crossings.push((k + 1, agent, if crossing.way == Way::Right { 1 } else { -1 }));
            }
        }
    }
    Reply::of(Flow { crossings })
}
