//! A crowd among the components of a run: its trajectories and extremes, from the outputs of its FMU.

use crate::compared::{Follower, Seen};
use crate::recording::Recording;
use crate::results::{self, Column, Content, FrameWriter, Kind, Place, told};
use anyhow::{Context, Result, bail};
use lemons_files::Staged;
use lemons_master::{Component, CrowdRecord, Extremes, Greatest, Selection, Since, System};
use lemons_plane::{Motion, Pose, Twist, Vec2, vec2};
use lemons_record::columns::{self, Groups};
use lemons_record::{Frame, Observed, OfStep, Recorder, Run, Totals, Wanted};
use lemons_ssp::{Interface, Kind as Causality, Type};
use lemons_trial::Trial;
use std::path::{Path, PathBuf};

/// Where the rows of a crowd go.
pub enum Target {
    Table(Place),
    /// Those that are wanted.
    Memory(Wanted),
}

enum Rows {
    Table(Box<Table>),
    Memory(Recorder),
}

struct Table {
    writer: FrameWriter<Staged>,
    path: PathBuf,
}

/// What became of the records.
pub struct Recorded {
    /// Of the summary.
    pub lines: Vec<String>,
    /// If it was to be kept in memory.
    pub run: Option<Run>,
    /// Of the poses of each crowd, if they were followed.
    pub poses: Vec<Seen>,
    /// Whether each file is in its place.
    pub placed: Result<()>,
}

/// The agents of an instance, and what has been seen of them.
pub struct Crowd {
    /// Among the components.
    place: usize,
    ids: Vec<String>,
    motions: Selection,
    contacts: Selection,
    squeezes: Selection,
    /// Empty if the FMU has none.
    steps: Selection,
    /// Whether agents are there; empty if nothing decides about it.
    active: Selection,
    /// Empty if the FMU has none.
    totals: Selection,
    trajectories: Rows,
    extremes: Extremes,
    /// Of the steps since the last rows.
    since: Since,
    /// \[s\] of the last look.
    seen: f64,
    /// Whether the greatest peak was since then.
    peak_passed: bool,
    /// At the last look.
    moves: bool,
    /// \[m\] Where everybody was; `None` of those who have left.
    standing: Vec<Option<Vec2>>,
    follower: Follower,
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
pub fn agents_of(description: &Interface) -> usize {
    let is = |name: &str, real: bool| {
        let found = description.single(name).map(|single| single.variable);
        let found = found.filter(|variable| variable.kind == Some(Causality::Output));
        found.is_some_and(|variable| matches!(variable.of, Type::Real(_)) == real)
    };
    let has = |i: usize| {
        let reals = columns::MOTION.iter().chain([&columns::SQUEEZE]).map(|row| (row.variable, true));
        let mut names = reals.chain(columns::CONTACTS.iter().map(|row| (row.variable, false)));
        names.all(|(name, real)| is(&format!("agent[{i}].{name}"), real))
    };
    (0..).take_while(|&i| has(i)).count()
}

/// Integer outputs of the whole crowd; none if one is missing.
fn totals_of(component: &Component) -> lemons_master::Result<Selection> {
    let totals = columns::TOTALS.iter().map(|row| {
        let found = component.fmu.description.single(row.variable)?;
        let own = found.variable;
        (own.of == Type::Integer && own.kind == Some(Causality::Output)).then_some(found.address())
    });
    let addresses = totals.collect::<Option<Vec<_>>>().unwrap_or_default();
    component.instance.select_at(&addresses)
}

/// The inputs that say whether agents are there, if another component decides about it or somebody is not there from the
/// start; else none.
fn active_of(system: &System, place: usize, agents: usize) -> lemons_master::Result<Selection> {
    let component = &system.components()[place];
    let name = |i: usize| format!("agent[{i}].{}", columns::ACTIVE.variable);
    let address = |i: usize| {
        let found = component.fmu.description.single(&name(i))?;
        let own = found.variable;
        (own.of == Type::Boolean && own.kind == Some(Causality::Input)).then_some(found.address())
    };
    let addresses = (0..agents).map(address).collect::<Option<Vec<_>>>().unwrap_or_default();
    let all = component.instance.select_at(&addresses)?;
    let mut there = vec![0; all.len()];
    component.instance.get_boolean(&all, &mut there)?;
    let decided = (0..all.len()).any(|i| system.feeds(place, &name(i)));
    Ok(if decided || there.contains(&0) { all } else { Selection::default() })
}

/// Whether all these agents have the outputs of [`columns::OF_STEP`].
fn has_steps(description: &Interface, agents: usize) -> bool {
    let names = |i: usize| columns::OF_STEP.iter().map(move |row| format!("agent[{i}].{}", row.variable));
    let has = |name: String| {
        let found = description.single(&name);
        found.is_some_and(|single| matches!(single.variable.of, Type::Real(_)))
    };
    (0..agents).flat_map(names).all(has)
}

/// The columns of the table.
fn columns_of(description: &Interface, groups: Groups) -> Vec<Column> {
    let mut all = groups.columns();
    // What the FMU itself says comes first: it might count in other units.
    for column in all.iter_mut().filter(|column| column.kind == Kind::Real) {
        if let Some(name) = column.variable.strip_prefix("agent[i].") {
            let own = description.single(&format!("agent[0].{name}"));
            let said = own.and_then(|own| own.variable.of.unit()).map(str::to_owned);
            column.unit = said.or(column.unit.take());
        }
    }
    all
}

/// A communication point at which a run is looked at.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Point {
    /// The first one: its rows are written, and there has been no step.
    Start,
    /// The end of a step, whose rows are written.
    Written,
    /// The end of a step, whose squeeze goes into the next rows.
    Passed,
}

impl Crowd {
    /// The first `agents` of an initialized component, perhaps after a run before.
    pub fn create(
        system: &System,
        place: usize,
        agents: usize,
        trial: Option<Trial>,
        to: Target,
        recording: &mut Recording<'_>,
    ) -> Result<Crowd> {
        let component = &system.components()[place];
        let trial = trial.filter(|trial| trial.agents.len() == agents);
        let select = |rows: &[columns::Quantity]| {
            let names =
                (0..agents).flat_map(|i| rows.iter().map(move |row| format!("agent[{i}].{}", row.variable)));
            component.instance.select(names)
        };
        let ids: Vec<String> = match &trial {
            Some(trial) => trial.agents.iter().map(|agent| agent.id.clone()).collect(),
            None => (0..agents).map(|i| i.to_string()).collect(),
        };
        let totals = totals_of(component)?;
        let description = &component.fmu.description;
        let steps =
            if has_steps(description, agents) { select(&columns::OF_STEP)? } else { Selection::default() };
        let active = active_of(system, place, agents)?;
        let groups = Groups {
            contacts: true,
            of_step: !steps.is_empty(),
            active: !active.is_empty(),
            totals: !totals.is_empty(),
        };
        let mut about = recording.about.clone();
        about.extend(trial.as_ref().map(|trial| ("trial", trial.name.clone())));
        about.push(("component", component.name.clone()));
        about.extend([("model_name", description.model_name.clone()), ("guid", description.guid.clone())]);
        let content = Content { columns: columns_of(description, groups), about };
        let before = recording.before_of(&component.name)?;
        let extremes = before.map(|before| before.extremes).unwrap_or_default();
        let since = before.map(|before| before.since.clone()).unwrap_or_default();
        if [extremes.mean_squeeze, extremes.peak_squeeze].iter().any(|most| most.agent >= agents)
            || !(since.is_empty() || since.people() == agents)
        {
            bail!(
                "the saved run is damaged: it contains other agents than component {:?} has",
                component.name
            );
        }
        let trajectories = match to {
            Target::Table(place) => {
                let table = results::begin(&place, &content, recording.before.is_some())?;
                let writer = FrameWriter::new(table, ids.clone(), groups)?;
                Rows::Table(Box::new(Table { writer, path: place.path }))
            }
            Target::Memory(wanted) => Rows::Memory(Recorder::new(wanted)),
        };
        let follower = recording.poses.follower(trial.as_ref(), agents);
        Ok(Crowd {
            follower,
            motions: select(&columns::MOTION)?,
            contacts: select(&columns::CONTACTS)?,
            squeezes: select(&[columns::SQUEEZE])?,
            steps,
            active,
            totals,
            place,
            ids,
            trajectories,
            extremes,
            since,
            seen: system.time(),
            peak_passed: false,
            moves: false,
            standing: Vec::new(),
        })
    }

    /// Whether another component says who is there.
    pub fn may_leave(&self) -> bool {
        !self.active.is_empty()
    }

    /// \[m\] Where everybody was at the last look; `None` of those who have left.
    pub fn standing(&self) -> &[Option<Vec2>] {
        &self.standing
    }

    /// Of everybody.
    pub fn ids(&self) -> impl Iterator<Item = &str> {
        self.ids.iter().map(String::as_str)
    }

    /// How many people it has.
    pub fn people(&self) -> usize {
        self.ids.len()
    }

    /// Whether somebody moved at the last look.
    pub fn moves(&self) -> bool {
        self.moves
    }

    /// Reads the outputs at a communication point, notes the extremes, writes the rows if they are wanted.
    pub fn look(&mut self, system: &System, point: Point) -> Result<()> {
        let (time, instance) = (system.time(), &system.components()[self.place].instance);
        let mut motions = vec![0.0; self.motions.len()];
        let mut squeezes = vec![0.0; self.squeezes.len()];
        instance.get_real(&self.motions, &mut motions)?;
        instance.get_real(&self.squeezes, &mut squeezes)?;
        let (motions, _) = motions.as_chunks::<6>();
        self.follower.see(time, motions);
        self.moves = motions.iter().any(|[_, _, vx, vy, _, turn]| moves(vx.hypot(*vy), *turn));
        let mut steps = vec![0.0; self.steps.len()];
        if self.steps.is_empty() {
            self.extremes.mean_squeeze.see(squeezes.iter().copied(), time);
        } else {
            instance.get_real(&self.steps, &mut steps)?;
        }
        let (steps, _) = steps.as_chunks::<3>();
        // At the start they are the values of an instant.
        if point != Point::Start {
            self.extremes.mean_squeeze.see(steps.iter().map(|step| step[0]), time);
            let before = self.extremes.peak_squeeze.force;
            self.extremes.peak_squeeze.see(steps.iter().map(|step| step[1]), time);
            self.peak_passed =
                point == Point::Passed && (self.peak_passed || self.extremes.peak_squeeze.force > before);
            let deepest = steps.iter().map(|step| step[2]);
            self.extremes.largest_overlap = deepest.fold(self.extremes.largest_overlap, f64::max);
        }
        let mut active = vec![0; self.active.len()];
        instance.get_boolean(&self.active, &mut active)?;
        let there = active.iter().map(|active| *active != 0).chain(std::iter::repeat(true));
        let places = motions.iter().map(|&[x, y, ..]| vec2(x, y)).zip(there);
        self.standing = places.map(|(place, there)| there.then_some(place)).collect();
        self.since.add(time - self.seen, steps);
        self.seen = time;
        if point == Point::Passed {
            return Ok(());
        }
        let steps = std::mem::take(&mut self.since).finish();
        let mut contacts = vec![0; self.contacts.len()];
        let mut totals = vec![0; self.totals.len()];
        instance.get_integer(&self.contacts, &mut contacts)?;
        instance.get_integer(&self.totals, &mut totals)?;
        let (contacts, _) = contacts.as_chunks::<3>();
        let mut frame = frame(time, motions, contacts, &squeezes, &steps, &totals)?;
        frame.active = (!self.active.is_empty()).then(|| active.iter().map(|active| *active != 0).collect());
        match &mut self.trajectories {
            Rows::Table(table) => table.writer.frame(&frame).map_err(told),
            Rows::Memory(recorder) => {
                recorder.add(frame);
                Ok(())
            }
        }
    }

    /// What a saved run keeps of it.
    pub fn record(&self, component: &str) -> CrowdRecord {
        CrowdRecord { component: component.to_owned(), extremes: self.extremes, since: self.since.clone() }
    }

    /// Among the components.
    pub fn place(&self) -> usize {
        self.place
    }

    /// Puts the trajectories in their place.
    pub fn finish(self) -> Recorded {
        let Extremes { largest_overlap, mean_squeeze, peak_squeeze } = self.extremes;
        let squeeze = |what: &str, Greatest { force, agent, time }: Greatest, when: &str| {
            let line = format!("{what:<18} {force:>10.1} N");
            if force > 0.0 {
                format!("{line}   (squeeze of agent {}, {when} {time:.3} s)", self.ids[agent])
            } else {
                line
            }
        };
        let poses = self.follower.finish(&self.ids).into_iter().collect();
        let mut lines = Vec::new();
        if !self.active.is_empty() {
            let left = self.standing.iter().filter(|place| place.is_none()).count();
            lines.push(format!("left               {left:>10}     (of {} people)", self.ids.len()));
        }
        if self.steps.is_empty() {
            lines.push(squeeze("greatest squeeze", mean_squeeze, "communication point"));
        } else {
            lines.push(format!("largest overlap    {:>10.3} mm", 1e3 * largest_overlap));
            lines.push(squeeze("greatest step mean", mean_squeeze, "step to"));
            lines.push(squeeze("greatest peak", peak_squeeze, "step to"));
            if self.peak_passed && matches!(self.trajectories, Rows::Table(_)) {
                lines.push(format!(
                    "{:<33}(not in the table, whose last rows are before this step: --every)",
                    ""
                ));
            }
        }
        match self.trajectories {
            Rows::Table(table) => {
                let Table { writer, path } = *table;
                let line = format!("trajectories       {}", path.display());
                let placed = results::place(writer.finish(), &path);
                lines.extend(placed.is_ok().then_some(line));
                Recorded { lines, run: None, poses, placed }
            }
            Rows::Memory(recorder) => match recorder.finish(Path::new(""), self.ids) {
                Ok(run) => Recorded { lines, run: Some(run), poses, placed: Ok(()) },
                Err(error) => Recorded { lines, run: None, poses, placed: Err(error.into()) },
            },
        }
    }
}

/// What the outputs of all agents say at a time \[s\].
fn frame(
    time: f64,
    motions: &[[f64; 6]],
    contacts: &[[i32; 3]],
    squeezes: &[f64],
    steps: &[[f64; 3]],
    totals: &[i32],
) -> Result<Frame> {
    let agents = motions.iter().map(|&[x, y, vx, vy, orientation, angular_velocity]| Motion {
        pose: Pose { position: vec2(x, y), orientation },
        twist: Twist { velocity: vec2(vx, vy), angular_velocity },
    });
    let counted = |count: i32| u32::try_from(count).context("the FMU counts less than no contacts");
    let observed = contacts.iter().zip(squeezes).enumerate().map(|(i, (counts, &normal_force))| {
        let [agent_contacts, wall_contacts, contacting_agents] = counts.map(counted);
        Ok(Observed {
            agent_contacts: agent_contacts?,
            wall_contacts: wall_contacts?,
            contacting_agents: contacting_agents?,
            normal_force,
            of_step: steps.get(i).map(|&[mean_normal_force, peak_normal_force, peak_overlap]| OfStep {
                mean_normal_force,
                peak_normal_force,
                peak_overlap,
            }),
        })
    });
    let totals = match totals {
        &[agents, walls] => Some(Totals { agent_contacts: counted(agents)?, wall_contacts: counted(walls)? }),
        _ => None,
    };
    Ok(Frame {
        time,
        agents: agents.collect(),
        observed: Some(observed.collect::<Result<_>>()?),
        totals,
        place: format!("t = {time:?} s"),
        ..Frame::default()
    })
}
