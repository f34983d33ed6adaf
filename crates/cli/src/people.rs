//! `lemons person`, `lemons crowd`: people from anthropometric data, and what both commands share.

mod bodies;
pub mod crowd;
mod leave;
mod outputs;
pub mod person;
mod placing;
mod regions;
pub mod room;
pub mod shape;
mod source;

use crate::error::TrialHasErrors;
use crate::values::within;
use anyhow::Result;
use lemons_core::trial::Problems;
use lemons_people::{BodyMeasure, Person, Sex};

/// A parser of a number of a scenario; `unit` follows its range in the error.
fn ranged(key: &str, unit: &str) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync + use<> {
    let [low, high] = lemons_scenario::range(key);
    within(low, high, unit)
}

/// A parser of a measure: breadth and depth in cm, the others in m and kg.
fn measure(of: BodyMeasure) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync {
    let (scale, unit) = match of {
        BodyMeasure::Breadth | BodyMeasure::Depth => (100.0, "cm"),
        BodyMeasure::Stature | BodyMeasure::Mass => (1.0, of.unit()),
    };
    let [low, high] = of.possible();
    within(scale * low, scale * high, &format!(" ({unit})"))
}

/// From cm, cm, m, kg.
fn person(sex: Sex, [breadth, depth, stature, mass]: [f64; 4]) -> Result<Person, String> {
    let person = Person::from_measures(sex, [breadth / 100.0, depth / 100.0, stature, mass]);
    person.check().map_err(|error| error.to_string()).map(|()| person)
}

/// A line of a summary: what, a number with three digits after the point, and its unit.
fn line(what: &str, value: f64, unit: &str) -> String {
    format!("{what:<18} {value:>10.3} {unit}")
}

/// Prints the warnings of what was read, or its errors.
fn read<T>(read: Result<(T, Problems), Problems>) -> Result<T> {
    match read {
        Ok((read, warnings)) => {
            warnings.iter().for_each(|warning| note!("{warning}"));
            Ok(read)
        }
        Err(problems) => {
            note!("{problems}");
            Err(TrialHasErrors.into())
        }
    }
}
