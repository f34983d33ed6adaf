//! Two things that touch: where, and how they move relative to each other.

use super::body_kinematics::BodyKinematics;
use super::circle::Circle;
use super::contact_law::Reaction;
use super::near_pairs::{DiskPair, DiskPairDetail, FacePair, Separation};
use super::overlap::Overlap;
use super::{FacePart, InPlane, PairLaw, Scene, Vec2, Wrench};

/// The instant at which contacts are evaluated.
pub(super) struct Instant<'a> {
    pub scene: &'a Scene,
    /// One for each body.
    pub kinematics: &'a [BodyKinematics],
    /// The number of the previous evaluation.
    pub before: u32,
}

/// Two touching things, before the law is applied.
#[derive(Clone, Copy)]
pub(super) struct ContactGeometry<'a> {
    pub law: &'a PairLaw,
    /// Index of the law in the table.
    pub law_at: u32,
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
pub(super) struct ContactForce {
    pub overlap: Overlap,
    pub part: FacePart,
    /// \[m\] from the receiver's centre of mass to the contact point.
    pub arm: Vec2,
    /// \[m\] from the other's centre of mass to the contact point.
    pub other_arm: Vec2,
    pub normal_speed: f64,
    pub slip_speed: f64,
    pub reaction: Reaction,
}

impl Instant<'_> {
    /// Two disks with an overlap, which is negative where they do not touch.
    #[inline(always)]
    pub fn disk_geometry(
        &self,
        pair: &DiskPair,
        detail: &DiskPairDetail,
        separation: &Separation,
        overlap: Overlap,
    ) -> ContactGeometry<'_> {
        let (i, j) = (&self.kinematics[pair.first_body.index()], &self.kinematics[pair.second_body.index()]);
        let arm = separation.arm + overlap.contact_point(detail.first_radius);
        let other_arm = separation.other_arm - overlap.contact_point(detail.second_radius);
        let velocity = i.velocity_at(arm) - j.velocity_at(other_arm);
        let (law, law_at) = (self.scene.law_at(detail.law), detail.law);
        ContactGeometry { law, law_at, overlap, part: FacePart::Left, arm, other_arm, velocity }
    }

    /// The circle of a disk that may touch a face.
    #[inline(always)]
    pub fn circle(&self, pair: &FacePair) -> Circle {
        let disk = &self.scene.disks[pair.disk.index()];
        let centre = self.kinematics[disk.body.index()].centre(disk.offset);
        Circle { centre, radius: disk.radius }
    }

    /// A disk and a part of a face with an overlap, which is negative where they do not touch.
    #[inline(always)]
    pub fn face_geometry(&self, pair: &FacePair, overlap: Overlap, part: FacePart) -> ContactGeometry<'_> {
        let (disk, wall) = (&self.scene.disks[pair.disk.index()], &self.scene.faces[pair.face.index()]);
        let kinematics = &self.kinematics[disk.body.index()];
        let arm = kinematics.arm(disk.offset) + overlap.contact_point(disk.radius);
        let law_at = self.scene.law_between(disk.material, wall.material);
        let law = self.scene.law_at(law_at);
        let velocity = kinematics.velocity_at(arm);
        ContactGeometry { law, law_at, overlap, part, arm, other_arm: Vec2::zeros(), velocity }
    }
}

impl ContactGeometry<'_> {
    /// \[m/s\] along the normal, positive if they separate, and along the tangent.
    #[inline(always)]
    pub fn speeds(&self) -> (f64, f64) {
        (self.velocity.dot(&self.overlap.normal), self.velocity.dot(&self.overlap.normal.left()))
    }

    #[inline(always)]
    pub fn with(&self, reaction: Reaction) -> ContactForce {
        let (normal_speed, slip_speed) = self.speeds();
        let ContactGeometry { overlap, part, arm, other_arm, .. } = *self;
        ContactForce { overlap, part, arm, other_arm, normal_speed, slip_speed, reaction }
    }
}

impl ContactForce {
    /// Takes a share of the forces.
    #[inline(always)]
    pub fn scale(&mut self, share: f64) {
        self.reaction.normal *= share;
        self.reaction.tangential *= share;
    }

    /// \[N\] on the receiver.
    #[inline]
    pub fn vector(&self) -> Vec2 {
        let normal = self.overlap.normal;
        normal * self.reaction.normal + normal.left() * self.reaction.tangential
    }

    /// The wrench on the receiver, of the force on it.
    #[inline(always)]
    pub fn on_receiver(&self, force: Vec2) -> Wrench {
        Wrench { force, torque: self.arm.perp(&force) }
    }

    /// The wrench on the other body, of the force on the receiver.
    #[inline(always)]
    pub fn on_giver(&self, force: Vec2) -> Wrench {
        Wrench { force: -force, torque: -self.other_arm.perp(&force) }
    }
}
