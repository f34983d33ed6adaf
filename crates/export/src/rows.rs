//! The rows of the table that `lemons run` writes, in whatever format.

use crate::error::ExportError;
use crate::run::{Frame, Observed};
use crowd_mechanics::trial::AgentDynamics;
use std::collections::HashMap;

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

/// Read where these, too, are all there: tables of earlier versions have none of them.
pub(crate) const OF_STEP: [(&str, Option<&str>); 3] =
    [("mean_normal_force", Some("N")), ("peak_normal_force", Some("N")), ("peak_overlap", Some("m"))];

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

/// Why rows are read no further.
pub(crate) enum Stop {
    /// Something is wrong with them.
    Wrong(String),
    /// What is done with them failed.
    Error(ExportError),
}

impl From<String> for Stop {
    fn from(message: String) -> Stop {
        Stop::Wrong(message)
    }
}

impl From<ExportError> for Stop {
    fn from(error: ExportError) -> Stop {
        Stop::Error(error)
    }
}

/// Rows become frames.
pub(crate) struct Builder {
    /// What is counted in the file: lines or rows.
    what: &'static str,
    ids: Vec<String>,
    places: HashMap<String, usize>,
    /// Whether the newest frame is the first.
    first: bool,
    /// Time \[s\] and place of the newest frame.
    newest: Option<(f64, String)>,
    /// Of the newest frame, by place.
    agents: Vec<Option<Seen>>,
}

impl Builder {
    pub(crate) fn new(what: &'static str) -> Builder {
        let (ids, places, agents) = (Vec::new(), HashMap::new(), Vec::new());
        Builder { what, ids, places, first: true, newest: None, agents }
    }

    /// The `n`-th row; answers the frame before, if this is the first one of the next.
    pub(crate) fn add(&mut self, n: u64, time: f64, id: &str, agent: Seen) -> Result<Option<Frame>, String> {
        let what = self.what;
        let mut complete = None;
        match self.newest.as_ref().map(|(time, _)| *time) {
            Some(last) if time == last => {}
            Some(last) if time < last => {
                return Err(format!(
                    "{what} {n}: column t: t = {time:?} s must not come after t = {last:?} s"
                ));
            }
            _ => {
                complete = self.close()?;
                self.first = complete.is_none();
                self.newest = Some((time, format!("{what} {n}")));
            }
        }
        if id.is_empty() {
            return Err(format!("{what} {n}: column id: is empty"));
        }
        if self.first && !self.places.contains_key(id) {
            self.places.insert(id.to_owned(), self.ids.len());
            self.ids.push(id.to_owned());
            self.agents.push(None);
        }
        let Some(&place) = self.places.get(id) else {
            return Err(format!("{what} {n}: column id: agent {id:?} was not there at the first time"));
        };
        match self.agents[place].replace(agent) {
            Some(_) => Err(format!("{what} {n}: column id: agent {id:?} stands twice at t = {time:?} s")),
            None => Ok(complete),
        }
    }

    /// The newest frame, if there is one.
    fn close(&mut self) -> Result<Option<Frame>, String> {
        let Some((time, place)) = self.newest.take() else { return Ok(None) };
        let all = self.agents.iter_mut().zip(&self.ids).map(|(agent, id)| {
            agent.take().ok_or_else(|| format!("{place}: at t = {time:?} s agent {id:?} is missing"))
        });
        let (agents, observed): (_, Vec<_>) = all.collect::<Result<Vec<_>, _>>()?.into_iter().unzip();
        let observed = observed.into_iter().collect();
        Ok(Some(Frame { time, agents, observed, interactions: None, place }))
    }

    /// The last frame, and the Ids of all agents.
    pub(crate) fn finish(mut self) -> Result<(Frame, Vec<String>), String> {
        let last = self.close()?.ok_or("the run is empty: there is no row")?;
        Ok((last, self.ids))
    }
}
