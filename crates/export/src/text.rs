//! Text formats: one file for PedPy, one file for each agent for ChAOS.

use crate::error::ExportError;
use crate::run::Run;
use crowd_mechanics::files::{Staged, WriteError};
use std::io::{BufWriter, Write};
use std::path::Path;

/// Writes a text that `pedpy.load_trajectory` reads: `id frame x y z` in m, after the frame rate.
///
/// # Errors
/// No constant frame rate, or the file cannot be written.
pub fn pedpy(run: &Run, path: &Path) -> Result<(), ExportError> {
    let (rate, names) = (run.frame_rate()?, run.names());
    write(path, |out| {
        writeln!(out, "# framerate: {rate:?} fps")?;
        writeln!(out, "# id frame x/m y/m z/m")?;
        for (frame, at) in run.frames.iter().enumerate() {
            for (number, agent) in names.numbers.iter().zip(&at.agents) {
                writeln!(out, "{number} {frame} {:?} {:?} 0.0", agent.position.x, agent.position.y)?;
            }
        }
        Ok(())
    })
}

/// Writes `trajNNN.csv` for each agent, NNN its place among the agents: `t,x,y,0.0` in s and m, no header.
///
/// # Errors
/// The directory holds trajectories of more agents, or a file cannot be written.
pub fn chaos(run: &Run, directory: &Path) -> Result<(), ExportError> {
    let names: Vec<String> = (0..run.ids.len()).map(|place| format!("traj{place:03}.csv")).collect();
    own(directory, &names, |name| name.starts_with("traj") && name.ends_with(".csv"))?;
    for (place, name) in names.iter().enumerate() {
        write(&directory.join(name), |out| {
            for frame in &run.frames {
                let position = frame.agents[place].position;
                writeln!(out, "{:?},{:?},{:?},0.0", frame.time, position.x, position.y)?;
            }
            Ok(())
        })?;
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

fn write(
    path: &Path,
    content: impl FnOnce(&mut BufWriter<Staged>) -> std::io::Result<()>,
) -> Result<(), ExportError> {
    let written = || {
        let mut out = BufWriter::new(Staged::beside(path)?);
        content(&mut out)?;
        out.into_inner()?.persist()
    };
    Ok(written().map_err(WriteError::at(path))?)
}
