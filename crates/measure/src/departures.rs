//! Who has left, by any exit.

use lemons_record::Frame;
use serde::Serialize;

/// Who has left so far. It is given all frames in the order of time.
#[derive(Debug, Clone, PartialEq)]
pub struct Departures {
    /// \[s\] Of each person who is gone, the first frame without it.
    times: Vec<Option<f64>>,
    /// Whether a frame says who is there.
    known: bool,
}

/// Who has left, at all exits together.
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
}

impl Departures {
    /// Of so many people.
    pub fn of(people: usize) -> Departures {
        Departures { times: vec![None; people], known: false }
    }

    /// Adds the next frame. Who comes back has not left.
    pub fn add(&mut self, frame: &Frame) {
        self.known |= frame.active.is_some();
        for (place, gone) in self.times.iter_mut().enumerate() {
            *gone = if frame.is_there(place) { None } else { gone.or(Some(frame.time)) };
        }
    }

    /// Returns who has left; `None` if no frame says who is there.
    pub fn left(&self) -> Option<Left> {
        let gone = || self.times.iter().flatten().copied();
        let (people, last) = (gone().count(), gone().reduce(f64::max));
        let all = people == self.times.len();
        let left =
            Left { people, first: gone().reduce(f64::min), last, evacuation_time: last.filter(|_| all) };
        self.known.then_some(left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn left(frames: &[Option<[bool; 2]>]) -> Option<Left> {
        let mut departures = Departures::of(2);
        for (k, active) in frames.iter().enumerate() {
            let active = active.map(|there| there.to_vec());
            departures.add(&Frame { time: k as f64, active, ..Frame::default() });
        }
        departures.left()
    }

    #[test]
    fn who_is_gone_for_good_has_left() {
        let (here, gone) = (true, false);
        assert_eq!(left(&[None, None]), None);
        let nobody = Left { people: 0, first: None, last: None, evacuation_time: None };
        assert_eq!(left(&[Some([here, here]), Some([gone, here]), Some([here, here])]), Some(nobody));
        let one = Left { people: 1, first: Some(1.0), last: Some(1.0), evacuation_time: None };
        assert_eq!(left(&[Some([here, here]), Some([here, gone]), Some([here, gone])]), Some(one));
        let both = Left { people: 2, first: Some(1.0), last: Some(3.0), evacuation_time: Some(3.0) };
        assert_eq!(
            left(&[Some([here, here]), Some([here, gone]), Some([here, gone]), Some([gone, gone])]),
            Some(both)
        );
    }
}
