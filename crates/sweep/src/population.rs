//! `[population]` of a `sweep.toml`: each point has a crowd of its own, made of a [`Scenario`].

use crate::error::{Error, Place, Result};
use crate::points::Points;
use lemons_core::files::source::Disk;
use lemons_core::trial::DriveTable;
use lemons_master::ensure;
use lemons_scenario::{MOST_PEOPLE, Scenario, ScenarioError};
use lemons_sim::Documents;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// Prefix of the parameters that are keys of the population.
pub(crate) const PREFIX: &str = "population.";
/// Keys of a walking crowd that may stand at the top, and where they are in a scenario.
const WALKING: [(&str, &str); 4] =
    [("model", "model"), ("start", "start"), ("groups", "groups.share"), ("push", "push")];

/// Crowd and its room, and the directory in which its files are.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Population(Scenario, PathBuf);

impl<'de> Deserialize<'de> for Population {
    /// With doors, everybody leaves, if it is not said.
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Population, D::Error> {
        let mut table = toml::Table::deserialize(from)?;
        let walking: Vec<_> =
            WALKING.iter().filter_map(|(key, to)| Some((*key, *to, table.remove(*key)?))).collect();
        let has_leave = table.contains_key("leave");
        let mut scenario = Scenario::from_table(table).map_err(|error| D::Error::custom(wrong(error)))?;
        for (key, to, value) in walking {
            let given = scenario.decision.clone();
            let twice = [
                ("model", given.model.is_some()),
                ("start", given.start.is_some()),
                ("groups", given.groups.is_some()),
                ("push", given.push.is_some()),
            ];
            if twice.contains(&(key, true)) {
                return Err(D::Error::custom(format!("{key}: is in decision, too: give it once")));
            }
            let set = scenario.with(&format!("decision.{to}"), &value.to_string());
            scenario = set.map_err(|error| D::Error::custom(format!("{key}: {error}")))?;
        }
        if !has_leave {
            scenario.leave = !scenario.doors.is_empty();
        }
        Ok(Population(scenario, PathBuf::new()))
    }
}

fn wrong(error: ScenarioError) -> Error {
    match error {
        ScenarioError::NoRoom { ref place, .. } => Error::Spec(format!("{place}: {error}")),
        error => Error::Spec(error.to_string()),
    }
}

impl Population {
    /// Reads a scenario.
    ///
    /// # Errors
    /// Those of [`Scenario::read`].
    pub fn read(path: &Path) -> Result<Population> {
        let scenario = Scenario::read_as_it_is(&Disk, path).map_err(wrong)?;
        Ok(Population(scenario, PathBuf::new()).within(path.parent().unwrap_or(Path::new(""))))
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
        let parameter = |parameter: &crate::points::Parameter| {
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
            ensure(!self.0.doors.is_empty(), || "there are no doors to have a width")?;
            let width = value.parse::<f64>().ok().filter(|width| width.is_finite());
            let width = width.ok_or_else(|| Error::Spec(format!("{value:?}: must be a finite number")))?;
            self.0.doors.iter_mut().for_each(|door| door.0.width = width);
            return Ok(self);
        }
        let own = WALKING.iter().find(|(known, _)| *known == key);
        let key = own.map_or_else(|| key.to_owned(), |(_, to)| format!("decision.{to}"));
        Ok(Population(self.0.with(&key, value).map_err(wrong)?, self.1))
    }

    /// Checks keys and values.
    ///
    /// # Errors
    /// One is not possible: key, value and why.
    pub fn check(&self) -> Result<()> {
        self.0.check().map_err(wrong)
    }

    /// Draws and places the people, and makes the documents of their Trial.
    ///
    /// # Errors
    /// They do not fit, or cannot leave.
    pub fn documents(&self) -> Result<Documents> {
        let mut watch = |_: &_| ControlFlow::Continue(());
        let made = self.found().documents("crowd", MOST_PEOPLE, &Disk, &mut watch).map_err(wrong)?;
        let drive = match made.drive.as_str() {
            "" => DriveTable::default(),
            text => DriveTable::from_csv(text.as_bytes()).map_err(|error| Error::Spec(error.to_string()))?,
        };
        Ok(Documents { trial: made.trial, drive, plan: made.decision.map(|(_, plan)| plan) })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The same text is a scenario and a `[population]`, if it says whether people leave.
    #[test]
    fn a_population_is_a_scenario() {
        let directory = lemons_testing::repository().join("crates/scenario/tests/crowds");
        let mut count = 0;
        for file in std::fs::read_dir(directory).unwrap().map(|file| file.unwrap().path()) {
            let text = std::fs::read_to_string(&file).unwrap();
            let text = if text.contains("leave =") { text } else { format!("leave = false\n{text}") };
            let population: Population = toml::from_str(&text).unwrap();
            let scenario = Scenario::read(&Disk, &file).unwrap();
            assert_eq!(population.0, scenario, "{}", file.display());
            let mut watch = |_: &_| ControlFlow::Continue(());
            let made = scenario.documents("crowd", MOST_PEOPLE, &Disk, &mut watch).unwrap();
            let own = population.documents().unwrap();
            assert_eq!((own.trial, own.plan), (made.trial, made.decision.map(|(_, plan)| plan)));
            count += 1;
        }
        assert!(count >= 20);
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
