//! Figures: an agent in three dimensions, standing or seated, with the things that go along.
//!
//! A seated body is the standing one with bent knees and elbows: simple, an assumption. Things are the plain solids of
//! `data/kinds.toml`. Closed surfaces may overlap here: thighs begin within the trunk, wheels in their axles.

use super::{Body3d, BodySlice, MeshPart};
use crate::anthropometry::ansur;
use crate::bicycle::{Bicycle, PAPER_BICYCLES};
use crate::error::Result;
use crate::growth::child;
use crate::kinds::{KindPart, Kinds, PartOrigin, PersonKind, Solid};
use crate::materials::PART_MATERIALS;
use crate::person::{Person, Sex};
use crate::population::CrowdMember;
use crate::shape::{Shape, bounds};
use lemons_core::plane::{Disk, Pose, Vec2, rotation, vec2};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::{Arc, LazyLock};

/// Height of the middle of the knees by the stature (ANSUR II: 0.277).
const KNEES: f64 = 0.277;
/// Height of the elbows of somebody who stands, by the stature (assumption).
const ELBOWS: f64 = 0.63;
/// \[rad\] Angle by which the elbows of somebody who is seated are bent (assumption).
const BENT: f64 = 1.3;
/// Sides of a round solid.
const SIDES: usize = 24;

/// An agent in three dimensions, in its frame: origin at the centre of mass, on the floor; gaze along +x, left is +y.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Figure {
    kind: Option<Arc<PersonKind>>,
    /// The bodies, standing, and their places \[m\].
    people: Vec<(Body3d, Vec2)>,
    /// \[m\] Where the solids of each part of the kind are measured from.
    origins: Vec<Vec2>,
}

impl Figure {
    /// Makes the figure of an agent.
    ///
    /// # Errors
    /// As those of [`Body3d::similar`].
    pub fn of(agent: &CrowdMember) -> Result<Figure> {
        match agent {
            CrowdMember::Pedestrian(person) => Figure::new(None, &[(*person, Vec2::zeros())]),
            CrowdMember::Member(member) => Figure::new(Some(member.kind.clone()), &member.people),
        }
    }

    /// Makes a figure that fits an agent of a Trial: of [`people_fitting`], or, of no kind that there is, of
    /// [`person_fitting`].
    ///
    /// # Errors
    /// No body fits the disks.
    pub fn fitting(agent: &lemons_core::trial::Agent) -> Result<Figure> {
        match people_fitting(agent) {
            Some((kind, people)) => Figure::new(Some(kind), &people),
            None => Figure::new(None, &[(person_fitting(agent), Vec2::zeros())]),
        }
    }

    fn new(kind: Option<Arc<PersonKind>>, people: &[(Person, Vec2)]) -> Result<Figure> {
        let mut origins = Vec::new();
        if let (Some(kind), Some((person, at))) = (&kind, people.first()) {
            let (front, back) = Shape::fit(person.breadth, person.depth).ends();
            origins.extend(kind.parts.iter().map(|part| match part.from {
                PartOrigin::Centre => *at,
                PartOrigin::Front => *at + vec2(front, 0.0),
                PartOrigin::Back => *at + vec2(back, 0.0),
            }));
        }
        let body = |(person, at): &(Person, Vec2)| Ok((Body3d::similar(person)?, *at));
        Ok(Figure { kind, people: people.iter().map(body).collect::<Result<_>>()?, origins })
    }

    /// Returns the height \[m\] of the seat of somebody who is seated.
    fn seat(&self) -> Option<f64> {
        self.kind.as_ref().filter(|kind| kind.seated).map(|kind| kind.seat)
    }

    /// Returns the bodies with their places \[m\], and how much \[m\] higher than those of who stands their trunks are.
    pub(crate) fn trunks(&self) -> impl Iterator<Item = (&Body3d, Vec2, f64)> {
        let raised = |body: &Body3d| self.seat().map_or(0.0, |seat| seat - body.rings[0][0].z);
        self.people.iter().map(move |(body, at)| (body, *at, raised(body)))
    }

    /// Returns the parts of the kind, with where they are measured from \[m\], and their lowest and highest place \[m\].
    pub(crate) fn parts(&self) -> impl Iterator<Item = (&KindPart, Vec2, [f64; 2])> {
        let parts = self.kind.iter().flat_map(|kind| &kind.parts).zip(&self.origins);
        parts.map(|(part, origin)| (part, *origin, extent(&solids(part))))
    }

    /// Returns the lowest and the highest place \[m\] of the bicycle, if somebody rides one.
    pub(crate) fn bicycle(&self) -> Option<[f64; 2]> {
        let kind = self.kind.as_ref().filter(|kind| kind.bicycle)?;
        Some(extent(&kind.solids.iter().map(solid).collect::<Vec<_>>()))
    }

    /// Returns the closed parts of the bodies: all, or less fine ones to be looked at ([`Body3d::coarse_mesh`]).
    pub fn bodies(&self, fine: bool) -> Vec<MeshPart> {
        let mut all = Vec::new();
        for (k, (body, at)) in self.people.iter().enumerate() {
            let mut parts = if fine { body.mesh() } else { body.coarse_mesh() };
            if let Some(seat) = self.seat() {
                sit(&mut parts, body.person.stature, seat);
            }
            for part in &mut parts {
                if k > 0 {
                    part.name = format!("child_{}", part.name);
                }
                shift(part, *at);
            }
            all.extend(parts);
        }
        all
    }

    /// Returns the closed parts of things.
    pub fn things(&self) -> Vec<MeshPart> {
        let parts = self.kind.iter().flat_map(|kind| &kind.parts).zip(&self.origins);
        let moved = |(part, origin): (&KindPart, &Vec2)| {
            let mut solids = solids(part);
            solids.iter_mut().for_each(|solid| shift(solid, *origin));
            solids
        };
        let bicycle = self.kind.iter().flat_map(|kind| named("bicycle", kind.solids.iter().map(solid)));
        bicycle.chain(parts.flat_map(moved)).collect()
    }

    /// Returns the outlines of the people who stand, at an altitude \[m\]; of who sits and of things there are none.
    pub fn slice_at(&self, altitude: f64) -> Vec<BodySlice> {
        let standing = self.people.iter().filter(|_| self.seat().is_none());
        let placed = |(body, at): &(Body3d, Vec2)| {
            let pose = Pose { position: *at, orientation: 0.0 };
            body.slice_at(altitude).into_iter().map(move |polygon| polygon.at(&pose))
        };
        standing.flat_map(placed).collect()
    }

    /// Returns all parts at a pose, in world coordinates; the names begin with the agent's Id.
    pub fn surfaces(&self, id: &str, pose: &Pose) -> impl Iterator<Item = MeshPart> + use<> {
        let (turn, position, id) = (rotation(pose.orientation), pose.position, plain(id));
        self.bodies(true).into_iter().chain(self.things()).map(move |mut part| {
            for [x, y, _] in &mut part.vertices {
                let point = turn * vec2(*x, *y) + position;
                (*x, *y) = (point.x, point.y);
            }
            MeshPart { name: format!("agent_{id}_{}", part.name), ..part }
        })
    }
}

/// Names in files have letters, digits and underscores.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect()
}

/// People of one body, with their places \[m\].
pub type PlacedPeople = Vec<(Person, Vec2)>;

/// \[m\] Stature of somebody whose height is not known.
const USUAL_STATURE: f64 = 1.75;

/// A person whose measures fit an agent of a Trial: the extents of its disks, without those of things that go along,
/// are breadth and depth, in levels those of the broadest one; of somebody who has none, those of the mean man. The
/// sex cannot be known: it is taken for a man.
pub fn person_fitting(agent: &lemons_core::trial::Agent) -> Person {
    let stature = agent.height.unwrap_or(USUAL_STATURE);
    let disks = agent.disks_facing_x().into_iter().zip(&agent.shapes);
    let own = disks.filter(|(_, shape)| !PART_MATERIALS.contains(&&*shape.material_id));
    let own: Vec<_> = own.map(|((centre, radius), shape)| (Disk { radius, centre }, shape.heights)).collect();
    let levels = own.iter().map(|(_, heights)| {
        bounds(own.iter().filter(|(_, other)| other == heights).map(|(disk, _)| *disk)).size()
    });
    let broadest = levels.max_by(|one, other| one.y.total_cmp(&other.y));
    let [breadth, depth, ..] = ansur(Sex::Male).measures.each_ref().map(|measure| measure.mean);
    let size = broadest.unwrap_or(vec2(depth, breadth));
    let (depth, breadth) = (size.x, size.y);
    Person { sex: Sex::Male, breadth, depth: depth.min(breadth), stature, mass: agent.mass }
}

/// Returns the kind of an agent of a Trial, and the people that fit its disks, with their places \[m\]: the person, whose
/// measures are those of [`person_fitting`], and a child at its hand. `None` if there is no such kind, or if the disks are
/// not those of the kind.
pub fn people_fitting(agent: &lemons_core::trial::Agent) -> Option<(Arc<PersonKind>, PlacedPeople)> {
    static KINDS: LazyLock<Option<Kinds>> = LazyLock::new(|| Kinds::built_in().ok());
    let kind = KINDS.as_ref()?.get(agent.kind.as_ref()?)?;
    Some((kind.clone(), people_of(kind, agent)?))
}

fn people_of(kind: &PersonKind, agent: &lemons_core::trial::Agent) -> Option<PlacedPeople> {
    let disks = agent.disks_facing_x().into_iter().zip(&agent.shapes);
    let (things, own): (Vec<_>, Vec<_>) =
        disks.partition(|(_, shape)| PART_MATERIALS.contains(&&*shape.material_id));
    let [things, own] = [things, own].map(|disks| {
        disks.into_iter().map(|((centre, radius), _)| Disk { radius, centre }).collect::<Vec<Disk>>()
    });
    let carried: f64 = kind.parts.iter().map(|part| part.mass.quantile(0.5)).sum();
    let fitting = person_fitting(agent);
    let mass = (agent.mass - carried).max(0.5 * agent.mass);
    if kind.bicycle {
        if things.is_empty() || own.len() < 2 * Bicycle::ACROSS {
            return None;
        }
        // The rider's own measures are not in the disks.
        let [breadth, depth, ..] = ansur(Sex::Male).measures.each_ref().map(|measure| measure.mean);
        let mass = (agent.mass - PAPER_BICYCLES[4].mean).max(0.5 * agent.mass);
        return Some(vec![(Person { breadth, depth, mass, ..fitting }, Vec2::zeros())]);
    }
    if kind.seated {
        let first = kind.parts.first()?.disks.first()?;
        let at = things.first()?.centre - vec2(first[0], first[1]);
        let all = kind.parts.iter().map(|part| part.disks.len()).sum::<usize>();
        return (all == things.len() && own.is_empty()).then(|| vec![(Person { mass, ..fitting }, at)]);
    }
    let of = |disks: &[Disk], person: Person| {
        let size = bounds(disks.iter().copied()).size();
        let person = Person { breadth: size.y, depth: size.x.min(size.y), ..person };
        let shape = Shape::fit(person.breadth, person.depth);
        (person, disks[0].centre - shape.disks[0].centre)
    };
    match (kind.companion, own.len()) {
        (None, 5) => Some(vec![of(&own, Person { mass, ..fitting })]),
        // The child is between the first disk of the adult and the others.
        (Some([from, to]), 10) => {
            let small = of(&own[1..6], fitting);
            let ages =
                (0..=100).map(|k| child(Sex::Female, from + 0.01 * f64::from(k) * (to - from), [0.0; 2]));
            let off = |one: &Person| (one.breadth - small.0.breadth).abs();
            let like = ages.min_by(|one, other| off(one).total_cmp(&off(other)))?;
            let beside = (Person { breadth: small.0.breadth, depth: small.0.depth, ..like }, small.1);
            let adult = [&own[..1], &own[6..]].concat();
            let mass = (agent.mass - like.mass).max(0.5 * agent.mass);
            Some(vec![of(&adult, Person { mass, ..fitting }), beside])
        }
        _ => None,
    }
}

/// \[m\] The lowest and the highest place of parts, not below the floor.
fn extent(parts: &[MeshPart]) -> [f64; 2] {
    let heights = parts.iter().flat_map(|part| &part.vertices).map(|place| place[2]);
    heights.fold([f64::MAX, 0.0], |[low, high], z| [low.min(z.max(0.0)), high.max(z)])
}

fn shift(part: &mut MeshPart, by: Vec2) {
    for [x, y, _] in &mut part.vertices {
        (*x, *y) = (*x + by.x, *y + by.y);
    }
}

/// Bends the parts of a standing body, in the order of [`super::BodyPart::ALL`], so that it sits at a height \[m\].
fn sit(parts: &mut [MeshPart], stature: f64, seat: f64) {
    let [trunk, arms @ .., left, right] = parts else { return };
    let low = trunk.vertices.iter().fold(f64::MAX, |low, place| low.min(place[2]));
    let size = stature / 1.75;
    for part in std::iter::once(trunk).chain(arms.iter_mut()) {
        part.vertices.iter_mut().for_each(|place| place[2] += seat - low);
    }
    for arm in arms {
        let elbow = ELBOWS * stature + seat - low;
        let Limb { top, axis, .. } = Limb::of(arm);
        Bend { start: vec2(axis, top), straight: top - elbow, radius: 0.06 * size, down: true, angle: BENT }
            .apply(arm);
    }
    for leg in [left, right] {
        let Limb { top, axis, back } = Limb::of(leg);
        // The back of the thighs lies on the seat.
        let (start, straight) = (vec2(axis, seat + back), top - KNEES * stature);
        Bend { start, straight, radius: 0.085 * size, down: false, angle: FRAC_PI_2 }.apply(leg);
    }
}

/// A hanging limb.
struct Limb {
    /// \[m\] Its highest place.
    top: f64,
    /// \[m\] x of its middle there.
    axis: f64,
    /// \[m\] How far it reaches behind.
    back: f64,
}

impl Limb {
    fn of(part: &MeshPart) -> Limb {
        let top = part.vertices.iter().fold(f64::MIN, |top, place| top.max(place[2]));
        let near = |depth: f64| {
            part.vertices.iter().filter(move |place| place[2] > top - depth).map(|place| place[0])
        };
        let (low, high) = near(0.05).fold((f64::MAX, f64::MIN), |(low, high), x| (low.min(x), high.max(x)));
        let axis = 0.5 * (low + high);
        Limb { top, axis, back: axis - near(0.2).fold(f64::MAX, f64::min) }
    }
}

/// A bend of a limb in the plane of x and z, ahead: its axis begins at a place, downwards or ahead, and turns after a
/// straight piece.
struct Bend {
    /// \[m\] x and z.
    start: Vec2,
    /// \[m\] Along the axis to the middle of the bend.
    straight: f64,
    /// \[m\] Of the axis, in the bend.
    radius: f64,
    /// Whether the axis begins downwards and then goes ahead, as that of an arm.
    down: bool,
    /// \[rad\]
    angle: f64,
}

impl Bend {
    fn apply(&self, part: &mut MeshPart) {
        let Limb { top, axis, .. } = Limb::of(part);
        let Bend { start, straight, radius, down, angle } = *self;
        // The directions of the axis, and of what was ahead of it; and towards the middle of the bend.
        let (along, ahead, inwards) = if down {
            (vec2(0.0, -1.0), vec2(1.0, 0.0), vec2(1.0, 0.0))
        } else {
            (vec2(1.0, 0.0), vec2(0.0, 1.0), vec2(0.0, -1.0))
        };
        let turned = |of: Vec2, by: f64| rotation(if down { by } else { -by }) * of;
        let first = (straight - 0.5 * radius * angle).max(0.0);
        let middle = start + along * first + inwards * radius;
        for place in &mut part.vertices {
            let (s, off) = (top - place[2], place[0] - axis);
            let by = ((s - first) / radius).clamp(0.0, angle);
            let beyond = if s < first { s - first } else { (s - first - radius * angle).max(0.0) };
            let at =
                middle - turned(inwards, by) * radius + turned(along, by) * beyond + turned(ahead, by) * off;
            (place[0], place[2]) = (at.x, at.y);
        }
    }
}

/// The solids of a thing, from its origin.
fn solids(part: &KindPart) -> Vec<MeshPart> {
    let [low, high] = part.height;
    let cylinder = |&[x, y, radius]: &[f64; 3]| {
        let size = Vector3::new(radius, radius, 0.5 * (high - low));
        prism(Vector3::new(x, y, 0.5 * (low + high)), Matrix3::from_diagonal(&size), SIDES)
    };
    match &part.solids[..] {
        [] => named(&part.name, part.disks.iter().map(cylinder)),
        solids => named(&part.name, solids.iter().map(solid)),
    }
}

fn named(name: &str, parts: impl Iterator<Item = MeshPart>) -> Vec<MeshPart> {
    let name = plain(name);
    parts.enumerate().map(|(k, part)| MeshPart { name: format!("{name}_{k}"), ..part }).collect()
}

fn solid(solid: &Solid) -> MeshPart {
    match *solid {
        Solid::Box(sides) => {
            let [x, y, z] = sides.map(|[from, to]| 0.5 * (to - from));
            let middle = sides.map(|[from, to]| 0.5 * (to + from));
            let root = 2.0f64.sqrt();
            prism(middle.into(), Matrix3::from_diagonal(&Vector3::new(x * root, y * root, z)), 4)
        }
        Solid::Wheel([x, y, z, radius, width]) => {
            let axes = [[0.0, 0.0, radius], [radius, 0.0, 0.0], [0.0, 0.5 * width, 0.0]];
            prism(Vector3::new(x, y, z), axes.into(), SIDES)
        }
        Solid::Bar(from, to, thick) => {
            let [from, to] = [from, to].map(Vector3::from);
            let (middle, half) = ((from + to) * 0.5, (to - from) * 0.5);
            // Any direction that is not along the bar.
            let helper = if half.z.abs() > 0.9 * half.norm() { Vector3::x() } else { Vector3::z() };
            let across = helper.cross(&half).normalize() * (0.5 * thick);
            let other = half.cross(&across).normalize() * (0.5 * thick);
            prism(middle, Matrix3::from_columns(&[across, other, half]), 8)
        }
    }
}

/// A closed prism about a point: a polygon in the plane of the first two axes (columns), along both directions of the
/// third one. The axes are right-handed. A polygon of four corners has its sides, not its corners, along them.
fn prism(middle: Vector3<f64>, axes: Matrix3<f64>, sides: usize) -> MeshPart {
    let mut part = MeshPart { name: String::new(), vertices: Vec::new(), triangles: Vec::new() };
    for end in [-1.0, 1.0] {
        let mut add = |x, y| part.vertices.push((middle + axes * Vector3::new(x, y, end)).into());
        add(0.0, 0.0);
        for k in 0..sides {
            let turn = rotation(TAU * (k as f64 + 0.5) / sides as f64);
            add(turn.re, turn.im);
        }
    }
    let ring = sides as u32 + 1;
    for k in 0..sides as u32 {
        let (one, next) = (1 + k, 1 + (k + 1) % sides as u32);
        part.triangles.extend([[0, next, one], [ring, ring + one, ring + next]]);
        part.triangles.extend([[one, next, ring + next], [one, ring + next, ring + one]]);
    }
    part
}
