//! What a point simulates: loaded FMUs, and what a sweep sets and reads of them.

use crate::error::{Error, Place, Result};
use crate::measure::Measure;
use crate::models::{Plan, Simulated};
use crate::output::{Names, Of};
use crate::points::Values;
use crate::scene::Wanted;
use crate::spec::{End, Spec};
use lemons_master::{Clock, Model, plan_in};
use lemons_ssp::Type;
use lemons_trial::{DriveTable, Trial};
use std::collections::HashSet;

/// A Trial or an FMU, ready for any number of points in any number of threads.
pub struct Subject {
    pub model: Model,
    /// Of the crowd.
    pub trial: Trial,
    pub drive: DriveTable,
    pub clock: Clock,
    /// For each parameter what it sets: nothing if it only chooses what is simulated.
    pub parameters: Vec<Vec<Lead>>,
    /// What each measure reads.
    pub measures: Vec<Reads>,
    /// What the condition that ends a point reads.
    pub stop: Option<Names>,
    /// What is read of the whole crowd.
    pub wanted: Option<Wanted>,
    /// A point ends when so many have left.
    pub leave: Option<usize>,
}

/// What a measure reads.
pub enum Reads {
    /// Variables.
    Output(Names),
    /// Of the whole crowd, of which these agents count.
    Crowd(Vec<usize>),
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
        let clock = Clock::new(0.0, step, spec.until.latest()).map_err(lemons_master::Error::from);
        let clock = clock.place(|| "until".into())?;
        let parameters = leads(spec, &model)?;
        let names = |of: &Of, agents: &[String]| -> Result<Names> {
            let places = if of.is_of_agents() { places(&trial, agents)? } else { Vec::new() };
            of.names(&model, &places).map_err(Error::Spec)
        };
        let mut wanted = Wanted::default();
        let measures = spec.measures.iter().map(|(name, measure)| {
            let named = || format!("measures: {name}");
            let ready = match measure {
                Measure::Output(of) => {
                    let found = names(&of.of, &of.agents).place(named)?;
                    of.check(found.values()).map(|()| Reads::Output(found))
                }
                Measure::Squeeze(of) => {
                    let squeezes = Wanted { squeezes: true, ..Wanted::default() };
                    squeezes.check(model.crowd(), trial.agents.len()).place(named)?;
                    wanted.squeezes = true;
                    let found = places(&trial, &of.agents).place(named)?;
                    of.check(found.len()).map(|()| Reads::Crowd(found))
                }
                Measure::Line(_) | Measure::Area(_) => {
                    wanted.motions = true;
                    Ok(Reads::Crowd(Vec::new()))
                }
            };
            ready.map_err(|what| Error::Spec(format!("{}: {what}", named())))
        });
        let measures = measures.collect::<Result<_>>()?;
        let stop = spec.stop.as_ref().map(|stop| names(&stop.of, &stop.agents).place(|| "stop".into()));
        let stop = stop.transpose()?;
        let leave = if spec.until == End::Left { Some(who_leaves(&model)?) } else { None };
        // Whether people get any further.
        wanted.motions |= leave.is_some();
        let wanted = (wanted.motions || wanted.squeezes).then_some(wanted);
        Ok(Subject { model, trial, drive, clock, parameters, measures, stop, wanted, leave })
    }
}

/// How many people have an exit.
fn who_leaves(model: &Model) -> Result<usize> {
    let known = model.parts().iter().find_map(|part| plan_in(&part.fmu));
    let nobody =
        "until = \"left\": nobody can leave: people do not walk, or have no exits (give a time in seconds)";
    known
        .map(|plan| plan.leaving().into_iter().filter(|leaves| *leaves).count())
        .filter(|leave| *leave > 0)
        .ok_or_else(|| Error::Spec(nobody.into()))
}

/// What the parameters mean.
fn leads(spec: &Spec, model: &Model) -> Result<Vec<Vec<Lead>>> {
    let mut all: Vec<Vec<Lead>> = Vec::new();
    for (column, (parameter, values)) in spec.points.columns.iter().enumerate() {
        let wrong = |why: String| Error::Spec(format!("parameters: {parameter}: {why}"));
        if spec.only_chooses(column) {
            all.push(Vec::new());
            continue;
        }
        let (places, variable) = model.set_by(parameter);
        if variable == "Trial" {
            // Drive, TimeStep and agents would be those of another Trial.
            return Err(wrong(
                "Trials are chosen by their paths: trial = \"{NAME}\", where NAME is a parameter".into(),
            ));
        }
        let named = |place: usize| (place, model.parts()[place].fmu.named(variable));
        let leads: Vec<Lead> = places.into_iter().map(named).collect();
        for (place, name) in
            leads.iter().flat_map(|(place, names)| names.iter().map(move |name| (*place, name)))
        {
            let Some(kind) = model.parts()[place].fmu.kind(name) else {
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
        if all.iter().flatten().any(|known| leads.contains(known)) {
            return Err(wrong("another parameter sets the same".into()));
        }
        all.push(leads);
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
    let places: Vec<usize> = agents.iter().map(place).collect::<Result<_>>()?;
    let mut seen = HashSet::new();
    match places.iter().find(|place| !seen.insert(**place)) {
        Some(twice) => Err(Error::Spec(format!("agents: {:?} is named twice", known[*twice].id))),
        None => Ok(places),
    }
}
