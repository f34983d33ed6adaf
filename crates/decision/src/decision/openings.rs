//! Doors and exits: which are open, by their times and by who operates them.

use super::Decision;
use super::quantities::DecisionQuantity;
use crate::plan::Plan;
use crate::target::Destination;
use lemons_core::trial::{OpeningTimes, Wall};
use serde::{Deserialize, Serialize};
use std::sync::LazyLock;

static NEVER: LazyLock<OpeningTimes> = LazyLock::new(OpeningTimes::never);

/// Doors and exits that are shut from outside, whatever their times are.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Shut {
    doors: Vec<bool>,
    /// Of all targets; goals never are.
    targets: Vec<bool>,
    /// Whether somebody has shut or opened one since the last step.
    changed: bool,
    /// Whether an exit has ever been shut: from then on, people choose among exits.
    exits: bool,
}

impl Shut {
    pub fn none(plan: &Plan) -> Shut {
        let (doors, targets) = (vec![false; plan.doors.len()], vec![false; plan.targets.len()]);
        Shut { doors, targets, changed: false, exits: false }
    }

    /// Whether a saved state can be of this plan.
    pub fn fits(&self, plan: &Plan) -> bool {
        let goals = self.targets.iter().zip(&plan.targets).any(|(shut, target)| *shut && target.stay);
        self.doors.len() == plan.doors.len() && self.targets.len() == plan.targets.len() && !goals
    }
}

impl Decision {
    /// Whether a door or an exit may be open now: an element of `DoorOpen` or `ExitOpen`; `None` if there is none.
    pub(super) fn may_open(&self, quantity: DecisionQuantity, element: usize) -> Option<bool> {
        let shut = match quantity {
            DecisionQuantity::DoorOpen => self.shut.doors.get(element)?,
            DecisionQuantity::ExitOpen => &self.shut.targets[self.exits().nth(element)?],
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
        self.shut.changed = true;
        let exit = self.exits().nth(element).filter(|_| quantity == DecisionQuantity::ExitOpen);
        match exit {
            None => self.shut.doors[element] = !open,
            Some(k) => {
                self.shut.targets[k] = !open;
                // Who left before it was shut does not count.
                self.passed[k] = 0;
                if !self.shut.exits {
                    // To each exit there is a way of its own now.
                    (self.shut.exits, self.ways) = (true, None);
                }
            }
        }
        self.wanted = None;
        self.forget();
        true
    }

    /// Takes what was operated before a step as known. Returns whether anything was.
    pub(super) fn notice(&mut self) -> bool {
        std::mem::take(&mut self.shut.changed)
    }

    /// Goes to what was saved.
    pub(super) fn restore_shut(&mut self, saved: &Shut) {
        if self.shut.exits != saved.exits {
            self.ways = None;
        }
        self.shut.clone_from(saved);
    }

    /// Whether somebody chooses an exit by more than where it is.
    pub(super) fn chooses(&self) -> bool {
        let chooses = |destination| destination == Destination::NearestExit;
        self.plan.chooses()
            || self.shut.exits && self.plan.agents.iter().any(|agent| chooses(agent.destination))
    }

    /// Whether those who choose do so before the first step.
    pub(super) fn chooses_at_once(&self) -> bool {
        self.plan.chooses_at_once() || self.shut.exits
    }

    /// Whether people can leave by an exit now.
    pub(super) fn is_open(&self, k: usize) -> bool {
        !self.shut.targets[k] && self.plan.targets[k].is_open(self.time) && !self.is_full(k)
    }

    /// The doors that are closed at a time \[s\].
    pub(super) fn closed_doors(&self, time: f64) -> impl Iterator<Item = &Wall> {
        let doors = self.plan.doors.iter().zip(&self.shut.doors);
        doors.filter(move |(door, shut)| **shut || !door.is_open(time)).map(|(door, _)| door)
    }

    /// When a door is open, as people expect it now.
    pub(super) fn times_of_door(&self, k: usize) -> Option<&OpeningTimes> {
        if self.shut.doors[k] { Some(&NEVER) } else { self.plan.doors[k].open.as_ref() }
    }

    /// When an exit is open, as people expect it now; `None` for always.
    pub(super) fn times_of_exit(&self, k: usize) -> Option<&OpeningTimes> {
        if self.shut.targets[k] { Some(&NEVER) } else { self.plan.targets[k].open.as_ref() }
    }
}
