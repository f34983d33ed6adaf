//! Source of `lemons plot`, `lemons movie` and `lemons measure`: a Trial, an FMU, or the record of a run.

use super::trial_run::{Bodies, TrialRun};
use crate::error::Misused;
use crate::interrupt::{Interrupt, Interrupted};
use crate::record::{InMemory, expect_table, recorded, trial_of};
use crate::run::{Inputs, RowTarget, RunJob, name_and_value, not_set, simulate};
use crate::trajectories::TrajectoryArguments;
use anyhow::{Context, Error, Result, bail};
use crowd_mechanics::model_description::DEFAULT_STOP_TIME;
use lemons_core::plane::Motion;
use lemons_core::trial::{AgentDynamics, DriveTable, OpeningTimes, PanelChoice, Trial};
use lemons_decision::Plan;
use lemons_master::{DecisionChoice, RunSettings, TrialInput, plan_of};
pub use lemons_results::KeptFrames;
use lemons_results::{Frame, READ, Record, Run};
use lemons_sim::settings::Value;
use lemons_sim::{Algorithm, Clock, Documents, Simulation, Until};
use std::path::{Path, PathBuf};
use std::sync::Arc;

#[derive(clap::Args)]
pub struct RunSource {
    #[arg(value_name = "TRIAL, FILE.fmu, TABLE or SERIES", help = format!(
        "A Trial or an FMU, which is simulated first, as by lemons run; or the results of an earlier run: its table, or \
         an OutputDirectory of XML files; or trajectories of an experiment or of another simulator: {}",
        *READ
    ))]
    pub path: PathBuf,
    /// Tables of the runs that went on from there (lemons run --resume), in the order of time
    #[arg(value_name = "MORE TABLES")]
    more: Vec<PathBuf>,
    /// The Trial or FMU of an earlier run, for shapes and walls. Scenes of a table need it. Default for an
    /// OutputDirectory: the Trial that contains it
    #[arg(long, value_name = "TRIAL or FILE.fmu")]
    trial: Option<PathBuf>,
    #[command(flatten)]
    inputs: Inputs,
    /// Set a parameter of the simulation; for earlier results: the value they were simulated with, which
    /// is needed for forces
    #[arg(long = "set", value_name = "NAME=VALUE", value_parser = name_and_value)]
    settings: Vec<(String, String)>,
    #[command(flatten)]
    others: TrajectoryArguments,
    /// Further panels of a Trial's walls.
    #[arg(skip)]
    pub panels: Option<PanelChoice>,
    /// The run itself; the path is what messages call it.
    #[arg(skip)]
    memory: Option<Arc<InMemory>>,
}

/// Communication steps of a run that is made to be shown: its table is a temporary file.
const MOST_STEPS: u64 = 1_000_000;

/// A run in memory, or in its file.
enum Found {
    Made(Run),
    Recorded(Record),
}

/// An opened source.
pub struct Opened {
    /// A table may come without.
    pub trial: Option<Trial>,
    pub run: Run,
    pub bodies: Bodies,
}

impl RunSource {
    /// Takes what it names from memory, or from a database.
    pub fn hold(&mut self, run: Option<Arc<InMemory>>, database: Option<PathBuf>) {
        (self.memory, self.others.reading.database) = (run, database);
    }

    /// Opens it: a Trial or an FMU is run until then; without an end it is shown as it begins.
    pub fn open(&self, until: Option<Until>, wanted: KeptFrames, interrupt: &Interrupt) -> Result<Opened> {
        let (trial, found) = self.find(until, wanted.clone(), interrupt)?;
        let (run, bodies) = match found {
            Found::Made(run) => (run, Bodies::Known),
            Found::Recorded(record) => {
                let bodies = match record.trajectories() {
                    Some(trajectories) if self.trial.is_some() && !trajectories.oriented => bail!(
                        "{}: it does not say where people look, so bodies of --trial cannot be drawn: --geometry takes \
                         the walls alone",
                        self.path.display()
                    ),
                    Some(trajectories) if self.trial.is_none() => {
                        Bodies::Assumed { oriented: trajectories.oriented }
                    }
                    _ => Bodies::Known,
                };
                let run = record.read_unless(interrupt.flag(), wanted);
                interrupt.check()?;
                (run?, bodies)
            }
        };
        Ok(Opened { trial, run, bodies })
    }

    /// Opens it as [`RunSource::open`] with all frames; those of earlier results stay in their file.
    pub fn record_of(&self, until: Option<Until>, interrupt: &Interrupt) -> Result<(Option<Trial>, Record)> {
        let (trial, found) = self.find(until, KeptFrames::All, interrupt)?;
        let record = match found {
            Found::Made(run) => run.into(),
            Found::Recorded(record) => record,
        };
        Ok((trial, record))
    }

    fn find(
        &self,
        until: Option<Until>,
        wanted: KeptFrames,
        interrupt: &Interrupt,
    ) -> Result<(Option<Trial>, Found)> {
        let (runs, path) = (self.runs(), self.path.display());
        if !runs && self.inputs.given() {
            bail!(Misused(format!(
                "{path} contains the results of an earlier run: --drive, --no-drive, --decision, --no-decision and --step are only for a Trial or an FMU, which is simulated first"
            )));
        }
        if self.ends_in("ssp") {
            bail!(
                "{path}: an SSP cannot be drawn: run it with lemons run, and give the trajectories.csv of this run"
            );
        }
        let of_others = self.others.is_for(&self.path)? && self.memory.is_none();
        if !self.more.is_empty() && (runs || of_others || self.path.is_dir()) {
            bail!(Misused(format!("{path}: is no table: only tables of one run can be several")));
        }
        if !runs && self.memory.is_none() && self.others.reading.database.is_none() {
            [&self.path].into_iter().chain(&self.more).try_for_each(|path| expect_table(path))?;
        }
        let given = if runs { Some(self.path.as_path()) } else { self.trial.as_deref() };
        let mut trial = trial_of(&self.path, given, self.memory.as_deref())?;
        if let Some(trial) = &mut trial {
            self.plan(trial).iter().for_each(|plan| plan.mark_absent(trial));
            let documents = Documents { trial: trial.clone(), drive: DriveTable::default(), plan: None };
            let mut edited = Simulation::new(documents, Algorithm::default())?;
            for (name, value) in &self.settings {
                // What a run needs of people who walk, it takes itself.
                if !(runs && until.is_some() && name.starts_with("decision.")) {
                    edited.set(name, value).map_err(not_set)?;
                }
            }
            *trial = edited.trial().clone();
            let doors = trial.geometry.walls.iter_mut().filter_map(|wall| wall.open.as_mut());
            for (k, times) in doors.enumerate() {
                if edited.value(&format!("door[{k}].Open"))? == Value::Boolean(false) {
                    *times = OpeningTimes::never();
                }
            }
            // An FMU has the panels that it was packed with.
            if matches!(self.panels, Some(PanelChoice::Longest(_))) && self.ends_in("fmu") {
                bail!(Misused(format!(
                    "--panel-length: {path} is an FMU, which has the panels of its Trial"
                )));
            }
            if let Some(panels) = self.panels.filter(|_| !self.ends_in("fmu")) {
                trial.geometry.divide(panels).map_err(Error::msg)?;
            }
        }
        let found = match (runs, until, &trial) {
            (true, Some(until), Some(trial)) => {
                let step = self.inputs.step.unwrap_or(trial.parameters.time_step);
                let clock = Clock::new(0.0, step, until.latest());
                let clock = clock.and_then(|clock| clock.check_at_most(MOST_STEPS).map(|()| clock));
                let clock = clock.with_context(|| path.to_string())?;
                let until = match until {
                    Until::Point(_) => Until::Time(clock.point(clock.steps)),
                    until => until,
                };
                Found::Made(self.record(until, wanted, interrupt)?)
            }
            (true, None, Some(trial)) => Found::Made(still(&self.path, trial)),
            (_, _, None) if self.path.is_dir() => bail!(
                "{path}: is not a Trial (it has no Parameters.xml); for an OutputDirectory, give the Trial or FMU of the run with --trial"
            ),
            _ if of_others => return self.find_of_others(trial),
            (_, _, trial) => {
                let record = recorded(&self.path, &self.more, self.memory.as_deref(), trial.as_ref())?;
                trial.iter().for_each(|trial| tell_other(&record, trial));
                Found::Recorded(record)
            }
        };
        Ok((trial, found))
    }

    /// Opens trajectories that are not of our runs, with the bodies of a Trial, or with circles.
    fn find_of_others(&self, trial: Option<Trial>) -> Result<(Option<Trial>, Found)> {
        let record = self.others.open(&self.path)?;
        if let Some(trial) = trial {
            let record = record.of_trial(&trial).context("--geometry takes the walls of a Trial alone")?;
            return Ok((Some(trial), Found::Recorded(record)));
        }
        if !self.settings.is_empty() {
            bail!(Misused("--set: trajectories of others have no parameters".into()));
        }
        let trial = self.others.reading.assumed_trial(&record, self.others.radius())?;
        Ok((Some(trial), Found::Recorded(record)))
    }

    /// Returns the end of a run that is made now; `None` for earlier results, which have one.
    ///
    /// # Errors
    /// Earlier results are to end when everybody has left.
    pub fn end(&self, until: Option<Until>) -> Result<Option<Until>> {
        if self.runs() {
            return Ok(Some(until.unwrap_or(Until::Time(DEFAULT_STOP_TIME))));
        }
        if until == Some(Until::Left) {
            bail!(Misused("--until left is for a Trial that is run now; earlier results have an end".into()));
        }
        Ok(None)
    }

    /// Opens it as [`RunSource::open`], with shapes and walls.
    pub fn trial_run(
        &self,
        until: Option<Until>,
        wanted: KeptFrames,
        interrupt: &Interrupt,
    ) -> Result<TrialRun> {
        let Opened { trial, run, bodies } = self.open(until, wanted, interrupt)?;
        let Some(trial) = trial else {
            bail!(
                "{}: it contains no shapes and no walls: give the Trial or FMU of the run with --trial",
                self.path.display()
            );
        };
        if let Bodies::Assumed { .. } = bodies {
            note!("people are drawn as circles of radius {} m (--radius)", self.others.radius());
        }
        Ok(TrialRun::new(trial, run, bodies)?)
    }

    /// Returns what the people of its Trial want, if that can be read.
    pub fn plan(&self, trial: &Trial) -> Option<Plan> {
        if let Some(memory) = self.memory.as_ref().filter(|_| self.trial.is_none()) {
            return memory.plan.clone();
        }
        let path = if self.runs() { &self.path } else { self.trial.as_ref()? };
        let own = || TrialInput::open(path).ok()?.decision_file().and_then(|file| plan_of(trial, &file).ok());
        match self.inputs.settings(path).decision {
            DecisionChoice::None => None,
            DecisionChoice::File(file) => plan_of(trial, &file).ok(),
            DecisionChoice::Own => own(),
        }
    }

    /// Returns whether it is something to run.
    pub fn runs(&self) -> bool {
        let is_trial = || self.path.join("Parameters.xml").is_file();
        self.memory.is_none() && (self.ends_in("fmu") || self.ends_in("zip") || is_trial())
    }

    fn ends_in(&self, extension: &str) -> bool {
        self.path.extension().is_some_and(|end| end.eq_ignore_ascii_case(extension))
    }

    /// Runs it as `lemons run` does, in memory.
    fn record(&self, until: Until, wanted: KeptFrames, interrupt: &Interrupt) -> Result<Run> {
        let settings = RunSettings {
            until: Some(until.latest()),
            parameters: self.settings.clone(),
            panels: self.panels,
            ..self.inputs.settings(&self.path)
        };
        let rows = RowTarget::Memory(wanted);
        let job = RunJob { settings, rows, outputs: None, either: false, state: None, until: Some(until) };
        let ended = simulate(job, interrupt)?;
        ended.complete?;
        if ended.stopped.is_some() {
            return Err(Interrupted::given_up().into());
        }
        let path = self.path.display();
        let none = format!(
            "{path}: it is not a crowd: it has no variables such as agent[0].Position.x, so there is nothing to show"
        );
        Ok(Run { source: self.path.clone(), ..ended.recorded.context(none)? })
    }
}

/// Says so if a record does not begin where the people of a Trial stand: its bodies are probably those of others.
fn tell_other(record: &Record, trial: &Trial) {
    /// \[m\] Tables of other programs have fewer digits.
    const NEAR: f64 = 1e-3;
    let apart = |(agent, own): &(Motion, &AgentDynamics)| {
        (agent.pose.position - own.motion().pose.position).norm() > NEAR
    };
    let others = record.first().iter().copied().zip(&trial.dynamics).filter(apart).count();
    if others > 0 && record.times().next() == Some(0.0) {
        note!(
            "warning: {}: {others} of {} people do not begin where they stand in the Trial {:?}: is it the table of \
             another crowd?",
            record.source().display(),
            trial.agents.len(),
            trial.name
        );
    }
}

/// Returns a Trial as it begins, as a run.
fn still(path: &Path, trial: &Trial) -> Run {
    let start = Frame {
        time: 0.0,
        agents: trial.dynamics.iter().map(AgentDynamics::motion).collect(),
        interactions: Some(trial.interactions.clone()),
        place: "start".to_owned(),
        ..Frame::default()
    };
    let ids = trial.agents.iter().map(|agent| agent.id.clone()).collect();
    Run { source: path.to_owned(), ids, frames: vec![start] }
}
