//! People who have left, by any exit.

use crate::Frame;
use lemons_core::plane::{Bounds, Vec2};
use serde::{Deserialize, Serialize};

/// Finds people who have left. It is given all frames in the order of time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Departures {
    /// \[s\] Of each person who is gone, the first frame without it.
    times: Vec<Option<f64>>,
    /// \[m\] Where each person was seen last, if at all.
    places: Vec<Option<Vec2>>,
    /// Whether a frame says who is there.
    known: bool,
    /// Whether who was seen in no frame has left before the first one.
    unseen: bool,
}

/// Departures at all exits together.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Left {
    /// People who were gone at the end.
    pub people: usize,
    /// \[s\] When the first of them was gone.
    pub first: Option<f64>,
    /// \[s\] When the last of them was gone.
    pub last: Option<f64>,
    /// \[s\] When nobody was there any more; `None` if somebody is.
    pub evacuation_time: Option<f64>,
    /// \[m\] Lower left and upper right corner of a rectangle around where they were seen last.
    pub last_seen: Option<[[f64; 2]; 2]>,
}

impl Departures {
    /// Returns whether they can be of so many people.
    pub fn fits(&self, people: usize) -> bool {
        let finite = self.times.iter().flatten().all(|time| time.is_finite())
            && self.places.iter().flatten().all(|at| at.iter().all(|x| x.is_finite()));
        self.times.len() == people && self.places.len() == people && finite
    }

    /// Begins, for so many people.
    pub fn of(people: usize) -> Departures {
        Departures { times: vec![None; people], places: vec![None; people], known: false, unseen: true }
    }

    /// Begins, for so many people who may also appear: who was not seen yet has not left.
    pub fn of_appearing(people: usize) -> Departures {
        Departures { unseen: false, ..Departures::of(people) }
    }

    /// Adds the next frame. Who comes, or comes back, has not left.
    pub fn add(&mut self, frame: &Frame) {
        self.known |= frame.active.is_some();
        for (place, gone) in self.times.iter_mut().enumerate() {
            let here = frame.is_there(place) || frame.is_outside(place);
            *gone = if here { None } else { gone.or(Some(frame.time)) };
        }
        for (place, agent) in frame.present() {
            self.places[place] = Some(agent.pose.position);
        }
    }

    /// Returns of each person who is gone, when \[s\] the first frame without it was.
    pub fn times(&self) -> &[Option<f64>] {
        &self.times
    }

    /// Returns who has left; `None` if no frame says who is there.
    pub fn left(&self) -> Option<Left> {
        let seen = self.times.iter().zip(&self.places).filter(|(_, place)| self.unseen || place.is_some());
        let gone: Vec<f64> = seen.filter_map(|(time, _)| *time).collect();
        let last = gone.iter().copied().reduce(f64::max);
        let places = self.times.iter().zip(&self.places).filter_map(|(time, place)| time.and(*place));
        self.known.then(|| Left {
            people: gone.len(),
            first: gone.iter().copied().reduce(f64::min),
            last,
            evacuation_time: last.filter(|_| gone.len() == self.times.len()),
            last_seen: Bounds::of(places).map(|Bounds { low, high }| [low.into(), high.into()]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::{Motion, Pose, vec2};

    fn left(frames: &[Option<[bool; 2]>]) -> Option<Left> {
        let mut departures = Departures::of(2);
        for (k, active) in frames.iter().enumerate() {
            let active = active.map(|there| there.to_vec());
            // Both walk along x, two metres apart.
            let at = |y: f64| Motion {
                pose: Pose { position: vec2(k as f64, y), orientation: 0.0 },
                ..Motion::default()
            };
            let agents = vec![at(0.0), at(2.0)];
            departures.add(&Frame { time: k as f64, active, agents, ..Frame::default() });
        }
        departures.left()
    }

    #[test]
    fn who_is_gone_for_good_has_left() {
        let (here, gone) = (true, false);
        assert_eq!(left(&[None, None]), None);
        let nobody = Left { people: 0, first: None, last: None, evacuation_time: None, last_seen: None };
        assert_eq!(left(&[Some([here, here]), Some([gone, here]), Some([here, here])]), Some(nobody));
        let (first, last, last_seen) = (Some(1.0), Some(1.0), Some([[0.0, 2.0]; 2]));
        let one = Left { people: 1, first, last, evacuation_time: None, last_seen };
        assert_eq!(left(&[Some([here, here]), Some([here, gone]), Some([here, gone])]), Some(one));
        // Who appears has not left before.
        let frames = [[here, gone], [gone, gone]];
        let mut appearing = Departures::of_appearing(2);
        for (k, active) in (0..).zip(frames) {
            let agents = vec![Motion::default(); 2];
            appearing.add(&Frame {
                time: f64::from(k),
                active: Some(active.to_vec()),
                agents,
                ..Frame::default()
            });
        }
        let seen = appearing.left().unwrap();
        assert_eq!((seen.people, seen.last, seen.evacuation_time), (1, Some(1.0), None));
        // Who was gone before the first frame was seen nowhere.
        let before = left(&[Some([here, gone]), Some([gone, gone])]).unwrap();
        assert_eq!((before.people, before.last_seen), (2, Some([[0.0, 0.0]; 2])));
        let (last, last_seen) = (Some(3.0), Some([[0.0, 0.0], [2.0, 2.0]]));
        let both = Left { people: 2, first, last, evacuation_time: Some(3.0), last_seen };
        assert_eq!(
            left(&[Some([here, here]), Some([here, gone]), Some([here, gone]), Some([gone, gone])]),
            Some(both)
        );
    }
}
