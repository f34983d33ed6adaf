//! The rows of the table of a crowd, in whatever format.

use crate::columns::{AgentRow, Groups, ID, MOTION, Quantity, TIME, TOTALS};
use crate::error::RecordError;
use crate::run::{Frame, Totals};
use std::borrow::Cow;
use std::collections::HashMap;

/// The columns that are read of a table.
pub(super) struct ReadColumns {
    groups: Groups,
    quantities: Vec<&'static Quantity>,
}

/// Name and unit of a column.
pub(super) type Head = (&'static str, Option<&'static str>);

impl ReadColumns {
    /// Of a table in which these names exist.
    pub fn among(exists: impl Fn(&str) -> bool) -> ReadColumns {
        let groups = Groups::among(exists);
        ReadColumns { groups, quantities: groups.quantities().collect() }
    }

    /// The columns: time, Id, quantities.
    pub fn heads(&self) -> impl Iterator<Item = Head> {
        let quantities = self.quantities.iter().map(|quantity| (quantity.name, quantity.unit));
        [(TIME, Some("s")), (ID, None)].into_iter().chain(quantities)
    }

    /// Reads the time \[s\] and the quantities of a row; `place` says where it is in the file.
    fn read(&self, row: &impl Row, place: impl Fn() -> String) -> Result<(f64, AgentRow), String> {
        let wrong = |k: usize, name: &str, must: &str| {
            format!("{}: column {name}: {} is not {must}", place(), row.shown(k))
        };
        let time = row.number(0);
        if !time.is_finite() {
            return Err(wrong(0, TIME, "a finite number"));
        }
        let mut agent = AgentRow::default();
        for (k, quantity) in (2..).zip(&self.quantities) {
            let field = (quantity.field)(&mut agent);
            field.set(row.number(k)).map_err(|must| wrong(k, quantity.name, must))?;
        }
        Ok((time, agent))
    }
}

/// Finds a wanted column among the names and units of a table. A column without unit is in ours.
///
/// # Errors
/// There is none, there are two, or it has another unit.
pub(super) fn place<'a>(
    columns: impl Iterator<Item = (&'a str, Option<&'a str>)>,
    (name, unit): Head,
) -> Result<usize, String> {
    let mut found = columns.enumerate().filter(|(_, column)| column.0 == name);
    let Some((place, (_, there))) = found.next() else {
        let needed = [TIME, ID].into_iter().chain(MOTION.iter().map(|quantity| quantity.name));
        let needed = needed.collect::<Vec<_>>().join(", ");
        return Err(format!("there is no column {name:?} (lemons run writes {needed})"));
    };
    if found.next().is_some() {
        return Err(format!("there are two columns {name:?}"));
    }
    match there {
        Some(there) if Some(there) != unit => {
            let ours = unit.map_or("without unit".into(), |unit| format!("in {unit:?}"));
            Err(format!("column {name}: is in {there:?}, it must be {ours}"))
        }
        _ => Ok(place),
    }
}

/// A row of a table. Its cells have the places of their columns among those of [`ReadColumns::heads`].
pub(super) trait Row {
    /// The Id, in the second cell.
    fn id(&self) -> Cow<'_, str>;
    /// A number; NaN if the cell is none.
    fn number(&self, k: usize) -> f64;
    /// A cell, for messages.
    fn shown(&self, k: usize) -> String;
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

/// Makes frames of rows.
pub(super) struct Frames<'a> {
    wanted: &'a ReadColumns,
    /// What is counted in the file: lines or rows.
    what: &'static str,
    ids: Vec<String>,
    places: HashMap<String, usize>,
    /// Whether the newest frame is the first.
    first: bool,
    /// Time \[s\] and place of the newest frame.
    newest: Option<(f64, String)>,
    /// Rows of the newest frame, in the order of the Ids.
    agents: Vec<Option<AgentRow>>,
    totals: Totals,
}

impl<'a> Frames<'a> {
    pub fn new(wanted: &'a ReadColumns, what: &'static str) -> Frames<'a> {
        Frames {
            wanted,
            what,
            ids: Vec::new(),
            places: HashMap::new(),
            first: true,
            newest: None,
            agents: Vec::new(),
            totals: Totals::default(),
        }
    }

    /// Adds the `n`-th row; returns the previous frame if this row is the first of the next one.
    pub fn add(&mut self, n: u64, row: &impl Row) -> Result<Option<Frame>, String> {
        let what = self.what;
        let place = || format!("{what} {n}");
        let (time, agent) = self.wanted.read(row, place)?;
        let mut complete = None;
        match self.newest.as_ref().map(|(time, _)| *time) {
            Some(last) if time == last => {
                if agent.totals != self.totals {
                    let names = TOTALS.map(|quantity| quantity.name).join(", ");
                    return Err(format!("{}: columns {names}: differ from those of the row before", place()));
                }
            }
            Some(last) if time < last => {
                return Err(format!(
                    "{}: column t: t = {time:?} s must not come after t = {last:?} s",
                    place()
                ));
            }
            _ => {
                complete = self.close()?;
                self.first = complete.is_none();
                self.newest = Some((time, place()));
                self.totals = agent.totals;
            }
        }
        let id = row.id();
        if id.is_empty() {
            return Err(format!("{}: column id: is empty", place()));
        }
        if self.first && !self.places.contains_key(&*id) {
            self.places.insert(id.clone().into_owned(), self.ids.len());
            self.ids.push(id.clone().into_owned());
            self.agents.push(None);
        }
        let Some(&k) = self.places.get(&*id) else {
            return Err(format!("{}: column id: agent {id:?} was not there at the first time", place()));
        };
        match self.agents[k].replace(agent) {
            Some(_) => Err(format!("{}: column id: agent {id:?} stands twice at t = {time:?} s", place())),
            None => Ok(complete),
        }
    }

    /// The newest frame, if there is one.
    fn close(&mut self) -> Result<Option<Frame>, String> {
        let Some((time, place)) = self.newest.take() else { return Ok(None) };
        let rows = self.agents.iter_mut().zip(&self.ids).map(|(agent, id)| {
            agent.take().ok_or_else(|| format!("{place}: at t = {time:?} s agent {id:?} is missing"))
        });
        let rows = rows.collect::<Result<Vec<_>, _>>()?;
        Ok(Some(Frame { place, ..Frame::of_rows(time, &rows, self.wanted.groups) }))
    }

    /// The last frame, and the Ids of all agents.
    pub fn finish(mut self) -> Result<(Frame, Vec<String>), String> {
        let last = self.close()?.ok_or("the run is empty: there is no row")?;
        Ok((last, self.ids))
    }
}
