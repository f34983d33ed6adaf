//! What `lemons plot` and `lemons movie` show: a Trial, an FMU, or the record of a run.

use super::look::positive;
use super::moment::Footage;
use crate::error::Misused;
use crate::export::{expect_table, trial_of};
use crate::interrupt::{Interrupt, Interrupted};
use crate::run::simulate;
use anyhow::{Context, Result, anyhow, bail};
use clap::Parser;
use crowd_mechanics::files::Scratch;
use crowd_mechanics::trial::Trial;
use crowd_mechanics::variables::{Kind, in_documents_mut, table};
use lemons_export::{Frame, Record, Run};
use lemons_master::{Clock, named};
use std::collections::{BTreeSet, HashMap};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

#[derive(clap::Args)]
pub struct Source {
    /// A Trial directory or an FMU, which is run as lemons run does; or the record of a run: its table, or
    /// an OutputDirectory
    #[arg(value_name = "TRIAL, FILE.fmu, TABLE or SERIES")]
    pub path: PathBuf,
    /// The Trial or FMU that ran, for shapes and walls; default: the Trial directory that a series lies in
    #[arg(long, value_name = "TRIAL or FILE.fmu")]
    trial: Option<PathBuf>,
    /// Propulsion over time of a run that is made now; default: the Trial's drive.csv
    #[arg(long, value_name = "FILE.csv", conflicts_with = "no_drive")]
    drive: Option<PathBuf>,
    /// Ignore the Trial's drive.csv
    #[arg(long)]
    no_drive: bool,
    /// A parameter of a run that is made now; of a record: what it was run with, for forces
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    /// Communication step of a run that is made now, in seconds; default: the Trial's TimeStep
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    step: Option<f64>,
}

#[derive(clap::Parser)]
struct Running {
    #[command(flatten)]
    arguments: crate::run::Arguments,
}

/// Communication steps of a run that is made to be shown: its table is a temporary file.
const MOST_STEPS: u64 = 1_000_000;

/// Which frames of a run are read into memory.
#[derive(Clone, Copy)]
pub enum Wanted<'a> {
    All,
    /// The first, the last, and those on both sides of each of these times \[s\].
    Around(&'a [f64]),
}

impl Wanted<'_> {
    fn of(self, record: Record) -> Result<Run> {
        let Wanted::Around(asked) = self else { return Ok(record.read(|_| true)?) };
        let (times, last) = (record.times().collect::<Vec<_>>(), record.frames() - 1);
        let after = asked.iter().map(|asked| times.partition_point(|time| time <= asked).min(last));
        let mut places: BTreeSet<usize> = after.flat_map(|after| [after.saturating_sub(1), after]).collect();
        places.extend([0, last]);
        Ok(record.read(|place| places.contains(&place))?)
    }
}

/// When a run that is made now ends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum End {
    /// \[s\]
    At(f64),
    /// When all have come to rest, and at [`LATEST`].
    Still,
}

/// \[s\] Crowds that push for ever never come to rest.
pub const LATEST: f64 = 120.0;

/// What was found there.
pub struct Opened {
    /// `None` where a table came without.
    pub trial: Option<Trial>,
    pub run: Run,
}

impl End {
    /// \[s\]
    fn latest(self) -> f64 {
        match self {
            End::At(time) => time,
            End::Still => LATEST,
        }
    }
}

impl Source {
    /// A Trial or an FMU is run until then; without an end it is shown as it begins.
    pub fn open(&self, until: Option<End>, wanted: Wanted<'_>, interrupt: &Interrupt) -> Result<Opened> {
        let runs = self.runs();
        if !runs && (self.drive.is_some() || self.no_drive || self.step.is_some()) {
            let path = self.path.display();
            return Err(Misused(format!(
                "{path} is the record of a run: --drive, --no-drive and --step are for a run that is made now"
            ))
            .into());
        }
        if self.path.extension().is_some_and(|end| end.eq_ignore_ascii_case("ssp")) {
            bail!("{}: run it first, and show its trajectories.csv", self.path.display());
        }
        if !runs {
            expect_table(&self.path)?;
        }
        let given = if runs { Some(self.path.as_path()) } else { self.trial.as_deref() };
        let mut trial = trial_of(&self.path, given)?;
        if let Some(trial) = &mut trial {
            for setting in &self.settings {
                set(trial, setting)?;
            }
        }
        let run = match (runs, until, &trial) {
            (true, Some(until), Some(trial)) => {
                let step = self.step.unwrap_or(trial.parameters.time_step);
                Clock::new(0.0, step, until.latest())
                    .and_then(|clock| clock.check_at_most(MOST_STEPS))
                    .with_context(|| self.path.display().to_string())?;
                self.record(until, wanted, interrupt)?
            }
            (true, None, Some(trial)) => still(&self.path, trial),
            (_, _, Some(trial)) if self.path.is_dir() => wanted.of(Record::series(&self.path, trial)?)?,
            (_, _, Some(trial)) => wanted.of(Record::table(&self.path)?.of_trial(trial)?)?,
            (_, _, None) if self.path.is_dir() => bail!(
                "{}: is no Trial, as it has no Parameters.xml; a series needs the Trial or FMU that ran: --trial",
                self.path.display()
            ),
            (_, _, None) => wanted.of(Record::table(&self.path)?)?,
        };
        Ok(Opened { trial, run })
    }

    /// With shapes and walls.
    pub fn footage(&self, until: Option<End>, wanted: Wanted<'_>, interrupt: &Interrupt) -> Result<Footage> {
        let Opened { trial, run } = self.open(until, wanted, interrupt)?;
        let need = || {
            format!("{}: give the Trial or FMU that ran, for shapes and walls: --trial", self.path.display())
        };
        Ok(Footage::new(trial.with_context(need)?, run)?)
    }

    /// Whether it is something to run.
    pub fn runs(&self) -> bool {
        let ends = |with: &str| self.path.extension().is_some_and(|end| end.eq_ignore_ascii_case(with));
        ends("fmu") || ends("zip") || self.path.join("Parameters.xml").is_file()
    }

    /// As `lemons run` does it.
    fn record(&self, until: End, wanted: Wanted<'_>, interrupt: &Interrupt) -> Result<Run> {
        let directory = Scratch::new().context("cannot make a temporary directory")?;
        let table = directory.path().join("trajectories.csv");
        let mut words: Vec<OsString> = vec!["run".into()];
        let mut option = |name: &str, value: OsString| words.extend([name.into(), value]);
        option("--until", until.latest().to_string().into());
        option("--output", table.clone().into());
        option("--outputs", directory.path().join("outputs.csv").into());
        self.drive.iter().for_each(|drive| option("--drive", drive.into()));
        self.settings.iter().for_each(|setting| option("--set", setting.into()));
        self.step.iter().for_each(|step| option("--step", step.to_string().into()));
        words.extend(self.no_drive.then(|| "--no-drive".into()));
        words.extend(["--".into(), self.path.clone().into()]);
        let Running { mut arguments } = Running::try_parse_from(words)?;
        arguments.until_still = until == End::Still;
        if simulate(&arguments, interrupt)?.stopped.is_some() {
            return Err(Interrupted::nothing_written().into());
        }
        if !table.is_file() {
            bail!(
                "{}: has no agents under the names of this program's FMUs: nothing to show",
                self.path.display()
            );
        }
        Ok(Run { source: self.path.clone(), ..wanted.of(Record::table(&table)?)? })
    }
}

/// A Trial as it begins.
fn still(path: &Path, trial: &Trial) -> Run {
    let start = Frame {
        time: 0.0,
        agents: trial.dynamics.clone(),
        observed: None,
        interactions: Some(trial.interactions.clone()),
        place: "start".to_owned(),
    };
    let ids = trial.agents.iter().map(|agent| agent.id.clone()).collect();
    Run { source: path.to_owned(), ids, frames: vec![start] }
}

/// A parameter of the run, which its contacts depend on.
fn set(trial: &mut Trial, setting: &str) -> Result<()> {
    let (name, value) =
        setting.split_once('=').with_context(|| format!("--set {setting}: expected NAME=VALUE"))?;
    let variables = table(trial);
    let variables: HashMap<&str, _> =
        variables.iter().map(|variable| (variable.name.as_str(), variable)).collect();
    for name in named(name, |name| variables.contains_key(name)) {
        let unknown = || format!("--set {setting}: there is no variable {name:?}");
        let variable = variables.get(name.as_str()).with_context(unknown)?;
        match variable.kind {
            Kind::Real(_) => {}
            // Results do not depend on them.
            Kind::Integer => continue,
            Kind::String => bail!("--set {setting}: not for pictures"),
        }
        let value: f64 = value.parse().with_context(|| format!("--set {setting}: not a number"))?;
        variable.domain.check(value).map_err(|must| anyhow!("--set {setting}: must be {must}"))?;
        match in_documents_mut(trial, variable.quantity) {
            Some(place) => *place = value,
            None => bail!("--set {setting}: {name} is computed"),
        }
    }
    Ok(())
}
