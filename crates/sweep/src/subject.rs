//! What a point simulates: loaded FMUs, and what a sweep sets and reads of them.

use crate::error::{Error, Place, Result};
use crate::models::{Plan, Simulated};
use crate::output::{Names, Of};
use crate::points::Values;
use crate::spec::Spec;
use lemons_master::{Clock, Model};
use lemons_ssp::Type;
use lemons_trial::{DriveTable, Trial};

/// A Trial or an FMU, ready for any number of points in any number of threads.
pub struct Subject {
    pub model: Model,
    /// Of the crowd.
    pub trial: Trial,
    pub drive: DriveTable,
    pub clock: Clock,
    /// For each parameter what it sets; `None` if it only chooses what is simulated.
    pub parameters: Vec<Option<Lead>>,
    /// What each measure reads.
    pub measures: Vec<Names>,
    /// What the condition that ends a point reads.
    pub stop: Option<Names>,
}

/// Variables that a parameter sets, and the place of their component.
pub type Lead = (usize, Vec<String>);

impl Subject {
    /// Loads it, and checks that it has all variables that are set and read.
    pub fn open(spec: &Spec, (path, plan): &Simulated) -> Result<Subject> {
        let model = Model::of(path, plan, None)?;
        if spec.plan == Plan::Needed && model.plan().is_none() {
            let why = format!("plan = true: {} has no decision.toml", path.display());
            return Err(Error::Spec(why));
        }
        let trial = model.crowd().trial(None)?;
        let drive = model.drive(Some(&trial), &spec.drive)?;
        let step = spec.step.or(model.step()?).unwrap_or(trial.parameters.time_step);
        let clock = Clock::new(0.0, step, spec.until).map_err(lemons_master::Error::from);
        let clock = clock.place(|| "until".into())?;
        let parameters = leads(spec, &model)?;
        let names = |of: &Of, agents: &[String]| -> Result<Names> {
            let places = if of.is_of_agents() { places(&trial, agents)? } else { Vec::new() };
            of.names(&model, &places).map_err(Error::Spec)
        };
        let measures = spec.measures.iter().map(|(name, measure)| {
            let found = names(&measure.of, &measure.agents).place(|| format!("measures: {name}"))?;
            let checked = measure.check(found.values());
            checked.map_err(|what| Error::Spec(format!("measures: {name}: {what}")))?;
            Ok(found)
        });
        let measures = measures.collect::<Result<_>>()?;
        let stop = spec.stop.as_ref().map(|stop| names(&stop.of, &stop.agents).place(|| "stop".into()));
        let stop = stop.transpose()?;
        Ok(Subject { model, trial, drive, clock, parameters, measures, stop })
    }
}

/// What the parameters mean.
fn leads(spec: &Spec, model: &Model) -> Result<Vec<Option<Lead>>> {
    let mut all: Vec<Option<Lead>> = Vec::new();
    for (column, (parameter, values)) in spec.points.columns.iter().enumerate() {
        let wrong = |why: String| Error::Spec(format!("parameters: {parameter}: {why}"));
        if spec.only_chooses(column) {
            all.push(None);
            continue;
        }
        let (place, variable) = model.find(parameter);
        let fmu = &model.parts()[place].fmu;
        if variable == "Trial" {
            // Drive, TimeStep and agents would be those of another Trial.
            return Err(wrong(
                "Trials are chosen by their paths: trial = \"{NAME}\", where NAME is a parameter".into(),
            ));
        }
        let names = fmu.named(variable);
        for name in &names {
            let Some(kind) = fmu.kind(name) else {
                let better = match model.meant(parameter) {
                    Some(meant) => format!("did you mean {meant:?}?"),
                    None => "see lemons info".into(),
                };
                return Err(wrong(format!("the FMU has no variable {name:?}; {better}")));
            };
            // A text that is a number is used as a number.
            if let (Type::Real(_), Values::Texts(texts)) = (kind, values) {
                let endless = |text: &&String| text.parse().is_ok_and(|value: f64| !value.is_finite());
                if let Some(text) = texts.iter().find(endless) {
                    return Err(wrong(format!("{text}: must be a finite number")));
                }
            }
        }
        if all.iter().flatten().any(|(other, known)| *other == place && *known == names) {
            return Err(wrong("another parameter sets the same".into()));
        }
        all.push(Some((place, names)));
    }
    Ok(all)
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
    agents.iter().map(place).collect()
}
