//! Two things that touch: where, and how they move relative to each other.

use super::contact_law::Reaction;
use super::face::nearest_on_face;
use super::overlap::{Meeting, Overlap, books_contact, meet, meet_face};
use super::pairs::{DiskPair, DiskPairDetail, FacePair, Sight};
use super::standing::Standing;
use super::{BodyId, FacePart, PairLaw, Scene, Twist, Vec2, Wrench};

/// The instant at which contacts are evaluated.
pub(super) struct Instant<'a> {
    pub scene: &'a Scene,
    /// One for each body.
    pub standing: &'a [Standing],
    /// Returns the twist of a body without its last half kick.
    pub unkicked: &'a (dyn Fn(BodyId) -> Twist + Sync),
    /// The number of the previous evaluation.
    pub before: u32,
}

/// What becomes of a pair that is near.
pub(super) enum Found<T> {
    Apart,
    /// The centres coincide, so that there is no normal.
    Coincident {
        /// \[m\] overlap h.
        depth: f64,
        part: FacePart,
    },
    Touching(T),
}

/// Two touching things, before the law is applied.
#[derive(Clone, Copy)]
pub(super) struct Encounter<'a> {
    pub law: &'a PairLaw,
    pub overlap: Overlap,
    pub part: FacePart,
    /// \[m\] from the receiver's centre of mass to the contact point.
    pub arm: Vec2,
    /// \[m\] from the other's centre of mass to the contact point.
    pub other_arm: Vec2,
    /// \[m/s\] of the receiver relative to the other at the contact point.
    pub velocity: Vec2,
}

/// Two touching things, and the forces between them.
pub(super) struct Touch {
    pub overlap: Overlap,
    pub part: FacePart,
    /// \[m\] from the receiver's centre of mass to the contact point.
    pub arm: Vec2,
    /// \[m\] from the other's centre of mass to the contact point.
    pub other_arm: Vec2,
    pub normal_speed: f64,
    pub slip_speed: f64,
    /// \[m\] of the spring, before the slider may give way.
    pub elongation: f64,
    pub reaction: Reaction,
}

impl Instant<'_> {
    /// Two disks that may touch.
    #[inline(always)]
    pub fn meet_disks(
        &self,
        pair: &DiskPair,
        detail: &DiskPairDetail,
        sight: &Sight,
    ) -> Found<Encounter<'_>> {
        match meet(sight.between, pair.reach) {
            Meeting::Apart => Found::Apart,
            Meeting::Coincident => Found::Coincident { depth: pair.reach, part: FacePart::Left },
            Meeting::Touching(overlap) => Found::Touching(self.disks_encounter(pair, detail, sight, overlap)),
        }
    }

    /// Two disks with an overlap, which is negative where they do not touch.
    #[inline(always)]
    pub fn disks_encounter(
        &self,
        pair: &DiskPair,
        detail: &DiskPairDetail,
        sight: &Sight,
        overlap: Overlap,
    ) -> Encounter<'_> {
        let (i, j) = (&self.standing[pair.first_body.index()], &self.standing[pair.second_body.index()]);
        let arm = sight.arm + overlap.contact_point(detail.first_radius);
        let other_arm = sight.other_arm - overlap.contact_point(detail.second_radius);
        let velocity = i.velocity_at(arm) - j.velocity_at(other_arm);
        let law = self.scene.law_at(detail.law);
        Encounter { law, overlap, part: FacePart::Left, arm, other_arm, velocity }
    }

    /// A disk and a face that may touch.
    #[inline(always)]
    pub fn meet_face(&self, pair: &FacePair) -> Found<Encounter<'_>> {
        let (disk, face) = (&self.scene.disks[pair.disk.index()], pair.face.index());
        let (wall, standing) = (&self.scene.faces[face], &self.standing[disk.body.index()]);
        let centre = standing.position + standing.arm(disk.offset);
        let nearest = nearest_on_face(wall, centre);
        let apart = (centre - nearest.0).norm_squared() >= disk.radius * disk.radius;
        if apart || !books_contact(self.scene, face, nearest, centre) {
            return Found::Apart;
        }
        let (meeting, part) = meet_face(wall, nearest, centre, disk.radius, standing.position);
        match meeting {
            Meeting::Apart => Found::Apart,
            Meeting::Coincident => Found::Coincident { depth: disk.radius, part },
            Meeting::Touching(overlap) => Found::Touching(self.face_encounter(pair, overlap, part)),
        }
    }

    /// A disk and a part of a face with an overlap, which is negative where they do not touch.
    #[inline(always)]
    pub fn face_encounter(&self, pair: &FacePair, overlap: Overlap, part: FacePart) -> Encounter<'_> {
        let (disk, wall) = (&self.scene.disks[pair.disk.index()], &self.scene.faces[pair.face.index()]);
        let standing = &self.standing[disk.body.index()];
        let arm = standing.arm(disk.offset) + overlap.contact_point(disk.radius);
        let law = self.scene.law(disk.material, wall.material);
        let velocity = standing.velocity_at(arm);
        Encounter { law, overlap, part, arm, other_arm: Vec2::ZERO, velocity }
    }
}

impl Encounter<'_> {
    /// \[m/s\] along the normal, positive if they separate, and along the tangent.
    #[inline(always)]
    pub fn speeds(&self) -> (f64, f64) {
        (self.velocity.dot(self.overlap.normal), self.velocity.dot(self.overlap.normal.perp()))
    }

    #[inline(always)]
    pub fn touch(&self, elongation: f64, reaction: Reaction) -> Touch {
        let (normal_speed, slip_speed) = self.speeds();
        let Encounter { overlap, part, arm, other_arm, .. } = *self;
        Touch { overlap, part, arm, other_arm, normal_speed, slip_speed, elongation, reaction }
    }
}

impl Touch {
    /// \[N\] on the receiver.
    #[inline]
    pub fn force(&self) -> Vec2 {
        let normal = self.overlap.normal;
        normal * self.reaction.normal + normal.perp() * self.reaction.tangential
    }

    /// The wrench on the receiver, of the force on it.
    #[inline(always)]
    pub fn on_receiver(&self, force: Vec2) -> Wrench {
        Wrench { force, torque: self.arm.cross(force) }
    }

    /// The wrench on the other body, of the force on the receiver.
    #[inline(always)]
    pub fn on_giver(&self, force: Vec2) -> Wrench {
        Wrench { force: -force, torque: -self.other_arm.cross(force) }
    }
}
