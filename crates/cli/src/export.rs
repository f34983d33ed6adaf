//! `lemons export`: a run for the field's tools, and a Trial that goes on where it ended.

use crate::error::Misused;
use crate::files::{self, ForceOption};
use crate::output::Output;
use crate::record::{InMemory, area, expect_table, recorded, trial_of};
use crate::trajectories::ReadingArguments;
use anyhow::{Context, Result, bail};
use clap::ValueEnum;
use lemons_core::files::input;
use lemons_core::trial::{Geometry, Trial};
use lemons_decision::{DECISION_FILE, DecisionConfig, Plan};
use lemons_master::TrialInput;
use lemons_people::drawing::{self, write_plan};
use lemons_results::{
    Record, VELOCITY_OVER, chaos, chaos_files, jupedsim, pedpy, series, series_files, trial_at_end,
};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;

#[derive(clap::Args)]
pub struct Arguments {
    /// Results of a run: the table of lemons run (CSV or Parquet), or an OutputDirectory of
    /// AgentDynamics and AgentInteractions files. For jupedsim, pedpy and chaos also trajectories of an
    /// experiment or of another simulator. For geojson, wkt and dxf: a Trial or an FMU
    #[arg(value_name = "TABLE, SERIES or TRIAL")]
    source: PathBuf,
    /// Format to write
    #[arg(long, value_name = "FORMAT")]
    to: Format,
    /// Where to write: a directory for chaos, series and trial, a file for the other formats
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
    pub reading: ReadingArguments,
    #[command(flatten)]
    _force: ForceOption,
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
    /// The room of a Trial as GeoJSON: its walls, and the exits of its decision.toml. lemons room reads it
    Geojson,
    /// The walls of a Trial as well-known text
    Wkt,
    /// The room of a Trial as DXF, in m, for programs that draw
    Dxf,
    /// A Trial that continues from the end of the run, with those who are there and its decision.toml; from an OutputDirectory, if nobody can leave, with contact springs
    Trial,
}

/// Format in which a run is written.
#[derive(Clone, Copy, PartialEq)]
enum Runs {
    Jupedsim,
    Pedpy,
    Chaos,
    Series,
    Trial,
}

/// Content of the file: a room, or a run.
enum What {
    Room(drawing::DrawingFormat),
    Run(Runs),
}

impl Format {
    /// Returns what it is a format of.
    fn what(self) -> What {
        match self {
            Format::Jupedsim => What::Run(Runs::Jupedsim),
            Format::Pedpy => What::Run(Runs::Pedpy),
            Format::Chaos => What::Run(Runs::Chaos),
            Format::Series => What::Run(Runs::Series),
            Format::Trial => What::Run(Runs::Trial),
            Format::Geojson => What::Room(drawing::DrawingFormat::GeoJson),
            Format::Wkt => What::Room(drawing::DrawingFormat::Wkt),
            Format::Dxf => What::Room(drawing::DrawingFormat::Dxf),
        }
    }
}

pub fn export(arguments: &Arguments) -> Result<()> {
    let Arguments { source, to, out, every, memory, .. } = arguments;
    let to = match to.what() {
        What::Room(format) => return arguments.write_room(format),
        What::Run(to) => to,
    };
    arguments.check()?;
    let of_others = arguments.reading.is_for(source)? && memory.is_none();
    if of_others && matches!(to, Runs::Series | Runs::Trial) {
        bail!(
            "{}: --to series and --to trial are for runs of a Trial: these are positions only",
            source.display()
        );
    }
    let trial = trial_of(source, arguments.trial.as_deref(), memory.as_deref())?;
    if to == Runs::Jupedsim && !of_others && trial.is_none() && arguments.area.is_none() {
        bail!(
            "{}: its walls are not known: give the Trial or FMU of the run with --trial, or the walkable area with --area",
            source.display()
        );
    }
    if matches!(to, Runs::Jupedsim | Runs::Pedpy) {
        files::claim_and_try(out)?;
    } else {
        files::claim_directory(out)?;
    }
    let need = || {
        trial
            .as_ref()
            .with_context(|| format!("{}: give the Trial or FMU of the run with --trial", source.display()))
    };
    if source.is_dir() && memory.is_none() {
        need()?;
    }
    let run = if of_others {
        arguments.reading.open(source, VELOCITY_OVER)?
    } else {
        recorded(source, &arguments.more, memory.as_deref(), trial.as_ref())?
    };
    let run = run.every(*every as usize);
    let (first, end) = (run.times().next().unwrap_or_default(), run.times().last().unwrap_or_default());
    let mut notes = Vec::new();
    match to {
        Runs::Jupedsim => {
            let walls = trial.as_ref().map(|trial| trial.geometry.walls.clone());
            let walls = match walls {
                None if of_others => arguments.reading.walls(&run)?.walls,
                walls => walls.unwrap_or_default(),
            };
            let area = area(&run, ("--area", arguments.area.as_deref()), &walls)?;
            files::check_still(out)?;
            jupedsim(&run, &area, out)?;
            notes = area.messages;
        }
        Runs::Pedpy => pedpy(&run, files::open(out)?, out)?,
        Runs::Chaos => {
            claim_all(chaos_files(&run).iter().map(|name| out.join(name)))?;
            chaos(&run, out)?;
        }
        Runs::Series => {
            claim_all(series_files(&run).iter().map(|name| out.join(name)))?;
            series(&run, need()?, out)?;
            notes.extend((!run.contacts()).then(|| {
                "a table contains no contacts, so no AgentInteractions files are written. To have them, let the FMU \
                 write the files: lemons run TRIAL --set OutputDirectory=DIRECTORY"
                    .into()
            }));
        }
        Runs::Trial => {
            let agents = arguments.write_trial_at_end(&run, need()?, end)?;
            return Ok(say!("{}: {agents} agents as at t = {end:?} s", out.display())?);
        }
    }
    if matches!(to, Runs::Jupedsim | Runs::Pedpy) && run.numeric_ids().is_none() {
        notes
            .push("Ids are not whole numbers: agents are numbered from 0, in the order of the source".into());
    }
    if let Some(time) = run.lost_time().filter(|_| matches!(to, Runs::Jupedsim | Runs::Pedpy)) {
        notes.push(format!(
            "t = {time:?} s is 0 s there: the format numbers frames, and has no whole number for it (--every {every})"
        ));
    }
    notes.iter().for_each(|line| note!("{line}"));
    let (out, agents, frames) = (out.display(), run.ids().len(), run.frames());
    Ok(say!("{out}: {agents} agents, {frames} frames from {first:?} to {end:?} s")?)
}

impl Arguments {
    /// Checks that the options belong together.
    fn check(&self) -> Result<()> {
        let to = self.to;
        let mistakes = [
            (
                to == Format::Trial && self.every != 1,
                "--every is not for --to trial, which takes the last frame",
            ),
            (
                to != Format::Jupedsim && self.area.is_some(),
                "--area is for --to jupedsim: the other formats have no walkable area",
            ),
            (
                to != Format::Jupedsim && self.reading.has_walls(),
                "--geometry is for --to jupedsim: the other formats have no walls",
            ),
            (
                !self.more.is_empty() && self.memory.is_none() && self.reading.is_for(&self.source)?,
                "--more is for tables of lemons run",
            ),
            (
                to != Format::Pedpy && files::is_standard_output(&self.out),
                "OUT -: only the format pedpy can go to standard output; for a file of this name, write ./-",
            ),
            (
                !self.more.is_empty() && self.source.is_dir(),
                "--more is for tables, not for an OutputDirectory",
            ),
        ];
        if let Some((_, mistake)) = mistakes.iter().find(|(is_made, _)| *is_made) {
            bail!(Misused((*mistake).into()));
        }
        let is_held = self.memory.is_some() || self.reading.database.is_some();
        let tables = (!is_held).then_some(&self.source).into_iter().chain(&self.more);
        tables.into_iter().try_for_each(|path| expect_table(path))
    }

    /// Writes walls and exits of a Trial as a drawing.
    fn write_room(&self, format: drawing::DrawingFormat) -> Result<()> {
        let Arguments { source, out, memory, .. } = self;
        if self.every != 1 || !self.more.is_empty() || self.area.is_some() {
            bail!(Misused("--every, --more and --area are for runs, not for the room of a Trial".into()));
        }
        self.reading.is_for(source)?;
        let given = self.trial.as_deref().unwrap_or(source);
        let own = if memory.is_some() { self.trial.as_deref() } else { Some(given) };
        let trial =
            trial_of(source, own, memory.as_deref())?.with_context(|| source.display().to_string())?;
        let mut exits = Vec::new();
        if let Some((config, _)) = decision_of(given)? {
            let plan =
                Plan::of(&trial, &config).with_context(|| given.join(DECISION_FILE).display().to_string())?;
            let leaving = plan.targets.into_iter().filter(|target| !target.stay);
            exits = leaving
                .map(|target| drawing::NamedPlace {
                    name: target.name,
                    corners: target.corners.into_iter().map(Into::into).collect(),
                })
                .collect();
        }
        let room = drawing::FloorPlan::of_geometry(&trial.geometry, exits);
        let text = write_plan(&room, format).context("this format is not written")?;
        let mut file = Output::open(out)?;
        file.fill(|file| file.write_all(text.as_bytes()))?;
        file.persist()?;
        let (walls, exits) = (room.walls.len(), room.exits.len());
        let left =
            if format == drawing::DrawingFormat::Wkt && exits > 0 { "; exits are not in it" } else { "" };
        let opens = trial.geometry.walls.iter().any(|wall| wall.open.is_some());
        let opens = if opens { "; walls that open are as closed ones in it" } else { "" };
        let Geometry { grounds, links, .. } = &trial.geometry;
        let level = grounds.is_empty() && links.is_empty();
        let flat = if level { "" } else { "; slopes, stairs and links are not in it" };
        Ok(say!("{}: {walls} walls, {exits} exits{left}{opens}{flat}", out.display())?)
    }

    /// Writes the Trial that continues from the end of a run of `before`, with the `decision.toml` of those who are there.
    /// Returns the number of its agents.
    fn write_trial_at_end(&self, run: &Record, before: &Trial, end: f64) -> Result<usize> {
        let (source, out) = (self.source.display(), &self.out);
        let given = self.trial.as_deref().unwrap_or(&before.directory);
        let named = || given.join(DECISION_FILE).display().to_string();
        let decision = decision_of(given)?;
        let plan = decision.as_ref().map(|(config, _)| Plan::of(before, config).with_context(named));
        let plan = plan.transpose()?;
        let leaves = plan.as_ref().is_some_and(|plan| plan.leaving().contains(&true));
        let legs = plan.as_ref().is_some_and(|plan| plan.balance.is_some());
        if leaves && self.source.is_dir() {
            bail!(
                "{source}: an OutputDirectory does not say who has left ({DECISION_FILE} lets people leave): export from \
                 the table of the run"
            );
        }
        let mut before = before.clone();
        plan.iter().for_each(|plan| plan.mark_absent(&mut before));
        let (trial, left) = trial_at_end(run, &before)?;
        if trial.agents.is_empty() {
            bail!("{source}: nobody is there at its end, t = {end:.3} s: no Trial can go on from it");
        }
        let fewer = |(config, text): (DecisionConfig, String)| {
            config.without_others(&trial.agents).map_or(Ok(text), |fewer| fewer.to_toml())
        };
        let later = |(config, text): (DecisionConfig, String)| {
            let later = plan.as_ref().map(|plan| plan.going_on(&config, end, &trial, &left));
            // Else the text of the file is kept.
            let changed = later.filter(|later| *later != config);
            changed.map_or(Ok((config, text)), |later| later.to_toml().map(|text| (later, text)))
        };
        let decision = decision.map(|decision| later(decision).and_then(fewer)).transpose()?;
        let path = decision.is_some().then(|| out.join(DECISION_FILE));
        claim_all(trial.files_written(out).into_iter().chain(path.clone()))?;
        trial.write(out)?;
        if let (Some(text), Some(path)) = (&decision, &path) {
            let mut file = Output::claimed(path)?;
            file.fill(|file| file.write_all(text.as_bytes()))?;
            file.persist()?;
            note!(
                "decision.toml is taken along; people begin again with their first way-point, and by shares (share) it is \
                 chosen again who takes which exit"
            );
        }
        if legs {
            note!(
                "the state of legs is not taken along: people begin with their feet under the body, and no steps"
            );
        }
        for line in files::staying(out, if decision.is_some() { &[DECISION_FILE] } else { &[] }) {
            note!("{line}");
        }
        if !run.contacts() {
            // An OutputDirectory does not say who has left.
            let kept = if leaves {
                ""
            } else {
                ". To keep them, export from an OutputDirectory (lemons run TRIAL --set OutputDirectory=DIRECTORY)"
            };
            note!("a table contains no contacts, so all contact springs start unstretched{kept}");
        }
        note!(
            "Fp and Mp are those of the Trial, because runs do not record them; its drive.csv is not copied"
        );
        Ok(trial.agents.len())
    }
}

/// The `decision.toml` of a Trial, read and as text.
fn decision_of(given: &Path) -> Result<Option<(DecisionConfig, String)>> {
    let named = || given.join(DECISION_FILE).display().to_string();
    let input = TrialInput::find(given)?;
    let Some(path) = input.as_ref().and_then(TrialInput::decision_file) else { return Ok(None) };
    let text = input::read_text(&path, input::LARGEST_SETTINGS).with_context(named)?;
    Ok(Some((DecisionConfig::from_toml(&text).with_context(named)?, text)))
}

/// Claims files before one of them is written.
fn claim_all(mut paths: impl Iterator<Item = PathBuf>) -> Result<()> {
    paths.try_for_each(|path| files::claim(&path))
}
