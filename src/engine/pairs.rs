//! Candidate pairs and the springs they hold, as arrays.

use super::{BodyId, DiskId, DiskSpring, FaceId, FacePart, FaceSpring, Scene, State};
use std::cmp::Ordering;

/// What a pair remembers from one mechanical step to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spring {
    /// \[m\] along the tangent.
    pub elongation: f64,
    /// \[m/s\] tangential speed at the last evaluation.
    pub slip_speed: f64,
    /// The part of the face it touched; disks are touched [`FacePart::Inside`] by convention.
    pub part: FacePart,
    /// The evaluation that found the pair touching last: it holds a spring only if that was the one before.
    pub touched_at: u64,
}

impl Spring {
    /// Never touched: evaluations count from [`FIRST_EVALUATION`].
    pub const RELAXED: Spring =
        Spring { elongation: 0.0, slip_speed: 0.0, part: FacePart::Inside, touched_at: 0 };
}

/// The evaluation that a state's springs were found by.
pub(super) const FIRST_EVALUATION: u64 = 1;

/// Two disks of different bodies that may touch, with what a first look needs, side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DiskPair {
    /// The receiver.
    pub first: DiskId,
    /// The other.
    pub second: DiskId,
    /// \[m\] sum of the radii.
    pub reach: f64,
}

/// What a contact of two disks needs beyond that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DiskPairDetail {
    pub first_body: BodyId,
    pub second_body: BodyId,
    /// \[m\]
    pub first_radius: f64,
    /// \[m\]
    pub second_radius: f64,
    /// Place in the table of laws.
    pub law: u32,
}

/// A disk and a face that may touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FacePair {
    /// The receiver.
    pub disk: DiskId,
    /// The face.
    pub face: FaceId,
}

/// All candidate pairs, ascending, each with its spring.
///
/// The order makes sums independent of when the list was made: pairs that touch stand in the same
/// order whatever others stand between them.
#[derive(Debug, Clone, Default)]
pub(super) struct Pairs {
    pub disks: Vec<DiskPair>,
    pub disk_details: Vec<DiskPairDetail>,
    pub disk_springs: Vec<Spring>,
    pub faces: Vec<FacePair>,
    pub face_springs: Vec<Spring>,
    /// How many evaluations there have been.
    pub evaluation: u64,
    /// Places of the disk pairs that overlap at the present instant; scratch of the evaluation.
    pub overlapping: Vec<u32>,
}

impl Pairs {
    /// Begins another evaluation: the numbers of the last and of this one.
    pub fn next_evaluation(&mut self) -> (u64, u64) {
        self.evaluation += 1;
        (self.evaluation - 1, self.evaluation)
    }

    /// Lists these pairs instead of the old ones, whose springs stay with those in both lists.
    pub fn replace(
        &mut self,
        scene: &Scene,
        mut disks: Vec<(DiskId, DiskId)>,
        mut faces: Vec<(DiskId, FaceId)>,
    ) {
        disks.sort_unstable();
        faces.sort_unstable();
        let old = self.disks.iter().map(|pair| (pair.first, pair.second));
        self.disk_springs = kept(old.zip(self.disk_springs.iter().copied()), &disks);
        let old = self.faces.iter().map(|pair| (pair.disk, pair.face));
        self.face_springs = kept(old.zip(self.face_springs.iter().copied()), &faces);
        self.disks.clear();
        self.disk_details.clear();
        for (first, second) in disks {
            self.push_disks(scene, first, second);
        }
        self.faces.clear();
        self.faces.extend(faces.into_iter().map(|(disk, face)| FacePair { disk, face }));
    }

    fn push_disks(&mut self, scene: &Scene, first: DiskId, second: DiskId) {
        let (a, b) = (&scene.disks[first.index()], &scene.disks[second.index()]);
        self.disks.push(DiskPair { first, second, reach: a.radius + b.radius });
        self.disk_details.push(DiskPairDetail {
            first_body: a.body,
            second_body: b.body,
            first_radius: a.radius,
            second_radius: b.radius,
            law: scene.law_between(a.material, b.material),
        });
    }

    /// Holds just the state's springs: what the first rebuild of a communication step starts from.
    pub fn load(&mut self, scene: &Scene, state: &State) {
        self.evaluation = FIRST_EVALUATION;
        let spring =
            |elongation, part| Spring { elongation, slip_speed: 0.0, part, touched_at: FIRST_EVALUATION };
        self.disks.clear();
        self.disk_details.clear();
        self.disk_springs.clear();
        for known in &state.disk_springs {
            self.push_disks(scene, known.first, known.second);
            self.disk_springs.push(spring(known.elongation, FacePart::Inside));
        }
        self.faces.clear();
        self.face_springs.clear();
        for known in &state.face_springs {
            self.faces.push(FacePair { disk: known.disk, face: known.face });
            self.face_springs.push(spring(known.elongation, known.part));
        }
    }

    /// Writes the springs of the touching pairs into the state.
    pub fn store(&self, state: &mut State) {
        let touching = |spring: &Spring| spring.touched_at == self.evaluation;
        state.disk_springs.clear();
        let disks = self.disks.iter().zip(&self.disk_springs).filter(|(_, spring)| touching(spring));
        state.disk_springs.extend(disks.map(|(pair, spring)| DiskSpring {
            first: pair.first,
            second: pair.second,
            elongation: spring.elongation,
        }));
        state.face_springs.clear();
        let faces = self.faces.iter().zip(&self.face_springs).filter(|(_, spring)| touching(spring));
        state.face_springs.extend(faces.map(|(pair, spring)| FaceSpring {
            disk: pair.disk,
            face: pair.face,
            part: spring.part,
            elongation: spring.elongation,
        }));
    }
}

/// The springs of the new pairs, both lists ascending: those of the old ones, relaxed for others.
fn kept<Key: Copy + Ord>(old: impl Iterator<Item = (Key, Spring)>, new: &[Key]) -> Vec<Spring> {
    let mut old = old.peekable();
    let spring = |key: &Key| {
        while old.next_if(|(known, _)| known < key).is_some() {}
        match old.next_if(|(known, _)| known.cmp(key) == Ordering::Equal) {
            Some((_, spring)) => spring,
            None => Spring::RELAXED,
        }
    };
    new.iter().map(spring).collect()
}
