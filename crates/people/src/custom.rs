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
//! ```
//!
//! Where the file gives no value, the paper's default is used. The default of `spearman`, the rank correlations in the
//! order breadth, depth, stature, mass, is that of ANSUR II.

use crate::bicycle::BicycleStatistics;
use crate::copula::Correlations;
use crate::normal::TruncatedNormal;
use crate::population::{CustomMeasures, CustomStatistics};
use serde::Deserialize;
use thiserror::Error;

/// Custom statistics of people and bicycles, and the proportions of both.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Custom {
    /// Statistics of people.
    pub people: CustomStatistics,
    /// Statistics of bicycles.
    pub bicycles: BicycleStatistics,
    /// Fraction of the pedestrians that are men, if the file gives it.
    pub men: Option<f64>,
    /// Fraction of the agents that are pedestrians, if the file gives it.
    pub pedestrians: Option<f64>,
}

/// A text that is not TOML, has unknown keys, or values of the wrong type; with line and column.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{0}")]
pub struct CustomError(String);

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields, default)]
struct File {
    men: Option<f64>,
    pedestrians: Option<f64>,
    male: People,
    female: People,
    bicycle: Bicycles,
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

/// Centimetres in a metre; kilograms in a kilogram.
const CM: f64 = 100.0;
const KG: f64 = 1.0;

impl Wanted {
    /// Replaces the given values of the default; `units` is the number of file units in an SI unit.
    fn over(&self, default: &mut TruncatedNormal, units: f64) {
        let fields = [
            (self.mean, &mut default.mean),
            (self.sd, &mut default.sd),
            (self.min, &mut default.min),
            (self.max, &mut default.max),
        ];
        for (said, field) in fields {
            if let Some(said) = said {
                *field = said / units;
            }
        }
    }
}

impl People {
    fn over(&self, default: &mut CustomMeasures) {
        self.breadth.over(&mut default.breadth, CM);
        self.depth.over(&mut default.depth, CM);
        self.stature.over(&mut default.stature, CM);
        self.mass.over(&mut default.mass, KG);
        if let Some(spearman) = self.spearman {
            default.spearman = spearman;
        }
    }
}

impl Custom {
    /// Reads the text of a file. [`Population::new`](crate::Population::new) checks that people can be drawn.
    ///
    /// # Errors
    /// The text is not valid; see [`CustomError`].
    pub fn from_toml(text: &str) -> Result<Custom, CustomError> {
        let file: File = toml::from_str(text).map_err(|error| CustomError(error.to_string()))?;
        let mut custom = Custom { men: file.men, pedestrians: file.pedestrians, ..Custom::default() };
        file.male.over(&mut custom.people.men);
        file.female.over(&mut custom.people.women);
        let (said, bicycles) = (&file.bicycle, &mut custom.bicycles);
        said.wheel_width.over(&mut bicycles.wheel_width, CM);
        said.length.over(&mut bicycles.length, CM);
        said.handlebar.over(&mut bicycles.handlebar, CM);
        said.top_tube.over(&mut bicycles.top_tube, CM);
        said.mass.over(&mut bicycles.mass, KG);
        Ok(custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::population::{Population, Proportions, Source};

    #[test]
    fn what_is_not_said_is_the_default() {
        assert_eq!(Custom::from_toml("").unwrap(), Custom::default());
        let text = "men = 0.25\n[female]\nbreadth = { mean = 40 }\nmass.max = 99\n[bicycle]\nlength.sd = 7";
        let custom = Custom::from_toml(text).unwrap();
        let mut wanted = Custom { men: Some(0.25), ..Custom::default() };
        wanted.people.women.breadth.mean = 0.4;
        wanted.people.women.mass.max = 99.0;
        wanted.bicycles.length.sd = 0.07;
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
        let spearman = custom.people.men.spearman;
        assert_eq!((spearman[0][1], custom.men, custom.pedestrians), (0.7, Some(0.5), Some(1.0)));
        custom.people.men.spearman = CustomStatistics::default().men.spearman;
        assert_eq!(custom.people, CustomStatistics::default());
        assert_eq!(custom.bicycles, BicycleStatistics::default());
    }

    #[test]
    fn mistakes_are_named() {
        let said = |text: &str| Custom::from_toml(text).unwrap_err().to_string();
        assert!(
            said("[male]\nheight.mean = 1").contains("unknown field `height`"),
            "{}",
            said("[male]\nheight.mean = 1")
        );
        assert!(said("[male]\nmass.mean = 'heavy'").contains("line 2"), "");
        let custom = Custom::from_toml("[male]\nmass.sd = -3").unwrap();
        let population = Population::new(Source::Custom(Box::new(custom.people)), Proportions::default());
        assert_eq!(
            population.unwrap_err().to_string(),
            "male statistics, mass: the standard deviation = -3: must be positive"
        );
    }
}
