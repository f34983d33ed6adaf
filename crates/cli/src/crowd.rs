//! A crowd among the components of a run: its trajectories and extremes, from the outputs of its FMU.

use crate::results::{Table, Tables};
use anyhow::Result;
use crowd_mechanics::engine::{Pose, State, Twist, World, vec2};
use crowd_mechanics::trial::Trial;
use fmi_rs::model_description::fmi2::{Causality, ModelDescription, VariableType};
use lemons_master::{Component, System};
use std::collections::HashSet;
use std::path::{Path, PathBuf};

const MOTION: [&str; 6] = ["Position.x", "Position.y", "Velocity.x", "Velocity.y", "Theta", "Omega"];
const CONTACTS: [&str; 3] = ["AgentContacts", "WallContacts", "ContactingAgents"];
const SQUEEZE: &str = "NormalForce";
const HEADER: [&str; 12] = [
    "t",
    "id",
    "x",
    "y",
    "vx",
    "vy",
    "theta",
    "omega",
    "agent_contacts",
    "wall_contacts",
    "contacting_agents",
    "normal_force",
];

/// The agents of an instance, and what has been seen of them.
pub struct Crowd {
    /// Among the components.
    place: usize,
    /// For overlaps, which are no variables of the FMU; only from an FMU that holds a Trial.
    shadow: Option<World>,
    ids: Vec<String>,
    motions: Vec<u32>,
    contacts: Vec<u32>,
    squeezes: Vec<u32>,
    trajectories: Table,
    path: PathBuf,
    largest_overlap: f64,
    greatest_squeeze: f64,
    most_squeezed: Option<(usize, f64)>,
}

/// How many agents' outputs an FMU has under the names of our mechanics, from 0 on.
pub fn agents_of(description: &ModelDescription) -> usize {
    let outputs = description.modelVariables.iter().filter(|v| v.causality == Causality::Output);
    let outputs: HashSet<(&str, bool)> =
        outputs.map(|v| (v.name.as_str(), matches!(v.variableType, VariableType::Real { .. }))).collect();
    let has = |i: usize| {
        let reals = MOTION.iter().chain([&SQUEEZE]).map(|name| (name, true));
        let mut names = reals.chain(CONTACTS.iter().map(|name| (name, false)));
        names.all(|(name, real)| outputs.contains(&(format!("agent[{i}].{name}").as_str(), real)))
    };
    (0..).take_while(|&i| has(i)).count()
}

/// The Trial that an initialized instance runs; `None` if its FMU holds none.
pub fn trial_of(component: &Component) -> Result<Option<Trial>> {
    let (Ok(resources), Ok(reference)) = (component.fmu.resources(), component.instance.reference("Trial"))
    else {
        return Ok(None);
    };
    let mut chosen = [String::new()];
    component.instance.get_string(&[reference], &mut chosen)?;
    Ok(Some(resources.load(&chosen[0])?.0))
}

impl Crowd {
    /// The first `agents` of an initialized component.
    pub fn create(
        system: &System,
        place: usize,
        agents: usize,
        trial: Option<Trial>,
        path: &Path,
        tables: &mut Tables,
    ) -> Result<Crowd> {
        let component = &system.components()[place];
        let trial = trial.filter(|trial| trial.agents.len() == agents);
        let references = |names: &[&str]| -> Result<Vec<u32>> {
            let names = (0..agents).flat_map(|i| names.iter().map(move |name| format!("agent[{i}].{name}")));
            names.map(|name| component.instance.reference(&name)).collect()
        };
        let ids = match &trial {
            Some(trial) => trial.agents.iter().map(|agent| agent.id.clone()).collect(),
            None => (0..agents).map(|i| i.to_string()).collect(),
        };
        Ok(Crowd {
            motions: references(&MOTION)?,
            contacts: references(&CONTACTS)?,
            squeezes: references(&[SQUEEZE])?,
            shadow: trial.as_ref().map(Trial::world).transpose()?,
            place,
            ids,
            trajectories: tables.create(path, HEADER)?,
            path: path.to_owned(),
            largest_overlap: 0.0,
            greatest_squeeze: 0.0,
            most_squeezed: None,
        })
    }

    /// Reads the outputs at a communication point, notes the extremes, writes the rows.
    pub fn look(&mut self, system: &System) -> Result<()> {
        let (time, instance) = (system.time(), &system.components()[self.place].instance);
        let mut motions = vec![0.0; self.motions.len()];
        let mut contacts = vec![0; self.contacts.len()];
        let mut squeezes = vec![0.0; self.squeezes.len()];
        instance.get_real(&self.motions, &mut motions)?;
        instance.get_integer(&self.contacts, &mut contacts)?;
        instance.get_real(&self.squeezes, &mut squeezes)?;
        let (motions, _) = motions.as_chunks::<6>();
        let (contacts, _) = contacts.as_chunks::<3>();
        for (i, id) in self.ids.iter().enumerate() {
            // `{:?}` reads back to the same double.
            let row = std::iter::once(format!("{time:?}"))
                .chain([id.clone()])
                .chain(motions[i].iter().map(|value| format!("{value:?}")))
                .chain(contacts[i].iter().map(ToString::to_string))
                .chain([format!("{:?}", squeezes[i])]);
            self.trajectories.write(row)?;
            if squeezes[i] > self.greatest_squeeze {
                self.greatest_squeeze = squeezes[i];
                self.most_squeezed = Some((i, time));
            }
        }
        if let Some(shadow) = &mut self.shadow {
            let poses =
                motions.iter().map(|m| Pose { position: vec2(m[0], m[1]), orientation: m[4] }).collect();
            let twists = motions
                .iter()
                .map(|m| Twist { velocity: vec2(m[2], m[3]), angular_velocity: m[5] })
                .collect();
            shadow.restore(State::new(poses, twists));
            self.largest_overlap = self.largest_overlap.max(shadow.contacts().largest_overlap());
        }
        Ok(())
    }

    /// Puts the trajectories in their place; answers the lines of the summary.
    pub fn finish(self) -> Result<Vec<String>> {
        let mut lines = Vec::new();
        if self.shadow.is_some() {
            let overlap = 1e3 * self.largest_overlap;
            lines.push(format!("largest overlap    {overlap:>10.3} mm   (at communication points)"));
        }
        let squeeze = format!("greatest squeeze   {:>10.1} N", self.greatest_squeeze);
        lines.push(match self.most_squeezed {
            Some((i, time)) => format!("{squeeze}   (agent {} at t = {time:.3} s)", self.ids[i]),
            None => squeeze,
        });
        lines.push(format!("trajectories       {}", self.path.display()));
        self.trajectories.finish()?;
        Ok(lines)
    }
}
