//! One run: prepared, stepped, recorded, and what is said of it.

use super::model::{CrowdInfo, PreparedRun, RecordedModel};
use super::outputs::{About, OutputTable, TableFile};
use super::recorder::{CrowdRecorder, Poses, Recorded, RowTarget};
use super::{fmus, trial};
use crate::connect::plain_names;
use crate::error::{and_then, full_message};
use crate::files;
use crate::interrupt::Interrupt;
use crate::print::{self, is_closed_pipe};
use crate::version::BUILD;
use anyhow::{Context, Error, Result, bail, ensure};
use indicatif::ProgressBar;
use lemons_decision::Plan;
use lemons_master::{FileType, RunSettings, SavedRun, TrialInput, writers};
use lemons_results::columns::Group;
use lemons_results::measure::{Leaving, WAITING, Wait};
use lemons_results::{Frame, Run};
use lemons_sim::lint::late_legs;
use lemons_sim::{PointKind, Stepper, Until};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A run, and what becomes of it.
pub struct RunJob {
    /// With a tolerance, the poses of all communication points are kept.
    pub settings: RunSettings,
    /// Where rows of crowds go.
    pub rows: RowTarget,
    /// Where the outputs of what is not a crowd go, if they are recorded.
    pub outputs: Option<TableFile>,
    /// Whether outputs go where rows do, if nothing is a crowd.
    pub either: bool,
    /// Where it is saved.
    pub state: Option<PathBuf>,
    /// When it ends, if not at the time of the settings.
    pub until: Option<Until>,
}

/// The result of a run.
pub struct EndedRun {
    /// Of a run with a tolerance: the poses of each crowd, and the mechanical steps \[s\].
    pub poses: Vec<Poses>,
    pub mechanical_steps: Vec<(String, f64)>,
    /// \[s\] the communication step
    pub step: f64,
    /// Lines of the summary.
    pub summary: Vec<String>,
    /// \[s\] where Ctrl-C stopped it; not where it ended since all had come to rest.
    pub stopped: Option<f64>,
    /// The frames of a run that is shown, unless the FMU has no agents.
    pub recorded: Option<Run>,
    /// Whether all files are in their places.
    pub complete: Result<()>,
}

/// Prepares a run of a Trial, an FMU or an SSP.
fn prepare(settings: &RunSettings) -> Result<PreparedRun> {
    let runs = [FileType::TRIAL, FileType::FMU, FileType::SSP, FileType::ARCHIVE];
    FileType::expect(&settings.input, &runs, "a Trial directory, an FMU or an SSP")?;
    match TrialInput::find(&settings.input)? {
        Some(given) => trial::prepare(&given, settings),
        None => fmus::prepare(settings),
    }
}

/// Runs and records; warnings go to standard error. Ctrl-C ends the run after the step under way.
pub fn simulate(job: RunJob, interrupt: &Interrupt) -> Result<EndedRun> {
    let RunJob { settings, rows, outputs, either, state, until } = job;
    let compared = settings.tolerance.is_some();
    let PreparedRun {
        mut model,
        crowds,
        output_columns,
        plans,
        coupling: mut summary,
        mechanical_steps,
        output_directories,
        clock,
        every,
        drive,
        components,
        wiring,
        before,
    } = prepare(&settings)?;
    model.take_warnings().iter().for_each(|warning| note!("{warning}"));
    let late = plans.iter().filter_map(|plan| late_legs(plan, clock.step, Path::new("")));
    late.for_each(|found| note!("{found}"));
    summary.push(format!("communication step {:>10} s", clock.step));
    if compared && mechanical_steps.is_empty() {
        bail!(
            "--accuracy: nothing here has a parameter TimeStepMechanical, so no mechanical step can be chosen"
        );
    }
    if before.is_none() {
        let named = output_directories.iter().filter(|name| !name.is_empty());
        named.map(Path::new).try_for_each(claim_series)?;
    }
    let (first, index) = before.as_ref().map_or((clock.start, 0), |before| (before.time, before.index));
    let lemons = writers(before.as_ref().map_or("", |before| &before.lemons), &BUILD.whole());
    let lines = vec![
        ("lemons_version", lemons.clone()),
        ("communication_step", format!("{:?}", clock.step)),
        ("every", every.to_string()),
    ];
    let about = About { lines, goes_on: before.is_some() };
    let outputs = match &rows {
        RowTarget::Table(place) if either && crowds.is_empty() => {
            let input = settings.input.display();
            ensure!(!output_columns.is_empty(), "-o: {input} has no outputs, so there is no table");
            ensure!(
                outputs.is_none(),
                "-o, --outputs: {input} has no variables of each person: give one of them"
            );
            Some(place.clone())
        }
        _ => outputs,
    };
    let outputs = outputs.filter(|_| !output_columns.is_empty());
    let mut outputs = outputs.map(|place| OutputTable::create(output_columns, &place, &about)).transpose()?;
    let mut recorders = Vec::with_capacity(crowds.len());
    // Files have plain names.
    let names = plain_names(crowds.iter().map(|crowd| crowd.component.as_str()));
    let several = crowds.len() > 1;
    for (crowd, name) in crowds.into_iter().zip(&names) {
        let to = if several { rows.named(name)? } else { rows.clone() };
        recorders.push(CrowdRecorder::create(crowd, to, &about, before.as_ref(), compared)?);
    }
    if until == Some(Until::Left) && recorders.is_empty() {
        bail!(
            "--until left: {} has no variables of each person, so nobody is seen to leave: give seconds",
            settings.input.display()
        );
    }
    let stop = match until {
        Some(until) => {
            until.condition(drive.end(), || who_leaves(&plans, &recorders)).context("--until left")?
        }
        None => None,
    };
    let mut stepper = Stepper::new(clock, every, stop).from(index);
    if let Some(leaving) = stepper.leaving() {
        note_without_exit(leaving, recorders.iter().map(|crowd| crowd.crowd.ids.len()).sum());
    }
    let file = state.map(|path| Ok::<_, Error>((files::stage(&path)?, path))).transpose()?;
    let bar = progress_bar(&stepper)?;
    let started = Instant::now();
    let mut noted = started;
    let mut record = |run: &Stepper, model: &mut (dyn RecordedModel + 'static), frames: Vec<Frame>, kind| {
        let time = model.time();
        for (recorder, frame) in recorders.iter_mut().zip(frames) {
            recorder.see(frame, kind)?;
        }
        if matches!(kind, PointKind::Start | PointKind::Written)
            && let Some(outputs) = &mut outputs
        {
            outputs.row(time, &model.outputs()?)?;
        }
        bar.set_message(format!("t = {time:.2} s"));
        if run.steps() > 0 && bar.is_hidden() && print::is_due(&mut noted, Instant::now()) {
            note!("t = {time:.2} s");
        }
        bar.set_position(run.leaving().map_or(run.steps(), |leaving| leaving.counts().1 as u64));
        Ok::<_, Error>(if interrupt.pressed() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) })
    };
    let kind = if before.is_none() { PointKind::Start } else { PointKind::Resumed };
    let done = stepper.run(&mut *model, &mut record, kind);
    bar.finish_and_clear();
    let (wall, time) = (started.elapsed().as_secs_f64(), model.time());
    let over = stepper.is_over();
    if let Some(leaving) = stepper.leaving().filter(|_| over) {
        note_remaining(leaving, &recorders, time);
    }
    let saved = match (&done, file) {
        (Ok(()), Some((file, path))) => {
            let states = model.states()?;
            let crowd = recorders.iter().map(CrowdRecorder::record).collect();
            let saved = SavedRun {
                format: SavedRun::FORMAT,
                lemons,
                start: clock.start,
                step: clock.step,
                until: clock.until,
                index: stepper.index(),
                time,
                every,
                algorithm: settings.algorithm.to_string(),
                wiring,
                drive: drive.fingerprint(),
                component: components,
                crowd,
            };
            let shown = path.display();
            let written = saved.write(&states, file).with_context(|| format!("cannot write {shown}"));
            written.map(|()| Some(format!("saved run          {shown}   (at t = {time:.3} s)")))
        }
        (Err(_), Some((_, path))) => {
            note!("warning: {}: a run that fails is not saved", path.display());
            Ok(None)
        }
        _ => Ok(None),
    };
    if let Some(leaving) = stepper.leaving()
        && let Some(Wait { agent, from, time }) = leaving.longest_wait()
    {
        let ids: Vec<&String> = recorders.iter().flat_map(|crowd| &crowd.crowd.ids).collect();
        summary.push(format!(
            "longest wait       {time:>10.3} s   (agent {}, within {WAITING} m from t = {from:.3} s on)",
            ids[agent]
        ));
    }
    let mut warnings = Vec::new();
    if let (Ok(()), [plan], [crowd]) = (&done, &plans[..], &recorders[..]) {
        let found = crowd.end.findings(plan, model.drive().as_deref(), !about.goes_on);
        warnings.extend(found.iter().map(ToString::to_string));
    }
    if !over {
        summary.push(format!("stopped by Ctrl-C  {time:>10.3} s"));
    }
    let simulated = time - first;
    summary.push(format!("simulated time     {simulated:>10.3} s"));
    summary.push(format!("wall time          {wall:>10.3} s"));
    summary.push(format!("real-time factor   {:>10.2}", simulated / wall));
    // What was simulated before a failure is worth having.
    let (mut recorded, mut poses, mut complete) = (None, Vec::new(), Ok(()));
    for recorder in recorders {
        summary.extend(several.then(|| format!("crowd              {}", recorder.crowd.component)));
        let (Recorded { lines, run, poses: own }, placed) = recorder.finish();
        summary.extend(lines);
        poses.extend(own);
        recorded = recorded.or(run);
        complete = and_then(complete, placed);
    }
    match outputs.map(OutputTable::finish).transpose() {
        Ok(line) => summary.extend(line),
        Err(error) => complete = and_then(complete, Err(error)),
    }
    let done = done.and_then(|()| model.terminate());
    model.take_warnings().iter().chain(&warnings).for_each(|warning| note!("{warning}"));
    if let Err(error) = done {
        return Err(stopped(error, time, complete));
    }
    match saved {
        Ok(line) => summary.extend(line),
        Err(error) => complete = and_then(complete, Err(error)),
    }
    let stopped = (!over).then_some(time);
    Ok(EndedRun { poses, mechanical_steps, step: clock.step, summary, stopped, recorded, complete })
}

/// A crowd writes XML files of its own into its OutputDirectory: those of an earlier run must not be among them.
fn claim_series(directory: &Path) -> Result<()> {
    files::claim_series(directory).context("OutputDirectory")?.iter().try_for_each(|path| {
        let cannot = || format!("OutputDirectory: cannot remove {}", path.display());
        std::fs::remove_file(path).with_context(cannot)
    })
}

fn progress_bar(run: &Stepper) -> Result<ProgressBar> {
    let (length, template) = match run.leaving() {
        // How long it takes is not known.
        Some(leaving) => (leaving.counts().0 as u64, "{bar:40} {msg}  {pos} of {len} have left"),
        None => (run.clock.steps.saturating_sub(run.index()), "{bar:40} {percent:>3}%  {msg}  {eta} left"),
    };
    print::bar(length, template)
}

/// Returns of everybody whether they are to leave.
fn who_leaves(plans: &[Plan], recorders: &[CrowdRecorder]) -> Vec<bool> {
    let mut plans = plans.iter().map(Plan::leaving);
    let who = recorders.iter().flat_map(|recorder| {
        let CrowdInfo { ids, groups, .. } = &recorder.crowd;
        // Only our own plans say who has an exit; of others, all might leave.
        let known = if groups.has(Group::Active) { plans.next() } else { None };
        known
            .filter(|who| who.len() == ids.len())
            .unwrap_or_else(|| vec![groups.has(Group::Active); ids.len()])
    });
    who.collect()
}

fn note_without_exit(leaving: &Leaving, people: usize) {
    let stay = people - leaving.counts().0;
    if stay > 0 {
        note!("note: {stay} of {people} people have no exit: the run ends when the others have left");
    }
}

/// Says who has not left, and why the run ends nevertheless.
fn note_remaining(leaving: &Leaving, recorders: &[CrowdRecorder], time: f64) {
    let Some(why) = leaving.why_some_stay(time) else { return };
    let ids: Vec<&String> = recorders.iter().flat_map(|crowd| &crowd.crowd.ids).collect();
    let stay: Vec<&String> = leaving.stay().map(|agent| ids[agent]).collect();
    note!("warning: {why} (still there: {})", print::few(&stay, 5));
}

/// The error of a run that stopped at a time \[s\], after what became of its files was told.
fn stopped(error: Error, time: f64, placed: Result<()>) -> Error {
    let written = match placed {
        Ok(()) => "; the results until then are written",
        Err(_) if is_closed_pipe(&error) => "",
        Err(why) => {
            note!("lemons: {}", full_message(&why));
            ""
        }
    };
    error.context(format!("stopped at t = {time:?} s{written}"))
}
