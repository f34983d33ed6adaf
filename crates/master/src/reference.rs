//! Reference results in an FMU: an experiment, its inputs, and the outputs that the FMU itself has given. They are there by the
//! layered standard FMI-LS-REF, and anybody can run it again and compare.

mod layered;
mod table;

use crate::error::{ErrorPlace, Result, require};
use crate::fmu::{Fmu, agents_of_drive};
use crate::instance::ValueSelection;
use crate::ssp::{Causality, FmuVariable, Interface, entry};
use crowd_mechanics::engine::Wrench;
use crowd_mechanics::model_description::DEFAULT_STOP_TIME;
use layered::Described;
use lemons_core::plane::Motion;
use lemons_sim::{Algorithm, Clock, Documents, Simulation};
use std::collections::HashMap;
use std::fs::File;
use std::io::Write as _;
use std::path::Path;
use table::{MOST_VALUES, Table, is_number};
use zip::{CompressionMethod, ZipWriter};

/// Experiment with an FMU, for its reference.
#[derive(Debug, Clone, Default)]
pub struct Experiment {
    /// \[s\] The end. Default: that of the FMU's DefaultExperiment.
    pub until: Option<f64>,
    /// \[s\] The communication step. Default: that of the FMU's DefaultExperiment.
    pub step: Option<f64>,
    /// The tolerance that the FMU gets: see [`RunSettings::tolerance`](crate::RunSettings::tolerance).
    pub tolerance: Option<f64>,
}

/// An experiment that was run again.
#[derive(Debug, Clone, PartialEq)]
pub struct ReplayedExperiment {
    /// The name of the experiment.
    pub name: String,
    /// Its communication points.
    pub clock: Clock,
    /// How many rows were compared.
    pub rows: usize,
    /// How many values each of them has.
    pub width: usize,
    /// How many values differ.
    pub different: usize,
    /// The first of them.
    pub first: Option<Difference>,
    /// The largest difference of all values, also within the tolerance.
    pub largest: Option<Difference>,
    /// Of the FMU.
    pub warnings: Vec<String>,
}

/// A value that is not that of the reference.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// \[s\]
    pub time: f64,
    /// The name of the value.
    pub name: String,
    /// Of this run.
    pub value: f64,
    /// Of the reference.
    pub reference: f64,
}

/// Runs an FMU that was packed from these documents, or from their plan, and adds the experiment to the file. Its inputs are
/// those of a run of the documents: the Trial's drive, and where people walk, what drives them or what they see. Messages
/// call the FMU `shown`.
///
/// # Errors
/// The FMU has no library for this machine or fails, there are too many values, or the file cannot be written.
pub fn add_reference(
    packed: &Path,
    shown: &Path,
    documents: Documents,
    experiment: &Experiment,
) -> Result<()> {
    let fmu = Fmu::open(packed)?.shown_as(&shown.display().to_string());
    let of = &fmu.description;
    let step = experiment.step.or(of.step).ok_or("the FMU has no DefaultExperiment with a stepSize")?;
    let until = experiment.until.or(of.stop).unwrap_or(DEFAULT_STOP_TIME);
    let clock = Clock::new(of.start.unwrap_or(0.0), step, until)?;
    let outputs = of.variables.iter().filter(|it| it.kind == Some(Causality::Output) && is_number(it));
    let mut results = Table::of(outputs);
    let inputs_of = of.variables.iter().filter(|it| it.kind == Some(Causality::Input) && is_number(it));
    // A row has a time, too.
    let widest = results.width().max(Table::of(inputs_of).width()) as u64 + 1;
    let values = (clock.steps + 2).saturating_mul(widest);
    require(results.width() > 0, || "the FMU has no output that is a number: nothing to compare".to_owned())?;
    require(values <= MOST_VALUES, || {
        format!("a reference of {values} values: at most {MOST_VALUES} are packed (--until, --step)")
    })?;
    let name = documents.trial.name.clone();
    let stimuli = inputs(of, clock, &stimuli(documents, clock, experiment.tolerance)?);
    let singles = results.singles(of);
    run(&fmu, clock, experiment.tolerance, &stimuli, &ValueSelection::new(singles), |time, values| {
        require(values.iter().all(|value| value.is_finite()), || {
            format!("an output is not finite at t = {time:?} s: a reference cannot hold it")
        })?;
        results.push(time, values);
        Ok(())
    })?;
    let with = !stimuli.is_empty();
    let cannot = || format!("cannot write {}", shown.display());
    let file = File::options().read(true).write(true).open(packed).place(cannot)?;
    let mut zip = ZipWriter::new_append(file).place(cannot)?;
    for (name, text) in [
        (layered::MANIFEST, layered::manifest(with)),
        (layered::EXPERIMENTS, layered::experiments(&name, clock, experiment, with)),
        (layered::STIMULI, stimuli.csv()),
        (layered::RESULTS, results.csv()),
    ] {
        if with || name != layered::STIMULI {
            let place = format!("{}/{name}", layered::DIRECTORY);
            zip.start_file(place, entry(CompressionMethod::Deflated)).place(cannot)?;
            zip.write_all(text.as_bytes()).place(cannot)?;
        }
    }
    zip.finish().place(cannot)?;
    Ok(())
}

/// Runs the experiments of an FMU again. Values are the same if they have the same bits, or with a tolerance, if they differ by
/// no more than that times the larger of 1 and the reference.
///
/// # Errors
/// The FMU has no reference, something in it is wrong, or the FMU fails.
pub fn replay(path: &Path, tolerance: Option<f64>) -> Result<Vec<ReplayedExperiment>> {
    let fmu = Fmu::open(path)?;
    layered::read(&fmu)?.iter().map(|described| replay_one(&fmu, described, tolerance)).collect()
}

fn replay_one(fmu: &Fmu, described: &Described, tolerance: Option<f64>) -> Result<ReplayedExperiment> {
    let Described { name, clock, stimuli, references, .. } = described;
    let of = &fmu.description;
    let read = |file: &layered::Inside, kind| Table::read(&file.path, &file.shown, of, kind);
    let stimuli = stimuli.as_ref().map(|file| read(file, Causality::Input)).transpose()?.unwrap_or_default();
    let reference = read(references, Causality::Output)?;
    let (width, singles) = (reference.width(), reference.singles(of));
    require(width > 0, || format!("{}: has no column but \"time\"", references.shown.display()))?;
    let mut replay = ReplayedExperiment {
        name: name.clone(),
        clock: *clock,
        rows: 0,
        width,
        different: 0,
        first: None,
        largest: None,
        warnings: Vec::new(),
    };
    let other = |row: usize, what: &str| {
        let time = reference.times.get(row).map_or("nothing".to_owned(), |time| format!("time {time:?}"));
        format!("{}: {time} where {what}", references.shown.display())
    };
    // Times may be rounded to 15 digits.
    let (mut row, near) = (0, (1e-9 * clock.step).max(1e-14 * clock.until.abs()));
    let mut most = 0.0;
    replay.warnings = run(
        fmu,
        *clock,
        described.tolerance,
        &stimuli,
        &ValueSelection::new(singles.clone()),
        |time, values| {
            let next = reference.times.get(row).copied().unwrap_or(f64::INFINITY);
            if next > time + near && time != clock.start && time != clock.until {
                return Ok(());
            }
            require((next - time).abs() <= near, || other(row, &format!("the experiment is at {time:?}")))?;
            for ((value, reference), single) in values.iter().zip(reference.row(row)).zip(&singles) {
                if value.to_bits() == reference.to_bits() {
                    continue;
                }
                let by = Some((value - reference).abs()).filter(|by| !by.is_nan()).unwrap_or(f64::INFINITY);
                let found = || {
                    let name = of.name_of(single.variable, single.element);
                    Some(Difference { time, name, value: *value, reference: *reference })
                };
                if by > most || replay.largest.is_none() {
                    (most, replay.largest) = (by, found());
                }
                if tolerance
                    .is_none_or(|tolerance| by == f64::INFINITY || by > tolerance * reference.abs().max(1.0))
                {
                    replay.different += 1;
                    replay.first = replay.first.take().or_else(found);
                }
            }
            row += 1;
            Ok(())
        },
    )?;
    require(row == reference.times.len(), || other(row, "the experiment has ended"))?;
    Ok(ReplayedExperiment { rows: row, ..replay })
}

/// Runs an FMU: `each` gets the selected values at each communication point. Inputs are set in initialization, and before each
/// step. Returns the FMU's warnings.
fn run(
    fmu: &Fmu,
    clock: Clock,
    tolerance: Option<f64>,
    stimuli: &Table,
    outputs: &ValueSelection,
    mut each: impl FnMut(f64, &[f64]) -> Result<()>,
) -> Result<Vec<String>> {
    let instance = fmu.instantiate("reference")?;
    let inputs = ValueSelection::new(stimuli.singles(&fmu.description));
    let feed = |time: f64| instance.set(&inputs, &stimuli.at(time));
    instance.enter_initialization(clock.start, tolerance)?;
    feed(clock.start)?;
    instance.exit_initialization()?;
    each(clock.start, &instance.values(outputs)?)?;
    let mut time = clock.start;
    for next in clock.points(0) {
        feed(time)?;
        instance.step(time, next - time)?;
        time = next;
        each(time, &instance.values(outputs)?)?;
    }
    instance.terminate()?;
    Ok(instance.warnings())
}

/// Values at the communication points, by the names of FMI 2.0.
type Stimuli = HashMap<String, Vec<f64>>;

/// Returns what drives the crowd in a run of the documents, and what Decision sees in it.
fn stimuli(documents: Documents, clock: Clock, tolerance: Option<f64>) -> Result<Stimuli> {
    let mut stimuli = Stimuli::new();
    if documents.plan.is_none() {
        let times: Vec<f64> = std::iter::once(clock.start).chain(clock.points(0)).collect();
        for (agent, names) in agents_of_drive(&documents.trial.agents, &documents.drive) {
            let at = |time: &f64| documents.drive.at(&agent.id, *time).unwrap_or_default();
            let pushes: Vec<[f64; 3]> = times.iter().map(at).collect();
            stimuli.extend(
                names
                    .into_iter()
                    .enumerate()
                    .map(|(k, name)| (name, pushes.iter().map(|push| push[k]).collect())),
            );
        }
        return Ok(stimuli);
    }
    let refused = || "the run that gives the inputs of the reference".to_owned();
    let mut simulation = Simulation::new(documents, Algorithm::default()).place(refused)?;
    simulation.begin(clock.start, tolerance).place(refused)?;
    let mut add = |values: Vec<(String, f64)>| {
        values.into_iter().for_each(|(name, value)| stimuli.entry(name).or_default().push(value));
    };
    add(seen(&simulation));
    for time in clock.points(0) {
        simulation.step_to(time).place(refused)?;
        add(seen(&simulation));
        add(drives(&simulation));
    }
    add(drives(&simulation));
    Ok(stimuli)
}

/// Returns what Decision sees.
fn seen(simulation: &Simulation) -> Vec<(String, f64)> {
    let motions = simulation.frame().agents.into_iter().enumerate();
    let of = |(i, Motion { pose, twist }): (usize, Motion)| {
        let [[x, y], [vx, vy]] = [pose.position, twist.velocity].map(Into::into);
        let theta = ("Theta", pose.orientation);
        [("Position.x", x), ("Position.y", y), theta, ("Velocity.x", vx), ("Velocity.y", vy)]
            .map(|(name, value)| (format!("agent[{i}].{name}"), value))
    };
    motions.flat_map(of).collect()
}

/// Returns what has driven the crowd since the last communication point, and who was there.
fn drives(simulation: &Simulation) -> Vec<(String, f64)> {
    let world = simulation.world().into_iter();
    let agents = world.flat_map(|world| world.drive.iter().zip(world.present())).enumerate();
    let of = |(i, (drive, present)): (usize, (&Wrench, &bool))| {
        let active = ("Active", f64::from(u8::from(*present)));
        [("Fp.x", drive.force.x), ("Fp.y", drive.force.y), ("Mp", drive.torque), active]
            .map(|(name, value)| (format!("agent[{i}].{name}"), value))
    };
    agents.flat_map(of).collect()
}

/// Returns the table of those inputs of an FMU that do not keep their start values.
fn inputs(interface: &Interface, clock: Clock, stimuli: &Stimuli) -> Table {
    let start = |variable: &FmuVariable, element| match variable.start_of(element) {
        Some("true") => 1.0,
        Some(text) => text.parse().unwrap_or_default(),
        None => 0.0,
    };
    let own = |variable: &FmuVariable, element| stimuli.get(&interface.name_of(variable, element));
    let changes = |variable: &&FmuVariable| {
        let changes = |element| {
            let start = start(variable, element);
            own(variable, element).is_some_and(|values| values.iter().any(|value| *value != start))
        };
        variable.kind == Some(Causality::Input) && is_number(variable) && (0..variable.count()).any(changes)
    };
    let changing: Vec<&FmuVariable> = interface.variables.iter().filter(changes).collect();
    let mut table = Table::of(changing.iter().copied());
    for (k, time) in std::iter::once(clock.start).chain(clock.points(0)).enumerate() {
        let values = changing.iter().flat_map(|variable| {
            (0..variable.count()).map(move |element| {
                own(variable, element)
                    .and_then(|values| values.get(k).copied())
                    .unwrap_or_else(|| start(variable, element))
            })
        });
        table.push(time, &values.collect::<Vec<f64>>());
    }
    table
}
