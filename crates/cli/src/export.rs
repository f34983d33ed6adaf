//! `lemons export`: a run for the field's tools, and a Trial that goes on where it ended.

use crate::embedded::InMemory;
use crate::error::Misused;
use crate::files::{self, Force};
use crate::output::Output;
use anyhow::{Context, Result, anyhow, bail};
use clap::ValueEnum;
use crowd_mechanics::setup;
use lemons_core::files::input;
use lemons_core::trial::Trial;
use lemons_decision::{DECISION_FILE, DecisionConfig, Person};
use lemons_master::{FileType, Fmu, TrialInput, plan_of};
use lemons_results::{
    Area, Record, chaos, chaos_files, given_area, jupedsim, pedpy, series, series_files, trial_at_end,
    walkable_area,
};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

#[derive(clap::Args)]
pub struct Arguments {
    /// Results of a run: the table of lemons run (CSV or Parquet), or an OutputDirectory of
    /// AgentDynamics and AgentInteractions files
    #[arg(value_name = "TABLE or SERIES")]
    source: PathBuf,
    /// Format to write
    #[arg(long, value_name = "FORMAT")]
    to: Format,
    /// Where to write: a file for jupedsim and pedpy, a directory for the other formats
    #[arg(value_name = "OUT")]
    out: PathBuf,
    /// The Trial or FMU of the run. Default for an OutputDirectory: the Trial that contains it. A table
    /// needs it for the formats series and trial, and for jupedsim if there is no --area
    #[arg(long, value_name = "TRIAL or FILE.fmu")]
    trial: Option<PathBuf>,
    /// For jupedsim: the walkable area, instead of the area that the walls enclose. A file with
    /// POLYGON ((x y, …), (hole), …) in metres (well-known text)
    #[arg(long, value_name = "FILE.wkt")]
    area: Option<PathBuf>,
    /// Tables of the runs that went on from a table (lemons run --resume), in the order of time
    #[arg(long, value_name = "TABLE")]
    more: Vec<PathBuf>,
    /// Write only every N-th frame, beginning with the first
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    every: u32,
    #[command(flatten)]
    _force: Force,
    /// The run itself; the source is what messages call it.
    #[arg(skip)]
    pub memory: Option<Arc<InMemory>>,
}

#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Format {
    /// SQLite database of JuPedSim, version 2, with the walkable area; PedPy reads it with load_trajectory_from_jupedsim_sqlite
    Jupedsim,
    /// Text with the frame rate and lines "id frame x y z"; PedPy reads it with load_trajectory
    Pedpy,
    /// A file trajNNN.csv for each agent, with t,x,y,0.0
    Chaos,
    /// The paper's AgentDynamics files for each time; from an OutputDirectory also AgentInteractions
    Series,
    /// A Trial that continues from the end of the run, with those who are there and its decision.toml; from an OutputDirectory, if nobody can leave, with contact springs
    Trial,
}

pub fn export(arguments: &Arguments) -> Result<()> {
    let Arguments { source, to, out, every, .. } = arguments;
    arguments.check()?;
    let trial = match &arguments.memory {
        Some(memory) if arguments.trial.is_none() => Some(memory.trial.clone()),
        _ => trial_of(source, arguments.trial.as_deref())?,
    };
    if *to == Format::Jupedsim && trial.is_none() && arguments.area.is_none() {
        bail!(
            "{}: its walls are not known: give the Trial or FMU of the run with --trial, or the walkable area with --area",
            source.display()
        );
    }
    let leaves = *to == Format::Trial && arguments.lets_leave(trial.as_ref())?;
    if leaves && source.is_dir() {
        bail!(
            "{}: an OutputDirectory does not say who has left ({DECISION_FILE} lets people leave): export from the table of \
             the run",
            source.display()
        );
    }
    if matches!(to, Format::Jupedsim | Format::Pedpy) {
        files::claim_and_try(out)?;
    } else {
        files::claim_directory(out)?;
    }
    let need = || {
        trial
            .as_ref()
            .with_context(|| format!("{}: give the Trial or FMU of the run with --trial", source.display()))
    };
    if source.is_dir() && arguments.memory.is_none() {
        need()?;
    }
    let run = recorded(source, &arguments.more, arguments.memory.as_deref(), trial.as_ref())?;
    let run = run.every(*every as usize);
    let (first, end) = (run.times().next().unwrap_or_default(), run.times().last().unwrap_or_default());
    let mut said = Vec::new();
    let mut agents = run.ids().len();
    match to {
        Format::Jupedsim => {
            let area = area(&run, ("--area", arguments.area.as_deref()), trial.as_ref())?;
            jupedsim(&run, &area, out)?;
            said.extend(area.said);
        }
        Format::Pedpy => pedpy(&run, files::open(out)?, out)?,
        Format::Chaos => {
            claim_all(chaos_files(&run).iter().map(|name| out.join(name)))?;
            chaos(&run, out)?;
        }
        Format::Series => {
            claim_all(series_files(&run).iter().map(|name| out.join(name)))?;
            series(&run, need()?, out)?;
        }
        Format::Trial => {
            let before = need()?;
            let trial = trial_at_end(&run, before)?;
            agents = trial.agents.len();
            if agents == 0 {
                bail!(
                    "{}: nobody is there at its end, t = {end:?} s: no Trial can go on from it",
                    source.display()
                );
            }
            let given = arguments.trial.as_deref().unwrap_or(&before.directory);
            let wishes = wishes_at_end(given, &trial, &mut said)?;
            let plan = out.join(DECISION_FILE);
            let own = wishes.is_some().then(|| plan.clone());
            claim_all(trial.files_written(out).into_iter().chain(own))?;
            trial.write(out)?;
            if let Some(text) = &wishes {
                let mut file = Output::claimed(&plan)?;
                file.fill(|file| file.write_all(text.as_bytes()))?;
                file.persist()?;
            }
            said.extend(files::staying(out, if wishes.is_some() { &[DECISION_FILE] } else { &[] }));
        }
    }
    said.extend(not_exported(*to, &run, leaves));
    for line in said {
        note!("{line}");
    }
    let out = out.display();
    match to {
        Format::Trial => say!("{out}: {agents} agents as at t = {end:?} s")?,
        _ => say!("{out}: {agents} agents, {} frames from {first:?} to {end:?} s", run.frames())?,
    }
    Ok(())
}

impl Arguments {
    /// Checks that the options belong together.
    fn check(&self) -> Result<()> {
        if self.to == Format::Trial && self.every != 1 {
            bail!("--every is not for --to trial, which takes the last frame");
        }
        if self.memory.is_none() {
            expect_table(&self.source)?;
        }
        self.more.iter().try_for_each(|path| expect_table(path))?;
        if !self.more.is_empty() && self.source.is_dir() {
            bail!(Misused("--more is for tables, not for an OutputDirectory".into()));
        }
        if self.to != Format::Jupedsim && self.area.is_some() {
            bail!("--area is for --to jupedsim: the other formats have no walkable area");
        }
        if self.to != Format::Pedpy && files::is_standard_output(&self.out) {
            bail!(Misused(
                "OUT -: only the format pedpy can go to standard output; for a file of this name, write ./-"
                    .into()
            ));
        }
        Ok(())
    }

    /// Returns whether the Trial has a `decision.toml` with which people leave.
    fn lets_leave(&self, trial: Option<&Trial>) -> Result<bool> {
        let Some(trial) = trial else { return Ok(false) };
        let given = self.trial.as_deref().unwrap_or(&trial.directory);
        let Some(path) = TrialInput::find(given)?.and_then(|given| given.wishes()) else { return Ok(false) };
        let plan = plan_of(trial, &path).with_context(|| given.join(DECISION_FILE).display().to_string())?;
        Ok(plan.leaving().contains(&true))
    }
}

/// Returns the `decision.toml` of a Trial for those who are there at the end of its run, if it has one.
fn wishes_at_end(given: &Path, end: &Trial, said: &mut Vec<String>) -> Result<Option<String>> {
    let Some(path) = TrialInput::find(given)?.and_then(|given| given.wishes()) else { return Ok(None) };
    let shown = || given.join(DECISION_FILE).display().to_string();
    let text = input::read_text(&path, input::LARGEST_SETTINGS).with_context(shown)?;
    let wishes = DecisionConfig::from_toml(&text).with_context(shown)?;
    said.push(
        "decision.toml is taken along; people begin again with their first way-point, and by shares (share) it is chosen \
         again who takes which exit"
            .into(),
    );
    Ok(Some(match wishes.without_others(&Person::all_of(end)) {
        Some(fewer) => fewer.to_toml()?,
        None => text,
    }))
}

/// Returns what the format or the record does not have.
fn not_exported(to: Format, run: &Record, leaves: bool) -> Vec<String> {
    let mut said: Vec<String> = Vec::new();
    match to {
        Format::Jupedsim | Format::Pedpy if run.numeric_ids().is_none() => said
            .push("Ids are not whole numbers: agents are numbered from 0, in the order of the source".into()),
        Format::Series if !run.contacts() => said.push(
            "a table contains no contacts, so no AgentInteractions files are written. To have them, let the FMU write \
             the files: lemons run TRIAL --set OutputDirectory=DIRECTORY"
                .into(),
        ),
        Format::Trial => {
            let no_contacts = "a table contains no contacts, so all contact springs start unstretched";
            // An OutputDirectory does not say who has left.
            let kept = if leaves {
                ""
            } else {
                ". To keep them, export from an OutputDirectory (lemons run TRIAL --set OutputDirectory=DIRECTORY)"
            };
            said.extend((!run.contacts()).then(|| format!("{no_contacts}{kept}")));
            said.push(
                "Fp and Mp are those of the Trial, because runs do not record them; its drive.csv is not copied"
                    .into(),
            );
        }
        _ => {}
    }
    said
}

/// Checks that a file can be the table of a run; what is in it is read later.
pub fn expect_table(path: &Path) -> Result<()> {
    let tables = [
        FileType::TEXT,
        FileType::BINARY,
        FileType::PARQUET,
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
pub fn area(run: &Record, given: (&str, Option<&Path>), trial: Option<&Trial>) -> Result<Area> {
    let positions = run.positions()?;
    let positions = positions.iter().copied();
    let (option, given) = given;
    if let Some(path) = given {
        let named = || format!("{option} {}", path.display());
        let text = input::read_text(path, LARGEST_AREA).with_context(named)?;
        return given_area(&text, positions).map_err(|wrong| anyhow!("{}: {wrong}", named()));
    }
    Ok(walkable_area(trial.map_or(&[][..], |trial| &trial.geometry.walls), positions))
}

/// Claims files before one of them is written.
fn claim_all(mut paths: impl Iterator<Item = PathBuf>) -> Result<()> {
    paths.try_for_each(|path| files::claim(&path))
}

/// Reads the Trial or FMU that was given with the record of a run, else the Trial directory that a series lies in.
pub fn trial_of(source: &Path, given: Option<&Path>) -> Result<Option<Trial>> {
    let Some(path) = given else {
        let own = source.canonicalize().ok().filter(|source| source.is_dir());
        let mut around = own.iter().flat_map(|own| own.ancestors().take(2));
        let Some(path) = around.find(|path| path.join("Parameters.xml").is_file()) else { return Ok(None) };
        files::reads(path, &source.display().to_string());
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
