//! Overlaps: depth, place and normal.

use super::face::{Along, beyond, nearest_on_face};
use super::{Face, FacePart, Scene, Vec2};

/// An overlap, seen from the body that receives the force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// \[m\] depth h > 0.
    pub depth: f64,
    /// Unit vector from the other's centre (or corner) to the receiver's centre. On a face it is the face's normal on
    /// the side of the receiver's centre.
    pub normal: Vec2,
}

impl Overlap {
    /// \[m\] Vector from the receiving disk's centre to the contact point, which is halfway into the overlap.
    #[inline]
    pub fn contact_point(&self, radius: f64) -> Vec2 {
        self.normal * (0.5 * self.depth - radius)
    }
}

/// The relation of two things at a distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Meeting {
    /// No overlap.
    Apart,
    /// Overlapping with a well-defined normal.
    Touching(Overlap),
    /// The centres coincide within a nanometre: there is no normal, so no force; it is counted.
    Coincident,
}

/// \[m\] Centres closer than this are one point, because the difference is rounding and has no direction. With a
/// smaller limit, rounding would choose the normal. The missing force has no effect in practice, because bodies do not
/// stay so close.
pub const COINCIDENT: f64 = 1e-9;

/// The overlap of a disk with another disk, or with a point (`reach` is then the disk's radius).
///
/// `between` \[m\] is the vector from the other's centre to the receiver's; `reach` \[m\] is the sum of the radii.
#[inline]
pub fn meet(between: Vec2, reach: f64) -> Meeting {
    let squared = between.norm_squared();
    if squared >= reach * reach {
        return Meeting::Apart;
    }
    let distance = squared.sqrt();
    if distance <= COINCIDENT {
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

/// The overlap of a disk with a face; `nearest` is the point of the face nearest to the disk's centre.
///
/// Inside the face, and at a corner where the wall continues straight, the normal is that of the face on the side of
/// the centre, because the direction from a near point to the centre would be a rounding error. A centre within
/// [`COINCIDENT`] of the line counts as on the side of its body's centre of mass; if that is on the line too, as on the
/// left.
///
/// `radius` \[m\] is that of the disk; `owner` \[m\] is the centre of mass of its body.
#[inline]
pub fn meet_face(
    face: &Face,
    nearest: (Vec2, Along),
    centre: Vec2,
    radius: f64,
    owner: Vec2,
) -> (Meeting, FacePart) {
    match nearest.1 {
        Along::Start if !face.straight_before => return (meet(centre - nearest.0, radius), FacePart::Start),
        Along::End if !face.straight_after => return (meet(centre - nearest.0, radius), FacePart::End),
        _ => {}
    }
    let offset = (centre - face.start).dot(face.normal);
    let side = if offset.abs() > COINCIDENT { offset } else { (owner - face.start).dot(face.normal) };
    let (normal, part) =
        if side >= 0.0 { (face.normal, FacePart::Left) } else { (-face.normal, FacePart::Right) };
    let depth = radius - offset.abs();
    let meeting = if depth > 0.0 { Meeting::Touching(Overlap { depth, normal }) } else { Meeting::Apart };
    (meeting, part)
}

/// The overlap of a disk with a part of a face that it touched before: negative where they parted. None if there is no
/// normal.
pub fn overlap_with_part(face: &Face, part: FacePart, centre: Vec2, radius: f64) -> Option<Overlap> {
    let corner = match part {
        FacePart::Left | FacePart::Right => {
            let normal = if part == FacePart::Left { face.normal } else { -face.normal };
            return Some(Overlap { depth: radius - (centre - face.start).dot(normal), normal });
        }
        FacePart::Start => face.start,
        FacePart::End => face.end,
    };
    let between = centre - corner;
    let distance = between.norm();
    (distance > COINCIDENT).then(|| Overlap { depth: radius - distance, normal: unit(between, distance) })
}

/// \[m\] If the nearest points of two faces are both this close to their common corner, they are one point.
const SAME_POINT: f64 = 1e-9;

/// Whether a contact with the nearest point of a face belongs to this face.
///
/// A corner touches only if it is the nearest point of every face that meets there. The contact then belongs to the
/// face with the lowest number. Where a straight wall is drawn in two pieces, rounding may move the nearest points of
/// both just inside; this too is one contact of the face with the lower number.
pub fn books_contact(scene: &Scene, face: usize, (nearest, along): (Vec2, Along), place: Vec2) -> bool {
    let own = &scene.faces[face];
    let at = match along {
        Along::Start => own.start_corner,
        Along::End => own.end_corner,
        Along::Inside => {
            return ![(own.start_corner, own.straight_before), (own.end_corner, own.straight_after)]
                .into_iter()
                .any(|(at, straight)| {
                    let corner = &scene.corners[at.index()];
                    let near = |point: Vec2| {
                        straight || (point - corner.position).norm_squared() < SAME_POINT * SAME_POINT
                    };
                    near(nearest)
                        && corner.faces.iter().take_while(|lower| lower.index() < face).any(|lower| {
                            let (point, along) = nearest_on_face(&scene.faces[lower.index()], place);
                            along == Along::Inside && near(point)
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

    fn booked(scene: &Scene, place: Vec2) -> Vec<(usize, Along)> {
        (0..scene.faces.len())
            .map(|face| (face, nearest_on_face(&scene.faces[face], place)))
            .filter(|&(face, nearest)| books_contact(scene, face, nearest, place))
            .map(|(face, (_, along))| (face, along))
            .collect()
    }

    /// Of a disk of 0.2 m with the first face.
    fn met(scene: &Scene, centre: Vec2, owner: Vec2) -> (Meeting, FacePart) {
        let face = &scene.faces[0];
        meet_face(face, nearest_on_face(face, centre), centre, 0.2, owner)
    }

    #[test]
    fn the_normal_at_a_face_is_never_a_rounding_error() {
        let touching = |depth, normal| Meeting::Touching(Overlap { depth, normal });
        let (start, end) = (vec2(-4.7, -1.3), vec2(5.1, 2.9));
        let scene = wall(&[start, end]);
        let across = scene.faces[0].normal;
        assert!(across.dot(end - start).abs() < 1e-15 && (across.norm() - 1.0).abs() < 1e-15);
        for share in [0.1, 0.3, 0.51, 0.9] {
            let on_line = start + (end - start) * share;
            for (beside, part, sign) in [(across, FacePart::Left, 1.0), (-across, FacePart::Right, -1.0)] {
                // The centre on the line but for rounding: the body's centre of mass tells the side.
                let (meeting, seen) = met(&scene, on_line, on_line + beside * 0.1);
                assert_eq!(seen, part);
                let Meeting::Touching(Overlap { depth, normal }) = meeting else { panic!() };
                assert!((depth - 0.2).abs() < 1e-15 && normal == across * sign);
                // Beside it: the centre itself does.
                let (_, seen) = met(&scene, on_line + beside * 2e-9, on_line - beside);
                assert_eq!(seen, part);
            }
        }
        // Both on it.
        let scene = wall(&[vec2(-4.7, 0.0), vec2(5.1, 0.0)]);
        let on_line = vec2(0.3, 0.0);
        assert_eq!(met(&scene, on_line, on_line), (touching(0.2, vec2(0.0, 1.0)), FacePart::Left));
        // At the end of the wall there is a normal only away from it.
        assert_eq!(met(&scene, vec2(5.1 + 5e-10, 0.0), on_line), (Meeting::Coincident, FacePart::End));
        assert_eq!(met(&scene, vec2(5.2, 0.0), on_line).1, FacePart::End);
    }

    #[test]
    fn a_seam_of_a_straight_wall_has_the_normal_of_its_faces() {
        let scene = wall(&[vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(2.0, 0.0)]);
        for y in [0.1, 0.0, -0.1] {
            let (meeting, part) = met(&scene, vec2(1.0, y), vec2(1.0, 3.0 * y));
            let (normal, side) =
                if y < 0.0 { (vec2(0.0, -1.0), FacePart::Right) } else { (vec2(0.0, 1.0), FacePart::Left) };
            let depth = 0.2 - y.abs();
            assert_eq!((meeting, part), (Meeting::Touching(Overlap { depth, normal }), side));
        }
    }

    #[test]
    fn centres_within_a_nanometre_are_coincident() {
        assert_eq!(meet(vec2(6e-10, 7e-10), 0.4), Meeting::Coincident);
        assert_eq!(meet(Vec2::ZERO, 0.4), Meeting::Coincident);
        assert!(matches!(meet(vec2(2e-9, 0.0), 0.4), Meeting::Touching(_)));
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
        assert_eq!(booked(&scene, vec2(0.5, 0.1)), [(0, Along::Inside)]);
        assert_eq!(booked(&scene, vec2(1.0, 0.1)), [(0, Along::End)]);
        assert_eq!(booked(&scene, vec2(1.5, 0.1)), [(1, Along::Inside)]);
        assert_eq!(booked(&scene, vec2(-0.1, 0.1)), [(0, Along::Start)]);
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

    /// Bends of less than a microradian are none: on their inner side a disk is above both faces for a tenth of a
    /// micrometre.
    #[test]
    fn a_seam_that_is_straight_but_for_rounding_is_booked_once() {
        for bend in [5e-7, -5e-7] {
            let scene = wall(&[vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(2.0, bend)]);
            for k in -300..=300 {
                for y in [0.19, -0.19] {
                    let place = vec2(1.0 + 1e-9 * f64::from(k), y);
                    assert_eq!(booked(&scene, place).len(), 1, "bend {bend:e}, {place:?}");
                }
            }
        }
    }

    #[test]
    fn corners_push_once_outside_and_twice_inside() {
        let scene = wall(&[vec2(-1.0, 0.0), vec2(0.0, 0.0), vec2(0.0, -1.0)]);
        // Outside the right angle only the corner is near.
        assert_eq!(booked(&scene, vec2(0.1, 0.1)), [(0, Along::End)]);
        // Inside it, both faces are.
        assert_eq!(booked(&scene, vec2(-0.1, -0.1)), [(0, Along::Inside), (1, Along::Inside)]);
        // Beside one face only that face is, though the corner is the other's nearest point.
        assert_eq!(booked(&scene, vec2(-0.1, 0.1)), [(0, Along::Inside)]);
    }

    #[test]
    fn a_corner_of_a_closed_wall_is_booked_on_its_lowest_face() {
        let scene = wall(&[vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(1.0, 1.0), vec2(0.0, 1.0), vec2(0.0, 0.0)]);
        assert_eq!(booked(&scene, vec2(-0.1, -0.1)), [(0, Along::Start)]);
    }
}
