//! The sweep: workers, and what they have finished on its way to the directory.

use crate::directory::{Directory, Finished};
use crate::points::hex;
use crate::simulate::{Job, Worker};
use crate::spec::{DriveChoice, Spec};
use anyhow::{Context, Result, bail};
use lemons_files::input;
use lemons_master::{Drive, Fmu, PATIENCE};
use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How far a sweep is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Points that are finished, failed ones among them.
    pub done: usize,
    /// Those that failed.
    pub failed: usize,
    /// All.
    pub total: usize,
    /// Of those done, how many were so when the sweep was begun.
    pub before: usize,
}

/// Runs what a sweep's directory does not hold yet, with so many threads.
///
/// `tell` is called as points are finished. With `stop` set, those under way are finished and kept if that takes no
/// longer than [`PATIENCE`]; the others are given up, their threads end with the program. Failed points are kept with their message; a sweep that is begun again with `retry` simulates them once more.
///
/// # Errors
/// The FMU or the drive cannot be used, the directory is another sweep's or cannot be written.
pub fn sweep(
    spec: Spec,
    fmu: &Path,
    directory: &Path,
    (threads, retry): (usize, bool),
    stop: &AtomicBool,
    mut tell: impl FnMut(Progress),
) -> Result<(Directory, Progress)> {
    let bytes = input::read(fmu, input::LARGEST_BINARY).with_context(|| fmu.display().to_string())?;
    let opened = Fmu::open(fmu)?;
    let resources = opened.resources()?;
    let trial = resources.load(resources.first())?.0;
    let drive = match &spec.drive {
        DriveChoice::None => Drive::default(),
        DriveChoice::Own => Drive::of(Some(&trial), None)?,
        DriveChoice::File(path) => Drive::of(Some(&trial), Some(path))?,
    };
    let step = spec.step.unwrap_or(trial.parameters.time_step);
    let job = Job { fmu: opened, trial, drive, spec, step };
    job.check()?;
    let Spec { points, measures, .. } = &job.spec;
    let measures: Vec<String> = measures.iter().map(|(name, _)| name.clone()).collect();
    let kept = Directory::open(directory, manifest(&job, &bytes)?, points, &measures)?;
    let before = kept.read()?;
    let mut left = vec![true; points.count];
    before.iter().filter(|row| row.outcome.is_ok() || !retry).for_each(|row| left[row.point] = false);
    let left: Vec<usize> = (0..left.len()).filter(|&point| left[point]).collect();
    let done = points.count - left.len();
    let failed = before.iter().filter(|row| row.outcome.is_err()).count();
    let mut progress =
        Progress { done, failed: if retry { 0 } else { failed }, total: points.count, before: done };
    tell(progress);
    let (next, over) = (AtomicUsize::new(0), AtomicBool::new(false));
    let queue = Arc::new(Queue { job, points: left, next, over });
    simulate(&queue, threads, stop, |rows| {
        kept.add(rows)?;
        progress.done += rows.len();
        progress.failed += rows.iter().filter(|row| row.outcome.is_err()).count();
        tell(progress);
        Ok(())
    })?;
    if progress.done == progress.total {
        kept.finish(&kept.read()?)?;
    }
    Ok((kept, progress))
}

/// What the threads of a sweep share.
struct Queue {
    job: Job,
    points: Vec<usize>,
    /// Among these.
    next: AtomicUsize,
    /// No further one is begun.
    over: AtomicBool,
}

impl Queue {
    fn work(&self, finished: &Sender<Finished>) {
        let mut worker = None;
        while !self.over.load(Ordering::Relaxed) {
            let Some(&point) = self.points.get(self.next.fetch_add(1, Ordering::Relaxed)) else { return };
            let outcome = one(&self.job, &mut worker, point);
            if finished.send(Finished { point, outcome }).is_err() {
                return;
            }
        }
    }
}

/// How often it is looked whether the sweep is to be stopped.
const LOOK: Duration = Duration::from_millis(50);

/// Hands points out to threads; what they finish is written every second, or every hundredth of the time so far: the
/// number of parts stays small.
fn simulate(
    queue: &Arc<Queue>,
    threads: usize,
    stop: &AtomicBool,
    mut write: impl FnMut(&[Finished]) -> Result<()>,
) -> Result<()> {
    let (finished, arrived) = channel();
    let mut workers = Vec::new();
    for _ in 0..threads.min(queue.points.len()) {
        let (queue, finished) = (queue.clone(), finished.clone());
        let worker = std::thread::Builder::new().name("sweep".into()).spawn(move || queue.work(&finished));
        workers.push(worker.context("cannot start a thread")?);
    }
    // When all workers have ended, nothing more arrives.
    drop(finished);
    let (start, mut last, mut stopped) = (Instant::now(), Instant::now(), None);
    let mut pending: Vec<Finished> = Vec::new();
    loop {
        let between = Duration::from_secs(1).max(start.elapsed() / 100);
        let message = arrived.recv_timeout(between.saturating_sub(last.elapsed()).min(LOOK));
        let over = message == Err(RecvTimeoutError::Disconnected);
        pending.extend(message);
        if stop.load(Ordering::Relaxed) {
            queue.over.store(true, Ordering::Relaxed);
            stopped.get_or_insert_with(Instant::now);
        }
        let given_up = stopped.is_some_and(|since| since.elapsed() >= PATIENCE);
        if (over || given_up || last.elapsed() >= between) && !pending.is_empty() {
            pending.extend(arrived.try_iter());
            pending.sort_by_key(|row| row.point);
            if let Err(error) = write(&pending) {
                queue.give_up();
                return Err(error);
            }
            pending.clear();
        }
        if last.elapsed() >= between {
            last = Instant::now();
        }
        if over {
            break;
        }
        if given_up {
            queue.give_up();
            return Ok(());
        }
    }
    match workers.into_iter().map(JoinHandle::join).find(Result::is_err) {
        Some(_) => bail!("a worker's thread ended by a fault of its own"),
        None => Ok(()),
    }
}

impl Queue {
    /// Leaves the points under way to threads that end with the program.
    fn give_up(&self) {
        self.over.store(true, Ordering::Relaxed);
        // They would do it, but are not waited for.
        let _ = std::fs::remove_dir_all(self.job.fmu.directory());
    }
}

/// A point; after a failure the next one has a new instance.
fn one<'a>(
    job: &'a Job,
    worker: &mut Option<Worker<'a>>,
    point: usize,
) -> std::result::Result<Vec<Option<f64>>, String> {
    let mut used = match worker.take() {
        Some(used) => used,
        None => Worker::new(job).map_err(|error| format!("{error:#}"))?,
    };
    let measured = used.simulate(point).map_err(|error| format!("{error:#}"))?;
    *worker = Some(used);
    Ok(measured)
}

/// What must be the same for a sweep to go on.
fn manifest(job: &Job, fmu: &[u8]) -> Result<Map<String, Value>> {
    let (description, spec) = (&job.fmu.description, &job.spec);
    let names: Vec<&str> = spec.points.columns.iter().map(|(name, _)| name.as_str()).collect();
    let measures: Map<String, Value> = spec
        .measures
        .iter()
        .map(|(name, measure)| Ok((name.clone(), serde_json::to_value(measure)?)))
        .collect::<Result<_>>()?;
    let manifest = json!({
        "fmu": {
            "model": description.modelName,
            "guid": description.guid,
            "sha256": hex(&Sha256::digest(fmu)),
        },
        "points": { "parameters": names, "count": spec.points.count, "sha256": spec.points.sha256() },
        "drive": drive_identity(job),
        "measure": measures,
        "until": spec.until,
        "step": job.step,
    });
    match manifest {
        Value::Object(manifest) => Ok(manifest),
        _ => Ok(Map::new()),
    }
}

/// As the Python package has it: by the values, however the file is spelled.
fn drive_identity(job: &Job) -> Value {
    let mut digest = Sha256::new();
    let mut driven = false;
    for (place, agent) in job.trial.agents.iter().enumerate() {
        let Some(rows) = job.drive.rows(&agent.id) else { continue };
        driven = true;
        [place, rows.len()].iter().for_each(|number| digest.update((*number as u64).to_le_bytes()));
        for (time, push) in rows {
            std::iter::once(time).chain(push).for_each(|value| digest.update(value.to_le_bytes()));
        }
    }
    match driven {
        true => {
            json!({ "kind": "table", "at": "start", "per_mass": false, "sha256": hex(&digest.finalize()) })
        }
        false => json!({ "kind": "none" }),
    }
}
