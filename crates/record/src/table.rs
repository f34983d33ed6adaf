//! The table of a run: rows of agents at communication points, in CSV or Parquet, read and written.

mod content;
mod csv;
mod digest;
mod format;
mod lent;
#[cfg(feature = "parquet")]
mod parquet;
mod rows;
mod write;

pub use content::{Content, Extent};
pub use format::Format;
pub use write::{FrameWriter, TableWriter};

use crate::error::RecordError;
use crate::record::{Each, Record};
use crate::run::Run;
use lemons_files::input;
use rows::Stop;
use std::fs::File;
use std::io::{BufReader, Read, Seek};
use std::path::{Path, PathBuf};

/// What a file of Parquet begins with.
const PARQUET: &[u8; 4] = b"PAR1";

impl Run {
    /// Reads a whole table into memory; see [`Record::table`].
    ///
    /// # Errors
    /// As [`Record::table`].
    pub fn read_table(path: &Path) -> Result<Run, RecordError> {
        let mut frames = Vec::new();
        let ids = Table::open(path)?.pass(&mut |frame| {
            frames.push(frame);
            Ok(())
        })?;
        Ok(Run { source: path.to_owned(), ids, frames })
    }
}

impl Record {
    /// Opens the table of a run: CSV, or Parquet if the file begins as such, whatever its name is. All rows are read
    /// once.
    ///
    /// The table must have the columns [`TIME`](crate::columns::TIME), [`ID`](crate::columns::ID) and those of
    /// [`MOTION`](crate::columns::MOTION), in any order. In CSV a header may have the unit (`x [m]`), in Parquet the
    /// metadata has it. Other columns of [`crate::columns`] are read if their whole group exists; further columns are
    /// ignored. Rows are in the order of time, and every agent has one row at each time.
    ///
    /// # Errors
    /// The file cannot be read, or something in it is wrong; the message names the line (CSV) or row (Parquet) and the
    /// column.
    pub fn table(path: &Path) -> Result<Record, RecordError> {
        let table = Table::open(path)?;
        Record::new(path, move |each| table.pass(each))
    }
}

/// A file that is read more than once.
struct Table {
    path: PathBuf,
    file: File,
    parquet: bool,
}

impl Table {
    fn open(path: &Path) -> Result<Table, RecordError> {
        let cannot = |error| RecordError::Read { path: path.to_owned(), error };
        let mut file = input::open(path).map_err(cannot)?;
        let mut begin = Vec::new();
        file.by_ref().take(PARQUET.len() as u64).read_to_end(&mut begin).map_err(cannot)?;
        Ok(Table { path: path.to_owned(), file, parquet: begin == PARQUET })
    }

    fn pass(&self, each: &mut Each<'_>) -> Result<Vec<String>, RecordError> {
        let again = (&self.file).rewind().and_then(|()| self.file.try_clone());
        let file = again.map_err(|error| RecordError::Read { path: self.path.clone(), error })?;
        let read =
            if self.parquet { read_parquet(file, each) } else { csv::read(BufReader::new(file), each) };
        read.map_err(|stop| match stop {
            Stop::Wrong(message) => RecordError::wrong(&self.path, message),
            Stop::Error(error) => error,
        })
    }
}

#[cfg(feature = "parquet")]
use parquet::read as read_parquet;

#[cfg(not(feature = "parquet"))]
fn read_parquet(_: File, _: &mut Each<'_>) -> Result<Vec<String>, Stop> {
    Err(Stop::Wrong("is Parquet, which this build does not read: only CSV".into()))
}
