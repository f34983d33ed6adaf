//! Text formats: one file for PedPy, one file for each agent for ChAOS.

use crate::error::ExportError;
use crate::record::Record;
use crowd_mechanics::files::{Staged, WriteError};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

/// Writes a text that `pedpy.load_trajectory` reads: `id frame x y z` in m, after the frame rate.
///
/// # Errors
/// No constant frame rate, or the file cannot be written.
pub fn pedpy(record: &Record, path: &Path) -> Result<(), ExportError> {
    let (rate, names) = (record.frame_rate()?, record.names());
    let mut out = begun(path)?;
    let cannot = WriteError::at(path);
    let head = writeln!(out, "# framerate: {rate:?} fps\n# id frame x/m y/m z/m");
    head.map_err(cannot)?;
    record.each(|k, frame| {
        let mut rows = names.numbers.iter().zip(&frame.agents);
        let written = rows.try_for_each(|(number, agent)| {
            writeln!(out, "{number} {k} {:?} {:?} 0.0", agent.position.x, agent.position.y)
        });
        Ok(written.map_err(WriteError::at(path))?)
    })?;
    ended(out, path)
}

/// Files that are written at once.
const TOGETHER: usize = 64;

/// The files that [`chaos`] writes.
pub fn chaos_files(record: &Record) -> Vec<String> {
    (0..record.ids().len()).map(|place| format!("traj{place:03}.csv")).collect()
}

/// Writes `trajNNN.csv` for each agent, NNN its place among the agents: `t,x,y,0.0` in s and m, no header.
///
/// # Errors
/// The directory holds trajectories of more agents, or a file cannot be written.
pub fn chaos(record: &Record, directory: &Path) -> Result<(), ExportError> {
    let names = chaos_files(record);
    own(directory, &names, |name| name.starts_with("traj") && name.ends_with(".csv"))?;
    let paths: Vec<PathBuf> = names.iter().map(|name| directory.join(name)).collect();
    let positions = record.positions()?;
    for (group, paths) in paths.chunks(TOGETHER).enumerate() {
        let first = group * TOGETHER;
        let files = paths.iter().map(|path| Ok((begun(path)?, path)));
        let mut files = files.collect::<Result<Vec<_>, ExportError>>()?;
        for (time, positions) in record.times().zip(positions.of(first..first + paths.len())) {
            for ((out, path), position) in files.iter_mut().zip(positions) {
                let written = writeln!(out, "{time:?},{:?},{:?},0.0", position.x, position.y);
                written.map_err(WriteError::at(path))?;
            }
        }
        positions.check().map_err(WriteError::at(directory))?;
        files.into_iter().try_for_each(|(out, path)| ended(out, path))?;
    }
    Ok(())
}

/// Makes a directory for these files; those of the same kind that an earlier export left would be read as this one's.
pub(crate) fn own(
    directory: &Path,
    names: &[String],
    kind: impl Fn(&str) -> bool,
) -> Result<(), ExportError> {
    std::fs::create_dir_all(directory).map_err(WriteError::at(directory))?;
    let names: std::collections::BTreeSet<&str> = names.iter().map(String::as_str).collect();
    let cannot = |error| ExportError::Read { path: directory.to_owned(), error };
    for entry in std::fs::read_dir(directory).map_err(cannot)? {
        let name = entry.map_err(cannot)?.file_name();
        let name = name.to_string_lossy();
        if kind(&name) && !names.contains(&*name) {
            let message = "is of another run and would be taken for this one's: choose an empty directory";
            return Err(ExportError::wrong(&directory.join(&*name), message));
        }
    }
    Ok(())
}

fn begun(path: &Path) -> Result<BufWriter<Staged>, ExportError> {
    Ok(BufWriter::new(Staged::beside(path).map_err(WriteError::at(path))?))
}

fn ended(out: BufWriter<Staged>, path: &Path) -> Result<(), ExportError> {
    let file = out.into_inner().map_err(|error| error.into_error());
    Ok(file.and_then(Staged::persist).map_err(WriteError::at(path))?)
}
