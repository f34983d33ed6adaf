//! A run of an FMU, or of FMUs that an SSP couples: frames of its crowds, from the outputs of their FMUs.

use super::model::{CrowdInfo, PreparedRun, RecordedModel};
use super::outputs::OutputValues;
use crate::print::few;
use anyhow::{Error, Result, anyhow};
use crowd_mechanics::quantities::segments;
use lemons_core::trial::Trial;
use lemons_master::ssp::{Causality, FmiType, FmuVariable, Interface};
use lemons_master::{RunSettings, System, SystemComponent, ValueSelection, plan_in};
use lemons_results::columns::{self, Column, Group, Groups};
use lemons_results::{CellType, Frame, OfWall};
use lemons_sim::RunModel;

struct FmuRun {
    run: lemons_master::PreparedSystem,
    crowds: Vec<Reader>,
    /// The outputs of other components, by their places: numbers and texts.
    outputs: Vec<(usize, ValueSelection, ValueSelection)>,
}

/// Reads the frames of a crowd from the outputs of its FMU.
struct Reader {
    /// Place among the components.
    place: usize,
    agents: usize,
    groups: Groups,
    values: ValueSelection,
    /// Means and peaks of the pieces of walls.
    walls: Option<[ValueSelection; 2]>,
    /// If somebody comes later.
    trial: Option<Trial>,
    /// The same of panels, and their lengths \[m\].
    panels: Option<([ValueSelection; 2], Vec<f64>)>,
}

/// Parameters that are chosen before initialization.
const STEP: &str = "TimeStepMechanical";
const DIRECTORY: &str = "OutputDirectory";
/// Outputs of each panel.
const BARRIER_LOADS: [&str; 2] = ["Load", "PeakLoad"];
/// Outputs of each straight piece of a wall.
const WALL_FORCES: [&str; 2] = ["MeanNormalForce", "PeakNormalForce"];

/// Prepares a run of an FMU or an SSP. Warnings are printed.
pub fn prepare(settings: &RunSettings) -> Result<PreparedRun> {
    let mut run = lemons_master::PreparedSystem::of(settings)?;
    run.warnings.iter().for_each(|warning| note!("{warning}"));
    let (system, trials) = (&run.system, std::mem::take(&mut run.trials));
    let (mut readers, mut crowds) = (Vec::new(), Vec::new());
    let (mut output_columns, mut outputs) = (Vec::new(), Vec::new());
    let mut output_directories = Vec::new();
    for (place, trial) in trials.into_iter().enumerate() {
        let component = &system.components[place];
        if trial.is_some() && component.fmu.kind(DIRECTORY).is_some() {
            output_directories.push(component.instance.value::<String>(DIRECTORY)?);
        }
        let agents = agents_of(&component.fmu.description);
        if agents == 0 {
            let columns = output_columns_of(component, run.coupled);
            let names = |is_text: bool| {
                let own = columns.iter().filter(move |column| (column.kind == CellType::Text) == is_text);
                component.instance.select(own.map(|column| &column.variable))
            };
            outputs.push((place, names(false)?, names(true)?));
            output_columns.extend(columns);
            continue;
        }
        let (reader, crowd) = Reader::of(system, place, agents, trial)?;
        readers.push(reader);
        crowds.push(crowd);
    }
    let mut mechanical_steps = Vec::new();
    for component in &system.components {
        if component.fmu.description.single(STEP).is_some() {
            let name = if run.coupled { format!("{}.{STEP}", component.name) } else { STEP.to_owned() };
            mechanical_steps.push((name, component.instance.value(STEP)?));
        }
    }
    let (count, connections, algorithm) = (system.components.len(), system.connections, system.algorithm);
    let parts =
        format!("components         {count:>10}     ({algorithm} algorithm, {connections} connections)");
    Ok(PreparedRun {
        crowds,
        output_columns,
        plans: system.components.iter().filter_map(|component| plan_in(&component.fmu)).collect(),
        coupling: run.coupled.then_some(parts).into_iter().collect(),
        mechanical_steps,
        output_directories,
        clock: run.clock,
        every: run.every,
        drive: run.feed.drive.clone(),
        components: system.records(),
        wiring: system.fingerprint.clone(),
        before: run.before.take(),
        model: Box::new(FmuRun { run, crowds: readers, outputs }),
    })
}

impl RunModel for FmuRun {
    type Error = Error;

    fn step_to(&mut self, time: f64) -> Result<()> {
        Ok(self.run.step_to(time)?)
    }

    fn time(&self) -> f64 {
        self.run.system.time
    }

    fn frames(&self) -> Result<Vec<Frame>> {
        self.crowds.iter().map(|crowd| crowd.frame(&self.run.system)).collect()
    }
}

impl RecordedModel for FmuRun {
    fn outputs(&mut self) -> Result<OutputValues> {
        let mut values = OutputValues::default();
        for (place, numbers, texts) in &self.outputs {
            let instance = &self.run.system.components[*place].instance;
            values.0.extend(instance.values::<f64>(numbers)?);
            values.1.extend(instance.values::<String>(texts)?);
        }
        Ok(values)
    }

    fn states(&mut self) -> Result<Vec<Vec<u8>>> {
        Ok(self.run.system.states()?)
    }

    fn terminate(&mut self) -> Result<()> {
        Ok(self.run.system.terminate()?)
    }

    fn take_warnings(&mut self) -> Vec<String> {
        self.run.system.warnings()
    }
}

impl Reader {
    /// Makes the reader of the first `agents` of an initialized component.
    fn of(system: &System, place: usize, agents: usize, trial: Option<Trial>) -> Result<(Reader, CrowdInfo)> {
        let component = &system.components[place];
        let trial = trial.filter(|trial| trial.agents.len() == agents);
        let description = &component.fmu.description;
        let has = |name: &str| match columns::with_name(name) {
            Some(of) if of.group == Group::Totals => is_output(description, of.variable, of),
            Some(of) => (0..agents).all(|i| is_output(description, &of_agent(i, of), of)),
            None => false,
        };
        let groups = Groups::among(has).with(Group::Active, may_leave(system, place, agents)?);
        let ids = match &trial {
            Some(trial) => trial.agents.iter().map(|agent| agent.id.clone()).collect(),
            None => (0..agents).map(|i| i.to_string()).collect(),
        };
        let crowd = CrowdInfo {
            component: component.name.clone(),
            ids,
            trial,
            groups,
            columns: columns_of(description, groups),
            model_name: description.model_name.clone(),
            guid: description.guid.clone(),
        };
        let variables = groups.variables(agents);
        let values = component.instance.select(variables.iter().map(|(name, _)| name))?;
        let select = |count: usize, element: &str, outputs: [&str; 2]| {
            let names =
                outputs.map(|name| (0..count).map(|k| format!("{element}[{k}].{name}")).collect::<Vec<_>>());
            let known = names.iter().flatten().all(|name| description.single(name).is_some());
            let [means, peaks] = names.map(|names| component.instance.select(names.iter()));
            known.then(|| Ok::<_, Error>([means?, peaks?])).transpose()
        };
        let (mut walls, mut panels) = (None, None);
        if let Some(trial) = &crowd.trial {
            let doors = (0..trial.geometry.doors().count()).map(|k| format!("door[{k}].Open"));
            let fed: Vec<String> = doors.filter(|door| system.feeds(place, door)).collect();
            if !fed.is_empty() {
                note!(
                    "note: {}: {} connected, which tables do not hold: pictures of this run show doors by the times \
                     of the Trial that they get (--trial)",
                    component.name,
                    few(&fed, 5)
                );
            }
            walls = select(segments(trial).count(), "wall", WALL_FORCES)?;
            let lengths: Vec<f64> =
                trial.geometry.panels().map(|(_, [start, end])| (end - start).norm()).collect();
            panels = select(lengths.len(), "barrier", BARRIER_LOADS)?.map(|values| (values, lengths));
        }
        let late = |trial: &&Trial| trial.dynamics.iter().any(|own| own.absent);
        let trial = crowd.trial.as_ref().filter(late).cloned();
        Ok((Reader { place, agents, groups, values, walls, trial, panels }, crowd))
    }

    fn frame(&self, system: &System) -> Result<Frame> {
        let component = &system.components[self.place];
        let values = component.instance.values(&self.values)?;
        let frame = self.groups.frame_of_values(system.time, self.agents, &values);
        let mut frame = frame.map_err(|what| anyhow!("{}: {what}", component.name))?;
        let forces = |[means, peaks]: &[ValueSelection; 2], length: &dyn Fn(usize) -> f64| {
            let both = component.instance.values::<f64>(means)?.into_iter();
            let both = both.zip(component.instance.values::<f64>(peaks)?).enumerate();
            let of = |(k, (mean, peak)): (usize, (f64, f64))| OfWall {
                mean_normal_force: mean * length(k),
                peak_normal_force: peak * length(k),
            };
            Ok::<Vec<OfWall>, Error>(both.map(of).collect())
        };
        frame.walls = self.walls.as_ref().map(|walls| forces(walls, &|_| 1.0)).transpose()?;
        let panels = self.panels.as_ref();
        frame.panels = panels.map(|(panels, lengths)| forces(panels, &|k| lengths[k])).transpose()?;
        Ok(match &self.trial {
            Some(trial) => frame.with_outside(trial),
            None => frame,
        })
    }
}

/// The name of a variable of an agent.
fn of_agent(i: usize, quantity: &columns::RecordedQuantity) -> String {
    format!("agent[{i}].{}", quantity.variable)
}

/// Returns whether an FMU has this output, with the type of the quantity.
fn is_output(description: &Interface, name: &str, quantity: &columns::RecordedQuantity) -> bool {
    description.single(name).is_some_and(|single| {
        let variable = single.variable;
        cell_type(variable) == Some(quantity.kind()) && variable.kind == Some(Causality::Output)
    })
}

/// Returns the type of a variable's values in a table, which has no place for binary values and clocks.
fn cell_type(variable: &FmuVariable) -> Option<CellType> {
    match variable.of.class() {
        FmiType::Real => Some(CellType::Real),
        FmiType::Boolean => Some(CellType::Boolean),
        FmiType::String => Some(CellType::Text),
        FmiType::Binary | FmiType::Clock => None,
        _ => Some(CellType::Integer),
    }
}

/// How many agents' outputs an FMU has under the names of our mechanics, from 0 on.
fn agents_of(description: &Interface) -> usize {
    let needed = || Group::Motion.quantities().chain(Group::Contacts.quantities());
    let has = |i: &usize| needed().all(|quantity| is_output(description, &of_agent(*i, quantity), quantity));
    (0..).take_while(has).count()
}

/// Returns whether inputs say who is there, and another component decides about it or somebody is not there from the start.
fn may_leave(system: &System, place: usize, agents: usize) -> Result<bool> {
    let component = &system.components[place];
    let active = || Group::Active.quantities();
    let names: Vec<String> = (0..agents).flat_map(|i| active().map(move |of| of_agent(i, of))).collect();
    let is_input = |name: &String| {
        let found = component.fmu.description.single(name).map(|single| single.variable);
        found.is_some_and(|variable| {
            variable.of == FmiType::Boolean && variable.kind == Some(Causality::Input)
        })
    };
    if !names.iter().all(is_input) {
        return Ok(false);
    }
    let there: Vec<f64> = component.instance.values(&component.instance.select(&names)?)?;
    Ok(there.contains(&0.0) || names.iter().any(|name| system.feeds(place, name)))
}

/// The columns of the table.
fn columns_of(description: &Interface, groups: Groups) -> Vec<Column> {
    let mut all = groups.columns();
    // What the FMU itself says comes first: it might count in other units.
    for column in all.iter_mut().filter(|column| column.kind == CellType::Real) {
        if let Some(name) = column.variable.strip_prefix("agent[i].") {
            let own = description.single(&format!("agent[0].{name}"));
            let unit = own.and_then(|own| own.variable.unit.clone());
            column.unit = unit.or(column.unit.take());
        }
    }
    all
}

/// The columns of the outputs of what is not a crowd; the variables of the columns are the names of the values. Where FMUs are
/// coupled, columns begin with the name of the component.
fn output_columns_of(component: &SystemComponent, coupled: bool) -> Vec<Column> {
    let singles = component.fmu.description.singles();
    let outputs = singles.filter(|(_, single)| single.variable.kind == Some(Causality::Output));
    let columns = outputs.filter_map(|(name, single)| {
        let variable = single.variable;
        Some(Column {
            name: if coupled { format!("{}.{name}", component.name) } else { name.clone() },
            kind: cell_type(variable)?,
            unit: variable.unit.clone(),
            variable: name,
            description: variable.description.clone().unwrap_or_default(),
        })
    });
    columns.collect()
}
