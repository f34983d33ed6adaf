//! Simulates one point.

use crate::accumulators::Accumulators;
use crate::error::{Error, Place, Result};
use crate::identity;
use crate::loaded::{LoadedModel, reading_of_stop};
use crate::spec::Spec;
use lemons_results::measure::{Leaving, Over};
use lemons_sim::Simulation;
use lemons_sim::stop::places;
use serde_json::{Map, Value};
use std::sync::atomic::{AtomicBool, Ordering};

/// Data shared by all points.
pub struct Job {
    pub spec: Spec,
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
        let models = &spec.models;
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
            identity.extend(identity::of_models(&spec.points, &digests, models));
        }
        Ok((Job { spec, digests }, identity, warnings))
    }

    /// Loads one of the models again.
    fn load(&self, place: usize) -> Result<LoadedModel> {
        let model = LoadedModel::open(&self.spec, &self.spec.models.all[place])?;
        if identity::digest(&model.identity)? != self.digests[place] {
            let path = self.spec.models.all[place].0.display();
            return Err(Error::Spec(format!("{path}: it was changed while the sweep was running")));
        }
        Ok(model)
    }
}

/// Simulates points one after the other.
pub struct Worker<'a> {
    job: &'a Job,
    /// The model of the last point with its place, unless the point failed.
    model: Option<(usize, LoadedModel)>,
}

impl<'a> Worker<'a> {
    pub fn new(job: &'a Job) -> Worker<'a> {
        Worker { job, model: None }
    }

    /// Simulates a point and returns its measures, and when it ended by itself \[s\] if it may; `None` if `stop` was set
    /// meanwhile.
    ///
    /// # Errors
    /// The point cannot be simulated.
    pub fn simulate(&mut self, point: usize, stop: &AtomicBool) -> Result<Option<Vec<Option<f64>>>> {
        let (job, place) = (self.job, self.job.spec.models.place(point));
        // Nothing of another model stays in memory beside this one.
        let mut model = match self.model.take().filter(|(last, _)| *last == place) {
            Some((_, model)) => model,
            None => job.load(place)?,
        };
        let values = simulate(&job.spec, &mut model, point, stop)?;
        self.model = Some((place, model));
        Ok(values)
    }
}

fn simulate(
    spec: &Spec,
    LoadedModel { simulation, trial, clock, leave, .. }: &mut LoadedModel,
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
    let condition = reading_of_stop(spec, trial, simulation)?;
    let mut leaving = leave.map(Leaving::of);
    // [s] When the condition held, or all had left.
    let mut ended = None;
    let mut observe = |simulation: &mut Simulation| -> Result<bool> {
        if stop.load(Ordering::Relaxed) {
            return Ok(false);
        }
        let frame = simulation.frame();
        let holds = match &condition {
            Some((condition, reading)) => condition.holds(&reading.read(simulation, &frame)?),
            None => false,
        };
        let over = leaving.as_mut().and_then(|leaving| leaving.see(frame.time, &places(&frame)));
        ended = (holds || over == Some(Over::Left)).then_some(frame.time);
        accumulators.add(simulation, frame)?;
        Ok(!holds && over.is_none())
    };
    let mut points = clock.points(0);
    while observe(simulation)?
        && let Some(point) = points.next()
    {
        simulation.step_to(point.time)?;
    }
    if stop.load(Ordering::Relaxed) {
        return Ok(None);
    }
    let mut values = accumulators.finish(trial).map_err(Error::Spec)?;
    values.extend(spec.may_end().then_some(ended));
    Ok(Some(values))
}
