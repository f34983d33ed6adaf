//! `lemons check`: all that is wrong with a Trial at once.

use crate::error::{TrialHasErrors, said};
use crate::tell;
use crate::words;
use anyhow::{Context, Result};
use crowd_mechanics::setup::{Setup, doubts_of_drive};
use lemons_core::plane::Vec2;
use lemons_core::trial::DRIVE_FILE;
use lemons_core::trial::Problems;
use lemons_core::trial::Trial;
use lemons_decision::{Plan, WISHES_FILE};
use lemons_master::{Given, Warning, plan_of};
use std::io::{self, Write};
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
    let mut out = tell::out();
    let mut broken = false;
    for path in &arguments.trials {
        let given = match Given::open(path) {
            Ok(given) => given,
            Err(error) => {
                broken = true;
                writeln!(out, "{}", said(&error.into()))?;
                continue;
            }
        };
        match given.read() {
            Ok((trial, warnings)) => {
                print(&mut out, &warnings)?;
                let wishes = given.wishes();
                let plan = wishes
                    .as_deref()
                    .map(|wishes| plan_of(&trial, wishes).with_context(|| wishes.display().to_string()));
                let (plan, wished) = match plan.transpose() {
                    Ok(plan) => (plan, Ok(())),
                    Err(error) => (None, Err(error)),
                };
                let doubts: Vec<String> = plan
                    .iter()
                    .flat_map(|plan| [hurried(plan), unmoved(plan), unused(&trial)])
                    .flatten()
                    .collect();
                for doubt in &doubts {
                    writeln!(out, "warning: {}: {doubt}", path.join(WISHES_FILE).display())?;
                }
                let driven = given.drive(&trial);
                let parameters = &trial.parameters;
                let missed = driven.as_ref().map(|drive| drive.missed(0.0, parameters.time_step));
                let missed = missed.ok().flatten();
                let drive_doubts = driven.as_ref().map(doubts_of_drive).unwrap_or_default();
                for doubt in &drive_doubts {
                    writeln!(out, "warning: {}: {doubt}", path.join(DRIVE_FILE).display())?;
                }
                if wishes.is_some() && given.directory().join(DRIVE_FILE).exists() {
                    let plan = path.join(WISHES_FILE);
                    writeln!(out, "{}", words::warned(&Warning::DriveOfWalkers { plan }))?;
                }
                if let Some(missed) = &missed {
                    let file = path.join(DRIVE_FILE);
                    let missed = words::missed(missed, "TimeStep");
                    writeln!(out, "warning: {}: {missed}", file.display())?;
                }
                if let (Ok(drive), None) = (&driven, &missed)
                    && let (between @ 1.., of) = drive.between(0.0, parameters.time_step)
                {
                    let file = path.join(DRIVE_FILE);
                    writeln!(
                        out,
                        "note: {}: {between} of {of} rows are between communication points: the drive is interpolated at \
                         each point and held until the next, so results depend on TimeStep",
                        file.display()
                    )?;
                }
                let mut errors = 0;
                if let Err(error) = wished {
                    errors += 1;
                    // A zip is unpacked elsewhere.
                    writeln!(out, "{}", given.under_its_name(&format!("{error:#}")))?;
                }
                if let Err(problems) = driven {
                    errors += problems.errors().count();
                    print(&mut out, &problems)?;
                }
                if errors > 0 {
                    broken = true;
                    say_errors(&mut out, path, errors)?;
                    continue;
                }
                if let Some(about) = about_step(&trial) {
                    writeln!(out, "note: {}: {about}", path.join("Parameters.xml").display())?;
                }
                writeln!(
                    out,
                    "{}: {}, {}, TimeStep {:?} s, TimeStepMechanical {:?} s: {}",
                    path.display(),
                    counted(trial.agents.len(), "agent"),
                    counted(trial.geometry.walls.len(), "wall"),
                    parameters.time_step,
                    parameters.time_step_mechanical,
                    match warnings.iter().count()
                        + usize::from(missed.is_some())
                        + doubts.len()
                        + drive_doubts.len()
                    {
                        0 => "no problem".to_owned(),
                        1 => "1 warning".to_owned(),
                        n => format!("{n} warnings"),
                    }
                )?;
            }
            Err(problems) => {
                broken = true;
                print(&mut out, &problems)?;
                say_errors(&mut out, path, problems.errors().count())?;
            }
        }
    }
    if broken { Err(TrialHasErrors.into()) } else { Ok(()) }
}

/// \[m/s\] Nobody walks so fast; numbers of km/h are mostly above it.
const FASTEST: f64 = 3.0;

/// Who wants to be faster than people are.
fn hurried(plan: &Plan) -> Option<String> {
    let fast = || plan.agents.iter().filter(|agent| agent.walker.desired_speed > FASTEST);
    let first = fast().next()?;
    let (speed, id) = (first.walker.desired_speed, &first.id);
    let others = match fast().count() {
        1 => String::new(),
        n => format!(", and {} others more than {FASTEST:?} m/s", n - 1),
    };
    Some(format!(
        "agent {id:?} wants {speed:?} m/s{others}: people walk at 0.5 to 2 m/s, and run at 3 to 5 m/s"
    ))
}

/// Whose force and torque are replaced by those with which people walk.
fn unused(trial: &Trial) -> Option<String> {
    let pushed = trial.dynamics.iter().map(|dynamics| dynamics.fp != Vec2::ZERO || dynamics.mp != 0.0);
    let mut pushed = trial.agents.iter().zip(pushed).filter(|(_, pushed)| *pushed);
    let (first, _) = pushed.next()?;
    let others = match pushed.count() {
        0 => String::new(),
        n => format!(" and {n} more"),
    };
    Some(format!(
        "Fp and Mp in AgentDynamics.xml of agent {:?}{others} are not used, because people walk; forces of a {DRIVE_FILE} \
         would be added",
        first.id
    ))
}

/// Who cannot walk: the force with which people walk is proportional to FloorDamping.
fn unmoved(plan: &Plan) -> Option<String> {
    let unmoved = || plan.agents.iter().filter(|agent| agent.walker.floor_damping == 0.0);
    let (first, count) = (unmoved().next()?, unmoved().count());
    Some(format!(
        "{count} of {} agents cannot walk (first {:?}): FloorDamping=\"0\" in Agents.xml, and the force with which they \
         walk is Mass · FloorDamping · speed",
        plan.agents.len(),
        first.id
    ))
}

fn say_errors(out: &mut impl Write, path: &Path, errors: usize) -> io::Result<()> {
    let noun = if errors == 1 { "error" } else { "errors" };
    writeln!(out, "{}: {errors} {noun}", path.display())
}

/// Up to which mechanical step a Trial is stable, and how accurate its own and another one are. `None` if nothing can
/// touch, since any step is exact then.
fn about_step(trial: &Trial) -> Option<String> {
    let steps = Setup::of(trial).steps()?;
    let own = trial.parameters.time_step_mechanical;
    let stable = steps.stable();
    let told = if own < stable {
        format!(
            "TimeStepMechanical {own:e} s: stable (up to {stable:.1e} s), with an error of about {} in a collision",
            length(steps.error(own))
        )
    } else {
        format!("TimeStepMechanical {own:e} s: not stable (up to {stable:.1e} s)")
    };
    let usual = steps.accurate_to(USUAL_ACCURACY);
    let usual = usual
        .map(|step| format!("; a step of {step:e} s has an error of about {}", length(USUAL_ACCURACY)))
        .unwrap_or_default();
    Some(format!("{told}{usual}"))
}

/// A length \[m\] in its usual unit.
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

fn print(out: &mut impl Write, problems: &Problems) -> io::Result<()> {
    problems.iter().try_for_each(|problem| writeln!(out, "{problem}"))
}
