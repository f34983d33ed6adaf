//! When a run is over in which people leave.

use crate::measure::ROUNDING;
use lemons_core::plane::{Vec2, vec2};

/// \[s\] Who has not left until then does not leave.
pub const LATEST: f64 = 3600.0;
/// \[s\] If nobody leaves in this time, and nobody gets further than [`REACH`], nobody leaves any more.
const STANDSTILL: f64 = 300.0;
/// \[m\] Who is stuck steps back and to the side, again and again.
const REACH: f64 = 5.0;
/// \[m\] Who gets no further than this from a place waits there.
pub const WAITING: f64 = 1.0;

/// \[m\] Place of who has not come yet. While somebody is there, no standstill ends a run.
pub const OUTSIDE: Vec2 = vec2(f64::INFINITY, f64::INFINITY);

/// Why such a run is over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// All have left who were to leave.
    Left,
    /// Nobody leaves, or gets any further.
    Standstill,
}

/// How long somebody waited.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wait {
    /// Place among the people.
    pub agent: usize,
    /// \[s\] When it began.
    pub from: f64,
    /// \[s\] How long the person did not get further than [`WAITING`].
    pub time: f64,
}

/// A run that ends when people have left. It is given all communication points in the order of time.
#[derive(Debug, Clone)]
pub struct Leaving {
    /// Of each person, whether they are to leave.
    who: Vec<bool>,
    /// Number of those who are.
    leave: usize,
    left: usize,
    /// \[s\] Since then nobody has got further than [`REACH`] from these places \[m\]; `None` of those who have left.
    since: f64,
    places: Vec<Option<Vec2>>,
    over: Option<Over>,
    /// Whether a standstill ends it.
    ends_still: bool,
    /// Where \[m\] and since when \[s\] each person waits.
    waits: Vec<(Vec2, f64)>,
    longest: Option<Wait>,
}

impl Leaving {
    /// Begins; the run is over when all have left who are to leave.
    pub fn of(who: Vec<bool>) -> Leaving {
        Leaving {
            leave: who.iter().filter(|leaves| **leaves).count(),
            who,
            left: 0,
            since: f64::NEG_INFINITY,
            places: Vec::new(),
            over: None,
            ends_still: true,
            waits: Vec::new(),
            longest: None,
        }
    }

    /// Returns the same, over only when all have left.
    pub fn without_standstill(self) -> Leaving {
        Leaving { ends_still: false, ..self }
    }

    /// Sees at a time \[s\] where everybody is \[m\], or [`OUTSIDE`]; `None` of those who have left.
    pub fn see(&mut self, time: f64, places: &[Option<Vec2>]) -> Option<Over> {
        self.left = places.iter().filter(|place| place.is_none()).count();
        let stays = |(agent, (was, is)): (usize, (&Option<Vec2>, &Option<Vec2>))| match (was, is) {
            // Who is outside comes, if it is one of those who leave.
            (Some(was), Some(is)) if *is == OUTSIDE => *was == OUTSIDE && !self.leaves(agent),
            (Some(was), Some(is)) => (*is - *was).norm() <= REACH,
            (was, is) => was.is_none() && is.is_none(),
        };
        if self.places.len() != places.len() || !self.places.iter().zip(places).enumerate().all(stays) {
            (self.since, self.places) = (time, places.to_vec());
        }
        self.waits.resize(places.len(), (vec2(f64::INFINITY, 0.0), time));
        let inside = |at: &Vec2| *at != OUTSIDE;
        let there = places.iter().enumerate().filter_map(|(agent, at)| Some((agent, at.filter(inside)?)));
        for (agent, at) in there {
            let (place, from) = &mut self.waits[agent];
            if (at - *place).norm() > WAITING {
                (*place, *from) = (at, time);
            }
            let wait = Wait { agent, from: *from, time: time - *from };
            if self.longest.is_none_or(|longest| wait.time > longest.time) && self.leaves(agent) {
                self.longest = Some(wait);
            }
        }
        self.over = if self.left >= self.leave {
            Some(Over::Left)
        } else if self.ends_still && time - self.since >= STANDSTILL - ROUNDING {
            Some(Over::Standstill)
        } else {
            None
        };
        self.over
    }

    /// Returns why it is over, if it is.
    pub fn over(&self) -> Option<Over> {
        self.over
    }

    /// Returns the longest wait of those who are to leave.
    pub fn longest_wait(&self) -> Option<Wait> {
        self.longest
    }

    fn leaves(&self, agent: usize) -> bool {
        self.who.get(agent).copied().unwrap_or(true)
    }

    /// Returns how many are to leave, and how many have left.
    pub fn counts(&self) -> (usize, usize) {
        (self.leave, self.left)
    }

    /// Returns in words how many have not left in a run that ends at a time \[s\], and why it ends; `None` if all have
    /// left.
    pub fn why_some_stay(&self, time: f64) -> Option<String> {
        let why = match self.over {
            Some(Over::Left) => return None,
            Some(Over::Standstill) => {
                format!("in the last {STANDSTILL} s nobody has left or got further than {REACH} m")
            }
            None => "this is the latest end".to_owned(),
        };
        let (leave, stay) = (self.leave, self.leave.saturating_sub(self.left));
        Some(format!("{stay} of {leave} people have not left: {why}; the run ends at t = {time:.3} s"))
    }

    /// Returns those who have come, have not left and were to leave, by their places among the people.
    pub fn stay(&self) -> impl Iterator<Item = usize> {
        let there = self.places.iter().enumerate();
        let there = there.filter(|(_, place)| place.is_some_and(|place| place != OUTSIDE));
        there.map(|(agent, _)| agent).filter(|agent| self.leaves(*agent))
    }

    /// Returns how many are to leave, and have not come yet.
    pub fn outside(&self) -> usize {
        let outside = self.places.iter().enumerate().filter(|(_, place)| **place == Some(OUTSIDE));
        outside.filter(|(agent, _)| self.leaves(*agent)).count()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// When it is over, and why, of people who are there \[m\] at each second; at most an hour.
    fn over(leave: usize, places: impl Fn(f64) -> Vec<Option<Vec2>>) -> Option<(f64, Over)> {
        let mut leaving = Leaving::of((0..2).map(|agent| agent < leave).collect());
        (0..=3600).map(f64::from).find_map(|time| Some((time, leaving.see(time, &places(time))?)))
    }

    #[test]
    fn it_is_over_when_all_have_left_or_nobody_gets_any_further() {
        let walker = |time: f64, end: f64| (time < end).then_some(vec2(0.1 * time, 0.0));
        assert_eq!(over(1, |time| vec![walker(time, 40.0), Some(vec2(1.0, 1.0))]), Some((40.0, Over::Left)));
        // The last one stands; the clock begins as the one before leaves.
        let one_stands = |time| vec![walker(time, 40.0), Some(vec2(1.0, 1.0))];
        assert_eq!(over(2, one_stands), Some((340.0, Over::Standstill)));
        // Who steps back and tries again gets nowhere.
        let tries = |time: f64| vec![Some(vec2(2.0 * (0.7 * time).sin(), 0.0))];
        assert_eq!(over(1, tries), Some((300.0, Over::Standstill)));
        // A slow queue of which one gets somewhere goes on.
        let slow = |time: f64| vec![Some(vec2(0.02 * time, 0.0)), Some(vec2(3.0, 0.0))];
        assert_eq!(over(2, slow), None);
    }

    #[test]
    fn who_stays_is_who_was_to_leave() {
        let here = Some(vec2(0.0, 0.0));
        let mut leaving = Leaving::of(vec![true, false, true]);
        leaving.see(0.0, &[here, here, here]);
        leaving.see(1.0, &[None, here, here]);
        assert_eq!((leaving.stay().collect::<Vec<_>>(), leaving.counts()), (vec![2], (2, 1)));
    }

    #[test]
    fn nobody_waits_who_is_not_there_or_is_not_to_leave() {
        let mut leaving = Leaving::of(vec![true, false]);
        (0..10).map(f64::from).for_each(|time| {
            leaving.see(time, &[None, Some(vec2(0.0, 0.0))]);
        });
        assert_eq!(leaving.longest_wait(), None);
    }

    #[test]
    fn the_longest_wait_is_that_of_somebody_who_is_to_leave() {
        let mut leaving = Leaving::of(vec![true, true, false]);
        // The first one walks 10 m, waits from 10 to 30 s, and leaves; the second one always gets on.
        for time in (0..=40).map(f64::from) {
            let first = vec2(time.min(10.0) + (time - 30.0).max(0.0), 0.0);
            let there = [(time < 35.0).then_some(first), Some(vec2(0.3 * time, 1.0)), Some(vec2(0.0, 2.0))];
            leaving.see(time, &there);
        }
        // At 10 s it is 2 m from its place of 8 s, so a wait begins; at 31 s it is exactly 1 m away, which still counts.
        assert_eq!(leaving.longest_wait(), Some(Wait { agent: 0, from: 10.0, time: 21.0 }));
    }
}
