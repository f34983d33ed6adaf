//! `lemons person`, `lemons crowd`: people from anthropometric data, and what both commands share.

mod bodies;
pub mod crowd;
mod leave;
mod outputs;
pub mod person;
mod placing;
mod regions;
mod source;

use clap::ValueEnum;
use lemons_people::{Person, Sex};

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SexArgument {
    Male,
    Female,
}

impl From<SexArgument> for Sex {
    fn from(sex: SexArgument) -> Sex {
        match sex {
            SexArgument::Male => Sex::Male,
            SexArgument::Female => Sex::Female,
        }
    }
}

/// A number within bounds, both allowed.
fn within(text: &str, low: f64, high: f64, unit: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if (low..=high).contains(&value) => Ok(value),
        _ => Err(format!("must be a number from {low} to {high}{unit}")),
    }
}

// Wider than anybody, children included, and narrow enough to tell metres from centimetres.

fn breadth(text: &str) -> Result<f64, String> {
    within(text, 10.0, 200.0, " (cm)")
}

fn depth(text: &str) -> Result<f64, String> {
    within(text, 5.0, 200.0, " (cm)")
}

fn stature(text: &str) -> Result<f64, String> {
    within(text, 0.3, 3.0, " (m)")
}

fn mass(text: &str) -> Result<f64, String> {
    within(text, 1.0, 500.0, " (kg)")
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
