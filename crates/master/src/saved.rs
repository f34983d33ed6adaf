//! A saved run: `run.toml` and the state of each component, in a zip.

use crate::calls::LARGEST_STATE;
use crate::error::{ErrorPlace, MasterError, Result, require};
use crate::file_type::FileType;
use crate::ssp::{Allowance, entry, open_zip, sound};
use lemons_core::files::Staged;
use lemons_core::trial::quoted;
use lemons_sim::{Algorithm, ExposureSum, Extremes};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt::Display;
use std::io::{BufWriter, Read, Write};
use std::path::Path;
use zip::{CompressionMethod, ZipWriter};

const RUN: &str = "run.toml";
/// \[byte\] of `run.toml`: thousands of components.
const LARGEST_RUN: u64 = 4_000_000;

/// `run.toml`: where a run was, and what it had recorded.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SavedRun {
    /// [`SavedRun::FORMAT`]
    pub format: u32,
    /// The builds of the program that wrote it ([`writers`]). For people: a run goes on with any build that knows the
    /// format.
    pub lemons: String,
    /// \[s\] when the run began
    pub start: f64,
    /// \[s\] Communication points are `start + k * step`.
    pub step: f64,
    /// \[s\] when the run was to end
    pub until: f64,
    /// The last k.
    pub index: u64,
    /// \[s\] where it was: there, or after it if the last step was a shorter one.
    pub time: f64,
    /// One communication point in so many is recorded.
    pub every: u64,
    /// How components are coupled.
    pub algorithm: String,
    /// Fingerprint of the connections.
    pub wiring: String,
    /// Fingerprint of the drive.
    pub drive: String,
    /// In the order of the system.
    pub component: Vec<ComponentRecord>,
    /// Records of the components that are crowds.
    pub crowd: Vec<CrowdRecord>,
}

/// An FMU of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComponentRecord {
    /// In the system.
    pub name: String,
    /// modelName
    pub model: String,
    /// guid
    pub guid: String,
    /// The sizes of arrays that were chosen before initialization, and the Trial (FMI 3.0).
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub chosen: BTreeMap<String, String>,
    /// The archive's entry with its state.
    pub state: String,
    /// \[byte\] of the state
    pub bytes: u64,
}

/// The record of a crowd.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CrowdRecord {
    /// Its name.
    pub component: String,
    /// So far.
    pub extremes: Extremes,
    /// Since the last rows, where not every communication point has rows.
    #[serde(default, skip_serializing_if = "ExposureSum::is_empty")]
    pub since: ExposureSum,
}

impl ComponentRecord {
    /// Makes the record of a component without choices, whose state is not known yet.
    pub fn new(name: &str, model: &str, guid: &str) -> ComponentRecord {
        let [name, model, guid] = [name, model, guid].map(str::to_owned);
        ComponentRecord { name, model, guid, chosen: BTreeMap::new(), state: String::new(), bytes: 0 }
    }
}

/// Returns what a file says of the programs that wrote it, once `now` has gone on with what those `before` had written: each
/// of them once, oldest first, with `; ` between them.
pub fn writers(before: &str, now: &str) -> String {
    let mut seen = HashSet::new();
    let all = before.split("; ").chain(now.split("; "));
    all.filter(|one| !one.is_empty() && seen.insert(*one)).collect::<Vec<_>>().join("; ")
}

/// Says what is wrong with `run.toml`.
fn wrong(why: impl Display) -> MasterError {
    MasterError::new(format!("{RUN}: {why}"))
}

impl SavedRun {
    /// The format of `run.toml` that this program knows; raised when its meaning changes.
    pub const FORMAT: u32 = 5;

    /// Returns what was chosen before initialization, as parameters: in an SSP, with the names of the components.
    pub(crate) fn chosen(&self, coupled: bool) -> Vec<(String, String)> {
        let of = |component: &ComponentRecord, name: &String| {
            if coupled { format!("{}.{name}", component.name) } else { name.clone() }
        };
        let all = self.component.iter().flat_map(|component| {
            component.chosen.iter().map(move |(name, value)| (of(component, name), value.clone()))
        });
        all.collect()
    }

    /// Checks that the states of all components can be read again.
    fn check_states(states: &[Vec<u8>], most: usize) -> Result<()> {
        let size = states.iter().fold(0, |sum: usize, state| sum.saturating_add(state.len()));
        let large = || format!("the states of all components have {size} bytes together, more than {most}");
        Ok(require(size <= most, large)?)
    }

    /// Writes the archive with the states of the components; the same run gives the same bytes.
    ///
    /// # Errors
    /// It cannot be written, or the states have more than [`LARGEST_STATE`] together.
    pub fn write(mut self, states: &[Vec<u8>], file: Staged) -> Result<()> {
        SavedRun::check_states(states, LARGEST_STATE)?;
        for (place, (component, state)) in self.component.iter_mut().zip(states).enumerate() {
            (component.state, component.bytes) = (format!("state-{place}"), state.len() as u64);
        }
        let mut zip = ZipWriter::new(BufWriter::new(file));
        let options = entry(CompressionMethod::Deflated);
        zip.start_file(RUN, options)?;
        zip.write_all(toml::to_string(&self).map_err(wrong)?.as_bytes())?;
        for (component, state) in self.component.iter().zip(states) {
            zip.start_file(component.state.as_str(), options)?;
            zip.write_all(state)?;
        }
        let file = zip.finish()?.into_inner().map_err(|error| error.into_error())?;
        file.sync()?;
        Ok(file.persist()?)
    }

    /// Reads an archive, with the states of the components.
    ///
    /// # Errors
    /// It is not a saved run, or it contains impossible numbers.
    pub fn read(path: &Path) -> Result<(SavedRun, Vec<Vec<u8>>)> {
        let found = FileType::expect(path, &[FileType::SAVED_RUN], "a saved run");
        found.map_err(|error| MasterError::new(format!("{error} (--state writes one)")))?;
        SavedRun::read_archive(path).place(|| format!("saved run {}", path.display()))
    }

    fn read_archive(path: &Path) -> Result<(SavedRun, Vec<Vec<u8>>)> {
        let mut zip = sound(open_zip(path)?)?;
        let mut text = Vec::new();
        Allowance::new(LARGEST_RUN).copy(RUN, zip.by_name(RUN)?, &mut text)?;
        let text = String::from_utf8(text).map_err(|_| wrong("is not UTF-8 text"))?;
        let saved = SavedRun::parse(&text)?;
        let mut left = Allowance::new(LARGEST_STATE as u64);
        let mut states = Vec::new();
        for component in &saved.component {
            let name = &component.state;
            let (stated, own) = (component.bytes, &component.name);
            let missing = || format!("it contains no {name:?}, the state of component {own:?}");
            require(zip.index_for_name(name).is_some(), missing)?;
            // No more is unpacked than is said, and no more than is said is allocated.
            let mut bytes = Vec::new();
            left.copy(name, zip.by_name(name)?.take(stated.saturating_add(1)), &mut bytes)?;
            let other = || format!("{name}: has not the {stated} bytes that {RUN} says");
            require(bytes.len() as u64 == stated, other)?;
            states.push(bytes);
        }
        Ok((saved, states))
    }

    fn parse(text: &str) -> Result<SavedRun> {
        /// The part that every version has.
        #[derive(Deserialize)]
        struct Version {
            format: u32,
            #[serde(default)]
            lemons: String,
        }
        let Version { format, lemons } = toml::from_str(text).map_err(wrong)?;
        require(format == SavedRun::FORMAT, || {
            let by = if lemons.is_empty() { String::new() } else { format!(" (lemons {})", quoted(&lemons)) };
            wrong(format!(
                "format = {format}: this program knows format {} only; continue the run with the program that \
                 saved it{by}, or begin it again",
                SavedRun::FORMAT
            ))
        })?;
        let saved: SavedRun = toml::from_str(text).map_err(wrong)?;
        saved.check_numbers().place(|| RUN.to_owned())?;
        Ok(saved)
    }

    fn check_numbers(&self) -> Result<()> {
        let SavedRun { start, step, until, time, index, every, .. } = *self;
        let (point, next) = (start + index as f64 * step, start + (index as f64 + 1.0) * step);
        let within = format!("from {point:?} on and before {next:?}, at index {index}");
        for (key, value, is_right, must) in [
            ("start", start, start.is_finite(), "finite"),
            ("step", step, step > 0.0 && step.is_finite(), "positive and finite"),
            ("until", until, until.is_finite(), "finite"),
            ("time", time, time >= point && time < next, &within),
        ] {
            require(is_right, || format!("{key}: {value:?}: must be {must}"))?;
        }
        require(every > 0, || "every: 0: must be positive")?;
        require(!self.component.is_empty(), || "component: there is none")?;
        let mut of = HashMap::new();
        for ComponentRecord { name, state, .. } in &self.component {
            require(state != RUN, || {
                format!("state: {state:?}: component {name:?} has no entry of its own")
            })?;
            if let Some(other) = of.insert(state, name) {
                return Err(
                    format!("state: {state:?}: is that of component {other:?} and of {name:?}").into()
                );
            }
        }
        for CrowdRecord { component, extremes, since } in &self.crowd {
            let possible = extremes.are_possible() && since.is_possible();
            require(possible, || format!("crowd: {component:?}: has a number that is not possible"))?;
        }
        Ok(())
    }

    /// Checks that it is a run of these components (names, models and GUIDs), coupled like this.
    ///
    /// # Errors
    /// It is not; the message says why.
    pub fn check(&self, components: &[ComponentRecord], algorithm: Algorithm, wiring: &str) -> Result<()> {
        let names = |all: &[ComponentRecord]| {
            all.iter().map(|component| component.name.as_str()).collect::<Vec<_>>().join(", ")
        };
        let (there, here) = (names(&self.component), names(components));
        require(there == here, || format!("the saved run is of the components {there}; here are {here}"))?;
        for (ComponentRecord { name, model, guid, .. }, here) in self.component.iter().zip(components) {
            require(*guid == here.guid, || {
                format!(
                    "component {name:?}: the saved run is of {model:?} with the GUID {guid}; here is {:?} with {}",
                    here.model, here.guid
                )
            })?;
        }
        let there = &self.algorithm;
        require(*there == algorithm.to_string(), || {
            format!("--algorithm: the saved run has {there}, not {algorithm}")
        })?;
        let why = "the components are connected otherwise than in the saved run";
        Ok(require(self.wiring == wiring, || why)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// It was written, but nothing could read it.
    #[test]
    fn states_that_are_too_large_together_are_not_written() {
        let states = [vec![0; 6], vec![0; 5]];
        assert!(SavedRun::check_states(&states, 11).is_ok());
        let message = SavedRun::check_states(&states, 10).unwrap_err().to_string();
        assert_eq!(message, "the states of all components have 11 bytes together, more than 10");
    }

    #[test]
    fn a_file_names_each_of_its_writers_once() {
        assert_eq!(writers("", "0.1.0 (a)"), "0.1.0 (a)");
        assert_eq!(writers("0.1.0 (a)", "0.1.0 (a)"), "0.1.0 (a)");
        assert_eq!(writers("0.1.0", "0.1.0 (a)"), "0.1.0; 0.1.0 (a)");
        assert_eq!(writers("0.1.0; 0.1.0 (a)", "0.1.0 (a); 0.1.0 (b)"), "0.1.0; 0.1.0 (a); 0.1.0 (b)");
    }
}
