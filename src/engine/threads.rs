//! Threads of a world: a pool of its own, or none.

use rayon::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;
use thiserror::Error;

/// Threads could not be started.
#[derive(Debug, Error)]
#[error("cannot start {count} threads: {reason}")]
pub struct ThreadsError {
    count: usize,
    reason: String,
}

/// Executes the work of a communication step: with the calling thread, or a pool.
///
/// Clones share the pool. When the last of them is dropped, the pool is dropped and its threads are joined, because a
/// host may unload this library right after.
#[derive(Debug, Clone, Default)]
pub(super) struct Threads(Option<Arc<Pool>>);

impl Threads {
    /// Starts `count` threads; none if it is 0 or 1.
    ///
    /// # Errors
    /// The system cannot start them.
    pub fn new(count: usize) -> Result<Threads, ThreadsError> {
        if count <= 1 { Ok(Threads(None)) } else { Ok(Threads(Some(Arc::new(Pool::new(count)?)))) }
    }

    /// Returns the number of threads.
    pub fn count(&self) -> usize {
        self.0.as_ref().map_or(1, |pool| pool.count)
    }

    /// Runs a function inside the pool, so that [`Threads::each`] in it uses the pool.
    pub(super) fn enter<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match self.0.as_deref().and_then(|pool| pool.threads.as_ref()) {
            Some(threads) => threads.install(work),
            None => work(),
        }
    }

    /// Applies the work to every item, in any order.
    #[inline]
    pub(super) fn each<T: Send>(&self, items: impl Iterator<Item = T>, work: impl Fn(T) + Send + Sync) {
        if self.0.is_some() {
            items.collect::<Vec<T>>().into_par_iter().for_each(work);
        } else {
            items.for_each(work);
        }
    }
}

#[derive(Debug)]
struct Pool {
    count: usize,
    /// `Some` until it is dropped.
    threads: Option<ThreadPool>,
    handles: Vec<JoinHandle<()>>,
}

impl Pool {
    fn new(count: usize) -> Result<Pool, ThreadsError> {
        let handles = Arc::new(Mutex::new(Vec::with_capacity(count)));
        let made = handles.clone();
        let threads = ThreadPoolBuilder::new()
            .num_threads(count)
            .spawn_handler(move |thread| {
                let name = format!("crowd {}", thread.index());
                let handle = std::thread::Builder::new().name(name).spawn(|| thread.run())?;
                made.lock().unwrap_or_else(|broken| broken.into_inner()).push(handle);
                Ok(())
            })
            .build();
        let handles = std::mem::take(&mut *handles.lock().unwrap_or_else(|broken| broken.into_inner()));
        match threads {
            Ok(threads) => Ok(Pool { count, threads: Some(threads), handles }),
            Err(error) => {
                join(handles);
                Err(ThreadsError { count, reason: error.to_string() })
            }
        }
    }
}

impl Drop for Pool {
    fn drop(&mut self) {
        // This tells the threads to end but does not wait for them.
        self.threads = None;
        join(std::mem::take(&mut self.handles));
    }
}

fn join(handles: Vec<JoinHandle<()>>) {
    for handle in handles {
        // A thread that panicked has ended too.
        let _ = handle.join();
    }
}
