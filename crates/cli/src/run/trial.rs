//! A run of a Trial in memory.

use super::model::{CrowdInfo, PreparedRun, RecordedModel};
use super::outputs::OutputValues;
use anyhow::{Context, Error, Result, anyhow, bail};
use crowd_mechanics::engine::Wrench;
use crowd_mechanics::model_description::MODEL_NAME;
use crowd_mechanics::quantities::{CrowdQuantity, guid};
use lemons_core::plane::{Twist, Vec2};
use lemons_decision::DECISION_FILE;
use lemons_fmi::variables::{Scalar, VariableType};
use lemons_master::{ComponentRecord, RunSettings, TrialInput, notes};
use lemons_results::columns::{Column, Groups};
use lemons_results::{CellType, Frame};
use lemons_sim::lint::{self, Files};
use lemons_sim::settings::{CROWD, DECISION, VariableSelection};
use lemons_sim::{RunModel, SimError, Simulation};

/// Name of the component in a saved run of people who walk.
const WALKERS: &str = "crowd and decision";

struct TrialRun {
    simulation: Simulation,
    /// The outputs of Decision.
    outputs: VariableSelection,
}

/// The columns of the outputs of Decision.
fn columns_of(simulation: &Simulation) -> Vec<Column> {
    let column = |scalar: &Scalar<_>| {
        let (kind, unit) = match scalar.variable.kind {
            VariableType::Real(of) => (CellType::Real, Some(of.unit.name.to_owned())),
            VariableType::Integer => (CellType::Integer, None),
            _ => (CellType::Boolean, None),
        };
        Column {
            name: format!("{DECISION}.{}", scalar.name),
            kind,
            unit,
            variable: scalar.name.clone(),
            description: scalar.description.clone(),
        }
    };
    simulation.decision_outputs().iter().map(column).collect()
}

impl RunModel for TrialRun {
    type Error = Error;

    fn step_to(&mut self, time: f64) -> Result<()> {
        Ok(self.simulation.step_to(time)?)
    }

    fn time(&self) -> f64 {
        self.simulation.time()
    }

    fn frames(&self) -> Result<Vec<Frame>> {
        Ok(self.simulation.frames()?)
    }
}

impl RecordedModel for TrialRun {
    fn drive(&self) -> Option<Vec<Vec2>> {
        Some(self.simulation.world()?.drive.iter().map(|drive| drive.force).collect())
    }

    fn outputs(&mut self) -> Result<OutputValues> {
        Ok((self.simulation.read(&self.outputs)?, Vec::new()))
    }

    fn states(&mut self) -> Result<Vec<Vec<u8>>> {
        Ok(vec![self.simulation.save()])
    }

    fn take_warnings(&mut self) -> Vec<String> {
        self.simulation.take_warnings().into_iter().map(|warning| format!("warning: {warning}")).collect()
    }
}

/// Prepares a run of a Trial. Warnings are printed.
pub fn prepare(given: &TrialInput, settings: &RunSettings) -> Result<PreparedRun> {
    let saved = settings.saved()?;
    let (mut documents, mut problems, decision) = given.documents(&settings.drive, &settings.decision)?;
    if let Some(panels) = settings.panels {
        documents.trial.geometry.divide(panels).map_err(Error::msg)?;
    }
    let files = Files::chosen(given.path(), &settings.drive, decision.as_deref());
    problems.extend(lint::of_documents(&documents, &files));
    problems.iter().for_each(|problem| note!("{problem}"));
    let (drive, walking) = (documents.drive.clone(), documents.plan.clone());
    let trial = documents.trial.clone();
    let mut simulation = Simulation::new(documents, settings.algorithm)?;
    if settings.tolerance.is_some() {
        // It only shortens the step that is set, and shall choose it.
        simulation.set("TimeStepMechanical", "1")?;
    }
    for (name, value) in &settings.parameters {
        if let Some(input) = simulation.set(name, value).map_err(not_set)? {
            note!("{}", notes::overwritten(name, value, &input));
        }
    }
    if let Some(threads) = settings.threads {
        simulation.set("Threads", &threads.to_string())?;
    }
    for (name, [decision, crowd], people) in simulation.differing()? {
        note!("{}", notes::differs(&name, [(DECISION, decision), (CROWD, crowd)], people));
    }
    let (before, states) = saved.unzip();
    simulation.begin(0.0, settings.tolerance)?;
    let name = if walking.is_some() { WALKERS } else { CROWD };
    let guid = guid(&trial).braced().to_string();
    let components = vec![ComponentRecord::new(name, MODEL_NAME, &guid)];
    let of_saved = || format!("saved run {}", settings.resume.as_deref().unwrap_or(given.path()).display());
    if let Some(before) = &before {
        match (&decision, before.component[0].name.as_str()) {
            (Some(file), CROWD) => bail!(
                "nobody walked by a file in the saved run, but now people would walk ({}): give --no-decision to go on as \
                 before",
                file.display()
            ),
            (None, WALKERS) => bail!(
                "people walked by a file like {DECISION_FILE} in the saved run, but now nobody would: go on without \
                 --no-decision, and with the file as it was (--decision)"
            ),
            _ => {}
        }
        before.check(&components, settings.algorithm, "").with_context(of_saved)?;
    }
    let step = Some(trial.parameters.time_step);
    let (clock, every, warnings) = settings.points(before.as_ref(), 0.0, [None, step], &drive)?;
    if let Some(states) = &states {
        simulation.restore(&states[0]).with_context(of_saved)?;
    }
    warnings.iter().for_each(|warning| note!("{warning}"));
    if decision.is_none() && before.is_none() && drive.end().is_none() && is_still(&simulation) {
        note!("{}", notes::still());
    }
    let output_columns = columns_of(&simulation);
    let names: Vec<String> = output_columns.iter().map(|column| column.name.clone()).collect();
    let outputs = simulation.select(&names).map_err(|(name, _)| anyhow!("there is no {name}"))?;
    let groups = Groups::of(&simulation.frame());
    let crowd = CrowdInfo {
        component: CROWD.into(),
        ids: simulation.ids().to_vec(),
        groups,
        columns: groups.columns(),
        model_name: MODEL_NAME.into(),
        guid,
        trial: Some(simulation.trial().clone()),
    };
    let step_name = if walking.is_some() { "crowd.TimeStepMechanical" } else { "TimeStepMechanical" };
    let mechanical = simulation.trial().parameters.time_step_mechanical;
    let parts = |_| format!("people walk        ({} algorithm)", settings.algorithm);
    Ok(PreparedRun {
        crowds: vec![crowd],
        output_columns,
        coupling: walking.iter().map(parts).collect(),
        plans: walking.into_iter().collect(),
        mechanical_steps: vec![(step_name.into(), mechanical)],
        output_directories: vec![simulation.text(CrowdQuantity::OutputDirectory).to_owned()],
        clock,
        every,
        drive,
        components,
        wiring: String::new(),
        before,
        model: Box::new(TrialRun { simulation, outputs }),
    })
}

/// Why a parameter was not set, in the words of the command.
pub fn not_set(error: SimError) -> Error {
    match error {
        SimError::Unknown { given, meant: Some(meant) } => {
            let (name, text) = given.split_once('=').unwrap_or((&given, ""));
            notes::no_such_variable(name, text, &meant).into()
        }
        SimError::Unknown { meant: None, .. } => anyhow!("--set {error}; see lemons info"),
        SimError::Value { .. } => anyhow!("--set {error}"),
        error => error.into(),
    }
}

/// Returns whether nobody has a speed or a force at the start.
fn is_still(simulation: &Simulation) -> bool {
    simulation.world().is_some_and(|world| {
        world.state().twists.iter().all(|twist| *twist == Twist::default())
            && world.drive.iter().all(|drive| *drive == Wrench::default())
    })
}
