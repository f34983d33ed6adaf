//! The plan for the people of a Trial that follows from a `decision.toml`: everything for each agent, in memory only.

mod checked;
mod destinations;
mod groups;
mod normalized;

use crate::balance::{BalanceModel, Pendulum};
use crate::config::{AgentConfig, DECISION_FILE, DecisionConfig, GroupsConfig};
use crate::error::{PlanError, moderate};
use crate::exit_choice::ExitChoice;
use crate::queue::QueueConfig;
use crate::rule::{Motivation, UNLIMITED, Walker, Waypoint, usual_stature};
use crate::source::{Source, reach, sources};
use crate::stuck::normal;
use crate::target::{Destination, Target, Ways, nearest_exit};
use crate::walking_model::WalkingModel;
use destinations::{destinations, targets_of, ways};
use lemons_core::files::input;
use lemons_core::plane::{Pose, Vec2, vec2};
use lemons_core::trial::{Grounds, Link, Trial, Wall};
use lemons_fmi::fingerprint;
pub use normalized::normalized;
use std::collections::HashSet;
use std::fmt::Display;
use std::path::Path;

/// \[m/s\] Mean speed of pedestrians who walk freely (Weidmann 1993).
pub const DEFAULT_SPEED: f64 = 1.34;

/// Draw of a person that is that of the push; those of walking begin at 0.
const PUSH_DRAW: u64 = u64::MAX / 2;
/// Those of the desired speed and of the start.
const SPEED_DRAW: u64 = u64::MAX / 4;
const START_DRAW: u64 = u64::MAX / 8;

/// An agent of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned {
    /// Id in Agents.xml.
    pub id: String,
    /// Destination after the last way-point.
    pub destination: Destination,
    /// Disks relative to the centre of mass when the gaze is along x: x, y, radius \[m\]; none where nobody looks at them.
    pub disks: Vec<[f64; 3]>,
    /// Start values of the inputs.
    pub pose: Pose,
    /// The data for the rule.
    pub walker: Walker,
}

impl Planned {
    /// \[m\] Returns the breadth of the body across the gaze.
    pub fn breadth(&self) -> f64 {
        2.0 * self.disks.iter().map(|&[_, y, radius]| y.abs() + radius).fold(0.0, f64::max)
    }

    /// \[m\] Returns how far the body reaches from its centre of mass.
    pub fn radius(&self) -> f64 {
        reach(&self.disks)
    }

    /// \[m\] Returns the depth of the body along the gaze.
    pub fn depth(&self) -> f64 {
        2.0 * self.disks.iter().map(|&[x, _, radius]| x.abs() + radius).fold(0.0, f64::max)
    }
}

/// Everything that Decision does with the agents of a Trial, in memory only.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Settings, as the user wrote them.
    pub config: DecisionConfig,
    /// Fingerprint of all that follows.
    pub fingerprint: u128,
    /// \[s\] `DefaultExperiment.stepSize`
    pub time_step: f64,
    /// Chooses who does what when nobody gets on.
    pub seed: u64,
    /// \[m\] Corners of each wall that never opens; none if nobody looks at them.
    pub walls: Vec<Vec<Vec2>>,
    /// Walls that open.
    pub doors: Vec<Wall>,
    /// Slopes and stairs.
    pub grounds: Grounds,
    /// Lines that are one.
    pub links: Vec<Link>,
    /// Groups that stay together: places of their members in `agents`.
    pub groups: Vec<Vec<usize>>,
    /// Model of how people walk among others.
    pub walking_model: WalkingModel,
    /// Legs of those who stand, if they have any.
    pub balance: Option<BalanceModel>,
    /// How people who wait press those in front, if they do, and how their feet hold.
    pub queue: Option<(QueueConfig, Pendulum)>,
    /// How people choose who take the nearest exit.
    pub exit_choice: ExitChoice,
    /// Changes of everybody's motivation during the run.
    pub motivation: Vec<Motivation>,
    /// Who comes later.
    pub sources: Vec<Source>,
    /// Exits and goals.
    pub targets: Vec<Target>,
    /// People in the order of Agents.xml; at least one.
    pub agents: Vec<Planned>,
}

impl Plan {
    /// Returns whether its people queue with gaps without leaning, and hardly press, whatever the limits of pushes are.
    pub fn queues(&self) -> bool {
        matches!(self.walking_model, WalkingModel::Rotational(_)) && self.queue.is_none()
    }

    /// Makes a plan from a `decision.toml` for the people of a Trial, among its walls. Ways lead through walls that open. People stop
    /// in front of one that is closed.
    ///
    /// # Errors
    /// There is a setting for an unknown agent, exit or goal, an agent without way-points and exits, an exit to which no
    /// way leads, or a number out of range.
    pub fn of(trial: &Trial, config: &DecisionConfig) -> Result<Plan, PlanError> {
        let plan = Plan::without_ways(trial, config)?;
        plan.check_ways()?;
        Ok(plan)
    }

    /// Makes the same, without looking whether ways lead there.
    fn without_ways(trial: &Trial, config: &DecisionConfig) -> Result<Plan, PlanError> {
        let people = &trial.agents;
        if let Some(unknown) = config.agents.keys().find(|id| people.iter().all(|person| person.id != **id)) {
            return Err(PlanError::UnknownAgent(unknown.clone()));
        }
        if let Some(deviation) = config.push_sd {
            moderate("everybody", "push_sd", deviation)?;
            moderate("everybody", "push", config.push.ok_or(PlanError::NoPush)?)?;
        }
        config.desired_speed.map_or(Ok(()), |speed| speed.check("desired_speed"))?;
        config.start.map_or(Ok(()), |start| start.check("start"))?;
        config.queue.map_or(Ok(()), |queue| queue.check())?;
        let (walking_model, balance) = (config.walking_model()?, config.balance()?);
        let targets = targets_of(config)?;
        let groups = groups::groups(trial, config)?;
        let leads = groups::leads(people, config, &groups)?;
        let destinations = destinations(people, config, &targets, &groups, &leads)?;
        let chosen = ways(people.len(), config, &groups)?;
        let nothing = AgentConfig::default();
        let goes = |waypoints: &Option<Vec<Waypoint>>| waypoints.as_ref().is_some_and(|way| !way.is_empty());
        let several = config.ways.as_ref().is_some_and(|ways| !ways.is_empty());
        let ways =
            several || goes(&config.waypoints) || config.agents.values().any(|own| goes(&own.waypoints));
        let only_stands = balance.is_some() && targets.is_empty() && !ways;
        let seed = config.seed.unwrap_or(0);
        let doors: Vec<Wall> = trial.geometry.doors().map(|(_, wall)| wall.clone()).collect();
        let queue = config.queue.filter(|queue| !queue.is_idle());
        let sources = sources(trial, &config.sources, seed)?;
        let late: HashSet<usize> =
            sources.iter().flat_map(|source| source.people.iter().map(|(i, _)| *i)).collect();
        let bodies =
            walking_model.sees_others() || !doors.is_empty() || queue.is_some() || !sources.is_empty();
        let push = |i: usize| {
            let drawn = |deviation: f64| deviation * normal(seed, i as u64, PUSH_DRAW);
            let push = config.push.unwrap_or(UNLIMITED);
            config.push_sd.map_or(push, |deviation| (push + drawn(deviation)).max(0.0))
        };
        let people = people.iter().zip(&trial.dynamics);
        let agents = people.zip(destinations).enumerate().map(|(i, ((person, dynamics), destination))| {
            let own = config.agents.get(&person.id).unwrap_or(&nothing);
            let lead = config.agents.get(&trial.agents[leads[i]].id).unwrap_or(&nothing);
            let chosen = chosen[i].map(|k| &config.ways.as_ref().expect("one was chosen")[k].waypoints);
            let usual = chosen.or(config.waypoints.as_ref());
            let waypoints = lead.waypoints.as_ref().or(usual).cloned().unwrap_or_default();
            // Who is said to have no way, in a crowd with legs, stands.
            let stands = only_stands || balance.is_some() && lead.waypoints.is_some();
            if waypoints.is_empty() && destination == Destination::None && !stands {
                return Err(PlanError::NoWaypoint(person.id.clone()));
            }
            let disks = || person.disks_facing_x().iter().map(|(at, radius)| [at.x, at.y, *radius]).collect();
            Ok(Planned {
                id: person.id.clone(),
                destination,
                disks: if bodies { disks() } else { Vec::new() },
                pose: dynamics.motion().pose,
                walker: Walker {
                    mass: person.mass,
                    moment_of_inertia: person.moment_of_inertia,
                    floor_damping: person.floor_damping,
                    angular_damping: person.angular_damping,
                    desired_speed: own.desired_speed.unwrap_or_else(|| {
                        config.desired_speed.map_or(DEFAULT_SPEED, |speed| speed.of(seed, i, SPEED_DRAW))
                    }),
                    start: own.start.unwrap_or_else(|| {
                        let start = config.start.filter(|_| !late.contains(&i));
                        start.map_or(0.0, |start| start.of(seed, i, START_DRAW))
                    }),
                    time_gap: own.time_gap.unwrap_or(walking_model.time_gap()),
                    standstill_gap: own.standstill_gap.unwrap_or(walking_model.standstill_gap()),
                    reaction_time: own.reaction_time.unwrap_or(walking_model.reaction_time()),
                    stature: person.height.unwrap_or_else(usual_stature),
                    push: own.push.unwrap_or_else(|| push(i)),
                    waypoints,
                },
            })
        });
        let agents = agents.collect::<Result<_, PlanError>>()?;
        // Who sees neither walls nor exits needs no copy of them.
        let seen = bodies || !targets.is_empty() || balance.is_some() || !groups.is_empty();
        let walls = trial.geometry.fixed_walls().filter(|_| seen).map(|wall| wall.corners.clone()).collect();
        let exit_choice = config.exit_choice.unwrap_or_default();
        let motivation = config.motivation.clone();
        let plan = Plan {
            config: DecisionConfig::default(),
            fingerprint: 0,
            time_step: trial.parameters.time_step,
            seed,
            walls,
            doors,
            grounds: Grounds::new(&trial.geometry.grounds),
            links: trial.geometry.links.clone(),
            groups,
            walking_model,
            balance,
            queue: queue.map(|queue| (queue, config.pendulum.unwrap_or_default())),
            exit_choice,
            motivation,
            sources,
            targets,
            agents,
        };
        let plan = plan.checked()?;
        let fingerprint = fingerprint(format!("{plan:?}").as_bytes());
        Ok(Plan { config: config.clone(), fingerprint, ..plan })
    }

    /// Reads a Trial directory with a `decision.toml`, as an FMU contains it.
    ///
    /// # Errors
    /// A sentence with the file: it cannot be read, or what is in it is wrong.
    pub fn read(directory: &Path) -> Result<Plan, String> {
        let (trial, _) = Trial::read(directory).map_err(|problems| problems.to_string())?;
        Plan::beside(&trial, directory)
    }

    /// Reads the `decision.toml` of an FMU that contains it beside a Trial that was read.
    ///
    /// # Errors
    /// As [`Plan::read`].
    pub fn beside(trial: &Trial, directory: &Path) -> Result<Plan, String> {
        let path = directory.join(DECISION_FILE);
        let at = |error: &dyn Display| format!("{}: {error}", path.display());
        let text = input::read_text(&path, input::LARGEST_SETTINGS).map_err(|error| at(&error))?;
        // Ways were looked at when the FMU was packed.
        DecisionConfig::from_toml(&text)
            .and_then(|config| Plan::without_ways(trial, &config))
            .map_err(|error| at(&error))
    }

    /// Returns settings for who goes on from a time \[s\] of a run, with a clock that begins anew: exits open and close as
    /// much earlier, people start so, too, and motivation changes so. Groups are those of the plan, and motivation that has
    /// changed stays so. Of a source, those come who are not there in the Trial of then. By an exit that is always open, as many
    /// fewer leave as have `left` there, by their last places \[m\].
    pub fn going_on(
        &self,
        config: &DecisionConfig,
        time: f64,
        trial: &Trial,
        left: &[Vec2],
    ) -> DecisionConfig {
        let mut later = config.clone();
        let by = |k| left.iter().filter(|at| nearest_exit(&self.targets, **at) == Some(k)).count() as u32;
        let exits = later.exits.iter_mut().flatten().enumerate();
        for (k, exit) in exits.filter(|(_, exit)| exit.open.is_none()) {
            exit.most = exit.most.map(|most| most.saturating_sub(by(k)));
        }
        let people = trial.agents.iter().zip(&trial.dynamics);
        let outside: HashSet<&str> =
            people.filter(|(_, own)| own.absent).map(|(person, _)| &*person.id).collect();
        for (source, plan) in later.sources.iter_mut().zip(&self.sources) {
            source.people.retain(|id| outside.contains(&**id));
            let left = plan.times.len() - source.people.len();
            source.times = Some(plan.times[left..].iter().map(|due| (due - time).max(0.0)).collect());
            (source.rate, source.every, source.start) = (None, None, None);
        }
        later.sources.retain(|source| !source.people.is_empty());
        for open in later.exits.iter_mut().flatten().filter_map(|exit| exit.open.as_mut()) {
            *open = open.since(time, self.time_step);
        }
        let begun: Vec<Motivation> = config.motivation.iter().filter(|of| of.time <= time).cloned().collect();
        later.motivation.retain(|motivation| motivation.time > time);
        later.motivation.iter_mut().for_each(|motivation| motivation.time -= time);
        let mut starts: Vec<f64> = self.agents.iter().map(|agent| agent.walker.start).collect();
        if !self.groups.is_empty() {
            let ids = |group: &Vec<usize>| group.iter().map(|&i| self.agents[i].id.clone()).collect();
            let members = Some(self.groups.iter().map(ids).collect());
            later.groups = Some(GroupsConfig { members, ..GroupsConfig::default() });
            for group in &self.groups {
                let last = group.iter().map(|&i| starts[i]).fold(0.0, f64::max);
                group.iter().for_each(|&i| starts[i] = last);
            }
        }
        let waits = starts.iter().any(|&start| start > 0.0);
        if waits {
            later.start = None;
        }
        for (agent, start) in self.agents.iter().zip(starts) {
            if waits {
                later.agents.entry(agent.id.clone()).or_default().start = Some((start - time).max(0.0));
            }
            if !begun.is_empty() {
                let mut walker = agent.walker.clone();
                begun.iter().for_each(|motivation| walker.motivate(motivation));
                let own = later.agents.entry(agent.id.clone()).or_default();
                (own.desired_speed, own.time_gap) = (Some(walker.desired_speed), Some(walker.time_gap));
                own.standstill_gap = Some(walker.standstill_gap);
                own.push = (walker.push < UNLIMITED).then_some(walker.push);
            }
        }
        later
    }

    /// Returns how many people come per second, by all sources that have a rate; `None` without such.
    pub fn arrivals(&self) -> Option<f64> {
        self.sources.iter().filter_map(|source| source.rate).reduce(|a, b| a + b)
    }

    /// Returns whether somebody chooses an exit by more than where it is: by the expected time, by what is open, or with
    /// others.
    pub fn chooses(&self) -> bool {
        let chooses = |agent: &Planned| agent.destination == Destination::NearestExit;
        (self.exit_choice == ExitChoice::Time || self.chooses_at_once()) && self.agents.iter().any(chooses)
    }

    /// Returns whether those who choose do so before the first step.
    pub(crate) fn chooses_at_once(&self) -> bool {
        let exits = self.targets.iter().filter(|target| !target.stay).count();
        !self.groups.is_empty()
            || exits > 1 && !self.doors.is_empty()
            || self.targets.iter().any(|target| target.open.is_some() || target.most.is_some())
    }

    /// Returns whether an exit closes after some people.
    pub(crate) fn counts(&self) -> bool {
        self.targets.iter().any(|target| target.most.is_some())
    }

    /// Returns whether an exit or a door opens or closes between two times \[s\].
    pub(crate) fn opens_or_closes(&self, before: f64, now: f64) -> bool {
        self.targets.iter().any(|exit| exit.is_open(before) != exit.is_open(now))
            || self.doors.iter().any(|door| door.is_open(before) != door.is_open(now))
    }

    /// Says in a Trial who comes later, also where it does not.
    pub fn mark_absent(&self, trial: &mut Trial) {
        let late = self.sources.iter().flat_map(|source| &source.people);
        late.for_each(|(i, _)| trial.dynamics[*i].absent = true);
    }

    /// Returns whether they leave in the end, of everybody.
    pub fn leaving(&self) -> Vec<bool> {
        let leaves = |agent: &Planned| match agent.destination {
            Destination::None => false,
            Destination::NearestExit => true,
            Destination::Target(k) => self.targets.get(k).is_some_and(|target| !target.stay),
        };
        let mut all: Vec<bool> = self.agents.iter().map(leaves).collect();
        let never = self.sources.iter().filter(|source| source.times.is_empty());
        never.flat_map(|source| &source.people).for_each(|(i, _)| all[*i] = false);
        all
    }

    /// Returns the different ways of way-points, at most so many.
    pub fn ways_of_points(&self, most: usize) -> Vec<&[Waypoint]> {
        let mut ways: Vec<&[Waypoint]> = Vec::new();
        for Planned { walker, .. } in &self.agents {
            let way = &walker.waypoints[..];
            if ways.len() < most && !way.is_empty() && !ways.contains(&way) {
                ways.push(way);
            }
        }
        ways
    }

    /// Returns the ways to exits and goals; `None` if nobody goes to one. Where people choose an exit, each has a way.
    ///
    /// # Errors
    /// The area is too large.
    pub fn ways(&self, choosing: bool) -> Result<Option<Ways>, PlanError> {
        if self.agents.iter().all(|agent| agent.destination == Destination::None) {
            return Ok(None);
        }
        // After way-points, people are elsewhere.
        let places = self.agents.iter().flat_map(|agent| {
            let own = agent.pose.position;
            let further = agent.walker.waypoints.iter().map(|w| vec2(w.x, w.y));
            std::iter::once(own).chain(further).map(|at| (at, agent.destination))
        });
        if !choosing {
            return Ways::new(&self.walls, &self.links, &self.targets, places).map(Some);
        }
        let exits = self.targets.iter().enumerate().filter(|(_, target)| !target.stay);
        let choices =
            exits.map(|(k, exit)| (vec2(exit.corners[0][0], exit.corners[0][1]), Destination::Target(k)));
        let ways = Ways::new(&self.walls, &self.links, &self.targets, places.chain(choices))?;
        let ways = if self.exit_choice == ExitChoice::Time { ways.with_widths()? } else { ways };
        let doors: Vec<Vec<[Vec2; 2]>> = self.doors.iter().map(|door| door.sides().collect()).collect();
        Ok(Some(if doors.is_empty() { ways } else { ways.with_doors(doors)? }))
    }
}
