//! Who leans on those in front, and with which force.

use super::Decision;
use crate::balance::OwnMotion;
use crate::cells::Cells;
use crate::plan::Planned;
use crate::queue::{self, Lean, TOUCHING, feet_hold};
use crate::stuck::StuckAction;
use crate::walking_model::Walking;
use lemons_core::plane::Vec2;
use lemons_core::trial::Ground;

impl Decision {
    /// Returns how an agent leans on who is in front, if it does.
    pub(super) fn lean(&mut self, i: usize) -> Option<Lean> {
        self.find_leans();
        self.leans.as_ref()?[i]
    }

    /// Returns the motion of an agent as its legs feel it, with what it leans.
    pub(super) fn leaning(&self, i: usize) -> OwnMotion {
        let agent = &self.agents[i];
        let lean = self.leans.as_ref().and_then(|leans| leans[i]).unwrap_or_default();
        OwnMotion {
            lean: lean.direction * (lean.part * lean.force / agent.walker.mass),
            steps: !self.plan.grounds.at(agent.at()).is_some_and(Ground::is_stairs),
            ..agent.motion()
        }
    }

    /// Computes how people lean at the present poses, if anybody leans.
    pub(super) fn find_leans(&mut self) {
        let (Some((queue, pendulum)), None) = (self.plan.queue, &self.leans) else { return };
        self.find_aims();
        let people: Vec<Option<Walking<'_>>> = (0..self.agents.len()).map(|i| self.walking(i)).collect();
        let closed = self.closed_doors(self.time).flat_map(|door| door.sides());
        let faces: Vec<[Vec2; 2]> = self.faces.iter().copied().chain(closed).collect();
        // Bodies whose centres are further apart do not touch.
        let reach = 2.0 * self.plan.agents.iter().map(Planned::radius).fold(0.0, f64::max) + TOUCHING;
        let cells = Cells::new(&people, |walking| walking.at, &faces, (reach, reach), |i, _| i);
        let lean = |(i, walking): (usize, &Option<Walking<'_>>)| {
            let (walking, agent) = (walking.as_ref()?, &self.agents[i]);
            let direction = walking.direction?;
            // Who is there, or does not want to walk, does not lean; nor does who gives way.
            let wants = self.speed(i) > 0.0 && self.arrival(i).is_none();
            if !wants || agent.stuck.action(direction, walking.speed) != StuckAction::Walk {
                return None;
            }
            let cell = cells.cell(walking.at);
            let mut near = Vec::new();
            cells.block(cell, 1, |&k| near.extend(people[k].as_ref().filter(|_| k != i)));
            let part = queue::part(walking, near.into_iter(), cells.faces(cell));
            let most = feet_hold(&pendulum, agent.walker.mass, agent.walker.stature);
            (part > 0.0).then(|| Lean { direction, force: queue.force(&agent.queue).min(most), part })
        };
        self.leans = Some(people.iter().enumerate().map(lean).collect());
    }
}
