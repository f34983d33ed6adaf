//! Which faces of walls act on a disk, and how deep the disk is in each.
//!
//! - Of faces that are one [`super::Face::line`], those that a disk overlaps form *runs*: connected pieces of the line.
//!   Of each run only the nearest face acts. So neither the division of a wall into faces nor a wall that is drawn twice
//!   changes the mechanics.
//! - A corner acts if it is the nearest point of all faces that meet there, and only once.
//! - Two contacts whose normals differ by less than 90° act with the depths that they have as a pair, whether the faces
//!   meet or not. The elastic energy is then k d²/2, where d is the distance of the disk's centre from the wall moved
//!   inwards by the radius. Because d is continuous, inner corners neither make nor take energy.

use super::circle::Circle;
use super::face::{Along, Continuation, beyond, nearest_on_face};
use super::near_pairs::{FacePair, Spring};
use super::overlap::{Overlap, Proximity, meet_face, overlap_with_part};
use super::{FaceId, FacePart, Scene, Vec2};

/// A contact of a disk with a face.
#[derive(Debug, Clone, Copy)]
pub(super) struct WallContact {
    /// Index of the face among those that were looked at.
    pub place: usize,
    pub part: FacePart,
    /// The depth is not positive where the other contact of a pair alone holds the disk: no force acts then.
    pub overlap: Overlap,
    /// Whether the disk's centre is on a corner: there is no normal, so no force acts.
    pub coincident: bool,
    /// \[1\] The depth falls by the product of this vector and a small motion of the disk's centre. It is the normal,
    /// but not where two faces act as a pair.
    pub gradient: Vec2,
    /// \[m\] The depth that the contact has without the other one of a pair.
    alone: f64,
}

/// A face that a disk overlaps.
#[derive(Debug, Clone, Copy)]
struct Overlapped {
    place: usize,
    face: FaceId,
    nearest: (Vec2, Along),
    /// \[m²\]
    squared_distance: f64,
    run: u32,
    /// Whether it is the nearest of its run.
    acts: bool,
}

/// Without a run as yet.
const NO_RUN: u32 = u32::MAX;
/// Below this squared sine two normals are parallel: the deeper contact alone holds the disk.
const PARALLEL: f64 = 1e-12;

/// Finds the contacts of a disk with walls; holds scratch space.
#[derive(Debug, Clone, Default)]
pub(super) struct WallContacts {
    overlapped: Vec<Overlapped>,
    contacts: Vec<WallContact>,
    flood: Vec<usize>,
}

impl WallContacts {
    /// Returns the contacts of a disk with some faces, ascending. `faces` are those near the disk, ascending; `owner`
    /// \[m\] is the centre of mass of its body.
    pub fn find(&mut self, scene: &Scene, faces: &[FacePair], disk: Circle, owner: Vec2) -> &[WallContact] {
        self.contacts.clear();
        self.overlapped.clear();
        for (place, pair) in faces.iter().enumerate() {
            let face = &scene.faces[pair.face.index()];
            let nearest = nearest_on_face(face, disk.centre);
            let squared_distance = (disk.centre - nearest.0).norm_squared();
            if squared_distance < disk.radius * disk.radius && !is_covered(scene, pair.face, nearest.1) {
                let (face, run) = (pair.face, NO_RUN);
                self.overlapped.push(Overlapped { place, face, nearest, squared_distance, run, acts: false });
            }
        }
        self.find_runs(scene);
        for k in 0..self.overlapped.len() {
            let Overlapped { place, face, nearest, acts, .. } = self.overlapped[k];
            if !acts || !self.is_free(scene, k, disk.centre) {
                continue;
            }
            let (meeting, part) =
                meet_face(&scene.faces[face.index()], nearest, disk.centre, disk.radius, owner);
            let (overlap, coincident) = match meeting {
                Proximity::Touching(overlap) => (overlap, false),
                Proximity::Coincident => (Overlap { depth: disk.radius, normal: Vec2::zeros() }, true),
                Proximity::Apart => continue,
            };
            let (gradient, alone) = (overlap.normal, overlap.depth);
            self.contacts.push(WallContact { place, part, overlap, coincident, gradient, alone });
        }
        if self.contacts.len() > 1 {
            self.join_runs(scene, faces);
            self.pair(scene, faces, disk);
        }
        &self.contacts
    }

    /// The contacts that were found last.
    pub fn found(&self) -> &[WallContact] {
        &self.contacts
    }

    /// Finds the runs, and the nearest face of each: of equally near ones the first.
    fn find_runs(&mut self, scene: &Scene) {
        if let [only] = &mut self.overlapped[..] {
            (only.run, only.acts) = (0, true);
            return;
        }
        for run in 0.. {
            let alone = self.overlapped.iter().enumerate().filter(|(_, face)| face.run == NO_RUN);
            let nearest = alone.min_by(|(_, one), (_, other)| {
                one.squared_distance.total_cmp(&other.squared_distance).then(one.place.cmp(&other.place))
            });
            let Some((nearest, _)) = nearest else { return };
            (self.overlapped[nearest].run, self.overlapped[nearest].acts) = (run, true);
            self.flood.push(nearest);
            while let Some(k) = self.flood.pop() {
                for other in &scene.joined[self.overlapped[k].face.index()] {
                    if let Some(other) = self.place_of(*other)
                        && self.overlapped[other].run == NO_RUN
                    {
                        self.overlapped[other].run = run;
                        self.flood.push(other);
                    }
                }
            }
        }
    }

    fn place_of(&self, face: FaceId) -> Option<usize> {
        self.overlapped.binary_search_by_key(&face, |overlapped| overlapped.face).ok()
    }

    fn run_of(&self, face: FaceId) -> Option<u32> {
        self.place_of(face).map(|k| self.overlapped[k].run)
    }

    /// Whether the nearest point of a face is no corner, or one that belongs to this contact.
    fn is_free(&self, scene: &Scene, k: usize, centre: Vec2) -> bool {
        let Overlapped { face, nearest, run, .. } = self.overlapped[k];
        let of_face = &scene.faces[face.index()];
        let at = match nearest.1 {
            Along::Inside => return true,
            Along::Start => of_face.start_corner,
            Along::End => of_face.end_corner,
        };
        if of_face.continuation(at) == Continuation::Straight {
            return true;
        }
        let corner = &scene.corners[at.index()];
        let nearest_of = |other: &FaceId| {
            let face = &scene.faces[other.index()];
            let (end, other_end) =
                if face.start_corner == at { (face.start, face.end) } else { (face.end, face.start) };
            beyond(end, other_end, centre)
        };
        (corner.owner == face || self.run_of(corner.owner) == Some(run))
            && corner.faces.iter().all(|other| self.run_of(*other) == Some(run) || nearest_of(other))
    }

    /// Leaves the deepest of the contacts of a line that act in similar directions: the disk does not overlap the faces
    /// between them as yet, and when it does they are one run.
    fn join_runs(&mut self, scene: &Scene, faces: &[FacePair]) {
        let line = |contact: &WallContact| scene.faces[faces[contact.place].face.index()].line;
        for j in 1..self.contacts.len() {
            for i in 0..j {
                let (one, other) = (self.contacts[i], self.contacts[j]);
                if line(&one) == line(&other) && one.goes_with(other.overlap.normal) {
                    self.contacts[if one.alone < other.alone { i } else { j }].alone = 0.0;
                }
            }
        }
        self.contacts.retain(|contact| contact.alone > 0.0);
    }

    /// Gives contacts in directions that differ by less than 90° the depths that they have as a pair.
    fn pair(&mut self, scene: &Scene, faces: &[FacePair], disk: Circle) {
        for j in 1..self.contacts.len() {
            for i in 0..j {
                let (one, other) = (self.contacts[i], self.contacts[j]);
                let (n, m) = (one.overlap.normal, other.overlap.normal);
                let cos = n.dot(&m);
                let squared_sine = 1.0 - cos * cos;
                // Walls of different heights act each for itself: their forces are of other parts of the disk.
                let [of_one, of_other] = [one, other].map(|contact| faces[contact.place].face);
                if cos <= 0.0 || !scene.same_heights(of_one, of_other) {
                    continue;
                }
                if squared_sine < PARALLEL {
                    let (shallow, lead) =
                        if one.alone < other.alone { (i, other.alone) } else { (j, one.alone) };
                    let depth = self.contacts[shallow].alone - lead;
                    self.contacts[shallow].reduce(depth, Vec2::zeros());
                    continue;
                }
                let seen = |contact: &WallContact, centre| {
                    let face = &scene.faces[faces[contact.place].face.index()];
                    overlap_with_part(face, contact.part, centre, disk.radius)
                };
                let [mut a, mut b] = shares(
                    &Overlap { depth: one.alone, normal: n },
                    &Overlap { depth: other.alone, normal: m },
                );
                if !(one.is_on_side() && other.is_on_side()) {
                    // About a corner the depth is not linear: Newton's method finds where the disk touches both.
                    let mut to = n * a + m * b;
                    for _ in 0..3 {
                        let centre = disk.centre + to;
                        if let (Some(one), Some(other)) = (seen(&one, centre), seen(&other, centre)) {
                            let [a, b] = shares(&one, &other);
                            to += one.normal * a + other.normal * b;
                        }
                    }
                    // Far away there is no such place, or another one.
                    if to.norm() < disk.radius {
                        [a, b] = [to.perp(&m), n.perp(&to)].map(|part| part / n.perp(&m));
                    }
                }
                if b > 0.0 {
                    self.contacts[i].reduce(a, (n - m * cos) * (1.0 / squared_sine));
                }
                if a > 0.0 {
                    self.contacts[j].reduce(b, (m - n * cos) * (1.0 / squared_sine));
                }
            }
        }
    }

    /// Returns the index of the pair whose spring a contact keeps: its own, or that of a face of the same line that
    /// touched in the evaluation `before` and acts no more.
    pub fn keeps(
        &self,
        scene: &Scene,
        faces: &[FacePair],
        springs: &[Spring],
        contact: &WallContact,
        centre: Vec2,
        before: u32,
    ) -> Option<usize> {
        let place = contact.place;
        let (face, spring) = (&scene.faces[faces[place].face.index()], &springs[place]);
        if spring.touched_at == before {
            let in_line = face.goes_on(contact.part) || face.goes_on(spring.part);
            return (spring.part == contact.part || in_line).then_some(place);
        }
        if scene.joined[faces[place].face.index()].is_empty() {
            return None;
        }
        let acts = |k: usize| self.contacts.iter().any(|other| other.place == k && other.overlap.depth > 0.0);
        let same_side = |k: usize| {
            let other = &scene.faces[faces[k].face.index()];
            let overlap = overlap_with_part(other, springs[k].part, centre, 0.0);
            overlap.is_some_and(|overlap| contact.goes_with(overlap.normal))
        };
        let in_line = |k: &usize| {
            springs[*k].touched_at == before && scene.faces[faces[*k].face.index()].line == face.line
        };
        (0..faces.len()).filter(in_line).find(|k| !acts(*k) && same_side(*k))
    }
}

impl WallContact {
    fn is_on_side(&self) -> bool {
        matches!(self.part, FacePart::Left | FacePart::Right)
    }

    /// Whether a normal is in a similar direction.
    fn goes_with(&self, normal: Vec2) -> bool {
        self.overlap.normal.dot(&normal) > 0.5
    }

    /// Takes a depth \[m\] of a pair, if it is less.
    fn reduce(&mut self, depth: f64, gradient: Vec2) {
        if depth < self.overlap.depth {
            (self.overlap.depth, self.gradient) = (depth, gradient);
        }
    }
}

/// Returns the depths of two contacts as a pair.
fn shares(one: &Overlap, other: &Overlap) -> [f64; 2] {
    let cos = one.normal.dot(&other.normal);
    let share = |one: &Overlap, other: &Overlap| (one.depth - other.depth * cos) / (1.0 - cos * cos);
    [share(one, other), share(other, one)]
}

/// Whether the nearest point of a face is a corner through which another face passes.
fn is_covered(scene: &Scene, face: FaceId, along: Along) -> bool {
    let face = &scene.faces[face.index()];
    match along {
        Along::Inside => false,
        Along::Start => scene.corners[face.start_corner.index()].covered,
        Along::End => scene.corners[face.end_corner.index()].covered,
    }
}

#[cfg(test)]
mod tests {
    use super::super::{DiskId, InPlane, LawTable, WallSpec, vec2};
    use super::*;

    fn walls(walls: &[&[Vec2]]) -> Scene {
        let specs: Vec<WallSpec> =
            walls.iter().map(|corners| WallSpec { material: 0, corners: corners.to_vec() }).collect();
        Scene::new(&[], &specs, LawTable::new(1))
    }

    fn wall(corners: &[Vec2]) -> Scene {
        walls(&[corners])
    }

    fn found(scene: &Scene, centre: Vec2, radius: f64) -> Vec<WallContact> {
        let pairs: Vec<FacePair> = (0..scene.faces.len())
            .map(|face| FacePair { disk: DiskId(0), face: FaceId::from(face) })
            .collect();
        WallContacts::default().find(scene, &pairs, Circle { centre, radius }, centre).to_vec()
    }

    fn acting(scene: &Scene, centre: Vec2, radius: f64) -> Vec<WallContact> {
        let found = found(scene, centre, radius).into_iter();
        found.filter(|contact| contact.overlap.depth > 0.0).collect()
    }

    /// The faces that a disk of 0.3 m touches, and where.
    fn touched(scene: &Scene, centre: Vec2) -> Vec<(usize, FacePart)> {
        acting(scene, centre, 0.3).iter().map(|contact| (contact.place, contact.part)).collect()
    }

    /// The sum of depths along normals: the force, divided by the stiffness.
    fn force(acting: &[WallContact]) -> Vec2 {
        let forces = acting.iter().map(|contact| contact.overlap.normal * contact.overlap.depth);
        forces.fold(Vec2::zeros(), |sum, force| sum + force)
    }

    #[test]
    fn straight_wall_in_two_pieces_is_one() {
        let scene = wall(&[vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(2.0, 0.0)]);
        assert_eq!(touched(&scene, vec2(0.5, 0.1)), [(0, FacePart::Left)]);
        assert_eq!(touched(&scene, vec2(1.0, 0.1)), [(0, FacePart::Left)]);
        assert_eq!(touched(&scene, vec2(1.5, 0.1)), [(1, FacePart::Left)]);
        assert_eq!(touched(&scene, vec2(-0.1, 0.1)), [(0, FacePart::Start)]);
    }

    #[test]
    fn a_seam_is_booked_once_whatever_the_rounding() {
        let straight = wall(&[vec2(-10.0, 0.0), vec2(0.0, 0.0), vec2(10.0, 0.0)]);
        for x in [-1e-16, -6e-17, -1e-17, -0.0, 0.0, 1e-17, 1e-16] {
            assert_eq!(touched(&straight, vec2(x, 0.19)).len(), 1, "{x}");
        }
        // Slanted walls of any length, the place on the normal at the seam but for rounding.
        for k in 0..5000 {
            let angle = 0.37 * f64::from(k);
            let along = vec2(libm::cos(angle), libm::sin(angle));
            let seam = vec2(libm::sin(1.7 * f64::from(k)) * 9.0, libm::cos(2.3 * f64::from(k)) * 9.0);
            let (before, after) = (0.1 + 0.003 * f64::from(k % 977), 0.1 + 0.002 * f64::from(k % 613));
            let slanted = wall(&[seam - along * before, seam, seam + along * after]);
            for shift in [-1e-15, -1e-16, 0.0, 1e-16, 1e-15] {
                let place = seam + along.left() * 0.19 + along * shift;
                assert_eq!(touched(&slanted, place).len(), 1, "wall {k}, shift {shift}");
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
                    assert_eq!(touched(&scene, place).len(), 1, "bend {bend:e}, {place:?}");
                }
            }
        }
    }

    #[test]
    fn corners_push_once_outside_and_twice_inside() {
        let scene = wall(&[vec2(-1.0, 0.0), vec2(0.0, 0.0), vec2(0.0, -1.0)]);
        // Outside the right angle only the corner is near.
        assert_eq!(touched(&scene, vec2(0.1, 0.1)), [(0, FacePart::End)]);
        // Inside it, both faces are.
        assert_eq!(touched(&scene, vec2(-0.1, -0.1)), [(0, FacePart::Right), (1, FacePart::Right)]);
        // Beside one face only that face is, though the corner is the other's nearest point.
        assert_eq!(touched(&scene, vec2(-0.1, 0.1)), [(0, FacePart::Left)]);
    }

    #[test]
    fn a_corner_of_a_closed_wall_is_booked_on_its_lowest_face() {
        let scene = wall(&[vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(1.0, 1.0), vec2(0.0, 1.0), vec2(0.0, 0.0)]);
        assert_eq!(touched(&scene, vec2(-0.1, -0.1)), [(0, FacePart::Start)]);
    }

    /// Two faces that turn by an angle \[rad\] at the origin: from the left, then up.
    fn bend(angle: f64) -> Scene {
        wall(&[vec2(-3.0, 0.0), Vec2::zeros(), vec2(3.0 * libm::cos(angle), 3.0 * libm::sin(angle))])
    }

    /// The force of the acting depths is the gradient of half the squared distance from the wall moved inwards, which is
    /// computed from the nearest point of that polyline.
    #[test]
    fn the_depths_of_a_pair_are_those_of_the_moved_wall() {
        let radius = 0.2;
        for degrees in [21.0, 35.0, 60.0, 89.0f64] {
            let angle = degrees.to_radians();
            let scene = bend(angle);
            let (n, m) = (scene.faces[0].normal, scene.faces[1].normal);
            // Where both moved lines meet.
            let vertex = vec2(-radius * libm::tan(0.5 * angle), radius);
            let (mut both, mut single) = (0, 0);
            for k in 0..2000 {
                let (x, y) = (libm::sin(1.3 * f64::from(k)), libm::cos(2.9 * f64::from(k)));
                let centre = vertex + vec2(0.15 * x, 0.06 * y);
                let (below, beside) = ((vertex - centre).dot(&n), (vertex - centre).dot(&m));
                if below <= 0.0 && beside <= 0.0 {
                    continue;
                }
                let [along, other] = [vec2(-1.0, 0.0), vec2(libm::cos(angle), libm::sin(angle))];
                let on_line =
                    |direction: Vec2| vertex + direction * (centre - vertex).dot(&direction).max(0.0);
                let nearest = [on_line(along), on_line(other)]
                    .into_iter()
                    .min_by(|a, b| (*a - centre).norm().total_cmp(&(*b - centre).norm()))
                    .unwrap();
                let acting = acting(&scene, centre, radius);
                let apart = force(&acting) - (nearest - centre);
                assert!(apart.norm() < 1e-12, "{degrees}° {centre:?} {acting:?}");
                both += u32::from(acting.len() == 2);
                single += u32::from(acting.len() == 1);
            }
            assert!(both > 50 && single > 50, "{degrees}° {both} {single}");
        }
    }

    /// Half the squared force is the elastic energy, divided by the stiffness.
    #[test]
    fn the_elastic_energy_does_not_jump() {
        let turned = |degrees: f64| vec2(libm::cos(degrees.to_radians()), libm::sin(degrees.to_radians()));
        let (from, to) = (vec2(-3.0, 0.0), vec2(3.0, 0.0));
        let bends = |first: f64, length: f64, second: f64| {
            let middle = turned(first) * length;
            wall(&[from, Vec2::zeros(), middle, middle + turned(first + second) * 3.0])
        };
        let scenes = [
            ("a wall that ends on another", walls(&[&[from, to], &[Vec2::zeros(), turned(10.0) * 3.0]])),
            ("three in a corner", walls(&[&[from, Vec2::zeros(), to], &[Vec2::zeros(), turned(10.0) * 3.0]])),
            ("a step", bends(60.0, 0.115, -60.0)),
            ("a small bend and a large one", bends(-15.0, 0.04, 60.0)),
            ("a large bend and a small one", bends(60.0, 0.1, 15.0)),
            ("a short face in a line", bends(19.9, 0.04, 19.9)),
            ("a short face between corners", bends(20.1, 0.04, 20.1)),
        ];
        for (name, scene) in scenes {
            for row in 1..12 {
                let (step, mut last) = (2e-5, None);
                for column in 0..20_000 {
                    let centre = vec2(-0.3 + step * f64::from(column), 0.2 - 0.001 * f64::from(row));
                    let force = force(&acting(&scene, centre, 0.2));
                    if force.norm() > 0.02 {
                        break;
                    }
                    let energy = 0.5 * force.norm_squared();
                    let jump = (energy - last.unwrap_or(energy)).abs();
                    assert!(jump < 1.1 * 0.02 * step, "{name}: {jump:e} at {centre:?}");
                    last = Some(energy);
                }
            }
        }
    }

    /// The gradient is that of the depth.
    #[test]
    fn the_depth_of_a_pair_changes_by_its_gradient() {
        let scene = bend(0.7);
        let (centre, by) = (vec2(-0.05, 0.17), vec2(3e-7, -5e-7));
        let (here, there) = (found(&scene, centre, 0.2), found(&scene, centre + by, 0.2));
        assert_eq!((here.len(), there.len()), (2, 2));
        for (here, there) in here.iter().zip(&there) {
            let change = there.overlap.depth - here.overlap.depth;
            assert!((change + here.gradient.dot(&by)).abs() < 1e-13 && change.abs() > 1e-8);
        }
    }

    #[test]
    fn a_line_acts_once_and_a_slot_twice() {
        // 10°: of both faces the nearer acts, up to the bisector and beyond.
        let scene = bend(10f64.to_radians());
        assert_eq!(touched(&scene, vec2(-0.1, 0.19)), [(0, FacePart::Left)]);
        assert_eq!(touched(&scene, vec2(0.1, 0.19)), [(1, FacePart::Left)]);
        // From outside its corner goes on as a part of the line.
        assert_eq!(touched(&scene, vec2(0.01, -0.19)), [(0, FacePart::End)]);
        // A slot with a round bottom of 0.2 m: the bottom is too far for a disk of 0.3 m that touches both sides.
        let round = (0..=18).map(|k| {
            let angle = f64::from(k - 9) * 10f64.to_radians();
            vec2(0.25 * libm::sin(angle), -0.25 * libm::cos(angle))
        });
        let corners: Vec<Vec2> =
            [vec2(-0.25, 3.0)].into_iter().chain(round).chain([vec2(0.25, 3.0)]).collect();
        let slot = wall(&corners);
        assert_eq!(touched(&slot, vec2(0.0, 0.5)), [(0, FacePart::Left), (19, FacePart::Left)]);
    }

    #[test]
    fn walls_that_meet_act_like_one() {
        let along = [vec2(-2.0, 0.0), vec2(0.0, 0.0), vec2(2.0, 0.0)];
        // Two walls end to end, one of them drawn twice, and one that ends on them from below.
        let scene = walls(&[
            &[along[0], along[1]],
            &[along[2], along[1]],
            &[along[1], along[0]],
            &[vec2(1.0, -1.0), vec2(1.0, 0.0)],
        ]);
        for k in -150..150 {
            let x = 0.01 * f64::from(k);
            assert_eq!(touched(&scene, vec2(x, 0.25)).len(), 1, "{x}");
        }
        // A second line 5 mm below is not nearer.
        let plate = walls(&[&[along[0], along[2]], &[vec2(-2.0, -0.005), vec2(2.0, -0.005)]]);
        assert_eq!(touched(&plate, vec2(0.3, 0.25)), [(0, FacePart::Left)]);
        // In the corner of the last one both act.
        assert_eq!(touched(&scene, vec2(1.1, -0.2)), [(1, FacePart::Left), (3, FacePart::Right)]);
    }
}
