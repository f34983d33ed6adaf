//! Three-dimensional bodies (section 3.3, `Shapes3D`): a standing person with hanging arms, as slices, sections or
//! meshes.
//!
//! The paper scales the contours of two cadavers: vertically to the stature, horizontally by one factor for each
//! direction. The factors are found at the altitude of the torso and fade out below the knees and above the neck (a
//! door-shaped profile).
//!
//! Here a body follows from the person's own measures. 40 heights, breadths, depths and girths follow from sex,
//! breadth, depth, stature and mass (conditional means in the US Army ANSUR II survey, 2012). Rounded outlines go
//! through them, connected by monotone cubics of the altitude. So a heavy person has a larger waist, not wider bones,
//! and men and women are built differently. The paper's door profile remains for the last step: one girth factor
//! between knees and neck gives the body the volume of its mass. Breadth and depth at the torso's altitude are those of
//! the person, as in the paper.

mod export;
mod figure;
mod landmarks;
mod measures;
mod mesh;
mod outline;
mod sections;
mod skin;
mod slices;
mod template;

pub use export::{write_geojson, write_obj, write_stl, write_wkt};
pub use figure::{Figure, PlacedPeople, people_fitting, person_fitting};
pub use landmarks::TORSO_ALTITUDE;
pub use mesh::{MeshPart, packed};
pub use sections::{CrowdSection, section};
pub use slices::BodySlice;

use crate::error::{Result, require};
use crate::person::{BodyMeasure, Person};
use lemons_core::plane::{Vec2, vec2};
use measures::Measures;
use skin::Ring;
use slices::volume;
use template::{Skins, Template, other_side};

/// \[kg/m³\] Density of a body with air in its lungs. The volume of a body is mass / density.
const BODY_DENSITY: f64 = 985.0;
/// Range of the girth factor: the ratio of the girths between knees and neck to the mean of people with the same four
/// measures. A person whose mass needs a factor outside gets the nearest bound.
const GIRTH_FACTORS: [f64; 2] = [0.8, 1.25];

/// A closed part of a body, separate from the others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BodyPart {
    /// From the crotch to the top of the head; above the armpits it includes the upper arms.
    Trunk,
    /// From the armpit to the fingertips.
    LeftArm,
    /// From the armpit to the fingertips.
    RightArm,
    /// From the crotch to the sole.
    LeftLeg,
    /// From the crotch to the sole.
    RightLeg,
}

impl BodyPart {
    /// All parts, in the order in which a body lists them.
    pub const ALL: [BodyPart; 5] =
        [BodyPart::Trunk, BodyPart::LeftArm, BodyPart::RightArm, BodyPart::LeftLeg, BodyPart::RightLeg];

    /// Returns the name used in files.
    pub fn name(self) -> &'static str {
        match self {
            BodyPart::Trunk => "trunk",
            BodyPart::LeftArm => "left_arm",
            BodyPart::RightArm => "right_arm",
            BodyPart::LeftLeg => "left_leg",
            BodyPart::RightLeg => "right_leg",
        }
    }
}

/// \[m, m, m, kg\] Smallest and largest measures of a body, in the order of [`BodyMeasure::ALL`]. The ranges are wider than
/// those of any custom statistics of the paper.
const LIMITS: [(f64, f64); 4] = [(0.25, 0.8), (0.1, 0.5), (1.0, 2.5), (20.0, 250.0)];

/// \[m\] Stature of the body that bodies of small children are like.
const SMALL: f64 = 1.35;

/// A person's body, standing upright with hanging arms.
///
/// Its frame is that of the person's two-dimensional shape: gaze along +x, left is +y. The vertical axis goes through
/// the centroid of the section at the torso's altitude; z is the height above the soles. Each part is a stack of closed
/// outlines (rings), with straight walls between two rings. Parts do not overlap: arms end where they enter the trunk's
/// outline, legs where the trunk begins.
#[derive(Debug, Clone, PartialEq)]
pub struct Body3d {
    person: Person,
    /// Of each part, in the order of [`BodyPart::ALL`], from low to high. Two rings at the same altitude are a flat step.
    rings: [Vec<Ring>; 5],
}

/// The skins with the wanted volume \[m³\], or the nearest that [`GIRTH_FACTORS`] allow.
fn fit(template: &Template, wanted: f64) -> Skins {
    let volume_of = |skins: &Skins| volume(&skins.trunk) + 2.0 * (volume(&skins.arm) + volume(&skins.leg));
    let [mut low, mut high] = GIRTH_FACTORS;
    let (mut factor, mut round) = (1.03, 0);
    loop {
        let skins = template.skins(factor);
        let ratio = volume_of(&skins) / wanted;
        let at_end = factor == GIRTH_FACTORS[if ratio < 1.0 { 1 } else { 0 }];
        if (ratio - 1.0).abs() < 1e-4 || at_end || high - low < 1e-5 {
            return skins;
        }
        *(if ratio < 1.0 { &mut low } else { &mut high }) = factor;
        // The volume grows roughly like this power of the factor. A bisection now and then guarantees that the search
        // ends.
        let aim = factor * libm::pow(ratio, -1.0 / 1.6);
        round += 1;
        factor = if round % 4 == 0 { 0.5 * (low + high) } else { aim.clamp(low, high) };
    }
}

impl Body3d {
    /// Makes the body of a person. The girth factor scales outlines evenly about their centres: by the paper's door
    /// profile on trunk and legs, fully on the upper arms, less towards the hands. Outlines at the torso's altitude and
    /// above keep their size.
    ///
    /// # Errors
    /// A measure is not a number, or no person has it, or the depth exceeds the breadth.
    pub fn of(person: &Person) -> Result<Body3d> {
        Body3d::possible(person)?;
        let mut skins = fit(&Template::of(person), person.mass / BODY_DENSITY);
        skins.lean_arm();
        let Skins { trunk, arm, leg } = skins;
        let (right_arm, right_leg) = (other_side(&arm), other_side(&leg));
        Ok(Body3d { person: *person, rings: [trunk, arm, right_arm, leg, right_leg] }.about_torso())
    }

    /// Makes the body of a person, also of a small child: a body of 1.35 m whose measures are as many times larger, made
    /// smaller. This is an assumption: the head of a small child is larger.
    ///
    /// # Errors
    /// As those of [`Body3d::of`], with ranges as many times smaller.
    pub fn similar(person: &Person) -> Result<Body3d> {
        Body3d::similar_possible(person)?;
        let (larger, size) = Body3d::larger(person);
        let mut body = Body3d::of(&larger)?;
        if size < 1.0 {
            body.person = *person;
            for ring in body.rings.iter_mut().flatten() {
                ring.z *= size;
                ring.points = ring.points.map(|point| point * size);
            }
        }
        Ok(body)
    }

    /// Checks that a person can have such a body.
    ///
    /// # Errors
    /// As those of [`Body3d::similar`].
    pub fn similar_possible(person: &Person) -> Result<()> {
        let (larger, size) = Body3d::larger(person);
        Body3d::within_limits(&larger, person, size)
    }

    /// Returns the person itself, or, of a small child, the one whose body is made smaller; and by how much.
    fn larger(person: &Person) -> (Person, f64) {
        if Body3d::possible(person).is_ok() || !(0.3..SMALL).contains(&person.stature) {
            return (*person, 1.0);
        }
        let size = person.stature / SMALL;
        let Person { sex, breadth, depth, mass, .. } = *person;
        let [breadth, depth, mass] = [breadth / size, depth / size, mass / (size * size * size)];
        (Person { sex, breadth, depth, stature: SMALL, mass }, size)
    }

    /// Checks that a person can have a body.
    ///
    /// # Errors
    /// As those of [`Body3d::of`].
    pub fn possible(person: &Person) -> Result<()> {
        Body3d::within_limits(person, person, 1.0)
    }

    /// Checks a body; messages are of the person that is this many times as large.
    fn within_limits(body: &Person, person: &Person, size: f64) -> Result<()> {
        let measures = body.measures().into_iter().zip(person.measures());
        for ((measure, (value, given)), (least, most)) in
            BodyMeasure::ALL.into_iter().zip(measures).zip(LIMITS)
        {
            let (name, unit) = (measure.name(), measure.unit());
            require((least..=most).contains(&value), || {
                let by = if measure == BodyMeasure::Mass { size * size * size } else { size };
                let [least, most] = [least, most].map(|limit| (limit * by * 1000.0).round() / 1000.0);
                format!("{name} = {given} {unit}: must be from {least} to {most} {unit} for a body")
            })?;
        }
        // What is left is the depth, which must not exceed the breadth.
        person.check()
    }

    /// Moves the body so that the centroid of the section at the torso's altitude is on the axis.
    fn about_torso(mut self) -> Body3d {
        let torso = self.slice_at(self.torso_altitude());
        let area: f64 = torso.iter().map(BodySlice::area).sum();
        let moment =
            torso.iter().fold(Vec2::zeros(), |sum, polygon| sum + polygon.centroid() * polygon.area());
        let ahead = vec2(moment.x / area, 0.0);
        for ring in self.rings.iter_mut().flatten() {
            ring.points = ring.points.map(|point| point - ahead);
        }
        self
    }

    /// Returns the stature \[m\].
    pub(crate) fn stature(&self) -> f64 {
        self.person.stature
    }

    /// Returns the heights \[m\] of somebody's crotch, and of the chest, at the nipples.
    pub(crate) fn crotch_and_chest(person: &Person) -> [f64; 2] {
        let (larger, size) = Body3d::larger(person);
        let landmarks::Heights { crotch, chest, .. } = landmarks::Heights::of(&Measures::of(&larger));
        [crotch * size, chest * size]
    }

    fn parts(&self) -> impl Iterator<Item = (BodyPart, &Vec<Ring>)> {
        BodyPart::ALL.into_iter().zip(&self.rings)
    }

    /// Returns the altitude \[m\] at which bideltoid breadth and chest depth are measured: [`TORSO_ALTITUDE`] ×
    /// stature.
    pub fn torso_altitude(&self) -> f64 {
        TORSO_ALTITUDE * self.person.stature
    }
}
