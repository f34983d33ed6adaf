//! Overlaps: depth, place and normal.

use super::face::{Along, Continuation};
use super::{Face, FacePart, Vec2};

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
pub enum Proximity {
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
pub fn proximity(between: Vec2, reach: f64) -> Proximity {
    let squared = between.norm_squared();
    if squared >= reach * reach {
        return Proximity::Apart;
    }
    let distance = squared.sqrt();
    if distance <= COINCIDENT {
        return Proximity::Coincident;
    }
    let depth = reach - distance;
    if depth > 0.0 {
        Proximity::Touching(Overlap { depth, normal: unit(between, distance) })
    } else {
        Proximity::Apart
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
) -> (Proximity, FacePart) {
    match nearest.1 {
        Along::Start if face.before != Continuation::Straight => {
            return (proximity(centre - nearest.0, radius), FacePart::Start);
        }
        Along::End if face.after != Continuation::Straight => {
            return (proximity(centre - nearest.0, radius), FacePart::End);
        }
        _ => {}
    }
    let offset = (centre - face.start).dot(&face.normal);
    let side = if offset.abs() > COINCIDENT { offset } else { (owner - face.start).dot(&face.normal) };
    let (normal, part) =
        if side >= 0.0 { (face.normal, FacePart::Left) } else { (-face.normal, FacePart::Right) };
    let depth = radius - offset.abs();
    let meeting = if depth > 0.0 { Proximity::Touching(Overlap { depth, normal }) } else { Proximity::Apart };
    (meeting, part)
}

/// The overlap of a disk with a part of a face that it touched before: negative where they parted. None if there is no
/// normal.
pub fn overlap_with_part(face: &Face, part: FacePart, centre: Vec2, radius: f64) -> Option<Overlap> {
    let corner = match part {
        FacePart::Left | FacePart::Right => {
            let normal = if part == FacePart::Left { face.normal } else { -face.normal };
            return Some(Overlap { depth: radius - (centre - face.start).dot(&normal), normal });
        }
        FacePart::Start => face.start,
        FacePart::End => face.end,
    };
    let between = centre - corner;
    let distance = between.norm();
    (distance > COINCIDENT).then(|| Overlap { depth: radius - distance, normal: unit(between, distance) })
}

#[cfg(test)]
mod tests {
    use super::super::face::nearest_on_face;
    use super::super::{LawTable, Scene, WallSpec, vec2};
    use super::*;

    fn wall(corners: &[Vec2]) -> Scene {
        Scene::new(&[], &[WallSpec { material: 0, corners: corners.to_vec() }], LawTable::new(1))
    }

    /// Of a disk of 0.2 m with the first face.
    fn met(scene: &Scene, centre: Vec2, owner: Vec2) -> (Proximity, FacePart) {
        let face = &scene.faces[0];
        meet_face(face, nearest_on_face(face, centre), centre, 0.2, owner)
    }

    #[test]
    fn the_normal_at_a_face_is_never_a_rounding_error() {
        let touching = |depth, normal| Proximity::Touching(Overlap { depth, normal });
        let (start, end) = (vec2(-4.7, -1.3), vec2(5.1, 2.9));
        let scene = wall(&[start, end]);
        let across = scene.faces[0].normal;
        assert!(across.dot(&(end - start)).abs() < 1e-15 && (across.norm() - 1.0).abs() < 1e-15);
        for share in [0.1, 0.3, 0.51, 0.9] {
            let on_line = start + (end - start) * share;
            for (beside, part, sign) in [(across, FacePart::Left, 1.0), (-across, FacePart::Right, -1.0)] {
                // The centre on the line but for rounding: the body's centre of mass tells the side.
                let (meeting, seen) = met(&scene, on_line, on_line + beside * 0.1);
                assert_eq!(seen, part);
                let Proximity::Touching(Overlap { depth, normal }) = meeting else { panic!() };
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
        assert_eq!(met(&scene, vec2(5.1 + 5e-10, 0.0), on_line), (Proximity::Coincident, FacePart::End));
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
            assert_eq!((meeting, part), (Proximity::Touching(Overlap { depth, normal }), side));
        }
    }

    #[test]
    fn centres_within_a_nanometre_are_coincident() {
        assert_eq!(proximity(vec2(6e-10, 7e-10), 0.4), Proximity::Coincident);
        assert_eq!(proximity(Vec2::zeros(), 0.4), Proximity::Coincident);
        assert!(matches!(proximity(vec2(2e-9, 0.0), 0.4), Proximity::Touching(_)));
    }

    #[test]
    fn contact_point_is_shared() {
        let (a, b, ra, rb) = (vec2(0.1, 0.2), vec2(0.25, 0.3), 0.15, 0.1);
        let Proximity::Touching(seen_by_a) = proximity(a - b, ra + rb) else { panic!() };
        let Proximity::Touching(seen_by_b) = proximity(b - a, ra + rb) else { panic!() };
        let gap = (a + seen_by_a.contact_point(ra)) - (b + seen_by_b.contact_point(rb));
        assert!(gap.norm() < 1e-16);
        assert_eq!(seen_by_a.normal, -seen_by_b.normal);
    }
}
