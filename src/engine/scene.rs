//! What is constant in time: bodies, disks, walls and the contact laws between materials.

use super::face::Face;
use super::face_grid::FaceGrid;
use super::{BodyId, CornerId, DiskId, FaceId, LineId, Rotation, Vec2, WallId};
use lemons_plane::shown_orientation;
use std::collections::HashMap;
use std::ops::Range;
use thiserror::Error;

/// The properties of a body, for [`Scene::new`].
#[derive(Debug, Clone, PartialEq)]
pub struct BodySpec {
    /// \[kg\] positive.
    pub mass: f64,
    /// \[kg.m2\] moment of inertia about the centre of mass, positive.
    pub inertia: f64,
    /// \[1/s\] relaxation rate of the velocity, 1/t_transl ≥ 0.
    pub translation_rate: f64,
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

/// The contact law of every pair of materials; `None` where none is defined.
#[derive(Debug, Clone, PartialEq)]
pub struct LawTable {
    materials: usize,
    laws: Vec<Option<PairLaw>>,
}

impl LawTable {
    /// A table for this number of materials, without laws.
    pub fn new(materials: usize) -> LawTable {
        LawTable { materials, laws: vec![None; materials * materials] }
    }

    /// Sets the law of two materials, in either order.
    pub fn set(&mut self, first: usize, second: usize, law: PairLaw) {
        self.laws[first * self.materials + second] = Some(law);
        self.laws[second * self.materials + first] = Some(law);
    }

    /// The law of two materials.
    pub fn get(&self, first: usize, second: usize) -> Option<PairLaw> {
        self.laws[first * self.materials + second]
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
    /// \[1/s\]
    pub rotation_rate: f64,
    /// Bodies with the same two relaxation rates share a flight: its place in [`Scene::flyers`].
    pub(super) flyer: u32,
    /// Its disks, as places in [`Scene::disks`].
    pub disks: Range<usize>,
    /// \[m\] radius of the circle about the centre of mass that contains every disk.
    pub bounding_radius: f64,
    /// \[m\] distance of the farthest disk's centre from the centre of mass.
    pub reach: f64,
}

/// A disk of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct Disk {
    /// The owner.
    pub body: BodyId,
    /// \[m\]
    pub radius: f64,
    /// \[m\] from the centre of mass when the body's orientation is zero.
    pub offset: Vec2,
    /// Place in the table of laws.
    pub material: usize,
}

/// \[rad\] Consecutive faces whose directions differ by at most this much count as straight.
const STRAIGHT: f64 = 1e-6;

/// A point where faces of one wall meet, or where a wall ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Corner {
    /// \[m\]
    pub position: Vec2,
    /// The faces that meet here, ascending. Contacts with the corner are assigned to the first.
    pub faces: Vec<FaceId>,
}

/// Bodies, walls and laws: immutable after load.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// In the order of the agents.
    pub bodies: Vec<Body>,
    /// Grouped by body.
    pub disks: Vec<Disk>,
    /// One body for each pair of relaxation rates that occurs.
    pub(super) flyers: Vec<BodyId>,
    /// Grouped by wall.
    pub faces: Vec<Face>,
    /// First face of each wall.
    pub wall_faces: Vec<Range<usize>>,
    /// Of all walls.
    pub corners: Vec<Corner>,
    laws: Vec<PairLaw>,
    materials: usize,
    pub(super) face_grid: FaceGrid,
}

/// Why a scene cannot be built.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SceneError {
    /// Two materials can touch but have no contact law.
    #[error("materials {first} and {second} can touch but have no law")]
    MissingLaw {
        /// Place of the first material.
        first: usize,
        /// Place of the second material.
        second: usize,
    },
    /// There are more disks or faces than an index can represent.
    #[error("too many {0}")]
    TooMany(&'static str),
}

impl Scene {
    /// Builds the scene.
    ///
    /// # Errors
    /// A pair of materials that can touch has no law.
    pub fn new(bodies: &[BodySpec], walls: &[WallSpec], laws: &LawTable) -> Result<Scene, SceneError> {
        let mut scene = Scene {
            bodies: Vec::with_capacity(bodies.len()),
            disks: Vec::with_capacity(bodies.iter().map(|body| body.disks.len()).sum()),
            flyers: Vec::new(),
            faces: Vec::new(),
            wall_faces: Vec::with_capacity(walls.len()),
            corners: Vec::new(),
            laws: Vec::new(),
            materials: laws.materials,
            face_grid: FaceGrid::default(),
        };
        let mut flyers = HashMap::new();
        for spec in bodies {
            scene.add_body(spec, &mut flyers);
        }
        for spec in walls {
            scene.add_wall(spec);
        }
        scene.face_grid = FaceGrid::new(&scene.faces);
        if scene.disks.len() > u32::MAX as usize || scene.faces.len() > u32::MAX as usize {
            return Err(SceneError::TooMany("disks or faces"));
        }
        check_laws(bodies, walls, laws)?;
        // Pairs that cannot touch never use their law, so any value will do.
        let never = PairLaw {
            normal_stiffness: f64::NAN,
            tangential_stiffness: f64::NAN,
            normal_damping: f64::NAN,
            tangential_damping: f64::NAN,
            friction: f64::NAN,
        };
        scene.laws = laws.laws.iter().map(|law| law.unwrap_or(never)).collect();
        Ok(scene)
    }

    /// `flyers` maps the bits of the rates to indices in [`Scene::flyers`].
    fn add_body(&mut self, spec: &BodySpec, flyers: &mut HashMap<[u64; 2], u32>) {
        let body = BodyId::from(self.bodies.len());
        let rates = [spec.translation_rate, spec.rotation_rate].map(f64::to_bits);
        let flyer = *flyers.entry(rates).or_insert_with(|| {
            self.flyers.push(body);
            (self.flyers.len() - 1) as u32
        });
        let first = self.disks.len();
        let shown = match (spec.disks.first(), spec.disks.last()) {
            (Some(left), Some(right)) => shown_orientation(left.position, right.position),
            _ => 0.0,
        };
        let back = Rotation::by(-shown);
        self.disks.extend(spec.disks.iter().map(|disk| Disk {
            body,
            radius: disk.radius,
            offset: disk.position.rotated(back),
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
            rotation_rate: spec.rotation_rate,
            flyer,
            bounding_radius: own.iter().map(|disk| disk.offset.norm() + disk.radius).fold(0.0, f64::max),
            reach: own.iter().map(|disk| disk.offset.norm()).fold(0.0, f64::max),
            disks,
        });
    }

    fn add_wall(&mut self, spec: &WallSpec) {
        let wall = WallId::from(self.wall_faces.len());
        let first_face = self.faces.len();
        let first_corner = self.corners.len();
        let mut known = HashMap::new();
        for ends in spec.corners.windows(2) {
            let face = FaceId::from(self.faces.len());
            let mut corner = |position: Vec2| {
                // + 0.0 makes −0 and 0 the same key.
                let key = ((position.x + 0.0).to_bits(), (position.y + 0.0).to_bits());
                let at = *known.entry(key).or_insert_with(|| {
                    self.corners.push(Corner { position, faces: Vec::new() });
                    self.corners.len() - 1
                });
                self.corners[at].faces.push(face);
                CornerId::from(at)
            };
            let (start_corner, end_corner) = (corner(ends[0]), corner(ends[1]));
            self.faces.push(Face {
                wall,
                material: spec.material,
                start: ends[0],
                end: ends[1],
                start_corner,
                end_corner,
                normal: across(ends[0], ends[1]),
                line: LineId::from(face.index()),
                straight_before: false,
                straight_after: false,
            });
        }
        self.join_lines(first_face);
        debug_assert!(self.corners[first_corner..].iter().all(|corner| corner.faces.is_sorted()));
        self.wall_faces.push(first_face..self.faces.len());
    }

    /// Finds where successive faces of the last wall continue straight.
    fn join_lines(&mut self, first: usize) {
        for face in first + 1..self.faces.len() {
            if self.goes_on(face - 1, face) {
                self.faces[face].line = self.faces[face - 1].line;
            }
        }
        // A closed wall of two faces goes back along itself.
        let Some(last) = self.faces.len().checked_sub(1).filter(|last| *last > first + 1) else { return };
        if self.goes_on(last, first) {
            let (from, to) = (self.faces[last].line, self.faces[first].line);
            self.faces[first..].iter_mut().filter(|face| face.line == from).for_each(|face| face.line = to);
        }
    }

    /// Notes if a face continues straight into another that begins where it ends, and no third face begins there.
    fn goes_on(&mut self, before: usize, after: usize) -> bool {
        let (one, other) = (&self.faces[before], &self.faces[after]);
        let straight = one.end_corner == other.start_corner
            && self.corners[one.end_corner.index()].faces.len() == 2
            && (one.normal - other.normal).norm() <= STRAIGHT
            && one.normal != Vec2::ZERO;
        self.faces[before].straight_after = straight;
        self.faces[after].straight_before = straight;
        straight
    }

    /// Returns the law of two materials.
    #[inline]
    pub fn law(&self, first: usize, second: usize) -> &PairLaw {
        self.law_at(self.law_between(first, second))
    }

    /// Returns the index of the law of two materials.
    #[inline]
    pub(super) fn law_between(&self, first: usize, second: usize) -> u32 {
        (first * self.materials + second) as u32
    }

    /// Returns the law at an index.
    #[inline]
    pub(super) fn law_at(&self, place: u32) -> &PairLaw {
        &self.laws[place as usize]
    }

    /// Returns the body of a disk.
    #[inline]
    pub fn body_of(&self, disk: DiskId) -> BodyId {
        self.disks[disk.index()].body
    }
}

/// The unit vector to the left of the direction from one point to another; zero if the points are equal.
fn across(from: Vec2, to: Vec2) -> Vec2 {
    let along = to - from;
    let length = libm::hypot(along.x, along.y);
    if length > 0.0 { (along * (1.0 / length)).perp() } else { Vec2::ZERO }
}

fn check_laws(bodies: &[BodySpec], walls: &[WallSpec], laws: &LawTable) -> Result<(), SceneError> {
    /// The bodies that have a material: only whether two different bodies do.
    #[derive(Clone, Copy, PartialEq)]
    enum Carriers {
        None,
        One(usize),
        Many,
    }
    let mut carriers = vec![Carriers::None; laws.materials];
    for (body, spec) in bodies.iter().enumerate() {
        for disk in &spec.disks {
            let seen = &mut carriers[disk.material];
            *seen = match *seen {
                Carriers::None => Carriers::One(body),
                Carriers::One(same) if same == body => Carriers::One(body),
                _ => Carriers::Many,
            };
        }
    }
    let mut on_walls = vec![false; laws.materials];
    for wall in walls {
        on_walls[wall.material] = true;
    }
    for first in 0..laws.materials {
        for second in first..laws.materials {
            let (a, b) = (carriers[first], carriers[second]);
            let bodies_touch = a != Carriers::None
                && b != Carriers::None
                && !matches!((a, b), (Carriers::One(x), Carriers::One(y)) if x == y);
            let wall_touches =
                (a != Carriers::None && on_walls[second]) || (b != Carriers::None && on_walls[first]);
            if (bodies_touch || wall_touches) && laws.get(first, second).is_none() {
                return Err(SceneError::MissingLaw { first, second });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::vec2;
    use super::*;

    #[test]
    fn closed_wall_shares_its_first_corner() {
        let corners = vec![vec2(0.0, 0.0), vec2(1.0, 0.0), vec2(1.0, 1.0), vec2(-0.0, 0.0)];
        let scene = Scene::new(&[], &[WallSpec { material: 0, corners }], &LawTable::new(1)).unwrap();
        assert_eq!(scene.corners.len(), 3);
        assert_eq!(scene.corners[0].faces, vec![FaceId(0), FaceId(2)]);
    }

    #[test]
    fn straight_faces_are_of_one_line() {
        let lines = |corners: &[(f64, f64)]| {
            let corners = corners.iter().map(|&(x, y)| vec2(x, y)).collect();
            let scene = Scene::new(&[], &[WallSpec { material: 0, corners }], &LawTable::new(1)).unwrap();
            scene.faces.iter().map(|face| face.line.index()).collect::<Vec<_>>()
        };
        assert_eq!(lines(&[(0.0, 0.0), (1.0, 0.0), (2.5, 0.0), (2.5, 1.0), (2.5, 7.0)]), [0, 0, 2, 2]);
        // Closed in the middle of a side.
        let square = [(0.5, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0), (0.5, 0.0)];
        assert_eq!(lines(&square), [0, 1, 2, 3, 0]);
        // A bend of 2e-6 rad is a bend, one of 5e-7 rad is none.
        assert_eq!(lines(&[(0.0, 0.0), (1.0, 0.0), (2.0, 2e-6)]), [0, 1]);
        assert_eq!(lines(&[(0.0, 0.0), (1.0, 0.0), (2.0, 5e-7)]), [0, 0]);
        // There and back, and a third face at the corner.
        assert_eq!(lines(&[(0.0, 0.0), (1.0, 0.0), (0.0, 0.0)]), [0, 1]);
        assert_eq!(lines(&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 0.0), (1.0, 1.0)]), [0, 1, 2, 3]);
    }

    #[test]
    fn a_missing_law_is_named() {
        let body = |material| BodySpec {
            mass: 1.0,
            inertia: 1.0,
            translation_rate: 0.0,
            rotation_rate: 0.0,
            disks: vec![DiskSpec { radius: 0.1, position: Vec2::ZERO, material }],
        };
        let error = Scene::new(&[body(0), body(1)], &[], &LawTable::new(2)).unwrap_err();
        assert_eq!(error, SceneError::MissingLaw { first: 0, second: 1 });
        assert!(Scene::new(&[body(0)], &[], &LawTable::new(2)).is_ok());
    }
}
