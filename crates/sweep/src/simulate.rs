//! Simulates one point.

use crate::courses::Courses;
use crate::error::{Error, Place, Result};
use crate::identity;
use crate::models::Models;
use crate::output::Names;
use crate::scene::{Scene, standing};
use crate::spec::Spec;
use crate::stop::Stop;
use crate::subject::{Reads, Subject};
use lemons_master::{Kind, Observer, PlanChoice, Pushes, Reached, Selection, System};
use lemons_measure::{Leaving, Over};
use lemons_trial::DriveChoice;
use serde_json::{Map, Value};
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
        if models.all.len() > 1 {
            check_read_again(&spec, &models)?;
        }
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
            let warning = subject.model.warning(&spec.drive);
            warnings.extend(warning.map(|warning| format!("{}: {warning}", simulated.0.display())));
            let own = identity::of_subject(&spec, &subject)?;
            let (digest, subject_of) = (identity::digest(&own)?, Mutex::new(Arc::downgrade(&subject)));
            subjects.push(Shared { digest, subject: subject_of });
            if models.all.len() == 1 {
                identity.extend(own);
                only = Some(subject);
            }
        }
        if only.is_none() {
            let all: Vec<String> = subjects.iter().map(|shared| shared.digest.clone()).collect();
            identity.extend(identity::of_subjects(&spec, &all, &models));
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
        if identity::digest(&identity::of_subject(&self.spec, &subject)?)? != *digest {
            let path = simulated.0.display();
            return Err(Error::Spec(format!("{path}: it was changed while the sweep was running")));
        }
        *kept = Arc::downgrade(&subject);
        Ok(subject)
    }

    /// Removes the files of all models that are in use.
    pub fn remove_files(&self) {
        for Shared { subject, .. } in &self.subjects {
            // Who holds the lock now loads it, and ends with the program.
            let subject = subject.try_lock().ok().and_then(|kept| kept.upgrade());
            subject.iter().for_each(|subject| subject.model.remove_files());
        }
    }
}

/// That files of several models can be read again: a pipe cannot.
fn check_read_again(spec: &Spec, models: &Models) -> Result<()> {
    let drive = if let DriveChoice::File(path) = &spec.drive { Some(path) } else { None };
    let plans = models.all.iter().filter_map(|(_, plan)| match plan {
        PlanChoice::File(path) => Some(path),
        PlanChoice::Own | PlanChoice::None => None,
    });
    match drive.into_iter().chain(plans).find(|path| Kind::of(path) == Kind::Stream) {
        Some(pipe) => {
            let why =
                "a sweep over several models reads it for each of them, and a pipe can be read only once";
            Err(Error::Spec(format!("{}: {why}", pipe.display())))
        }
        None => Ok(()),
    }
}

/// Simulates points one after the other.
pub struct Worker<'a> {
    job: &'a Job,
    /// Of the last point, with the place of its model.
    runner: Option<(usize, Runner)>,
}

/// A system that simulates points of one model.
struct Runner {
    /// Dropped before the files of its FMUs.
    system: System,
    pushes: Pushes,
    /// Of each measure; `None` if it looks at the whole crowd.
    measures: Vec<Option<Look>>,
    stop: Option<Look>,
    scene: Option<Scene>,
    subject: Arc<Subject>,
}

/// Where values are read.
struct Look {
    /// Of the component.
    place: usize,
    reals: Selection,
    integers: Selection,
    booleans: Selection,
    /// For values of agents who may leave, whether they are there; else empty.
    there: Selection,
    /// Number of values that become one.
    width: usize,
}

impl<'a> Worker<'a> {
    pub fn new(job: &'a Job) -> Worker<'a> {
        Worker { job, runner: None }
    }

    /// Simulates a point and returns its measures, and when it ended by itself \[s\] if it may. The worker can be used
    /// again unless this failed.
    pub fn simulate(&mut self, point: usize) -> Result<Vec<Option<f64>>> {
        let place = self.job.models.place(point);
        let mut runner = match self.runner.take() {
            Some((own, runner)) if own == place => runner,
            // Nothing of the former stays in memory beside it.
            other => {
                drop(other);
                Runner::new(&self.job.spec, self.job.subject(place)?)?
            }
        };
        let measured = runner.simulate(&self.job.spec, point)?;
        self.runner = Some((place, runner));
        Ok(measured)
    }
}

impl Runner {
    fn new(spec: &Spec, subject: Arc<Subject>) -> Result<Runner> {
        let system = subject.model.system(spec.algorithm)?;
        for ((parameter, _), leads) in spec.points.columns.iter().zip(&subject.parameters) {
            let mut inputs =
                leads.iter().flat_map(|(place, names)| names.iter().map(move |name| (*place, name)));
            if let Some((_, input)) = inputs.find(|(place, name)| system.feeds(*place, name)) {
                return Err(Error::Spec(format!(
                    "parameters: {parameter}: overwritten by the connection that feeds {input}"
                )));
            }
        }
        let look = |names: &Names| -> Result<Look> {
            let instance = &system.components()[names.place].instance;
            let there = names.there();
            let fed = !there.is_empty() && there.iter().all(|name| system.feeds(names.place, name));
            Ok(Look {
                there: instance.select(if fed { &there[..] } else { &[] })?,
                place: names.place,
                reals: instance.select(&names.reals)?,
                integers: instance.select(&names.integers)?,
                booleans: instance.select(&names.booleans)?,
                width: names.width,
            })
        };
        let measures = subject.measures.iter().map(|reads| match reads {
            Reads::Output(names) => look(names).map(Some),
            Reads::Crowd(_) => Ok(None),
        });
        let measures = measures.collect::<Result<_>>()?;
        let stop = subject.stop.as_ref().map(look).transpose()?;
        let people = subject.trial.agents.len();
        let scene = subject.wanted.map(|wanted| Scene::of(&system, wanted, people)).transpose()?;
        let driven = &system.components()[subject.model.parts().len() - 1].instance;
        let plays = subject.model.plays(&spec.drive);
        let pushes = Pushes::new(driven, &subject.trial.agents, subject.drive.clone(), plays)?;
        Ok(Runner { system, pushes, measures, stop, scene, subject })
    }

    fn simulate(&mut self, spec: &Spec, point: usize) -> Result<Vec<Option<f64>>> {
        let Runner { system, pushes, measures, stop, scene, subject } = self;
        system.reset()?;
        for ((_, values), leads) in spec.points.columns.iter().zip(&subject.parameters) {
            for (place, names) in leads {
                system.components()[*place].instance.set(names, &values.text(point))?;
            }
        }
        if !subject.model.plays(&spec.drive) {
            system.stop_drives()?;
        }
        system.initialize(0.0, None)?;
        let courses = Courses::begin(spec, subject, point).map_err(Error::Spec)?;
        let stop = spec.stop.as_ref().zip(stop.as_ref());
        let (scene, leaving) = (scene.as_ref(), subject.leave.map(Leaving::of));
        let mut measured =
            Measured { looks: measures, scene, courses, stop, leaving, ended: None, over: false };
        measured.see(system, 0.0)?;
        // Whether its condition or its end ended it, it says itself.
        let _ = lemons_master::simulate(system, &subject.clock, 0, pushes, &mut measured)?;
        system.terminate()?;
        let Measured { courses, ended, .. } = measured;
        let walls = &subject.trial.geometry.walls;
        let mut values = courses.finish(walls).map_err(Error::Spec)?;
        values.extend(spec.may_end().then_some(ended));
        Ok(values)
    }
}

/// The measures of a run under way.
struct Measured<'a> {
    looks: &'a [Option<Look>],
    scene: Option<&'a Scene>,
    courses: Courses<'a>,
    stop: Option<(&'a Stop, &'a Look)>,
    /// It ends when people have left.
    leaving: Option<Leaving>,
    /// \[s\] When its condition held, or all had left.
    ended: Option<f64>,
    /// Whether it ends now.
    over: bool,
}

impl Observer<System> for Measured<'_> {
    type Error = Error;

    fn goes_on(&mut self, _: &System) -> bool {
        !self.over
    }

    fn look(&mut self, system: &mut System, reached: Reached) -> Result<()> {
        self.see(system, reached.time)
    }
}

impl Measured<'_> {
    fn see(&mut self, system: &System, time: f64) -> Result<()> {
        for (place, look) in self.looks.iter().enumerate() {
            if let Some(look) = look {
                self.courses.see_values(place, time, look.values(system)?.into_iter());
            }
        }
        let mut holds = match self.stop {
            Some((stop, look)) => stop.holds(look.values(system)?.into_iter()),
            None => false,
        };
        let mut stuck = false;
        if let Some(scene) = self.scene {
            let frame = scene.frame(system, time)?;
            if let Some(leaving) = &mut self.leaving {
                let over = leaving.see(time, &standing(&frame));
                holds |= over == Some(Over::Left);
                stuck = over == Some(Over::Standstill);
            }
            self.courses.see_frame(frame).map_err(Error::Spec)?;
        }
        self.ended = holds.then_some(time);
        self.over = holds || stuck;
        Ok(())
    }
}

impl Look {
    /// `None` for agents who have left.
    fn values(&self, system: &System) -> lemons_master::Result<Vec<Option<f64>>> {
        let instance = &system.components()[self.place].instance;
        let mut numbers = vec![0.0; self.reals.len()];
        if !self.reals.is_empty() {
            instance.get_real(&self.reals, &mut numbers)?;
        }
        if !self.integers.is_empty() {
            let mut integers = vec![0; self.integers.len()];
            instance.get_integer(&self.integers, &mut integers)?;
            numbers.extend(integers.into_iter().map(f64::from));
        }
        if !self.booleans.is_empty() {
            let mut booleans = vec![0; self.booleans.len()];
            instance.get_boolean(&self.booleans, &mut booleans)?;
            numbers.extend(booleans.into_iter().map(|value| f64::from(u8::from(value != 0))));
        }
        let values = numbers.chunks_exact(self.width).map(|of| match of {
            [value] => *value,
            parts => parts.iter().map(|part| part * part).sum::<f64>().sqrt(),
        });
        let mut there = vec![1; self.there.len()];
        instance.get_boolean(&self.there, &mut there)?;
        let there = there.into_iter().map(|there| there != 0).chain(std::iter::repeat(true));
        Ok(values.zip(there).map(|(value, there)| there.then_some(value)).collect())
    }
}
