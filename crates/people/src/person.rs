//! A person, described by four measures.

use crate::error::{Result, require};
use serde::{Deserialize, Serialize};

/// Sex, which selects the statistics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(rename_all = "lowercase")]
pub enum Sex {
    /// A man.
    Male,
    /// A woman.
    Female,
}

impl Sex {
    /// Both sexes, in the order of all tables.
    pub const ALL: [Sex; 2] = [Sex::Male, Sex::Female];

    /// Returns "male" or "female".
    pub fn name(self) -> &'static str {
        match self {
            Sex::Male => "male",
            Sex::Female => "female",
        }
    }
}

/// One of a person's measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum BodyMeasure {
    /// \[m\] bideltoid breadth.
    Breadth,
    /// \[m\] chest depth.
    Depth,
    /// \[m\] stature.
    Stature,
    /// \[kg\] mass.
    Mass,
}

impl BodyMeasure {
    /// All measures, in the order of all tables and matrices here.
    pub const ALL: [BodyMeasure; 4] =
        [BodyMeasure::Breadth, BodyMeasure::Depth, BodyMeasure::Stature, BodyMeasure::Mass];

    /// Name, unit and range.
    fn about(self) -> (&'static str, &'static str, [f64; 2]) {
        match self {
            BodyMeasure::Breadth => ("bideltoid breadth", "m", [0.1, 2.0]),
            BodyMeasure::Depth => ("chest depth", "m", [0.05, 2.0]),
            BodyMeasure::Stature => ("stature", "m", [0.3, 3.0]),
            BodyMeasure::Mass => ("mass", "kg", [1.0, 500.0]),
        }
    }

    /// Returns the name in words.
    pub fn name(self) -> &'static str {
        self.about().0
    }

    /// Returns "m" or "kg".
    pub fn unit(self) -> &'static str {
        self.about().1
    }

    /// Returns the range \[m\] or \[kg\] of human measures, from children to giants. A number outside is probably in
    /// another unit.
    pub fn possible(self) -> [f64; 2] {
        self.about().2
    }
}

/// A person. Its two-dimensional shape and its three-dimensional body follow from these measures.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Person {
    /// Sex, which selects the statistics.
    pub sex: Sex,
    /// \[m\] bideltoid breadth: breadth of the shoulders.
    pub breadth: f64,
    /// \[m\] chest depth.
    pub depth: f64,
    /// \[m\] stature: height without shoes.
    pub stature: f64,
    /// \[kg\] mass.
    pub mass: f64,
}

impl Person {
    /// Makes a person from measures in the order of [`BodyMeasure::ALL`].
    pub fn from_measures(sex: Sex, [breadth, depth, stature, mass]: [f64; 4]) -> Person {
        Person { sex, breadth, depth, stature, mass }
    }

    /// Returns the measures in the order of [`BodyMeasure::ALL`].
    pub fn measures(&self) -> [f64; 4] {
        [self.breadth, self.depth, self.stature, self.mass]
    }

    /// Checks that a shape and a body can be made.
    ///
    /// # Errors
    /// A measure is not positive and finite, or the chest is deeper than the shoulders are broad.
    pub fn check(&self) -> Result<()> {
        for (measure, value) in BodyMeasure::ALL.into_iter().zip(self.measures()) {
            require(value > 0.0 && value.is_finite(), || {
                format!("{} = {value} {}: must be positive and finite", measure.name(), measure.unit())
            })?;
        }
        let Person { breadth, depth, .. } = self;
        Ok(require(depth <= breadth, || {
            format!("chest depth = {depth} m: must not exceed the bideltoid breadth, {breadth} m")
        })?)
    }
}
