//! A person: four measures -> five disks, and where the person stands in the survey.

use crate::{Refused, Reply};
use lemons_people::{Measure, Person, Sex, Shape, ansur};
use serde::Deserialize;
use serde_json::{Value, json};

/// A person's sex and measures.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wanted {
    /// "male" or "female".
    pub sex: SexName,
    /// \[m\] bideltoid breadth; `None`: the survey's median, as for the others.
    pub breadth: Option<f64>,
    /// \[m\] chest depth.
    pub depth: Option<f64>,
    /// \[m\]
    pub stature: Option<f64>,
    /// \[kg\]
    pub mass: Option<f64>,
}

/// As pages write it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)]
pub enum SexName {
    Male,
    Female,
}

impl From<SexName> for Sex {
    fn from(name: SexName) -> Sex {
        match name {
            SexName::Male => Sex::Male,
            SexName::Female => Sex::Female,
        }
    }
}

/// Returns measures, disks \[m\] in the body's frame, area \[m²\], moment of inertia \[kg m²\] and ranks.
///
/// # Errors
/// A measure is not a person's, or the chest is deeper than the shoulders are broad.
pub fn person(wanted: &Wanted) -> Result<Reply, Refused> {
    let sex = Sex::from(wanted.sex);
    let survey = ansur(sex);
    let given = [wanted.breadth, wanted.depth, wanted.stature, wanted.mass];
    let median = |k: usize| survey.measures[k].quantile(0.5);
    let measures = std::array::from_fn(|k| given[k].unwrap_or_else(|| median(k)));
    let person = Person::from_measures(sex, measures);
    for (measure, value) in Measure::ALL.iter().zip(measures) {
        let [low, high] = measure.possible();
        if !(low..=high).contains(&value) {
            let (name, unit) = (measure.name(), measure.unit());
            return Err(Refused(format!("{name} = {value} {unit}: a person has {low} to {high} {unit}")));
        }
    }
    let shape = Shape::of(&person).map_err(Refused::of)?;
    let about = |(k, measure): (usize, &Measure)| {
        let of = &survey.measures[k];
        json!({
            "name": measure.name(), "unit": measure.unit(), "value": measures[k], "possible": measure.possible(),
            "rank": rank(|rank| of.quantile(rank), measures[k]), "median": median(k),
            "quantiles": of.quantiles,
        })
    };
    let measures: Vec<Value> = Measure::ALL.iter().enumerate().map(about).collect();
    let disks: Vec<[f64; 3]> =
        shape.disks.iter().map(|disk| [disk.centre.x, disk.centre.y, disk.radius]).collect();
    let value = json!({
        "sex": sex.name(), "measures": measures, "disks": disks, "area": shape.moments().area,
        "inertia": shape.inertia(person.mass), "surveyed": survey.count,
    });
    Ok(Reply { value, bytes: Vec::new() })
}

/// The fraction of the people below a value, by bisection of the quantile function. Where many have the same value: in
/// their middle.
fn rank(quantile: impl Fn(f64) -> f64, value: f64) -> f64 {
    let from = |below: &dyn Fn(f64) -> bool| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if below(quantile(middle)) { low = middle } else { high = middle }
        }
        if below(quantile(1.0)) { 1.0 } else { high }
    };
    if value < quantile(0.0) {
        return 0.0;
    }
    0.5 * (from(&|found| found < value) + from(&|found| found <= value))
}
