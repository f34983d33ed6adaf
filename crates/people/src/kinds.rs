//! Kinds of people: children, the elderly, people with luggage, strollers, wheelchairs, bicycles. A table says of each
//! kind whose body it is, what goes along with it, and how fast it walks: `data/kinds.toml`, with the source of each
//! number.

use crate::anthropometry::ansur;
use crate::bicycle::Bicycle;
use crate::error::{NO_SHARES, PeopleError, Result, require};
use crate::growth::{AGES, child};
use crate::materials::{FRAME, PART_MATERIALS};
use crate::person::{Person, Sex};
use crate::random::Random;
use crate::shape::Shape;
use lemons_core::distribution::{Distribution, inverse};
use lemons_core::files::words;
use lemons_core::message::message;
use lemons_core::plane::{Disk, Vec2, union, vec2};
use lemons_core::trial::Heights;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::sync::Arc;

/// \[m\] Gap between an adult and the child at its hand.
const HAND: f64 = 0.05;
/// Names in tables that are no kinds.
const OTHERS: [&str; 3] = ["male", "female", "pedestrian"];
/// The kind of those who are no pedestrians.
pub const BICYCLE: &str = "bicycle";
/// \[1/s\] Largest rate at which a floor brakes.
const MOST_DAMPING: f64 = 1000.0;
/// Most disks of all parts of a kind.
const MOST_DISKS: usize = 50;
/// \[m\] Largest number of a part: nothing that goes along with a person is farther away.
const FARTHEST: f64 = 5.0;
/// \[m\] Height of a seat (assumption).
const SEAT: f64 = 0.48;
/// Most solids of a part.
const MOST_SOLIDS: usize = 100;

/// Whose statistics give the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BodyStatistics {
    /// The population's adults.
    #[default]
    Adult,
    /// The growth charts (CDC 2000), for the ages of the kind.
    Child,
}

/// Origin from which the disks of a [`KindPart`] are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PartOrigin {
    /// The centroid of the person's shape.
    #[default]
    Centre,
    /// The foremost point of the person's shape, on the axis of the gaze.
    Front,
    /// The hindmost one.
    Back,
}

/// A thing that goes along with a person, rigidly.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KindPart {
    /// Name of the thing.
    pub name: String,
    /// Id of its material: one of [`PART_MATERIALS`].
    pub material: String,
    /// Origin of its disks.
    #[serde(default)]
    pub from: PartOrigin,
    /// \[m\] Centre ahead and to the left, and radius of each disk.
    pub disks: Vec<[f64; 3]>,
    /// \[kg\] Its mass.
    pub mass: Distribution,
    /// \[m\] Its lowest and its highest place above the floor, in three dimensions.
    #[serde(default = "usual_height")]
    pub height: [f64; 2],
    /// Its look in three dimensions; empty: its disks as cylinders.
    #[serde(default)]
    pub solids: Vec<Solid>,
}

/// \[m\] Of a thing of which nothing is said (assumption).
fn usual_height() -> [f64; 2] {
    [0.0, 1.0]
}

/// A plain solid: how a part of a thing looks. x and y \[m\] are those of its disks, z is above the floor.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Solid {
    /// From and to, along x, y and z.
    Box([[f64; 2]; 3]),
    /// From a point to another one, and how thick it is.
    Bar([f64; 3], [f64; 3], f64),
    /// Its middle, its radius and its width, along y.
    Wheel([f64; 5]),
}

/// A kind of people.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PersonKind {
    /// Name of the kind: its key in the table.
    #[serde(skip)]
    pub name: String,
    /// Whose body it is.
    #[serde(default)]
    pub person: BodyStatistics,
    /// \[years\] The youngest and the oldest child; each age between is as likely.
    pub ages: Option<[f64; 2]>,
    /// \[years\] The same of a child at the person's hand.
    pub companion: Option<[f64; 2]>,
    /// Whether the person sits within the parts, and has no disks of its own.
    #[serde(default)]
    pub seated: bool,
    /// Whether the person rides a bicycle, whose measures are drawn; there are no parts then.
    #[serde(default)]
    pub bicycle: bool,
    /// \[m\] Height of its seat, in three dimensions.
    #[serde(default = "usual_seat")]
    pub seat: f64,
    /// \[m/s\] Desired speed; of a child, times the square root of its stature by the adults' mean.
    pub speed: Distribution,
    /// \[m/s\] That of women, if it differs.
    pub speed_women: Option<Distribution>,
    /// \[1/s\] Rate at which the floor brakes it across the gaze, if that is not as along: of wheels.
    pub floor_damping_across: Option<f64>,
    /// Things that go along.
    #[serde(default)]
    pub parts: Vec<KindPart>,
    /// Look of the bicycle in three dimensions, from the middle of the rider.
    #[serde(default)]
    pub solids: Vec<Solid>,
    /// The source of each number, or that it is an assumption.
    #[serde(default)]
    pub sources: Vec<String>,
}

fn usual_seat() -> f64 {
    SEAT
}

/// The kinds that a crowd can have, by name.
#[derive(Debug, Clone, PartialEq)]
pub struct Kinds(BTreeMap<String, Arc<PersonKind>>);

impl Kinds {
    /// Returns the kinds of the table `data/kinds.toml`.
    ///
    /// # Errors
    /// None: a test reads the table.
    pub fn built_in() -> Result<Kinds> {
        let table: BTreeMap<String, PersonKind> = toml::from_str(include_str!("../data/kinds.toml"))
            .map_err(|error| PeopleError::new(error.to_string()))?;
        Kinds(BTreeMap::new()).with(table)
    }

    /// Adds kinds; one with the name of another replaces it.
    ///
    /// # Errors
    /// A number of a kind is impossible.
    pub fn with(mut self, kinds: BTreeMap<String, PersonKind>) -> Result<Kinds> {
        for (name, mut kind) in kinds {
            require(!name.trim().is_empty() && !OTHERS.contains(&&*name), || {
                format!("kind {name:?}: this name means something else; give it another one")
            })?;
            require(name != BICYCLE || kind.bicycle, || {
                format!("kind {name:?}: must have bicycle = true, because others ride it")
            })?;
            kind.check().map_err(|error| error.of(format!("kind {name:?}")))?;
            if let Some(built_in) = self.0.get(BICYCLE).filter(|_| kind.bicycle && kind.solids.is_empty()) {
                kind.solids = built_in.solids.clone();
            }
            self.0.insert(name.clone(), Arc::new(PersonKind { name, ..kind }));
        }
        Ok(self)
    }

    /// Returns the kind of a name.
    pub fn get(&self, name: &str) -> Option<&Arc<PersonKind>> {
        self.0.get(name)
    }

    /// Returns all kinds, in the order of their names.
    pub fn iter(&self) -> impl Iterator<Item = &PersonKind> {
        self.0.values().map(|kind| &**kind)
    }

    /// Returns a mix of kinds with their shares, which need not sum up to 1.
    ///
    /// # Errors
    /// There is no such kind, a share is negative or not finite, or all are 0.
    pub fn mix(&self, shares: &BTreeMap<String, f64>) -> Result<Vec<(Arc<PersonKind>, f64)>> {
        let sum: f64 = shares.values().sum();
        require(sum > 0.0 && sum.is_finite(), || message!(NO_SHARES))?;
        let one = |(name, &share): (&String, &f64)| {
            require(share >= 0.0, || format!("the share of {name:?} = {share}: must not be negative"))?;
            let kind = self.0.get(name).ok_or_else(|| {
                let known: Vec<&str> = self.0.keys().map(String::as_str).collect();
                let meant = words::meant(name, known.iter().copied());
                let meant = meant.map_or(String::new(), |meant| format!(" (did you mean {meant:?}?)"));
                PeopleError::new(format!("there is no kind {name:?}{meant}; kinds are {}", known.join(", ")))
            })?;
            Ok((kind.clone(), share / sum))
        };
        shares.iter().map(one).collect()
    }
}

impl PersonKind {
    fn check(&self) -> Result<()> {
        for (name, speed) in [("speed", Some(&self.speed)), ("speed_women", self.speed_women.as_ref())] {
            speed.map_or(Ok(()), Distribution::check).map_err(|error| PeopleError::new(error).of(name))?;
        }
        require(self.ages.is_some() == (self.person == BodyStatistics::Child), || {
            "ages: of children there must be ages, and of adults there are none".to_owned()
        })?;
        for (name, ages) in [("ages", self.ages), ("companion", self.companion)] {
            let Some([from, to]) = ages else { continue };
            require(AGES[0] <= from && from < to && to <= AGES[1], || {
                format!("{name} = [{from}, {to}]: must be from 2 to 18 years, the lower one first")
            })?;
        }
        require(!self.bicycle || self.seated && self.parts.is_empty(), || {
            "bicycle = true: needs seated = true, and has no parts".to_owned()
        })?;
        require(!self.seated || self.bicycle || self.disks() > 0, || {
            "seated: there are no parts to sit in".to_owned()
        })?;
        require(!self.seated || self.companion.is_none(), || {
            "companion: nobody holds the hand of somebody who is seated".to_owned()
        })?;
        require(!self.seated || self.bicycle || self.looks_ahead(), || {
            "seated: the first disk must be the leftmost one, and the last one opposite: they say where it looks"
                .to_owned()
        })?;
        require(self.floor_damping_across.is_none_or(|rate| (0.0..=MOST_DAMPING).contains(&rate)), || {
            format!("floor_damping_across: must be from 0 to {MOST_DAMPING} 1/s")
        })?;
        require((0.0..=2.0).contains(&self.seat), || {
            format!("seat = {} m: must be from 0 to 2 m", self.seat)
        })?;
        require(self.bicycle || self.solids.is_empty(), || {
            "solids: those of a part belong to it, [[parts]]; those of a kind are its bicycle".to_owned()
        })?;
        check_solids(&self.solids)?;
        require(self.disks() <= MOST_DISKS, || format!("{} disks: at most {MOST_DISKS}", self.disks()))?;
        self.parts
            .iter()
            .try_for_each(|part| part.check().map_err(|error| error.of(format!("part {:?}", part.name))))
    }

    /// Whether the first and the last disk of parts in which somebody sits are left and right, or there is one disk.
    /// Later parts come between the first disk and the others.
    fn looks_ahead(&self) -> bool {
        let Some(part) = self.parts.first() else { return false };
        let [first, .., last] = part.disks[..] else { return self.disks() == 1 };
        first[0] == last[0] && first[1] > last[1]
    }

    /// Number of disks of all parts.
    fn disks(&self) -> usize {
        self.parts.iter().map(|part| part.disks.len()).sum()
    }

    /// Draws the desired speed \[m/s\] of a person.
    fn speed(&self, person: &Person, random: &mut Random) -> f64 {
        let of_women = self.speed_women.as_ref().filter(|_| person.sex == Sex::Female);
        let speed = of_women.unwrap_or(&self.speed).quantile(random.inside_unit());
        match self.person {
            BodyStatistics::Adult => speed,
            BodyStatistics::Child => speed * froude(person),
        }
    }

    /// Returns the member that a person, who has a shape, is with a child at its hand.
    pub(crate) fn draw(
        self: &Arc<PersonKind>,
        person: Person,
        companion: Option<Person>,
        bicycle: Option<Bicycle>,
        random: &mut Random,
    ) -> Member {
        let mut speed = self.speed(&person, random);
        let shape = Shape::fit(person.breadth, person.depth);
        let (front, back) = shape.ends();
        let mut pieces = Pieces::default();
        let own: &[Disk] = if self.seated { &[] } else { &shape.disks };
        pieces.body(&shape, Vec2::zeros(), person.mass, own);
        if let Some(bicycle) = &bicycle {
            pieces.bicycle(bicycle);
        }
        for part in &self.parts {
            let from = match part.from {
                PartOrigin::Centre => 0.0,
                PartOrigin::Front => front,
                PartOrigin::Back => back,
            };
            let disk = |&[x, y, radius]: &[f64; 3]| Disk { radius, centre: vec2(from + x, y) };
            let disks = Shape { disks: part.disks.iter().map(disk).collect() };
            pieces.part(&disks, part.mass.quantile(random.inside_unit()), &part.material);
        }
        let beside = companion.map(|child| {
            let side = if random.inside_unit() < 0.5 { 1.0 } else { -1.0 };
            (child, vec2(0.0, side * (0.5 * (person.breadth + child.breadth) + HAND)))
        });
        if let Some((child, at)) = beside {
            speed = speed.min(self.speed.quantile(random.inside_unit()) * froude(&child));
            let shape = Shape::fit(child.breadth, child.depth);
            let disks: Vec<Disk> =
                shape.disks.iter().map(|disk| Disk { centre: disk.centre + at, ..*disk }).collect();
            pieces.body(&shape, at, child.mass, &disks);
        }
        Member { bicycle, ..pieces.member(self.clone(), person, beside, speed) }
    }
}

/// The speed of a child by that of an adult who walks at the same Froude number v²/(g l), l proportional to the stature.
fn froude(child: &Person) -> f64 {
    let [_, _, stature, _] = ansur(child.sex).measures.each_ref().map(|measure| measure.mean);
    (child.stature / stature).sqrt()
}

/// Draws a child of an age between two \[years\].
pub(crate) fn draw_child(sex: Sex, [from, to]: [f64; 2], ranks: [f64; 2], random: &mut Random) -> Person {
    child(sex, from + (to - from) * random.inside_unit(), ranks.map(inverse))
}

impl KindPart {
    fn check(&self) -> Result<()> {
        require(PART_MATERIALS.contains(&&*self.material), || {
            format!("material = {:?}: must be one of {}", self.material, PART_MATERIALS.join(", "))
        })?;
        self.mass.check().map_err(|error| PeopleError::new(error).of("mass"))?;
        require(!self.disks.is_empty(), || "disks: there are none".to_owned())?;
        let [from, to] = self.height;
        require(0.0 <= from && from < to && to <= FARTHEST, || {
            format!("height = [{from}, {to}]: must be from 0 to {FARTHEST} m, the lower one first")
        })?;
        check_solids(&self.solids)?;
        self.disks.iter().try_for_each(|disk| {
            let good = disk[2] >= 0.01 && disk.iter().all(|value| value.abs() <= FARTHEST);
            Ok(require(good, || {
                format!("disk {disk:?}: must be within {FARTHEST} m, with a radius of at least 0.01 m")
            })?)
        })
    }
}

fn check_solids(solids: &[Solid]) -> Result<()> {
    require(solids.len() <= MOST_SOLIDS, || format!("{} solids: at most {MOST_SOLIDS}", solids.len()))?;
    solids.iter().try_for_each(|solid| {
        Ok(require(solid.is_possible(), || {
            format!("solid {solid:?}: must be within {FARTHEST} m, not below the floor, from the smaller to the larger")
        })?)
    })
}

impl Solid {
    fn is_possible(&self) -> bool {
        let near = |values: &[f64]| values.iter().all(|value| value.abs() <= FARTHEST);
        match self {
            Solid::Box(sides) => {
                near(sides.as_flattened()) && sides.iter().all(|[from, to]| from < to) && sides[2][0] >= 0.0
            }
            Solid::Bar(from, to, thick) => {
                near(from)
                    && near(to)
                    && from != to
                    && from[2].min(to[2]) >= 0.0
                    && (0.001..=1.0).contains(thick)
            }
            Solid::Wheel([x, y, z, radius, width]) => {
                near(&[*x, *y, *z])
                    && *radius >= 0.005
                    && *z >= *radius
                    && near(&[*radius])
                    && (0.001..=1.0).contains(width)
            }
        }
    }
}

/// A disk of a body.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyDisk {
    /// \[m\] Relative to the body's centre of mass.
    pub disk: Disk,
    /// Id of the material of a part; `None`: the people's.
    pub material: Option<String>,
    /// Where it is above the floor.
    pub heights: Heights,
}

impl BodyDisk {
    /// Makes a disk of a person, of all heights.
    pub fn of(disk: Disk) -> BodyDisk {
        BodyDisk { disk, material: None, heights: Heights::default() }
    }
}

/// A member of a mixed crowd: a person of some kind with what goes along with it, one rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct Member {
    /// Its kind.
    pub kind: Arc<PersonKind>,
    /// The people it consists of, and their places \[m\] from the centre of mass: the person, and a child at its hand.
    pub people: Vec<(Person, Vec2)>,
    /// The disks: the first one at the left, the last one at the right of the same person or thing.
    pub disks: Vec<BodyDisk>,
    /// \[kg\] mass of all.
    pub mass: f64,
    /// \[kg m²\] moment of inertia about the centre of mass.
    pub inertia: f64,
    /// \[m/s\] desired speed.
    pub speed: f64,
    /// Its bicycle, if it rides one.
    pub bicycle: Option<Bicycle>,
}

impl Member {
    /// Returns the shape that is placed.
    pub fn shape(&self) -> Shape {
        Shape { disks: self.disks.iter().map(|part| part.disk).collect() }
    }
}

/// Pieces of a member, while it is put together: relative to the person's centroid.
#[derive(Default)]
struct Pieces {
    disks: Vec<BodyDisk>,
    /// Mass, centroid, and moment of inertia about the centroid.
    masses: Vec<(f64, Vec2, f64)>,
}

impl Pieces {
    /// Adds disks between those that are there: the first and the last one say where the body looks.
    fn add(&mut self, disks: impl Iterator<Item = Disk>, material: Option<&str>) {
        let new = disks.map(|disk| BodyDisk { material: material.map(str::to_owned), ..BodyDisk::of(disk) });
        let place = self.disks.len().min(1);
        self.disks.splice(place..place, new);
    }

    fn body(&mut self, shape: &Shape, at: Vec2, mass: f64, disks: &[Disk]) {
        self.add(disks.iter().copied(), None);
        self.masses.push((mass, at, shape.inertia(mass)));
    }

    fn part(&mut self, shape: &Shape, mass: f64, material: &str) {
        self.add(shape.disks.iter().copied(), Some(material));
        let moments = union(&shape.disks);
        self.masses.push((mass, moments.centroid, mass * moments.polar / moments.area));
    }

    /// Adds a bicycle about the person: the disks of the rider's rectangle are the person's.
    fn bicycle(&mut self, bicycle: &Bicycle) {
        let [wheels, mut rider] = bicycle.covering_disks();
        // Of the foremost row the left one comes first and the right one last.
        let left = rider.pop();
        let right = rider.len() + 1 - Bicycle::ACROSS;
        let right = rider.remove(right);
        self.add(left.into_iter().chain([right]), None);
        self.add(rider.into_iter(), None);
        self.add(wheels.into_iter(), Some(FRAME));
        self.masses.push((bicycle.mass, Vec2::zeros(), bicycle.inertia()));
    }

    fn member(
        self,
        kind: Arc<PersonKind>,
        person: Person,
        beside: Option<(Person, Vec2)>,
        speed: f64,
    ) -> Member {
        let mass: f64 = self.masses.iter().map(|part| part.0).sum();
        let centre = self.masses.iter().fold(Vec2::zeros(), |sum, part| sum + part.1 * part.0) * (1.0 / mass);
        let inertia = self.masses.iter().map(|part| part.2 + part.0 * (part.1 - centre).norm_squared()).sum();
        let moved = |part: BodyDisk| BodyDisk {
            disk: Disk { centre: part.disk.centre - centre, ..part.disk },
            ..part
        };
        let people = std::iter::once((person, Vec2::zeros())).chain(beside);
        Member {
            kind,
            people: people.map(|(person, at)| (person, at - centre)).collect(),
            disks: self.disks.into_iter().map(moved).collect(),
            mass,
            inertia,
            speed,
            bicycle: None,
        }
    }
}

#[cfg(test)]
mod tests;
