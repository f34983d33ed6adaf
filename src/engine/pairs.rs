//! Candidate pairs and the springs they hold, as arrays.

use super::{DiskId, DiskSpring, FaceId, FacePart, FaceSpring, State};
use std::cmp::Ordering;

/// What a pair remembers from one mechanical step to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spring {
    /// \[m\] along the tangent.
    pub elongation: f64,
    /// \[m/s\] tangential speed at the last evaluation.
    pub slip_speed: f64,
    /// The part of the face it touches; disks are touched [`FacePart::Inside`] by convention.
    pub touching: Option<FacePart>,
}

impl Spring {
    pub const RELAXED: Spring = Spring { elongation: 0.0, slip_speed: 0.0, touching: None };

    fn stretched(elongation: f64, part: FacePart) -> Spring {
        Spring { elongation, slip_speed: 0.0, touching: Some(part) }
    }
}

/// Pairs of a disk with something else, ascending, each with its spring.
///
/// The order makes sums independent of when the list was made: pairs that touch stand in the same
/// order whatever others stand between them.
#[derive(Debug, Clone)]
pub(super) struct PairList<Other> {
    pub first: Vec<DiskId>,
    pub second: Vec<Other>,
    pub spring: Vec<Spring>,
}

impl<Other> Default for PairList<Other> {
    fn default() -> Self {
        PairList { first: Vec::new(), second: Vec::new(), spring: Vec::new() }
    }
}

impl<Other: Copy + Ord> PairList<Other> {
    pub fn len(&self) -> usize {
        self.first.len()
    }

    pub fn clear(&mut self) {
        self.first.clear();
        self.second.clear();
        self.spring.clear();
    }

    /// Takes the place of the old list: pairs in both keep their springs.
    pub fn replace(&mut self, mut keys: Vec<(DiskId, Other)>) {
        keys.sort_unstable();
        let old = std::mem::take(self);
        let mut at = 0;
        for (first, second) in keys {
            let key = (first, second);
            while at < old.len() && (old.first[at], old.second[at]) < key {
                at += 1;
            }
            let kept = at < old.len() && (old.first[at], old.second[at]).cmp(&key) == Ordering::Equal;
            self.first.push(first);
            self.second.push(second);
            self.spring.push(if kept { old.spring[at] } else { Spring::RELAXED });
        }
    }

    fn touching(&self) -> impl Iterator<Item = (DiskId, Other, FacePart, f64)> + '_ {
        (0..self.len()).filter_map(|k| {
            let spring = &self.spring[k];
            spring.touching.map(|part| (self.first[k], self.second[k], part, spring.elongation))
        })
    }
}

/// All candidate pairs.
#[derive(Debug, Clone, Default)]
pub(super) struct Pairs {
    pub disks: PairList<DiskId>,
    pub faces: PairList<FaceId>,
}

impl Pairs {
    /// Holds just the state's springs: what the first rebuild of a communication step starts from.
    pub fn load(&mut self, state: &State) {
        self.disks.clear();
        self.faces.clear();
        for spring in &state.disk_springs {
            self.disks.first.push(spring.first);
            self.disks.second.push(spring.second);
            self.disks.spring.push(Spring::stretched(spring.elongation, FacePart::Inside));
        }
        for spring in &state.face_springs {
            self.faces.first.push(spring.disk);
            self.faces.second.push(spring.face);
            self.faces.spring.push(Spring::stretched(spring.elongation, spring.part));
        }
    }

    /// Writes the springs of the touching pairs into the state.
    pub fn store(&self, state: &mut State) {
        state.disk_springs.clear();
        state.disk_springs.extend(self.disks.touching().map(|(first, second, _, elongation)| DiskSpring {
            first,
            second,
            elongation,
        }));
        state.face_springs.clear();
        state.face_springs.extend(self.faces.touching().map(|(disk, face, part, elongation)| FaceSpring {
            disk,
            face,
            part,
            elongation,
        }));
    }
}
