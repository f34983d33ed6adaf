//! When a disk passed from one part of a wall to another: from a side to a corner, or back.
//!
//! The contact with the one part ends there, and that with the other begins. The normal force goes on; the tangential
//! one jumps, because the new contact has a new spring.

use super::{CornerId, Face, FacePart, Scene, Vec2};

/// That a disk came to a part of a wall, or left it, within the last step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Passed {
    /// \[s\] Time since then.
    pub since: f64,
    /// Whether the wall's normal force went on: the disk passed around a corner. Inside of a corner, the
    /// force of a face begins and ends as a whole.
    pub around: bool,
}

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
    corner: CornerId,
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
        End { corner: face.start_corner, place: face.start, away: -along, straight: face.straight_before },
        End { corner: face.end_corner, place: face.end, away: along, straight: face.straight_after },
    ]
}

impl Passing<'_> {
    /// When the disk came to a part of a face, if it did so within the last step.
    pub fn coming(&self, face: &Face, part: FacePart) -> Option<Passed> {
        match self.corner(face, part) {
            // It touches a corner while it is beyond all faces there.
            Some(faces) => faces.filter_map(|(_, end)| self.since_beyond(&end)).reduce(f64::min).map(around),
            None => self.of_side(face, Passing::since_inside).reduce(later),
        }
    }

    /// When the disk left a part of a face, if it did so within the last step.
    pub fn leaving(&self, face: &Face, part: FacePart) -> Option<Passed> {
        match self.corner(face, part) {
            Some(faces) => faces.filter_map(|(_, end)| self.since_inside(&end)).reduce(f64::max).map(around),
            None => self.of_side(face, Passing::since_beyond).reduce(earlier),
        }
    }

    /// The ends of a face at which the wall turns: when the disk passed them.
    fn of_side(&self, face: &Face, since: fn(&Self, &End) -> Option<f64>) -> impl Iterator<Item = Passed> {
        let turns = ends(face).into_iter().filter(|end| !end.straight);
        turns.filter_map(move |end| {
            let others = || self.at_corner(end.corner).filter(|(other, _)| !std::ptr::eq(*other, face));
            let beyond = |end: End| (self.centre - end.place).dot(end.away) >= 0.0;
            since(self, &end).map(|since| Passed { since, around: others().all(|(_, other)| beyond(other)) })
        })
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

fn around(since: f64) -> Passed {
    Passed { since, around: true }
}

/// The one that was later.
fn later(one: Passed, other: Passed) -> Passed {
    if other.since < one.since { other } else { one }
}

/// The one that was earlier.
fn earlier(one: Passed, other: Passed) -> Passed {
    if other.since > one.since { other } else { one }
}

#[cfg(test)]
mod tests {
    use super::super::{LawTable, WallSpec, vec2};
    use super::*;

    /// From (0, 0) straight on to (2, 0), then up.
    fn scene() -> Scene {
        let corners = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0)].map(|(x, y)| vec2(x, y));
        Scene::new(&[], &[WallSpec { material: 0, corners: corners.to_vec() }], &LawTable::new(1)).unwrap()
    }

    fn passing(scene: &Scene, centre: Vec2, velocity: Vec2) -> Passing<'_> {
        Passing { scene, centre, velocity, dt: 0.1 }
    }

    #[test]
    fn the_time_since_a_disk_passed_an_end_is_known() {
        let scene = scene();
        // 3 cm beyond the first end, at 1 m/s.
        let gone = passing(&scene, vec2(-0.03, 0.2), vec2(-1.0, 0.0));
        let first = &scene.faces[0];
        assert!((gone.leaving(first, FacePart::Left).unwrap().since - 0.03).abs() < 1e-15);
        assert!((gone.coming(first, FacePart::Start).unwrap().since - 0.03).abs() < 1e-15);
        assert_eq!(gone.coming(first, FacePart::Left), None);
        // And back.
        let back = passing(&scene, vec2(0.03, 0.2), vec2(1.0, 0.0));
        assert!((back.coming(first, FacePart::Left).unwrap().since - 0.03).abs() < 1e-15);
        assert!((back.leaving(first, FacePart::Start).unwrap().since - 0.03).abs() < 1e-15);
        // Longer ago than a step.
        let slow = passing(&scene, vec2(-0.03, 0.2), vec2(-0.2, 0.0));
        assert_eq!(slow.leaving(first, FacePart::Left), None);
    }

    #[test]
    fn a_corner_is_touched_beyond_all_its_faces() {
        let scene = scene();
        // 1 cm beyond the one and 4 cm beyond the other, of the corner at (2, 0).
        let at = passing(&scene, vec2(2.01, -0.04), vec2(1.0, -1.0));
        assert!((at.coming(&scene.faces[1], FacePart::End).unwrap().since - 0.01).abs() < 1e-15);
    }

    #[test]
    fn a_straight_wall_has_no_end_inside() {
        let scene = scene();
        let at = passing(&scene, vec2(1.03, 0.2), vec2(1.0, 0.0));
        assert_eq!(at.leaving(&scene.faces[0], FacePart::Left), None);
        assert_eq!(at.coming(&scene.faces[1], FacePart::Left), None);
    }

    #[test]
    fn only_outside_of_a_corner_the_force_goes_on() {
        let scene = scene();
        // Outside of the corner at (2, 0), right of the upward wall and below the other.
        let outside = passing(&scene, vec2(2.03, -0.2), vec2(1.0, 0.0));
        assert!(outside.leaving(&scene.faces[1], FacePart::Right).unwrap().around);
        // A corner of 170 degrees, from inside: the next face holds the disk already.
        let bend = [(0.0, 0.0), (1.0, 0.0), (1.985, 0.174)].map(|(x, y)| vec2(x, y));
        let bent =
            Scene::new(&[], &[WallSpec { material: 0, corners: bend.to_vec() }], &LawTable::new(1)).unwrap();
        let inside = passing(&bent, vec2(1.03, 0.2), vec2(1.0, 0.0));
        assert!(!inside.leaving(&bent.faces[0], FacePart::Left).unwrap().around);
        let before = passing(&bent, vec2(0.97, 0.2), vec2(1.0, 0.0));
        assert!(!before.coming(&bent.faces[1], FacePart::Left).unwrap().around);
    }
}
