//! A Trial as users give it: its directory, or a zip of that (`lemons crowd --zip`).

use crate::error::TrialHasErrors;
use anyhow::{Context, Result};
use crowd_mechanics::files::Scratch;
use crowd_mechanics::trial::{Problem, Problems, Severity, Trial};
use lemons_master::{Kind, unzip_trial};
use std::path::{Component, Path, PathBuf};

/// Unpacked, if need be, as long as it lives.
pub struct Given {
    /// As the user gave it.
    named: PathBuf,
    directory: PathBuf,
    unpacked: Option<Scratch>,
}

impl Given {
    /// `None` where there is neither a directory nor the zip of a Trial: perhaps an FMU.
    pub fn find(path: &Path) -> Result<Option<Given>> {
        let named = path.to_owned();
        if path.is_dir() {
            return Ok(Some(Given { directory: named.clone(), named, unpacked: None }));
        }
        if !path.is_file() {
            return Ok(None);
        }
        let scratch = Scratch::new().context("cannot make a temporary directory")?;
        let found = unzip_trial(path, scratch.path()).with_context(|| path.display().to_string())?;
        Ok(found.map(|directory| Given { named, directory, unpacked: Some(scratch) }))
    }

    /// For what takes nothing but Trials.
    pub fn open(path: &Path) -> Result<Given> {
        Kind::expect(path, &[Kind::Trial, Kind::Archive], "a Trial directory or a zip of one")?;
        match Given::find(path)? {
            Some(given) => Ok(given),
            // Why it cannot be read says the reader.
            None => Ok(Given { named: path.to_owned(), directory: path.to_owned(), unpacked: None }),
        }
    }

    /// Where its files are.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// The Trial with its warnings, or all that is wrong with it, under the names that the user knows.
    pub fn read(&self) -> Result<(Trial, Problems), Problems> {
        let (trial, warnings) = Trial::read(&self.directory).map_err(|problems| self.renamed(&problems))?;
        if self.unpacked.is_some() {
            let parameters = &trial.parameters;
            let outside = [parameters.static_path(), parameters.dynamic_path()].into_iter().find(|path| {
                !path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
            });
            if let Some(outside) = outside {
                let mut problems = Problems::default();
                problems.push(Problem {
                    severity: Severity::Error,
                    file: self.named.join("Parameters.xml"),
                    line: None,
                    element: Some("Directories".into()),
                    attribute: None,
                    value: None,
                    message: format!("{outside:?} leads outside of the zip"),
                });
                return Err(problems);
            }
        }
        Ok((trial, self.renamed(&warnings)))
    }

    /// As [`Given::read`]; prints what is wrong.
    pub fn read_or_say(&self) -> Result<(Trial, Problems)> {
        self.read().map_err(|problems| self.say(&problems))
    }

    /// Prints errors that were found in it, as [`Given::read`] tells them.
    pub fn say(&self, problems: &Problems) -> anyhow::Error {
        note!("{problems}");
        note!("lemons: {} has errors", self.named.display());
        TrialHasErrors.into()
    }

    /// A text in which the user's name for it stands instead of where it was unpacked.
    pub fn under_its_name(&self, text: &str) -> String {
        match self.unpacked {
            Some(_) => text.replace(&*self.directory.to_string_lossy(), &self.named.to_string_lossy()),
            None => text.to_owned(),
        }
    }

    /// The names of files within a zip, instead of those where it was unpacked.
    pub fn renamed(&self, problems: &Problems) -> Problems {
        let mut renamed = Problems::default();
        for problem in problems.iter() {
            let file = match problem.file.strip_prefix(&self.directory) {
                Ok(inside) if self.unpacked.is_some() => self.named.join(inside),
                _ => problem.file.clone(),
            };
            renamed.push(Problem { file, ..problem.clone() });
        }
        renamed
    }
}
