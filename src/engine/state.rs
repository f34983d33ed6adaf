//! What changes while time runs.

use super::{DiskId, FaceId, Vec2};
use serde::{Deserialize, Serialize};

/// Where a body stands.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Pose {
    /// \[m\] centre of mass.
    pub position: Vec2,
    /// \[rad\] direction of the gaze, counter-clockwise from the x axis.
    pub orientation: f64,
}

/// How a body moves.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Twist {
    /// \[m/s\] of the centre of mass.
    pub velocity: Vec2,
    /// \[rad/s\]
    pub angular_velocity: f64,
}

/// A force at the centre of mass and a torque about it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Wrench {
    /// \[N\]
    pub force: Vec2,
    /// \[N.m\]
    pub torque: f64,
}

/// The part of a face that a disk touches.
///
/// A corner at which the wall goes on straight is no corner to a disk: it belongs to the sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum FacePart {
    /// The side on the left of the way from its first to its last corner.
    Left,
    /// The side on the right.
    Right,
    /// Its first corner.
    Start,
    /// Its last corner.
    End,
}

/// The spring of a contact between two disks.
///
/// The elongation is one signed number along the tangent (the normal turned by a quarter
/// counter-clockwise): in the plane the tangent has one direction, so the spring turns with the
/// contact at no cost, its length preserved, and has the same value seen from either disk.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DiskSpring {
    /// The disk that receives the force; of the lower-numbered body.
    pub first: DiskId,
    /// The other disk.
    pub second: DiskId,
    /// \[m\] along the tangent.
    pub elongation: f64,
}

/// The spring of a contact between a disk and a face.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FaceSpring {
    /// The disk that receives the force.
    pub disk: DiskId,
    /// The face.
    pub face: FaceId,
    /// Which part of the face. Another part is another contact, but a side of faces that go on straight
    /// ([`super::Face::line`]) is one.
    pub part: FacePart,
    /// \[m\] along the tangent.
    pub elongation: f64,
}

/// Poses, twists and springs: with the drive, all that the future depends on.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct State {
    /// One for each body.
    pub poses: Vec<Pose>,
    /// One for each body.
    pub twists: Vec<Twist>,
    /// Of the touching pairs, ascending.
    pub disk_springs: Vec<DiskSpring>,
    /// Of the touching pairs, ascending.
    pub face_springs: Vec<FaceSpring>,
    /// Mechanical steps made so far.
    pub steps: u64,
}

impl State {
    /// Bodies at their poses, no spring stretched.
    pub fn new(poses: Vec<Pose>, twists: Vec<Twist>) -> State {
        State { poses, twists, ..State::default() }
    }
}
