//! Text formats: one file for PedPy, one file for each agent for ChAOS.

use crate::error::RecordError;
use crate::record::Record;
use lemons_core::files::{Staged, WriteError};
use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes a text that `pedpy.load_trajectory` reads: the frame rate, then lines `id frame x y z`, with x, y, z in m.
/// Messages call the file `path`.
///
/// # Errors
/// The run has no constant frame rate, or the file cannot be written.
pub fn pedpy(record: &Record, file: Staged, path: &Path) -> Result<(), RecordError> {
    let (rate, numbers) = (record.frame_rate()?, record.numbers());
    let mut out = BufWriter::new(file);
    let head = writeln!(out, "# framerate: {rate:?} fps\n# id frame x/m y/m z/m");
    head.map_err(WriteError::at(path))?;
    let first = record.first_number();
    record.each(|k, frame| {
        let k = first + k as i64;
        // Who has left has no more rows there.
        let written = frame.present().try_for_each(|(place, agent)| {
            let number = numbers[place];
            writeln!(out, "{number} {k} {:?} {:?} 0.0", agent.pose.position.x, agent.pose.position.y)
        });
        Ok(written.map_err(WriteError::at(path))?)
    })?;
    ended(out, path)
}

/// Names of the files that [`chaos`] writes.
pub fn chaos_files(record: &Record) -> Vec<String> {
    (0..record.ids().len()).map(|place| format!("traj{place:03}.csv")).collect()
}

/// Writes a file `trajNNN.csv` for each agent into a directory; NNN is the agent's place, from 0. Lines are `t,x,y,0.0`,
/// with t in s, x and y in m. There is no header.
///
/// # Errors
/// The directory holds such files of other agents, or a file cannot be written.
pub fn chaos(record: &Record, directory: &Path) -> Result<(), RecordError> {
    let names = chaos_files(record);
    own(directory, &names, |name| name.starts_with("traj") && name.ends_with(".csv"))?;
    let mut frames = Vec::new();
    record.each(|_, frame| {
        let there = (0..names.len()).map(|k| frame.is_there(k).then(|| frame.agents[k].pose.position));
        frames.push((frame.time, there.collect::<Vec<_>>()));
        Ok(())
    })?;
    for (k, name) in names.iter().enumerate() {
        let path = directory.join(name);
        let mut out = BufWriter::new(Staged::beside(&path).map_err(WriteError::at(&path))?);
        let mut rows = frames.iter().filter_map(|(time, positions)| Some((time, positions[k]?)));
        let written = rows.try_for_each(|(time, p)| writeln!(out, "{time:?},{:?},{:?},0.0", p.x, p.y));
        written.map_err(WriteError::at(&path))?;
        ended(out, &path)?;
    }
    Ok(())
}

/// Makes a directory for these files; those of the same kind that an earlier export left would be read as this one's.
pub(crate) fn own(
    directory: &Path,
    names: &[String],
    kind: impl Fn(&str) -> bool,
) -> Result<(), RecordError> {
    lemons_core::files::make_directories(directory).map_err(WriteError::at(directory))?;
    let names: std::collections::BTreeSet<&str> = names.iter().map(String::as_str).collect();
    match files_of(directory, kind)?.iter().find(|name| !names.contains(name.as_str())) {
        Some(stranger) => {
            let message = "is of another run and would be taken for this one's: choose an empty directory";
            Err(RecordError::wrong(&directory.join(stranger), message))
        }
        None => Ok(()),
    }
}

/// The names of a kind in a directory, which need not exist, sorted.
pub(crate) fn files_of(directory: &Path, kind: impl Fn(&str) -> bool) -> Result<Vec<String>, RecordError> {
    let cannot = |error| RecordError::Read { path: directory.to_owned(), error };
    let entries = match std::fs::read_dir(directory) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries.map_err(cannot)?,
    };
    let mut names = Vec::new();
    for entry in entries {
        let name = entry.map_err(cannot)?.file_name().to_string_lossy().into_owned();
        names.extend(kind(&name).then_some(name));
    }
    names.sort();
    Ok(names)
}

fn ended(out: BufWriter<Staged>, path: &Path) -> Result<(), RecordError> {
    let file = out.into_inner().map_err(|error| error.into_error());
    Ok(file.and_then(Staged::persist).map_err(WriteError::at(path))?)
}
