//! `lemons decide`: a Trial and its people's wishes -> a Decision FMU.

use crate::binary::DECISION;
use crate::files::{self, Force, WISHES_FILE};
use crate::pack::{Fmi, FmuArguments, say_size};
use crate::words::read_or_say;
use anyhow::{Context, Result, bail};
use lemons_decision::rule::Pose;
use lemons_decision::{Person, Plan, Wishes};
use lemons_files::input;
use lemons_master::Given;
use lemons_trial::Trial;
use std::path::{Path, PathBuf};

/// Wishes of everybody, as short as they can be.
const SHORTEST: &str = "  desired_speed = 1.34
  waypoints = [{ x = 6.0, y = 2.5 }]";

const WISHES: &str = "\
The file decision.toml: first the values for all agents, then those for single \
agents, by their Id in Agents.xml. An agent walks to its way-points one after the \
other. It has reached one when the distance is at most its radius.

  desired_speed = 1.34    # m/s; default 1.34
  waypoints = [           # m; default of radius 0.3
    { x = 6.0, y = 2.5, radius = 0.45 },
    { x = 20.0, y = 2.5 },
  ]

  [agents.7]              # overrides the values for all agents
  desired_speed = 0.9
  waypoints = [{ x = 0.0, y = 1.0 }]";

#[derive(clap::Args)]
#[command(after_help = WISHES)]
pub struct Arguments {
    /// The Trial whose people are driven: its directory, or a zip of it
    #[arg(value_name = "TRIAL")]
    trial: PathBuf,
    /// File with way-points and desired speeds. Default: decision.toml in the Trial's directory
    #[arg(long, value_name = "FILE.toml")]
    plan: Option<PathBuf>,
    /// The FMU to write
    #[arg(short, long, value_name = "FILE.fmu")]
    output: PathBuf,
    #[command(flatten)]
    fmi: Fmi,
    #[command(flatten)]
    fmu: FmuArguments,
    #[command(flatten)]
    _force: Force,
}

pub fn decide(arguments: &Arguments) -> Result<()> {
    let mut file = files::stage(&arguments.output)?;
    let given = Given::open(&arguments.trial)?;
    let (trial, warnings) = read_or_say(&given)?;
    for warning in warnings.iter() {
        note!("{warning}");
    }
    let plan = wanted(&arguments.trial, &trial, arguments.plan.as_deref())?;
    let binaries = arguments.fmu.binaries(&DECISION)?;
    let unwritten = || format!("cannot write {}", arguments.output.display());
    lemons_decision::pack::write_fmu(
        &plan,
        arguments.fmi.format(arguments.fmu.naming()),
        &binaries,
        &mut file,
    )
    .with_context(|| arguments.output.display().to_string())?;
    file.persist().with_context(unwritten)?;
    say_size(&arguments.output)
}

/// What the people of a Trial do by the wishes in a file; by default, that of the Trial's directory as it was `given`.
fn wanted(given: &Path, trial: &Trial, plan: Option<&Path>) -> Result<Plan> {
    let own = trial.directory.join(WISHES_FILE);
    let (path, named) = plan.map_or((&*own, given.join(WISHES_FILE)), |plan| (plan, plan.to_owned()));
    if plan.is_none() && !path.exists() {
        bail!(
            "there is no {}. Write it, or name another file with --plan FILE.toml. The shortest such file is:\n{SHORTEST}",
            named.display()
        );
    }
    plan_of(trial, path).with_context(|| named.display().to_string())
}

/// What the people of a Trial do by the wishes in a file.
pub fn plan_of(trial: &Trial, path: &Path) -> Result<Plan> {
    // What lies in the Trial is not a pipe on purpose.
    let own = trial.directory.join(WISHES_FILE) == path;
    let read = if own { input::read_text } else { input::read_given_text };
    let text = read(path, input::LARGEST_SETTINGS).context("cannot be read")?;
    let wishes = Wishes::from_toml(&text)?;
    Ok(Plan::new(&people(trial), &wishes, trial.parameters.time_step)?)
}

/// What a decision needs to know of a Trial's agents.
fn people(trial: &Trial) -> Vec<Person> {
    let agents = trial.agents.iter().zip(&trial.dynamics);
    agents
        .map(|(agent, dynamics)| Person {
            id: agent.id.clone(),
            mass: agent.mass,
            moment_of_inertia: agent.moment_of_inertia,
            floor_damping: agent.floor_damping,
            angular_damping: agent.angular_damping,
            pose: Pose { x: dynamics.position.x, y: dynamics.position.y, theta: dynamics.theta },
        })
        .collect()
}
