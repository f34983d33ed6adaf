//! What presses a body together: opposing forces, not their sum.
//!
//! The mean stress of a body times its area is −Σ r ⊗ F over its contacts (the virial theorem; its symmetric part, as
//! contacts also exert torques). Over the extent of the body along an axis it is a force: that of two walls which press
//! it between them. A force that nothing opposes counts half: such a body is accelerated, and its far side is free.

use super::exposure::mean_of_both;
use super::overlap::Overlap;
use super::report::ContactReport;
use super::{DiskId, InPlane, Pair, Rotation, Scene, State, Vec2, rotation};
use serde::{Deserialize, Serialize};

/// Moments −Σ r ⊗ F of forces at arms r from the centre of mass \[N.m\], or of impulses \[N.m.s\].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ForceMoments {
    /// Along the gaze.
    pub front: f64,
    /// Across it.
    pub side: f64,
    /// Their symmetric product.
    pub shear: f64,
}

impl ForceMoments {
    /// Returns those of a force at an arm, on a body that is turned.
    #[inline]
    pub fn of(turn: Rotation, arm: Vec2, force: Vec2) -> ForceMoments {
        let gaze = turn * Vec2::new(1.0, 0.0);
        let left = gaze.left();
        let (ahead, aside) = (arm.dot(&gaze), arm.dot(&left));
        let (along, across) = (force.dot(&gaze), force.dot(&left));
        ForceMoments {
            front: -ahead * along,
            side: -aside * across,
            shear: -0.5 * (ahead * across + aside * along),
        }
    }

    /// Adds others, multiplied by a number.
    #[inline]
    pub fn add(&mut self, other: &ForceMoments, by: f64) {
        self.front += other.front * by;
        self.side += other.side * by;
        self.shear += other.shear * by;
    }

    /// Returns the forces that press together something of an extent \[m\] along the gaze, and across it.
    pub fn compression(&self, extent: Vec2) -> Compression {
        Compression {
            front: self.front / extent.x,
            side: self.side / extent.y,
            shear: self.shear / (extent.x.sqrt() * extent.y.sqrt()),
        }
    }
}

/// Forces that press something together, positive; negative where they pull it apart.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Compression {
    /// \[N\] Front–back: along the gaze.
    pub front: f64,
    /// \[N\] Side–side: across it.
    pub side: f64,
    /// \[N\] Their mixed part.
    pub shear: f64,
}

impl Compression {
    /// \[N\] Returns the principal parts, the smaller one first.
    pub fn principal(&self) -> [f64; 2] {
        let (middle, half) = (0.5 * (self.front + self.side), 0.5 * (self.front - self.side));
        let radius = libm::hypot(half, self.shear);
        [middle - radius, middle + radius]
    }

    /// Returns it over a time of two parts.
    pub(super) fn and(&self, before: f64, after: &Compression, duration: f64) -> Compression {
        let mean = |one, other| mean_of_both([one, other], [before, duration]);
        Compression {
            front: mean(self.front, after.front),
            side: mean(self.side, after.side),
            shear: mean(self.shear, after.shear),
        }
    }

    /// Returns whether all of it are numbers.
    pub fn is_finite(&self) -> bool {
        self.front.is_finite() && self.side.is_finite() && self.shear.is_finite()
    }
}

/// Returns what presses each body together, by the contacts in a state.
pub(super) fn compressions(scene: &Scene, state: &State, contacts: &ContactReport) -> Vec<Compression> {
    let mut moments = vec![ForceMoments::default(); scene.bodies.len()];
    for contact in &contacts.contacts {
        let force = contact.normal * contact.normal_force + contact.normal.left() * contact.tangential_force;
        let mut add = |disk: DiskId, normal: Vec2, force: Vec2| {
            let of = &scene.disks[disk.index()];
            let turn = rotation(state.poses[of.body.index()].orientation);
            let arm = turn * of.offset + Overlap { depth: contact.depth, normal }.contact_point(of.radius);
            moments[of.body.index()].add(&ForceMoments::of(turn, arm, force), 1.0);
        };
        match contact.pair {
            Pair::Disks { first, second } => {
                add(first, contact.normal, force);
                add(second, -contact.normal, -force);
            }
            Pair::Face { disk, .. } => add(disk, contact.normal, force),
        }
    }
    let over = |(moments, body): (&ForceMoments, &super::Body)| moments.compression(body.extent);
    moments.iter().zip(&scene.bodies).map(over).collect()
}
