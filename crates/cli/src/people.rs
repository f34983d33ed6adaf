//! `lemons person`, `lemons crowd`: people from anthropometric data, and what both commands share.

mod bodies;
pub mod crowd;
mod leave;
mod outputs;
pub mod person;
mod placing;
mod regions;
mod source;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use lemons_people::{Measure, Person, Sex};

/// A parser of the names of some values.
fn named<T: Copy + Send + Sync>(
    all: &'static [T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let parser = PossibleValuesParser::new(all.iter().map(|value| name(*value)));
    parser.map(move |said| all.iter().copied().find(|value| name(*value) == said).unwrap_or(all[0]))
}

/// A number within bounds, both allowed.
fn within(text: &str, low: f64, high: f64, unit: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if (low..=high).contains(&value) => Ok(value),
        _ => Err(format!("must be a number from {low} to {high}{unit}")),
    }
}

/// Finite numbers between commas.
fn numbers<const N: usize>(text: &str) -> Option<[f64; N]> {
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    text.split(',').map(number).collect::<Option<Vec<f64>>>()?.try_into().ok()
}

/// A parser of a measure: breadth and depth in cm, the others in m and kg.
fn measure(of: Measure) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync {
    let (scale, unit) = match of {
        Measure::Breadth | Measure::Depth => (100.0, "cm"),
        Measure::Stature | Measure::Mass => (1.0, of.unit()),
    };
    let [low, high] = of.possible();
    move |text: &str| within(text, scale * low, scale * high, &format!(" ({unit})"))
}

/// From cm, cm, m, kg.
fn person(sex: Sex, [breadth, depth, stature, mass]: [f64; 4]) -> Result<Person, String> {
    if depth > breadth {
        return Err(format!("depth = {depth} cm must not exceed breadth = {breadth} cm"));
    }
    let person = Person::from_measures(sex, [breadth / 100.0, depth / 100.0, stature, mass]);
    person.check().map_err(|error| error.to_string()).map(|()| person)
}

/// A line of a summary: what, a number with three digits after the point, and its unit.
fn line(what: &str, value: f64, unit: &str) -> String {
    format!("{what:<18} {value:>10.3} {unit}")
}
