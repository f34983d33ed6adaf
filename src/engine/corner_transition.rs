//! When a disk passed from one part of a wall to another: from a side to a corner, or back.
//!
//! The contact with the one part ends there, and that with the other begins. The normal force goes on; the tangential
//! one jumps, because the new contact has a new spring.

use super::face::Continuation;
use super::{CornerId, Face, FacePart, Scene, Vec2};

/// The centre of a disk.
#[derive(Clone, Copy)]
pub(super) struct CornerTransition<'a> {
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
    corner: CornerId,
    /// \[m\]
    place: Vec2,
    /// \[m\] Along the face and away from it.
    away: Vec2,
    /// Whether the line goes on.
    goes_on: bool,
}

fn ends(face: &Face) -> [End; 2] {
    let along = face.end - face.start;
    let goes_on = |continuation| continuation != Continuation::None;
    [
        End { corner: face.start_corner, place: face.start, away: -along, goes_on: goes_on(face.before) },
        End { corner: face.end_corner, place: face.end, away: along, goes_on: goes_on(face.after) },
    ]
}

impl CornerTransition<'_> {
    /// Returns the time \[s\] since the disk came to a part of a face, if it did so within the last step.
    pub fn coming(&self, face: &Face, part: FacePart) -> Option<f64> {
        match self.corner(face, part) {
            // It touches a corner while it is beyond all faces there.
            Some(faces) => faces.filter_map(|(_, end)| self.since_beyond(&end)).reduce(f64::min),
            None => turns(face).filter_map(|end| self.since_inside(&end)).reduce(f64::min),
        }
    }

    /// Returns the time \[s\] since the disk left a part of a face, if it did so within the last step.
    pub fn leaving(&self, face: &Face, part: FacePart) -> Option<f64> {
        match self.corner(face, part) {
            Some(faces) => faces.filter_map(|(_, end)| self.since_inside(&end)).reduce(f64::max),
            None => turns(face).filter_map(|end| self.since_beyond(&end)).reduce(f64::max),
        }
    }

    /// The ends of all faces that meet at a corner; none if the part is a side.
    fn corner(&self, face: &Face, part: FacePart) -> Option<impl Iterator<Item = (&Face, End)>> {
        match part {
            FacePart::Left | FacePart::Right => None,
            FacePart::Start => Some(self.at_corner(face.start_corner)),
            FacePart::End => Some(self.at_corner(face.end_corner)),
        }
    }

    fn at_corner(&self, corner: CornerId) -> impl Iterator<Item = (&Face, End)> {
        self.scene.corners[corner.index()].faces.iter().map(move |face| {
            let face = &self.scene.faces[face.index()];
            let [start, end] = ends(face);
            (face, if start.corner == corner { start } else { end })
        })
    }

    fn since_beyond(&self, end: &End) -> Option<f64> {
        self.since((self.centre - end.place).dot(&end.away), self.velocity.dot(&end.away))
    }

    fn since_inside(&self, end: &End) -> Option<f64> {
        self.since(-(self.centre - end.place).dot(&end.away), -self.velocity.dot(&end.away))
    }

    /// Time since something that grows was zero.
    fn since(&self, now: f64, rate: f64) -> Option<f64> {
        (now >= 0.0 && rate * self.dt > now).then(|| now / rate)
    }
}

/// The ends of a face at which its line ends.
fn turns(face: &Face) -> impl Iterator<Item = End> {
    ends(face).into_iter().filter(|end| !end.goes_on)
}

#[cfg(test)]
mod tests {
    use super::super::{LawTable, WallSpec, vec2};
    use super::*;

    /// From (0, 0) straight on to (2, 0), then up.
    fn scene() -> Scene {
        let corners = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0)].map(|(x, y)| vec2(x, y));
        Scene::new(&[], &[WallSpec { material: 0, corners: corners.to_vec() }], LawTable::new(1))
    }

    fn transition(scene: &Scene, centre: Vec2, velocity: Vec2) -> CornerTransition<'_> {
        CornerTransition { scene, centre, velocity, dt: 0.1 }
    }

    #[test]
    fn the_time_since_a_disk_passed_an_end_is_known() {
        let scene = scene();
        // 3 cm beyond the first end, at 1 m/s.
        let gone = transition(&scene, vec2(-0.03, 0.2), vec2(-1.0, 0.0));
        let first = &scene.faces[0];
        assert!((gone.leaving(first, FacePart::Left).unwrap() - 0.03).abs() < 1e-15);
        assert!((gone.coming(first, FacePart::Start).unwrap() - 0.03).abs() < 1e-15);
        assert_eq!(gone.coming(first, FacePart::Left), None);
        // And back.
        let back = transition(&scene, vec2(0.03, 0.2), vec2(1.0, 0.0));
        assert!((back.coming(first, FacePart::Left).unwrap() - 0.03).abs() < 1e-15);
        assert!((back.leaving(first, FacePart::Start).unwrap() - 0.03).abs() < 1e-15);
        // Longer ago than a step.
        let slow = transition(&scene, vec2(-0.03, 0.2), vec2(-0.2, 0.0));
        assert_eq!(slow.leaving(first, FacePart::Left), None);
    }

    #[test]
    fn a_corner_is_touched_beyond_all_its_faces() {
        let scene = scene();
        // 1 cm beyond the one and 4 cm beyond the other, of the corner at (2, 0).
        let at = transition(&scene, vec2(2.01, -0.04), vec2(1.0, -1.0));
        assert!((at.coming(&scene.faces[1], FacePart::End).unwrap() - 0.01).abs() < 1e-15);
    }

    #[test]
    fn a_straight_wall_has_no_end_inside() {
        let scene = scene();
        let at = transition(&scene, vec2(1.03, 0.2), vec2(1.0, 0.0));
        assert_eq!(at.leaving(&scene.faces[0], FacePart::Left), None);
        assert_eq!(at.coming(&scene.faces[1], FacePart::Left), None);
    }
}
