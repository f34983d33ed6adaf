//! Who comes later, and when there is room.

use super::Decision;
use crate::plan::Plan;
use crate::source::{ASKED, SPARE_SPEED, placed, reach};
use lemons_core::plane::{self, Vec2};
use lemons_fmi::Answer;

impl Decision {
    /// Lets those in who are due after a step \[s\] and find room, source after source. Of a source, those who have not come are
    /// asked in their order. Returns whether somebody comes.
    pub(super) fn let_in(&mut self, step: f64) -> bool {
        let wanted = self.influence.arrivals.zip(self.plan.arrivals());
        let factor = wanted.map_or(1.0, |(wanted, planned)| wanted / planned);
        for (source, ahead) in self.plan.sources.iter().zip(&mut self.ahead) {
            *ahead = source.ahead(*ahead, factor, self.time, step);
        }
        let mut new = Vec::new();
        for (source, ahead) in self.plan.sources.iter().zip(&self.ahead) {
            let came = source.people.iter().filter(|(i, _)| self.agents[*i].came).count();
            let mut due = source.due(self.time + step + ahead).saturating_sub(came);
            let wait = source.people.iter().filter(|(i, _)| !self.agents[*i].came).take(ASKED);
            for &(i, velocity) in wait {
                if due > 0 && self.has_room(i, &new, step) {
                    new.push((i, velocity));
                    due -= 1;
                }
            }
        }
        for &(i, velocity) in &new {
            (self.agents[i].came, self.agents[i].velocity) = (true, velocity);
        }
        !new.is_empty()
    }

    /// Returns whether somebody touches no wall at its place, and nobody for one more step \[s\], in which all move on; others
    /// come, too.
    fn has_room(&self, i: usize, new: &[(usize, Vec2)], step: f64) -> bool {
        let body = |i: usize| (&self.plan.agents[i].disks[..], self.agents[i].pose);
        let there = (0..self.agents.len()).filter(|j| self.agents[*j].came && !self.agents[*j].left);
        let others = there.chain(new.iter().map(|(j, _)| *j)).map(|j| {
            let ((disks, pose), spare) = (body(j), (self.agents[j].velocity.norm() + SPARE_SPEED) * step);
            let kept = placed(disks, pose).map(move |(at, radius)| (at, radius + spare));
            (pose.position, reach(disks) + spare, kept)
        });
        let closed = self.closed_doors(self.time + step);
        let walls = self.faces.iter().copied().chain(closed.flat_map(|door| door.sides()));
        let (disks, pose) = body(i);
        plane::has_room(pose.position, &placed(disks, pose).collect::<Vec<_>>(), walls, others)
    }

    /// Returns with which velocity \[m/s\] and orientation \[rad\] everybody of a plan would walk alone at its place at 0 s;
    /// `None` of who would stand.
    ///
    /// # Errors
    /// No ways to exits and goals can be found.
    pub fn velocities(plan: Plan) -> Answer<Vec<Option<(Vec2, f64)>>> {
        let mut decision = Decision::new(plan);
        for agent in &mut decision.agents {
            (agent.came, agent.walker.start) = (true, 0.0);
        }
        decision.find_ways()?;
        let motion = |(way, speed): (Vec2, f64)| (way * speed, libm::atan2(way.y, way.x));
        let goes = |i: usize| decision.find_aim(i).goes.map(motion);
        Ok((0..decision.agents.len()).map(goes).collect())
    }
}
