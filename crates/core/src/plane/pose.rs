//! Poses and motions of rigid bodies.

use crate::plane::{Vec2, vec2};
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
    /// A pose at x, y \[m\], facing a direction \[rad\].
    pub const fn new(x: f64, y: f64, orientation: f64) -> Pose {
        Pose { position: vec2(x, y), orientation }
    }

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

/// The orientation \[rad\] that the disks of a body define, given the centres of the first and of the last: the normal
/// to the line between them (paper, fig. 6c). Zero if the two coincide.
pub fn shown_orientation(first: Vec2, last: Vec2) -> f64 {
    let line = last - first;
    if line == Vec2::zeros() { 0.0 } else { libm::atan2(line.x, -line.y) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaze_is_normal_to_the_shoulders() {
        // Left shoulder at +y, right shoulder at −y: gaze along +x.
        assert_eq!(shown_orientation(vec2(0.0, 0.2), vec2(0.0, -0.2)), 0.0);
        // Left at −x, right at +x: gaze along +y.
        let quarter = shown_orientation(vec2(-0.2, 0.0), vec2(0.2, 0.0));
        assert!((quarter - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert_eq!(shown_orientation(vec2(0.1, 0.1), vec2(0.1, 0.1)), 0.0);
    }
}
