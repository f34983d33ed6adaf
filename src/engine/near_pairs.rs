//! Candidates, near pairs and their springs, as arrays.

use super::body_kinematics::BodyKinematics;
use super::circle::Circle;
use super::contact_law::SpringHistory;
use super::{BodyId, DiskId, DiskSpring, FaceId, FacePart, FaceSpring, Scene, State, Vec2};
use std::iter::Peekable;
use std::slice::Iter;

/// The memory of a pair between mechanical steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Spring {
    /// The contact at the last evaluation.
    pub history: SpringHistory,
    /// The part of the face it touched; for two disks it is [`FacePart::Left`] by convention.
    pub part: FacePart,
    /// Number of the last evaluation in which the pair touched. It has a spring only if that was the previous one.
    pub touched_at: u32,
}

impl Spring {
    /// A pair that never touched: evaluations are numbered from [`FIRST_EVALUATION`].
    pub const RELAXED: Spring = Spring { history: SpringHistory::NONE, part: FacePart::Left, touched_at: 0 };
}

/// The number of the evaluation to which the springs of a state belong.
pub(super) const FIRST_EVALUATION: u32 = 1;

/// Two disks of different bodies that may touch, with the data of a first check side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DiskPair {
    /// Body of the receiver.
    pub first_body: BodyId,
    /// Body of the other disk; it has a higher index.
    pub second_body: BodyId,
    /// \[m\] [`super::ContactDisk::offset`] of the receiver's disk.
    pub first_offset: Vec2,
    /// \[m\] [`super::ContactDisk::offset`] of the other disk.
    pub second_offset: Vec2,
    /// \[m\] Sum of the radii.
    pub reach: f64,
}

/// The relative position of two disks.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Separation {
    /// \[m\] Vector from the other's centre to the receiver's.
    pub between: Vec2,
    /// \[m\] Vector from the receiver's centre of mass to its disk's centre.
    pub arm: Vec2,
    /// \[m\] Vector from the other's centre of mass to its disk's centre.
    pub other_arm: Vec2,
}

impl DiskPair {
    /// Returns the relative position of the disks for the present poses.
    #[inline(always)]
    pub fn separation(&self, kinematics: &[BodyKinematics]) -> Separation {
        let (i, j) = (&kinematics[self.first_body.index()], &kinematics[self.second_body.index()]);
        let (arm, other_arm) = (i.arm(self.first_offset), j.arm(self.second_offset));
        Separation { between: (i.position + arm) - (j.position + other_arm), arm, other_arm }
    }
}

/// The further data of a contact of two disks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct DiskPairDetail {
    /// Disk of the receiver.
    pub first: DiskId,
    /// The other disk.
    pub second: DiskId,
    /// \[m\] Radius of the receiver's disk.
    pub first_radius: f64,
    /// \[m\] Radius of the other disk.
    pub second_radius: f64,
    /// Index in the table of laws.
    pub law: u32,
}

/// A disk and a face that may touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FacePair {
    /// Disk of the receiver.
    pub disk: DiskId,
    /// The face.
    pub face: FaceId,
}

/// Pairs that may soon be near, ascending.
#[derive(Debug, Clone, Default)]
pub(super) struct Candidates {
    pub disks: Vec<(DiskId, DiskId)>,
    pub faces: Vec<(DiskId, FaceId)>,
}

impl Candidates {
    pub fn count(&self) -> usize {
        self.disks.len() + self.faces.len()
    }
}

/// Near pairs, ascending, each with its spring.
///
/// The order makes sums independent of the time when the list was made: touching pairs are in the same order whatever
/// other pairs are between them.
#[derive(Debug, Clone, Default)]
pub(super) struct NearPairs {
    pub disks: Vec<DiskPair>,
    pub disk_details: Vec<DiskPairDetail>,
    pub disk_springs: Vec<Spring>,
    pub faces: Vec<FacePair>,
    pub face_springs: Vec<Spring>,
    /// The disk pairs that touched in the last evaluation: one bit for each, [`AT_ONCE`] in a word.
    pub touching: Vec<u32>,
    /// Scratch space.
    pub overlapping: Overlapping,
    /// The previous list; scratch space.
    old: OldPairs,
}

/// Among some disk pairs, those that overlap at the present instant, and their indices.
pub(super) type Overlapping = [(usize, Separation); AT_ONCE];

/// Number of pairs that are processed together, so that intermediate results stay in the nearest cache.
pub(super) const AT_ONCE: usize = u32::BITS as usize;

/// Writes the bit of pair `k`, which follows those that are there.
#[inline(always)]
fn mark(touching: &mut Vec<u32>, k: usize, touches: bool) {
    if k.is_multiple_of(AT_ONCE) {
        touching.push(0);
    }
    if let Some(word) = touching.last_mut() {
        *word |= u32::from(touches) << (k % AT_ONCE);
    }
}

/// The pairs that touched, and their springs.
#[derive(Debug, Clone, Default)]
struct OldPairs {
    disks: Vec<((DiskId, DiskId), Spring)>,
    faces: Vec<((DiskId, FaceId), Spring)>,
}

impl NearPairs {
    /// Replaces the near pairs by the candidates that meet after an evaluation if each disk is larger by the margin of its
    /// body. Pairs that remain keep their springs; candidates that touched in this evaluation remain.
    pub fn renew(&mut self, scene: &Scene, enlarged: &[Circle], candidates: &Candidates, evaluation: u32) {
        self.put_aside(evaluation);
        let mut old = self.old.disks.iter().peekable();
        for &(first, second) in &candidates.disks {
            let spring = kept(&mut old, (first, second));
            if enlarged[first.index()].nears(&enlarged[second.index()], 0.0) || spring.is_some() {
                push_disks(&mut self.disks, &mut self.disk_details, scene, first, second);
                mark(&mut self.touching, self.disk_springs.len(), spring.is_some());
                self.disk_springs.push(spring.unwrap_or(Spring::RELAXED));
            }
        }
        let mut old = self.old.faces.iter().peekable();
        for &(disk, face) in &candidates.faces {
            let spring = kept(&mut old, (disk, face));
            if enlarged[disk.index()].nears_face(&scene.faces, face, 0.0) || spring.is_some() {
                self.face_springs.push(spring.unwrap_or(Spring::RELAXED));
                self.faces.push(FacePair { disk, face });
            }
        }
        give_back(&mut self.disks);
        give_back(&mut self.disk_details);
        give_back(&mut self.disk_springs);
    }

    /// Whether the bits are those of the springs that touched in an evaluation.
    #[cfg(test)]
    pub fn marked(&self, evaluation: u32) -> bool {
        let of_springs = self.disk_springs.chunks(AT_ONCE).map(|some| {
            some.iter()
                .enumerate()
                .fold(0, |word, (k, spring)| word | u32::from(spring.touched_at == evaluation) << k)
        });
        of_springs.eq(self.touching.iter().copied())
    }

    /// Empties the list, but keeps the springs of the pairs that touched in an evaluation.
    fn put_aside(&mut self, evaluation: u32) {
        let disks = self.disk_details.drain(..).map(|pair| (pair.first, pair.second));
        self.old.disks.clear();
        self.old.disks.extend(touched(disks, self.disk_springs.drain(..), evaluation));
        let faces = self.faces.drain(..).map(|pair| (pair.disk, pair.face));
        self.old.faces.clear();
        self.old.faces.extend(touched(faces, self.face_springs.drain(..), evaluation));
        self.disks.clear();
        self.touching.clear();
    }

    /// Empties the list.
    pub fn clear(&mut self) {
        self.disks.clear();
        self.disk_details.clear();
        self.disk_springs.clear();
        self.faces.clear();
        self.face_springs.clear();
        self.touching.clear();
    }

    /// Adds the pair of a state's spring, which belongs to the [`FIRST_EVALUATION`].
    pub fn load_disks(&mut self, scene: &Scene, known: &DiskSpring) {
        push_disks(&mut self.disks, &mut self.disk_details, scene, known.first, known.second);
        self.disk_springs.push(loaded(known.elongation, FacePart::Left));
    }

    /// Adds the pair of a state's spring at a face.
    pub fn load_face(&mut self, known: &FaceSpring) {
        self.faces.push(FacePair { disk: known.disk, face: known.face });
        self.face_springs.push(loaded(known.elongation, known.part));
    }

    /// Adds the springs of the pairs that touched in an evaluation to the state.
    pub fn store(&self, evaluation: u32, state: &mut State) {
        let touching = |spring: &Spring| spring.touched_at == evaluation;
        let disks = self.disk_details.iter().zip(&self.disk_springs);
        state.disk_springs.extend(disks.filter(|(_, spring)| touching(spring)).map(|(pair, spring)| {
            DiskSpring { first: pair.first, second: pair.second, elongation: spring.history.elongation }
        }));
        let faces = self.faces.iter().zip(&self.face_springs);
        state.face_springs.extend(faces.filter(|(_, spring)| touching(spring)).map(|(pair, spring)| {
            let elongation = spring.history.elongation;
            FaceSpring { disk: pair.disk, face: pair.face, part: spring.part, elongation }
        }));
    }
}

/// Gives back memory that a list no longer needs: it was longer before, or a growing list took twice its size.
fn give_back<T>(list: &mut Vec<T>) {
    let count = list.len();
    if list.capacity() > count + count / 2 {
        list.shrink_to(count + count / 4);
    }
}

fn push_disks(
    disks: &mut Vec<DiskPair>,
    details: &mut Vec<DiskPairDetail>,
    scene: &Scene,
    first: DiskId,
    second: DiskId,
) {
    let (a, b) = (&scene.disks[first.index()], &scene.disks[second.index()]);
    disks.push(DiskPair {
        first_body: a.body,
        second_body: b.body,
        first_offset: a.offset,
        second_offset: b.offset,
        reach: a.radius + b.radius,
    });
    details.push(DiskPairDetail {
        first,
        second,
        first_radius: a.radius,
        second_radius: b.radius,
        law: scene.law_between(a.material, b.material),
    });
}

fn loaded(elongation: f64, part: FacePart) -> Spring {
    Spring {
        history: SpringHistory { elongation, ..SpringHistory::NONE },
        part,
        touched_at: FIRST_EVALUATION,
    }
}

/// The pairs that touched in an evaluation, and their springs.
fn touched<Key>(
    pairs: impl Iterator<Item = Key>,
    springs: impl Iterator<Item = Spring>,
    evaluation: u32,
) -> impl Iterator<Item = (Key, Spring)> {
    pairs.zip(springs).filter(move |(_, spring)| spring.touched_at == evaluation)
}

/// Returns the spring of the next listed pair if it is in the old list; both are ascending.
#[inline(always)]
fn kept<Key: Copy + Ord>(old: &mut Peekable<Iter<(Key, Spring)>>, key: Key) -> Option<Spring> {
    while old.next_if(|(known, _)| *known < key).is_some() {}
    old.next_if(|(known, _)| *known == key).map(|&(_, spring)| spring)
}
