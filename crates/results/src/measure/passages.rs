//! People who have crossed a line so far.

use crate::Frame;
use crate::measure::crossing::{CountingLine, Crossing, Way, is_walked};
use crate::measure::present;
use lemons_core::plane::Vec2;

/// A person crosses a line for the first time in a direction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passage {
    /// \[s\] Between two frames, places change linearly.
    pub time: f64,
    /// Place of the person in the frames.
    pub agent: usize,
}

/// Counts who crosses a line. It is given all frames in the order of time.
#[derive(Debug, Clone)]
pub struct Passages {
    line: CountingLine,
    /// \[s\] The newest frame.
    time: f64,
    people: Vec<Person>,
}

#[derive(Debug, Clone, Default)]
struct Person {
    /// \[m\] At the newest frame that has this person.
    place: Option<Vec2>,
    /// \[s\] When the person crossed in each direction.
    crossed: [Vec<f64>; 2],
}

impl Passages {
    /// Begins to count over a line.
    pub fn over(line: CountingLine, people: usize) -> Passages {
        Passages { line, time: f64::NAN, people: vec![Person::default(); people] }
    }

    /// Adds the next frame. Who is in no frame between two is not followed between them.
    pub fn add(&mut self, frame: &Frame) {
        let (line, before) = (self.line, self.time);
        for (agent, person) in self.people.iter_mut().enumerate() {
            let place = present(frame, agent).map(|motion| motion.pose.position);
            if let (Some(from), Some(to)) = (person.place, place)
                && is_walked(from, to, frame.time - before)
                && let Some(Crossing { way, part }) = line.crossing(from, to)
            {
                person.crossed[way as usize].push(before + part * (frame.time - before));
            }
            person.place = place;
        }
        self.time = frame.time;
    }

    /// Returns the first crossing of each person in a direction, in the order of time: their number up to a time is N(t).
    pub fn first(&self, way: Way) -> Vec<Passage> {
        let first = |(agent, person): (usize, &Person)| {
            Some(Passage { time: *person.crossed[way as usize].first()?, agent })
        };
        let mut all: Vec<Passage> = self.people.iter().enumerate().filter_map(first).collect();
        // Who crosses at the same time stays in the order of the frames.
        all.sort_by(|a, b| a.time.total_cmp(&b.time));
        all
    }

    /// Returns how often people crossed in a direction, counting all who came back and crossed again.
    pub fn crossings(&self, way: Way) -> usize {
        self.people.iter().map(|person| person.crossed[way as usize].len()).sum()
    }

    /// Returns when people crossed in a direction for the last time \[s\]: only those who did not come back, ascending.
    pub fn stayed(&self, way: Way) -> Vec<f64> {
        let (there, back) = (way as usize, 1 - way as usize);
        let stayed = self.people.iter().map(|person| &person.crossed);
        let stayed = stayed.filter(|crossed| crossed[there].len() > crossed[back].len());
        let mut times: Vec<f64> = stayed.filter_map(|crossed| crossed[there].last().copied()).collect();
        times.sort_by(f64::total_cmp);
        times
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::{Motion, Pose, vec2};

    const DOOR: CountingLine = CountingLine { from: vec2(0.0, 0.0), to: vec2(0.0, 1.0) };

    /// Counts people with these x \[m\], frames 0.5 s apart. Not a number: the person is not there.
    fn counted(frames: &[&[f64]]) -> Passages {
        let mut passages = Passages::over(DOOR, frames[0].len());
        for (k, places) in frames.iter().enumerate() {
            let motion = |&x: &f64| Motion {
                pose: Pose { position: vec2(x, 0.5), orientation: 0.0 },
                ..Motion::default()
            };
            let agents = places.iter().map(motion).collect();
            passages.add(&Frame { time: k as f64 * 0.5, agents, ..Frame::default() });
        }
        passages
    }

    fn times(passages: &Passages, way: Way) -> Vec<(f64, usize)> {
        passages.first(way).iter().map(|passage| (passage.time, passage.agent)).collect()
    }

    #[test]
    fn who_walks_back_and_forth_passes_once_in_each_direction() {
        let seen = counted(&[&[-1.0], &[1.0], &[-3.0], &[-1.0], &[1.0], &[2.0]]);
        assert_eq!(times(&seen, Way::Right), [(0.25, 0)]);
        assert_eq!(times(&seen, Way::Left), [(0.625, 0)]);
        assert_eq!((seen.crossings(Way::Right), seen.crossings(Way::Left)), (2, 1));
        // Out for good at the second time.
        assert_eq!((seen.stayed(Way::Right), seen.stayed(Way::Left)), (vec![1.75], vec![]));
        // Who came back has not left.
        let back = counted(&[&[-1.0], &[1.0], &[-1.0]]);
        assert!(back.stayed(Way::Right).is_empty() && back.stayed(Way::Left).is_empty());
        // In the order of time.
        let seen = counted(&[&[-3.0, -1.0, 1.0, -2.0], &[1.0, 3.0, 2.0, -2.0]]);
        assert_eq!(times(&seen, Way::Right), [(0.125, 1), (0.375, 0)]);
        assert_eq!(seen.stayed(Way::Right), [0.125, 0.375]);
        // Who was not there between two frames did not cross.
        let seen = counted(&[&[-1.0, -1.0], &[f64::NAN, -0.5], &[1.0, f64::NAN]]);
        assert!(times(&seen, Way::Right).is_empty());
    }
}
