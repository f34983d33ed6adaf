//! A run of an FMU, or of FMUs that an SSP couples: frames of its crowds, from the outputs of their FMUs.

use super::model::{CrowdInfo, Prepared, RunModel, States, record_of};
use super::outputs::Outputs;
use crate::connect::plain_names;
use crate::messages::{not_prepared, warning_text};
use crate::results::{CellType, Column};
use anyhow::{Error, Result, anyhow};
use lemons_core::trial::Trial;
use lemons_master::ssp::{Interface, Kind as Causality, Type};
use lemons_master::{Saved, Selection, Settings, System, plan_in, wiring_of};
use lemons_results::Frame;
use lemons_results::columns::{self, Groups};
use lemons_sim::{Clock, Model};
use std::path::PathBuf;

struct FmuRun {
    run: lemons_master::Prepared,
    crowds: Vec<Reader>,
    outputs: Option<Outputs>,
}

/// Reads the frames of a crowd from the outputs of its FMU.
struct Reader {
    /// Place among the components.
    place: usize,
    agents: usize,
    groups: Groups,
    /// Types of the values, in their order.
    kinds: Vec<CellType>,
    reals: Selection,
    integers: Selection,
    booleans: Selection,
}

/// What is chosen before initialization.
const STEP: &str = "TimeStepMechanical";
const DIRECTORY: &str = "OutputDirectory";

/// Prepares a run of an FMU or an SSP. Outputs of what is not a crowd go to a table, unless the run is not recorded.
pub fn prepare(
    settings: &Settings,
    outputs: impl FnOnce(&System, Vec<usize>, (&Clock, u64), Option<&Saved>) -> Result<Option<Outputs>>,
) -> Result<Prepared> {
    let mut run = lemons_master::Prepared::of(settings).map_err(not_prepared)?;
    for warning in &run.warnings {
        note!("{}", warning_text(warning));
    }
    let (system, trials) = (&run.system, std::mem::take(&mut run.trials));
    let (mut readers, mut crowds, mut others) = (Vec::new(), Vec::new(), Vec::new());
    let mut output_directories = Vec::new();
    for (place, trial) in trials.into_iter().enumerate() {
        let component = &system.components()[place];
        if trial.is_some() && component.fmu.kind(DIRECTORY).is_some() {
            let name = component.instance.value::<String>(DIRECTORY)?;
            output_directories.extend(Some(name).filter(|name| !name.is_empty()).map(PathBuf::from));
        }
        let agents = agents_of(&component.fmu.description);
        if agents == 0 {
            others.push(place);
            continue;
        }
        let (reader, crowd) = Reader::of(system, place, agents, trial)?;
        readers.push(reader);
        crowds.push(crowd);
    }
    // Files have plain names.
    let names: Vec<String> = crowds.iter().map(|crowd| crowd.component.clone()).collect();
    for (crowd, name) in crowds.iter_mut().zip(plain_names(names.iter().map(String::as_str))) {
        crowd.file_name = name;
    }
    let outputs = outputs(system, others, (&run.clock, run.every), run.before.as_ref())?;
    let mut mechanical_steps = Vec::new();
    for component in system.components() {
        if component.fmu.description.single(STEP).is_some() {
            let name = if run.coupled { format!("{}.{STEP}", component.name) } else { STEP.to_owned() };
            mechanical_steps.push((name, component.instance.value(STEP)?));
        }
    }
    let (count, connections, algorithm) =
        (system.components().len(), system.connections(), system.algorithm());
    let parts =
        format!("components         {count:>10}     ({algorithm} algorithm, {connections} connections)");
    Ok(Prepared {
        crowds,
        plans: system.components().iter().filter_map(|component| plan_in(&component.fmu)).collect(),
        coupling: run.coupled.then_some(parts).into_iter().collect(),
        mechanical_steps,
        output_directories,
        clock: run.clock,
        drive_end: run.feed.drive.end(),
        record: Saved {
            algorithm: algorithm.to_string(),
            wiring: wiring_of(system),
            drive: run.feed.drive.fingerprint(),
            ..record_of(&run.clock, run.every, run.before.as_ref())
        },
        before: run.before.take(),
        model: Box::new(FmuRun { run, crowds: readers, outputs }),
    })
}

impl Model for FmuRun {
    type Error = Error;

    fn step_to(&mut self, time: f64) -> Result<()> {
        Ok(self.run.step_to(time)?)
    }
}

impl RunModel for FmuRun {
    fn time(&self) -> f64 {
        self.run.system.time()
    }

    fn frame(&self, crowd: usize) -> Result<Frame> {
        self.crowds[crowd].frame(&self.run.system)
    }

    fn values(&mut self, crowd: usize, names: &[String]) -> Result<Vec<f64>> {
        let instance = &self.run.system.components()[self.crowds[crowd].place].instance;
        Ok(instance.values(&instance.select(names)?)?)
    }

    fn write_outputs(&mut self) -> Result<()> {
        self.outputs.as_mut().map_or(Ok(()), |outputs| outputs.write_row(&self.run.system))
    }

    fn finish_outputs(&mut self) -> Result<Option<String>> {
        self.outputs.take().map(Outputs::finish).transpose()
    }

    fn states(&mut self) -> Result<States> {
        let states = self.run.system.states()?;
        Ok((Saved::components(&self.run.system, &states), states))
    }

    fn terminate(&mut self) -> Result<()> {
        Ok(self.run.system.terminate()?)
    }

    fn take_warnings(&mut self) -> Vec<String> {
        self.run.system.warnings()
    }
}

impl Reader {
    /// Of the first `agents` of an initialized component.
    fn of(system: &System, place: usize, agents: usize, trial: Option<Trial>) -> Result<(Reader, CrowdInfo)> {
        let component = &system.components()[place];
        let trial = trial.filter(|trial| trial.agents.len() == agents);
        let description = &component.fmu.description;
        let has_all = |group: &[columns::Quantity]| {
            group.iter().all(|quantity| is_output(description, quantity.variable, quantity))
        };
        let has_steps = |i: usize| {
            columns::OF_STEP.iter().all(|quantity| is_output(description, &of_agent(i, quantity), quantity))
        };
        let groups = Groups {
            contacts: true,
            of_step: (0..agents).all(has_steps),
            active: may_leave(system, place, agents)?,
            totals: has_all(&columns::TOTALS),
        };
        let mut about: Vec<_> = trial.iter().map(|trial| ("trial", trial.name.clone())).collect();
        about.push(("component", component.name.clone()));
        about.extend([("model_name", description.model_name.clone()), ("guid", description.guid.clone())]);
        let ids = match &trial {
            Some(trial) => trial.agents.iter().map(|agent| agent.id.clone()).collect(),
            None => (0..agents).map(|i| i.to_string()).collect(),
        };
        let crowd = CrowdInfo {
            component: component.name.clone(),
            file_name: String::new(),
            ids,
            trial,
            groups,
            columns: columns_of(description, groups),
            about,
        };
        let variables = groups.variables(agents);
        let select = |kind: CellType| {
            component.instance.select(variables.iter().filter(|(_, own)| *own == kind).map(|(name, _)| name))
        };
        let reader = Reader {
            place,
            agents,
            groups,
            reals: select(CellType::Real)?,
            integers: select(CellType::Integer)?,
            booleans: select(CellType::Boolean)?,
            kinds: variables.into_iter().map(|(_, kind)| kind).collect(),
        };
        Ok((reader, crowd))
    }

    fn frame(&self, system: &System) -> Result<Frame> {
        let component = &system.components()[self.place];
        let instance = &component.instance;
        let mut reals = instance.values::<f64>(&self.reals)?.into_iter();
        let mut integers = instance.values::<i32>(&self.integers)?.into_iter().map(f64::from);
        let mut booleans = instance.values::<bool>(&self.booleans)?.into_iter().map(f64::from);
        let next = |kind: &CellType| match kind {
            CellType::Real => reals.next(),
            CellType::Integer => integers.next(),
            _ => booleans.next(),
        };
        let values: Vec<f64> = self.kinds.iter().filter_map(next).collect();
        let frame = Frame::of_values(system.time(), self.agents, self.groups, &values);
        frame.map_err(|what| anyhow!("{}: {what}", component.name))
    }
}

/// The name of a variable of an agent.
fn of_agent(i: usize, quantity: &columns::Quantity) -> String {
    format!("agent[{i}].{}", quantity.variable)
}

/// Whether an FMU has this output, with the type of the quantity.
fn is_output(description: &Interface, name: &str, quantity: &columns::Quantity) -> bool {
    let found = description.single(name).map(|single| single.variable);
    found.is_some_and(|variable| {
        let is_type = match quantity.kind() {
            CellType::Real => matches!(variable.of, Type::Real(_)),
            _ => variable.of == Type::Integer,
        };
        is_type && variable.kind == Some(Causality::Output)
    })
}

/// How many agents' outputs an FMU has under the names of our mechanics, from 0 on.
fn agents_of(description: &Interface) -> usize {
    let needed = || columns::MOTION.iter().chain(&columns::CONTACTS).chain([&columns::SQUEEZE]);
    let has = |i: &usize| needed().all(|quantity| is_output(description, &of_agent(*i, quantity), quantity));
    (0..).take_while(has).count()
}

/// Whether inputs say who is there, and another component decides about it or somebody is not there from the start.
fn may_leave(system: &System, place: usize, agents: usize) -> Result<bool> {
    let component = &system.components()[place];
    let names: Vec<String> = (0..agents).map(|i| of_agent(i, &columns::ACTIVE)).collect();
    let is_input = |name: &String| {
        let found = component.fmu.description.single(name).map(|single| single.variable);
        found.is_some_and(|variable| variable.of == Type::Boolean && variable.kind == Some(Causality::Input))
    };
    if !names.iter().all(is_input) {
        return Ok(false);
    }
    let there: Vec<bool> = component.instance.values(&component.instance.select(&names)?)?;
    Ok(there.contains(&false) || names.iter().any(|name| system.feeds(place, name)))
}

/// The columns of the table.
fn columns_of(description: &Interface, groups: Groups) -> Vec<Column> {
    let mut all = groups.columns();
    // What the FMU itself says comes first: it might count in other units.
    for column in all.iter_mut().filter(|column| column.kind == CellType::Real) {
        if let Some(name) = column.variable.strip_prefix("agent[i].") {
            let own = description.single(&format!("agent[0].{name}"));
            let said = own.and_then(|own| own.variable.of.unit()).map(str::to_owned);
            column.unit = said.or(column.unit.take());
        }
    }
    all
}
