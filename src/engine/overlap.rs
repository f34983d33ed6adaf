//! How deep two things overlap, where, and along which normal.

use super::{Face, FacePart, Scene, Vec2};

/// An overlap, seen from the body that receives the force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// \[m\] h > 0.
    pub depth: f64,
    /// Unit vector from the other's centre (or nearest point) to the receiver's centre.
    pub normal: Vec2,
}

impl Overlap {
    /// \[m\] from the receiving disk's centre to the contact point, half-way into the overlap.
    #[inline]
    pub fn contact_point(&self, radius: f64) -> Vec2 {
        self.normal * (0.5 * self.depth - radius)
    }
}

/// What two things at a distance do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Meeting {
    /// No overlap.
    Apart,
    /// Overlapping with a well-defined normal.
    Touching(Overlap),
    /// Centres on top of each other: no normal, so no force; counted.
    Coincident,
}

/// A disk and another (a point where `reach` is the disk's radius alone) whose centre is `between` away.
///
/// `between` \[m\] from the other's centre to the receiver's; `reach` \[m\] the sum of the radii.
#[inline]
pub fn meet(between: Vec2, reach: f64) -> Meeting {
    let squared = between.norm_squared();
    if squared >= reach * reach {
        return Meeting::Apart;
    }
    let distance = squared.sqrt();
    if distance == 0.0 {
        return Meeting::Coincident;
    }
    let depth = reach - distance;
    if depth > 0.0 {
        Meeting::Touching(Overlap { depth, normal: unit(between, distance) })
    } else {
        Meeting::Apart
    }
}

/// The unit vector along `between`, whose length is `distance` > 0.
#[inline]
pub fn unit(between: Vec2, distance: f64) -> Vec2 {
    between * (1.0 / distance)
}

/// The point of a face nearest to a place, and the part of the face it lies on.
#[inline]
pub fn nearest_on_face(face: &Face, place: Vec2) -> (Vec2, FacePart) {
    let along = face.end - face.start;
    let share = (place - face.start).dot(along);
    let length_squared = along.norm_squared();
    if share <= 0.0 {
        (face.start, FacePart::Start)
    } else if share >= length_squared {
        (face.end, FacePart::End)
    } else {
        (face.start + along * (share / length_squared), FacePart::Inside)
    }
}

/// Whether the contact of a place with a part of a face is this face's to book.
///
/// A corner touches only when it is the nearest point of every face that meets there, and then once,
/// on the lowest-numbered of them: a straight wall drawn in two pieces acts like one.
pub fn books_contact(scene: &Scene, face: usize, part: FacePart, place: Vec2) -> bool {
    let at = match part {
        FacePart::Inside => return true,
        FacePart::Start => scene.faces[face].start_corner,
        FacePart::End => scene.faces[face].end_corner,
    };
    let corner = &scene.corners[at.index()];
    corner.faces[0].index() == face
        && corner.faces.iter().all(|other| {
            let other = &scene.faces[other.index()];
            let away = if other.start_corner == at { other.end } else { other.start };
            (place - corner.position).dot(away - corner.position) <= 0.0
        })
}

#[cfg(test)]
mod tests {
    use super::super::{LawTable, WallSpec, vec2};
    use super::*;

    fn wall(corners: &[Vec2]) -> Scene {
        Scene::new(&[], &[WallSpec { material: 0, corners: corners.to_vec() }], &LawTable::new(1)).unwrap()
    }

    fn booked(scene: &Scene, place: Vec2) -> Vec<(usize, FacePart)> {
        (0..scene.faces.len())
            .map(|face| (face, nearest_on_face(&scene.faces[face], place).1))
            .filter(|&(face, part)| books_contact(scene, face, part, place))
            .collect()
    }

    #[test]
    fn contact_point_is_shared() {
        let (a, b, ra, rb) = (vec2(0.1, 0.2), vec2(0.25, 0.3), 0.15, 0.1);
        let Meeting::Touching(seen_by_a) = meet(a - b, ra + rb) else { panic!() };
        let Meeting::Touching(seen_by_b) = meet(b - a, ra + rb) else { panic!() };
        let gap = (a + seen_by_a.contact_point(ra)) - (b + seen_by_b.contact_point(rb));
        assert!(gap.norm() < 1e-16);
        assert_eq!(seen_by_a.normal, -seen_by_b.normal);
    }

    #[test]
    fn straight_wall_in_two_pieces_is_one() {
        let scene = wall(&[vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(2.0, 0.0)]);
        assert_eq!(booked(&scene, vec2(0.5, 0.1)), [(0, FacePart::Inside)]);
        assert_eq!(booked(&scene, vec2(1.0, 0.1)), [(0, FacePart::End)]);
        assert_eq!(booked(&scene, vec2(1.5, 0.1)), [(1, FacePart::Inside)]);
        assert_eq!(booked(&scene, vec2(-0.1, 0.1)), [(0, FacePart::Start)]);
    }

    #[test]
    fn corners_push_once_outside_and_twice_inside() {
        let scene = wall(&[vec2(-1.0, 0.0), vec2(0.0, 0.0), vec2(0.0, -1.0)]);
        // Outside the right angle only the corner is near.
        assert_eq!(booked(&scene, vec2(0.1, 0.1)), [(0, FacePart::End)]);
        // Inside it, both faces are.
        assert_eq!(booked(&scene, vec2(-0.1, -0.1)), [(0, FacePart::Inside), (1, FacePart::Inside)]);
        // Beside one face only that face is, though the corner is the other's nearest point.
        assert_eq!(booked(&scene, vec2(-0.1, 0.1)), [(0, FacePart::Inside)]);
    }

    #[test]
    fn a_corner_of_a_closed_wall_is_booked_on_its_lowest_face() {
        let scene = wall(&[vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(1.0, 1.0), vec2(0.0, 1.0), vec2(0.0, 0.0)]);
        assert_eq!(booked(&scene, vec2(-0.1, -0.1)), [(0, FacePart::Start)]);
    }
}
