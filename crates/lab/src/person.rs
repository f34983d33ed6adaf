//! A person: four measures -> five disks, and where the person stands in the survey.

use crate::body::section_of;
use crate::{Refused, Reply, require};
use lemons_people::{BICYCLE_MEASURES, Bicycle, Measure, Person, Sex, Shape, ansur};
use serde::Deserialize;
use serde_json::{Value, json};

/// A person's sex and measures.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
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
    fn measures(&self) -> [f64; 4] {
        let survey = ansur(self.sex);
        let given = [self.breadth, self.depth, self.stature, self.mass];
        std::array::from_fn(|k| given[k].unwrap_or_else(|| survey.measures[k].quantile(0.5)))
    }

    /// The person with these measures.
    ///
    /// # Errors
    /// A measure is not a person's.
    pub fn person(&self) -> Result<Person, Refused> {
        let measures = self.measures();
        for (measure, value) in Measure::ALL.iter().zip(measures) {
            let [low, high] = measure.possible();
            let (name, unit) = (measure.name(), measure.unit());
            require((low..=high).contains(&value), || {
                format!("{name} = {value} {unit}: a person has {low} to {high} {unit}")
            })?;
        }
        Ok(Person::from_measures(self.sex, measures))
    }
}

/// Returns measures, disks \[m\] in the body's frame, area \[m²\], moment of inertia \[kg m²\] and ranks.
///
/// # Errors
/// A measure is not a person's, or the chest is deeper than the shoulders are broad.
pub fn person(wanted: &PersonRequest) -> Result<Reply, Refused> {
    let (sex, measures, person) = (wanted.sex, wanted.measures(), wanted.person()?);
    let survey = ansur(sex);
    let shape = Shape::of(&person)?;
    let about = |(k, measure): (usize, &Measure)| {
        let of = &survey.measures[k];
        json!({
            "name": measure.name(), "unit": measure.unit(), "value": measures[k], "possible": measure.possible(),
            "rank": of.rank(measures[k]), "quantiles": of.quantiles,
        })
    };
    let measures: Vec<Value> = Measure::ALL.iter().enumerate().map(about).collect();
    let disks: Vec<[f64; 3]> =
        shape.disks.iter().map(|disk| [disk.centre.x, disk.centre.y, disk.radius]).collect();
    let sections = wanted.altitude.map(|altitude| section_of(&person, altitude)).transpose()?;
    Ok(Reply::of(json!({
        "sex": sex.name(), "measures": measures, "disks": disks, "area": shape.moments().area,
        "inertia": shape.inertia(person.mass), "surveyed": survey.count,
        "sections": sections,
    })))
}

/// Returns the two rectangles of a bicycle \[m\], in its frame, and its measures.
pub fn bicycle() -> Reply {
    let bicycle = Bicycle::TEMPLATE;
    let corners = |(length, width): (f64, f64)| {
        [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(|(x, y)| [0.5 * x * length, 0.5 * y * width])
    };
    let measures = BICYCLE_MEASURES
        .into_iter()
        .zip(bicycle.measures())
        .map(|((name, unit), value)| json!({ "name": name, "unit": unit, "value": value }));
    Reply::of(json!({
        "rectangles": bicycle.rectangles().map(corners), "measures": measures.collect::<Vec<_>>(),
    }))
}
