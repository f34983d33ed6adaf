//! The record of a run, as it is given to commands: in memory, or as files; with its Trial, and the area around its people.

use anyhow::{Context, Result, anyhow};
use crowd_mechanics::setup;
use lemons_core::files::input;
use lemons_core::trial::{Trial, Wall};
use lemons_decision::Plan;
use lemons_master::{FileType, Fmu, TrialInput};
use lemons_results::{Area, Record, Run, given_area, given_area_of_heads, measured_area, walkable_area};
use std::path::{Path, PathBuf};

/// A run in memory, in the place of a table and of its Trial.
#[derive(Debug)]
pub struct InMemory {
    /// Its frames; the source is what messages call it.
    pub run: Run,
    /// Shapes and walls.
    pub trial: Trial,
    /// Plan of its people.
    pub plan: Option<Plan>,
}

/// Checks that a file can be the table of a run; what is in it is read later.
pub fn expect_table(path: &Path) -> Result<()> {
    let tables = [
        FileType::TEXT,
        FileType::BINARY,
        FileType::PARQUET,
        FileType::SQLITE,
        FileType::STREAM,
        FileType::TRIAL,
        FileType::DIRECTORY,
    ];
    Ok(FileType::expect(path, &tables, "a table that lemons run wrote (CSV, Parquet)")?)
}

/// Opens the record of a run: in memory, in the XML series of an OutputDirectory, or in tables; with a Trial, its agents are in
/// the Trial's order.
pub fn recorded(
    source: &Path,
    more: &[PathBuf],
    memory: Option<&InMemory>,
    trial: Option<&Trial>,
) -> Result<Record> {
    let record = match (memory, trial) {
        (Some(memory), _) => memory.run.clone().into(),
        (None, Some(trial)) if source.is_dir() => return Ok(Record::series(source, trial)?),
        _ => Record::tables(&[&[source.to_owned()], more].concat())?,
    };
    match trial {
        Some(trial) => Ok(record.of_trial(trial)?),
        None => Ok(record),
    }
}

/// \[bytes\] A polygon of more is a mistake.
const LARGEST_AREA: u64 = 16 << 20;

/// Returns the walkable area: given by an option, or from the walls.
pub fn area(run: &Record, given: (&str, Option<&Path>), walls: &[Wall]) -> Result<Area> {
    let positions = run.positions()?;
    let positions = positions.iter().copied();
    let (option, given) = given;
    if let Some(path) = given {
        let named = || format!("{option} {}", path.display());
        let text = input::read_text(path, LARGEST_AREA).with_context(named)?;
        return given_area(&text, positions).map_err(|wrong| anyhow!("{}: {wrong}", named()));
    }
    Ok(walkable_area(walls, positions))
}

/// Returns the area of people whose heads were measured, as [`area`] does: those who lean over its rim are not looked at. `None`
/// if walls are around some of the others only.
pub fn area_of_heads(run: &Record, given: (&str, Option<&Path>), walls: &[Wall]) -> Result<Option<Area>> {
    let positions = run.positions()?;
    let (option, Some(path)) = given else { return Ok(measured_area(walls, &positions)) };
    let named = || format!("{option} {}", path.display());
    let text = input::read_text(path, LARGEST_AREA).with_context(named)?;
    Ok(Some(given_area_of_heads(&text, &positions).map_err(|wrong| anyhow!("{}: {wrong}", named()))?))
}

/// Reads the Trial or FMU that was given with the record of a run, else the Trial of a run in memory, or the Trial
/// directory that a series lies in.
pub fn trial_of(source: &Path, given: Option<&Path>, memory: Option<&InMemory>) -> Result<Option<Trial>> {
    if let (None, Some(memory)) = (given, memory) {
        return Ok(Some(memory.trial.clone()));
    }
    let Some(path) = given else {
        let own = source.canonicalize().ok().filter(|source| source.is_dir());
        let mut around = own.iter().flat_map(|own| own.ancestors().take(2));
        let Some(path) = around.find(|path| path.join("Parameters.xml").is_file()) else { return Ok(None) };
        crate::files::reads(path, &source.display().to_string());
        return Ok(Some(setup::read(path)?.0));
    };
    if let Some(given) = TrialInput::find(path)? {
        return Ok(Some(given.read()?.0));
    }
    let fmu = Fmu::open(path)?;
    let resources = fmu.resources().with_context(|| path.display().to_string())?;
    if resources.names().len() > 1 {
        note!("warning: {} holds several Trials: {:?} is taken", path.display(), resources.first());
    }
    Ok(Some(fmu.trial(None)?))
}
