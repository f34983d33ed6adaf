//! The rows of the table of a crowd, in whatever format.

use crate::columns::{AgentRow, Group, Groups, ID, RecordedQuantity, TIME};
use crate::error::RecordError;
use crate::record::Each;
use crate::run::Frame;
use crate::trajectories::READ;
use std::borrow::Cow;
use std::collections::HashMap;
use std::path::Path;

/// Name and unit of a column.
pub(super) type Head = (&'static str, Option<&'static str>);

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
        let needed = [TIME, ID].into_iter().chain(Group::Motion.quantities().map(|quantity| quantity.name));
        let needed = needed.collect::<Vec<_>>().join(", ");
        return Err(format!(
            "there is no column {name:?} (lemons run writes {needed}; of other programs are read: \
                            {})",
            *READ
        ));
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

/// A row of a table. Its cells have the places of their columns among those of [`Frames::heads`].
pub(super) trait Cells {
    /// Returns the Id, in the second cell.
    fn id(&self) -> Cow<'_, str>;
    /// Returns a number; NaN if the cell is none.
    fn number(&self, k: usize) -> f64;
    /// Returns a cell, for messages.
    fn text(&self, k: usize) -> String;
}

/// Makes frames of rows.
pub(super) struct Frames<'a, 'b> {
    path: &'a Path,
    each: &'a mut Each<'b>,
    /// Unit of the file's length: lines or rows.
    what: &'static str,
    groups: Groups,
    /// Quantities that are read, with their places in a row.
    quantities: Vec<(usize, &'static RecordedQuantity)>,
    ids: Vec<String>,
    places: HashMap<String, usize>,
    /// Time \[s\], place and first row of the newest frame.
    newest: Option<(f64, String, AgentRow)>,
    /// True while the newest frame is the first.
    first: bool,
    /// Its rows, in the order of the Ids.
    rows: Vec<Option<AgentRow>>,
}

impl<'a, 'b> Frames<'a, 'b> {
    /// Begins to read a table in which these columns exist.
    pub fn new(
        path: &'a Path,
        exists: impl Fn(&str) -> bool,
        what: &'static str,
        each: &'a mut Each<'b>,
    ) -> Frames<'a, 'b> {
        let groups = Groups::among(exists);
        Frames {
            path,
            each,
            what,
            groups,
            quantities: groups.quantities().collect(),
            ids: Vec::new(),
            places: HashMap::new(),
            newest: None,
            first: true,
            rows: Vec::new(),
        }
    }

    /// Returns the columns that are read: time, Id, quantities.
    pub fn heads(&self) -> Vec<Head> {
        let quantities = self.quantities.iter().map(|(_, quantity)| (quantity.name, quantity.unit));
        [(TIME, Some("s")), (ID, None)].into_iter().chain(quantities).collect()
    }

    /// Adds the `n`-th row; if it is the first of the next frame, the frame before is complete.
    pub fn add(&mut self, n: u64, cells: &impl Cells) -> Result<(), RecordError> {
        let (path, what) = (self.path, self.what);
        let at = |message: String| RecordError::wrong(path, format!("{what} {n}: {message}"));
        let wrong =
            |k: usize, name: &str, must: &str| at(format!("column {name}: {} is not {must}", cells.text(k)));
        let time = cells.number(0);
        if !time.is_finite() {
            return Err(wrong(0, TIME, "a finite number"));
        }
        let mut row = AgentRow::default();
        for (k, (place, quantity)) in (2..).zip(&self.quantities) {
            row[*place] = cells.number(k);
            quantity.check(row[*place], false).map_err(|must| wrong(k, quantity.name, must))?;
        }
        match &self.newest {
            Some((last, _, first)) if time == *last => {
                let mut totals = self.quantities.iter().filter(|(_, of)| of.group == Group::Totals);
                if totals.any(|(place, _)| first[*place] != row[*place]) {
                    let names = Group::Totals.quantities().map(|quantity| quantity.name);
                    let names = names.collect::<Vec<_>>().join(", ");
                    return Err(at(format!("columns {names}: differ from those of the row before")));
                }
            }
            Some((last, ..)) if time < *last => {
                return Err(at(format!("column t: t = {time:?} s must not come after t = {last:?} s")));
            }
            last => {
                self.first = last.is_none();
                self.complete()?;
                self.newest = Some((time, format!("{what} {n}"), row));
            }
        }
        let id = cells.id();
        if id.is_empty() {
            return Err(at("column id: is empty".into()));
        }
        if self.first && !self.places.contains_key(&*id) {
            self.places.insert(id.to_string(), self.ids.len());
            self.ids.push(id.to_string());
            self.rows.push(None);
        }
        let Some(&k) = self.places.get(&*id) else {
            return Err(at(format!("column id: agent {id:?} was not there at the first time")));
        };
        match self.rows[k].replace(row) {
            Some(_) => Err(at(format!("column id: agent {id:?} stands twice at t = {time:?} s"))),
            None => Ok(()),
        }
    }

    /// Completes the newest frame, if there is one.
    fn complete(&mut self) -> Result<(), RecordError> {
        let Some((time, place, _)) = self.newest.take() else { return Ok(()) };
        let missing = |id| format!("{place}: at t = {time:?} s agent {id:?} is missing");
        let rows = self.rows.iter_mut().zip(&self.ids);
        let rows = rows.map(|(row, id)| row.take().ok_or_else(|| RecordError::wrong(self.path, missing(id))));
        let rows = rows.collect::<Result<Vec<_>, _>>()?;
        (self.each)(Frame { place, ..self.groups.frame_of_rows(time, &rows) })
    }

    /// Completes the last frame, and returns the Ids of all agents.
    pub fn finish(mut self) -> Result<Vec<String>, RecordError> {
        if self.newest.is_none() {
            return Err(RecordError::wrong(self.path, "the run is empty: there is no row"));
        }
        self.complete()?;
        Ok(self.ids)
    }
}
