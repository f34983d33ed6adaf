//! Poses of two runs, compared at each communication point.

use lemons_core::plane::Pose;
use lemons_core::trial::Trial;
use lemons_results::Frame;

/// What is done with the poses of a run.
#[derive(Default)]
pub enum Poses {
    /// Nothing.
    #[default]
    Ignore,
    /// They are kept, to be compared with those of another run.
    Keep,
    /// They are compared with those of each crowd of another run, which are wished to be this close \[m\].
    Compare(Vec<Kept>, f64),
}

/// Poses of a crowd at each communication point.
#[derive(Default)]
pub struct Kept(Vec<Vec<Pose>>);

/// Where two runs of a crowd differ.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// \[m\] The largest one: how far a point of a body is from where it is in the other run.
    pub largest: f64,
    /// Id of the agent, and time \[s\] of it.
    pub at: (String, f64),
    /// Id of the first agent that is further apart than wished, and the first time \[s\].
    pub first: Option<(String, f64)>,
    /// Whether shapes are known; else only positions are compared.
    pub with_shapes: bool,
}

/// What came of the poses of a crowd.
pub enum Seen {
    Kept(Kept),
    Compared(Difference),
}

/// Looks at the poses of a crowd.
pub enum Follower {
    Nobody,
    Keeper(Kept),
    Comparer(Box<Comparer>),
}

/// Compares the poses of a crowd with those of another run.
pub struct Comparer {
    others: std::vec::IntoIter<Vec<Pose>>,
    /// \[m\] from the centre of mass to the rim, by agent; 0 if it is not known.
    rims: Vec<f64>,
    wished: f64,
    largest: (f64, usize, f64),
    first: Option<(usize, f64)>,
    with_shapes: bool,
}

impl Poses {
    /// Of the next crowd, with so many agents.
    pub fn follower(&mut self, trial: Option<&Trial>, agents: usize) -> Follower {
        match self {
            Poses::Ignore => Follower::Nobody,
            Poses::Keep => Follower::Keeper(Kept::default()),
            Poses::Compare(others, _) if others.is_empty() => Follower::Nobody,
            Poses::Compare(others, wished) => {
                let others = others.remove(0).0.into_iter();
                let (rims, with_shapes) = match trial {
                    Some(trial) => (trial.agents.iter().map(rim).collect(), true),
                    None => (vec![0.0; agents], false),
                };
                let (wished, largest) = (*wished, (0.0, 0, 0.0));
                let comparer = Comparer { others, rims, wished, largest, first: None, with_shapes };
                Follower::Comparer(Box::new(comparer))
            }
        }
    }
}

fn rim(agent: &lemons_core::trial::Agent) -> f64 {
    agent.shapes.iter().map(|shape| shape.position.norm() + shape.radius).fold(0.0, f64::max)
}

impl Follower {
    /// Sees the frame of a communication point.
    pub fn see(&mut self, frame: &Frame) {
        let poses = frame.agents.iter().map(|motion| motion.pose);
        match self {
            Follower::Nobody => {}
            Follower::Keeper(kept) => kept.0.push(poses.collect()),
            Follower::Comparer(comparer) => comparer.compare(frame.time, poses),
        }
    }

    /// With the Ids of the agents.
    pub fn finish(self, ids: &[String]) -> Option<Seen> {
        match self {
            Follower::Nobody => None,
            Follower::Keeper(kept) => Some(Seen::Kept(kept)),
            Follower::Comparer(comparer) => {
                let id = |agent: usize| ids.get(agent).cloned().unwrap_or_default();
                let (largest, agent, time) = comparer.largest;
                Some(Seen::Compared(Difference {
                    largest,
                    at: (id(agent), time),
                    first: comparer.first.map(|(agent, time)| (id(agent), time)),
                    with_shapes: comparer.with_shapes,
                }))
            }
        }
    }
}

impl Comparer {
    fn compare(&mut self, time: f64, poses: impl Iterator<Item = Pose>) {
        let Some(others) = self.others.next() else { return };
        for (agent, (pose, other)) in poses.zip(others).enumerate() {
            let rim = self.rims.get(agent).copied().unwrap_or(0.0);
            let apart = pose.apart(&other, rim);
            if apart > self.largest.0 {
                self.largest = (apart, agent, time);
            }
            if apart > self.wished && self.first.is_none() {
                self.first = Some((agent, time));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::{Motion, Twist, vec2};

    #[test]
    fn the_largest_difference_and_the_first_beyond_are_found() {
        let frame = |time: f64, poses: [(f64, f64); 2]| {
            let pose = |(x, orientation)| Pose { position: vec2(x, 0.0), orientation };
            let agents = poses.map(|of| Motion { pose: pose(of), twist: Twist::default() }).to_vec();
            Frame { time, agents, ..Frame::default() }
        };
        let mut keeper = Poses::Keep.follower(None, 2);
        for time in [0.0, 1.0, 2.0] {
            keeper.see(&frame(time, [(time, 0.0), (5.0, 0.0)]));
        }
        let ids = ["a".to_owned(), "b".to_owned()];
        let Some(Seen::Kept(kept)) = keeper.finish(&ids) else { panic!("kept") };
        let mut comparer = Poses::Compare(vec![kept], 0.1).follower(None, 2);
        comparer.see(&frame(0.0, [(0.0, 0.0), (5.0, 3.0)]));
        comparer.see(&frame(1.0, [(1.2, 0.0), (5.0, 0.0)]));
        comparer.see(&frame(2.0, [(2.0, 0.0), (5.5, 0.0)]));
        let Some(Seen::Compared(difference)) = comparer.finish(&ids) else { panic!("compared") };
        assert_eq!(difference.largest, 0.5);
        assert_eq!((difference.at, difference.first), (("b".into(), 2.0), Some(("a".into(), 1.0))));
        assert!(!difference.with_shapes);
    }
}
