//! Which exit people take, and when they take another one.

use super::aims::Aim;
use super::{AgentState, Decision};
use crate::exit_choice::{ExitChoice, Offer, Queues};
use crate::target::Destination;
use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::OpeningTimes;

impl Decision {
    /// Chooses an exit for everybody whose turn it is, as it is after a step \[s\], if people choose by more than where exits
    /// are; for everybody if a door or an exit was operated.
    pub(super) fn choose_exits(&mut self, step: f64, operated: bool) {
        let Some(Some(ways)) = self.ways.clone().filter(|_| self.chooses()) else { return };
        let (now, by_time) = (self.time + step, self.plan.exit_choice == ExitChoice::Time);
        // By distance, once a second and when something opens or closes; a group with its first member.
        let anew = operated || self.plan.opens_or_closes(self.time, now);
        let open = self.exits().any(|k| !self.is_full(k));
        let due = |agent: &mut AgentState| !by_time && (agent.choice.is_due(step) || anew);
        let due: Vec<bool> = self.agents.iter_mut().map(due).collect();
        let here = |i: &usize| !self.agents[*i].left && self.has_started(*i);
        let here: Vec<usize> = (0..self.agents.len()).filter(here).collect();
        for &i in &here {
            let own = self.agents[i].choice.exit;
            let full = open && own.is_some_and(|own| self.is_full(own));
            let chooses = own.is_none() || full || due[self.leader(i)];
            if self.plan.agents[i].destination == Destination::NearestExit && chooses {
                let nearest = self.nearest_exit(i, now);
                match (own, nearest) {
                    (Some(_), Some(exit)) => self.change_exit(i, exit),
                    _ => self.agents[i].choice.exit = nearest,
                }
            }
        }
        if !by_time {
            return;
        }
        let heads = |i: &usize| match self.destination(*i) {
            Destination::Target(k) => Some((k, self.to_go(*i, Destination::Target(k)))),
            _ => None,
        };
        let mut queues = Queues::new(self.plan.targets.len(), here.iter().filter_map(heads));
        let from = |i: &usize| self.agents[*i].choice.exit.map(|_| self.starts_from(*i));
        let from: Vec<Vec2> = here.iter().filter_map(from).collect();
        let widths: Vec<(usize, f64)> = self
            .exits()
            .filter(|k| !self.is_full(*k))
            .map(|k| (k, ways.width(k, from.iter().copied())))
            .collect();
        for i in here {
            let Some(own) = self.agents[i].choice.exit.filter(|_| self.leader(i) == i) else { continue };
            if !self.agents[i].choice.is_due(step) {
                continue;
            }
            let doors: Vec<Vec<_>> =
                widths.iter().map(|(target, _)| self.doors_on_the_way(i, *target)).collect();
            let offers = widths.iter().zip(&doors).map(|(&(target, width), doors)| {
                let distance = self.to_go(i, Destination::Target(target));
                let time_factor = self.plan.targets[target].time_factor;
                Offer { target, distance, width, open: self.times_of_exit(target), doors, time_factor }
            });
            let all: Vec<Offer<'_>> = offers.collect();
            let Some(exit) = queues.change(own, self.speed(i), now, &all) else {
                continue;
            };
            self.change_exit(i, exit);
            let others = self.group(i).into_iter().flatten().copied();
            for j in others.filter(|&j| j != i && !self.agents[j].left).collect::<Vec<_>>() {
                let Some(own) = self.agents[j].choice.exit.filter(|own| *own != exit) else { continue };
                let [before, after] = [own, exit].map(|k| (k, self.to_go(j, Destination::Target(k))));
                queues.shift(before, after);
                self.change_exit(j, exit);
            }
        }
    }

    /// Changes the exit of an agent. The direction of walking follows from the one before.
    pub(super) fn change_exit(&mut self, i: usize, exit: usize) {
        if self.agents[i].choice.exit == Some(exit) {
            return;
        }
        let before = self.goes(i);
        let choice = &mut self.agents[i].choice;
        (choice.exit, choice.turn) = (Some(exit), 0.0);
        if let (Some((before, _)), Some((after, _))) = (before, self.goes(i)) {
            self.agents[i].choice.turn = libm::atan2(after.perp(&before), after.dot(&before));
        }
    }

    /// Returns whether as many have left by an exit as may.
    pub(super) fn is_full(&self, k: usize) -> bool {
        self.plan.targets[k].most.is_some_and(|most| self.passed[k] >= most as usize)
    }

    /// Of those who reach an exit in the same step, only as many leave as may: the first ones in their order. The others wait.
    pub(super) fn let_out(&self, aims: &mut [Aim]) {
        if !self.plan.counts() {
            return;
        }
        let mut passed = self.passed.clone();
        for (i, aim) in aims.iter_mut().enumerate().filter(|(i, _)| !self.agents[*i].left) {
            let Some(k) = self.reached(i).filter(|k| !self.plan.targets[*k].stay) else { continue };
            passed[k] += 1;
            if self.plan.targets[k].most.is_some_and(|most| passed[k] > most as usize) {
                *aim = Aim { arrival: None, goes: None, ..*aim };
            }
        }
    }

    /// Returns the places of the exits among the targets of the plan.
    pub fn exits(&self) -> impl Iterator<Item = usize> {
        (0..self.plan.targets.len()).filter(|k| !self.plan.targets[*k].stay)
    }

    /// Returns the doors on the way of an agent to an exit: when each is open, and how far it is from there \[m\].
    fn doors_on_the_way(&self, i: usize, exit: usize) -> Vec<(&OpeningTimes, f64)> {
        let doors = self.ways().into_iter().flat_map(|ways| ways.doors_to(exit, self.starts_from(i)));
        doors.filter_map(|(k, far)| Some((self.times_of_door(k)?, far))).collect()
    }

    /// Returns the exit through which an agent is first without queues, at a time \[s\]: the nearest one on foot, if no door
    /// makes people wait. That an exit will open is known, but not that it will close. If no exit can be reached in time, it
    /// is the nearest of all. A group has that of its first member.
    pub(super) fn nearest_exit(&self, i: usize, time: f64) -> Option<usize> {
        let i = self.leader(i);
        let by_each = self.exits().map(|target| {
            let distance = self.to_go(i, Destination::Target(target));
            let doors = self.doors_on_the_way(i, target);
            let open = self.times_of_exit(target).filter(|open| !open.is_open(time));
            let offer =
                Offer { target, distance, width: f64::INFINITY, open, doors: &doors, time_factor: 1.0 };
            let first = offer.time(self.speed(i), time, 0.0);
            (target, if self.is_full(target) { f64::INFINITY } else { first }, distance)
        });
        let first = by_each.min_by(|a, b| a.1.total_cmp(&b.1).then(a.2.total_cmp(&b.2)));
        first.map(|(target, ..)| target)
    }

    /// \[m\] Where the way of an agent to an exit begins: at its last way-point, if there is one ahead.
    fn starts_from(&self, i: usize) -> Vec2 {
        let agent = &self.agents[i];
        let last = agent.walker.waypoints[agent.next()..].last();
        last.map_or(agent.at(), |waypoint| vec2(waypoint.x, waypoint.y))
    }
}
