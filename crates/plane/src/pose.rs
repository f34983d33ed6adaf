//! Poses and motions of rigid bodies.

use crate::Vec2;
use serde::{Deserialize, Serialize};

/// Position and orientation of a body.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Pose {
    /// \[m\] position of the centre of mass.
    pub position: Vec2,
    /// \[rad\] direction of the gaze, counter-clockwise from the x axis.
    pub orientation: f64,
}

impl Pose {
    /// Returns how far the points of a body in this pose may be from where they are in another, in m: the distance of
    /// the centres plus the angle between both poses times the distance `rim` \[m\] from the centre to the rim.
    pub fn apart(&self, other: &Pose, rim: f64) -> f64 {
        (self.position - other.position).norm() + rim * (self.orientation - other.orientation).abs()
    }
}

/// Velocity of a body.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Twist {
    /// \[m/s\] velocity of the centre of mass.
    pub velocity: Vec2,
    /// \[rad/s\] angular velocity, counter-clockwise positive.
    pub angular_velocity: f64,
}

/// Pose and twist of a body.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Motion {
    /// Position and orientation.
    pub pose: Pose,
    /// Velocity.
    pub twist: Twist,
}

impl Motion {
    /// Interpolates linearly between this motion (`share` 0) and another (`share` 1).
    pub fn towards(&self, other: &Motion, share: f64) -> Motion {
        let vector = |a: Vec2, b: Vec2| a + (b - a) * share;
        let number = |a: f64, b: f64| a + (b - a) * share;
        Motion {
            pose: Pose {
                position: vector(self.pose.position, other.pose.position),
                orientation: number(self.pose.orientation, other.pose.orientation),
            },
            twist: Twist {
                velocity: vector(self.twist.velocity, other.twist.velocity),
                angular_velocity: number(self.twist.angular_velocity, other.twist.angular_velocity),
            },
        }
    }
}
