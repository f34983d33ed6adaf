//! Writes tables row by row, and goes on with those that were written before.

use super::content::{Content, Extent, check_headings};
use super::csv;
use super::format::Format;
use super::lent::{Lent, Sink};
#[cfg(feature = "parquet")]
use super::parquet;
use crate::columns::Groups;
use crate::error::RecordError;
use crate::run::{Frame, Observed, OfStep, Totals};
use lemons_columns::Cell;
use lemons_files::WriteError;
use lemons_plane::{Motion, Pose, Twist};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Writes a table with any columns after the time. The table is complete after [`TableWriter::finish`], and of no use
/// after an error. The same rows give the same bytes, also if they are written by several writers one after the other
/// ([`TableWriter::resume`]).
pub struct TableWriter<W> {
    file: Lent<W>,
    table: Table,
}

impl<W: Write + Send + 'static> TableWriter<W> {
    /// Begins a table in an empty file, which messages call `path`.
    ///
    /// # Errors
    /// Two columns have the same name (Parquet), or the file cannot be written.
    pub fn create(file: W, path: &Path, format: Format, content: &Content) -> Result<Self, RecordError> {
        let (file, sink) = Lent::new(file);
        Ok(TableWriter { file, table: Table::create(sink, path, format, content)? })
    }

    /// Goes on with the table at `path`, of which `kept` was written before: its rows are copied into the empty `file`,
    /// which is to replace it.
    ///
    /// # Errors
    /// [`RecordError::NotContinued`]: the table at `path` has other columns, units, types, a different number of rows,
    /// another last time or other rows, or it cannot be copied.
    pub fn resume(
        file: W,
        path: &Path,
        format: Format,
        content: &Content,
        kept: Extent,
    ) -> Result<Self, RecordError> {
        let (file, sink) = Lent::new(file);
        Ok(TableWriter { file, table: Table::resume(sink, path, format, content, kept)? })
    }

    /// Writes a row: the time \[s\], and the cells of the other columns.
    ///
    /// # Errors
    /// A cell has not the type of its column or is missing (Parquet), or the file cannot be written.
    pub fn row<'a>(
        &mut self,
        time: f64,
        cells: impl IntoIterator<Item = Cell<'a>>,
    ) -> Result<(), RecordError> {
        self.table.row(time, &mut cells.into_iter())
    }

    /// What was written so far, with the rows of writers before.
    pub fn extent(&self) -> Extent {
        self.table.extent
    }

    /// What messages call the file.
    pub fn path(&self) -> &Path {
        &self.table.path
    }

    /// Completes the table and returns its file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(self) -> Result<W, RecordError> {
        self.table.finish(self.file)
    }
}

/// A table, whatever its file is.
struct Table {
    rows: Rows,
    /// For messages.
    path: PathBuf,
    names: Vec<String>,
    extent: Extent,
}

enum Rows {
    Csv(Box<csv::Writer<Sink>>),
    #[cfg(feature = "parquet")]
    Parquet(Box<parquet::Writer<Sink>>),
}

impl Table {
    fn create(sink: Sink, path: &Path, format: Format, content: &Content) -> Result<Table, RecordError> {
        let made = match format {
            Format::Csv => {
                csv::Writer::create(sink, &content.columns).map(|writer| Rows::Csv(Box::new(writer)))
            }
            #[cfg(feature = "parquet")]
            Format::Parquet => {
                let made = parquet::Writer::create(sink, content).map_err(std::io::Error::other);
                made.map(|writer| Rows::Parquet(Box::new(writer)))
            }
        };
        let rows = made.map_err(WriteError::at(path))?;
        Ok(Table::with(rows, path, content, Extent::default()))
    }

    fn resume(
        sink: Sink,
        path: &Path,
        format: Format,
        content: &Content,
        kept: Extent,
    ) -> Result<Table, RecordError> {
        let made = match format {
            Format::Csv => csv::Writer::resume(sink, &content.columns, path, kept)
                .map(|writer| Rows::Csv(Box::new(writer))),
            #[cfg(feature = "parquet")]
            Format::Parquet => parquet::Writer::resume(sink, content, path, kept)
                .map(|writer| Rows::Parquet(Box::new(writer))),
        };
        let wrong = |message| RecordError::NotContinued { path: path.to_owned(), message };
        Ok(Table::with(made.map_err(wrong)?, path, content, kept))
    }

    fn with(rows: Rows, path: &Path, content: &Content, extent: Extent) -> Table {
        let names = content.columns.iter().map(|column| column.name.clone()).collect();
        Table { rows, path: path.to_owned(), names, extent }
    }

    fn row<'a>(&mut self, time: f64, cells: &mut dyn Iterator<Item = Cell<'a>>) -> Result<(), RecordError> {
        let cells = std::iter::once(Cell::Real(time)).chain(cells);
        let written = match &mut self.rows {
            Rows::Csv(rows) => rows.row(cells),
            #[cfg(feature = "parquet")]
            Rows::Parquet(rows) => rows.row(cells).map_err(std::io::Error::other),
        };
        written.map_err(WriteError::at(&self.path))?;
        let digest = match &self.rows {
            Rows::Csv(rows) => rows.digest(),
            #[cfg(feature = "parquet")]
            Rows::Parquet(rows) => rows.digest(),
        };
        self.extent = Extent { rows: self.extent.rows + 1, last: Some(time), digest };
        Ok(())
    }

    fn finish<W: Write + Send + 'static>(self, file: Lent<W>) -> Result<W, RecordError> {
        let done = match self.rows {
            Rows::Csv(rows) => rows.finish(),
            #[cfg(feature = "parquet")]
            Rows::Parquet(rows) => rows.finish().map_err(std::io::Error::other),
        };
        Ok(done.and_then(|sink| file.back(sink)).map_err(WriteError::at(&self.path))?)
    }
}

/// Writes the table of a crowd frame by frame: what [`Record::table`](crate::Record::table) reads.
pub struct FrameWriter<W> {
    file: Lent<W>,
    frames: Frames,
}

impl<W: Write + Send + 'static> FrameWriter<W> {
    /// Writes frames of the agents with these Ids into a table whose columns are [`Groups::columns`].
    ///
    /// # Errors
    /// The table has other columns.
    pub fn new(writer: TableWriter<W>, ids: Vec<String>, groups: Groups) -> Result<Self, RecordError> {
        let TableWriter { file, table } = writer;
        let own = groups.columns().into_iter().map(|column| column.name);
        check_headings(table.names.iter().cloned(), own)
            .map_err(|message| RecordError::wrong(&table.path, message))?;
        Ok(FrameWriter { file, frames: Frames { table, ids, groups } })
    }

    /// Writes a row for each agent.
    ///
    /// # Errors
    /// The frame has not one value for each agent in each column of the table, a count is larger than 2³¹ − 1, or the
    /// file cannot be written.
    pub fn frame(&mut self, frame: &Frame) -> Result<(), RecordError> {
        self.frames.write(frame)
    }

    /// What was written so far, with the rows of writers before.
    pub fn extent(&self) -> Extent {
        self.frames.table.extent
    }

    /// Ids of the agents.
    pub fn ids(&self) -> &[String] {
        &self.frames.ids
    }

    /// Completes the table and returns its file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn finish(self) -> Result<W, RecordError> {
        self.frames.table.finish(self.file)
    }
}

/// A table of frames.
struct Frames {
    table: Table,
    ids: Vec<String>,
    groups: Groups,
}

impl Frames {
    fn write(&mut self, frame: &Frame) -> Result<(), RecordError> {
        self.check(frame).map_err(|what| {
            let message = format!("the frame at t = {:?} s {what}", frame.time);
            RecordError::wrong(&self.table.path, message)
        })?;
        let totals = frame.totals.filter(|_| self.groups.totals);
        for (k, id) in self.ids.iter().enumerate() {
            let observed = frame.observed.as_ref().filter(|_| self.groups.contacts).map(|all| all[k]);
            let of_step = observed.and_then(|seen| seen.of_step).filter(|_| self.groups.of_step);
            let mut cells = std::iter::once(Cell::Text(id))
                .chain(of_motion(frame.agents[k]))
                .chain(observed.into_iter().flat_map(of_contacts))
                .chain(of_step.into_iter().flat_map(of_the_step))
                .chain(self.groups.active.then(|| count(frame.is_there(k).into())))
                .chain(totals.into_iter().flat_map(of_crowd));
            self.table.row(frame.time, &mut cells)?;
        }
        Ok(())
    }

    /// Whether the frame has what the columns are for.
    fn check(&self, frame: &Frame) -> Result<(), String> {
        let agents = self.ids.len();
        if frame.agents.len() != agents {
            return Err(format!("has {} agents, the table {agents}", frame.agents.len()));
        }
        let observed = frame.observed.as_deref().unwrap_or_default();
        if self.groups.contacts && observed.len() != agents {
            return Err("has not the contacts of all agents".into());
        }
        if self.groups.of_step && observed.iter().any(|seen| seen.of_step.is_none()) {
            return Err("has no means and peaks of the step".into());
        }
        if self.groups.active && frame.active.as_ref().is_none_or(|active| active.len() != agents) {
            return Err("does not say who is there".into());
        }
        if self.groups.totals && frame.totals.is_none() {
            return Err("has no contacts of the whole crowd".into());
        }
        let counts = observed
            .iter()
            .flat_map(|seen| [seen.agent_contacts, seen.wall_contacts, seen.contacting_agents]);
        let totals = frame.totals.into_iter().flat_map(|all| [all.agent_contacts, all.wall_contacts]);
        match counts.chain(totals).max() {
            Some(most) if i32::try_from(most).is_err() => {
                Err(format!("has {most} contacts, which is too many"))
            }
            _ => Ok(()),
        }
    }
}

/// In the order of [`crate::columns::MOTION`].
fn of_motion<'a>(motion: Motion) -> [Cell<'a>; 6] {
    let Motion { pose: Pose { position, orientation }, twist: Twist { velocity, angular_velocity } } = motion;
    [position.x, position.y, velocity.x, velocity.y, orientation, angular_velocity].map(Cell::Real)
}

/// A count that was checked.
fn count<'a>(value: u32) -> Cell<'a> {
    Cell::Integer(value.cast_signed())
}

/// In the order of [`crate::columns::CONTACTS`], then the squeeze.
fn of_contacts<'a>(seen: Observed) -> [Cell<'a>; 4] {
    let Observed { agent_contacts, wall_contacts, contacting_agents, normal_force, .. } = seen;
    let [agents, walls, others] = [agent_contacts, wall_contacts, contacting_agents].map(count);
    [agents, walls, others, Cell::Real(normal_force)]
}

/// In the order of [`crate::columns::OF_STEP`].
fn of_the_step<'a>(step: OfStep) -> [Cell<'a>; 3] {
    [step.mean_normal_force, step.peak_normal_force, step.peak_overlap].map(Cell::Real)
}

/// In the order of [`crate::columns::TOTALS`].
fn of_crowd<'a>(totals: Totals) -> [Cell<'a>; 2] {
    [totals.agent_contacts, totals.wall_contacts].map(count)
}
