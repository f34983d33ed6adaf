//! `lemons run`: an FMU, stepped like any FMI master would.

use crate::drive::Drive;
use crate::pack::write_fmu;
use crate::results::{Results, Row};
use anyhow::{Context, Result, bail};
use crowd_mechanics::engine::{Pose, State, Twist, World, vec2};
use crowd_mechanics::pack::{DRIVE_FILE, Naming};
use crowd_mechanics::trial::Trial;
use indicatif::{ProgressBar, ProgressStyle};
use lemons_master::{Fmu, Instance, own_binary};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

#[derive(clap::Args)]
pub struct Arguments {
    /// A Trial directory, or an FMU
    #[arg(value_name = "TRIAL or FILE.fmu")]
    input: PathBuf,
    /// How long to simulate, in seconds
    #[arg(long, default_value_t = 5.0, value_name = "SECONDS", value_parser = positive)]
    until: f64,
    /// Communication step, in seconds; default: the Trial's TimeStep
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    step: Option<f64>,
    /// Propulsion over time: CSV with t,agent,Fp.x,Fp.y,Mp, linearly interpolated, zero outside;
    /// agents it does not name keep AgentDynamics.xml's. Default: the Trial's drive.csv, if any
    #[arg(long, value_name = "FILE.csv", conflicts_with = "no_drive")]
    drive: Option<PathBuf>,
    /// Ignore the Trial's drive.csv
    #[arg(long)]
    no_drive: bool,
    /// A parameter, as in: --set contact.human_naked.human_naked.KineticFriction=0.6
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    /// Where the trajectories go
    #[arg(short, long, default_value = "trajectories.csv", value_name = "FILE.csv")]
    output: PathBuf,
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("must be a positive number of seconds".into()),
    }
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let packed = tempfile::TempDir::with_prefix("lemons-").context("cannot make a temporary directory")?;
    let path = if arguments.input.is_dir() {
        let path = packed.path().join("crowd.fmu");
        write_fmu(std::slice::from_ref(&arguments.input), vec![own_binary()?], Naming::Structured, &path)?;
        path
    } else {
        arguments.input.clone()
    };
    let fmu = Fmu::open(&path)?;
    let instance = fmu.instantiate("crowd")?;
    let mut chosen = None;
    for setting in &arguments.settings {
        let (name, value) =
            setting.split_once('=').with_context(|| format!("--set {setting}: expected NAME=VALUE"))?;
        let kind =
            fmu.kind(name).with_context(|| format!("the FMU has no variable {name:?}; see lemons info"))?;
        instance.set(kind, name, value)?;
        if name == "Trial" {
            chosen = Some(value);
        }
    }
    let resources = fmu.resources()?;
    let (trial, _) = resources.load(chosen.unwrap_or(resources.first()))?;
    let drive = drive_of(arguments, &trial)?;
    let step = arguments.step.unwrap_or(trial.parameters.time_step);

    let mut crowd = Crowd::new(&instance, &trial, drive)?;
    instance.initialize()?;
    let mut results = Results::create(&arguments.output)?;
    let started = Instant::now();
    let run = crowd.run(arguments.until, step, &mut results);
    let wall = started.elapsed();
    // What was simulated before a failure is worth having.
    results.finish()?;
    if run.is_ok() {
        instance.terminate()?;
    }
    for warning in instance.warnings() {
        eprintln!("{warning}");
    }
    run.with_context(|| {
        format!("stopped at t = {:?} s; the trajectories until then are written", crowd.time)
    })?;
    crowd.summary(wall, &arguments.output);
    Ok(())
}

fn drive_of(arguments: &Arguments, trial: &Trial) -> Result<Drive> {
    let own = trial.directory.join(DRIVE_FILE);
    let drive = match &arguments.drive {
        Some(path) => Drive::read(path)?,
        None if !arguments.no_drive && own.is_file() => Drive::read(&own)?,
        None => Drive::default(),
    };
    if let Some(unknown) = drive.agents().find(|id| trial.agents.iter().all(|agent| agent.id != *id)) {
        let file = arguments.drive.as_ref().unwrap_or(&own).display();
        bail!("drive file {file}: there is no agent {unknown:?} in Agents.xml");
    }
    Ok(drive)
}

/// The agents of an instance, and what has been seen of them.
struct Crowd<'a> {
    instance: &'a Instance,
    trial: &'a Trial,
    drive: Drive,
    /// For overlaps, which are no variables of the FMU.
    shadow: World,
    inputs: Vec<u32>,
    motions: Vec<u32>,
    contacts: Vec<u32>,
    squeezes: Vec<u32>,
    time: f64,
    largest_overlap: f64,
    greatest_squeeze: f64,
    most_squeezed: Option<(usize, f64)>,
}

const INPUTS: [&str; 3] = ["Fp.x", "Fp.y", "Mp"];
const MOTION: [&str; 6] = ["Position.x", "Position.y", "Velocity.x", "Velocity.y", "Theta", "Omega"];
const CONTACTS: [&str; 3] = ["AgentContacts", "WallContacts", "ContactingAgents"];

impl<'a> Crowd<'a> {
    fn new(instance: &'a Instance, trial: &'a Trial, drive: Drive) -> Result<Self> {
        let references = |names: &[&str], wanted: &dyn Fn(usize) -> bool| -> Result<Vec<u32>> {
            let agents = (0..trial.agents.len()).filter(|&i| wanted(i));
            agents
                .flat_map(|i| names.iter().map(move |name| format!("agent[{i}].{name}")))
                .map(|name| instance.reference(&name))
                .collect()
        };
        let driven = |i: usize| drive.at(&trial.agents[i].id, 0.0).is_some();
        Ok(Crowd {
            inputs: references(&INPUTS, &driven)?,
            motions: references(&MOTION, &|_| true)?,
            contacts: references(&CONTACTS, &|_| true)?,
            squeezes: references(&["NormalForce"], &|_| true)?,
            shadow: trial.world()?,
            instance,
            trial,
            drive,
            time: 0.0,
            largest_overlap: 0.0,
            greatest_squeeze: 0.0,
            most_squeezed: None,
        })
    }

    /// Steps to `until`; the last step is shortened to end there.
    fn run(&mut self, until: f64, step: f64, results: &mut Results) -> Result<()> {
        let steps = (until / step - 1e-9).ceil().max(1.0) as u64;
        let style = ProgressStyle::with_template("{bar:40} {percent:>3}%  {msg}  {eta} left")?;
        let progress = ProgressBar::new(steps).with_style(style);
        self.look(results)?;
        for k in 0..steps {
            let end = if k + 1 == steps { until } else { (k + 1) as f64 * step };
            self.push()?;
            self.instance.step(self.time, end - self.time)?;
            self.time = end;
            self.look(results)?;
            progress.set_message(format!("t = {end:.2} s"));
            progress.inc(1);
        }
        progress.finish_and_clear();
        Ok(())
    }

    /// Sets the inputs of the agents that the drive names.
    fn push(&self) -> Result<()> {
        if self.inputs.is_empty() {
            return Ok(());
        }
        let pushes = self.trial.agents.iter().filter_map(|agent| self.drive.at(&agent.id, self.time));
        let values: Vec<f64> = pushes.flatten().collect();
        self.instance.set_real(&self.inputs, &values)
    }

    /// Reads the outputs, notes the extremes, writes the rows.
    fn look(&mut self, results: &mut Results) -> Result<()> {
        let agents = self.trial.agents.len();
        let mut motions = vec![0.0; self.motions.len()];
        let mut contacts = vec![0; self.contacts.len()];
        let mut squeezes = vec![0.0; agents];
        self.instance.get_real(&self.motions, &mut motions)?;
        self.instance.get_integer(&self.contacts, &mut contacts)?;
        self.instance.get_real(&self.squeezes, &mut squeezes)?;
        let (motions, _) = motions.as_chunks::<6>();
        let (contacts, _) = contacts.as_chunks::<3>();
        for i in 0..agents {
            results.write(&Row {
                time: self.time,
                id: &self.trial.agents[i].id,
                motion: motions[i],
                contacts: contacts[i],
                normal_force: squeezes[i],
            })?;
            if squeezes[i] > self.greatest_squeeze {
                self.greatest_squeeze = squeezes[i];
                self.most_squeezed = Some((i, self.time));
            }
        }
        let poses = motions.iter().map(|m| Pose { position: vec2(m[0], m[1]), orientation: m[4] }).collect();
        let twists =
            motions.iter().map(|m| Twist { velocity: vec2(m[2], m[3]), angular_velocity: m[5] }).collect();
        self.shadow.restore(State::new(poses, twists));
        self.largest_overlap = self.largest_overlap.max(self.shadow.contacts().largest_overlap());
        Ok(())
    }

    fn summary(&self, wall: Duration, output: &Path) {
        let seconds = wall.as_secs_f64();
        println!("simulated time     {:>10.3} s", self.time);
        println!("wall time          {seconds:>10.3} s");
        println!("real-time factor   {:>10.2}", self.time / seconds);
        println!("largest overlap    {:>10.3} mm   (at communication points)", 1e3 * self.largest_overlap);
        print!("greatest squeeze   {:>10.1} N", self.greatest_squeeze);
        match self.most_squeezed {
            Some((i, time)) => println!("   (agent {} at t = {time:.3} s)", self.trial.agents[i].id),
            None => println!(),
        }
        println!("trajectories       {}", output.display());
    }
}
