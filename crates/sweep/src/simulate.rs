//! Simulates one point.

use crate::error::{Error, Place, Result};
use crate::measure::{Measure, Watched};
use crate::points::Values;
use crate::spec::Spec;
use lemons_master::{Clock, Fmu, Instance, Observer, Pushes, Reached, Selection};
use lemons_ssp::Type;
use lemons_trial::DriveTable;
use lemons_trial::Trial;

/// Data shared by all points.
pub struct Job {
    pub fmu: Fmu,
    pub trial: Trial,
    pub drive: DriveTable,
    pub spec: Spec,
    /// \[s\] Communication step.
    pub step: f64,
}

/// An instance that simulates points one after the other.
pub struct Worker<'a> {
    job: &'a Job,
    clock: Clock,
    instance: Instance,
    pushes: Pushes,
    looks: Vec<Look>,
}

/// Where a measure's values are read.
struct Look {
    reals: Selection,
    integers: Selection,
    /// Number of values for each agent.
    width: usize,
}

impl Job {
    fn clock(&self) -> Result<Clock> {
        Ok(Clock::new(0.0, self.step, self.spec.until).map_err(lemons_master::Error::from)?)
    }

    /// Checks that the FMU has all variables that are set and measured.
    pub fn check(&self) -> Result<()> {
        self.clock().place(|| "until".into())?;
        for (parameter, values) in &self.spec.points.columns {
            if parameter == "Trial" {
                // Drive, TimeStep and agents would be those of another Trial.
                return Err(Error::Spec("parameters: Trial: each Trial needs a sweep of its own".into()));
            }
            for name in self.fmu.named(parameter) {
                let Some(kind) = self.fmu.kind(&name) else {
                    return Err(Error::Spec(format!(
                        "parameters: {parameter}: the FMU has no variable {name:?}; see lemons info"
                    )));
                };
                // A text that is a number is used as a number.
                if let (Type::Real(_), Values::Texts(texts)) = (kind, values) {
                    let endless = |text: &&String| text.parse().is_ok_and(|value: f64| !value.is_finite());
                    if let Some(text) = texts.iter().find(endless) {
                        return Err(Error::Spec(format!(
                            "parameters: {parameter}: {text}: must be a finite number"
                        )));
                    }
                }
            }
        }
        for (name, measure) in &self.spec.measures {
            let agents = self.places(measure).place(|| format!("measures: {name}"))?.len();
            measure.check(agents).map_err(|what| Error::Spec(format!("measures: {name}: {what}")))?;
        }
        Ok(())
    }

    fn places(&self, measure: &Measure) -> Result<Vec<usize>> {
        let known = &self.trial.agents;
        if measure.agents.is_empty() {
            return Ok((0..known.len()).collect());
        }
        let place = |id: &String| {
            let found = known.iter().position(|agent| agent.id == *id);
            found.ok_or_else(|| Error::Spec(format!("there is no agent {id:?}")))
        };
        measure.agents.iter().map(place).collect()
    }
}

impl<'a> Worker<'a> {
    pub fn new(job: &'a Job) -> Result<Worker<'a>> {
        let instance = job.fmu.instantiate("sweep")?;
        let looks = job.spec.measures.iter().map(|(_, measure)| {
            let (reals, integers) = measure.of.outputs();
            let places = job.places(measure)?;
            let select = |names: &[&str]| -> Result<Selection> {
                let names =
                    places.iter().flat_map(|i| names.iter().map(move |name| format!("agent[{i}].{name}")));
                Ok(instance.select(names)?)
            };
            let width = reals.len().max(integers.len());
            Ok(Look { reals: select(reals)?, integers: select(integers)?, width })
        });
        let looks = looks.collect::<Result<Vec<_>>>()?;
        let pushes = Pushes::new(&instance, &job.trial.agents, job.drive.clone())?;
        Ok(Worker { job, clock: job.clock()?, instance, pushes, looks })
    }

    /// Simulates a point and returns its measures. The worker can be used again unless this failed.
    pub fn simulate(&mut self, point: usize) -> Result<Vec<Option<f64>>> {
        let Job { fmu, spec: Spec { points, measures, .. }, .. } = self.job;
        self.instance.reset()?;
        for (parameter, values) in &points.columns {
            let text = values.text(point);
            self.instance.set(&fmu.named(parameter), &text)?;
        }
        self.instance.initialize()?;
        let watched: Vec<Watched> = measures.iter().map(|(_, measure)| Watched::new(measure)).collect();
        let mut measured = Measured { looks: &self.looks, watched };
        measured.see(&self.instance, 0.0)?;
        // Only an error ends it early.
        let _ = lemons_master::simulate(&mut self.instance, &self.clock, 0, &self.pushes, &mut measured)?;
        self.instance.terminate()?;
        Ok(measured.watched.iter().map(Watched::value).collect())
    }
}

/// The measures of a run under way.
struct Measured<'a> {
    looks: &'a [Look],
    watched: Vec<Watched<'a>>,
}

impl Observer<Instance> for Measured<'_> {
    type Error = lemons_master::Error;

    fn look(&mut self, instance: &mut Instance, reached: Reached) -> lemons_master::Result<()> {
        self.see(instance, reached.time)
    }
}

impl Measured<'_> {
    fn see(&mut self, instance: &Instance, time: f64) -> lemons_master::Result<()> {
        for (look, watched) in self.looks.iter().zip(&mut self.watched) {
            let mut reals = vec![0.0; look.reals.len()];
            let mut integers = vec![0; look.integers.len()];
            if !reals.is_empty() {
                instance.get_real(&look.reals, &mut reals)?;
            }
            if !integers.is_empty() {
                instance.get_integer(&look.integers, &mut integers)?;
                reals.extend(integers.into_iter().map(f64::from));
            }
            let values = reals.chunks_exact(look.width).map(|of| match of {
                [value] => *value,
                parts => parts.iter().map(|part| part * part).sum::<f64>().sqrt(),
            });
            watched.look(time, values);
        }
        Ok(())
    }
}
