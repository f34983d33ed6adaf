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

/// Whether a place lies beyond an end of a straight piece: nearer to the end than to any other point of it.
///
/// The one predicate for both ends and for booking, so that faces that meet at a corner never disagree
/// by rounding about who is nearest.
#[inline]
fn beyond(end: Vec2, other_end: Vec2, place: Vec2) -> bool {
    (place - end).dot(other_end - end) <= 0.0
}

/// The point of a face nearest to a place, and the part of the face it lies on.
#[inline]
pub fn nearest_on_face(face: &Face, place: Vec2) -> (Vec2, FacePart) {
    if beyond(face.start, face.end, place) {
        (face.start, FacePart::Start)
    } else if beyond(face.end, face.start, place) {
        (face.end, FacePart::End)
    } else {
        let along = face.end - face.start;
        let share = (place - face.start).dot(along) / along.norm_squared();
        (face.start + along * share, FacePart::Inside)
    }
}

/// \[m\] Nearest points of two faces that both lie this near to their common corner are one point.
const SAME_POINT: f64 = 1e-9;

/// Whether the contact of a place with a part of a face is this face's to book.
///
/// A corner touches only when it is the nearest point of every face that meets there, and then once,
/// on the lowest-numbered of them. At the seam of a straight wall drawn in two pieces rounding may put
/// the nearest points of both just inside: that is one contact too, of the lower-numbered face.
pub fn books_contact(scene: &Scene, face: usize, nearest: Vec2, part: FacePart, place: Vec2) -> bool {
    let own = &scene.faces[face];
    let at = match part {
        FacePart::Start => own.start_corner,
        FacePart::End => own.end_corner,
        FacePart::Inside => {
            return ![own.start_corner, own.end_corner].into_iter().any(|at| {
                let corner = &scene.corners[at.index()];
                (nearest - corner.position).norm_squared() < SAME_POINT * SAME_POINT
                    && corner.faces.iter().take_while(|lower| lower.index() < face).any(|lower| {
                        let (point, part) = nearest_on_face(&scene.faces[lower.index()], place);
                        let near = (point - corner.position).norm_squared() < SAME_POINT * SAME_POINT;
                        part == FacePart::Inside && near
                    })
            });
        }
    };
    let corner = &scene.corners[at.index()];
    corner.faces[0].index() == face
        && corner.faces.iter().all(|other| {
            let other = &scene.faces[other.index()];
            if other.start_corner == at {
                beyond(other.start, other.end, place)
            } else {
                beyond(other.end, other.start, place)
            }
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
            .map(|face| (face, nearest_on_face(&scene.faces[face], place)))
            .filter(|&(face, (nearest, part))| books_contact(scene, face, nearest, part, place))
            .map(|(face, (_, part))| (face, part))
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
    fn a_seam_is_booked_once_whatever_the_rounding() {
        let straight = wall(&[vec2(-10.0, 0.0), vec2(0.0, 0.0), vec2(10.0, 0.0)]);
        for x in [-1e-16, -6e-17, -1e-17, -0.0, 0.0, 1e-17, 1e-16] {
            assert_eq!(booked(&straight, vec2(x, 0.19)).len(), 1, "{x}");
        }
        // Slanted walls of any length, the place on the normal at the seam but for rounding.
        for k in 0..5000 {
            let angle = 0.37 * f64::from(k);
            let along = vec2(libm::cos(angle), libm::sin(angle));
            let seam = vec2(libm::sin(1.7 * f64::from(k)) * 9.0, libm::cos(2.3 * f64::from(k)) * 9.0);
            let (before, after) = (0.1 + 0.003 * f64::from(k % 977), 0.1 + 0.002 * f64::from(k % 613));
            let slanted = wall(&[seam - along * before, seam, seam + along * after]);
            for shift in [-1e-15, -1e-16, 0.0, 1e-16, 1e-15] {
                let place = seam + along.perp() * 0.19 + along * shift;
                assert_eq!(booked(&slanted, place).len(), 1, "wall {k}, shift {shift}");
            }
        }
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
