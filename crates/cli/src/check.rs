//! `lemons check`: all that is wrong with a Trial at once.

pub mod walking;

use crate::error::{TrialHasErrors, full_message};
use anyhow::{Context, Result};
use crowd_mechanics::setup::{Setup, doubts_of_drive};
use lemons_core::files::words::shortened;
use lemons_core::plane::Vec2;
use lemons_core::trial::{AgentDynamics, DRIVE_FILE, Parameters, Problems, Trial};
use lemons_decision::balance::Balance;
use lemons_decision::plan::Planned;
use lemons_decision::target::Destination;
use lemons_decision::{DECISION_FILE, Plan};
use lemons_master::{TrialInput, notes, plan_of};
use std::path::{Path, PathBuf};

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
        let (lines, summary) = match TrialInput::open(path) {
            Ok(given) => report(&given),
            Err(error) => (vec![full_message(&error.into())], None),
        };
        lines.iter().try_for_each(|line| say!("{}", shortened(line)))?;
        match summary {
            Some(summary) => say!("{}: {summary}", path.display())?,
            None => sound = false,
        }
    }
    if sound { Ok(()) } else { Err(TrialHasErrors.into()) }
}

/// Returns what is found in a Trial, and the summary of one without errors.
fn report(given: &TrialInput) -> (Vec<String>, Option<String>) {
    let errors_of = |problems: &Problems| problems.errors().count();
    let texts_of = |problems: &Problems| problems.iter().map(ToString::to_string).collect::<Vec<_>>();
    let number_of = |errors: usize| format!("{}: {}", given.path().display(), counted(errors, "error"));
    let (trial, problems) = match given.read() {
        Ok(read) => read,
        Err(problems) => {
            let mut lines = texts_of(&problems);
            lines.push(number_of(errors_of(&problems)));
            return (lines, None);
        }
    };
    let mut lines = texts_of(&problems);
    let [plan_file, drive_file] = [DECISION_FILE, DRIVE_FILE].map(|name| given.path().join(name));
    let found = |kind: &str, file: &Path, text: &str| format!("{kind}: {}: {text}", file.display());
    let wishes = given.wishes();
    let plan_of = |wishes: &Path| plan_of(&trial, wishes).with_context(|| wishes.display().to_string());
    let plan = wishes.as_deref().map(plan_of).transpose();
    if let Ok(Some(plan)) = &plan {
        lines.extend(doubts_of_plan(plan, &trial).iter().map(|doubt| found(WARNING, &plan_file, doubt)));
        lines.extend(walking::flat_push(plan).map(|text| found(NOTE, &plan_file, &format!("push: {text}"))));
        let out_of_reach = walking::out_of_reach(plan, &trial.geometry);
        lines.extend(out_of_reach.iter().map(|doubt| found(WARNING, &plan_file, doubt)));
        lines.extend(walking::doubts(plan).iter().map(|(kind, doubt)| found(kind, &plan_file, doubt)));
    }
    let Parameters { time_step, time_step_mechanical, .. } = trial.parameters;
    let drive = given.drive(&trial);
    let doubts = drive.iter().flat_map(doubts_of_drive);
    lines.extend(doubts.map(|doubt| found(WARNING, &drive_file, &doubt)));
    if wishes.is_some() && given.directory().join(DRIVE_FILE).exists() {
        lines.push(format!("{NOTE}: {} (--no-drive: only these)", notes::drive_of_walkers(&plan_file)));
    }
    if let Ok(drive) = &drive {
        match (drive.missed(0.0, time_step), drive.between(0.0, time_step)) {
            (Some(missed), _) => lines.push(found(WARNING, &drive_file, &notes::missed(&missed, "TimeStep"))),
            (None, (between @ 1.., of)) => {
                let text = format!(
                    "{between} of {of} rows are between communication points: the drive is interpolated at each \
                     point and held until the next, so results depend on TimeStep"
                );
                lines.push(found(NOTE, &drive_file, &text));
            }
            _ => {}
        }
    }
    let mut errors = 0;
    if let Err(error) = plan {
        // A zip is unpacked elsewhere.
        lines.push(given.under_its_name(&format!("{error:#}")));
        errors += 1;
    }
    if let Err(problems) = drive {
        lines.extend(texts_of(&problems));
        errors += errors_of(&problems);
    }
    if errors > 0 {
        lines.push(number_of(errors));
        return (lines, None);
    }
    let warnings = lines.iter().filter(|line| !line.starts_with("note: ")).count();
    let about = about_step(&trial);
    lines.extend(about.map(|about| found(NOTE, &given.path().join("Parameters.xml"), &about)));
    let summary = format!(
        "{}, {}, TimeStep {time_step:?} s, TimeStepMechanical {time_step_mechanical:?} s: {}",
        counted(trial.agents.len(), "agent"),
        counted(trial.geometry.walls.len(), "wall"),
        if warnings == 0 { "no problem".to_owned() } else { counted(warnings, "warning") }
    );
    (lines, Some(summary))
}

/// Beginnings of lines: of what is probably not meant, and of what may be meant.
const WARNING: &str = "warning";
const NOTE: &str = "note";

/// \[m/s\] Nobody walks so fast; numbers of km/h are mostly above it.
const FASTEST: f64 = 3.0;

/// Doubts those who want to be faster than people are, those who cannot walk, and forces that are not used.
fn doubts_of_plan(plan: &Plan, trial: &Trial) -> Vec<String> {
    let mut doubts = Vec::new();
    let speed = |agent: &Planned| agent.walker.desired_speed;
    let fast: Vec<&Planned> = plan.agents.iter().filter(|agent| speed(agent) > FASTEST).collect();
    if let [first, others @ ..] = &fast[..] {
        let others = match others.len() {
            0 => String::new(),
            n => format!(", and {n} others more than {FASTEST:?} m/s"),
        };
        doubts.push(format!(
            "agent {:?} wants {:?} m/s{others}: people walk at 0.5 to 2 m/s, and run at 3 to 5 m/s",
            first.id,
            speed(first)
        ));
    }
    // The force with which people walk is proportional to FloorDamping.
    let unmoved: Vec<&Planned> =
        plan.agents.iter().filter(|agent| agent.walker.floor_damping == 0.0).collect();
    let goes =
        |agent: &&&Planned| !agent.walker.waypoints.is_empty() || agent.destination != Destination::None;
    if let Some(first) = unmoved.iter().find(goes) {
        doubts.push(format!(
            "{} of {} agents cannot walk (first {:?}): FloorDamping=\"0\" in Agents.xml, and the force with which they walk \
             is Mass · FloorDamping · speed",
            unmoved.iter().filter(goes).count(),
            plan.agents.len(),
            first.id
        ));
    }
    doubts.extend(doubts_of_legs(plan, &unmoved));
    let is_pushed = |dynamics: &AgentDynamics| dynamics.fp != Vec2::zeros() || dynamics.mp != 0.0;
    let pushed = trial.agents.iter().zip(&trial.dynamics).filter(|(_, dynamics)| is_pushed(dynamics));
    let pushed: Vec<&str> = pushed.map(|(agent, _)| agent.id.as_str()).collect();
    if let [first, others @ ..] = &pushed[..] {
        let others = match others.len() {
            0 => String::new(),
            n => format!(" and {n} more"),
        };
        doubts.push(format!(
            "Fp and Mp in AgentDynamics.xml of agent {first:?}{others} are not used, because people walk; forces of a \
             {DRIVE_FILE} would be added"
        ));
    }
    doubts
}

/// Doubts legs of people who do not try to stand still, and communication steps in which legs act too late.
fn doubts_of_legs(plan: &Plan, unmoved: &[&Planned]) -> Vec<String> {
    // The pendulum's ankles have a rate of their own.
    let by_floor = matches!(plan.balance, Some(Balance::TwoLevel(_)));
    let idle = unmoved.first().filter(|_| by_floor).map(|first| {
        let id = &first.id;
        format!("agent {id:?} has legs and FloorDamping=\"0\" in Agents.xml: it does not try to stand still")
    });
    idle.into_iter().chain(late_legs(plan, plan.time_step)).collect()
}

/// Doubts a communication step \[s\] in which legs act too late.
pub fn late_legs(plan: &Plan, step: f64) -> Option<String> {
    let damping = plan.agents.iter().map(|agent| agent.walker.floor_damping).fold(0.0, f64::max);
    let longest = plan.balance?.longest_step(damping);
    (step > longest * (1.0 + 1e-9)).then(|| {
        format!(
            "communication step {step:?} s: legs act once in a step; with more than {longest:.3} s they act too late \
             (--step; TimeStep in Parameters.xml)"
        )
    })
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
