//! Whom a crowd is drawn from.

use super::{breadth, depth, mass, person, stature};
use anyhow::{Context, Result};
use lemons_core::files::input;
use lemons_people::{Custom, Person, Population, Proportions, Sex, Source, Survey};
use std::path::PathBuf;

#[derive(clap::Args)]
#[command(next_help_heading = "People (default: drawn from the statistics of the survey ANSUR II, 2012)")]
pub struct SourceArguments {
    /// Probability that a pedestrian is a man, 0 to 1. Default: 0.5
    #[arg(long, value_name = "PART", value_parser = part, allow_negative_numbers = true, conflicts_with = "fixed")]
    men: Option<f64>,
    /// Probability that a member of the crowd is a pedestrian, 0 to 1; the others ride bicycles.
    /// Default: 1
    #[arg(long, value_name = "PART", value_parser = part, allow_negative_numbers = true)]
    pedestrians: Option<f64>,
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

pub const CUSTOM_HELP: &str = "\
A file for --custom: truncated normal distributions in cm and kg. The values below are \
the defaults. The defaults for women are (mean, sd, min, max): breadth 45, 1.5, 30, 60; \
depth 24, 1.5, 15, 45; stature 164, 7, 140, 210; mass 67, 11, 30, 130.

  men = 0.5             # probabilities; the options --men and
  pedestrians = 1.0     # --pedestrians override them
  [male]
  breadth = { mean = 51, sd = 2, min = 30, max = 65 }
  depth = { mean = 26, sd = 2, min = 15, max = 45 }
  stature = { mean = 178, sd = 8, min = 140, max = 240 }
  mass = { mean = 85, sd = 15, min = 30, max = 160 }
  [female]              # the same keys
  [bicycle]
  wheel_width = { mean = 6, sd = 0.5, min = 2, max = 20 }
  length = { mean = 142, sd = 5, min = 100, max = 200 }
  handlebar = { mean = 45, sd = 5, min = 30, max = 90 }
  top_tube = { mean = 61, sd = 5, min = 40, max = 90 }
  mass = { mean = 30, sd = 5, min = 10, max = 100 }

The rank correlations between the four measures of a person are those of the survey. A \
matrix `spearman` of 4 x 4 numbers in [male] or [female] replaces them.";

fn part(text: &str) -> Result<f64, String> {
    super::within(text, 0.0, 1.0, "")
}

fn fixed(text: &str) -> Result<Person, String> {
    let cells: Vec<&str> = text.split(',').map(str::trim).collect();
    let (measures, sex) = match cells[..] {
        [b, d, s, m] | [b, d, s, m, "male"] => ([b, d, s, m], Sex::Male),
        [b, d, s, m, "female"] => ([b, d, s, m], Sex::Female),
        _ => return Err("must be breadth,depth,stature,mass in cm, cm, m, kg, and perhaps ,female".into()),
    };
    let named = |name: &str, value: Result<f64, String>| value.map_err(|fault| format!("{name} {fault}"));
    let [b, d, s, m] = measures;
    person(
        sex,
        [
            named("breadth", breadth(b))?,
            named("depth", depth(d))?,
            named("stature", stature(s))?,
            named("mass", mass(m))?,
        ],
    )
}

impl SourceArguments {
    /// Whether bicycles can be among them.
    pub fn population(&self) -> Result<(Population, Mixed)> {
        let mut proportions = Proportions::default();
        let mut bicycles = None;
        let mut file = None;
        let source = if let Some(path) = &self.custom {
            let named = || format!("--custom {}", path.display());
            let text = input::read_text(path, input::LARGEST_SETTINGS).with_context(named)?;
            let custom = Custom::from_toml(&text).with_context(named)?;
            proportions.men = custom.men.unwrap_or(proportions.men);
            proportions.pedestrians = custom.pedestrians.unwrap_or(proportions.pedestrians);
            bicycles = Some(custom.bicycles);
            file = Some(named());
            Source::Custom(Box::new(custom.people))
        } else if self.ansur_male.is_some() || self.ansur_female.is_some() {
            // Of one table alone come its people alone.
            proportions.men = match (&self.ansur_male, &self.ansur_female) {
                (Some(_), None) => 1.0,
                (None, Some(_)) => 0.0,
                _ => proportions.men,
            };
            Source::Survey(Survey::read(self.ansur_male.as_deref(), self.ansur_female.as_deref())?)
        } else if let Some(person) = self.fixed {
            Source::Fixed(person)
        } else {
            Source::Ansur
        };
        proportions.men = self.men.unwrap_or(proportions.men);
        proportions.pedestrians = self.pedestrians.unwrap_or(proportions.pedestrians);
        let made = Population::new(source, proportions).and_then(|population| match bicycles {
            Some(bicycles) => population.with_bicycles(bicycles),
            None => Ok(population),
        });
        let population = match file {
            Some(file) => made.context(file)?,
            None => made?,
        };
        Ok((population, if proportions.pedestrians < 1.0 { Mixed::Yes } else { Mixed::No }))
    }
}

/// Whether a crowd has bicycles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mixed {
    Yes,
    No,
}
