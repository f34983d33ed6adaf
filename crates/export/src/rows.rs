//! The rows of the table that `lemons run` writes, in whatever format.

use crate::run::{Frame, Observed, Run};
use crowd_mechanics::trial::AgentDynamics;
use std::collections::HashMap;
use std::path::Path;

/// With their units.
pub(crate) const COLUMNS: [(&str, Option<&str>); 8] = [
    ("t", Some("s")),
    ("id", None),
    ("x", Some("m")),
    ("y", Some("m")),
    ("vx", Some("m/s")),
    ("vy", Some("m/s")),
    ("theta", Some("rad")),
    ("omega", Some("rad/s")),
];
/// Read where all of them are there.
pub(crate) const OBSERVED: [(&str, Option<&str>); 4] = [
    ("agent_contacts", None),
    ("wall_contacts", None),
    ("contacting_agents", None),
    ("normal_force", Some("N")),
];

/// A column without unit is in ours.
pub(crate) fn check_unit(name: &str, there: Option<&str>, ours: Option<&str>) -> Result<(), String> {
    match there {
        Some(there) if Some(there) != ours => {
            let ours = ours.map_or("without unit".into(), |unit| format!("in {unit:?}"));
            Err(format!("column {name}: is in {there:?}, it must be {ours}"))
        }
        _ => Ok(()),
    }
}

/// Of one agent at one time.
pub(crate) type Seen = (AgentDynamics, Option<Observed>);

/// Rows become frames.
pub(crate) struct Builder {
    /// What is counted in the file: lines or rows.
    what: &'static str,
    ids: Vec<String>,
    places: HashMap<String, usize>,
    frames: Vec<Frame>,
    /// Of the newest frame, by place.
    agents: Vec<Option<Seen>>,
}

impl Builder {
    pub(crate) fn new(what: &'static str) -> Builder {
        Builder { what, ids: Vec::new(), places: HashMap::new(), frames: Vec::new(), agents: Vec::new() }
    }

    /// The `n`-th row.
    pub(crate) fn add(&mut self, n: u64, time: f64, id: &str, agent: Seen) -> Result<(), String> {
        let what = self.what;
        match self.frames.last().map(|frame| frame.time) {
            Some(last) if time == last => {}
            Some(last) if time < last => {
                return Err(format!(
                    "{what} {n}: column t: t = {time:?} s must not come after t = {last:?} s"
                ));
            }
            _ => {
                self.close()?;
                let place = format!("{what} {n}");
                let (agents, observed, interactions) = (Vec::new(), None, None);
                self.frames.push(Frame { time, agents, observed, interactions, place });
            }
        }
        if id.is_empty() {
            return Err(format!("{what} {n}: column id: is empty"));
        }
        if self.frames.len() == 1 && !self.places.contains_key(id) {
            self.places.insert(id.to_owned(), self.ids.len());
            self.ids.push(id.to_owned());
            self.agents.push(None);
        }
        let Some(&place) = self.places.get(id) else {
            return Err(format!("{what} {n}: column id: agent {id:?} was not there at the first time"));
        };
        match self.agents[place].replace(agent) {
            Some(_) => Err(format!("{what} {n}: column id: agent {id:?} stands twice at t = {time:?} s")),
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

    pub(crate) fn finish(mut self, path: &Path) -> Result<Run, String> {
        self.close()?;
        if self.frames.is_empty() {
            return Err("the run is empty: there is no row".into());
        }
        Ok(Run { source: path.to_owned(), ids: self.ids, frames: self.frames })
    }
}
