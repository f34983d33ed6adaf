//! Simulates one point.

use crate::accumulators::Accumulators;
use crate::error::{Error, Place, Result};
use crate::identity;
use crate::loaded::LoadedModel;
use crate::models::Models;
use crate::spec::Spec;
use lemons_results::measure::{Leaving, Over};
use lemons_sim::Simulation;
use lemons_sim::stop::places;
use serde_json::{Map, Value};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

/// Data shared by all points.
pub struct Job {
    pub spec: Spec,
    models: Models,
    /// By which the models are known again.
    digests: Vec<String>,
}

impl Job {
    /// Loads and checks all models, one after the other. Returns what must be equal to continue, and what is probably not
    /// meant.
    ///
    /// # Errors
    /// A model cannot be used.
    pub fn open(spec: Spec) -> Result<(Job, Map<String, Value>, Vec<String>)> {
        let models = spec.models()?;
        let (mut digests, mut warnings) = (Vec::new(), Vec::new());
        let mut identity = identity::of_spec(&spec);
        for model in &models.all {
            let path = model.0.display();
            // With several, a sentence about a parameter does not say of which one.
            let loaded = match LoadedModel::open(&spec, model) {
                Err(error @ Error::Spec(_)) if models.all.len() > 1 => {
                    Err(error).place(|| path.to_string())?
                }
                loaded => loaded?,
            };
            warnings.extend(loaded.warnings.iter().map(|warning| format!("{path}: {warning}")));
            digests.push(identity::digest(&loaded.identity)?);
            if models.all.len() == 1 {
                identity.extend(loaded.identity);
            }
        }
        if models.all.len() > 1 {
            identity.extend(identity::of_models(&spec.points, &digests, &models));
        }
        Ok((Job { spec, models, digests }, identity, warnings))
    }

    /// Loads one of the models again.
    fn load(&self, place: usize) -> Result<LoadedModel> {
        let model = LoadedModel::open(&self.spec, &self.models.all[place])?;
        if identity::digest(&model.identity)? != self.digests[place] {
            let path = self.models.all[place].0.display();
            return Err(Error::Spec(format!("{path}: it was changed while the sweep was running")));
        }
        Ok(model)
    }
}

/// Simulates points one after the other.
pub struct Worker<'a> {
    job: &'a Job,
    /// That of the last point, with its place.
    model: Option<(usize, LoadedModel)>,
    /// That of the last point, unless it failed.
    simulation: Option<Simulation>,
}

impl<'a> Worker<'a> {
    pub fn new(job: &'a Job) -> Worker<'a> {
        Worker { job, model: None, simulation: None }
    }

    /// Simulates a point and returns its measures, and when it ended by itself \[s\] if it may; `None` if `stop` was set
    /// meanwhile.
    ///
    /// # Errors
    /// The point cannot be simulated.
    pub fn simulate(&mut self, point: usize, stop: &AtomicBool) -> Result<Option<Vec<Option<f64>>>> {
        let (job, place) = (self.job, self.job.models.place(point));
        // Nothing of another model stays in memory beside this one.
        if self.model.take_if(|(last, _)| *last != place).is_some() {
            self.simulation = None;
        }
        let (_, model) = match &mut self.model {
            Some(model) => model,
            none => none.insert((place, job.load(place)?)),
        };
        let mut simulation = match self.simulation.take() {
            Some(simulation) => simulation,
            None => Simulation::new(model.documents.clone(), job.spec.algorithm)?,
        };
        let values = simulate(&mut simulation, &job.spec, model, point, stop)?;
        self.simulation = Some(simulation);
        Ok(values)
    }
}

fn simulate(
    simulation: &mut Simulation,
    spec: &Spec,
    model: &LoadedModel,
    point: usize,
    stop: &AtomicBool,
) -> Result<Option<Vec<Option<f64>>>> {
    simulation.reset()?;
    for (place, parameter) in spec.points.parameters.iter().enumerate() {
        if !spec.only_chooses(place) {
            simulation.set(&parameter.name, parameter.at(point))?;
        }
    }
    simulation.begin(0.0, None)?;
    let mut accumulators = Accumulators::begin(spec, model, point)?;
    let mut leaving = model.leave.map(Leaving::of);
    // [s] When the condition held, or all had left.
    let mut ended = None;
    let mut observe = |simulation: &mut Simulation| -> Result<ControlFlow<()>> {
        if stop.load(Ordering::Relaxed) {
            return Ok(ControlFlow::Break(()));
        }
        let frame = simulation.frame();
        let holds = match spec.stop.as_ref().zip(model.stop.as_ref()) {
            Some((condition, reading)) => condition.holds(&reading.read(simulation, &frame)?),
            None => false,
        };
        let over = leaving.as_mut().and_then(|leaving| leaving.see(frame.time, &places(&frame)));
        ended = (holds || over == Some(Over::Left)).then_some(frame.time);
        accumulators.add(simulation, frame)?;
        Ok(if holds || over.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    };
    if observe(simulation)?.is_continue() {
        let _ =
            lemons_sim::run::<_, Error>(simulation, &model.clock, 0, |simulation, _| observe(simulation))?;
    }
    if stop.load(Ordering::Relaxed) {
        return Ok(None);
    }
    let mut values = accumulators.finish(&model.documents.trial.geometry.walls).map_err(Error::Spec)?;
    values.extend(spec.may_end().then_some(ended));
    Ok(Some(values))
}
