//! One run with the parameters of a point.

use crate::measure::{Measure, Watched};
use crate::points::Values;
use crate::spec::Spec;
use anyhow::{Context, Result, bail};
use crowd_mechanics::trial::Trial;
use fmi_rs::model_description::fmi2::VariableType;
use lemons_master::{Clock, Drive, Fmu, Instance, Pushes};

/// What all points have in common.
pub struct Job {
    pub fmu: Fmu,
    pub trial: Trial,
    pub drive: Drive,
    pub spec: Spec,
    /// \[s\]
    pub step: f64,
}

/// An instance that simulates one point after the other.
pub struct Worker<'a> {
    job: &'a Job,
    clock: Clock,
    instance: Instance,
    pushes: Pushes,
    looks: Vec<Look>,
}

/// Where a measure's values are read.
struct Look {
    reals: Vec<u32>,
    integers: Vec<u32>,
    /// Values of each agent.
    width: usize,
}

impl Job {
    fn clock(&self) -> Result<Clock> {
        Clock::new(0.0, self.step, self.spec.until)
    }

    /// That the FMU has what is set and measured.
    pub fn check(&self) -> Result<()> {
        self.clock().context("until")?;
        for (parameter, values) in &self.spec.points.columns {
            if parameter == "Trial" {
                // Its drive, its TimeStep and its agents would be those of another.
                bail!("parameters: Trial: each Trial needs a sweep of its own");
            }
            for name in self.fmu.named(parameter) {
                let Some(kind) = self.fmu.kind(&name) else {
                    bail!("parameters: {parameter}: the FMU has no variable {name:?}; see lemons info");
                };
                // A text that is a number is one.
                if let (VariableType::Real { .. }, Values::Texts(texts)) = (kind, values) {
                    let endless = |text: &&String| text.parse().is_ok_and(|value: f64| !value.is_finite());
                    if let Some(text) = texts.iter().find(endless) {
                        bail!("parameters: {parameter}: {text}: must be a finite number");
                    }
                }
            }
        }
        for (name, measure) in &self.spec.measures {
            let agents = self.places(measure).with_context(|| format!("measures: {name}"))?.len();
            measure.check(agents).map_err(|what| anyhow::anyhow!("measures: {name}: {what}"))?;
        }
        Ok(())
    }

    fn places(&self, measure: &Measure) -> Result<Vec<usize>> {
        let known = &self.trial.agents;
        if measure.agents.is_empty() {
            return Ok((0..known.len()).collect());
        }
        let place = |id: &String| {
            known
                .iter()
                .position(|agent| agent.id == *id)
                .with_context(|| format!("there is no agent {id:?}"))
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
            let references = |names: &[&str]| -> Result<Vec<u32>> {
                let names =
                    places.iter().flat_map(|i| names.iter().map(move |name| format!("agent[{i}].{name}")));
                names.map(|name| instance.reference(&name)).collect()
            };
            let width = reals.len().max(integers.len());
            Ok(Look { reals: references(reals)?, integers: references(integers)?, width })
        });
        let looks = looks.collect::<Result<Vec<_>>>()?;
        let pushes = Pushes::new(&instance, &job.trial.agents, job.drive.clone())?;
        Ok(Worker { job, clock: job.clock()?, instance, pushes, looks })
    }

    /// What is measured at a point. The worker goes on with the next one, unless this failed.
    pub fn simulate(&mut self, point: usize) -> Result<Vec<Option<f64>>> {
        let Job { fmu, spec: Spec { points, measures, .. }, .. } = self.job;
        self.instance.reset()?;
        for (parameter, values) in &points.columns {
            let text = values.text(point);
            for name in fmu.named(parameter) {
                let kind = fmu.kind(&name).with_context(|| format!("the FMU has no variable {name:?}"))?;
                self.instance.set(kind, &name, &text)?;
            }
        }
        self.instance.initialize()?;
        let mut watched: Vec<Watched> = measures.iter().map(|(_, measure)| Watched::new(measure)).collect();
        self.look(0.0, &mut watched)?;
        for k in 0..self.clock.steps {
            let (begin, end) = (self.clock.point(k), self.clock.end(k));
            self.pushes.send(&self.instance, begin)?;
            self.instance.step(begin, end - begin)?;
            self.look(end, &mut watched)?;
        }
        self.instance.terminate()?;
        Ok(watched.iter().map(Watched::value).collect())
    }

    fn look(&self, time: f64, watched: &mut [Watched]) -> Result<()> {
        for (look, watched) in self.looks.iter().zip(watched) {
            let mut reals = vec![0.0; look.reals.len()];
            let mut integers = vec![0; look.integers.len()];
            if !reals.is_empty() {
                self.instance.get_real(&look.reals, &mut reals)?;
            }
            if !integers.is_empty() {
                self.instance.get_integer(&look.integers, &mut integers)?;
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
