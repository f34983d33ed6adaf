//! Constants in time: bodies, disks, walls and the contact laws between materials.

use super::circle::Circle;
use super::face::{Along, Continuation, Face, nearest_on_face};
use super::face_grid::FaceGrid;
use super::levels::{self, Levels};
use super::panels::Panels;
use super::slope::Slopes;
use super::{BodyId, CornerId, DiskId, FaceId, InPlane, LineId, Pair, Vec2, WallId, rotation};
use lemons_core::plane::{shown_orientation, vec2};
use lemons_core::trial::{Ground, Heights, Wall};
use std::collections::HashMap;
use std::f64::consts::PI;
use std::ops::Range;
use std::sync::Arc;

/// The properties of a body, for [`Scene::new`].
#[derive(Debug, Clone, PartialEq)]
pub struct BodySpec {
    /// \[kg\] positive.
    pub mass: f64,
    /// \[kg.m2\] moment of inertia about the centre of mass, positive.
    pub inertia: f64,
    /// \[1/s\] relaxation rate of the velocity, 1/t_transl ≥ 0.
    pub translation_rate: f64,
    /// \[1/s\] relaxation rate ≥ 0 of the velocity across the gaze, if it is not the same: of wheels. The other one is
    /// then that along the gaze.
    pub across_rate: Option<f64>,
    /// \[1/s\] relaxation rate of the angular velocity, 1/t_rot ≥ 0.
    pub rotation_rate: f64,
    /// The disks, at least one, in order from the left shoulder to the right one.
    pub disks: Vec<DiskSpec>,
}

/// A disk of a [`BodySpec`].
#[derive(Debug, Clone, PartialEq)]
pub struct DiskSpec {
    /// \[m\] positive.
    pub radius: f64,
    /// \[m\] position relative to the centre of mass, at the orientation that the disks themselves define (see
    /// [`shown_orientation`]).
    pub position: Vec2,
    /// Place in the table of laws.
    pub material: usize,
}

/// A wall, for [`Scene::new`].
#[derive(Debug, Clone, PartialEq)]
pub struct WallSpec {
    /// Place in the table of laws.
    pub material: usize,
    /// \[m\] at least two corners; the wall is closed if the last one is at the place of the first.
    pub corners: Vec<Vec2>,
}

/// The damped springs and the slider between two materials.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairLaw {
    /// \[N/m\] k_n, positive.
    pub normal_stiffness: f64,
    /// \[N/m\] k_t, positive.
    pub tangential_stiffness: f64,
    /// \[kg/s\] γ_n ≥ 0.
    pub normal_damping: f64,
    /// \[kg/s\] γ_t ≥ 0.
    pub tangential_damping: f64,
    /// \[1\] μ ≥ 0.
    pub friction: f64,
}

/// The contact law of every pair of materials.
#[derive(Debug, Clone, PartialEq)]
pub struct LawTable {
    materials: usize,
    laws: Vec<PairLaw>,
}

impl LawTable {
    /// Makes a table for this number of materials. The laws of pairs that can touch must be set; others are not used.
    pub fn new(materials: usize) -> LawTable {
        let never = PairLaw {
            normal_stiffness: f64::NAN,
            tangential_stiffness: f64::NAN,
            normal_damping: f64::NAN,
            tangential_damping: f64::NAN,
            friction: f64::NAN,
        };
        LawTable { materials, laws: vec![never; materials * materials] }
    }

    /// Sets the law of two materials, in either order.
    pub fn set(&mut self, first: usize, second: usize, law: PairLaw) {
        self.laws[first * self.materials + second] = law;
        self.laws[second * self.materials + first] = law;
    }
}

/// A rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// \[kg\]
    pub mass: f64,
    /// \[kg.m2\]
    pub inertia: f64,
    /// \[1/kg\]
    pub inverse_mass: f64,
    /// \[1/(kg.m2)\]
    pub inverse_inertia: f64,
    /// \[1/s\]
    pub translation_rate: f64,
    /// \[1/s\] across the gaze, if it is not the same.
    pub across_rate: Option<f64>,
    /// \[1/s\]
    pub rotation_rate: f64,
    /// Bodies with the same relaxation rates share a flight: its place in [`Scene::flyers`].
    pub(super) flyer: u32,
    /// Its disks, as places in [`Scene::disks`].
    pub disks: Range<usize>,
    /// \[m\] radius of the circle about the centre of mass that contains every disk.
    pub bounding_radius: f64,
    /// \[m\] distance of the farthest disk's centre from the centre of mass.
    pub reach: f64,
    /// \[m\] Extent along the gaze, and across it.
    pub extent: Vec2,
}

impl Body {
    /// \[m/s2\] Returns the acceleration by the floor, at an orientation \[rad\] and a velocity \[m/s\].
    pub fn by_floor(&self, orientation: f64, velocity: Vec2) -> Vec2 {
        let isotropic = velocity * -self.translation_rate;
        let Some(across) = self.across_rate else { return isotropic };
        let side = rotation(orientation) * vec2(0.0, 1.0);
        isotropic + side * (side.dot(&velocity) * (self.translation_rate - across))
    }
}

/// A disk of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactDisk {
    /// The owner.
    pub body: BodyId,
    /// \[m\]
    pub radius: f64,
    /// \[m\] from the centre of mass when the body's orientation is zero.
    pub offset: Vec2,
    /// Place in the table of laws.
    pub material: usize,
}

/// \[rad\] Faces that meet and turn by at most this much go on straight.
const STRAIGHT: f64 = 1e-6;
/// Cosine of 20°: faces that meet and turn by at most this much are one line.
const LINE: f64 = 0.939_692_620_785_908_4;
/// \[m\] Points of walls closer than this are one point: they differ by rounding.
const SAME_POINT: f64 = 1e-9;

/// A point where faces meet, of one wall or of several, or where a wall ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Corner {
    /// \[m\]
    pub position: Vec2,
    /// The faces that meet here, ascending.
    pub faces: Vec<FaceId>,
    /// The face to which contacts with the corner are assigned: the first of those that go on in a line here, else the
    /// first.
    pub owner: FaceId,
    /// Whether another face passes through. Then nothing touches the corner, because that face is nearer.
    pub covered: bool,
}

impl Corner {
    fn new(position: Vec2) -> Corner {
        Corner { position, faces: Vec::new(), owner: FaceId::from(0), covered: false }
    }
}

/// Bodies, walls and laws. Only which walls are there changes: in a new scene.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// Bodies in the order of the agents.
    pub bodies: Vec<Body>,
    /// Grouped by body.
    pub disks: Vec<ContactDisk>,
    /// One body for each pair of relaxation rates that occurs.
    pub(super) flyers: Vec<BodyId>,
    /// Grouped by wall.
    pub faces: Vec<Face>,
    /// First face of each wall.
    pub wall_faces: Vec<Range<usize>>,
    /// The walls, as they were given.
    walls: Vec<WallSpec>,
    /// Corners of all walls.
    pub corners: Vec<Corner>,
    /// For each face, those that continue it: at an end, turning by at most 20°, or lying on it.
    pub(super) joined: Vec<Vec<FaceId>>,
    /// Pairs of faces that lie on each other, as many as join all that do. They act like one.
    pub doubled: Vec<(FaceId, FaceId)>,
    laws: LawTable,
    pub(super) face_grid: FaceGrid,
    pub(super) panels: Panels,
    pub(super) slopes: Arc<Slopes>,
    /// Heights of disks and walls; none in a plan view.
    pub levels: Option<Arc<Levels>>,
}

impl Scene {
    /// Builds the scene.
    pub fn new(bodies: &[BodySpec], walls: &[WallSpec], laws: LawTable) -> Scene {
        let mut scene = Scene {
            bodies: Vec::with_capacity(bodies.len()),
            disks: Vec::with_capacity(bodies.iter().map(|body| body.disks.len()).sum()),
            flyers: Vec::new(),
            faces: Vec::new(),
            wall_faces: Vec::with_capacity(walls.len()),
            walls: walls.to_vec(),
            corners: Vec::new(),
            joined: Vec::new(),
            doubled: Vec::new(),
            laws,
            face_grid: FaceGrid::default(),
            panels: Panels::default(),
            slopes: Arc::default(),
            levels: None,
        };
        let mut flyers = HashMap::new();
        for spec in bodies {
            scene.add_body(spec, &mut flyers);
        }
        scene.add_walls(&vec![true; walls.len()]);
        scene
    }

    /// Divides the straight stretches of walls into panels, for [`World::panel_exposures`](super::World::panel_exposures). `longest` \[m\]
    /// is the length of the longest panel of each wall, if it has some.
    pub fn with_panels(self, longest: &[Option<f64>]) -> Scene {
        assert_eq!(longest.len(), self.walls.len(), "one for each wall");
        let stretches = self.walls.iter().zip(longest).map(|(wall, longest)| {
            let corners = if longest.is_some() { wall.corners.clone() } else { Vec::new() };
            Wall { panel_length: *longest, ..Wall::new("", "", corners) }.stretches()
        });
        let panels = Panels::new(self.faces.len(), self.wall_faces.iter().zip(stretches));
        Scene { panels, ..self }
    }

    /// Adds slopes, which pull bodies downhill.
    pub fn with_grounds(self, grounds: &[Ground]) -> Scene {
        Scene { slopes: Arc::new(Slopes::new(grounds)), ..self }
    }

    /// Gives disks and walls heights. Walls whose heights differ are not joined where they meet.
    pub fn with_levels(self, levels: Levels) -> Scene {
        let present = vec![true; self.walls.len()];
        Scene { levels: Some(Arc::new(levels)), ..self }.with_walls(&present)
    }

    /// \[1\] Returns the share of the load length over which a pair touches: of its forces by its law. It is 1 in a plan
    /// view.
    pub fn share(&self, pair: Pair) -> f64 {
        let Some(levels) = &self.levels else { return 1.0 };
        match pair {
            Pair::Disks { first, second } => levels.share_of_disks(first, second),
            Pair::Face { disk, face, .. } => levels.share_of_face(disk, &self.faces[face.index()]),
        }
    }

    /// \[m/s2\] Returns the acceleration downhill at a place, by what feet do not hold.
    pub fn pull(&self, place: Vec2) -> Vec2 {
        self.slopes.pull(place)
    }

    /// Returns the scene with only some of its walls. Faces keep their numbers. Those of a wall that is absent touch
    /// nothing.
    pub(super) fn with_walls(&self, present: &[bool]) -> Scene {
        let mut scene =
            Scene { faces: Vec::new(), wall_faces: Vec::new(), corners: Vec::new(), ..self.clone() };
        scene.doubled.clear();
        scene.add_walls(present);
        scene
    }

    /// Makes faces and corners of the walls, and finds which of those that are present go on in each other.
    fn add_walls(&mut self, present: &[bool]) {
        let mut places = Places::default();
        for (wall, present) in present.iter().enumerate() {
            self.add_wall(WallId::from(wall), &mut places, *present);
        }
        self.face_grid = FaceGrid::new(&self.faces, |wall| present[wall.index()]);
        self.join_faces();
    }

    /// `flyers` maps the bits of the rates to indices in [`Scene::flyers`].
    fn add_body(&mut self, spec: &BodySpec, flyers: &mut HashMap<[Option<u64>; 3], u32>) {
        let body = BodyId::from(self.bodies.len());
        // Equal rates along and across are one: so the gaze need not be known.
        let across_rate = spec.across_rate.filter(|&rate| rate != spec.translation_rate);
        let rates = [Some(spec.translation_rate), across_rate, Some(spec.rotation_rate)];
        let rates = rates.map(|rate| rate.map(f64::to_bits));
        let flyer = *flyers.entry(rates).or_insert_with(|| {
            self.flyers.push(body);
            (self.flyers.len() - 1) as u32
        });
        let first = self.disks.len();
        let shown = match (spec.disks.first(), spec.disks.last()) {
            (Some(left), Some(right)) => shown_orientation(left.position, right.position),
            _ => 0.0,
        };
        let back = rotation(-shown);
        self.disks.extend(spec.disks.iter().map(|disk| ContactDisk {
            body,
            radius: disk.radius,
            offset: back * disk.position,
            material: disk.material,
        }));
        let disks = first..self.disks.len();
        let own = &self.disks[disks.clone()];
        self.bodies.push(Body {
            mass: spec.mass,
            inertia: spec.inertia,
            inverse_mass: 1.0 / spec.mass,
            inverse_inertia: 1.0 / spec.inertia,
            translation_rate: spec.translation_rate,
            across_rate,
            rotation_rate: spec.rotation_rate,
            flyer,
            bounding_radius: own.iter().map(|disk| disk.offset.norm() + disk.radius).fold(0.0, f64::max),
            reach: own.iter().map(|disk| disk.offset.norm()).fold(0.0, f64::max),
            extent: levels::extent(own.iter()).unwrap_or_default(),
            disks,
        });
    }

    /// The corners of a wall that is absent have no faces, so nothing is joined there.
    fn add_wall(&mut self, wall: WallId, places: &mut Places, present: bool) {
        let spec = &self.walls[wall.index()];
        let first_face = self.faces.len();
        let heights = self.levels.as_ref().map_or(0, |levels| places.place_of(levels.of_wall(wall.index())));
        for ends in spec.corners.windows(2) {
            let face = FaceId::from(self.faces.len());
            let [start_corner, end_corner] = [ends[0], ends[1]].map(|position| {
                if !present {
                    self.corners.push(Corner::new(position));
                    return CornerId::from(self.corners.len() - 1);
                }
                let at = places.corner_at(position, heights, &mut self.corners);
                let faces = &mut self.corners[at].faces;
                if faces.last() != Some(&face) {
                    faces.push(face);
                }
                CornerId::from(at)
            });
            let [start, end] = [start_corner, end_corner].map(|at| self.corners[at.index()].position);
            self.faces.push(Face {
                wall,
                material: spec.material,
                start,
                end,
                start_corner,
                end_corner,
                normal: across(start, end),
                line: LineId::from(face.index()),
                before: Continuation::None,
                after: Continuation::None,
            });
        }
        self.wall_faces.push(first_face..self.faces.len());
    }

    /// Finds which faces are one line, which corners are covered, and which face owns each corner.
    fn join_faces(&mut self) {
        self.joined = vec![Vec::new(); self.faces.len()];
        for at in 0..self.corners.len() {
            self.join_at_corner(CornerId::from(at));
        }
        self.find_doubled();
        for at in 0..self.corners.len() {
            let goes_on = |face: &&FaceId| {
                self.faces[face.index()].continuation(CornerId::from(at)) != Continuation::None
            };
            let corner = &self.corners[at];
            let owner = corner.faces.iter().find(goes_on).or(corner.faces.first());
            self.corners[at].owner = owner.copied().unwrap_or(corner.owner);
        }
        // Faces that are joined, directly or by others, are one line: that of the first of them.
        for face in 0..self.faces.len() {
            let line = LineId::from(face);
            let mut found = vec![FaceId::from(face)];
            while let Some(next) = found.pop().filter(|_| self.faces[face].line == line) {
                for &other in &self.joined[next.index()] {
                    let of_other = &mut self.faces[other.index()].line;
                    if *of_other > line {
                        *of_other = line;
                        found.push(other);
                    }
                }
            }
        }
    }

    /// Joins the faces that meet at a corner: each with the one that continues it best, if both agree.
    fn join_at_corner(&mut self, at: CornerId) {
        // By direction, so that the opposite one is found in a corner of many faces, too.
        let mut ends: Vec<(f64, FaceId, Vec2)> = self.corners[at.index()]
            .faces
            .iter()
            .filter_map(|&face| {
                let away = self.faces[face.index()].away_from(at)?;
                Some((libm::atan2(away.y, away.x), face, away))
            })
            .collect();
        ends.sort_by(|one, other| one.0.total_cmp(&other.0).then(one.1.cmp(&other.1)));
        let count = ends.len();
        let opposite = |k: usize| {
            let angle = ends[k].0 + if ends[k].0 > 0.0 { -PI } else { PI };
            let next = ends.partition_point(|end| end.0 < angle);
            // The first of those with the same direction as the one before.
            let before = ends[(next + count - 1) % count].0;
            let first = ends.partition_point(|end| end.0 < before);
            let turn = |j: &usize| ends[k].2.dot(&ends[*j].2);
            [next % count, first].into_iter().min_by(|a, b| turn(a).total_cmp(&turn(b))).unwrap_or(k)
        };
        for k in 0..count {
            let j = opposite(k);
            let ((_, one, away), (_, other, back)) = (ends[k], ends[j]);
            let turn = away.dot(&back);
            if turn <= -LINE && one < other && opposite(j) == k {
                let straight = (away + back).norm() <= STRAIGHT;
                let how = if straight { Continuation::Straight } else { Continuation::Bend };
                for face in [one, other] {
                    *self.faces[face.index()].continuation_mut(at) = how;
                }
                self.join(one, other);
            }
        }
    }

    /// Joins faces that lie on each other, and finds the corners that another face covers.
    fn find_doubled(&mut self) {
        let mut same: HashMap<[CornerId; 2], FaceId> = HashMap::new();
        for (at, face) in self.faces.iter().enumerate() {
            let mut ends = [face.start_corner, face.end_corner];
            ends.sort_unstable();
            let first = *same.entry(ends).or_insert(FaceId::from(at));
            if first.index() != at && face.normal != Vec2::zeros() {
                self.doubled.push((first, FaceId::from(at)));
            }
        }
        // Both are equally near to a disk but for rounding, which must not choose the material.
        for &(first, other) in &self.doubled {
            self.faces[other.index()].material = self.faces[first.index()].material;
        }
        let mut scratch = Vec::new();
        for at in 0..self.corners.len() {
            let place = Circle { centre: self.corners[at].position, radius: 0.0 };
            let found = self.face_grid.candidates(&place, SAME_POINT, &mut scratch);
            let passes = |through: &FaceId| {
                let (nearest, along) = nearest_on_face(&self.faces[through.index()], place.centre);
                along == Along::Inside
                    && (nearest - place.centre).norm() <= SAME_POINT
                    && self.corners[at].faces.first().is_none_or(|end| self.same_heights(*end, *through))
            };
            let ends = &self.corners[at].faces;
            let through: Vec<FaceId> =
                found.iter().copied().filter(|face| passes(face) && !ends.contains(face)).collect();
            for end in ends {
                let Some(away) = self.faces[end.index()].away_from(CornerId::from(at)) else { continue };
                // Of those on which it lies, the one that goes furthest beside it touches whatever both the others and
                // it touch: by such pairs all are joined, and there are at most two of each face, and one of its copy.
                let mut furthest: Option<(f64, FaceId)> = None;
                for &other in &through {
                    let face = &self.faces[other.index()];
                    let goes = |to: Vec2| (to - place.centre).dot(&away);
                    let far = goes(face.start).max(goes(face.end));
                    if face.normal.dot(&away).abs() <= STRAIGHT && furthest.is_none_or(|(most, _)| far > most)
                    {
                        furthest = Some((far, other));
                    }
                }
                self.doubled.extend(furthest.map(|(_, other)| (*end.min(&other), *end.max(&other))));
            }
            self.corners[at].covered |= !through.is_empty();
        }
        self.doubled.sort_unstable();
        self.doubled.dedup();
        for (one, other) in self.doubled.clone() {
            self.join(one, other);
        }
    }

    /// Whether the walls of two faces have the same heights.
    pub(super) fn same_heights(&self, one: FaceId, other: FaceId) -> bool {
        let wall = |face: FaceId| self.faces[face.index()].wall.index();
        self.levels.as_ref().is_none_or(|levels| levels.of_wall(wall(one)) == levels.of_wall(wall(other)))
    }

    fn join(&mut self, one: FaceId, other: FaceId) {
        self.joined[one.index()].push(other);
        self.joined[other.index()].push(one);
    }

    /// Returns the law of two materials.
    #[inline]
    pub fn law(&self, first: usize, second: usize) -> &PairLaw {
        self.law_at(self.law_between(first, second))
    }

    /// Returns the index of the law of two materials.
    #[inline]
    pub(super) fn law_between(&self, first: usize, second: usize) -> u32 {
        (first * self.laws.materials + second) as u32
    }

    /// Returns the law at an index.
    #[inline]
    pub(super) fn law_at(&self, place: u32) -> &PairLaw {
        &self.laws.laws[place as usize]
    }

    /// Returns the laws, in the order of their indices.
    pub(super) fn all_laws(&self) -> &[PairLaw] {
        &self.laws.laws
    }

    /// Returns the body of a disk.
    #[inline]
    pub fn body_of(&self, disk: DiskId) -> BodyId {
        self.disks[disk.index()].body
    }
}

/// Finds the corner at a place.
#[derive(Default)]
struct Places {
    /// Corners by cells of [`SAME_POINT`], and by the heights of their walls.
    cells: HashMap<[u64; 3], usize>,
    heights: Vec<Heights>,
}

impl Places {
    /// Returns a number for some heights.
    fn place_of(&mut self, heights: &Heights) -> u64 {
        let known = self.heights.iter().position(|known| known == heights);
        let at = known.unwrap_or_else(|| {
            self.heights.push(*heights);
            self.heights.len() - 1
        });
        at as u64
    }

    /// Returns the index of the corner at a place; a new one if there is none.
    fn corner_at(&mut self, position: Vec2, heights: u64, corners: &mut Vec<Corner>) -> usize {
        // + 0.0 makes −0 and 0 the same key.
        let cell = |x: f64, beside: f64| ((x / SAME_POINT).floor() + beside + 0.0).to_bits();
        let near = [0.0, -1.0, 1.0].into_iter().flat_map(|dx| [0.0, -1.0, 1.0].map(|dy| (dx, dy)));
        for (dx, dy) in near {
            let found = self.cells.get(&[cell(position.x, dx), cell(position.y, dy), heights]);
            if let Some(&at) = found.filter(|&&at| (corners[at].position - position).norm() <= SAME_POINT) {
                return at;
            }
        }
        let at = corners.len();
        self.cells.insert([cell(position.x, 0.0), cell(position.y, 0.0), heights], at);
        corners.push(Corner::new(position));
        at
    }
}

/// Returns the unit vector to the left of the direction from one point to another; zero if the points are equal.
fn across(from: Vec2, to: Vec2) -> Vec2 {
    let along = to - from;
    let length = libm::hypot(along.x, along.y);
    if length > 0.0 { (along * (1.0 / length)).left() } else { Vec2::zeros() }
}

#[cfg(test)]
mod tests;
