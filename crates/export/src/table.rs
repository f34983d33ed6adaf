//! The table that `lemons run` writes.

use crate::error::ExportError;
use crate::parquet;
use crate::record::{Each, Record};
use crate::rows::{Builder, COLUMNS, OBSERVED, OF_STEP, Stop, check_unit};
use crate::run::{Observed, OfStep, Run};
use crowd_mechanics::engine::{Vec2, vec2};
use crowd_mechanics::trial::AgentDynamics;
use lemons_files::input;
use std::fs::File;
use std::io::{self, BufReader, Read, Seek};
use std::path::{Path, PathBuf};

/// What a file of Parquet begins with.
const PARQUET: &[u8; 4] = b"PAR1";

impl Run {
    /// Reads a whole table into memory; see [`Record::table`].
    ///
    /// # Errors
    /// What is wrong, with line (CSV) or row (Parquet) and column.
    pub fn read_table(path: &Path) -> Result<Run, ExportError> {
        let mut frames = Vec::new();
        let ids = Table::open(path)?.pass(&mut |frame| {
            frames.push(frame);
            Ok(())
        })?;
        Ok(Run { source: path.to_owned(), ids, frames })
    }
}

impl Record {
    /// Of `trajectories.csv` or, whatever it is called, a table in Parquet: the columns t, id, x, y, vx, vy,
    /// theta, omega in any order, with units (`x [m]`) or without (in Parquet, as
    /// `lemons run` says them in the metadata), the contact counts and the squeeze where they are
    /// there, further ones do not matter; all agents at one time, then all at the next.
    ///
    /// # Errors
    /// What is wrong, with line (CSV) or row (Parquet) and column.
    pub fn table(path: &Path) -> Result<Record, ExportError> {
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
    fn open(path: &Path) -> Result<Table, ExportError> {
        let cannot = |error| ExportError::Read { path: path.to_owned(), error };
        let there = path.metadata().map_err(cannot)?;
        let mut file = if there.is_file() || there.is_dir() {
            input::open(path).map_err(cannot)?
        } else {
            // A pipe cannot go back.
            let mut given = input::open_given(path, input::LARGEST_PIPED_TABLE).map_err(cannot)?;
            let mut copy = tempfile::tempfile().map_err(cannot)?;
            io::copy(&mut given, &mut copy).map_err(cannot)?;
            copy.rewind().map_err(cannot)?;
            copy
        };
        let mut begin = Vec::new();
        file.by_ref().take(PARQUET.len() as u64).read_to_end(&mut begin).map_err(cannot)?;
        Ok(Table { path: path.to_owned(), file, parquet: begin == PARQUET })
    }

    fn pass(&self, each: &mut Each<'_>) -> Result<Vec<String>, ExportError> {
        let again = (&self.file).rewind().and_then(|()| self.file.try_clone());
        let file = again.map_err(|error| ExportError::Read { path: self.path.clone(), error })?;
        let read = if self.parquet { parquet::read(file, each) } else { read(BufReader::new(file), each) };
        read.map_err(|stop| match stop {
            Stop::Wrong(message) => ExportError::wrong(&self.path, message),
            Stop::Error(error) => error,
        })
    }
}

/// The name and the unit in the head of a column: `x`, or `x [m]`.
fn name_and_unit(head: &str) -> (&str, Option<&str>) {
    let head = head.trim_start_matches('\u{feff}');
    match head.strip_suffix(']').and_then(|head| head.rsplit_once('[')) {
        Some((name, unit)) => (name.trim_end(), Some(unit)),
        None => (head, None),
    }
}

/// Where a column is.
fn column(header: &csv::StringRecord, (name, unit): (&str, Option<&str>)) -> Result<usize, String> {
    let heads = header.iter().map(name_and_unit).enumerate();
    let mut found = heads.filter(|(_, head)| head.0 == name);
    let Some((place, (_, there))) = found.next() else {
        let names = COLUMNS.map(|(name, _)| name).join(", ");
        return Err(format!("line 1: there is no column {name:?} (lemons run writes {names})"));
    };
    if found.next().is_some() {
        return Err(format!("line 1: there are two columns {name:?}"));
    }
    check_unit(name, there, unit).map_err(|wrong| format!("line 1: {wrong}"))?;
    Ok(place)
}

/// Answers the Ids.
fn read(file: impl Read, each: &mut Each<'_>) -> Result<Vec<String>, Stop> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(file);
    let header = reader.headers().map_err(broken)?.clone();
    let mut columns = [0; COLUMNS.len()];
    for (place, name) in columns.iter_mut().zip(COLUMNS) {
        *place = column(&header, name)?;
    }
    let there = |name: &str| header.iter().any(|head| name_and_unit(head).0 == name);
    let all_of = |names: &[(&'static str, Option<&str>)]| -> Result<Option<Vec<usize>>, String> {
        if !names.iter().all(|(name, _)| there(name)) {
            return Ok(None);
        }
        names.iter().map(|name| column(&header, *name)).collect::<Result<_, _>>().map(Some)
    };
    let (observed, of_step) = (all_of(&OBSERVED)?, all_of(&OF_STEP)?);
    let mut builder = Builder::new("line");
    let mut row = csv::StringRecord::new();
    while reader.read_record(&mut row).map_err(broken)? {
        let line = row.position().map_or(0, csv::Position::line);
        let number = |k: usize| {
            let text = &row[columns[k]];
            let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
            value.ok_or_else(|| format!("line {line}: column {}: {text:?} is no finite number", COLUMNS[k].0))
        };
        let agent = AgentDynamics {
            position: vec2(number(2)?, number(3)?),
            velocity: vec2(number(4)?, number(5)?),
            theta: number(6)?,
            omega: number(7)?,
            fp: Vec2::ZERO,
            mp: 0.0,
        };
        let wrong = |name: &str, place: usize, what: &str| {
            format!("line {line}: column {name}: {:?} is no {what}", &row[place])
        };
        let size = |name: &str, place: usize, what: &str| {
            let value = row[place].parse::<f64>().ok().filter(|value| *value >= 0.0 && value.is_finite());
            value.ok_or_else(|| wrong(name, place, what))
        };
        let of_step = of_step.as_ref().map(|places| {
            let size = |k: usize, what| size(OF_STEP[k].0, places[k], what);
            Ok::<_, String>(OfStep {
                mean_normal_force: size(0, "squeeze in newtons")?,
                peak_normal_force: size(1, "squeeze in newtons")?,
                peak_overlap: size(2, "overlap in metres")?,
            })
        });
        let of_step = of_step.transpose()?;
        let seen = observed.as_ref().map(|places| {
            let count = |k: usize| {
                let count = row[places[k]].parse::<u32>();
                count.map_err(|_| wrong(OBSERVED[k].0, places[k], "number of contacts"))
            };
            Ok::<_, String>(Observed {
                agent_contacts: count(0)?,
                wall_contacts: count(1)?,
                contacting_agents: count(2)?,
                normal_force: size(OBSERVED[3].0, places[3], "squeeze in newtons")?,
                of_step,
            })
        });
        if let Some(frame) = builder.add(line, number(0)?, &row[columns[1]], (agent, seen.transpose()?))? {
            each(frame)?;
        }
    }
    let (last, ids) = builder.finish()?;
    each(last)?;
    Ok(ids)
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
