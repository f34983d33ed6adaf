//! Runs a sweep: threads simulate points, and their results are appended to the table.

use crate::error::{ErrorPlace, Result, SweepError};
use crate::points::Points;
use crate::simulate::SweepJob;
use crate::spec::Spec;
use crate::table::{Finished, MeasuredValue, SweepTable};
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::Builder;
use std::time::{Duration, Instant};

/// The progress of a sweep.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SweepProgress {
    /// Number of finished points, including failed ones.
    pub done: usize,
    /// Number of failed points.
    pub failed: usize,
    /// Number of all points.
    pub total: usize,
    /// Number of points that were finished before this call.
    pub before: usize,
}

/// How a sweep is run.
#[derive(Debug, Clone, Copy)]
pub struct Options<'a> {
    /// Number of threads.
    pub threads: usize,
    /// Whether failed points are simulated again.
    pub retry: bool,
    /// The program that runs the sweep, with its version: another one does not go on with the table.
    pub by: &'a str,
}

/// A sweep that has ended.
pub struct Swept {
    /// Points that were simulated.
    pub points: Points,
    /// Names of the measures.
    pub measures: Vec<String>,
    /// All finished points, in order.
    pub rows: Vec<Finished>,
    /// How far it is.
    pub progress: SweepProgress,
    /// Warnings of what is probably not meant.
    pub warnings: Vec<String>,
}

/// Simulates the points that a sweep's table does not contain yet.
///
/// `report` is called when points are finished. When `stop` is set, points in progress are given up at their next
/// communication point. Failed points are kept with their message.
///
/// # Errors
/// A Trial, an FMU, a `decision.toml` or the drive cannot be used, the table belongs to another sweep, or it cannot be written.
pub fn sweep(
    spec: Spec,
    table: &Path,
    Options { threads, retry, by }: Options<'_>,
    stop: &AtomicBool,
    mut report: impl FnMut(SweepProgress),
) -> Result<Swept> {
    let (job, mut identity, warnings) = SweepJob::open(spec)?;
    identity.insert("program".into(), by.into());
    let (points, measures) = (&job.spec.points, job.spec.measured());
    let mut table = SweepTable::open(table, &identity, points)?;
    table.name_measures(&measures)?;
    let mut left = vec![true; points.count];
    table.rows().filter(|row| row.outcome.is_ok() || !retry).for_each(|row| left[row.point] = false);
    let left: Vec<usize> = (0..left.len()).filter(|&point| left[point]).collect();
    let done = points.count - left.len();
    let failed = table.rows().filter(|row| row.outcome.is_err()).count();
    let mut progress =
        SweepProgress { done, failed: if retry { 0 } else { failed }, total: points.count, before: done };
    report(progress);
    let queue =
        Arc::new(Queue { job, points: left, next: AtomicUsize::new(0), over: AtomicBool::new(false) });
    simulate(&queue, threads, stop, |rows| {
        table.add(rows)?;
        progress.done += rows.len();
        progress.failed += rows.iter().filter(|row| row.outcome.is_err()).count();
        report(progress);
        Ok(())
    })?;
    let points = queue.job.spec.points.clone();
    let whole = progress.done == progress.total;
    let rows = if whole { table.finish()? } else { table.rows().cloned().collect() };
    Ok(Swept { points, measures, rows, progress, warnings })
}

/// Data shared by the threads of a sweep.
struct Queue {
    job: SweepJob,
    points: Vec<usize>,
    /// Index of the next point in the list.
    next: AtomicUsize,
    /// Whether no further point is begun.
    over: AtomicBool,
}

impl Queue {
    fn work(&self, finished: &Sender<Finished>) {
        let mut last = None;
        while let Some(&point) = self.points.get(self.next.fetch_add(1, Ordering::Relaxed)) {
            let outcome = match self.job.simulate(&mut last, point, &self.over) {
                Ok(None) => return,
                Ok(Some(values)) => {
                    Ok(values.into_iter().map(|value| value.map(MeasuredValue::Number)).collect())
                }
                Err(error) => Err(error.whole()),
            };
            if finished.send(Finished { point, outcome }).is_err() || self.over.load(Ordering::Relaxed) {
                return;
            }
        }
    }
}

/// Simulates points in threads, and writes what is finished. Threads that are stopped are not waited for: a step may
/// take long.
fn simulate(
    queue: &Arc<Queue>,
    threads: usize,
    stop: &AtomicBool,
    write: impl FnMut(&[Finished]) -> Result<()>,
) -> Result<()> {
    let (finished, arrived) = channel();
    let begin = |_| {
        let (queue, finished) = (queue.clone(), finished.clone());
        Builder::new().name("sweep".into()).spawn(move || queue.work(&finished))
    };
    let workers: io::Result<Vec<_>> = (0..threads.min(queue.points.len())).map(begin).collect();
    // The channel closes when all workers have ended.
    drop(finished);
    let done = workers.place(|| "cannot start a thread".into()).and_then(|workers| {
        if collect(&arrived, stop, write)? {
            workers.into_iter().try_for_each(|worker| worker.join().map_err(|_| SweepError::Worker))?;
        }
        Ok(())
    });
    queue.over.store(true, Ordering::Relaxed);
    done
}

/// How long it takes at most until a stop is noticed.
const LATENCY: Duration = Duration::from_millis(50);

/// Writes finished points as they arrive: at first each second, later each hundredth of the elapsed time. Returns whether
/// all have arrived, and the threads have ended.
fn collect(
    arrived: &Receiver<Finished>,
    stop: &AtomicBool,
    mut write: impl FnMut(&[Finished]) -> Result<()>,
) -> Result<bool> {
    let (start, mut last) = (Instant::now(), Instant::now());
    let mut pending: Vec<Finished> = Vec::new();
    loop {
        let between = Duration::from_secs(1).max(start.elapsed() / 100);
        let message = arrived.recv_timeout(between.saturating_sub(last.elapsed()).min(LATENCY));
        let all = message == Err(RecvTimeoutError::Disconnected);
        let ended = all || stop.load(Ordering::Relaxed);
        pending.extend(message);
        if (ended || last.elapsed() >= between) && !pending.is_empty() {
            pending.extend(arrived.try_iter());
            pending.sort_by_key(|row| row.point);
            write(&pending)?;
            pending.clear();
            last = Instant::now();
        }
        if ended {
            return Ok(all);
        }
    }
}
