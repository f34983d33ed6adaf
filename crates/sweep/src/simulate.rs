//! Simulates one point.

use crate::courses::Courses;
use crate::error::{Error, Place, Result};
use crate::identity;
use crate::models::Models;
use crate::spec::Spec;
use crate::subject::{Reads, Subject};
use lemons_results::measure::{Leaving, Over};
use lemons_sim::stop::places;
use lemons_sim::{Point, Simulation};
use serde_json::{Map, Value};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError, Weak};

/// Data shared by all points.
pub struct Job {
    pub spec: Spec,
    models: Models,
    subjects: Vec<Shared>,
    /// The only one, which all points need.
    _only: Option<Arc<Subject>>,
}

/// One of the models: in memory while a worker uses it.
struct Shared {
    /// By which it is known again.
    digest: String,
    subject: Mutex<Weak<Subject>>,
}

impl Job {
    /// Loads and checks all models, one after the other; a single one stays loaded. Returns what must be equal to
    /// continue, and what is probably not meant.
    pub fn open(spec: Spec) -> Result<(Job, Map<String, Value>, Vec<String>)> {
        let models = spec.models()?;
        let (mut subjects, mut warnings) = (Vec::new(), Vec::new());
        let (mut identity, mut only) = (identity::of_spec(&spec), None);
        for simulated in &models.all {
            let subject = Subject::open(&spec, simulated);
            // With several, a sentence about a parameter does not say of which one.
            let subject = match subject {
                Err(error @ Error::Spec(_)) if models.all.len() > 1 => {
                    Err(error).place(|| simulated.0.display().to_string())?
                }
                subject => Arc::new(subject?),
            };
            let named = |warning: &String| format!("{}: {warning}", simulated.0.display());
            warnings.extend(subject.warnings.iter().map(named));
            let own = identity::of_documents(&subject.documents, spec.algorithm, subject.clock.step)?;
            let (digest, subject_of) = (identity::digest(&own)?, Mutex::new(Arc::downgrade(&subject)));
            subjects.push(Shared { digest, subject: subject_of });
            if models.all.len() == 1 {
                identity.extend(own);
                only = Some(subject);
            }
        }
        if only.is_none() {
            let all: Vec<String> = subjects.iter().map(|shared| shared.digest.clone()).collect();
            identity.extend(identity::of_models(&spec.points, &all, &models));
        }
        Ok((Job { spec, models, subjects, _only: only }, identity, warnings))
    }

    /// One of the models, loaded again if nobody uses it now.
    fn subject(&self, place: usize) -> Result<Arc<Subject>> {
        let Shared { digest, subject } = &self.subjects[place];
        let mut kept = subject.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(subject) = kept.upgrade() {
            return Ok(subject);
        }
        let simulated = &self.models.all[place];
        let subject = Arc::new(Subject::open(&self.spec, simulated)?);
        let own = identity::of_documents(&subject.documents, self.spec.algorithm, subject.clock.step)?;
        if identity::digest(&own)? != *digest {
            let path = simulated.0.display();
            return Err(Error::Spec(format!("{path}: it was changed while the sweep was running")));
        }
        *kept = Arc::downgrade(&subject);
        Ok(subject)
    }
}

/// Simulates points one after the other.
pub struct Worker<'a> {
    job: &'a Job,
    /// Of the last point: the place of its model, its subject and its simulation.
    last: Option<(usize, Arc<Subject>, Simulation)>,
}

impl<'a> Worker<'a> {
    pub fn new(job: &'a Job) -> Worker<'a> {
        Worker { job, last: None }
    }

    /// Simulates a point and returns its measures, and when it ended by itself \[s\] if it may; `None` if `stop` was set
    /// meanwhile. The worker can be used again unless this failed.
    pub fn simulate(&mut self, point: usize, stop: &AtomicBool) -> Result<Option<Vec<Option<f64>>>> {
        let (job, place) = (self.job, self.job.models.place(point));
        let (_, subject, mut simulation) = match self.last.take() {
            Some(last) if last.0 == place => last,
            // Nothing of the former stays in memory beside it.
            other => {
                drop(other);
                let subject = job.subject(place)?;
                let simulation = Simulation::new(subject.documents.clone(), job.spec.algorithm)?;
                (place, subject, simulation)
            }
        };
        let measured = simulate(&mut simulation, &job.spec, &subject, point, stop)?;
        self.last = Some((place, subject, simulation));
        Ok(measured)
    }
}

fn simulate(
    simulation: &mut Simulation,
    spec: &Spec,
    subject: &Subject,
    point: usize,
    stop: &AtomicBool,
) -> Result<Option<Vec<Option<f64>>>> {
    simulation.reset()?;
    for (column, (name, values)) in spec.points.columns.iter().enumerate() {
        if !spec.only_chooses(column) {
            simulation.set(name, &values.text(point))?;
        }
    }
    simulation.begin(0.0, None)?;
    let courses = Courses::begin(spec, subject, point).map_err(Error::Spec)?;
    let leaving = subject.leave.map(Leaving::of);
    let mut measured = Measured { spec, subject, courses, leaving, ended: None };
    let mut over = measured.see(simulation)?.is_break();
    if !over {
        let step = |simulation: &mut Simulation, _: Point| match stop.load(Ordering::Relaxed) {
            true => Ok(ControlFlow::Break(())),
            false => measured.see(simulation),
        };
        over = lemons_sim::run::<_, Error>(simulation, &subject.clock, 0, step)?.is_break();
    }
    if stop.load(Ordering::Relaxed) {
        return Ok(None);
    }
    let Measured { courses, ended, .. } = measured;
    let mut values = courses.finish(&subject.documents.trial.geometry.walls).map_err(Error::Spec)?;
    values.extend(spec.may_end().then_some(ended.filter(|_| over)));
    Ok(Some(values))
}

/// The measures of a run under way.
struct Measured<'a> {
    spec: &'a Spec,
    subject: &'a Subject,
    courses: Courses<'a>,
    /// It ends when people have left.
    leaving: Option<Leaving>,
    /// \[s\] When its condition held, or all had left.
    ended: Option<f64>,
}

impl Measured<'_> {
    /// Sees a communication point; breaks if the point ends there.
    fn see(&mut self, simulation: &mut Simulation) -> Result<ControlFlow<()>> {
        let frame = simulation.frame();
        for (place, reads) in self.subject.measures.iter().enumerate() {
            if let Reads::Output(reading) = reads {
                let values = reading.read(simulation, &frame)?;
                self.courses.see_values(place, frame.time, values.into_iter());
            }
        }
        let mut holds = match self.spec.stop.as_ref().zip(self.subject.stop.as_ref()) {
            Some((stop, reading)) => stop.holds(reading.read(simulation, &frame)?.into_iter()),
            None => false,
        };
        let mut stuck = false;
        if let Some(leaving) = &mut self.leaving {
            let over = leaving.see(frame.time, &places(&frame));
            holds |= over == Some(Over::Left);
            stuck = over == Some(Over::Standstill);
        }
        self.ended = holds.then_some(frame.time);
        self.courses.see_frame(frame).map_err(Error::Spec)?;
        Ok(if holds || stuck { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    }
}
