//! Findings at the end of a run.

use lemons_core::message::{Message, message};
use lemons_core::plane::Vec2;
use lemons_core::rule::sentences::*;
use lemons_core::trial::{Problem, Rule};
use lemons_decision::Plan;
use lemons_decision::source::Source;
use lemons_decision::target::nearest_exit;
use lemons_results::Frame;
use lemons_results::columns::Effect;
use std::path::Path;

/// Part of the desired speed: who is slower and touched gets no further.
const STUCK: f64 = 0.1;
/// Ratio and difference \[s\] of the times of the last departures by two exits: from these on, they are uneven.
const UNEVEN: (f64, f64) = (1.5, 10.0);

/// \[s\] Who comes later than this after being due has found no room.
const LATE: f64 = 1.0;

/// End of a run: it sees the frames of all communication points.
#[derive(Debug, Default)]
pub struct RunEnd {
    /// The last frame.
    pub last: Frame,
    /// \[s\] and \[m\] When and where people have left since the first frame.
    pub departures: Vec<(f64, Vec2)>,
    /// \[s\] When people have come since then, and their places in the crowd.
    pub arrivals: Vec<(f64, usize)>,
}

impl RunEnd {
    /// Sees the next frame.
    pub fn see(&mut self, frame: Frame) {
        let before = std::mem::replace(&mut self.last, frame);
        let now = &self.last;
        let gone = (0..before.agents.len()).filter(|k| before.is_there(*k) && !now.is_there(*k));
        let come = (0..before.agents.len()).filter(|k| !before.is_there(*k) && now.is_there(*k));
        self.arrivals.extend(come.map(|k| (before.time, k)));
        self.departures.extend(gone.map(|k| (now.time, now.agents[k].pose.position)));
    }

    /// Returns what is found of people who walk by a plan. `forces` \[N\] drive them at the end; `whole`: the first frame was
    /// that of the beginning.
    pub fn findings(&self, plan: &Plan, forces: Option<&[Vec2]>, whole: bool) -> Vec<Problem> {
        let stuck = forces.and_then(|forces| self.stuck(plan, forces)).map(|message| (Rule::Stuck, message));
        let uneven = self.uneven(plan).filter(|_| whole).map(|message| (Rule::Uneven, message));
        let waited = plan.sources.iter().filter(|_| whole).filter_map(|source| self.waited(source));
        let waited = waited.map(|message| (Rule::NoRoom, message));
        let all = stuck.into_iter().chain(uneven).chain(waited);
        all.map(|(rule, message)| Problem::by(rule, Path::new(""), message)).collect()
    }

    /// Finds that people of a source came late. Who is due comes within two steps.
    fn waited(&self, source: &Source) -> Option<Message> {
        let is_of_it = |k: &usize| source.people.iter().any(|(i, _)| i == k);
        let came = self.arrivals.iter().filter(|(_, k)| is_of_it(k)).map(|(time, _)| *time);
        let due = source.due(self.last.time - LATE);
        let waits = source.times[..due].iter().zip(came.chain(std::iter::repeat(self.last.time)));
        let waits = waits.map(|(due, came)| came - due).filter(|wait| *wait > LATE);
        let (count, longest) =
            waits.fold((0_usize, 0.0), |(count, most), wait| (count + 1, f64::max(most, wait)));
        let still = due.saturating_sub(self.arrivals.iter().filter(|(_, k)| is_of_it(k)).count());
        let still = (still > 0).then(|| message!(STILL_OUTSIDE, count = still));
        (count > 0).then(|| message!(WAITED, source = &source.name, count, longest, still))
    }

    /// Finds that the last person left by one exit much later than by another, or nobody by that.
    fn uneven(&self, plan: &Plan) -> Option<Message> {
        // Those that are closed at times are used unevenly.
        if plan.targets.iter().any(|exit| exit.open.is_some() || exit.most.is_some()) {
            return None;
        }
        // \[s\] With the names; 0 where nobody has left.
        let exits = plan.targets.iter().enumerate().filter(|(_, target)| !target.stay);
        let mut last: Vec<(usize, &str, f64)> = exits.map(|(k, exit)| (k, &exit.name[..], 0.0)).collect();
        for (time, at) in &self.departures {
            let exit = nearest_exit(&plan.targets, *at)?;
            let entry = last.iter_mut().find(|entry| entry.0 == exit)?;
            entry.2 = time.max(entry.2);
        }
        let order = |a: &&(usize, &str, f64), b: &&(usize, &str, f64)| a.2.total_cmp(&b.2);
        let (least, most) = (last.iter().min_by(order)?, last.iter().max_by(order)?);
        if most.2 <= UNEVEN.0 * least.2 || most.2 <= least.2 + UNEVEN.1 {
            return None;
        }
        let before = match least {
            (_, exit, 0.0) => message!(NOBODY_BY, exit),
            (_, exit, time) => message!(BY, exit, time),
        };
        Some(message!(USED_UNEVENLY, exit = most.1, time = most.2, before))
    }

    /// Finds that in the model `straight` more than half of the people who are there are pushed, want to walk and get no
    /// further.
    fn stuck(&self, plan: &Plan, forces: &[Vec2]) -> Option<Message> {
        // With legs, who is pushed and stands does not press on.
        if plan.walking_model.sees_others() || plan.balance.is_some() {
            return None;
        }
        let frame = &self.last;
        let people = plan.agents.iter().zip(forces).zip(&frame.agents).enumerate();
        let squeezes = people.filter_map(|(place, ((agent, force), motion))| {
            let squeeze = frame.effects.get(Effect::MeanNormalForce, place)?;
            let slow = motion.twist.velocity.norm() < STUCK * agent.walker.desired_speed;
            (slow && *force != Vec2::zeros() && squeeze > 0.0).then_some(squeeze)
        });
        let mut squeezes: Vec<f64> = squeezes.collect();
        squeezes.sort_by(f64::total_cmp);
        let (stuck, all) = (squeezes.len(), frame.present().count());
        (2 * stuck > all && stuck > 1)
            .then(|| message!(PRESS_ON, time = frame.time, stuck, all, squeeze = squeezes[stuck / 2]))
    }
}
