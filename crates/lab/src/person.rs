//! A person: four measures -> five disks, and where the person stands in the survey.

use crate::body::section_of;
use crate::{Refused, Reply, within};
use lemons_people::{BICYCLE_MEASURES, Bicycle, BodyMeasure, Person, Sex, Shape, ansur};
use serde::{Deserialize, Serialize};

/// A person's sex and measures.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields)]
pub struct PersonRequest {
    /// "male" or "female".
    pub sex: Sex,
    /// \[m\] bideltoid breadth; `None`: the survey's median, as for the others.
    pub breadth: Option<f64>,
    /// \[m\] chest depth.
    pub depth: Option<f64>,
    /// \[m\]
    pub stature: Option<f64>,
    /// \[kg\]
    pub mass: Option<f64>,
    /// \[m\] Of a section that is wanted, too.
    pub altitude: Option<f64>,
}

impl PersonRequest {
    /// The person with these measures.
    ///
    /// # Errors
    /// A measure is not a person's.
    pub fn person(&self) -> Result<Person, Refused> {
        let given = [self.breadth, self.depth, self.stature, self.mass];
        let mut measures = [0.0; 4];
        for (k, measure) in BodyMeasure::ALL.into_iter().enumerate() {
            let value = given[k].unwrap_or_else(|| ansur(self.sex).measures[k].quantile(0.5));
            let name = format!("{} [{}]", measure.name(), measure.unit());
            measures[k] = within(&name, value, measure.possible())?;
        }
        Ok(Person::from_measures(self.sex, measures))
    }
}

/// A person, as a page shows it.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct PersonShown {
    sex: Sex,
    measures: Vec<MeasureShown>,
    disks: Vec<[f64; 3]>,
    area: f64,
    inertia: f64,
    surveyed: u32,
    /// Polygons of the body at the altitude that was asked for, in its frame; `None` if none was.
    sections: Option<Vec<Vec<[f64; 2]>>>,
}

/// A measure among those of the survey.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct MeasureShown {
    name: &'static str,
    unit: &'static str,
    value: f64,
    possible: [f64; 2],
    /// Fraction of the surveyed people below the value.
    rank: f64,
    quantiles: Vec<f64>,
}

/// A bicycle: rectangles \[m\], and measures.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct BicycleShown {
    rectangles: Vec<[[f64; 2]; 4]>,
    measures: Vec<BicycleMeasure>,
}

/// A measure of a bicycle.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct BicycleMeasure {
    name: &'static str,
    unit: &'static str,
    value: f64,
}

/// Returns measures, disks \[m\] in the body's frame, area \[m²\], moment of inertia \[kg m²\] and ranks.
///
/// # Errors
/// A measure is not a person's, or the chest is deeper than the shoulders are broad.
pub fn person(wanted: &PersonRequest) -> Result<Reply, Refused> {
    let (sex, person, survey) = (wanted.sex, wanted.person()?, ansur(wanted.sex));
    let measures = person.measures();
    let shape = Shape::of(&person)?;
    let about = |(k, measure): (usize, &BodyMeasure)| {
        let of = &survey.measures[k];
        MeasureShown {
            name: measure.name(),
            unit: measure.unit(),
            value: measures[k],
            possible: measure.possible(),
            rank: of.rank(measures[k]),
            quantiles: of.quantiles.to_vec(),
        }
    };
    Reply::of(PersonShown {
        sex,
        measures: BodyMeasure::ALL.iter().enumerate().map(about).collect(),
        disks: shape.disks.iter().map(|disk| [disk.centre.x, disk.centre.y, disk.radius]).collect(),
        area: shape.moments().area,
        inertia: shape.inertia(person.mass),
        surveyed: survey.count,
        sections: wanted.altitude.map(|altitude| section_of(&person, altitude)).transpose()?,
    })
}

/// Returns the two rectangles of a bicycle \[m\], in its frame, and its measures.
///
/// # Errors
/// None.
pub fn bicycle() -> Result<Reply, Refused> {
    let bicycle = Bicycle::TEMPLATE;
    let corners = |(length, width): (f64, f64)| {
        [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(|(x, y)| [0.5 * x * length, 0.5 * y * width])
    };
    let measures = BICYCLE_MEASURES.into_iter().zip(bicycle.measures());
    let measures = measures.map(|((name, unit), value)| BicycleMeasure { name, unit, value }).collect();
    Reply::of(BicycleShown { rectangles: bicycle.rectangles().map(corners).into(), measures })
}
