//! Findings of the rules of [`lemons_core::rule`] where people walk, in a drive, and at the end of a run. What they find in
//! the files of a Trial, its reader tells ([`crowd_mechanics::setup::read`]).

mod end;
mod walking;

pub use end::RunEnd;

use crate::Documents;
use crowd_mechanics::setup::{Setup, doubts_of_drive};
use lemons_core::message::{Message, message};
use lemons_core::plane::Vec2;
use lemons_core::rule::sentences::*;
use lemons_core::trial::{
    Agent, AgentDynamics, DRIVE_FILE, DriveChoice, DriveTable, Parameters, Problem, Rule, Trial,
};
use lemons_decision::balance::BalanceModel;
use lemons_decision::plan::Planned;
use lemons_decision::rule::UNLIMITED;
use lemons_decision::target::Destination;
use lemons_decision::{DECISION_FILE, Plan};
use std::path::{Path, PathBuf};

/// \[m/s\] Nobody walks so fast; numbers of km/h are mostly above it.
const FASTEST: f64 = 3.0;
/// \[m\] For which a step is named.
const USUAL_ACCURACY: f64 = 1e-4;

/// The files of documents, as their user knows them.
#[derive(Debug, Clone)]
pub struct Files {
    /// decision.toml
    pub decision: PathBuf,
    /// drive.csv
    pub drive: PathBuf,
}

impl Files {
    /// Those in a directory.
    pub fn within(directory: &Path) -> Files {
        Files { decision: directory.join(DECISION_FILE), drive: directory.join(DRIVE_FILE) }
    }

    /// Those that were chosen for the Trial in a directory.
    pub fn chosen(directory: &Path, drive: &DriveChoice, decision: Option<&Path>) -> Files {
        let own = Files::within(directory);
        let drive = if let DriveChoice::File(path) = drive { path.clone() } else { own.drive };
        Files { decision: decision.map_or(own.decision, Path::to_owned), drive }
    }
}

/// Returns what is found in documents, whatever the communication step is.
pub fn of_documents(documents: &Documents, files: &Files) -> Vec<Problem> {
    let Documents { trial, drive, plan } = documents;
    let mut found = plan.as_ref().map_or_else(Vec::new, |plan| of_plan(plan, trial, &files.decision));
    let unusual = doubts_of_drive(drive).into_iter();
    found.extend(unusual.map(|message| Problem::by(Rule::Unusual, &files.drive, message)));
    if plan.is_some() && drive.end().is_some() {
        found.push(Problem::by(Rule::DriveAdded, &files.decision, Rule::DriveAdded.message()));
    }
    found
}

/// Returns what is found where people of a Trial walk by a file.
pub fn of_plan(plan: &Plan, trial: &Trial, file: &Path) -> Vec<Problem> {
    let limited = plan.agents.iter().any(|agent| agent.walker.push < UNLIMITED)
        || plan.motivation.iter().any(|change| change.push.is_some());
    let flat = (limited && plan.queues()).then(|| message!(PUSH, finding = Rule::FlatPush.message()));
    let found = of_people(plan, trial).into_iter().chain(flat.map(|flat| (Rule::FlatPush, flat)));
    let found = found.chain(walking::out_of_reach(plan, &trial.geometry)).chain(walking::unfit(plan));
    found.map(|(rule, message)| Problem::by(rule, file, message)).collect()
}

/// Returns what is found in documents for a communication step \[s\].
pub fn of_step(documents: &Documents, step: f64, files: &Files) -> Vec<Problem> {
    let late = documents.plan.as_ref().and_then(|plan| late_legs(plan, step, &files.decision));
    late.into_iter().chain(missed(&documents.drive, 0.0, step, &files.drive)).collect()
}

/// Says how accurate the steps of a Trial in a directory are: what `lemons check` notes besides.
pub fn of_accuracy(documents: &Documents, directory: &Path, files: &Files) -> Vec<Problem> {
    let Documents { trial, drive, .. } = documents;
    let step = trial.parameters.time_step;
    let rows = match (drive.missed(0.0, step), drive.between(0.0, step)) {
        (None, (between @ 1.., of)) => {
            Some(Problem::by(Rule::RowsBetween, &files.drive, message!(ROWS_BETWEEN, between, of)))
        }
        _ => None,
    };
    let file = directory.join("Parameters.xml");
    let accuracy = accuracy(trial).map(|message| Problem::by(Rule::Accuracy, &file, message));
    rows.into_iter().chain(accuracy).collect()
}

/// Finds those who want to be faster than people are, those who cannot walk or stand, and forces that are not used.
fn of_people(plan: &Plan, trial: &Trial) -> Vec<(Rule, Message)> {
    let mut found = Vec::new();
    let speed = |agent: &Planned| agent.walker.desired_speed;
    let mut fast = plan.agents.iter().filter(|agent| speed(agent) > FASTEST);
    if let Some(first) = fast.next() {
        let others = some(fast.count()).map(|count| message!(OTHERS_FASTER, count, fastest = FASTEST));
        found.push((Rule::TooFast, message!(TOO_FAST, agent = &first.id, speed = speed(first), others)));
    }
    // The force with which people walk is proportional to FloorDamping.
    let unmoved: Vec<&Planned> =
        plan.agents.iter().filter(|agent| agent.walker.floor_damping == 0.0).collect();
    let goes =
        |agent: &&&Planned| !agent.walker.waypoints.is_empty() || agent.destination != Destination::None;
    if let Some(first) = unmoved.iter().find(goes) {
        let (count, all) = (unmoved.iter().filter(goes).count(), plan.agents.len());
        found.push((Rule::CannotWalk, message!(CANNOT_WALK, count, all, agent = &first.id)));
    }
    // The pendulum's ankles have a rate of their own.
    if let (Some(BalanceModel::TwoLevel(_)), Some(first)) = (plan.balance, unmoved.first()) {
        found.push((Rule::LegsIdle, message!(LEGS_IDLE, agent = &first.id)));
    }
    let is_pushed = |dynamics: &AgentDynamics| dynamics.fp != Vec2::zeros() || dynamics.mp != 0.0;
    let mut pushed = trial.agents.iter().zip(&trial.dynamics).filter(|(_, dynamics)| is_pushed(dynamics));
    if let Some((Agent { id: agent, .. }, _)) = pushed.next() {
        let others = some(pushed.count()).map(|count| message!(AND_OTHERS, count));
        found.push((Rule::ForcesUnused, message!(FORCES_UNUSED, agent, others)));
    }
    found
}

/// How many others there are, if there are some.
fn some(others: usize) -> Option<usize> {
    Some(others).filter(|count| *count > 0)
}

/// Finds legs that act too late with a communication step \[s\].
pub fn late_legs(plan: &Plan, step: f64, file: &Path) -> Option<Problem> {
    let damping = plan.agents.iter().map(|agent| agent.walker.floor_damping).fold(0.0, f64::max);
    let longest = plan.balance?.longest_step(damping);
    let message = message!(LEGS_LATE, step, longest);
    (step > longest * (1.0 + 1e-9)).then(|| Problem::by(Rule::LegsLate, file, message))
}

/// Finds rows of a drive that a run from `start` with a communication step, both \[s\], does not apply.
pub fn missed(drive: &DriveTable, start: f64, step: f64, file: &Path) -> Option<Problem> {
    drive.missed(start, step).map(|message| Problem::by(Rule::RowsMissed, file, message))
}

/// Says up to which mechanical step a Trial is stable, and how accurate its own and another one are. `None` if nothing can
/// touch, since any step is exact then.
fn accuracy(trial: &Trial) -> Option<Message> {
    let steps = Setup::of(trial).steps()?;
    let Parameters { time_step_mechanical: own, .. } = trial.parameters;
    let stable = steps.stable();
    let usual = steps.accurate_to(USUAL_ACCURACY);
    let usual = usual.map(|step| message!(ACCURATE_TO, step, error = length(USUAL_ACCURACY)));
    Some(if own < stable {
        message!(ACCURATE, own, stable, error = length(steps.error(own)), usual)
    } else {
        message!(NOT_STABLE, own, stable, usual)
    })
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
