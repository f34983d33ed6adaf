//! Where people want to go now, and how fast.

use super::Decision;
use crate::door;
use crate::rule::FASTEST;
use crate::target::{Arrival, Destination, Ways, nearest_exit};
use lemons_core::plane::{InPlane, Vec2, rotation, segments_cross, vec2};
use lemons_fmi::Answer;

/// Aim of somebody now. See [`Decision::arrival`], [`Decision::goes`] and [`Decision::to_go`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Aim {
    pub(super) arrival: Option<Arrival>,
    pub(super) goes: Option<(Vec2, f64)>,
    pub(super) to_go: f64,
    /// Whether the way leads to a closed door.
    pub(super) to_door: bool,
}

/// \[m\] A door that is no further than this behind where somebody wants to be is on the way there.
const AT_DOOR: f64 = 0.1;

impl Decision {
    /// Returns who wants to get on now: who has started, does not wait at a way-point or for an exit that is closed, is not
    /// on the way to a closed door, and has not arrived.
    ///
    /// # Errors
    /// Those of [`Decision::acts`].
    pub fn going(&mut self) -> Answer<Vec<bool>> {
        self.find_ways()?;
        self.find_aims();
        let aims = self.aims.as_deref().unwrap_or_default();
        let going = |i: usize| {
            let agent = &self.agents[i];
            let walks = self.has_started(i) && !agent.waits() && self.speed(i) > 0.0;
            let there = agent.next() == agent.walker.waypoints.len();
            let open = match self.destination(i) {
                Destination::None => false,
                Destination::Target(k) => self.is_open(k),
                Destination::NearestExit => true,
            };
            walks && (!there || open) && aims[i].arrival.is_none() && !aims[i].to_door
        };
        Ok((0..self.agents.len()).map(going).collect())
    }

    /// Computes the aims of all agents, unless that was done at these poses.
    pub(super) fn find_aims(&mut self) {
        if self.aims.is_none() {
            let mut aims: Vec<Aim> = (0..self.agents.len()).map(|i| self.find_aim(i)).collect();
            self.let_out(&mut aims);
            self.keep_together(&mut aims);
            self.aims = Some(aims);
        }
    }

    /// Returns the ways that were found.
    pub(super) fn ways(&self) -> Option<&Ways> {
        self.ways.as_ref()?.as_deref()
    }

    /// Returns what an agent does at its exit or goal, if it has arrived there at the present pose.
    pub(super) fn arrival(&self, i: usize) -> Option<Arrival> {
        if let Some(aims) = &self.aims {
            return aims[i].arrival;
        }
        if self.agents[i].left {
            return Some(Arrival::Leaves);
        }
        let stays = |k: usize| self.plan.targets[k].stay;
        self.reached(i).map(|k| if stays(k) { Arrival::Stays } else { Arrival::Leaves })
    }

    /// Returns at which exit or goal an agent has arrived that has not left.
    pub(super) fn reached(&self, i: usize) -> Option<usize> {
        let agent = &self.agents[i];
        let there = agent.came && agent.next() == agent.walker.waypoints.len();
        let open = |k: usize| self.is_open(k);
        self.ways().filter(|_| there)?.arrived(
            self.plan.agents[i].destination,
            agent.from(&self.plan.links),
            agent.at(),
            || self.plan.agents[i].radius(),
            open,
        )
    }

    /// Returns whether an agent is not there: it has not come yet, or has left.
    pub(super) fn is_away(&self, i: usize) -> bool {
        !self.agents[i].came || self.arrival(i) == Some(Arrival::Leaves)
    }

    /// \[m/s\] The desired speed of an agent, as it is influenced.
    pub(super) fn speed(&self, i: usize) -> f64 {
        let own = self.agents[i].walker.desired_speed;
        (own * self.influence.speed_factor).min(FASTEST.max(own))
    }

    /// Returns by which exit everybody wants to leave who is there, wants to walk, and has no way-point ahead: of who has
    /// chosen none, the [`nearest_exit`].
    ///
    /// # Errors
    /// Those of [`Decision::acts`].
    pub fn heads(&mut self) -> Answer<Vec<Option<usize>>> {
        self.find_ways()?;
        self.find_aims();
        let head = |i: usize| {
            let agent = &self.agents[i];
            let walks = self.has_started(i) && !self.is_away(i);
            let exit = match self.destination(i) {
                Destination::None => None,
                Destination::NearestExit => nearest_exit(&self.plan.targets, agent.at()),
                Destination::Target(k) => Some(k).filter(|k| !self.plan.targets[*k].stay),
            };
            exit.filter(|_| walks && agent.next() == agent.walker.waypoints.len())
        };
        Ok((0..self.agents.len()).map(head).collect())
    }

    /// Returns whether an agent walks by now; a group starts when the last one of it does. A rounding error is not a time.
    pub(super) fn has_started(&self, i: usize) -> bool {
        let starts = |i: usize| self.time >= self.agents[i].walker.start - 1e-9;
        self.agents[i].came
            && !self.influence.stop
            && self.group(i).map_or_else(|| starts(i), |group| group.iter().all(|&j| starts(j)))
    }

    /// Destination of an agent: the exit that it has chosen, if it chooses one.
    pub(super) fn destination(&self, i: usize) -> Destination {
        let planned = self.plan.agents[i].destination;
        let at_once = || {
            let chooses = planned == Destination::NearestExit && self.chooses_at_once();
            if chooses { self.nearest_exit(i, self.time) } else { None }
        };
        self.agents[i].choice.exit.or_else(at_once).map_or(planned, Destination::Target)
    }

    /// Where an agent wants to go from its present pose: a unit vector, and the speed \[m/s\].
    pub(super) fn goes(&self, i: usize) -> Option<(Vec2, f64)> {
        self.aims.as_ref().map_or_else(|| self.find_aim(i).goes, |aims| aims[i].goes)
    }

    /// Computes the aim of an agent at its present pose. On slopes and stairs the speed is another one.
    pub(super) fn find_aim(&self, i: usize) -> Aim {
        let mut aim = self.find_level_aim(i);
        if let (Some((way, speed)), Some(ground)) = (&mut aim.goes, self.plan.grounds.at(self.agents[i].at()))
        {
            *speed *= ground.speed_factor(*way);
        }
        aim
    }

    fn find_level_aim(&self, i: usize) -> Aim {
        let (agent, destination, arrival) = (&self.agents[i], self.destination(i), self.arrival(i));
        let nowhere = Aim { arrival, goes: None, to_go: 0.0, to_door: false };
        if !self.has_started(i) || agent.waits() {
            return Aim { to_go: self.to_go(i, destination), ..nowhere };
        }
        if let Some(waypoint) = agent.walker.waypoints.get(agent.next()) {
            let way = vec2(waypoint.x, waypoint.y) - agent.at();
            let share =
                way.unit(0.0).map(|direction| (direction, self.share_before_door(i, direction, way.norm())));
            let goes = share.map(|(way, share)| (way, share.unwrap_or(1.0) * self.speed(i)));
            let to_door = share.is_some_and(|(_, share)| share.is_some());
            return Aim { goes, to_go: self.to_go(i, destination), to_door, ..nowhere };
        }
        if destination == Destination::None || arrival == Some(Arrival::Leaves) {
            return nowhere;
        }
        let Some(ways) = self.ways() else { return nowhere };
        let closed = matches!(destination, Destination::Target(k) if !self.is_open(k));
        let (leg, turn) = (ways.leg(destination, agent.at(), closed), agent.choice.turn);
        // Without a change of the exit, not even rounding.
        let turned = |way: Vec2| if turn == 0.0 { way } else { rotation(turn) * way };
        let before_door = leg.direction.and_then(|way| self.share_before_door(i, way, leg.distance));
        let share = before_door.map_or(leg.share, |share| share.min(leg.share));
        let goes = leg.direction.map(|way| (turned(way), share * self.speed(i)));
        Aim { arrival, goes, to_go: leg.distance, to_door: before_door.is_some() }
    }

    /// The part of the desired speed with which somebody walks in a direction, a unit vector, to a place so far \[m\] away,
    /// if the nearest closed door on the way there is behind no other wall; `None` if there is no such door.
    fn share_before_door(&self, i: usize, way: Vec2, far: f64) -> Option<f64> {
        let (agent, disks) = (&self.agents[i], &self.plan.agents[i].disks);
        let at = agent.at();
        let ahead = self.closed_doors(self.time).map(|door| (door, door::distance(door, at, way)));
        let ahead = ahead.filter(|(_, distance)| *distance <= far + AT_DOOR);
        let (door, distance) = ahead.min_by(|(_, a), (_, b)| a.total_cmp(b))?;
        let before = at + way * distance;
        let hidden = self.faces.iter().any(|&[a, b]| segments_cross(at, before, a, b));
        (!hidden).then(|| door::share(door, agent.pose, disks))
    }

    /// \[m\] How far it is along the way-points and to an exit or a goal.
    pub(super) fn to_go(&self, i: usize, destination: Destination) -> f64 {
        let agent = &self.agents[i];
        let (mut at, mut sum) = (agent.at(), 0.0);
        for waypoint in &agent.walker.waypoints[agent.next()..] {
            let next = vec2(waypoint.x, waypoint.y);
            sum += (next - at).norm();
            at = next;
        }
        match destination {
            Destination::None => sum,
            _ => sum + self.ways().map_or(0.0, |ways| ways.distance(destination, at)),
        }
    }
}
