//! The table of a run: rows of agents at communication points, in CSV or Parquet, read and written.

mod csv;
mod format;
#[cfg(feature = "parquet")]
mod parquet;
mod rows;
mod write;

pub use format::{TableContent, TableFormat};
pub use write::{FrameWriter, TableWriter};

use crate::error::RecordError;
use crate::record::Record;
use crate::recorder::KeptFrames;
use crate::run::{Frame, Run};
use lemons_core::files::input;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::{Path, PathBuf};

/// Beginning of a file of Parquet.
const PARQUET: &[u8; 4] = b"PAR1";

/// Message of a build without the feature.
#[cfg(not(feature = "parquet"))]
const NO_PARQUET: &str = "this build has no Parquet: build with --features parquet";

impl Run {
    /// Reads a whole table into memory; see [`Record::table`].
    ///
    /// # Errors
    /// As [`Record::table`].
    pub fn read_table(path: &Path) -> Result<Run, RecordError> {
        Record::table(path)?.read_wanted(KeptFrames::All)
    }
}

impl Record {
    /// Opens the table of a run: CSV, or Parquet if the file begins as such, whatever its name is. All
    /// rows are read once.
    ///
    /// The table must have the columns [`TIME`](crate::columns::TIME), [`ID`](crate::columns::ID) and
    /// those of [`Motion`](crate::columns::Group::Motion), in any order. In CSV a header may have the unit
    /// (`x [m]`), in Parquet the metadata has it. Other columns of [`crate::columns`] are read if their
    /// whole group exists; further columns are ignored. Rows are in the order of time, and every agent
    /// has one row at each time.
    ///
    /// # Errors
    /// The file cannot be read, or something in it is wrong; the message names the line (CSV) or row
    /// (Parquet) and the column.
    pub fn table(path: &Path) -> Result<Record, RecordError> {
        Record::tables(&[path.to_owned()])
    }

    /// Opens several tables of one run, in the order of time: each but the first is that of a run which
    /// went on from the one before. If it begins with the frame at which the one before ends, this frame
    /// counts once.
    ///
    /// # Errors
    /// As [`Record::table`], a table has other agents than the first, or it begins before the end of the
    /// one before.
    pub fn tables(paths: &[PathBuf]) -> Result<Record, RecordError> {
        let tables = paths.iter().map(|path| open(path).map(|file| (path.clone(), file)));
        let tables = tables.collect::<Result<Vec<_>, _>>()?;
        let source = paths.first().cloned().unwrap_or_default();
        Record::new(&source, move |each| {
            let mut ids: Option<Vec<String>> = None;
            let mut end = f64::NEG_INFINITY;
            for (path, (file, parquet)) in &tables {
                let (before, mut first) = (end, true);
                let mut later = |frame: Frame| {
                    let time = frame.time;
                    if std::mem::take(&mut first) && time < before {
                        let message = format!(
                            "begins at t = {time:?} s, before the end of the table before it, t = {before:?} s"
                        );
                        return Err(RecordError::wrong(path, message));
                    }
                    end = time;
                    if time > before { each(frame) } else { Ok(()) }
                };
                let mut file = file.try_clone().map_err(cannot_read(path))?;
                file.rewind().map_err(cannot_read(path))?;
                let own = if *parquet {
                    read_parquet(path, file, &mut later)?
                } else {
                    csv::read(path, BufReader::new(file), &mut later)?
                };
                if ids.get_or_insert_with(|| own.clone()) != &own {
                    return Err(RecordError::wrong(path, "its agents are not those of the first table"));
                }
            }
            Ok(ids.unwrap_or_default())
        })
    }
}

fn cannot_read(path: &Path) -> impl FnOnce(io::Error) -> RecordError {
    move |error| RecordError::Read { path: path.to_owned(), error }
}

/// Opens a file that is read more than once; with whether it is Parquet.
fn open(path: &Path) -> Result<(File, bool), RecordError> {
    let mut file = input::open(path).map_err(cannot_read(path))?;
    let mut begin = Vec::new();
    file.by_ref().take(PARQUET.len() as u64).read_to_end(&mut begin).map_err(cannot_read(path))?;
    Ok((file, begin == PARQUET))
}

#[cfg(feature = "parquet")]
use parquet::read as read_parquet;

#[cfg(not(feature = "parquet"))]
fn read_parquet(path: &Path, _: File, _: &mut crate::record::Each<'_>) -> Result<Vec<String>, RecordError> {
    Err(RecordError::wrong(path, NO_PARQUET))
}
