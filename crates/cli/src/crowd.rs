//! A crowd among the components of a run: its trajectories and extremes, from the outputs of its FMU.

use crate::recording::Recording;
use crate::results::{Cell, Column, Content, Extent, Kind, Place, Table};
use anyhow::{Result, bail};
use crowd_mechanics::trial::Trial;
use fmi_rs::model_description::fmi2::{Causality, ModelDescription, VariableType};
use lemons_master::{Component, CrowdRecord, Extremes, Greatest, System};
use std::collections::HashSet;

const SQUEEZE: &str = "NormalForce";
/// Column, output of an agent, unit, description.
type Row = (&'static str, &'static str, Option<&'static str>, &'static str);
const MOTION_COLUMNS: [Row; 6] = [
    ("x", "Position.x", Some("m"), "x of the centre of mass"),
    ("y", "Position.y", Some("m"), "y of the centre of mass"),
    ("vx", "Velocity.x", Some("m/s"), "velocity along x"),
    ("vy", "Velocity.y", Some("m/s"), "velocity along y"),
    ("theta", "Theta", Some("rad"), "orientation: angle from the x axis to the gaze"),
    ("omega", "Omega", Some("rad/s"), "angular velocity"),
];
const CONTACT_COLUMNS: [Row; 3] = [
    ("agent_contacts", "AgentContacts", None, "contacts of the agent's disks with disks of others"),
    ("wall_contacts", "WallContacts", None, "contacts of the agent's disks with faces of walls"),
    ("contacting_agents", "ContactingAgents", None, "how many other agents touch the agent"),
];
const SQUEEZE_COLUMN: Row = (
    "normal_force",
    SQUEEZE,
    Some("N"),
    "squeeze at this time: sum of the normal forces |F_n| of the agent's contacts",
);
/// Of the step that ends at the time, not of the time itself; FMUs of earlier versions have none of them.
const STEP_COLUMNS: [Row; 3] = [
    ("mean_normal_force", "MeanNormalForce", Some("N"), "mean squeeze over the step that ends at this time"),
    (
        "peak_normal_force",
        "PeakNormalForce",
        Some("N"),
        "largest squeeze within the step that ends at this time",
    ),
    (
        "peak_overlap",
        "PeakOverlap",
        Some("m"),
        "deepest overlap of a contact within the step that ends at this time",
    ),
];
/// Of the whole crowd, in each row; without agent.
const TOTAL_COLUMNS: [Row; 2] = [
    ("total_agent_contacts", "AgentContacts", None, "contacts between disks of the crowd, each pair once"),
    ("total_wall_contacts", "WallContacts", None, "contacts between disks of the crowd and faces of walls"),
];

/// The agents of an instance, and what has been seen of them.
pub struct Crowd {
    /// Among the components.
    place: usize,
    ids: Vec<String>,
    motions: Vec<u32>,
    contacts: Vec<u32>,
    squeezes: Vec<u32>,
    /// Empty if the FMU has none.
    steps: Vec<u32>,
    /// Empty if the FMU has none.
    totals: Vec<u32>,
    trajectories: Table,
    extremes: Extremes,
    /// At the last look.
    moves: bool,
}

/// \[m/s\] Who is not faster stands,
const STANDING_SPEED: f64 = 0.01;
/// \[rad/s\] if he does not turn faster than this.
const STANDING_TURN: f64 = 0.05;

/// Whether somebody with this speed \[m/s\] and turn \[rad/s\] moves, and does not stand.
pub fn moves(speed: f64, turn: f64) -> bool {
    speed > STANDING_SPEED || turn.abs() > STANDING_TURN
}

/// How many agents' outputs an FMU has under the names of our mechanics, from 0 on.
pub fn agents_of(description: &ModelDescription) -> usize {
    let outputs = description.modelVariables.iter().filter(|v| v.causality == Causality::Output);
    let outputs: HashSet<(&str, bool)> =
        outputs.map(|v| (v.name.as_str(), matches!(v.variableType, VariableType::Real { .. }))).collect();
    let has = |i: usize| {
        let reals = MOTION_COLUMNS.iter().chain([&SQUEEZE_COLUMN]).map(|row| (row.1, true));
        let mut names = reals.chain(CONTACT_COLUMNS.iter().map(|row| (row.1, false)));
        names.all(|(name, real)| outputs.contains(&(format!("agent[{i}].{name}").as_str(), real)))
    };
    (0..).take_while(|&i| has(i)).count()
}

/// The Trial that an initialized instance runs; `None` if its FMU holds none.
pub fn trial_of(component: &Component) -> Result<Option<Trial>> {
    let (Ok(_), Ok(reference)) = (component.fmu.resources(), component.instance.reference("Trial")) else {
        return Ok(None);
    };
    let mut chosen = [String::new()];
    component.instance.get_string(&[reference], &mut chosen)?;
    component.fmu.trial(Some(&chosen[0])).map(Some)
}

/// Integer outputs of the whole crowd; none if one is missing.
fn totals_of(component: &Component) -> Vec<u32> {
    let variables = &component.fmu.description.modelVariables;
    let totals = TOTAL_COLUMNS.iter().map(|row| {
        let found = variables.iter().find(|variable| variable.name == row.1)?;
        let counts = matches!(found.variableType, VariableType::Integer { .. });
        (counts && found.causality == Causality::Output).then_some(found.valueReference)
    });
    totals.collect::<Option<_>>().unwrap_or_default()
}

/// Whether all these agents have the outputs of [`STEP_COLUMNS`].
fn has_steps(description: &ModelDescription, agents: usize) -> bool {
    let names = |i: usize| STEP_COLUMNS.iter().map(move |row| format!("agent[{i}].{}", row.1));
    let has = |name: String| {
        let found = description.variable_by_name(&name);
        found.is_ok_and(|v| matches!(v.variableType, VariableType::Real { .. }))
    };
    (0..agents).flat_map(names).all(has)
}

/// The columns after the time.
fn columns(description: &ModelDescription, steps: bool, totals: bool) -> Vec<Column> {
    let id = Column {
        name: "id".into(),
        kind: Kind::Text,
        unit: None,
        variable: "agent[i]".into(),
        description: "Id of the agent in Agents.xml; its place i if the FMU holds no Trial".into(),
    };
    let column = |(name, output, unit, description_): &Row, agent: &str, kind| {
        // What the FMU itself says comes first: it might count in other units.
        let variable = description.variable_by_name(&format!("agent[0].{output}")).ok();
        let said = variable.filter(|_| kind == Kind::Real).and_then(|own| description.get_unit(own));
        Column {
            name: (*name).into(),
            kind,
            unit: said.or(*unit).map(str::to_owned),
            variable: format!("{agent}{output}"),
            description: (*description_).into(),
        }
    };
    let mut columns = vec![id];
    columns.extend(MOTION_COLUMNS.iter().map(|row| column(row, "agent[i].", Kind::Real)));
    columns.extend(CONTACT_COLUMNS.iter().map(|row| column(row, "agent[i].", Kind::Integer)));
    columns.push(column(&SQUEEZE_COLUMN, "agent[i].", Kind::Real));
    if steps {
        columns.extend(STEP_COLUMNS.iter().map(|row| column(row, "agent[i].", Kind::Real)));
    }
    if totals {
        columns.extend(TOTAL_COLUMNS.iter().map(|row| column(row, "", Kind::Integer)));
    }
    columns
}

impl Crowd {
    /// The first `agents` of an initialized component, perhaps after a run before.
    pub fn create(
        system: &System,
        place: usize,
        agents: usize,
        trial: Option<Trial>,
        to: &Place,
        recording: &mut Recording<'_>,
    ) -> Result<Crowd> {
        let component = &system.components()[place];
        let trial = trial.filter(|trial| trial.agents.len() == agents);
        let references = |rows: &[Row]| -> Result<Vec<u32>> {
            let names = (0..agents).flat_map(|i| rows.iter().map(move |row| format!("agent[{i}].{}", row.1)));
            names.map(|name| component.instance.reference(&name)).collect()
        };
        let ids = match &trial {
            Some(trial) => trial.agents.iter().map(|agent| agent.id.clone()).collect(),
            None => (0..agents).map(|i| i.to_string()).collect(),
        };
        let totals = totals_of(component);
        let description = &component.fmu.description;
        let steps = if has_steps(description, agents) { references(&STEP_COLUMNS)? } else { Vec::new() };
        let columns = columns(description, !steps.is_empty(), !totals.is_empty());
        let columns = std::iter::once(Column::time()).chain(columns);
        let mut about = recording.about.clone();
        about.extend(trial.as_ref().map(|trial| ("trial", trial.name.clone())));
        about.push(("component", component.name.clone()));
        about.extend([("model_name", description.modelName.clone()), ("guid", description.guid.clone())]);
        let content = Content { columns: columns.collect(), about };
        let before = recording.before_of(&component.name)?;
        let extremes = before.map(|before| before.extremes).unwrap_or_default();
        if [extremes.mean_squeeze, extremes.peak_squeeze].iter().any(|most| most.agent >= agents) {
            bail!(
                "the saved run is damaged: it speaks of an agent that component {:?} has not",
                component.name
            );
        }
        Ok(Crowd {
            motions: references(&MOTION_COLUMNS)?,
            contacts: references(&CONTACT_COLUMNS)?,
            squeezes: references(&[SQUEEZE_COLUMN])?,
            steps,
            totals,
            place,
            ids,
            trajectories: Table::create(to, &content, before.map(|before| before.extent()))?,
            extremes,
            moves: false,
        })
    }

    /// Whether somebody moved at the last look.
    pub fn moves(&self) -> bool {
        self.moves
    }

    /// Reads the outputs at a communication point, notes the extremes, writes the rows if they are wanted.
    pub fn look(&mut self, system: &System, wanted: bool) -> Result<()> {
        let (time, instance) = (system.time(), &system.components()[self.place].instance);
        let mut motions = vec![0.0; self.motions.len()];
        let mut squeezes = vec![0.0; self.squeezes.len()];
        instance.get_real(&self.motions, &mut motions)?;
        instance.get_real(&self.squeezes, &mut squeezes)?;
        let (motions, _) = motions.as_chunks::<6>();
        self.moves = motions.iter().any(|[_, _, vx, vy, _, turn]| moves(vx.hypot(*vy), *turn));
        let mut steps = vec![0.0; self.steps.len()];
        if self.steps.is_empty() {
            self.extremes.mean_squeeze.see(squeezes.iter().copied(), time);
        } else {
            instance.get_real(&self.steps, &mut steps)?;
        }
        let (steps, _) = steps.as_chunks::<3>();
        self.extremes.mean_squeeze.see(steps.iter().map(|step| step[0]), time);
        self.extremes.peak_squeeze.see(steps.iter().map(|step| step[1]), time);
        let deepest = steps.iter().map(|step| step[2]);
        self.extremes.largest_overlap = deepest.fold(self.extremes.largest_overlap, f64::max);
        if !wanted {
            return Ok(());
        }
        let mut contacts = vec![0; self.contacts.len()];
        let mut totals = vec![0; self.totals.len()];
        instance.get_integer(&self.contacts, &mut contacts)?;
        instance.get_integer(&self.totals, &mut totals)?;
        let (contacts, _) = contacts.as_chunks::<3>();
        for (i, id) in self.ids.iter().enumerate() {
            let row = std::iter::once(Cell::Text(id))
                .chain(motions[i].iter().map(|value| Cell::Real(*value)))
                .chain(contacts[i].iter().map(|count| Cell::Integer(*count)))
                .chain([Cell::Real(squeezes[i])])
                .chain(steps.get(i).into_iter().flatten().map(|value| Cell::Real(*value)))
                .chain(totals.iter().map(|count| Cell::Integer(*count)));
            self.trajectories.write(time, row)?;
        }
        Ok(())
    }

    /// What a saved run keeps of it.
    pub fn record(&self, component: &str) -> CrowdRecord {
        let Extent { rows, last } = self.trajectories.extent();
        CrowdRecord { component: component.to_owned(), rows, last, extremes: self.extremes }
    }

    /// Among the components.
    pub fn place(&self) -> usize {
        self.place
    }

    /// Puts the trajectories in their place; answers the lines of the summary.
    pub fn finish(self) -> Result<Vec<String>> {
        let Extremes { largest_overlap, mean_squeeze, peak_squeeze } = self.extremes;
        let squeeze = |what: &str, Greatest { force, agent, time }: Greatest, when: &str| {
            let line = format!("{what:<18} {force:>10.1} N");
            if force > 0.0 {
                format!("{line}   (agent {}, {when} {time:.3} s)", self.ids[agent])
            } else {
                line
            }
        };
        let mut lines = Vec::new();
        if self.steps.is_empty() {
            lines.push(squeeze("greatest squeeze", mean_squeeze, "at the communication point"));
        } else {
            lines.push(format!("largest overlap    {:>10.3} mm", 1e3 * largest_overlap));
            lines.push(squeeze("mean squeeze, max", mean_squeeze, "over the step to"));
            lines.push(squeeze("peak squeeze, max", peak_squeeze, "in the step to"));
        }
        lines.push(format!("trajectories       {}", self.trajectories.said()));
        self.trajectories.finish()?;
        Ok(lines)
    }
}
