//! Doors and exits: which are open, by their times and by who operates them.

use super::Decision;
use super::quantities::DecisionQuantity;
use crate::plan::Plan;
use crate::target::{Destination, Ways};
use lemons_core::trial::{OpeningTimes, Wall};
use serde::{Deserialize, Serialize};
use std::sync::{Arc, LazyLock};

static NEVER: LazyLock<OpeningTimes> = LazyLock::new(OpeningTimes::never);

/// Doors and exits that are shut from outside, whatever their times are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Shut {
    /// As it is said now, and as it was at the last step.
    now: Operated,
    before: Operated,
    /// Whether an exit was shut in a step: from then on, people choose among exits.
    exits: bool,
}

/// Whether each is shut.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Operated {
    doors: Vec<bool>,
    /// Of all targets; goals never are.
    targets: Vec<bool>,
}

impl Operated {
    fn fits(&self, plan: &Plan) -> bool {
        let goals = self.targets.iter().zip(&plan.targets).any(|(shut, target)| *shut && target.stay);
        self.doors.len() == plan.doors.len() && self.targets.len() == plan.targets.len() && !goals
    }
}

impl Shut {
    pub fn none(plan: &Plan) -> Shut {
        let none =
            Operated { doors: vec![false; plan.doors.len()], targets: vec![false; plan.targets.len()] };
        Shut { now: none.clone(), before: none, exits: false }
    }

    /// Whether a saved state can be of this plan.
    pub fn fits(&self, plan: &Plan) -> bool {
        self.now.fits(plan) && self.before.fits(plan)
    }

    /// Whether people choose among exits because one is shut, or was.
    fn makes_choose(&self) -> bool {
        self.exits || self.now.targets.contains(&true)
    }
}

impl Decision {
    /// Whether a door or an exit may be open now: an element of `DoorOpen` or `ExitOpen`; `None` if there is none.
    pub(super) fn may_open(&self, quantity: DecisionQuantity, element: usize) -> Option<bool> {
        let shut = match quantity {
            DecisionQuantity::DoorOpen => self.shut.now.doors.get(element)?,
            DecisionQuantity::ExitOpen => &self.shut.now.targets[self.exits().nth(element)?],
            _ => return None,
        };
        Some(!shut)
    }

    /// Shuts a door or an exit, or lets it be open at its times. Returns whether there is one.
    pub(super) fn operate(&mut self, quantity: DecisionQuantity, element: usize, open: bool) -> bool {
        let Some(before) = self.may_open(quantity, element) else { return false };
        if before == open {
            return true;
        }
        let chose = self.shut.makes_choose();
        let exit = self.exits().nth(element).filter(|_| quantity == DecisionQuantity::ExitOpen);
        match exit {
            None => self.shut.now.doors[element] = !open,
            Some(k) => self.shut.now.targets[k] = !open,
        }
        if self.shut.makes_choose() != chose {
            // To each exit there is a way of its own now.
            self.ways = None;
        }
        self.forget();
        true
    }

    /// Takes what was operated before a step as known. Returns whether anything was.
    pub(super) fn notice(&mut self) -> bool {
        let Shut { now, before, exits } = &mut self.shut;
        if now == before {
            return false;
        }
        for (k, shut) in now.targets.iter().enumerate() {
            // Who left before it was shut does not count.
            if *shut != before.targets[k] {
                self.passed[k] = 0;
            }
            *exits |= shut;
        }
        before.clone_from(now);
        true
    }

    /// Goes to what was saved.
    pub(super) fn restore_shut(&mut self, saved: &Shut) {
        if self.shut.makes_choose() != saved.makes_choose() {
            self.ways = None;
        }
        self.shut.clone_from(saved);
    }

    /// Returns the ways of the plan, if they are not those of people who choose because an exit is shut.
    pub(super) fn ways_of_plan(&self) -> Option<Option<Arc<Ways>>> {
        self.ways.clone().filter(|_| !self.shut.makes_choose())
    }

    /// Whether somebody chooses an exit by more than where it is.
    pub(super) fn chooses(&self) -> bool {
        let chooses = |destination| destination == Destination::NearestExit;
        self.plan.chooses()
            || self.shut.makes_choose() && self.plan.agents.iter().any(|agent| chooses(agent.destination))
    }

    /// Whether those who choose do so before the first step.
    pub(super) fn chooses_at_once(&self) -> bool {
        self.plan.chooses_at_once() || self.shut.makes_choose()
    }

    /// Whether people can leave by an exit now.
    pub(super) fn is_open(&self, k: usize) -> bool {
        !self.shut.now.targets[k] && self.plan.targets[k].is_open(self.time) && !self.is_full(k)
    }

    /// The doors that are closed at a time \[s\].
    pub(super) fn closed_doors(&self, time: f64) -> impl Iterator<Item = &Wall> {
        let doors = self.plan.doors.iter().zip(&self.shut.now.doors);
        doors.filter(move |(door, shut)| **shut || !door.is_open(time)).map(|(door, _)| door)
    }

    /// When a door is open, as people expect it now.
    pub(super) fn times_of_door(&self, k: usize) -> Option<&OpeningTimes> {
        if self.shut.now.doors[k] { Some(&NEVER) } else { self.plan.doors[k].open.as_ref() }
    }

    /// When an exit is open, as people expect it now; `None` for always.
    pub(super) fn times_of_exit(&self, k: usize) -> Option<&OpeningTimes> {
        if self.shut.now.targets[k] { Some(&NEVER) } else { self.plan.targets[k].open.as_ref() }
    }
}
