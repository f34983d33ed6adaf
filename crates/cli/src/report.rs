//! `lemons report`: runs of a scenario with several seeds, and what an engineer wants to know of them.

use crate::error::{Misused, full_message};
use crate::files::ForceOption;
use crate::interrupt::{Interrupt, Interrupted};
use crate::output::Output;
use crate::print;
use crate::run::until;
use crate::version::BUILD;
use anyhow::{Context, Result, bail};
use lemons_core::files::source::LocalFiles;
use lemons_core::message::{Message, message};
use lemons_core::trial::DRIVE_FILE;
use lemons_decision::{DecisionConfig, Plan};
use lemons_master::{DecisionChoice, TrialInput};
use lemons_report::{LIMIT, Report, RunSeen, Settings, Told, html, pdf, sentences};
use lemons_scenario::{MOST_PEOPLE, People, Scenario, ScenarioDocuments};
use lemons_sim::lint::{self, Files};
use lemons_sim::{Algorithm, Documents, Until};
use lemons_sweep::{SimulatedPoints, identity, in_threads};
use std::io::Write;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

#[derive(clap::Args)]
pub struct Arguments {
    /// A scenario, as lemons crowd --save-scenario writes it (docs/reference/scenario.md); or a Trial
    #[arg(value_name = "SCENARIO.toml or TRIAL")]
    scenario: PathBuf,
    /// Number of runs. Each has a seed of its own, from that of the scenario on: other people at other
    /// places. Of a Trial, seeds choose only what its decision.toml draws. Default: 10; 1 for a Trial without one
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    seeds: Option<u32>,
    /// End of each run, in seconds, if not all have left before; or the word left: when all have left, or
    /// nobody gets on, at the latest after an hour. Default: left where people leave, else 5
    #[arg(long, value_name = "SECONDS|left", value_parser = until)]
    until: Option<Until>,
    /// The report
    #[arg(short, long, default_value = "report.html", value_name = "FILE.html or .pdf")]
    output: PathBuf,
    /// Number of runs at the same time. Default: one for each processor
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    #[command(flatten)]
    _force: ForceOption,
}

/// What runs are made of.
enum Subject {
    Scenario(Box<Scenario>),
    /// A Trial, with the warnings of its files.
    Trial(Box<Documents>),
}

/// The runs of a report.
struct Runs {
    subject: Subject,
    name: String,
    seeds: Vec<u64>,
    settings: Settings,
}

impl Runs {
    /// Makes the documents of a run. `tell` gets what was made of a scenario.
    fn documents(
        &self,
        seed: u64,
        stop: &AtomicBool,
        tell: impl FnOnce(&ScenarioDocuments),
    ) -> Result<Documents> {
        match &self.subject {
            Subject::Scenario(scenario) => {
                let own = Scenario { seed: Some(seed), ..(**scenario).clone() };
                let mut watch = |_: &_| match stop.load(Ordering::Relaxed) {
                    true => ControlFlow::Break(()),
                    false => ControlFlow::Continue(()),
                };
                let made = own.documents(&self.name, MOST_PEOPLE, &LocalFiles, &mut watch)?;
                tell(&made);
                let plan = made.decision.map(|(_, plan)| plan);
                Ok(Documents { trial: made.trial, drive: made.drive, plan })
            }
            Subject::Trial(documents) => {
                let mut own = (**documents).clone();
                if let Some(plan) = &mut own.plan {
                    *plan =
                        Plan::of(&own.trial, &DecisionConfig { seed: Some(seed), ..plan.config.clone() })?;
                }
                Ok(own)
            }
        }
    }
}

impl SimulatedPoints for Runs {
    type Kept = ();
    type Done = (u64, Result<RunSeen>);

    fn simulate(&self, (): &mut (), point: usize, stop: &AtomicBool) -> Option<Self::Done> {
        let seed = self.seeds[point];
        let mut watch = |_| match stop.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        };
        let run = self.documents(seed, stop, |_| ()).and_then(|documents| {
            // Without a plan, nothing depends on a seed.
            let own = Some(seed)
                .filter(|_| matches!(self.subject, Subject::Scenario(_)) || documents.plan.is_some());
            Ok(RunSeen::run(documents, own, self.settings, &mut watch)?)
        });
        Some((seed, run.transpose()?))
    }
}

pub fn report(arguments: &Arguments) -> Result<()> {
    let Arguments { scenario: path, output, .. } = arguments;
    let is_pdf = match output.extension().and_then(|end| end.to_str()).map(str::to_ascii_lowercase).as_deref()
    {
        Some("html" | "htm") => false,
        Some("pdf") => true,
        _ => bail!(Misused(format!("{}: reports are .html or .pdf", output.display()))),
    };
    let interrupt = Interrupt::watch();
    let name = path.canonicalize().unwrap_or_else(|_| path.clone());
    let name = name.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let mut told = Told {
        source: path.display().to_string(),
        program: format!("lemons {}", BUILD.whole()),
        ..Told::default()
    };
    let (subject, begin) = match TrialInput::find(path)? {
        Some(given) => {
            let (documents, problems, _) = given.documents(&Default::default(), &DecisionChoice::Own)?;
            told.people = message!(sentences::FROM_TRIAL);
            told.warnings.extend(problems.iter().map(|problem| problem.told()));
            if let Some(plan) = &documents.plan {
                told.settings = flat(&plan.config.to_toml()?);
                let several = arguments.seeds.is_none_or(|count| count > 1);
                told.warnings.extend(several.then(|| message!(sentences::SAME_PEOPLE)));
            }
            let pushed = documents.drive.end().map(|end| (DRIVE_FILE.to_owned(), format!("0 – {end} s")));
            told.settings.extend(pushed);
            let seed = documents.plan.as_ref().map_or(0, |plan| plan.seed);
            (Subject::Trial(Box::new(documents)), seed)
        }
        None => {
            let as_it_is = Scenario::read_as_it_is(&LocalFiles, path)?;
            told.settings = flat(&as_it_is.to_toml()?);
            let scenario = Scenario::read(&LocalFiles, path)?;
            let seed = scenario.seed();
            told.people = match scenario.people {
                People::Survey {} => message!(sentences::FROM_SURVEY),
                People::Statistics { .. } | People::Custom { .. } => message!(sentences::FROM_OWN),
                People::Tables { .. } => message!(sentences::FROM_TABLES),
                People::Fixed { .. } => message!(sentences::FROM_ONE),
            };
            (Subject::Scenario(Box::new(scenario)), seed)
        }
    };
    let still = matches!(&subject, Subject::Trial(documents) if documents.plan.is_none());
    if let Some(count) = arguments.seeds.filter(|count| still && *count > 1) {
        let why = "nothing in a Trial without decision.toml depends on a seed";
        bail!(Misused(format!("--seeds {count}: {}: {why}", path.display())));
    }
    let count = arguments.seeds.unwrap_or(if still { 1 } else { 10 });
    if begin > i64::MAX as u64 - u64::from(count) {
        bail!(Misused(format!("--seeds {count}: seeds from {begin} on would be more than {}", i64::MAX)));
    }
    let seeds: Vec<u64> = (0..u64::from(count)).map(|k| begin + k).collect();
    let settings = Settings { until: Until::Left, limit: LIMIT };
    let mut runs = Runs { subject, name: name.clone(), seeds, settings };
    // What is wrong with the first is said before anything long.
    let mut notes = Vec::new();
    let first = runs.documents(begin, interrupt.flag(), |made| {
        notes = made.notes.iter().map(|note| Message::from(note.as_str())).collect();
        let read = made.place.drawn.iter().flat_map(|read| read.messages(&made.place.name));
        told.drawing = read.map(|(what, how)| (what.to_owned(), how)).collect();
    });
    let first = first.with_context(|| path.display().to_string())?;
    let leaves = first.leaving().contains(&true);
    runs.settings.until = arguments.until.unwrap_or(if leaves { Until::Left } else { Until::Time(5.0) });
    if runs.settings.until == Until::Left && !leaves {
        bail!(Misused(format!("--until left: {}: {}", path.display(), lemons_sim::stop::NobodyLeaves)));
    }
    let files = Files::within(Path::new(""));
    let step = first.trial.parameters.time_step;
    let found = lint::of_documents(&first, &files).into_iter().chain(lint::of_step(&first, step, &files));
    told.warnings.extend(found.map(|problem| problem.told()));
    told.warnings.extend(notes);
    told.title = name;
    told.digest = identity::digest(&identity::of_documents(&first, Algorithm::default(), step)?)?;
    drop(first);

    let mut file = Output::open(output)?;
    let threads = arguments
        .threads
        .map_or_else(|| std::thread::available_parallelism().map_or(1, usize::from), usize::from);
    let bar = print::bar(u64::from(count), "{bar:40} {percent:>3}%  {pos} of {len} runs  {eta} left")?;
    let (started, mut noted, mut seen) = (Instant::now(), Instant::now(), Vec::new());
    let points = (0..runs.seeds.len()).collect();
    let all = in_threads(&Arc::new(runs), points, threads, interrupt.flag(), |done| {
        seen.extend(done);
        bar.set_position(seen.len() as u64);
        if bar.is_hidden() && print::is_due(&mut noted, Instant::now()) {
            note!("{} of {count} runs", seen.len());
        }
        Ok::<_, anyhow::Error>(())
    })?;
    bar.finish_and_clear();
    if !all {
        return Err(Interrupted::given_up().into());
    }
    seen.sort_by_key(|(seed, _)| *seed);
    let mut done = Vec::new();
    for (seed, run) in seen {
        match run {
            Ok(run) => done.push(run),
            // One that stands for all.
            Err(error) if count == 1 => return Err(error),
            Err(error) => told.failed.push((seed, full_message(&error))),
        }
    }
    if done.is_empty() {
        bail!("none of the {count} runs succeeded: {}", told.failed[0].1);
    }
    let report = Report::of(&told, &done);
    let bytes = if is_pdf { pdf(&report)? } else { html(&report).into_bytes() };
    interrupt.check()?;
    file.fill(|out| out.write_all(&bytes))?;
    file.persist()?;
    say!("runs               {:>10}     ({} failed)", count, told.failed.len())?;
    report.notices.iter().try_for_each(|notice| say!("{notice}"))?;
    say!("wall time          {:>10.3} s   ({threads} at once)", started.elapsed().as_secs_f64())?;
    Ok(say!("report             {}", output.display())?)
}

/// Returns the keys of a TOML text, with their values; those of the tables of a list are counted from 0.
fn flat(text: &str) -> Vec<(String, String)> {
    fn add(key: &str, value: &toml::Value, rows: &mut Vec<(String, String)>) {
        let below = |name: &str| if key.is_empty() { name.to_owned() } else { format!("{key}.{name}") };
        match value {
            toml::Value::Table(table) => {
                table.iter().for_each(|(name, value)| add(&below(name), value, rows))
            }
            toml::Value::Array(all) if all.iter().any(toml::Value::is_table) => {
                all.iter().enumerate().for_each(|(k, value)| add(&format!("{key}[{k}]"), value, rows));
            }
            value => {
                let text = value.to_string();
                // A corner for each metre of a room would fill pages.
                let cut = text.char_indices().nth(300).map(|(place, _)| format!("{} …", &text[..place]));
                rows.push((key.to_owned(), cut.unwrap_or(text)));
            }
        }
    }
    let mut rows = Vec::new();
    let table = toml::from_str(text).map(toml::Value::Table);
    table.iter().for_each(|table| add("", table, &mut rows));
    rows
}
