//! A drive file: who is pushed when, and how hard.

use crate::fmu::Instance;
use anyhow::{Context, Result, bail};
use crowd_mechanics::pack::DRIVE_FILE;
use crowd_mechanics::trial::{Agent, Trial};
use lemons_files::input;
use lemons_fmi2::fingerprint;
use std::collections::{BTreeMap, HashMap};
use std::io::Read;
use std::path::Path;

/// Fp.x \[N\], Fp.y \[N\], Mp \[N.m\].
pub type Push = [f64; 3];

/// Propulsion over time, from a CSV with the columns `t,agent,Fp.x,Fp.y,Mp`: for each agent (by Id)
/// linearly interpolated between its rows, zero before the first and after the last.
#[derive(Debug, Default, Clone)]
pub struct Drive {
    agents: HashMap<String, Vec<(f64, Push)>>,
}

impl Drive {
    /// Of a Trial: this file, else its own drive file, if it has one.
    ///
    /// # Errors
    /// What is wrong with the file; somebody in it is no agent of the Trial.
    pub fn of(trial: Option<&Trial>, given: Option<&Path>) -> Result<Drive> {
        let own =
            trial.map(|trial| trial.directory.join(DRIVE_FILE)).filter(|own| own.symlink_metadata().is_ok());
        let Some(path) = given.or(own.as_deref()) else { return Ok(Drive::default()) };
        // What lies in the Trial is not a pipe on purpose.
        let opened = match given {
            Some(path) => input::open_given(path, input::LARGEST_DRIVE),
            None => input::open_found(path, input::LARGEST_DRIVE),
        };
        let said = || format!("drive file {}", path.display());
        let drive = Drive::from_csv(opened.with_context(said)?).with_context(said)?;
        let known = |id: &str| trial.is_some_and(|trial| trial.agents.iter().any(|agent| agent.id == id));
        if let Some(unknown) = drive.agents().find(|id| !known(id)) {
            bail!("drive file {}: there is no agent {unknown:?} in Agents.xml", path.display());
        }
        Ok(drive)
    }

    /// Reads the content of a file.
    ///
    /// # Errors
    /// What is wrong with it: line, column, value.
    pub fn from_csv(content: impl Read) -> Result<Drive> {
        let mut reader =
            csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(content);
        let header = reader.headers()?.clone();
        let column = |name: &str| {
            let named = |column: &str| column.trim_start_matches('\u{feff}') == name;
            let mut places = header.iter().enumerate().filter(|(_, column)| named(column));
            let many = match (places.next(), places.next()) {
                (Some((place, _)), None) => return Ok(place),
                (None, _) => "is no column",
                (Some(_), Some(_)) => "are two columns",
            };
            bail!("there {many} {name:?} (expected t,agent,Fp.x,Fp.y,Mp)")
        };
        let (time, agent) = (column("t")?, column("agent")?);
        let push = [column("Fp.x")?, column("Fp.y")?, column("Mp")?];
        let mut drive = Drive::default();
        for record in reader.records() {
            let record = record?;
            let line = record.position().map_or(0, csv::Position::line);
            let number = |place: usize| {
                let text = &record[place];
                match text.parse::<f64>() {
                    Ok(value) if value.is_finite() => Ok(value),
                    _ => bail!("line {line}: {}={text:?}: not a finite number", &header[place]),
                }
            };
            let row = (number(time)?, [number(push[0])?, number(push[1])?, number(push[2])?]);
            let rows = drive.agents.entry(record[agent].to_owned()).or_default();
            if let Some(last) = rows.last().filter(|last| last.0 >= row.0) {
                bail!("line {line}: t={} does not come after t={} of the same agent", row.0, last.0);
            }
            rows.push(row);
        }
        Ok(drive)
    }

    /// The agents that the file names.
    pub fn agents(&self) -> impl Iterator<Item = &str> {
        self.agents.keys().map(String::as_str)
    }

    /// Time \[s\] and push of each row of an agent; `None` if the file does not name it.
    pub fn rows(&self, agent: &str) -> Option<&[(f64, Push)]> {
        self.agents.get(agent).map(Vec::as_slice)
    }

    /// Equal for equal pushes, however the file is spelled.
    pub fn fingerprint(&self) -> String {
        let sorted: BTreeMap<_, _> = self.agents.iter().collect();
        format!("{:032x}", fingerprint(format!("{sorted:?}").as_bytes()))
    }

    /// \[s\] The last row of all; `None` without rows.
    pub fn end(&self) -> Option<f64> {
        self.agents.values().flatten().map(|row| row.0).reduce(f64::max)
    }

    /// What an agent that the file names is driven by at a time \[s\]; `None` for others.
    pub fn at(&self, agent: &str, time: f64) -> Option<Push> {
        let rows = self.agents.get(agent)?;
        let after = rows.partition_point(|row| row.0 <= time);
        let push = match (after.checked_sub(1).map(|before| rows[before]), rows.get(after)) {
            (Some((t0, a)), Some((t1, b))) => {
                let share = match t1 - t0 {
                    whole if whole.is_finite() => (time - t0) / whole,
                    // Times so far apart that their difference is no number.
                    _ => (0.5 * time - 0.5 * t0) / (0.5 * t1 - 0.5 * t0),
                };
                std::array::from_fn(|k| match b[k] - a[k] {
                    change if change.is_finite() => a[k] + share * change,
                    _ => (1.0 - share) * a[k] + share * b[k],
                })
            }
            // The last row itself still counts.
            (Some((t0, a)), None) if t0 == time => a,
            _ => [0.0; 3],
        };
        Some(push)
    }
}

/// A drive, into an instance of a crowd.
pub struct Pushes {
    drive: Drive,
    /// Of the agents that the drive names.
    ids: Vec<String>,
    inputs: Vec<u32>,
}

impl Pushes {
    /// To the inputs of these agents of an instance.
    ///
    /// # Errors
    /// The instance has not the inputs of an agent that the drive names.
    pub fn new(instance: &Instance, agents: &[Agent], drive: Drive) -> Result<Pushes> {
        let agents = agents.iter().enumerate();
        let driven: Vec<_> = agents.filter(|(_, agent)| drive.at(&agent.id, 0.0).is_some()).collect();
        let names = driven
            .iter()
            .flat_map(|(i, _)| ["Fp.x", "Fp.y", "Mp"].map(move |name| format!("agent[{i}].{name}")));
        Ok(Pushes {
            inputs: names.map(|name| instance.reference(&name)).collect::<Result<_>>()?,
            ids: driven.iter().map(|(_, agent)| agent.id.clone()).collect(),
            drive,
        })
    }

    /// \[s\] When the last of them ends; `None` if there is none.
    pub fn end(&self) -> Option<f64> {
        self.drive.end()
    }

    /// What drives them at a time \[s\].
    ///
    /// # Errors
    /// The FMU's refusal.
    pub fn send(&self, instance: &Instance, time: f64) -> Result<()> {
        if self.inputs.is_empty() {
            return Ok(());
        }
        let pushes = self.ids.iter().filter_map(|id| self.drive.at(id, time));
        let values: Vec<f64> = pushes.flatten().collect();
        instance.set_real(&self.inputs, &values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(text: &str) -> Result<Drive> {
        Drive::from_csv(text.as_bytes())
    }

    #[test]
    fn interpolates_inside_and_is_zero_outside() {
        let drive = drive("t,agent,Fp.x,Fp.y,Mp\n1,a,0,0,0\n2,a,100,-50,2\n2,b,1,1,1\n").unwrap();
        assert_eq!(drive.at("a", 0.5), Some([0.0; 3]));
        assert_eq!(drive.at("a", 1.25), Some([25.0, -12.5, 0.5]));
        assert_eq!(drive.at("a", 2.0), Some([100.0, -50.0, 2.0]));
        assert_eq!(drive.at("a", 2.1), Some([0.0; 3]));
        assert_eq!(drive.at("c", 1.5), None);
    }

    #[test]
    fn the_largest_forces_are_interpolated_too() {
        let rows = "t,agent,Fp.x,Fp.y,Mp\n0,a,-1e308,1e308,0\n1,a,1e308,-1e308,0\n";
        let drive = drive(rows).unwrap();
        assert_eq!(drive.at("a", 0.0), Some([-1e308, 1e308, 0.0]));
        assert_eq!(drive.at("a", 0.5), Some([0.0; 3]));
        assert_eq!(drive.at("a", 0.75), Some([0.75e308 - 0.25e308, 0.25e308 - 0.75e308, 0.0]));
        let drive = self::drive("t,agent,Fp.x,Fp.y,Mp\n-1e308,a,0,0,0\n1e308,a,4,0,0\n").unwrap();
        assert_eq!(drive.at("a", 0.0), Some([2.0, 0.0, 0.0]));
    }

    #[test]
    fn says_line_and_value() {
        let said = |text: &str| format!("{:#}", drive(text).unwrap_err());
        assert!(said("t,agent,Fp.x,Mp\n").contains("no column \"Fp.y\""));
        assert!(said("t,agent,Fp.x,Fp.y,Mp,Mp\n").contains("two columns \"Mp\""));
        assert!(said("t,agent,Fp.x,Fp.y,Mp\n0,a,x,0,0\n").contains("line 2: Fp.x=\"x\""));
        assert!(said("t,agent,Fp.x,Fp.y,Mp\n1,a,0,0,0\n1,a,0,0,0\n").contains("line 3"));
    }
}
