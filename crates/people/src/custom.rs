//! Custom statistics, from a TOML file in cm and kg:
//!
//! ```toml
//! men = 0.5                       # fraction of the pedestrians
//! pedestrians = 1.0               # fraction of the crowd; the others are bicycles
//!
//! [male]
//! breadth = { mean = 51, sd = 2, min = 30, max = 65 }      # across the shoulders
//! depth = { mean = 26, sd = 2, min = 15, max = 45 }        # of the chest
//! stature = { mean = 178, sd = 8, min = 140, max = 240 }
//! mass = { mean = 85, sd = 15, min = 30, max = 160 }
//! spearman = [[1, 0.7, 0.4, 0.8], [0.7, 1, 0.2, 0.8], [0.4, 0.2, 1, 0.5], [0.8, 0.8, 0.5, 1]]
//!
//! [female]                        # the same keys
//!
//! [bicycle]                       # wheel_width, length, handlebar, top_tube, mass
//! length = { mean = 142, sd = 5, min = 100, max = 200 }
//!
//! [mix]                           # shares of kinds; without it, all are adults with nothing
//! adult = 70
//! cello = 5
//!
//! [kinds.cello]                   # a kind of one's own, as in data/kinds.toml, in m and kg
//! speed = { min = 1.0, max = 1.3 }
//! [[kinds.cello.parts]]
//! name = "cello"
//! material = "luggage"
//! from = "back"
//! disks = [[-0.15, 0, 0.2]]
//! mass = { min = 5, max = 7 }
//! ```
//!
//! Where the file gives no value, the paper's default is used. The default of `spearman`, the rank correlations in the
//! order breadth, depth, stature, mass, is that of ANSUR II.

use crate::bicycle::PAPER_BICYCLES;
use crate::copula::Correlations;
use crate::error::{PeopleError, Result};
use crate::kinds::PersonKind;
use crate::person::Sex;
use crate::population::CustomMeasures;
use lemons_core::distribution::TruncatedNormal;
use serde::Deserialize;
use std::collections::BTreeMap;

/// Custom statistics of people and bicycles, and the proportions of both.
#[derive(Debug, Clone, PartialEq)]
pub struct Custom {
    /// Statistics of people, in the order of [`Sex::ALL`].
    pub people: [CustomMeasures; 2],
    /// Distributions of the measures of bicycles.
    pub bicycles: [TruncatedNormal; 5],
    /// Fraction of the pedestrians that are men, if the file gives it.
    pub men: Option<f64>,
    /// Fraction of the agents that are pedestrians, if the file gives it.
    pub pedestrians: Option<f64>,
    /// Shares of kinds; empty: none.
    pub mix: BTreeMap<String, f64>,
    /// Kinds beside those of [`Kinds::built_in`](crate::Kinds::built_in).
    pub kinds: BTreeMap<String, PersonKind>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct File {
    men: Option<f64>,
    pedestrians: Option<f64>,
    male: People,
    female: People,
    bicycle: Bicycles,
    mix: BTreeMap<String, f64>,
    kinds: BTreeMap<String, PersonKind>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct People {
    breadth: Wanted,
    depth: Wanted,
    stature: Wanted,
    mass: Wanted,
    spearman: Option<Correlations>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct Bicycles {
    wheel_width: Wanted,
    length: Wanted,
    handlebar: Wanted,
    top_tube: Wanted,
    mass: Wanted,
}

/// A distribution in cm or kg.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct Wanted {
    mean: Option<f64>,
    sd: Option<f64>,
    min: Option<f64>,
    max: Option<f64>,
}

/// Replaces the given values of the defaults. Lengths are in cm; the last measure is the mass, in kg.
fn replace<const N: usize>(defaults: &mut [TruncatedNormal; N], wanted: [Wanted; N]) {
    for (k, (normal, wanted)) in defaults.iter_mut().zip(wanted).enumerate() {
        let units = if k + 1 == N { 1.0 } else { 100.0 };
        let or = |wanted: Option<f64>, default: f64| wanted.map_or(default, |value| value / units);
        *normal = TruncatedNormal {
            mean: or(wanted.mean, normal.mean),
            sd: or(wanted.sd, normal.sd),
            min: or(wanted.min, normal.min),
            max: or(wanted.max, normal.max),
        };
    }
}

impl Custom {
    /// Reads the text of a file. [`PopulationSource::custom`](crate::PopulationSource::custom) checks that people can be drawn.
    ///
    /// # Errors
    /// The text is not TOML, has unknown keys, or values of the wrong type; with line and column.
    pub fn from_toml(text: &str) -> Result<Custom> {
        let File { men, pedestrians, male, female, bicycle, mix, kinds } =
            toml::from_str(text).map_err(|error| PeopleError::new(error.to_string()))?;
        let mut people = Sex::ALL.map(CustomMeasures::paper);
        for (custom, wanted) in people.iter_mut().zip([male, female]) {
            let People { breadth, depth, stature, mass, spearman } = wanted;
            replace(&mut custom.measures, [breadth, depth, stature, mass]);
            custom.spearman = spearman.unwrap_or(custom.spearman);
        }
        let mut bicycles = PAPER_BICYCLES;
        let Bicycles { wheel_width, length, handlebar, top_tube, mass } = bicycle;
        replace(&mut bicycles, [wheel_width, length, handlebar, top_tube, mass]);
        Ok(Custom { people, bicycles, men, pedestrians, mix, kinds })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_said_is_the_default() {
        let defaults = Custom::from_toml("").unwrap();
        assert_eq!(defaults.people, Sex::ALL.map(CustomMeasures::paper));
        let text = "men = 0.25\n[female]\nbreadth = { mean = 40 }\nmass.max = 99\n[bicycle]\nlength.sd = 7";
        let custom = Custom::from_toml(text).unwrap();
        let mut wanted = Custom { men: Some(0.25), ..defaults };
        wanted.people[1].measures[0].mean = 0.4;
        wanted.people[1].measures[3].max = 99.0;
        wanted.bicycles[1].sd = 0.07;
        assert_eq!(custom, wanted);
    }

    /// The example above is one, and says the defaults.
    #[test]
    fn the_documented_file_is_read() {
        let lines = include_str!("custom.rs").lines().take_while(|line| line.starts_with("//!"));
        let lines = lines.map(|line| line[3..].trim()).skip_while(|line| *line != "```toml").skip(1);
        let text: Vec<&str> = lines.take_while(|line| *line != "```").collect();
        assert!(text.len() > 10);
        let mut custom = Custom::from_toml(&text.join("\n")).unwrap();
        let spearman = custom.people[0].spearman;
        assert_eq!((spearman[0][1], custom.men, custom.pedestrians), (0.7, Some(0.5), Some(1.0)));
        assert_eq!(custom.mix["cello"], 5.0);
        assert!(crate::Kinds::built_in().unwrap().with(custom.kinds.clone()).is_ok());
        custom.people[0].spearman = CustomMeasures::paper(Sex::Male).spearman;
        assert_eq!((custom.people, custom.bicycles), (Sex::ALL.map(CustomMeasures::paper), PAPER_BICYCLES));
    }

    #[test]
    fn mistakes_are_named() {
        let message = |text: &str| Custom::from_toml(text).unwrap_err().to_string();
        assert!(message("[male]\nheight.mean = 1").contains("unknown field `height`"));
        assert!(message("[male]\nmass.mean = 'heavy'").contains("line 2"));
    }
}
