//! Pose and motion of a body, for contacts.

use super::{InPlane, Pose, Rotation, Twist, Vec2, rotation};
use lemons_core::plane::{SMALL_TURN, turned_by};

/// Pose and motion of a body at one instant: everything that an evaluation of its contacts needs, in one cache line.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))]
pub(super) struct BodyKinematics {
    /// \[m\] Centre of mass.
    pub position: Vec2,
    /// \[rad\] Orientation.
    orientation: f64,
    /// Rotation by the orientation.
    turn: Rotation,
    /// Twist at the same instant.
    pub twist: Twist,
}

impl Default for BodyKinematics {
    fn default() -> BodyKinematics {
        BodyKinematics::at(Pose::default(), Twist::default())
    }
}

impl BodyKinematics {
    /// Makes it from a pose and a twist.
    pub fn at(pose: Pose, twist: Twist) -> BodyKinematics {
        let Pose { position, orientation } = pose;
        BodyKinematics { position, orientation, turn: rotation(orientation), twist }
    }

    #[inline]
    pub fn pose(&self) -> Pose {
        Pose { position: self.position, orientation: self.orientation }
    }

    /// Moves to a pose, turned by an angle \[rad\] since the last one.
    ///
    /// Updating sine and cosine is cheaper than computing them. Rounding errors add up during a communication step
    /// (1e-14 after 10 000 steps); at its ends they are computed again.
    #[inline(always)]
    pub fn follow(&mut self, pose: Pose, turned: f64, twist: Twist) {
        if turned.abs() > SMALL_TURN {
            self.turn_to(pose.orientation);
        } else {
            self.turn = turned_by(self.turn, turned);
        }
        (self.position, self.orientation, self.twist) = (pose.position, pose.orientation, twist);
    }

    /// Returns the rotation by the orientation.
    #[inline]
    pub fn turn(&self) -> Rotation {
        self.turn
    }

    #[cold]
    #[inline(never)]
    fn turn_to(&mut self, orientation: f64) {
        self.turn = rotation(orientation);
    }

    /// Returns the vector \[m\] from the centre of mass to the centre of a disk, from its [`super::ContactDisk::offset`].
    #[inline]
    pub fn arm(&self, offset: Vec2) -> Vec2 {
        self.turn * offset
    }

    /// Returns the centre \[m\] of a disk, from its [`super::ContactDisk::offset`].
    #[inline]
    pub fn centre(&self, offset: Vec2) -> Vec2 {
        self.position + self.arm(offset)
    }

    /// Returns the velocity \[m/s\] of the body's point at a vector from its centre of mass.
    #[inline]
    pub fn velocity_at(&self, arm: Vec2) -> Vec2 {
        velocity_at(&self.twist, arm)
    }
}

/// Returns the velocity \[m/s\] of a body's point at a vector from its centre of mass.
#[inline]
pub(super) fn velocity_at(twist: &Twist, arm: Vec2) -> Vec2 {
    twist.velocity + arm.left() * twist.angular_velocity
}
