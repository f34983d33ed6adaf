//! The sweep: workers, and what they have finished on its way to the directory.

use crate::directory::{Directory, Finished};
use crate::points::hex;
use crate::simulate::{Job, Worker};
use crate::spec::{DriveChoice, Spec};
use anyhow::{Context, Result};
use lemons_master::{Drive, Fmu};
use serde_json::{Map, Value, json};
use sha2::{Digest, Sha256};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
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
/// `tell` is called as points are finished. With `stop` set, those under way are finished and kept. Failed points are
/// kept with their message; a sweep that is begun again with `retry` simulates them once more.
///
/// # Errors
/// The FMU or the drive cannot be used, the directory is another sweep's or cannot be written.
pub fn sweep(
    spec: &Spec,
    fmu: &Path,
    directory: &Path,
    (threads, retry): (usize, bool),
    stop: &AtomicBool,
    mut tell: impl FnMut(Progress),
) -> Result<(Directory, Progress)> {
    let bytes = std::fs::read(fmu).with_context(|| fmu.display().to_string())?;
    let opened = Fmu::open(fmu)?;
    let resources = opened.resources()?;
    let trial = resources.load(resources.first())?.0;
    let drive = match &spec.drive {
        DriveChoice::None => Drive::default(),
        DriveChoice::Own => Drive::of(Some(&trial), None)?,
        DriveChoice::File(path) => Drive::of(Some(&trial), Some(path))?,
    };
    let job = Job {
        fmu: &opened,
        trial: &trial,
        drive: &drive,
        until: spec.until,
        step: spec.step.unwrap_or(trial.parameters.time_step),
        points: &spec.points,
        measures: &spec.measures,
    };
    job.check()?;
    let measures: Vec<String> = spec.measures.iter().map(|(name, _)| name.clone()).collect();
    let manifest = manifest(&job, spec, &bytes)?;
    let kept = Directory::open(directory, manifest, &spec.points, &measures)?;
    let before = kept.read()?;
    let mut left = vec![true; spec.points.count];
    before.iter().filter(|row| row.outcome.is_ok() || !retry).for_each(|row| left[row.point] = false);
    let left: Vec<usize> = (0..left.len()).filter(|&point| left[point]).collect();
    let done = spec.points.count - left.len();
    let failed = before.iter().filter(|row| row.outcome.is_err()).count();
    let mut progress =
        Progress { done, failed: if retry { 0 } else { failed }, total: spec.points.count, before: done };
    tell(progress);
    simulate(&job, &left, threads, stop, |rows| {
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

/// Hands points out to threads; what they finish is written every second, or every hundredth of the time so far: the
/// number of parts stays small.
fn simulate(
    job: &Job,
    points: &[usize],
    threads: usize,
    stop: &AtomicBool,
    mut write: impl FnMut(&[Finished]) -> Result<()>,
) -> Result<()> {
    let (next, given_up) = (&AtomicUsize::new(0), &AtomicBool::new(false));
    let (finished, arrived) = channel();
    let pool = &rayon::ThreadPoolBuilder::new().num_threads(threads.min(points.len()).max(1)).build()?;
    std::thread::scope(|scope| {
        // Owns the sender: when all have finished, nothing more arrives.
        let work = move || {
            let mut worker = None;
            while !stop.load(Ordering::Relaxed) && !given_up.load(Ordering::Relaxed) {
                let Some(&point) = points.get(next.fetch_add(1, Ordering::Relaxed)) else { return };
                let outcome = one(job, &mut worker, point);
                if finished.send(Finished { point, outcome }).is_err() {
                    return;
                }
            }
        };
        let workers = scope.spawn(move || pool.broadcast(|_| work()));
        let (start, mut last) = (Instant::now(), Instant::now());
        let mut pending: Vec<Finished> = Vec::new();
        let written = loop {
            let patience = Duration::from_secs(1).max(start.elapsed() / 100);
            let message = arrived.recv_timeout(patience.saturating_sub(last.elapsed()));
            let over = message == Err(RecvTimeoutError::Disconnected);
            pending.extend(message);
            if (over || last.elapsed() >= patience) && !pending.is_empty() {
                pending.sort_by_key(|row| row.point);
                if let Err(error) = write(&pending) {
                    given_up.store(true, Ordering::Relaxed);
                    break Err(error);
                }
                pending.clear();
            }
            if last.elapsed() >= patience {
                last = Instant::now();
            }
            if over {
                break Ok(());
            }
        };
        if workers.join().is_err() {
            anyhow::bail!("a worker's thread ended by a fault of its own");
        }
        written
    })
}

/// A point; after a failure the next one has a new instance.
fn one<'a>(
    job: &'a Job<'a>,
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
fn manifest(job: &Job, spec: &Spec, fmu: &[u8]) -> Result<Map<String, Value>> {
    let description = &job.fmu.description;
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
        "until": job.until,
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
