//! Runs a sweep: threads simulate points, and their results are appended to the table.

use crate::error::{Error, Place, Result};
use crate::points::Points;
use crate::simulate::{Job, Worker};
use crate::spec::{ENDED, Spec};
use crate::table::{Finished, Measured, Table};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// The progress of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Number of finished points, including failed ones.
    pub done: usize,
    /// Number of failed points.
    pub failed: usize,
    /// Number of all points.
    pub total: usize,
    /// Number of points that were finished before this call.
    pub before: usize,
}

/// Settings of a sweep.
#[derive(Debug, Clone, Copy)]
pub struct How<'a> {
    /// Number of threads.
    pub threads: usize,
    /// Whether failed points are simulated again.
    pub retry: bool,
    /// The program that runs the sweep, with its version: another one does not go on with the table.
    pub by: &'a str,
}

/// A sweep that has ended.
pub struct Swept {
    /// What was simulated.
    pub points: Points,
    /// Names of the measures.
    pub measures: Vec<String>,
    /// All finished points, in order.
    pub rows: Vec<Finished>,
    /// How far it is.
    pub progress: Progress,
    /// What is probably not meant.
    pub warnings: Vec<String>,
}

/// Simulates the points that a sweep's table does not contain yet.
///
/// `tell` is called when points are finished. When `stop` is set, points in progress are given up, and their threads end
/// at the next communication point. Failed points are kept with their message.
///
/// # Errors
/// A Trial, an FMU, a plan or the drive cannot be used, the table belongs to another sweep, or it cannot be written.
pub fn sweep(
    spec: Spec,
    table: &Path,
    How { threads, retry, by }: How<'_>,
    stop: &AtomicBool,
    mut tell: impl FnMut(Progress),
) -> Result<Swept> {
    let (job, mut identity, warnings) = Job::open(spec)?;
    identity.insert("program".into(), by.into());
    let Spec { points, measures, .. } = &job.spec;
    let ended = job.spec.may_end().then(|| ENDED.to_owned());
    let measures: Vec<String> = measures.iter().map(|(name, _)| name.clone()).chain(ended).collect();
    let mut table = Table::open(table, &identity, points, Some(&measures))?;
    let mut left = vec![true; points.count];
    table.rows().filter(|row| row.outcome.is_ok() || !retry).for_each(|row| left[row.point] = false);
    let left: Vec<usize> = (0..left.len()).filter(|&point| left[point]).collect();
    let done = points.count - left.len();
    let failed = table.rows().filter(|row| row.outcome.is_err()).count();
    let mut progress =
        Progress { done, failed: if retry { 0 } else { failed }, total: points.count, before: done };
    tell(progress);
    let (next, over) = (AtomicUsize::new(0), AtomicBool::new(false));
    let queue = Arc::new(Queue { job, points: left, next, over });
    simulate(&queue, threads, stop, |rows| {
        table.add(rows)?;
        progress.done += rows.len();
        progress.failed += rows.iter().filter(|row| row.outcome.is_err()).count();
        tell(progress);
        Ok(())
    })?;
    let points = queue.job.spec.points.clone();
    let whole = progress.done == progress.total;
    let rows = if whole { table.finish()? } else { table.rows().cloned().collect() };
    Ok(Swept { points, measures, rows, progress, warnings })
}

/// Data shared by the threads of a sweep.
struct Queue {
    job: Job,
    points: Vec<usize>,
    /// Index of the next point in the list.
    next: AtomicUsize,
    /// Whether no further point is begun.
    over: AtomicBool,
}

impl Queue {
    fn work(&self, finished: &Sender<Finished>) {
        let mut worker = None;
        while !self.over.load(Ordering::Relaxed) {
            let Some(&point) = self.points.get(self.next.fetch_add(1, Ordering::Relaxed)) else { return };
            let Some(outcome) = one(&self.job, &mut worker, point, &self.over) else { return };
            if finished.send(Finished { point, outcome }).is_err() {
                return;
            }
        }
    }
}

/// Time between two checks of `stop`.
const LOOK: Duration = Duration::from_millis(50);

/// Gives points to threads. Finished points are written every second, or every hundredth of the elapsed time.
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
        workers.push(worker.place(|| "cannot start a thread".into())?);
    }
    // The channel closes when all workers have ended.
    drop(finished);
    let (start, mut last) = (Instant::now(), Instant::now());
    let mut pending: Vec<Finished> = Vec::new();
    loop {
        let between = Duration::from_secs(1).max(start.elapsed() / 100);
        let message = arrived.recv_timeout(between.saturating_sub(last.elapsed()).min(LOOK));
        let over = message == Err(RecvTimeoutError::Disconnected);
        pending.extend(message);
        let stopped = stop.load(Ordering::Relaxed);
        if stopped {
            queue.over.store(true, Ordering::Relaxed);
        }
        if (over || stopped || last.elapsed() >= between) && !pending.is_empty() {
            pending.extend(arrived.try_iter());
            pending.sort_by_key(|row| row.point);
            if let Err(error) = write(&pending) {
                queue.over.store(true, Ordering::Relaxed);
                return Err(error);
            }
            pending.clear();
            last = Instant::now();
        }
        if over {
            break;
        }
        if stopped {
            return Ok(());
        }
    }
    match workers.into_iter().map(JoinHandle::join).find(Result::is_err) {
        Some(_) => Err(Error::Worker),
        None => Ok(()),
    }
}

/// Simulates a point; `None` if it was stopped. After a failure the next point gets a new simulation.
fn one<'a>(
    job: &'a Job,
    worker: &mut Option<Worker<'a>>,
    point: usize,
    stop: &AtomicBool,
) -> Option<std::result::Result<Vec<Option<Measured>>, String>> {
    let mut used = worker.take().unwrap_or_else(|| Worker::new(job));
    let outcome = used.simulate(point, stop).map_err(|error| error.whole()).transpose()?;
    let number = |value: Option<f64>| value.map(Measured::Number);
    let outcome = outcome.map(|values| values.into_iter().map(number).collect());
    if outcome.is_ok() {
        *worker = Some(used);
    }
    Some(outcome)
}
