//! `lemons check`: all that is wrong with a Trial at once.

mod walking;

use crate::error::{TrialHasErrors, full_message};
use anyhow::{Context, Result};
use crowd_mechanics::setup::{Setup, doubts_of_drive};
use lemons_core::plane::Vec2;
use lemons_core::trial::{Agent, DRIVE_FILE, Problems, Trial};
use lemons_decision::{DECISION_FILE, Plan};
use lemons_master::{TrialInput, notes, plan_of};
use std::fmt::Display;
use std::path::{Path, PathBuf};
use walking::Doubt;

/// \[m\] For which `check` names a step.
const USUAL_ACCURACY: f64 = 1e-4;

#[derive(clap::Args)]
pub struct Arguments {
    /// Trials to check: directories, or zips of them
    #[arg(required = true, value_name = "TRIAL")]
    trials: Vec<PathBuf>,
}

pub fn check(arguments: &Arguments) -> Result<()> {
    let mut sound = true;
    for path in &arguments.trials {
        let Report { lines, errors, summary } = match TrialInput::open(path) {
            Ok(given) => report(&given),
            Err(error) => {
                say!("{}", full_message(&error.into()))?;
                sound = false;
                continue;
            }
        };
        lines.iter().try_for_each(|line| say!("{line}"))?;
        sound &= errors == 0;
        match errors {
            0 => say!("{}: {summary}", path.display())?,
            errors => say!("{}: {}", path.display(), counted(errors, "error"))?,
        }
    }
    if sound { Ok(()) } else { Err(TrialHasErrors.into()) }
}

/// Findings about a Trial.
#[derive(Default)]
struct Report {
    lines: Vec<String>,
    errors: usize,
    /// Summary of a Trial without errors.
    summary: String,
}

impl Report {
    fn add_problems(&mut self, problems: &Problems) {
        self.lines.extend(problems.iter().map(ToString::to_string));
        self.errors += problems.errors().count();
    }

    fn warn(&mut self, file: &Path, text: impl Display) {
        self.lines.push(format!("warning: {}: {text}", file.display()));
    }

    fn note(&mut self, file: &Path, text: impl Display) {
        self.lines.push(format!("{NOTE}{}: {text}", file.display()));
    }
}

/// Beginning of a line that is no warning.
const NOTE: &str = "note: ";

fn report(given: &TrialInput) -> Report {
    let mut report = Report::default();
    let (trial, problems) = match given.read() {
        Ok((trial, warnings)) => (Some(trial), warnings),
        Err(problems) => (None, problems),
    };
    report.add_problems(&problems);
    let Some(trial) = trial else { return report };
    let [plan_file, drive_file] = [DECISION_FILE, DRIVE_FILE].map(|name| given.path().join(name));
    let wishes = given.wishes();
    let plan_of = |wishes: &Path| plan_of(&trial, wishes).with_context(|| wishes.display().to_string());
    let plan = wishes.as_deref().map(plan_of).transpose();
    if let Ok(Some(plan)) = &plan {
        let doubts = [hurried(plan), unmoved(plan), unused(&trial)].into_iter().flatten();
        doubts.for_each(|doubt| report.warn(&plan_file, doubt));
        for doubt in walking::doubts(plan) {
            match doubt {
                Doubt::Warning(text) => report.warn(&plan_file, text),
                Doubt::Note(text) => report.note(&plan_file, text),
            }
        }
    }
    let parameters = &trial.parameters;
    let drive = given.drive(&trial);
    let doubts = drive.iter().flat_map(doubts_of_drive);
    doubts.for_each(|doubt| report.warn(&drive_file, doubt));
    if wishes.is_some() && given.directory().join(DRIVE_FILE).exists() {
        let added = notes::drive_of_walkers(&plan_file);
        report.lines.push(format!("note: {added} (--no-drive: only these)"));
    }
    if let Ok(drive) = &drive {
        match (drive.missed(0.0, parameters.time_step), drive.between(0.0, parameters.time_step)) {
            (Some(missed), _) => report.warn(&drive_file, notes::missed(&missed, "TimeStep")),
            (None, (between @ 1.., of)) => report.note(
                &drive_file,
                format!(
                    "{between} of {of} rows are between communication points: the drive is interpolated at each \
                     point and held until the next, so results depend on TimeStep"
                ),
            ),
            _ => {}
        }
    }
    if let Err(error) = plan {
        // A zip is unpacked elsewhere.
        report.lines.push(given.under_its_name(&format!("{error:#}")));
        report.errors += 1;
    }
    if let Err(problems) = drive {
        report.add_problems(&problems);
    }
    let warnings = report.lines.iter().filter(|line| !line.starts_with(NOTE)).count();
    if report.errors == 0
        && let Some(about) = about_step(&trial)
    {
        report.note(&given.path().join("Parameters.xml"), about);
    }
    report.summary = format!(
        "{}, {}, TimeStep {:?} s, TimeStepMechanical {:?} s: {}",
        counted(trial.agents.len(), "agent"),
        counted(trial.geometry.walls.len(), "wall"),
        parameters.time_step,
        parameters.time_step_mechanical,
        if warnings == 0 { "no problem".to_owned() } else { counted(warnings, "warning") }
    );
    report
}

/// \[m/s\] Nobody walks so fast; numbers of km/h are mostly above it.
const FASTEST: f64 = 3.0;

/// Doubts those who want to be faster than people are.
fn hurried(plan: &Plan) -> Option<String> {
    let mut fast = plan.agents.iter().filter(|agent| agent.walker.desired_speed > FASTEST);
    let first = fast.next()?;
    let (speed, id) = (first.walker.desired_speed, &first.id);
    let others = match fast.count() {
        0 => String::new(),
        n => format!(", and {n} others more than {FASTEST:?} m/s"),
    };
    Some(format!(
        "agent {id:?} wants {speed:?} m/s{others}: people walk at 0.5 to 2 m/s, and run at 3 to 5 m/s"
    ))
}

/// Doubts forces and torques that are replaced by those with which people walk.
fn unused(trial: &Trial) -> Option<String> {
    let pushed = trial.agents.iter().zip(&trial.dynamics);
    let mut pushed = pushed.filter(|(_, dynamics)| dynamics.fp != Vec2::ZERO || dynamics.mp != 0.0);
    let (Agent { id, .. }, _) = pushed.next()?;
    let others = match pushed.count() {
        0 => String::new(),
        n => format!(" and {n} more"),
    };
    Some(format!(
        "Fp and Mp in AgentDynamics.xml of agent {id:?}{others} are not used, because people walk; forces of a \
         {DRIVE_FILE} would be added"
    ))
}

/// Doubts those who cannot walk: the force with which people walk is proportional to FloorDamping.
fn unmoved(plan: &Plan) -> Option<String> {
    let mut unmoved = plan.agents.iter().filter(|agent| agent.walker.floor_damping == 0.0);
    let first = &unmoved.next()?.id;
    let (count, all) = (1 + unmoved.count(), plan.agents.len());
    Some(format!(
        "{count} of {all} agents cannot walk (first {first:?}): FloorDamping=\"0\" in Agents.xml, and the force with \
         which they walk is Mass · FloorDamping · speed"
    ))
}

/// Says up to which mechanical step a Trial is stable, and how accurate its own and another one are. `None` if nothing can
/// touch, since any step is exact then.
fn about_step(trial: &Trial) -> Option<String> {
    let steps = Setup::of(trial).steps()?;
    let own = trial.parameters.time_step_mechanical;
    let stable = steps.stable();
    let (not, error) = if own < stable {
        ("", format!(", with an error of about {} in a collision", length(steps.error(own))))
    } else {
        ("not ", String::new())
    };
    let usual = steps.accurate_to(USUAL_ACCURACY).map_or(String::new(), |step| {
        format!("; a step of {step:e} s has an error of about {}", length(USUAL_ACCURACY))
    });
    Some(format!("TimeStepMechanical {own:e} s: {not}stable (up to {stable:.1e} s){error}{usual}"))
}

/// Writes a length \[m\] in its usual unit.
fn length(metres: f64) -> String {
    let (unit, factor) = [("m", 1.0), ("mm", 1e3), ("µm", 1e6)]
        .into_iter()
        .find(|(_, factor)| metres * factor >= 0.1)
        .unwrap_or(("nm", 1e9));
    let number = format!("{:.1e}", metres * factor).parse().unwrap_or(metres * factor);
    format!("{number} {unit}")
}

fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}
