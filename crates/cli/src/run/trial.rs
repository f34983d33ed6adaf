//! A run of a Trial in memory.

use super::About;
use super::model::{CrowdInfo, Prepared, RunModel, States, record_of};
use super::outputs::OutputTable;
use crate::messages::{not_prepared, warning_text};
use crate::results::{Cell, CellType, Column, Place};
use anyhow::{Context, Error, Result, anyhow, ensure};
use crowd_mechanics::model_description::MODEL_NAME;
use crowd_mechanics::quantities::{Quantity, guid};
use lemons_fmi::variables::{Kind as VariableKind, Scalar};
use lemons_master::{ComponentRecord, PrepareError, Saved, Settings, TrialInput, Warning, read_saved};
use lemons_results::Frame;
use lemons_results::columns::Groups;
use lemons_sim::settings::{DECISION, Selection};
use lemons_sim::{Clock, Documents, Model, SimError, Simulation};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Name of the component in a saved run, and in tables.
const CROWD: &str = "crowd";
/// The same in a saved run of people who walk.
const WALKERS: &str = "crowd and decision";

struct TrialRun {
    simulation: Simulation,
    /// Where the outputs of Decision go, if they are wanted.
    outputs: Option<DecisionOutputs>,
    /// Of the component in a saved run.
    name: &'static str,
    guid: String,
}

/// The outputs of Decision, and which of them are Reals, Integers or Booleans.
struct DecisionOutputs {
    selection: Selection,
    kinds: Vec<CellType>,
    table: OutputTable,
}

impl DecisionOutputs {
    fn create(simulation: &Simulation, to: &Place, about: &About) -> Result<Option<DecisionOutputs>> {
        let variables = simulation.decision_outputs();
        if variables.is_empty() {
            return Ok(None);
        }
        let column = |scalar: &Scalar<_>| Column {
            name: format!("{DECISION}.{}", scalar.name),
            kind: match scalar.variable.kind {
                VariableKind::Real(_) => CellType::Real,
                VariableKind::Integer => CellType::Integer,
                _ => CellType::Boolean,
            },
            unit: match scalar.variable.kind {
                VariableKind::Real(unit) => Some(unit.name.to_owned()),
                _ => None,
            },
            variable: scalar.name.clone(),
            description: scalar.description.clone(),
        };
        let columns: Vec<Column> = variables.iter().map(column).collect();
        let names: Vec<String> = columns.iter().map(|column| column.name.clone()).collect();
        let selection = simulation.select(&names).map_err(|(name, _)| anyhow!("there is no {name}"))?;
        let kinds = columns.iter().map(|column| column.kind).collect();
        Ok(Some(DecisionOutputs { selection, kinds, table: OutputTable::create(columns, to, about)? }))
    }
}

impl Model for TrialRun {
    type Error = Error;

    fn step_to(&mut self, time: f64) -> Result<()> {
        Ok(self.simulation.step_to(time)?)
    }
}

impl RunModel for TrialRun {
    fn time(&self) -> f64 {
        self.simulation.time()
    }

    fn frame(&self, _: usize) -> Result<Frame> {
        Ok(self.simulation.frame())
    }

    fn values(&mut self, _: usize, names: &[String]) -> Result<Vec<f64>> {
        let selection = self.simulation.select(names).map_err(|(name, _)| anyhow!("there is no {name}"))?;
        Ok(self.simulation.read(&selection)?)
    }

    fn write_outputs(&mut self) -> Result<()> {
        let Some(DecisionOutputs { selection, kinds, table }) = &mut self.outputs else { return Ok(()) };
        let values = self.simulation.read(selection)?;
        let cell = |(value, kind): (f64, &CellType)| match kind {
            CellType::Real => Cell::Real(value),
            CellType::Integer => Cell::Integer(value as i32),
            _ => Cell::Boolean(value != 0.0),
        };
        table.row(self.simulation.time(), values.into_iter().zip(kinds.iter()).map(cell).collect())
    }

    fn finish_outputs(&mut self) -> Result<Option<String>> {
        self.outputs.take().map(|outputs| outputs.table.finish()).transpose()
    }

    fn states(&mut self) -> Result<States> {
        let state = self.simulation.save();
        let record = ComponentRecord {
            name: self.name.into(),
            model: MODEL_NAME.into(),
            guid: self.guid.clone(),
            chosen: BTreeMap::new(),
            state: "state-0".into(),
            bytes: state.len() as u64,
        };
        Ok((vec![record], vec![state]))
    }

    fn take_warnings(&mut self) -> Vec<String> {
        self.simulation.take_warnings().into_iter().map(|warning| format!("warning: {warning}")).collect()
    }
}

/// Prepares a run of a Trial; outputs of Decision go to a table, if they are wanted. Warnings are printed.
pub fn prepare(given: &TrialInput, settings: &Settings, outputs: Option<&Place>) -> Result<Prepared> {
    settings.check().map_err(not_prepared)?;
    let saved = settings.resume.as_deref().map(read_saved).transpose().map_err(not_prepared)?;
    let (documents, problems, plan) = documents(given, settings)?;
    problems.iter().for_each(|problem| note!("{problem}"));
    let (drive, walking) = (documents.drive.clone(), documents.plan.clone());
    let (trial, drive_end) = (documents.trial.clone(), drive.end());
    let mut simulation = Simulation::new(documents, settings.algorithm)?;
    for (name, value) in &settings.parameters {
        let overwritten = simulation.set(name, value).map_err(not_set)?;
        if let Some(input) = overwritten {
            let (name, value) = (name.clone(), value.clone());
            note!("{}", warning_text(&Warning::Overwritten { name, value, input }));
        }
    }
    if let Some(threads) = settings.threads {
        simulation.set("Threads", &threads.to_string())?;
    }
    for (name, [decision, crowd], people) in simulation.differing()? {
        let values = [(DECISION.to_owned(), decision), (CROWD.to_owned(), crowd)];
        note!("{}", warning_text(&Warning::Differs { name, values, people }));
    }
    let (before, states) = saved.unzip();
    let until = settings.until_of(before.as_ref(), 0.0, None).map_err(not_prepared)?;
    simulation.begin(0.0, settings.tolerance)?;
    let name = if walking.is_some() { WALKERS } else { CROWD };
    let guid = guid(&trial).braced().to_string();
    let of_saved = || format!("saved run {}", settings.resume.as_deref().unwrap_or(given.path()).display());
    if let (Some(before), Some(states)) = (&before, &states) {
        match (&plan, before.component[0].name.as_str()) {
            (Some(plan), CROWD) => return Err(not_prepared(PrepareError::NowWalks(plan.clone()))),
            (None, WALKERS) => return Err(not_prepared(PrepareError::NoLongerWalks)),
            _ => {}
        }
        let component = [name.to_owned(), MODEL_NAME.to_owned(), guid.clone()];
        let checked = before.check(&[component], &settings.algorithm.to_string(), "");
        checked.with_context(of_saved)?;
        ensure!(before.drive == drive.fingerprint(), not_prepared(PrepareError::OtherDrive));
        simulation.restore(&states[0]).with_context(of_saved)?;
    }
    let (step, every) = match &before {
        Some(before) => settings.same_points(before).map_err(not_prepared)?,
        None => (settings.step.unwrap_or(trial.parameters.time_step), settings.every.unwrap_or(1)),
    };
    let clock = Clock::new(0.0, step, until).with_context(|| settings.input.display().to_string())?;
    let missed = drive.missed(0.0, step).map(Warning::Missed);
    for warning in missed.into_iter().chain(settings.between(before.as_ref(), &clock)) {
        note!("{}", warning_text(&warning));
    }
    match plan {
        Some(plan) if drive_end.is_some() => note!("{}", warning_text(&Warning::DriveOfWalkers { plan })),
        None if before.is_none() && drive_end.is_none() && is_still(&simulation) => {
            note!("{}", warning_text(&Warning::Still));
        }
        _ => {}
    }
    let outputs = outputs
        .map(|to| DecisionOutputs::create(&simulation, to, &About::of(&clock, every, before.as_ref())));
    let outputs = outputs.transpose()?.flatten();
    let frame = simulation.frame();
    let groups = Groups { contacts: true, of_step: true, active: frame.active.is_some(), totals: true };
    let crowd = CrowdInfo {
        component: CROWD.into(),
        file_name: CROWD.into(),
        ids: simulation.ids().to_vec(),
        groups,
        columns: groups.columns(),
        about: vec![
            ("trial", trial.name.clone()),
            ("component", CROWD.into()),
            ("model_name", MODEL_NAME.into()),
            ("guid", guid.clone()),
        ],
        trial: Some(simulation.trial().clone()),
    };
    let step_name = if walking.is_some() { "crowd.TimeStepMechanical" } else { "TimeStepMechanical" };
    let mechanical = simulation.trial().parameters.time_step_mechanical;
    let directory = simulation.text(Quantity::OutputDirectory).to_owned();
    let parts = |_| format!("people walk        ({} algorithm)", settings.algorithm);
    Ok(Prepared {
        crowds: vec![crowd],
        coupling: walking.iter().map(parts).collect(),
        plans: walking.into_iter().collect(),
        mechanical_steps: vec![(step_name.into(), mechanical)],
        output_directories: Some(directory)
            .filter(|name| !name.is_empty())
            .map(PathBuf::from)
            .into_iter()
            .collect(),
        record: Saved {
            algorithm: settings.algorithm.to_string(),
            drive: drive.fingerprint(),
            ..record_of(&clock, every, before.as_ref())
        },
        clock,
        drive_end,
        before,
        model: Box::new(TrialRun { simulation, outputs, name, guid }),
    })
}

/// The documents of a run; errors of a Trial are printed.
pub fn documents(
    given: &TrialInput,
    settings: &Settings,
) -> Result<(Documents, lemons_core::trial::Problems, Option<PathBuf>)> {
    let read = given.documents(&settings.drive, &settings.plan);
    read.map_err(|error| crate::messages::report_problems(error.into()))
}

/// Why a parameter was not set, in the words of the command.
pub fn not_set(error: SimError) -> Error {
    match error {
        SimError::Unknown { name, text, meant: Some(value) } => {
            not_prepared(PrepareError::OfOther { name, value: text, meant: value })
        }
        SimError::Unknown { meant: None, .. } => anyhow!("--set {error}; see lemons info"),
        SimError::Value { .. } => anyhow!("--set {error}"),
        error => error.into(),
    }
}

/// Whether nobody has a speed or a force at the start.
fn is_still(simulation: &Simulation) -> bool {
    simulation.world().is_some_and(|world| {
        let still = |(twist, drive): (&lemons_core::plane::Twist, &crowd_mechanics::engine::Wrench)| {
            *twist == lemons_core::plane::Twist::default() && *drive == Default::default()
        };
        world.state().twists.iter().zip(&world.drive).all(still)
    })
}
