//! `lemons sweep`: many runs with other parameters.

use crate::error::Misused;
use crate::files::{self, ForceOption};
use crate::interrupt::{Interrupt, Interrupted};
use crate::output::Output;
use crate::print;
use crate::version::BUILD;
use anyhow::{Context, Result, bail};
use lemons_sweep::{Finished, Options, Spec, SweepProgress, Swept, check_over, summary, sweep as run};
use std::cell::Cell;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::Instant;

#[derive(clap::Args)]
#[command(after_help = EXAMPLE)]
pub struct Arguments {
    /// The sweep: what is simulated, with which parameters, and what is measured
    #[arg(value_name = "FILE.toml")]
    spec: PathBuf,
    /// Table of the results. If it already holds a part of this sweep, the sweep continues.
    /// Default: the name of FILE.toml with the extension .csv
    #[arg(short, long, value_name = "FILE.csv")]
    output: Option<PathBuf>,
    /// Number of points that are simulated at the same time. Default: one for each processor
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Simulate failed points again
    #[arg(long)]
    retry_failed: bool,
    /// Write a table with a row for each case, that is for all runs that differ only in the parameters of
    /// --over: how many there are, how many failed and how many had no end (stuck); and of each measure the
    /// mean, its 95 % interval (_low, _high: Student's t) and quantiles, of the runs that have a value
    #[arg(long, value_name = "FILE.csv", requires = "over")]
    summary: Option<PathBuf>,
    /// Parameters that tell the runs of a case apart, such as a seed
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', requires = "summary")]
    over: Vec<String>,
    #[command(flatten)]
    _force: ForceOption,
}

const EXAMPLE: &str = include_str!("help/sweep.txt");

/// Messages of failed points that are shown.
const SHOWN: usize = 3;

pub fn sweep(arguments: &Arguments) -> Result<()> {
    let spec = Spec::read(&arguments.spec)?;
    let output = arguments.output.clone().unwrap_or_else(|| arguments.spec.with_extension("csv"));
    let who = arguments.spec.display().to_string();
    spec.inputs.iter().for_each(|path| files::reads(path, &who));
    // What is there is gone on with, or refused.
    files::claim_directory(&output)?;
    // Where points write files themselves.
    for (_, directory) in spec.points.output_directories() {
        files::claim_series(Path::new(directory)).context("OutputDirectory")?;
    }
    check_over(&spec.points, &arguments.over).map_err(|error| Misused(format!("--over: {error}")))?;
    let summary_file = arguments.summary.as_deref().map(Output::open).transpose()?;
    let all_processors = || std::thread::available_parallelism().map_or(1, usize::from);
    let threads = arguments.threads.map_or_else(all_processors, usize::from);
    let interrupt = Interrupt::watch();
    let template = "{bar:40} {percent:>3}%  {pos} of {len} points  {msg}{eta} left";
    let bar = print::bar(spec.points.count as u64, template)?;
    let (newest, mut noted) = (Cell::new(None), Instant::now());
    let tell = |at: SweepProgress| {
        newest.set(Some(at));
        if at.failed > 0 {
            bar.set_message(format!("{} failed  ", at.failed));
        }
        // What was there before says nothing about how fast it goes.
        if at.done == at.before {
            bar.set_position(at.before as u64);
            bar.reset_eta();
        }
        bar.set_position(at.done as u64);
        if bar.is_hidden() && print::is_due(&mut noted, Instant::now()) {
            note!("{} of {} points, {} failed", at.done, at.total, at.failed);
        }
    };
    let started = Instant::now();
    let by = BUILD.whole();
    let options = Options { threads, retry: arguments.retry_failed, by: &by };
    let may_end = spec.may_end();
    let done = run(spec, &output, options, interrupt.flag(), tell);
    bar.finish_and_clear();
    let Swept { points, measures, rows, progress: at, warnings } = match (done, newest.get()) {
        (Ok(done), _) => done,
        (Err(error), Some(at)) => return Err(anyhow::Error::new(error).context(kept(at))),
        // With the exit code of a Trial that has errors.
        (Err(lemons_sweep::SweepError::Master(error)), None) => return Err(error.into()),
        (Err(error @ (lemons_sweep::SweepError::Spec(_) | lemons_sweep::SweepError::In { .. })), None) => {
            return Err(anyhow::Error::new(error).context(arguments.spec.display().to_string()));
        }
        (Err(error), None) => return Err(error.into()),
    };
    let wall = started.elapsed().as_secs_f64();
    warnings.iter().for_each(|warning| note!("{warning}"));
    let told = print_points(&rows, at, wall, threads, may_end);
    if at.done < at.total {
        return Err(Interrupted(format!("{}; go on with the same command", kept(at))).into());
    }
    if at.failed == at.total {
        let again = "the table says why in the column error; --retry-failed simulates them again";
        bail!("none of the {} points succeeded: {again}", at.total);
    }
    told?;
    if let (Some(mut file), Some(path)) = (summary_file, &arguments.summary) {
        let text = summary(&points, &measures, &rows, &arguments.over)?;
        file.fill(|out| out.write_all(text.as_bytes()))?;
        file.persist()?;
        say!("summary            {}", path.display())?;
    }
    Ok(say!("table              {}", output.display())?)
}

/// How far a sweep is, in a line.
fn kept(at: SweepProgress) -> String {
    format!("{} of {} points are finished and kept", at.done, at.total)
}

fn print_points(
    rows: &[Finished],
    at: SweepProgress,
    wall: f64,
    threads: usize,
    may_end: bool,
) -> Result<()> {
    let new = at.done - at.before;
    say!("points             {:>10}     ({new} now, {} before)", at.total, at.before)?;
    say!("succeeded          {:>10}", at.done - at.failed)?;
    say!("failed             {:>10}", at.failed)?;
    if at.done < at.total {
        say!("not simulated      {:>10}", at.total - at.done)?;
    }
    // When a point ended by itself comes after its measures.
    let endless = |row: &&Finished| matches!(&row.outcome, Ok(values) if values.last() == Some(&None));
    let endless = rows.iter().filter(endless).count();
    if may_end && endless > 0 {
        say!("without an end     {endless:>10}     (people stayed, or stop did not hold: column ended)")?;
    }
    say!("wall time          {wall:>10.3} s   ({threads} at once)")?;
    if new > 0 {
        say!("points per second  {:>10.2}", new as f64 / wall)?;
    }
    let failed = || rows.iter().filter_map(|row| Some((row.point, row.outcome.as_ref().err()?)));
    for (point, message) in failed().take(SHOWN) {
        say!("point {point:<6}       {}", message.lines().next().unwrap_or_default())?;
    }
    if failed().count() > SHOWN {
        say!("                   … and {} more, see the column error", failed().count() - SHOWN)?;
    }
    Ok(())
}
