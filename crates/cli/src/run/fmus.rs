//! A run of an FMU, or of FMUs that an SSP couples: frames of its crowds, from the outputs of their FMUs.

use super::outputs::Outputs;
use super::subject::{CrowdInfo, Identity, Prepared, States, Subject};
use crate::connect::plain_names;
use crate::results::{Column, Kind};
use crate::words::{refused, warned};
use anyhow::{Context, Error, Result};
use lemons_core::plane::{Motion, Pose, Twist, vec2};
use lemons_core::trial::Trial;
use lemons_master::ssp::{Interface, Kind as Causality, Type};
use lemons_master::{Component, Saved, Selection, Settings, System, plan_in, wiring_of};
use lemons_results::columns::{self, Groups};
use lemons_results::{Frame, Observed, OfStep, Totals};
use lemons_sim::{Clock, Model};
use std::path::PathBuf;

struct FmuRun {
    run: lemons_master::Prepared,
    crowds: Vec<Reader>,
    outputs: Option<Outputs>,
}

/// Outputs of a crowd.
struct Reader {
    /// Place among the components.
    place: usize,
    motions: Selection,
    contacts: Selection,
    squeezes: Selection,
    /// Empty if the FMU has none.
    steps: Selection,
    /// Whether agents are there; empty if nothing decides about it.
    active: Selection,
    /// Empty if the FMU has none.
    totals: Selection,
}

/// What is chosen before initialization.
const STEP: &str = "TimeStepMechanical";
const DIRECTORY: &str = "OutputDirectory";

/// Prepares a run of an FMU or an SSP. Outputs of what is not a crowd go to a table, unless the run is not recorded.
pub fn prepare(
    settings: &Settings,
    outputs: impl FnOnce(&System, Vec<usize>, (&Clock, u64), Option<&Saved>) -> Result<Option<Outputs>>,
) -> Result<Prepared> {
    let mut run = lemons_master::Prepared::of(settings).map_err(refused)?;
    for warning in &run.warnings {
        note!("{}", warned(warning));
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
        index: run.before.as_ref().map_or(0, |before| before.index),
        every: run.every,
        drive_end: run.pushes.drive.end(),
        identity: Identity {
            algorithm: algorithm.to_string(),
            wiring: wiring_of(system),
            drive: run.pushes.drive.fingerprint(),
        },
        before: run.before.take(),
        subject: Box::new(FmuRun { run, crowds: readers, outputs }),
    })
}

impl Model for FmuRun {
    type Error = Error;

    fn step_to(&mut self, time: f64) -> Result<()> {
        Ok(self.run.step_to(time)?)
    }
}

impl Subject for FmuRun {
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
        self.outputs.as_mut().map_or(Ok(()), |outputs| outputs.look(&self.run.system))
    }

    fn finish_outputs(&mut self) -> Result<Option<String>> {
        self.outputs.take().map(Outputs::finish).transpose()
    }

    fn states(&mut self) -> Result<States> {
        let states = self.run.system.states()?;
        let states = states.iter().map(lemons_master::State::bytes).collect::<Result<Vec<_>, _>>()?;
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
        let select = |rows: &[columns::Quantity]| {
            let names =
                (0..agents).flat_map(|i| rows.iter().map(move |row| format!("agent[{i}].{}", row.variable)));
            component.instance.select(names)
        };
        let description = &component.fmu.description;
        let steps =
            if has_steps(description, agents) { select(&columns::OF_STEP)? } else { Selection::default() };
        let (totals, active) = (totals_of(component)?, active_of(system, place, agents)?);
        let groups = Groups {
            contacts: true,
            of_step: !steps.is_empty(),
            active: !active.is_empty(),
            totals: !totals.is_empty(),
        };
        let mut about: Vec<_> = trial.iter().map(|trial| ("trial", trial.name.clone())).collect();
        about.push(("component", component.name.clone()));
        about.extend([("model_name", description.model_name.clone()), ("guid", description.guid.clone())]);
        let ids = match &trial {
            Some(trial) => trial.agents.iter().map(|agent| agent.id.clone()).collect(),
            None => (0..agents).map(|i| i.to_string()).collect(),
        };
        let columns = columns_of(description, groups);
        let crowd = CrowdInfo {
            component: component.name.clone(),
            file_name: String::new(),
            ids,
            trial,
            groups,
            columns,
            about,
        };
        let reader = Reader {
            place,
            motions: select(&columns::MOTION)?,
            contacts: select(&columns::CONTACTS)?,
            squeezes: select(&[columns::SQUEEZE])?,
            steps,
            active,
            totals,
        };
        Ok((reader, crowd))
    }

    fn frame(&self, system: &System) -> Result<Frame> {
        let instance = &system.components()[self.place].instance;
        let motions: Vec<f64> = instance.values(&self.motions)?;
        let squeezes: Vec<f64> = instance.values(&self.squeezes)?;
        let steps: Vec<f64> = instance.values(&self.steps)?;
        let contacts: Vec<i32> = instance.values(&self.contacts)?;
        let totals: Vec<i32> = instance.values(&self.totals)?;
        let active: Vec<bool> = instance.values(&self.active)?;
        let (motions, contacts, steps) = (motions.as_chunks().0, contacts.as_chunks().0, steps.as_chunks().0);
        let mut frame = frame(system.time(), motions, contacts, &squeezes, steps, &totals)?;
        frame.active = (!active.is_empty()).then_some(active);
        Ok(frame)
    }
}

/// How many agents' outputs an FMU has under the names of our mechanics, from 0 on.
pub fn agents_of(description: &Interface) -> usize {
    let is = |name: &str, real: bool| {
        let found = description.single(name).map(|single| single.variable);
        let found = found.filter(|variable| variable.kind == Some(Causality::Output));
        found.is_some_and(|variable| matches!(variable.of, Type::Real(_)) == real)
    };
    let has = |i: usize| {
        let reals = columns::MOTION.iter().chain([&columns::SQUEEZE]).map(|row| (row.variable, true));
        let mut names = reals.chain(columns::CONTACTS.iter().map(|row| (row.variable, false)));
        names.all(|(name, real)| is(&format!("agent[{i}].{name}"), real))
    };
    (0..).take_while(|&i| has(i)).count()
}

/// Integer outputs of the whole crowd; none if one is missing.
fn totals_of(component: &Component) -> lemons_master::Result<Selection> {
    let totals = columns::TOTALS.iter().map(|row| {
        let found = component.fmu.description.single(row.variable)?;
        let own = found.variable;
        (own.of == Type::Integer && own.kind == Some(Causality::Output)).then_some(found.address())
    });
    let addresses = totals.collect::<Option<Vec<_>>>().unwrap_or_default();
    component.instance.select_at(&addresses)
}

/// The inputs that say whether agents are there, if another component decides about it or somebody is not there from the
/// start; else none.
fn active_of(system: &System, place: usize, agents: usize) -> lemons_master::Result<Selection> {
    let component = &system.components()[place];
    let name = |i: usize| format!("agent[{i}].{}", columns::ACTIVE.variable);
    let address = |i: usize| {
        let found = component.fmu.description.single(&name(i))?;
        let own = found.variable;
        (own.of == Type::Boolean && own.kind == Some(Causality::Input)).then_some(found.address())
    };
    let addresses = (0..agents).map(address).collect::<Option<Vec<_>>>().unwrap_or_default();
    let all = component.instance.select_at(&addresses)?;
    let there: Vec<bool> = component.instance.values(&all)?;
    let decided = (0..all.len()).any(|i| system.feeds(place, &name(i)));
    Ok(if decided || there.contains(&false) { all } else { Selection::default() })
}

/// Whether all these agents have the outputs of [`columns::OF_STEP`].
fn has_steps(description: &Interface, agents: usize) -> bool {
    let names = |i: usize| columns::OF_STEP.iter().map(move |row| format!("agent[{i}].{}", row.variable));
    let has = |name: String| {
        let found = description.single(&name);
        found.is_some_and(|single| matches!(single.variable.of, Type::Real(_)))
    };
    (0..agents).flat_map(names).all(has)
}

/// The columns of the table.
fn columns_of(description: &Interface, groups: Groups) -> Vec<Column> {
    let mut all = groups.columns();
    // What the FMU itself says comes first: it might count in other units.
    for column in all.iter_mut().filter(|column| column.kind == Kind::Real) {
        if let Some(name) = column.variable.strip_prefix("agent[i].") {
            let own = description.single(&format!("agent[0].{name}"));
            let said = own.and_then(|own| own.variable.of.unit()).map(str::to_owned);
            column.unit = said.or(column.unit.take());
        }
    }
    all
}

/// What the outputs of all agents say at a time \[s\].
fn frame(
    time: f64,
    motions: &[[f64; 6]],
    contacts: &[[i32; 3]],
    squeezes: &[f64],
    steps: &[[f64; 3]],
    totals: &[i32],
) -> Result<Frame> {
    let agents = motions.iter().map(|&[x, y, vx, vy, orientation, angular_velocity]| Motion {
        pose: Pose { position: vec2(x, y), orientation },
        twist: Twist { velocity: vec2(vx, vy), angular_velocity },
    });
    let counted = |count: i32| u32::try_from(count).context("the FMU counts less than no contacts");
    let observed = contacts.iter().zip(squeezes).enumerate().map(|(i, (counts, &normal_force))| {
        let [agent_contacts, wall_contacts, contacting_agents] = counts.map(counted);
        Ok(Observed {
            agent_contacts: agent_contacts?,
            wall_contacts: wall_contacts?,
            contacting_agents: contacting_agents?,
            normal_force,
            of_step: steps.get(i).map(|&[mean_normal_force, peak_normal_force, peak_overlap]| OfStep {
                mean_normal_force,
                peak_normal_force,
                peak_overlap,
            }),
        })
    });
    let totals = match totals {
        &[agents, walls] => Some(Totals { agent_contacts: counted(agents)?, wall_contacts: counted(walls)? }),
        _ => None,
    };
    Ok(Frame {
        time,
        agents: agents.collect(),
        observed: Some(observed.collect::<Result<_>>()?),
        totals,
        place: format!("t = {time:?} s"),
        ..Frame::default()
    })
}
