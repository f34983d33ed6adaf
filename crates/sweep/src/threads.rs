//! Threads that simulate points, whose results arrive as they finish.

use crate::error::{ErrorPlace, SweepError};
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

/// Points that are simulated in several threads.
pub trait SimulatedPoints: Send + Sync + 'static {
    /// Data that a thread keeps from one point to the next.
    type Kept: Default;
    /// The result of a point.
    type Done: Send + 'static;

    /// Simulates a point; `None` if `stop` was set meanwhile.
    fn simulate(&self, kept: &mut Self::Kept, point: usize, stop: &AtomicBool) -> Option<Self::Done>;
}

/// Data shared by the threads.
struct Queue<P> {
    job: Arc<P>,
    points: Vec<usize>,
    /// Index of the next point in the list.
    next: AtomicUsize,
    /// Whether no further point is begun.
    over: AtomicBool,
}

impl<P: SimulatedPoints> Queue<P> {
    fn work(&self, finished: &Sender<P::Done>) {
        let mut kept = P::Kept::default();
        while let Some(&point) = self.points.get(self.next.fetch_add(1, Ordering::Relaxed)) {
            let Some(done) = self.job.simulate(&mut kept, point, &self.over) else { return };
            if finished.send(done).is_err() || self.over.load(Ordering::Relaxed) {
                return;
            }
        }
    }
}

/// Simulates points in threads, and gives away what is finished. Threads that are stopped are not waited for: a step may
/// take long. Returns whether all are finished.
///
/// # Errors
/// Those of `write`, and a thread cannot be started or panicked.
pub fn in_threads<P: SimulatedPoints, E: From<SweepError>>(
    job: &Arc<P>,
    points: Vec<usize>,
    threads: usize,
    stop: &AtomicBool,
    write: impl FnMut(Vec<P::Done>) -> Result<(), E>,
) -> Result<bool, E> {
    let (job, next, over) = (job.clone(), AtomicUsize::new(0), AtomicBool::new(false));
    let queue = Arc::new(Queue { job, points, next, over });
    let (finished, arrived) = channel();
    let begin = |_| {
        let (queue, finished) = (queue.clone(), finished.clone());
        Builder::new().name("sweep".into()).spawn(move || queue.work(&finished))
    };
    let workers: io::Result<Vec<_>> = (0..threads.min(queue.points.len())).map(begin).collect();
    // The channel closes when all workers have ended.
    drop(finished);
    let done = workers.place(|| "cannot start a thread".into()).map_err(E::from).and_then(|workers| {
        let all = collect(&arrived, stop, write)?;
        let join = |worker: JoinHandle<()>| worker.join().map_err(|_| SweepError::Worker);
        if all {
            workers.into_iter().try_for_each(join)?;
        }
        Ok(all)
    });
    queue.over.store(true, Ordering::Relaxed);
    done
}

/// How long it takes at most until a stop is noticed.
const LATENCY: Duration = Duration::from_millis(50);

/// Gives away finished points as they arrive: at first each second, later each hundredth of the elapsed time. Returns
/// whether all have arrived, and the threads have ended.
fn collect<D, E>(
    arrived: &Receiver<D>,
    stop: &AtomicBool,
    mut write: impl FnMut(Vec<D>) -> Result<(), E>,
) -> Result<bool, E> {
    let (start, mut last) = (Instant::now(), Instant::now());
    let mut pending = Vec::new();
    loop {
        let between = Duration::from_secs(1).max(start.elapsed() / 100);
        let message = arrived.recv_timeout(between.saturating_sub(last.elapsed()).min(LATENCY));
        let all = matches!(message, Err(RecvTimeoutError::Disconnected));
        let ended = all || stop.load(Ordering::Relaxed);
        pending.extend(message);
        if (ended || last.elapsed() >= between) && !pending.is_empty() {
            pending.extend(arrived.try_iter());
            write(std::mem::take(&mut pending))?;
            last = Instant::now();
        }
        if ended {
            return Ok(all);
        }
    }
}
