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
//! If the exit is closed at times, the queue gets shorter only while it is open, and who is there waits until it is
//! ([`passed`]). So it is at each door on the way that opens and closes, one after the other: who waits at one comes
//! later to the next. A person may prefer an exit: its time is multiplied by a factor.
//!
//! At first everybody has the nearest exit. Each reconsiders once a second, one after the other, and changes only if the
//! gain is clear.

use crate::stuck::share;
use lemons_core::trial::OpeningTimes;
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

/// Returns after how many seconds somebody is through an exit who is there after `arrival` \[s\], and before whom people
/// leave for `service` \[s\], if it is `open` then, or always, and it is `now` \[s\]. Infinite if it closes before, for
/// ever.
pub fn passed(open: Option<&OpeningTimes>, now: f64, arrival: f64, mut service: f64) -> f64 {
    let Some(open) = open else { return arrival.max(service) };
    for &[from, to] in open.pairs() {
        let (from, to) = ((from - now).max(0.0), to - now);
        let through = (from + service).max(arrival);
        if through < to {
            return through;
        }
        service = (service - (to - from).max(0.0)).max(0.0);
    }
    f64::INFINITY
}

/// An exit that somebody may choose.
#[derive(Debug, Clone, Copy)]
pub struct Offer<'a> {
    /// Index of the target.
    pub target: usize,
    /// \[m\] How far it is on foot.
    pub distance: f64,
    /// \[m\] Width of the way to it.
    pub width: f64,
    /// See [`crate::target::Target`].
    pub open: Option<&'a OpeningTimes>,
    /// Doors on the way, in its order: when each is open, and how far it is from there \[m\].
    pub doors: &'a [(&'a OpeningTimes, f64)],
    /// See [`crate::target::Target`].
    pub time_factor: f64,
}

impl Offer<'_> {
    /// \[s\] Returns after how long somebody is through it, by the doors on the way in their order, who walks at a `speed`
    /// \[m/s\], and before whom people leave for `service` \[s\], if it is `now` \[s\]. Infinite if a door or the exit
    /// closes before, for ever.
    pub fn time(&self, speed: f64, now: f64, service: f64) -> f64 {
        let on_foot = |way: f64| if way > 0.0 { way / speed } else { 0.0 };
        let (mut at, mut left) = (0.0, self.distance);
        for &(open, far) in self.doors {
            at = passed(Some(open), now, at + on_foot(left - far), service);
            left = left.min(far);
        }
        passed(self.open, now, at + on_foot(left), service)
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

    /// Returns the target to which somebody changes, if it is clearly the quickest of these. `own` is the present one,
    /// `speed` \[m/s\] the desired speed, and it is `now` \[s\].
    pub fn change(&mut self, own: usize, speed: f64, now: f64, offers: &[Offer<'_>]) -> Option<usize> {
        let time = |offer: &Offer<'_>| {
            let service = self.ahead(offer.target, offer.distance) as f64 / (FLOW * offer.width);
            offer.time_factor * offer.time(speed, now, service)
        };
        let present = offers.iter().find(|offer| offer.target == own)?;
        let best = offers.iter().min_by(|a, b| time(a).total_cmp(&time(b)))?;
        let (before, after) = (time(present), time(best));
        // Without a speed no time is finite, and nobody changes.
        let gains = before - after >= LEAST_GAIN.max(LEAST_SHARE * before);
        if !gains {
            return None;
        }
        self.shift((own, present.distance), (best.target, best.distance));
        Some(best.target)
    }

    /// Moves somebody from one target to another: targets with the distances \[m\].
    pub fn shift(&mut self, from: (usize, f64), to: (usize, f64)) {
        let place = self.ahead(from.0, from.1);
        // Also of numbers that are none.
        if place < self.0[from.0].len() {
            self.0[from.0].remove(place);
        }
        let place = self.ahead(to.0, to.1);
        self.0[to.0].insert(place, to.1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(numbers: &[f64]) -> OpeningTimes {
        OpeningTimes::of_numbers(numbers).unwrap()
    }

    /// The outside: the rule by hand. 32 people are ahead at a door of 1 m: 20 s; it is 13.4 m to the other one: 10 s.
    #[test]
    fn who_gains_enough_changes_and_the_next_one_sees_it() {
        let offer = |target, distance, width| Offer {
            target,
            distance,
            width,
            open: None,
            doors: &[],
            time_factor: 1.0,
        };
        let ways = [offer(0, 5.0, 1.0), offer(1, 13.4, 2.0)];
        let change = |ahead: usize, there: usize| {
            let people = [(0, 1.0, ahead), (1, 2.0, there), (0, 5.0, 1)].into_iter();
            let each = people.flat_map(|(target, distance, count)| vec![(target, distance); count]);
            let mut queues = Queues::new(2, each);
            let changed = queues.change(0, 1.34, 0.0, &ways);
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
        assert_eq!(queues.change(0, 0.0, 0.0, &ways), None);
        assert_eq!(queues.change(0, 1.34, 0.0, &[offer(0, f64::INFINITY, 1.0), ways[1]]), Some(1));
    }

    /// The outside: sums by hand. It is 7 s; the exit is open from 10 s to 15 s and from 30 s to 40 s.
    #[test]
    fn a_queue_gets_shorter_while_the_exit_is_open() {
        let open = times(&[10.0, 15.0, 30.0, 40.0]);
        let open = Some(&open);
        let through = |arrival, service| passed(open, 7.0, arrival, service);
        // There before it opens; with a queue of 2 s; there later than the queue needs.
        assert_eq!([through(1.0, 0.0), through(1.0, 2.0), through(6.0, 2.0)], [3.0, 5.0, 6.0]);
        // Closed again at 8 s; of a queue of 7 s, 5 s are left over until 23 s; of 15 s nobody knows when.
        assert_eq!([through(9.0, 0.0), through(1.0, 7.0), through(1.0, 15.0)], [23.0, 25.0, f64::INFINITY]);
        assert_eq!([passed(open, 12.0, 1.0, 0.5), passed(open, 50.0, 0.0, 0.0)], [1.0, f64::INFINITY]);
        assert_eq!(passed(None, 3.0, 1.0, 2.0), 2.0);
    }

    /// The outside: by hand. 10 s on foot against an exit of 13.4 s that is preferred, and one that opens in 4 s.
    #[test]
    fn who_prefers_an_exit_or_waits_for_one_counts_it() {
        let own = Offer { target: 0, distance: 13.4, width: 1.0, open: None, doors: &[], time_factor: 1.0 };
        let change = |speed_of_other: f64, other: Offer<'_>| {
            let other = Offer { target: 1, distance: 1.34 * speed_of_other, ..other };
            Queues::new(2, [(0, 13.4)].into_iter()).change(0, 1.34, 6.0, &[own, other])
        };
        let preferred = Offer { time_factor: 0.5, ..own };
        assert_eq!(
            (change(13.0, own), change(13.0, preferred), change(17.0, preferred)),
            (None, Some(1), None)
        );
        let opens = |at: f64| change(1.0, Offer { open: Some(&times(&[at, 100.0])), ..own });
        assert_eq!((opens(12.0), opens(14.5), opens(5.0)), (Some(1), None, Some(1)));
        // A door 0.67 m before it, which shuts 1 s from now, or after 0.3 s; the exit lets out for longer.
        let shuts = |at: f64| {
            let (open, door) = (times(&[0.0, 60.0]), times(&[0.0, at]));
            change(1.0, Offer { open: Some(&open), doors: &[(&door, 0.67)], ..own })
        };
        assert_eq!((shuts(7.0), shuts(6.3)), (Some(1), None));
    }

    /// The outside: sums by hand. At 1 m/s it is 3 m to a door, 4 m more to the next one, and 2 m more to the exit.
    #[test]
    fn who_waits_at_a_door_comes_later_to_the_next() {
        let time = |first: [f64; 2], second: [f64; 2], exit: [f64; 2], service: f64| {
            let offer = Offer {
                target: 0,
                distance: 9.0,
                width: 1.0,
                open: Some(&times(&exit)),
                doors: &[(&times(&first), 6.0), (&times(&second), 2.0)],
                time_factor: 1.0,
            };
            offer.time(1.0, 10.0, service)
        };
        let always = [0.0, 100.0];
        assert_eq!(time(always, always, always, 0.0), 9.0);
        // The first opens at 40 s, so that the second is reached 34 s from now.
        assert_eq!(time([40.0, 70.0], always, always, 0.0), 36.0);
        assert_eq!(time([40.0, 70.0], [0.0, 43.9], always, 0.0), f64::INFINITY);
        assert_eq!(time([40.0, 70.0], [0.0, 44.1], [50.0, 60.0], 0.0), 40.0);
        assert_eq!(time([40.0, 70.0], always, [0.0, 45.9], 0.0), f64::INFINITY);
        // Behind a queue of 5 s before the first; nobody who stands gets anywhere.
        assert_eq!(time([40.0, 70.0], always, always, 5.0), 41.0);
        let own = Offer { target: 0, distance: 9.0, width: 1.0, open: None, doors: &[], time_factor: 1.0 };
        assert_eq!(
            (own.time(0.0, 0.0, 0.0), Offer { distance: 0.0, ..own }.time(0.0, 0.0, 0.0)),
            (f64::INFINITY, 0.0)
        );
    }
}
