//! Faces of walls, and their nearest points.

use super::{CornerId, FacePart, InPlane, LineId, Vec2, WallId};

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
    /// Faces that continue each other belong to one line: where they meet they turn by at most 20°, or one lies on the
    /// other.
    pub line: LineId,
    /// How the line goes on at the start of this face.
    pub before: Continuation,
    /// How the line goes on at the end of this face.
    pub after: Continuation,
}

/// How a line goes on at an end of a face.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Continuation {
    /// It ends here.
    None,
    /// It turns by at most 20°.
    Bend,
    /// It is straight, to 1e-6 rad.
    Straight,
}

impl Face {
    /// Returns how the line goes on at a corner of the face.
    pub(super) fn continuation(&self, at: CornerId) -> Continuation {
        if self.start_corner == at { self.before } else { self.after }
    }

    pub(super) fn continuation_mut(&mut self, at: CornerId) -> &mut Continuation {
        if self.start_corner == at { &mut self.before } else { &mut self.after }
    }

    /// Whether a part is a corner at which the line goes on.
    pub(super) fn goes_on(&self, part: FacePart) -> bool {
        match part {
            FacePart::Left | FacePart::Right => false,
            FacePart::Start => self.before != Continuation::None,
            FacePart::End => self.after != Continuation::None,
        }
    }

    /// Returns the unit vector along the face and away from one of its corners; none if it has no length.
    pub(super) fn away_from(&self, at: CornerId) -> Option<Vec2> {
        let along = -self.normal.left();
        let away = if self.start_corner == at { along } else { -along };
        (self.normal != Vec2::zeros()).then_some(away)
    }
}

/// Whether a point is beyond an end of a segment: nearer to the end than to any other point of it.
///
/// Both ends and the assignment of contacts use this one predicate. So faces that meet at a corner never disagree, by
/// rounding, on which of them is nearest.
#[inline]
pub(super) fn beyond(end: Vec2, other_end: Vec2, place: Vec2) -> bool {
    (place - end).dot(&(other_end - end)) <= 0.0
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
        let share = (place - face.start).dot(&along) / along.norm_squared();
        (face.start + along * share, Along::Inside)
    }
}
