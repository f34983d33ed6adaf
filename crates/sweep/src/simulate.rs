//! Loads models, the documents of Trials with what a sweep sets and reads of them, and simulates points.

use crate::accumulators::Accumulators;
use crate::error::{ErrorPlace, Result, SweepError};
use crate::identity;
use crate::measure::MeasureKind;
use crate::models::Models;
use crate::points::Points;
use crate::spec::Spec;
use lemons_core::trial::{PanelChoice, Problems, Trial};
use lemons_master::{documents_of, require};
use lemons_results::Frame;
use lemons_results::measure::Over;
use lemons_sim::lint::{self, Files};
use lemons_sim::{Clock, PointKind, Simulation, Stepper, StopCondition};
use serde_json::{Map, Value};
use std::collections::HashSet;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

/// Data shared by all points.
pub struct SweepJob {
    pub spec: Spec,
    /// By which the models are known again.
    digests: Vec<String>,
}

impl SweepJob {
    /// Loads and checks all models, one after the other. Returns what must be equal to continue, and what is probably not
    /// meant.
    ///
    /// # Errors
    /// A model cannot be used.
    pub fn open(spec: Spec) -> Result<(SweepJob, Map<String, Value>, Vec<String>)> {
        let models = &spec.models;
        let (mut digests, mut warnings) = (Vec::new(), Vec::new());
        let mut identity = identity::of_spec(&spec);
        for (place, model) in models.all.iter().enumerate() {
            let path = model.0.display();
            // With several, a sentence about a parameter does not say of which one.
            let loaded = match LoadedModel::open(&spec, place, true) {
                Err(error @ (SweepError::Spec(_) | SweepError::In { .. })) if models.all.len() > 1 => {
                    Err(error).place(|| path.to_string())?
                }
                loaded => loaded?,
            };
            for warning in loaded.warnings {
                // Crowds are alike.
                if !warnings.contains(&warning) {
                    warnings.push(warning);
                }
            }
            digests.push(identity::digest(&loaded.identity)?);
            if models.all.len() == 1 {
                identity.extend(loaded.identity);
            }
        }
        if models.all.len() > 1 {
            identity.extend(identity::of_models(&spec.points, &digests, models));
        }
        Ok((SweepJob { spec, digests }, identity, warnings))
    }

    /// Loads one of the models again.
    fn load(&self, place: usize) -> Result<LoadedModel> {
        let model = LoadedModel::open(&self.spec, place, false)?;
        let same = identity::digest(&model.identity)? == self.digests[place];
        let path = self.spec.models.all[place].0.display();
        require(same, || format!("{path}: it was changed while the sweep was running"))?;
        Ok(model)
    }

    /// Simulates a point and returns its measures, and when it ended by itself \[s\] if it may; `None` if `stop` was set
    /// meanwhile. `last` is the model of the last point with its place, unless that point failed.
    ///
    /// # Errors
    /// The point cannot be simulated.
    pub fn simulate(
        &self,
        last: &mut Option<(usize, LoadedModel)>,
        point: usize,
        stop: &AtomicBool,
    ) -> Result<Option<Vec<Option<f64>>>> {
        let place = self.spec.models.place(point);
        // Nothing of another model stays in memory beside this one.
        let mut model = match last.take().filter(|(last, _)| *last == place) {
            Some((_, model)) => model,
            None => self.load(place)?,
        };
        let values = simulate(&self.spec, &mut model, point, stop)?;
        *last = Some((place, model));
        Ok(values)
    }
}

fn simulate(
    spec: &Spec,
    LoadedModel { simulation, trial, clock, end, .. }: &mut LoadedModel,
    point: usize,
    stop: &AtomicBool,
) -> Result<Option<Vec<Option<f64>>>> {
    simulation.reset()?;
    for (place, parameter) in spec.points.parameters.iter().enumerate() {
        if !spec.models.only_chooses(place) {
            simulation.set(&parameter.name, parameter.at(point))?;
        }
    }
    simulation.begin(0.0, None)?;
    let mut accumulators = Accumulators::begin(spec, trial, simulation, point)?;
    // Whether the condition of the sweep has ended the point.
    let mut held = false;
    let mut add = |_: &Stepper, simulation: &mut Simulation, frames: Vec<Frame>, _| {
        for frame in frames {
            held = accumulators.add(simulation, frame)?;
        }
        let stops = held || stop.load(Ordering::Relaxed);
        Ok::<_, SweepError>(if stops { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    };
    let mut run = Stepper::new(*clock, 1, end.clone());
    run.run(simulation, &mut add, PointKind::Start)?;
    if stop.load(Ordering::Relaxed) {
        return Ok(None);
    }
    let mut values = accumulators.finish(trial)?;
    let ended = held || run.leaving().is_some_and(|leaving| leaving.over() == Some(Over::Left));
    values.extend(spec.may_end().then_some(ended.then_some(simulation.time())));
    Ok(Some(values))
}

/// A Trial, ready for any number of points.
pub struct LoadedModel {
    trial: Trial,
    simulation: Simulation,
    clock: Clock,
    /// Condition that ends a point before its time.
    end: Option<StopCondition>,
    /// Identity: it must be equal to continue a sweep.
    identity: Map<String, Value>,
    /// Warnings of what is probably not meant.
    warnings: Vec<String>,
}

impl LoadedModel {
    /// Loads the model of a place, and checks that it has all variables that are set and read. `examines`: says what is
    /// probably not meant.
    fn open(spec: &Spec, place: usize, examines: bool) -> Result<LoadedModel> {
        let (path, decision) = &spec.models.all[place];
        let (mut documents, mut problems, walks) = match &spec.population {
            Some(population) => {
                let own = population.at(&spec.points, spec.models.first_point(place));
                let documents = own.and_then(|own| own.documents()).place(|| "population".into())?;
                (documents, Problems::default(), None)
            }
            None => documents_of(path, &spec.drive, decision)?,
        };
        if walks.is_none() && spec.needs_decision {
            return Err(SweepError::Spec(format!(
                "decision = true: {} has no decision.toml",
                path.display()
            )));
        }
        let step = spec.step.unwrap_or(documents.trial.parameters.time_step);
        let clock = Clock::new(0.0, step, spec.until.latest()).map_err(lemons_master::MasterError::from);
        let clock = clock.place(|| "until".into())?;
        if examines {
            let files = match spec.population {
                Some(_) => Files { decision: PathBuf::new(), drive: PathBuf::new() },
                None => Files::chosen(path, &spec.drive, walks.as_deref()),
            };
            problems.extend(lint::of_documents(&documents, &files));
            problems.extend(lint::of_step(&documents, clock.step, &files));
        }
        let end = spec.until.condition(documents.drive.end(), || documents.leaving());
        let end = end.map_err(|nobody| SweepError::Spec(format!("until = \"left\": {nobody}")))?;
        let identity = identity::of_documents(&documents, spec.algorithm, clock.step)?;
        if spec.measures.iter().any(|(_, measure)| matches!(measure.kind, MeasureKind::Load(_))) {
            documents.trial.geometry.divide(PanelChoice::Missing).place(|| path.display().to_string())?;
        }
        let trial = documents.trial.clone();
        let simulation = Simulation::new(documents, spec.algorithm)?;
        check_parameters(&spec.points, &spec.models, &simulation)?;
        Accumulators::begin(spec, &trial, &simulation, 0)?;
        let warnings = problems.iter().map(ToString::to_string).collect();
        Ok(LoadedModel { trial, simulation, clock, end, identity, warnings })
    }
}

/// Checks that parameters set something, each something else; but those that only choose what is simulated.
///
/// # Errors
/// A sentence with the parameter.
pub fn check_parameters(points: &Points, models: &Models, simulation: &Simulation) -> Result<()> {
    let mut all: HashSet<Vec<String>> = HashSet::new();
    for (place, parameter) in points.parameters.iter().enumerate() {
        let wrong = |why: String| SweepError::Spec(format!("parameters: {}: {why}", parameter.name));
        if models.only_chooses(place) {
            continue;
        }
        let names = simulation.resolve(&parameter.name).map_err(|meant| {
            let better = meant.map_or("see lemons info".into(), |meant| format!("did you mean {meant:?}?"));
            wrong(format!("there is no such variable; {better}"))
        })?;
        // Drive, TimeStep and agents would be those of another Trial.
        let why = "Trials are chosen by their paths: trial = \"{NAME}\", where NAME is a parameter";
        require(!names.iter().any(|name| name == "crowd.Trial"), || wrong(why.into()))?;
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
            require(new, || wrong("another parameter sets the same".into()))?;
        }
    }
    Ok(())
}
