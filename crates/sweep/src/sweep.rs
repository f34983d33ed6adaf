//! Runs a sweep: threads simulate points, and their results are appended to the table.

use crate::error::{Result, SweepError};
use crate::points::Points;
use crate::simulate::{LoadedModel, SweepJob};
use crate::spec::Spec;
use crate::table::{Finished, MeasuredValue, SweepTable};
use crate::threads::{SimulatedPoints, in_threads};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

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
    let job = Arc::new(job);
    in_threads(&job, left, threads, stop, |mut rows| {
        rows.sort_by_key(|row| row.point);
        table.add(&rows)?;
        progress.done += rows.len();
        progress.failed += rows.iter().filter(|row| row.outcome.is_err()).count();
        report(progress);
        Ok::<_, SweepError>(())
    })?;
    let points = job.spec.points.clone();
    let whole = progress.done == progress.total;
    let rows = if whole { table.finish()? } else { table.rows().cloned().collect() };
    Ok(Swept { points, measures, rows, progress, warnings })
}

impl SimulatedPoints for SweepJob {
    /// The model of the last point.
    type Kept = Option<(usize, LoadedModel)>;
    type Done = Finished;

    fn simulate(&self, last: &mut Self::Kept, point: usize, stop: &AtomicBool) -> Option<Finished> {
        let outcome = match self.simulate(last, point, stop) {
            Ok(None) => return None,
            Ok(Some(values)) => {
                Ok(values.into_iter().map(|value| value.map(MeasuredValue::Number)).collect())
            }
            Err(error) => Err(error.whole()),
        };
        Some(Finished { point, outcome })
    }
}
