//! Whom a crowd is drawn from.

use super::{measure, person, ranged};
use crate::error::Misused;
use crate::values::within;
use anyhow::{Result, bail};
use lemons_people::{BodyMeasure, Kinds, Person, Sex};
use lemons_scenario::{People, Scenario, Share};
use std::path::PathBuf;

#[derive(clap::Args)]
#[command(next_help_heading = "People (default: drawn from the statistics of the survey ANSUR II, 2012)")]
pub struct SourceArguments {
    /// Probability that an adult is a man, 0 to 1. Default: 0.5
    #[arg(long, value_name = "PART", value_parser = ranged("men", ""), conflicts_with = "fixed")]
    men: Option<f64>,
    /// Probability that a member of the crowd is a pedestrian, 0 to 1; the others ride bicycles
    /// (the kind bicycle of --mix). Default: 1
    #[arg(long, value_name = "PART", value_parser = ranged("pedestrians", ""))]
    pedestrians: Option<f64>,
    #[arg(long, value_name = "KIND=SHARE", value_delimiter = ',', value_parser = share, help = help_of_mix())]
    mix: Vec<(String, Share)>,
    /// Your own statistics, see below
    #[arg(long, value_name = "FILE.toml", conflicts_with_all = ["ansur_male", "ansur_female", "fixed"])]
    custom: Option<PathBuf>,
    /// Draw real men from the survey's public table ANSUR_II_MALE_Public.csv
    #[arg(long, value_name = "FILE.csv", conflicts_with = "fixed")]
    ansur_male: Option<PathBuf>,
    /// Draw real women from the survey's public table ANSUR_II_FEMALE_Public.csv
    #[arg(long, value_name = "FILE.csv", conflicts_with = "fixed")]
    ansur_female: Option<PathBuf>,
    /// The same person every time: shoulder breadth and chest depth in cm, stature in m, mass in kg, for
    /// example 49,25,1.75,70 or 45,24,1.63,67,female
    #[arg(long, value_name = "MEASURES", value_parser = fixed, allow_hyphen_values = true)]
    fixed: Option<Person>,
}

fn help_of_mix() -> String {
    let kinds = Kinds::built_in().expect("the table is read by tests");
    let kinds: Vec<&str> = kinds.iter().map(|kind| &*kind.name).collect();
    format!(
        "Shares of kinds of people, as in adult=70,child=15,elderly=10,wheelchair=5; they need not sum up to 100. Kinds: \
         {}, and those of --custom (docs/people.md). With --leave, each has the desired speed of its kind",
        kinds.join(", ")
    )
}

pub const CUSTOM_HELP: &str = include_str!("../help/custom.txt");

fn share(text: &str) -> Result<(String, Share), String> {
    let (name, share) = text.split_once('=').ok_or("must be KIND=SHARE, as in adult=70,child=30")?;
    let share = within(0.0, 1e6, "")(share.trim()).map_err(|fault| format!("{name} {fault}"))?;
    Ok((name.trim().to_owned(), Share::Number(share)))
}

fn fixed(text: &str) -> Result<Person, String> {
    let cells: Vec<&str> = text.split(',').map(str::trim).collect();
    let (measures, sex) = match cells[..] {
        [b, d, s, m] | [b, d, s, m, "male"] => ([b, d, s, m], Sex::Male),
        [b, d, s, m, "female"] => ([b, d, s, m], Sex::Female),
        _ => return Err("must be breadth,depth,stature,mass in cm, cm, m, kg, and perhaps ,female".into()),
    };
    let mut values = [0.0; 4];
    let names = ["breadth", "depth", "stature", "mass"];
    for (((value, text), name), of) in values.iter_mut().zip(measures).zip(names).zip(BodyMeasure::ALL) {
        *value = measure(of)(text).map_err(|fault| format!("{name} {fault}"))?;
    }
    person(sex, values)
}

impl SourceArguments {
    /// Fills in what is given.
    pub fn fill(&self, scenario: &mut Scenario) -> Result<()> {
        scenario.men = self.men.or(scenario.men);
        scenario.pedestrians = self.pedestrians.or(scenario.pedestrians);
        let SourceArguments { custom, ansur_male, ansur_female, fixed, .. } = self;
        if let Some(file) = custom.clone() {
            scenario.people = People::Custom { file };
        } else if ansur_male.is_some() || ansur_female.is_some() {
            scenario.people = People::Tables { male: ansur_male.clone(), female: ansur_female.clone() };
        } else if let Some(person) = fixed {
            scenario.people = People::Fixed { sex: person.sex, measures: person.measures() };
        }
        if !self.mix.is_empty() {
            scenario.mix = self.mix.iter().cloned().collect();
            if scenario.mix.len() < self.mix.len() {
                bail!(Misused("--mix: a kind is there twice".into()));
            }
        }
        Ok(())
    }
}
