//! The paper's series of XML files, as an `OutputDirectory` holds it, and the Trial that goes on from its end.

use crate::columns::{Effect, Group, Groups};
use crate::error::RecordError;
use crate::record::Record;
use crate::recorder::KeptFrames;
use crate::run::{Effects, Frame};
use crate::text::{files_of, own};
use lemons_core::files::{Change, change_all};
use lemons_core::plane::Vec2;
use lemons_core::trial::{
    AgentDynamics, DynamicsElement, Interactions, Trial, dynamics_xml, interactions_xml, output_names,
};
use std::collections::BTreeSet;
use std::f64::consts::{PI, TAU};
use std::path::Path;

const DYNAMICS: &str = "AgentDynamics output t=";
const INTERACTIONS: &str = "AgentInteractions t=";

/// Returns the text between a prefix and `.xml`.
fn time_of<'a>(name: &'a str, prefix: &str) -> Option<&'a str> {
    name.strip_prefix(prefix)?.strip_suffix(".xml")
}

impl Record {
    /// Opens a series of files `AgentDynamics output t=….xml` and `AgentInteractions t=….xml`, which an FMU of this Trial
    /// wrote into its `OutputDirectory`. All files are read once.
    ///
    /// # Errors
    /// The directory holds no such series, or one of its files is wrong; the message names the file and the line.
    pub fn series(directory: &Path, trial: &Trial) -> Result<Record, RecordError> {
        let (directory, trial) = (directory.to_owned(), trial.clone());
        let (times, contacts) = times_of(&directory)?;
        Record::new(&directory.clone(), move |each| {
            for (time, text) in &times {
                let place = format!("{DYNAMICS}{text}.xml");
                let interactions = if contacts.contains(text) {
                    trial.read_interactions(&directory.join(format!("{INTERACTIONS}{text}.xml")))?
                } else {
                    Interactions::default()
                };
                let dynamics = trial.read_dynamics(&directory.join(&place))?;
                let agents = dynamics.iter().map(AgentDynamics::motion).collect();
                let effects = effects(trial.agents.len(), &interactions);
                let interactions = Some(interactions);
                each(Frame { time: *time, agents, effects, interactions, place, ..Frame::default() })?;
            }
            Ok(trial.agents.iter().map(|agent| agent.id.clone()).collect())
        })
    }
}

/// Times \[s\] with their texts in the names of files.
type Times = Vec<(f64, String)>;

/// Finds the times of a series in a directory, and at which of them there were contacts.
fn times_of(directory: &Path) -> Result<(Times, BTreeSet<String>), RecordError> {
    let wrong = |name: &str, message: String| RecordError::wrong(&directory.join(name), message);
    let (mut times, mut contacts) = (Vec::new(), BTreeSet::new());
    directory.read_dir().map_err(|error| RecordError::Read { path: directory.to_owned(), error })?;
    for name in series_in(directory)? {
        if let Some(text) = time_of(&name, INTERACTIONS) {
            contacts.insert(text.to_owned());
        } else if let Some(text) = time_of(&name, DYNAMICS) {
            let time = text.parse::<f64>().ok().filter(|time| time.is_finite());
            let message = "the name holds no time in seconds after \"t=\"";
            times.push((time.ok_or_else(|| wrong(&name, message.into()))?, text.to_owned()));
        }
    }
    times.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.cmp(&b.1)));
    if times.is_empty() {
        let message = format!("holds no series: no file is named {DYNAMICS:?}….xml");
        return Err(RecordError::wrong(directory, message));
    }
    if let Some(pair) = times.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        let message = format!("t={} is the same time", pair[0].1);
        return Err(wrong(&format!("{DYNAMICS}{}.xml", pair[1].1), message));
    }
    if let Some(alone) = contacts.iter().find(|text| times.iter().all(|(_, time)| time != *text)) {
        let message = format!("there is no {:?} beside it", format!("{DYNAMICS}{alone}.xml"));
        return Err(wrong(&format!("{INTERACTIONS}{alone}.xml"), message));
    }
    Ok((times, contacts))
}

/// Sums up the contacts of each of so many agents.
fn effects(agents: usize, interactions: &Interactions) -> Effects {
    let mut effects = Groups::default().with(Group::Contacts, true).zeros(agents, 0.0).effects;
    let mut add = |effect: Effect, agent: usize, more: f64| {
        effects.get_mut(effect, agent).into_iter().for_each(|number| *number += more);
    };
    let mut touching = BTreeSet::new();
    for contact in &interactions.agents {
        for agent in [contact.parent, contact.child] {
            add(Effect::AgentContacts, agent, 1.0);
            add(Effect::NormalForce, agent, contact.force.normal.norm());
        }
        if touching.insert((contact.parent, contact.child)) {
            add(Effect::ContactingAgents, contact.parent, 1.0);
            add(Effect::ContactingAgents, contact.child, 1.0);
        }
    }
    for contact in &interactions.walls {
        add(Effect::WallContacts, contact.agent, 1.0);
        add(Effect::NormalForce, contact.agent, contact.force.normal.norm());
    }
    effects
}

/// Returns the names of the files of a series that a directory holds; none if there is no such directory.
///
/// # Errors
/// The directory cannot be read.
pub fn series_in(directory: &Path) -> Result<Vec<String>, RecordError> {
    files_of(directory, is_of_series)
}

fn is_of_series(name: &str) -> bool {
    time_of(name, DYNAMICS).or(time_of(name, INTERACTIONS)).is_some()
}

/// Names of the files that [`series`] writes. Files of interactions are removed where a frame has none.
pub fn series_files(record: &Record) -> BTreeSet<String> {
    record.times().flat_map(output_names).collect()
}

/// Writes a run of a Trial as a series of XML files into a directory, with interactions where they were recorded.
///
/// # Errors
/// The agents are not those of the Trial, two times are too near for file names of their own, the directory holds files
/// of another run, or a file cannot be written.
pub fn series(record: &Record, trial: &Trial, directory: &Path) -> Result<(), RecordError> {
    let record = record.clone().of_trial(trial)?;
    let names: Vec<[String; 2]> = record.times().map(output_names).collect();
    if let Some(k) = (1..names.len()).find(|&k| names[k] == names[k - 1]) {
        return Err(record.wrong_at(k, |place| {
            format!("{place}: column t: as near to the frame before as no file name tells")
        }));
    }
    own(directory, names.as_flattened(), is_of_series)?;
    record.each(|k, frame| {
        let [dynamics, interactions] = &names[k];
        let agents: Vec<AgentDynamics> = frame.agents.iter().map(AgentDynamics::of).collect();
        let text = dynamics_xml(&trial.agents, &agents, DynamicsElement::Omitted);
        let dynamics = Change::Write(directory.join(dynamics), text);
        let place = directory.join(interactions);
        let interactions = match &frame.interactions {
            Some(some) if *some != Interactions::default() => {
                Change::Write(place, interactions_xml(&trial.agents, &trial.geometry, some))
            }
            _ => Change::Remove(place),
        };
        Ok(change_all(&[dynamics, interactions])?)
    })
}

/// The Trial that continues from the end of a run: with the poses, velocities and springs of the last frame, without
/// those who have left, whose last places \[m\] are told; who has not come yet is not there either. Its clock begins anew:
/// walls open and close as much earlier. Runs do not record Fp and Mp; they stay those of the Trial.
///
/// # Errors
/// The agents are not those of the Trial.
pub fn trial_at_end(record: &Record, trial: &Trial) -> Result<(Trial, Vec<Vec2>), RecordError> {
    let record = record.clone().of_trial(trial)?;
    let last = record.read_wanted(KeptFrames::Around(Vec::new()))?.frames.pop().unwrap_or_default();
    let mut trial = trial.clone();
    let step = trial.parameters.time_step;
    for open in trial.geometry.walls.iter_mut().filter_map(|wall| wall.open.as_mut()) {
        *open = open.since(last.time, step);
    }
    let last = last.with_outside(&trial);
    let moved = |(place, (motion, was)): (usize, (_, &AgentDynamics))| {
        let now = AgentDynamics::of(motion);
        let now = AgentDynamics { theta: within_a_turn(now.theta), fp: was.fp, mp: was.mp, ..now };
        if last.is_outside(place) { was.clone() } else { now }
    };
    trial.dynamics = last.agents.iter().zip(&trial.dynamics).enumerate().map(moved).collect();
    // A run in which people leave is a table, which has no springs: nothing names those who are taken out.
    let (mut agent, mut motion) = (0.., 0..);
    let stays = |place: usize| last.is_there(place) || last.is_outside(place);
    let left = last.agents.iter().enumerate().filter(|(place, _)| !stays(*place));
    let left = left.map(|(_, motion)| motion.pose.position).collect();
    trial.agents.retain(|_| agent.next().is_some_and(stays));
    trial.dynamics.retain(|_| motion.next().is_some_and(stays));
    trial.interactions = last.interactions.clone().unwrap_or_default();
    Ok((trial, left))
}

/// Returns the same orientation \[rad\], more than -π and at most π: in a run bodies turn on and on.
fn within_a_turn(theta: f64) -> f64 {
    if theta > -PI && theta <= PI {
        return theta;
    }
    let turned = theta.rem_euclid(TAU);
    if turned > PI { turned - TAU } else { turned }
}
