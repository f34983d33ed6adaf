//! A crowd that decides where it walks: poses are seen, drives follow.

use crate::balance::{Legs, OwnMotion};
use crate::exit_choice::Choice;
use crate::plan::Plan;
use crate::queue::{Lean, QueueState};
use crate::rule::{Propulsion, Walker};
use crate::stuck::{StuckAction, StuckState, normal, share};
use crate::target::{Arrival, Destination, Ways};
use crate::walking_model::{DesiredMotion, Walking};
use lemons_core::plane::{Motion, Pose, Vec2, vec2};
use lemons_core::trial::{Ground, Link, carried_from};
use lemons_fmi::{Answer, refuse};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::sync::Arc;

mod aims;
mod exits;
mod fmi;
mod groups;
mod lean;
mod legs;
mod openings;
pub mod quantities;
mod sources;

use aims::Aim;
pub use fmi::SavedDecision;
pub use legs::Stance;
use openings::Shut;
pub use quantities::DecisionQuantity;

/// \[s\] Relaxation time of the direction of walking, or only of the gaze.
const STEERING_TIME: f64 = 0.3;
/// \[rad\] A smaller angle is none.
const LEAST_TURN: f64 = 1e-3;
/// \[s\] Correlation time of the noise of speeds (Tordeux, Schadschneider, J. Phys. A 49 (2016) 185101: 1/(0.23 1/s)).
const NOISE_TIME: f64 = 4.3;
/// \[m/s\] Who never wants to be faster than this sways in proportion to the desired speed, and its noise is so, too.
const UNHURRIED: f64 = 0.5;
/// \[1/s\] Lowest frequency of swaying, and by how much it may be higher.
const SWAYING: [f64; 2] = [0.7, 0.4];

/// An agent during the simulation, and in a saved state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AgentState {
    pose: Pose,
    /// \[m/s\]
    velocity: Vec2,
    walker: Walker,
    /// Index of the next way-point. It is updated by steps: a way-point that was reached stays reached.
    next: usize,
    /// Whether it has come: it is of no source, or its source has let it in.
    came: bool,
    /// Whether the agent has left by an exit, at the last step or before.
    left: bool,
    /// \[s\] How long it has waited at the next way-point.
    waited: f64,
    /// \[m\] Where the agent was at the last step.
    last: Option<Vec2>,
    stuck: StuckState,
    /// \[rad\] Angle from the way to the direction of walking, or only of the gaze.
    steering: f64,
    /// \[m/s\] Noise of the speed, and how many numbers were drawn for it.
    noise: f64,
    draws: u64,
    /// \[rad\] Phase of swaying from one foot to the other.
    phase: f64,
    choice: Choice,
    legs: Legs,
    queue: QueueState,
}

impl AgentState {
    /// Index of the next way-point, seen from the present pose.
    fn next(&self) -> usize {
        self.walker.next(self.next, self.waited, self.pose)
    }

    /// Whether it stands at a way-point, to wait.
    fn waits(&self) -> bool {
        let next = self.next();
        self.walker.waits(next, if next == self.next { self.waited } else { 0.0 }, self.pose)
    }

    fn at(&self) -> Vec2 {
        self.pose.position
    }

    fn motion(&self) -> OwnMotion {
        let Walker { floor_damping: damping, stature, .. } = self.walker;
        let (at, velocity) = (self.at(), self.velocity);
        OwnMotion { at, velocity, damping, stature, lean: Vec2::zeros(), steps: true }
    }

    /// \[m\] Where the agent came from; who was carried over a link, from a place in front of its line.
    fn from(&self, links: &[Link]) -> Vec2 {
        let Some(last) = self.last else { return self.at() };
        carried_from(links, last, self.at()).unwrap_or(last)
    }

    /// Its legs; of who was carried over a link, those under the body.
    fn legs(&self, links: &[Link]) -> Legs {
        let carried = self.last.and_then(|last| carried_from(links, last, self.at()));
        carried.map_or(self.legs, |_| self.legs.under(&self.motion(), self.legs.stands))
    }
}

/// Returns whether a time is after one and not after another one \[s\]. A rounding error is not a step.
fn is_due(at: f64, before: f64, now: f64) -> bool {
    before < at - 1e-9 && at - 1e-9 <= now
}

/// Drive and state of an agent in a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Act {
    /// Its force and torque.
    pub drive: Propulsion,
    /// Whether it is there: it has come, and has not left by an exit.
    pub active: bool,
}

/// What somebody outside makes of everybody's wishes, from now on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Influence {
    /// Factor of desired speeds.
    pub speed_factor: f64,
    /// \[N\] With this force, who wants to get on pushes in addition, in the direction in which they want to walk.
    pub push: f64,
    /// Whether everybody wants to stand, as before the start.
    pub stop: bool,
    /// \[1/s\] How many people come by all sources that have a rate, each by its share; `None`: as planned.
    pub arrivals: Option<f64>,
}

impl Default for Influence {
    fn default() -> Influence {
        Influence { speed_factor: 1.0, push: 0.0, stop: false, arrivals: None }
    }
}

impl Influence {
    fn is_sound(&self) -> bool {
        let possible = |number: f64| number >= 0.0 && number.is_finite();
        possible(self.speed_factor) && possible(self.push) && self.arrivals.is_none_or(possible)
    }
}

/// A crowd that walks.
#[derive(Debug, Clone)]
pub struct Decision {
    plan: Plan,
    /// Fingerprint of the plan.
    fingerprint: u128,
    agents: Vec<AgentState>,
    /// \[s\] Time since the start.
    time: f64,
    influence: Influence,
    /// \[s\] By how much the clock of each source is ahead.
    ahead: Vec<f64>,
    /// Largest number of way-points of an agent, at least 1.
    most_waypoints: usize,
    /// Group of each agent, if it is in one.
    groups: Arc<Vec<Option<usize>>>,
    /// Of the walls.
    faces: Arc<Vec<[Vec2; 2]>>,
    /// Found when they are first needed; `None` inside if nobody needs any.
    ways: Option<Option<Arc<Ways>>>,
    /// Desired motions of all agents by the model at their present poses, if people see each other and nothing has changed.
    wanted: Option<Vec<DesiredMotion>>,
    /// Arrivals and directions of all agents at their present poses, if they were computed.
    aims: Option<Vec<Aim>>,
    /// How many have left by each target since it opened last.
    passed: Vec<usize>,
    shut: Shut,
    /// Legs of all agents at their present poses, if they were computed; `None` inside for who has left.
    legs: Option<Vec<Option<Legs>>>,
    /// How people lean on those in front at their present poses, if it was computed.
    leans: Option<Vec<Option<Lean>>>,
}

impl Decision {
    /// Makes the model at the start of a plan.
    pub fn new(plan: Plan) -> Decision {
        let agents = plan.agents.iter().enumerate().map(|(i, agent)| AgentState {
            pose: agent.pose,
            velocity: Vec2::zeros(),
            walker: agent.walker.clone(),
            next: 0,
            came: true,
            left: false,
            waited: 0.0,
            last: None,
            stuck: StuckState::default(),
            steering: 0.0,
            noise: 0.0,
            draws: 0,
            phase: TAU * share(plan.seed, i as u64, u64::MAX - 1),
            choice: Choice::new(plan.seed, i as u64),
            legs: Legs::default(),
            queue: QueueState::new(plan.seed, i as u64),
        });
        let fingerprint = plan.fingerprint;
        let most = plan.agents.iter().map(|agent| agent.walker.waypoints.len()).max();
        let most_waypoints = most.unwrap_or(0).max(1);
        let mut agents: Vec<AgentState> = agents.collect();
        let late = plan.sources.iter().flat_map(|source| &source.people);
        late.for_each(|(i, _)| agents[*i].came = false);
        let mut groups = vec![None; plan.agents.len()];
        for (group, members) in plan.groups.iter().enumerate() {
            members.iter().for_each(|&i| groups[i] = Some(group));
        }
        let faces =
            plan.walls.iter().flat_map(|wall| wall.windows(2).map(|ends| [ends[0], ends[1]])).collect();
        let faces = Arc::new(faces);
        let mut decision = Decision {
            agents,
            time: 0.0,
            passed: vec![0; plan.targets.len()],
            influence: Influence::default(),
            ahead: vec![0.0; plan.sources.len()],
            shut: Shut::none(&plan),
            plan,
            fingerprint,
            most_waypoints,
            groups: Arc::new(groups),
            faces,
            ways: None,
            wanted: None,
            aims: None,
            legs: None,
            leans: None,
        };
        // Who is due at the start comes then.
        decision.let_in(0.0);
        decision
    }

    /// Returns what its people do.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// Influences everybody from now on, and returns whether that is a change.
    pub fn influence(&mut self, by: Influence) -> bool {
        let changes = by != self.influence;
        if changes {
            self.influence = by;
            self.forget();
        }
        changes
    }

    /// Everybody is seen in these motions, in their order; without FMI. Who walks decides at [`Decision::acts`], and
    /// [`Decision::pass`] ends the step.
    pub fn see(&mut self, motions: impl Iterator<Item = Motion>) {
        for (agent, Motion { pose, twist }) in self.agents.iter_mut().zip(motions) {
            (agent.pose, agent.velocity) = (pose, twist.velocity);
        }
        self.forget();
    }

    /// Forgets what follows from poses and parameters.
    fn forget(&mut self) {
        (self.wanted, self.aims, self.legs, self.leans) = (None, None, None, None);
    }

    /// Returns what everybody does at the present poses.
    ///
    /// # Errors
    /// No ways to exits and goals can be found: the area is too large.
    pub fn acts(&mut self) -> Answer<Vec<Act>> {
        self.find_ways()?;
        self.find_aims();
        let mut acts = Vec::with_capacity(self.agents.len());
        for i in 0..self.agents.len() {
            acts.push(Act { drive: self.drive(i)?, active: !self.is_away(i) });
        }
        Ok(acts)
    }

    /// A step \[s\] passes. Way-points that were reached at its beginning stay reached, and who has left stays away.
    ///
    /// # Errors
    /// Those of [`Decision::acts`].
    pub fn pass(&mut self, step: f64) -> Answer<()> {
        self.find_ways()?;
        self.find_aims();
        let (seed, speed_noise) = (self.plan.seed, self.plan.walking_model.speed_noise());
        let (turned, kept) = (-libm::expm1(-step / STEERING_TIME), libm::exp(-step / NOISE_TIME));
        self.pass_legs(step);
        let (mut goes_on, mut gone) = (false, Vec::new());
        for i in 0..self.agents.len() {
            let arrival = self.arrival(i);
            let leaves = arrival == Some(Arrival::Leaves);
            if leaves && !self.agents[i].left {
                gone.extend(self.reached(i));
            }
            // Who is at a goal is not stuck there.
            let goes = self.goes(i).filter(|_| arrival.is_none());
            let sees = self.plan.walking_model.sees_others();
            let wanted = if sees { self.wanted(i) } else { DesiredMotion::default() };
            let queues = wanted.queues;
            let agent = &mut self.agents[i];
            let (next, way, at) = (agent.next(), agent.at() - agent.from(&self.plan.links), agent.at());
            // The paper's rule does not see it; and who queues is not stuck.
            if agent.next == agent.walker.waypoints.len() || sees {
                let moved = agent.last.is_some();
                agent.stuck.follow(step, way, goes.filter(|_| moved && !queues), seed, i as u64);
            }
            let turn = &mut agent.choice.turn;
            *turn = if turn.abs() > LEAST_TURN { *turn * (1.0 - turned) } else { 0.0 };
            agent.steering += (wanted.steering - agent.steering) * turned;
            let frequency = SWAYING[0] + SWAYING[1] * share(seed, i as u64, u64::MAX);
            // Also of the longest step there is.
            agent.phase = (agent.phase + (TAU * frequency * step).min(f64::MAX)) % TAU;
            if speed_noise > 0.0 {
                let drawn = normal(seed, i as u64, agent.draws);
                agent.noise = kept * agent.noise + speed_noise * (1.0 - kept * kept).sqrt() * drawn;
                agent.draws += 1;
            }
            if let Some((queue, _)) = &self.plan.queue {
                agent.queue.pass(queue, step, seed, i as u64);
            }
            let waits = agent.waits();
            let waited = if next == agent.next { agent.waited } else { 0.0 };
            (agent.next, agent.left, agent.last) = (next, leaves, agent.came.then_some(at));
            agent.waited = if waits { waited + step } else { waited };
            goes_on |= waits && !agent.waits();
        }
        (self.aims, self.leans) = (None, None);
        gone.into_iter().for_each(|by| self.passed[by] += 1);
        goes_on |= self.let_in(step);
        let operated = self.notice();
        self.choose_exits(step, operated);
        let before = self.time;
        self.time += step;
        self.motivate_since(before);
        for (passed, exit) in self.passed.iter_mut().zip(&self.plan.targets) {
            if exit.is_open(self.time) && !exit.is_open(before) {
                *passed = 0;
            }
        }
        goes_on |= self.plan.opens_or_closes(before, self.time);
        if goes_on || self.agents.iter().any(|agent| is_due(agent.walker.start, before, self.time)) {
            (self.wanted, self.aims) = (None, None);
        }
        Ok(())
    }

    /// Everybody's motivation changes as it is due after a time \[s\] and until now.
    fn motivate_since(&mut self, before: f64) {
        for motivation in self.plan.motivation.iter().filter(|of| is_due(of.time, before, self.time)) {
            self.agents.iter_mut().for_each(|agent| agent.walker.motivate(motivation));
        }
    }

    /// How many have arrived: at their last way-point, at a goal, or have left.
    ///
    /// # Errors
    /// Those of [`Decision::acts`].
    pub fn arrived(&mut self) -> Answer<usize> {
        self.find_ways()?;
        let arrived = |i: &usize| {
            self.agents[*i].came
                && match self.plan.agents[*i].destination {
                    Destination::None => self.agents[*i].next() == self.agents[*i].walker.waypoints.len(),
                    _ => self.arrival(*i).is_some(),
                }
        };
        Ok((0..self.agents.len()).filter(arrived).count())
    }

    /// The same at its start.
    fn anew(&self) -> Decision {
        Decision { ways: self.ways_of_plan(), ..Decision::new(self.plan.clone()) }
    }

    /// Finds the ways to exits and goals, unless that was done before.
    fn find_ways(&mut self) -> Answer<()> {
        if self.ways.is_none() {
            let found = self.plan.ways(self.chooses());
            let found = found.or_else(|error| refuse(format!("no ways to exits and goals: {error}")))?;
            self.ways = Some(found.map(Arc::new));
        }
        Ok(())
    }

    /// The drive of an agent at its present pose.
    fn drive(&mut self, i: usize) -> Answer<Propulsion> {
        let mut drive = self.drive_of_walking(i)?;
        let agent = &self.agents[i];
        agent.walker.limit(&mut drive, agent.velocity);
        let lean = self.lean(i);
        if let Some(lean) = lean {
            let agent = &self.agents[i];
            agent.walker.lean(&mut drive, agent.velocity, &lean);
        }
        let ahead = if self.influence.push > 0.0 { self.goes(i) } else { None };
        if let Some((way, _)) = ahead.filter(|(_, speed)| *speed > 0.0 && self.arrival(i).is_none()) {
            drive.force = (Vec2::from(drive.force) + way * self.influence.push).into();
        }
        let mut stands = false;
        if let Some(balance) = self.plan.balance {
            self.decide_legs(&balance);
            let legs = self.legs.as_ref().and_then(|legs| legs[i]).filter(|legs| legs.stands);
            // Whatever a model of walking wants of those who stand, only the ground acts on them.
            if let Some(legs) = legs {
                stands = true;
                let agent = &self.agents[i];
                drive.force = (balance.drive(&legs, &self.leaning(i)) * agent.walker.mass).into();
                drive.torque = if balance.lies(&legs) { 0.0 } else { drive.torque };
                if balance.lies(&legs) {
                    return Ok(drive);
                }
            }
        }
        if let Some(ground) = self.plan.grounds.at(self.agents[i].at()) {
            // Feet hold what pulls downhill. Who leans downhill, and does not stand on legs, lets go.
            let free = |lean: Lean| lean.part * lean.direction.dot(&ground.downhill()).max(0.0);
            let held = 1.0 - lean.filter(|_| !stands).map_or(0.0, free);
            let held = ground.pull() * (held * self.agents[i].walker.mass);
            drive.force = (Vec2::from(drive.force) - held).into();
        }
        Ok(drive)
    }

    fn drive_of_walking(&mut self, i: usize) -> Answer<Propulsion> {
        self.find_ways()?;
        let agent = &self.agents[i];
        // Towards way-points, the paper's rule as it is.
        let walks = self.has_started(i) && !agent.waits();
        let alone = !self.plan.walking_model.sees_others() && self.group(i).is_none();
        if walks && agent.next() < agent.walker.waypoints.len() && alone {
            let mut drive = agent.walker.drive(agent.next(), agent.pose);
            // In front of a closed door, and on slopes.
            let level = self.plan.doors.is_empty() && self.plan.grounds.is_empty();
            let level = level && self.influence.speed_factor == 1.0;
            if let (false, Some((_, speed))) = (level, self.goes(i)) {
                let whole = agent.walker.desired_speed;
                let share = if speed != whole { speed / whole } else { 1.0 };
                drive.force = drive.force.map(|force| share * force);
            }
            return Ok(drive);
        }
        if !self.plan.groups.is_empty() || self.plan.counts() {
            self.find_aims();
        }
        let DesiredMotion { velocity, force, facing, .. } = self.intent(i);
        let AgentState { walker, pose, .. } = &self.agents[i];
        Ok(walker.towards(*pose, velocity, force, facing))
    }

    /// An agent as others see it; `None` if it is away.
    fn walking(&self, i: usize) -> Option<Walking<'_>> {
        if self.is_away(i) {
            return None;
        }
        let agent = &self.agents[i];
        let (direction, speed) = self.goes(i).unzip();
        Some(Walking {
            at: agent.at(),
            velocity: agent.velocity,
            theta: agent.pose.orientation,
            disks: &self.plan.agents[i].disks,
            direction,
            speed: speed.unwrap_or(0.0),
            pace: (self.speed(i) / UNHURRIED).min(1.0),
            to_go: self.aims.as_ref().map_or_else(|| self.find_aim(i).to_go, |aims| aims[i].to_go),
            destination: match self.destination(i) {
                Destination::None => usize::MAX,
                Destination::NearestExit => usize::MAX - 1,
                Destination::Target(k) => k,
            },
            waypoint: agent.walker.waypoints.get(agent.next()).map(|next| vec2(next.x, next.y)),
            relaxation: if agent.walker.floor_damping > 0.0 { 1.0 / agent.walker.floor_damping } else { 0.0 },
            time_gap: agent.walker.time_gap,
            standstill_gap: agent.walker.standstill_gap,
            reaction_time: agent.walker.reaction_time,
            steering: agent.steering,
            noise: agent.noise,
            breadth: self.plan.agents[i].breadth(),
            depth: self.plan.agents[i].depth(),
            phase: agent.phase,
            stuck: agent.stuck.is_stuck(),
        })
    }

    /// Returns what an agent wants by a model in which people see each other.
    fn wanted(&mut self, i: usize) -> DesiredMotion {
        if let Some(wanted) = &self.wanted {
            return wanted[i];
        }
        self.find_aims();
        let people: Vec<Option<Walking<'_>>> = (0..self.agents.len()).map(|i| self.walking(i)).collect();
        let all = self.plan.walking_model.desired(&people, &self.faces);
        let own = all[i];
        self.wanted = Some(all);
        own
    }

    /// Returns what an agent wants by the model, or does because it is stuck.
    fn intent(&mut self, i: usize) -> DesiredMotion {
        let mut wanted = if self.plan.walking_model.sees_others() {
            self.wanted(i)
        } else {
            let walking = self.walking(i);
            walking
                .map(|walking| self.plan.walking_model.desired(&[Some(walking)], &[])[0])
                .unwrap_or_default()
        };
        let stuck = &self.agents[i].stuck;
        if let Some((direction, speed)) = self.goes(i) {
            // Feet need the steps ahead: on stairs nobody evades, sways or steps aside.
            let on_stairs = self.plan.grounds.at(self.agents[i].at()).is_some_and(Ground::is_stairs);
            let along = |vector: Vec2| direction * vector.dot(&direction).max(0.0);
            match stuck.action(direction, speed) {
                StuckAction::Walk | StuckAction::Step(_) if on_stairs => {
                    (wanted.velocity, wanted.force) = (along(wanted.velocity), along(wanted.force));
                }
                StuckAction::Walk => {}
                StuckAction::Step(velocity) => {
                    (wanted.velocity, wanted.speed, wanted.force) =
                        (velocity, velocity.norm(), Vec2::zeros());
                }
                StuckAction::Insist(speed) => {
                    (wanted.velocity, wanted.speed, wanted.force) = (direction * speed, speed, Vec2::zeros());
                    // Where shoulders are turned, they stay so.
                    if !self.plan.walking_model.turns_shoulders() {
                        wanted.facing = Some(direction);
                    }
                }
            }
        }
        wanted
    }
}

#[cfg(test)]
mod tests;
