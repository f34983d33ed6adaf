//! `[population]` of a `sweep.toml`: each point has a crowd of its own, made of a [`Scenario`].

use crate::error::{ErrorPlace, Result};
use crate::points::Points;
use lemons_core::files::source::LocalFiles;
use lemons_core::require;
use lemons_scenario::{MOST_PEOPLE, Scenario};
use lemons_sim::Documents;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Prefix of the parameters that are keys of the population.
pub(crate) const PREFIX: &str = "population.";
/// Keys of `decision` that may stand at the top, too. `groups` is then their share.
const WALKING: [&str; 4] = ["model", "start", "groups", "push"];

/// Crowd and its room, and the directory in which its files are.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Population(Scenario, PathBuf);

impl<'de> Deserialize<'de> for Population {
    /// With doors, everybody leaves, if it is not said.
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Population, D::Error> {
        let mut table = toml::Table::deserialize(from)?;
        for key in WALKING {
            let Some(value) = table.remove(key) else { continue };
            let value = if key == "groups" {
                toml::Table::from_iter([("share".to_owned(), value)]).into()
            } else {
                value
            };
            let decision = table.entry("decision").or_insert_with(|| toml::Table::new().into());
            // Of what is no table, the scenario says so.
            let before = decision.as_table_mut().and_then(|decision| decision.insert(key.into(), value));
            if before.is_some() {
                return Err(D::Error::custom(format!("{key}: is in decision, too: give it once")));
            }
        }
        let has_leave = table.contains_key("leave");
        let mut scenario = Scenario::from_table(table).map_err(D::Error::custom)?;
        if !has_leave {
            scenario.leave = !scenario.doors.is_empty();
        }
        Ok(Population(scenario, PathBuf::new()))
    }
}

impl Population {
    /// Reads a scenario.
    ///
    /// # Errors
    /// Those of [`Scenario::read`].
    pub fn read(path: &Path) -> Result<Population> {
        let directory = path.parent().unwrap_or(Path::new(""));
        Ok(Population(Scenario::read_as_it_is(&LocalFiles, path)?, directory.to_owned()))
    }

    /// Finds files in a directory, also those that parameters name.
    pub fn within(self, directory: &Path) -> Population {
        Population(self.0, directory.to_owned())
    }

    /// The scenario with paths in the directory.
    fn found(&self) -> Scenario {
        let mut found = self.0.clone();
        found.each_path(|path| *path = self.1.join(&*path));
        found
    }

    /// Returns the paths of files that it is made of.
    pub fn files(&self) -> Vec<PathBuf> {
        let mut files = Vec::new();
        self.found().each_path(|path| files.push(path.clone()));
        files
    }

    /// Returns of each parameter whether it is a key of the population.
    ///
    /// # Errors
    /// There is no such key, or a value cannot be read.
    pub fn choosers(&self, points: &Points) -> Result<Vec<bool>> {
        let parameter = |parameter: &crate::points::SweepParameter| {
            let Some(key) = parameter.name.strip_prefix(PREFIX) else { return Ok(false) };
            let set = |value: &String| self.clone().set(key, value).map(|_| true);
            parameter.values().iter().try_fold(true, |_, value| set(value)).place(|| parameter.name.clone())
        };
        points.parameters.iter().map(parameter).collect()
    }

    /// Returns the population of a point.
    ///
    /// # Errors
    /// A value is not possible with the others of the point.
    pub fn at(&self, points: &Points, point: usize) -> Result<Population> {
        let keys = points.parameters.iter().filter_map(|of| Some((of, of.name.strip_prefix(PREFIX)?)));
        let mut own = self.clone();
        for (parameter, key) in keys {
            own = own.set(key, parameter.at(point)).place(|| parameter.name.clone())?;
        }
        own.check()?;
        Ok(own)
    }

    /// Sets a key to a value that is only read, not checked: other keys of a point may make it possible. `width` is that of
    /// all doors.
    fn set(mut self, key: &str, value: &str) -> Result<Population> {
        if key == "width" {
            require(!self.0.doors.is_empty(), || "there are no doors to have a width")?;
            let width = value.parse().ok().filter(|width: &f64| width.is_finite());
            let width = width.ok_or_else(|| format!("{value:?}: must be a finite number"))?;
            self.0.doors.iter_mut().for_each(|door| door.0.width = width);
            return Ok(self);
        }
        let key = match key {
            "groups" => "decision.groups.share".to_owned(),
            key if WALKING.contains(&key) => format!("decision.{key}"),
            key => key.to_owned(),
        };
        Ok(Population(self.0.with(&key, value)?, self.1))
    }

    /// Checks keys and values.
    ///
    /// # Errors
    /// One is not possible: key, value and why.
    pub fn check(&self) -> Result<()> {
        Ok(self.0.check()?)
    }

    /// Draws and places the people, and makes the documents of their Trial.
    ///
    /// # Errors
    /// They do not fit, or cannot leave.
    pub fn documents(&self) -> Result<Documents> {
        let mut watch = |_: &_| ControlFlow::Continue(());
        let made = self.found().documents("crowd", MOST_PEOPLE, &LocalFiles, &mut watch)?;
        Ok(Documents { trial: made.trial, drive: made.drive, plan: made.decision.map(|(_, plan)| plan) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same text is a scenario and a `[population]`, if it says whether people leave.
    #[test]
    fn a_population_is_a_scenario() {
        for (_, file) in lemons_testing::scenarios() {
            let text = std::fs::read_to_string(&file).unwrap();
            let text = if text.contains("leave =") { text } else { format!("leave = false\n{text}") };
            let population: Population = toml::from_str(&text).unwrap();
            let scenario = Scenario::read(&LocalFiles, &file).unwrap();
            assert_eq!(population.0, scenario, "{}", file.display());
            let mut watch = |_: &_| ControlFlow::Continue(());
            let made = scenario.documents("crowd", MOST_PEOPLE, &LocalFiles, &mut watch).unwrap();
            let own = population.documents().unwrap();
            assert_eq!((own.trial, own.plan), (made.trial, made.decision.map(|(_, plan)| plan)));
        }
    }

    #[test]
    fn keys_of_walking_may_stand_at_the_top() {
        let text =
            "number = 9\nbox = [5, 5]\ndoors = [[5, 2, 1]]\nstart = 3\ngroups = 0.5\nmodel = \"straight\"";
        let Population(flat, _) = toml::from_str(text).unwrap();
        let nested = "number = 9\nbox = [5, 5]\ndoors = [[5, 2, 1]]\nleave = true\n[decision]\nstart = 3\n\
                      model = \"straight\"\ngroups = { share = 0.5 }";
        assert_eq!(flat, Scenario::from_toml(nested).unwrap());
    }
}
