//! The rows of the table of a crowd, in whatever format.

use crate::columns::{Groups, ID, MOTION, TIME, TOTALS};
use crate::error::RecordError;
use crate::run::{Frame, Observed, OfStep, Totals};
use lemons_plane::{Motion, Pose, Twist, vec2};
use std::borrow::Cow;
use std::collections::HashMap;

/// Name and unit of a column.
pub(super) type Head = (&'static str, Option<&'static str>);

/// The columns that are read of a table in which these names exist, in the order that [`read`] expects.
pub(super) fn heads(exists: impl Fn(&str) -> bool) -> (Groups, Vec<Head>) {
    let groups = Groups::among(exists);
    let quantities = groups.of_agent().chain(groups.of_crowd());
    let heads = [(TIME, Some("s")), (ID, None)].into_iter();
    (groups, heads.chain(quantities.map(|quantity| (quantity.name, quantity.unit))).collect())
}

/// What a table must have.
pub(super) fn missing(name: &str) -> String {
    let needed = [TIME, ID].into_iter().chain(MOTION.iter().map(|quantity| quantity.name));
    let needed = needed.collect::<Vec<_>>().join(", ");
    format!("there is no column {name:?} (lemons run writes {needed})")
}

/// A column without unit is in ours.
pub(super) fn check_unit(name: &str, there: Option<&str>, ours: Option<&str>) -> Result<(), String> {
    match there {
        Some(there) if Some(there) != ours => {
            let ours = ours.map_or("without unit".into(), |unit| format!("in {unit:?}"));
            Err(format!("column {name}: is in {there:?}, it must be {ours}"))
        }
        _ => Ok(()),
    }
}

/// A row of a table. Its cells have the places of their columns among those of [`heads`].
pub(super) trait Row {
    fn id(&self) -> Result<Cow<'_, str>, String>;
    fn real(&self, k: usize) -> Result<f64, String>;
    fn count(&self, k: usize) -> Result<u32, String>;
    /// A number that is not negative.
    fn size(&self, k: usize, what: &str) -> Result<f64, String>;
}

/// One agent at one time.
pub(super) struct Seen {
    motion: Motion,
    observed: Option<Observed>,
    active: Option<bool>,
    totals: Option<Totals>,
}

/// Reads the cells after time and Id.
pub(super) fn read(row: &impl Row, groups: Groups) -> Result<Seen, String> {
    const FORCE: &str = "squeeze in newtons";
    let motion = Motion {
        pose: Pose { position: vec2(row.real(2)?, row.real(3)?), orientation: row.real(6)? },
        twist: Twist { velocity: vec2(row.real(4)?, row.real(5)?), angular_velocity: row.real(7)? },
    };
    let of_step = || -> Result<OfStep, String> {
        Ok(OfStep {
            mean_normal_force: row.size(12, FORCE)?,
            peak_normal_force: row.size(13, FORCE)?,
            peak_overlap: row.size(14, "overlap in metres")?,
        })
    };
    let observed = || -> Result<Observed, String> {
        Ok(Observed {
            agent_contacts: row.count(8)?,
            wall_contacts: row.count(9)?,
            contacting_agents: row.count(10)?,
            normal_force: row.size(11, FORCE)?,
            of_step: groups.of_step.then(of_step).transpose()?,
        })
    };
    let first = 2 + groups.of_agent().count();
    let active = || match row.count(first - 1)? {
        0 => Ok(false),
        1 => Ok(true),
        other => Err(format!("{other} is neither 1 (there) nor 0 (left)")),
    };
    let totals = || -> Result<Totals, String> {
        Ok(Totals { agent_contacts: row.count(first)?, wall_contacts: row.count(first + 1)? })
    };
    Ok(Seen {
        motion,
        observed: groups.contacts.then(observed).transpose()?,
        active: groups.active.then(active).transpose()?,
        totals: groups.totals.then(totals).transpose()?,
    })
}

/// Why rows are read no further.
pub(super) enum Stop {
    /// Something is wrong with them.
    Wrong(String),
    /// What is done with them failed.
    Error(RecordError),
}

impl From<String> for Stop {
    fn from(message: String) -> Stop {
        Stop::Wrong(message)
    }
}

impl From<RecordError> for Stop {
    fn from(error: RecordError) -> Stop {
        Stop::Error(error)
    }
}

/// What a row says of an agent: its motion, what was observed, and whether it is there.
type OfAgent = (Motion, Option<Observed>, Option<bool>);

/// Rows become frames.
pub(super) struct Builder {
    /// What is counted in the file: lines or rows.
    what: &'static str,
    ids: Vec<String>,
    places: HashMap<String, usize>,
    /// Whether the newest frame is the first.
    first: bool,
    /// Time \[s\] and place of the newest frame.
    newest: Option<(f64, String)>,
    /// Of the newest frame.
    totals: Option<Totals>,
    /// Of the newest frame, by place.
    agents: Vec<Option<OfAgent>>,
}

impl Builder {
    pub(super) fn new(what: &'static str) -> Builder {
        let (ids, places, agents) = (Vec::new(), HashMap::new(), Vec::new());
        Builder { what, ids, places, first: true, newest: None, totals: None, agents }
    }

    /// Adds the `n`-th row; returns the previous frame if this row is the first of the next one.
    pub(super) fn add(&mut self, n: u64, time: f64, id: &str, seen: Seen) -> Result<Option<Frame>, String> {
        let what = self.what;
        let Seen { motion, observed, active, totals } = seen;
        let mut complete = None;
        match self.newest.as_ref().map(|(time, _)| *time) {
            Some(last) if time == last => {
                if totals != self.totals {
                    let names = TOTALS.map(|quantity| quantity.name).join(", ");
                    return Err(format!("{what} {n}: columns {names}: differ from those of the row before"));
                }
            }
            Some(last) if time < last => {
                return Err(format!(
                    "{what} {n}: column t: t = {time:?} s must not come after t = {last:?} s"
                ));
            }
            _ => {
                complete = self.close()?;
                self.first = complete.is_none();
                self.newest = Some((time, format!("{what} {n}")));
                self.totals = totals;
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
        match self.agents[place].replace((motion, observed, active)) {
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
        let all = all.collect::<Result<Vec<_>, _>>()?;
        let agents = all.iter().map(|(motion, ..)| *motion).collect();
        let observed = all.iter().map(|(_, observed, _)| *observed).collect();
        let active = all.iter().map(|(.., active)| *active).collect();
        Ok(Some(Frame { time, agents, observed, active, totals: self.totals, interactions: None, place }))
    }

    /// The last frame, and the Ids of all agents.
    pub(super) fn finish(mut self) -> Result<(Frame, Vec<String>), String> {
        let last = self.close()?.ok_or("the run is empty: there is no row")?;
        Ok((last, self.ids))
    }
}
