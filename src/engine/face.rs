//! Faces of walls, and their nearest points.

use super::{CornerId, LineId, Vec2, WallId};

/// A straight segment of a wall, solid from both sides.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// The owner.
    pub wall: WallId,
    /// Index in the table of laws.
    pub material: usize,
    /// \[m\] start point.
    pub start: Vec2,
    /// \[m\] end point.
    pub end: Vec2,
    /// The corner at the start.
    pub start_corner: CornerId,
    /// The corner at the end.
    pub end_corner: CornerId,
    /// Unit normal, to the left of the direction from start to end; zero if the face has no length.
    pub normal: Vec2,
    /// Faces of one wall that continue straight belong to one line. It acts on a disk like one long face.
    pub line: LineId,
    /// Whether the wall is straight at the start of this face, to 1e-6 rad.
    pub straight_before: bool,
    /// Whether the wall is straight at the end of this face, to 1e-6 rad.
    pub straight_after: bool,
}

/// Whether a point is beyond an end of a segment: nearer to the end than to any other point of it.
///
/// Both ends and the assignment of contacts use this one predicate. So faces that meet at a corner never disagree, by
/// rounding, on which of them is nearest.
#[inline]
pub(super) fn beyond(end: Vec2, other_end: Vec2, place: Vec2) -> bool {
    (place - end).dot(other_end - end) <= 0.0
}

/// The place of a point on a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Along {
    /// At its start.
    Start,
    /// Between its ends.
    Inside,
    /// At its end.
    End,
}

/// Returns the point of a face nearest to a place, and its position on the face.
#[inline]
pub fn nearest_on_face(face: &Face, place: Vec2) -> (Vec2, Along) {
    if beyond(face.start, face.end, place) {
        (face.start, Along::Start)
    } else if beyond(face.end, face.start, place) {
        (face.end, Along::End)
    } else {
        let along = face.end - face.start;
        let share = (place - face.start).dot(along) / along.norm_squared();
        (face.start + along * share, Along::Inside)
    }
}
