//! When a disk passed from one part of a wall to another: from a side to a corner, or back.
//!
//! The contact with the one part ends there, and that with the other begins. The normal force goes on; the tangential
//! one jumps, because the new contact has a new spring.

use super::{Face, FacePart, Scene, Vec2};

/// The centre of a disk.
#[derive(Clone, Copy)]
pub(super) struct Passing<'a> {
    pub scene: &'a Scene,
    /// \[m\]
    pub centre: Vec2,
    /// \[m/s\]
    pub velocity: Vec2,
    /// \[s\] the mechanical step.
    pub dt: f64,
}

/// An end of a face.
struct End {
    /// \[m\]
    place: Vec2,
    /// \[m\] Along the face and away from it.
    away: Vec2,
    /// Whether the wall continues straight.
    straight: bool,
}

fn ends(face: &Face) -> [End; 2] {
    let along = face.end - face.start;
    [
        End { place: face.start, away: -along, straight: face.straight_before },
        End { place: face.end, away: along, straight: face.straight_after },
    ]
}

impl Passing<'_> {
    /// \[s\] Time since the disk came to a part of a face, if it did so within the last step.
    pub fn since_coming(&self, face: &Face, part: FacePart) -> Option<f64> {
        match self.corner(face, part) {
            // It touches a corner while it is beyond all faces there.
            Some(faces) => faces.filter_map(|end| self.since_beyond(&end)).reduce(f64::min),
            None => turns(face).filter_map(|end| self.since_inside(&end)).reduce(f64::min),
        }
    }

    /// \[s\] Time since the disk left a part of a face, if it did so within the last step.
    pub fn since_leaving(&self, face: &Face, part: FacePart) -> Option<f64> {
        match self.corner(face, part) {
            Some(faces) => faces.filter_map(|end| self.since_inside(&end)).reduce(f64::max),
            None => turns(face).filter_map(|end| self.since_beyond(&end)).reduce(f64::max),
        }
    }

    /// The ends of all faces that meet at a corner; none if the part is a side.
    fn corner(&self, face: &Face, part: FacePart) -> Option<impl Iterator<Item = End>> {
        let at = match part {
            FacePart::Left | FacePart::Right => return None,
            FacePart::Start => face.start_corner,
            FacePart::End => face.end_corner,
        };
        let faces = self.scene.corners[at.index()].faces.iter();
        Some(faces.map(move |face| {
            let face = &self.scene.faces[face.index()];
            let [start, end] = ends(face);
            if face.start_corner == at { start } else { end }
        }))
    }

    fn since_beyond(&self, end: &End) -> Option<f64> {
        self.since((self.centre - end.place).dot(end.away), self.velocity.dot(end.away))
    }

    fn since_inside(&self, end: &End) -> Option<f64> {
        self.since(-(self.centre - end.place).dot(end.away), -self.velocity.dot(end.away))
    }

    /// Time since something that grows was zero.
    fn since(&self, now: f64, rate: f64) -> Option<f64> {
        (now >= 0.0 && rate * self.dt > now).then(|| now / rate)
    }
}

/// The ends of a face at which the wall does not continue straight.
fn turns(face: &Face) -> impl Iterator<Item = End> {
    ends(face).into_iter().filter(|end| !end.straight)
}
