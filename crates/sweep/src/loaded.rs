//! A model that is loaded: the documents of a Trial, and what a sweep sets and reads of them.

use crate::accumulators::Accumulators;
use crate::error::{Error, Place, Result};
use crate::identity::of_documents;
use crate::models::{Model, Models};
use crate::output::{Reading, Stop};
use crate::points::Points;
use crate::spec::{End, Event, Spec};
use lemons_core::trial::Trial;
use lemons_master::{documents_of, ensure};
use lemons_sim::{Clock, Documents, Simulation};
use serde_json::{Map, Value};
use std::collections::HashSet;

/// A Trial, ready for any number of points.
pub struct LoadedModel {
    pub trial: Trial,
    pub simulation: Simulation,
    pub clock: Clock,
    /// A point ends when so many have left.
    pub leave: Option<usize>,
    /// What must be equal to continue a sweep.
    pub identity: Map<String, Value>,
    /// What is probably not meant.
    pub warnings: Vec<String>,
}

impl LoadedModel {
    /// Loads it, and checks that it has all variables that are set and read.
    pub fn open(spec: &Spec, (path, plan): &Model) -> Result<LoadedModel> {
        let (documents, problems, walks) = documents_of(path, &spec.drive, plan)?;
        let mut warnings: Vec<String> = problems.iter().map(ToString::to_string).collect();
        match walks {
            None if spec.needs_plan => {
                return Err(Error::Spec(format!("plan = true: {} has no decision.toml", path.display())));
            }
            Some(plan) if documents.drive.end().is_some() => {
                warnings.push(lemons_master::notes::drive_of_walkers(&plan));
            }
            _ => {}
        }
        let step = spec.step.unwrap_or(documents.trial.parameters.time_step);
        let clock = Clock::new(0.0, step, spec.until.latest()).map_err(lemons_master::Error::from);
        let clock = clock.place(|| "until".into())?;
        let leave = if spec.until == End::When(Event::Left) { Some(who_leaves(&documents)?) } else { None };
        let identity = of_documents(&documents, spec.algorithm, clock.step)?;
        let trial = documents.trial.clone();
        let simulation = Simulation::new(documents, spec.algorithm)?;
        check_parameters(&spec.points, &spec.models, &simulation)?;
        Accumulators::begin(spec, &trial, &simulation, 0)?;
        reading_of_stop(spec, &trial, &simulation)?;
        Ok(LoadedModel { trial, simulation, clock, leave, identity, warnings })
    }
}

/// Returns the condition that ends a point before its time, with what it reads.
///
/// # Errors
/// There is no such variable or agent.
pub fn reading_of_stop<'a>(
    spec: &'a Spec,
    trial: &Trial,
    simulation: &Simulation,
) -> Result<Option<(&'a Stop, Reading)>> {
    let Some(stop) = &spec.stop else { return Ok(None) };
    let reading = stop.of.reading(simulation, trial, &stop.agents).place(|| "stop".into())?;
    Ok(Some((stop, reading)))
}

/// Returns how many people have an exit.
fn who_leaves(documents: &Documents) -> Result<usize> {
    let leaving = documents.plan.iter().flat_map(|plan| plan.leaving());
    match leaving.filter(|leaves| *leaves).count() {
        0 => Err(Error::Spec(
            "until = \"left\": nobody can leave: people do not walk, or have no exits (give a time in seconds)".into(),
        )),
        leave => Ok(leave),
    }
}

/// Checks that parameters set something, each something else; but those that only choose what is simulated.
///
/// # Errors
/// A sentence with the parameter.
pub fn check_parameters(points: &Points, models: &Models, simulation: &Simulation) -> Result<()> {
    let mut all: HashSet<Vec<String>> = HashSet::new();
    for (place, parameter) in points.parameters.iter().enumerate() {
        let wrong = |why: String| Error::Spec(format!("parameters: {}: {why}", parameter.name));
        if models.only_chooses(place) {
            continue;
        }
        let names = simulation.resolve(&parameter.name).map_err(|meant| {
            let better = meant.map_or("see lemons info".into(), |meant| format!("did you mean {meant:?}?"));
            wrong(format!("there is no such variable; {better}"))
        })?;
        // Drive, TimeStep and agents would be those of another Trial.
        let why = "Trials are chosen by their paths: trial = \"{NAME}\", where NAME is a parameter";
        ensure(!names.iter().any(|name| name == "crowd.Trial"), || wrong(why.into()))?;
        if let Some(input) = names.iter().find(|name| simulation.is_fed(name)) {
            return Err(wrong(format!("overwritten by the connection that feeds {input}")));
        }
        // A text that is a number is used as a number.
        let endless = |text: &&String| text.parse().is_ok_and(|value: f64| !value.is_finite());
        if let Some(text) = parameter.values().iter().find(endless) {
            return Err(wrong(format!("{text}: must be a finite number")));
        }
        // Of some agents, a later parameter may replace an earlier one of all.
        let (crowd, decision): (Vec<_>, Vec<_>) =
            names.into_iter().partition(|name| name.starts_with("crowd."));
        for of_one in [crowd, decision] {
            let new = of_one.is_empty() || all.insert(of_one);
            ensure(new, || wrong("another parameter sets the same".into()))?;
        }
    }
    Ok(())
}
