//! Choice of an exit by the expected time, for people who have none of their own.
//!
//! Somebody i expects to be through exit k after
//!
//! > T_ik = max(d_ik / v_i, N_ik / (J b_k))
//!
//! with the distance on foot d, the desired speed v, and the number N of people who head for k and are nearer to it than
//! i. They leave at the specific flow J through the width b of the exit ([`crate::target::Ways::width`]). Both run at the
//! same time: who arrives before the queue is gone waits for the rest of it. Quickest paths instead of shortest ones are
//! those of Kretz, J. Stat. Mech. (2009) P03012; that people see queues and change to a quicker way, of Kemloh Wagoum,
//! Seyfried, Holl, Adv. Complex Syst. 15 (2012) 1250029.
//!
//! At first everybody has the nearest exit. Each reconsiders once a second, one after the other, and changes only if the
//! gain is clear.

use crate::stuck::share;
use serde::{Deserialize, Serialize};

/// \[1/(m s)\] Specific flow J of a crowd through a door (Kretz et al. 2006, Seyfried et al. 2009: 1.6 to 1.9).
const FLOW: f64 = 1.6;
/// \[s\] Time between two decisions of a person.
const PERIOD: f64 = 1.0;
/// \[s\] Smallest gain for which somebody changes.
const LEAST_GAIN: f64 = 2.0;
/// Smallest part of the expected time that must be gained.
const LEAST_SHARE: f64 = 0.2;

/// Quantity by which people choose an exit who have none of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ExitChoice {
    /// Distance on foot.
    #[default]
    Distance,
    /// Expected time, with the queues.
    Time,
}

/// Choice of a person.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Choice {
    /// Index of the target; `None` before the first step.
    pub exit: Option<usize>,
    /// \[s\] Time until the person reconsiders.
    pub wait: f64,
    /// \[rad\] Angle from the way to the direction of walking: what is left of the direction before the last change.
    pub turn: f64,
}

impl Choice {
    /// Makes that of a person at the start. People reconsider at different times.
    pub fn new(seed: u64, person: u64) -> Choice {
        Choice { exit: None, wait: PERIOD * share(seed, person, u64::MAX - 2), turn: 0.0 }
    }

    /// Returns whether the person reconsiders at the end of a step \[s\].
    pub fn is_due(&mut self, step: f64) -> bool {
        self.wait -= step;
        let due = self.wait <= 0.0;
        if due {
            // Also if a step is longer than the period.
            self.wait = (self.wait + PERIOD).max(0.0);
        }
        due
    }
}

/// Distances \[m\] to each target of those who head for it, sorted.
#[derive(Debug, Clone)]
pub struct Queues(Vec<Vec<f64>>);

impl Queues {
    /// Makes them of targets and distances \[m\].
    pub fn new(targets: usize, people: impl Iterator<Item = (usize, f64)>) -> Queues {
        let mut queues = vec![Vec::new(); targets];
        people.for_each(|(target, distance)| queues[target].push(distance));
        queues.iter_mut().for_each(|queue| queue.sort_by(f64::total_cmp));
        Queues(queues)
    }

    fn ahead(&self, target: usize, distance: f64) -> usize {
        self.0[target].partition_point(|other| *other < distance)
    }

    /// Returns the target to which somebody changes, if it is clearly the quickest: of the targets with their distances
    /// \[m\] and widths \[m\]. `own` is the present one, `speed` \[m/s\] the desired speed.
    pub fn change(&mut self, own: usize, speed: f64, ways: &[(usize, f64, f64)]) -> Option<usize> {
        let time = |&(target, distance, width): &(usize, f64, f64)| {
            (distance / speed).max(self.ahead(target, distance) as f64 / (FLOW * width))
        };
        let present = ways.iter().find(|way| way.0 == own)?;
        let best = ways.iter().min_by(|a, b| time(a).total_cmp(&time(b)))?;
        let (before, after) = (time(present), time(best));
        // Without a speed no time is finite, and nobody changes.
        let gains = before - after >= LEAST_GAIN.max(LEAST_SHARE * before);
        if !gains {
            return None;
        }
        let place = self.ahead(own, present.1);
        // Also of numbers that are none.
        if place < self.0[own].len() {
            self.0[own].remove(place);
        }
        let place = self.ahead(best.0, best.1);
        self.0[best.0].insert(place, best.1);
        Some(best.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The outside: the rule by hand. 32 people are ahead at a door of 1 m: 20 s; it is 13.4 m to the other one: 10 s.
    #[test]
    fn who_gains_enough_changes_and_the_next_one_sees_it() {
        let ways = [(0, 5.0, 1.0), (1, 13.4, 2.0)];
        let change = |ahead: usize, there: usize| {
            let people = [(0, 1.0, ahead), (1, 2.0, there), (0, 5.0, 1)].into_iter();
            let each = people.flat_map(|(target, distance, count)| vec![(target, distance); count]);
            let mut queues = Queues::new(2, each);
            let changed = queues.change(0, 1.34, &ways);
            (changed, [queues.0[0].len(), queues.0[1].len()])
        };
        assert_eq!(change(32, 0), (Some(1), [32, 1]));
        // Less than a fifth of 12.5 s; less than 2 s of 3.7 s.
        assert_eq!(change(19, 0).0, None);
        assert_eq!(change(6, 0).0, None);
        // The queue at the other door: 16 s and 16.25 s.
        assert_eq!((change(32, 51).0, change(32, 52).0), (Some(1), None));
        // Nobody who stands, and everybody who has no way.
        let mut queues = Queues::new(2, [(0, 5.0), (0, f64::INFINITY)].into_iter());
        assert_eq!(queues.change(0, 0.0, &ways), None);
        assert_eq!(queues.change(0, 1.34, &[(0, f64::INFINITY, 1.0), ways[1]]), Some(1));
    }
}
