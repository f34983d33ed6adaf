//! State: everything that changes in time.

use super::{DiskId, FaceId, Pose, Twist, Vec2};
use serde::{Deserialize, Serialize};

/// A force at the centre of mass and a torque about it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Wrench {
    /// \[N\] force.
    pub force: Vec2,
    /// \[N.m\] torque.
    pub torque: f64,
}

/// The part of a face that a disk touches.
///
/// A corner at which the wall goes on straight does not count as a corner: it belongs to the sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum FacePart {
    /// The left side, seen in the direction from the first to the last corner.
    Left,
    /// The right side.
    Right,
    /// Its first corner.
    Start,
    /// Its last corner.
    End,
}

/// The spring of a contact between two disks.
///
/// The elongation is one signed number along the tangent (the normal turned by a quarter
/// counter-clockwise). In two dimensions the tangent has one direction. The spring therefore turns with the contact at
/// no cost, keeps its length, and has the same value for both disks.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DiskSpring {
    /// The disk that receives the force; of the lower-numbered body.
    pub first: DiskId,
    /// The other disk.
    pub second: DiskId,
    /// \[m\] elongation along the tangent.
    pub elongation: f64,
}

/// The spring of a contact between a disk and a face.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FaceSpring {
    /// The disk that receives the force.
    pub disk: DiskId,
    /// The face.
    pub face: FaceId,
    /// The part of the face. Another part is another contact; but parts of faces that are one line
    /// ([`super::Face::line`]) are parts of one contact.
    pub part: FacePart,
    /// \[m\] elongation along the tangent.
    pub elongation: f64,
}

/// Poses, twists and springs. Together with the drive they determine the future.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct State {
    /// One for each body.
    pub poses: Vec<Pose>,
    /// One for each body.
    pub twists: Vec<Twist>,
    /// One for each touching pair, ascending.
    pub disk_springs: Vec<DiskSpring>,
    /// One for each touching pair, ascending.
    pub face_springs: Vec<FaceSpring>,
    /// Number of mechanical steps so far.
    pub steps: u64,
}

impl State {
    /// A state of bodies at given poses, without stretched springs.
    pub fn new(poses: Vec<Pose>, twists: Vec<Twist>) -> State {
        State { poses, twists, ..State::default() }
    }
}
