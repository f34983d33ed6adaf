//! A model that is loaded: the documents of a Trial, and what a sweep sets and reads of them.

use crate::error::{Error, Place, Result};
use crate::identity::of_documents;
use crate::measure::Measure;
use crate::models::{Model, Plan};
use crate::output::{Of, Reading};
use crate::points::Points;
use crate::spec::{End, Spec};
use lemons_core::trial::Trial;
use lemons_master::documents_of;
use lemons_sim::{Clock, Documents, Simulation};
use serde_json::{Map, Value};
use std::collections::HashSet;

/// A Trial, ready for any number of points in any number of threads.
pub struct LoadedModel {
    pub documents: Documents,
    pub clock: Clock,
    /// What each measure reads.
    pub measures: Vec<Reads>,
    /// What the condition that ends a point reads.
    pub stop: Option<Reading>,
    /// A point ends when so many have left.
    pub leave: Option<usize>,
    /// What must be equal to continue a sweep.
    pub identity: Map<String, Value>,
    /// What is probably not meant.
    pub warnings: Vec<String>,
}

/// What a measure reads.
pub enum Reads {
    /// Variables.
    Output(Reading),
    /// Whole frames, in which these agents count; of lines and areas all do.
    Agents(Vec<usize>),
}

impl LoadedModel {
    /// Loads it, and checks that it has all variables that are set and read.
    pub fn open(spec: &Spec, (path, plan): &Model) -> Result<LoadedModel> {
        let (documents, problems, walks) = documents_of(path, &spec.drive, plan)?;
        let mut warnings: Vec<String> = problems.iter().map(ToString::to_string).collect();
        match walks {
            None if spec.plan == Plan::Needed => {
                return Err(Error::Spec(format!("plan = true: {} has no decision.toml", path.display())));
            }
            Some(plan) if documents.drive.end().is_some() => {
                warnings.push(lemons_master::notes::drive_of_walkers(&plan));
            }
            _ => {}
        }
        let trial = &documents.trial;
        let step = spec.step.unwrap_or(trial.parameters.time_step);
        let clock = Clock::new(0.0, step, spec.until.latest()).map_err(lemons_master::Error::from);
        let clock = clock.place(|| "until".into())?;
        let simulation = Simulation::new(documents.clone(), spec.algorithm)?;
        check_parameters(&spec.points, |place| spec.only_chooses(place), &simulation)?;
        let reading = |of: &Of, agents: &[String]| -> Result<Reading> {
            let places = if of.is_of_agents() { places(trial, agents)? } else { Vec::new() };
            of.reading(&simulation, &places).map_err(Error::Spec)
        };
        let measures = spec.measures.iter().map(|(name, measure)| {
            let named = || format!("measures: {name}");
            let ready = match measure {
                Measure::Output(of) => {
                    let found = reading(&of.of, &of.agents).place(named)?;
                    of.check(found.values()).map(|()| Reads::Output(found))
                }
                Measure::Squeeze(of) => {
                    let found = places(trial, &of.agents).place(named)?;
                    of.check(found.len()).map(|()| Reads::Agents(found))
                }
                Measure::Line(_) | Measure::Area(_) => Ok(Reads::Agents(Vec::new())),
            };
            ready.map_err(|what| Error::Spec(format!("{}: {what}", named())))
        });
        let measures = measures.collect::<Result<_>>()?;
        let stop = spec.stop.as_ref().map(|stop| reading(&stop.of, &stop.agents).place(|| "stop".into()));
        let stop = stop.transpose()?;
        let leave = if spec.until == End::Left { Some(who_leaves(&documents)?) } else { None };
        let identity = of_documents(&documents, spec.algorithm, clock.step)?;
        Ok(LoadedModel { documents, clock, measures, stop, leave, identity, warnings })
    }
}

/// How many people have an exit.
fn who_leaves(documents: &Documents) -> Result<usize> {
    let nobody =
        "until = \"left\": nobody can leave: people do not walk, or have no exits (give a time in seconds)";
    let plan = documents.plan.as_ref();
    plan.map(|plan| plan.leaving().into_iter().filter(|leaves| *leaves).count())
        .filter(|leave| *leave > 0)
        .ok_or_else(|| Error::Spec(nobody.into()))
}

/// Checks that parameters set something, each something else; but those that only choose what is simulated.
///
/// # Errors
/// A sentence with the parameter.
pub fn check_parameters(
    points: &Points,
    only_chooses: impl Fn(usize) -> bool,
    simulation: &Simulation,
) -> Result<()> {
    let mut all: HashSet<Vec<String>> = HashSet::new();
    for (place, parameter) in points.parameters.iter().enumerate() {
        let wrong = |why: String| Error::Spec(format!("parameters: {}: {why}", parameter.name));
        if only_chooses(place) {
            continue;
        }
        let names = simulation.resolve(&parameter.name).map_err(|meant| {
            let better = meant.map_or("see lemons info".into(), |meant| format!("did you mean {meant:?}?"));
            wrong(format!("there is no such variable; {better}"))
        })?;
        if names.iter().any(|name| name == "crowd.Trial") {
            // Drive, TimeStep and agents would be those of another Trial.
            return Err(wrong(
                "Trials are chosen by their paths: trial = \"{NAME}\", where NAME is a parameter".into(),
            ));
        }
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
            if !(of_one.is_empty() || all.insert(of_one)) {
                return Err(wrong("another parameter sets the same".into()));
            }
        }
    }
    Ok(())
}

/// The places of agents by their Ids; without Ids, all of them.
fn places(trial: &Trial, agents: &[String]) -> Result<Vec<usize>> {
    let known = &trial.agents;
    if agents.is_empty() {
        return Ok((0..known.len()).collect());
    }
    let place = |id: &String| {
        let found = known.iter().position(|agent| agent.id == *id);
        found.ok_or_else(|| Error::Spec(format!("there is no agent {id:?}")))
    };
    let places: Vec<usize> = agents.iter().map(place).collect::<Result<_>>()?;
    let mut seen = HashSet::new();
    match places.iter().find(|place| !seen.insert(**place)) {
        Some(twice) => Err(Error::Spec(format!("agents: {:?} is named twice", known[*twice].id))),
        None => Ok(places),
    }
}
