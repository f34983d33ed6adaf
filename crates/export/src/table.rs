//! The table that `lemons run` writes.

use crate::{ExportError, Frame, Observed, Run};
use crowd_mechanics::engine::{Vec2, vec2};
use crowd_mechanics::trial::AgentDynamics;
use std::collections::HashMap;
use std::path::Path;

const COLUMNS: [&str; 8] = ["t", "id", "x", "y", "vx", "vy", "theta", "omega"];
/// Read where all of them are there.
const OBSERVED: [&str; 4] = ["agent_contacts", "wall_contacts", "contacting_agents", "normal_force"];

impl Run {
    /// Reads `trajectories.csv`: the columns t, id, x, y, vx, vy, theta, omega in any order, the contact
    /// counts and the squeeze where they are there, further ones do not matter; all agents at one time, then all at the next.
    ///
    /// # Errors
    /// What is wrong, with line and column.
    pub fn read_table(path: &Path) -> Result<Run, ExportError> {
        let file =
            std::fs::File::open(path).map_err(|error| ExportError::Read { path: path.to_owned(), error })?;
        read(path, file).map_err(|message| ExportError::wrong(path, message))
    }
}

fn read(path: &Path, file: impl std::io::Read) -> Result<Run, String> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(file);
    let header = reader.headers().map_err(broken)?.clone();
    let column = |name: &str| {
        let mut found = (0..header.len()).filter(|&at| header[at].trim_start_matches('\u{feff}') == name);
        match (found.next(), found.next()) {
            (Some(place), None) => Ok(place),
            (Some(_), Some(_)) => Err(format!("line 1: there are two columns {name:?}")),
            (None, _) => Err(format!("line 1: there is no column {name:?} (lemons run writes {COLUMNS:?})")),
        }
    };
    let mut columns = [0; COLUMNS.len()];
    for (place, name) in columns.iter_mut().zip(COLUMNS) {
        *place = column(name)?;
    }
    let observed: Option<Vec<usize>> = OBSERVED.iter().map(|name| column(name).ok()).collect();
    let mut builder = Builder::default();
    let mut row = csv::StringRecord::new();
    while reader.read_record(&mut row).map_err(broken)? {
        let line = row.position().map_or(0, csv::Position::line);
        let number = |k: usize| {
            let text = &row[columns[k]];
            let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
            value.ok_or_else(|| format!("line {line}: column {}: {text:?} is no finite number", COLUMNS[k]))
        };
        let agent = AgentDynamics {
            position: vec2(number(2)?, number(3)?),
            velocity: vec2(number(4)?, number(5)?),
            theta: number(6)?,
            omega: number(7)?,
            fp: Vec2::ZERO,
            mp: 0.0,
        };
        let wrong = |k: usize, what: &str| {
            let place = observed.as_ref().map_or(0, |places| places[k]);
            format!("line {line}: column {}: {:?} is no {what}", OBSERVED[k], &row[place])
        };
        let seen = observed.as_ref().map(|places| {
            let count = |k: usize| row[places[k]].parse::<u32>().map_err(|_| wrong(k, "number of contacts"));
            let force = row[places[3]].parse::<f64>().ok().filter(|force| *force >= 0.0 && force.is_finite());
            Ok::<_, String>(Observed {
                agent_contacts: count(0)?,
                wall_contacts: count(1)?,
                contacting_agents: count(2)?,
                normal_force: force.ok_or_else(|| wrong(3, "squeeze in newtons"))?,
            })
        });
        builder.add(line, number(0)?, &row[columns[1]], (agent, seen.transpose()?))?;
    }
    builder.finish(path)
}

fn broken(error: csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => {
            let line = pos.as_ref().map_or(0, csv::Position::line);
            format!("line {line}: has {len} columns, the header {expected_len}")
        }
        csv::ErrorKind::Utf8 { pos, err } => {
            let line = pos.as_ref().map_or(0, csv::Position::line);
            format!("line {line}: column {}: is not UTF-8 text", err.field() + 1)
        }
        _ => error.to_string(),
    }
}

/// Of one agent at one time.
type Seen = (AgentDynamics, Option<Observed>);

#[derive(Default)]
struct Builder {
    ids: Vec<String>,
    places: HashMap<String, usize>,
    frames: Vec<Frame>,
    /// Of the newest frame, by place.
    agents: Vec<Option<Seen>>,
}

impl Builder {
    fn add(&mut self, line: u64, time: f64, id: &str, agent: Seen) -> Result<(), String> {
        match self.frames.last().map(|frame| frame.time) {
            Some(last) if time == last => {}
            Some(last) if time < last => {
                return Err(format!(
                    "line {line}: column t: t = {time:?} s must not come after t = {last:?} s"
                ));
            }
            _ => {
                self.close()?;
                let place = format!("line {line}");
                let (agents, observed, interactions) = (Vec::new(), None, None);
                self.frames.push(Frame { time, agents, observed, interactions, place });
            }
        }
        if id.is_empty() {
            return Err(format!("line {line}: column id: is empty"));
        }
        if self.frames.len() == 1 && !self.places.contains_key(id) {
            self.places.insert(id.to_owned(), self.ids.len());
            self.ids.push(id.to_owned());
            self.agents.push(None);
        }
        let Some(&place) = self.places.get(id) else {
            return Err(format!("line {line}: column id: agent {id:?} was not there at the first time"));
        };
        match self.agents[place].replace(agent) {
            Some(_) => Err(format!("line {line}: column id: agent {id:?} stands twice at t = {time:?} s")),
            None => Ok(()),
        }
    }

    /// Puts the newest frame's agents into it.
    fn close(&mut self) -> Result<(), String> {
        let Some(frame) = self.frames.last_mut() else { return Ok(()) };
        let all = self.agents.iter_mut().zip(&self.ids).map(|(agent, id)| {
            let missing = || format!("{}: at t = {:?} s agent {id:?} is missing", frame.place, frame.time);
            agent.take().ok_or_else(missing)
        });
        let (agents, observed): (_, Vec<_>) = all.collect::<Result<Vec<_>, _>>()?.into_iter().unzip();
        (frame.agents, frame.observed) = (agents, observed.into_iter().collect());
        Ok(())
    }

    fn finish(mut self, path: &Path) -> Result<Run, String> {
        self.close()?;
        if self.frames.is_empty() {
            return Err("line 2: the run is empty: there is no row after the header".into());
        }
        Ok(Run { source: path.to_owned(), ids: self.ids, frames: self.frames })
    }
}
