//! The plan for the people of a Trial that follows from wishes: everything for each agent.
//!
//! A plan is TOML (`decision.toml` in the FMU's resources).

use crate::error::{MOST_TARGETS, MOST_WAYPOINTS, PlanError, not_negative, number, positive};
use crate::gait::Gait;
use crate::person::Person;
use crate::rule::{Pose, Walker, Waypoint};
use crate::target::{Destination, Target, Ways};
use crate::wishes::{WantedTarget, Wish, Wishes};
use lemons_plane::{Vec2, vec2};
use lemons_trial::Trial;
use serde::{Deserialize, Serialize};

/// \[m\] Radius of a way-point that gives none.
const DEFAULT_RADIUS: f64 = 0.3;
/// \[m/s\] Mean speed of pedestrians who walk freely (Weidmann 1993).
const DEFAULT_SPEED: f64 = 1.34;
/// An agent of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Planned {
    /// Id in Agents.xml.
    pub id: String,
    /// Where it goes after the last way-point.
    #[serde(default, skip_serializing_if = "is_none")]
    pub destination: Destination,
    /// See [`Person::disks`]; empty where nobody looks at them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub disks: Vec<[f64; 3]>,
    /// Start values of the inputs.
    pub pose: Pose,
    /// The data for the rule.
    pub walker: Walker,
}

fn is_none(destination: &Destination) -> bool {
    *destination == Destination::None
}

/// The initial data of the FMU.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// \[s\] `DefaultExperiment.stepSize`
    pub time_step: f64,
    /// Chooses who does what when nobody gets on.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub seed: u64,
    /// \[m\] Corners (x, y) of each wall; none if nobody looks at them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub walls: Vec<Vec<[f64; 2]>>,
    /// How people walk among others.
    #[serde(default, skip_serializing_if = "is_straight")]
    pub gait: Gait,
    /// Exits and goals.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub targets: Vec<Target>,
    /// In the order of Agents.xml; at least one.
    pub agents: Vec<Planned>,
}

fn is_zero(seed: &u64) -> bool {
    *seed == 0
}

fn is_straight(gait: &Gait) -> bool {
    *gait == Gait::Straight
}

impl Plan {
    /// Makes a plan from wishes for the people of a Trial, among its walls.
    ///
    /// # Errors
    /// Those of [`Plan::among`].
    pub fn of(trial: &Trial, wishes: &Wishes) -> Result<Plan, PlanError> {
        let walls = trial.geometry.walls.iter().map(|wall| &wall.corners[..]);
        Plan::among(walls, &Person::all_of(trial), wishes, trial.parameters.time_step)
    }

    /// Makes a plan from wishes for these people, where there are no walls.
    ///
    /// # Errors
    /// Those of [`Plan::among`].
    pub fn new(people: &[Person], wishes: &Wishes, time_step: f64) -> Result<Plan, PlanError> {
        Plan::among(std::iter::empty(), people, wishes, time_step)
    }

    /// Makes a plan from wishes for these people among walls.
    ///
    /// # Errors
    /// There is a wish for an unknown agent, exit or goal, an agent without way-points and exits, an exit to which no
    /// way leads, or a number out of range.
    pub fn among<'a>(
        walls: impl Iterator<Item = &'a [Vec2]>,
        people: &[Person],
        wishes: &Wishes,
        time_step: f64,
    ) -> Result<Plan, PlanError> {
        if let Some(unknown) = wishes.agents.keys().find(|id| people.iter().all(|person| person.id != **id)) {
            return Err(PlanError::UnknownAgent(unknown.clone()));
        }
        let gait = wishes.gait()?;
        let targets = targets_of(wishes)?;
        let destinations = destinations(people, wishes, &targets)?;
        let nothing = Wish::default();
        let agents = people.iter().zip(destinations).map(|(person, destination)| {
            let own = wishes.agents.get(&person.id).unwrap_or(&nothing);
            let waypoints = own.waypoints.as_ref().or(wishes.waypoints.as_ref());
            let waypoints = waypoints.map_or(&[][..], |waypoints| &waypoints[..]);
            if waypoints.is_empty() && destination == Destination::None {
                return Err(PlanError::NoWaypoint(person.id.clone()));
            }
            Ok(Planned {
                id: person.id.clone(),
                destination,
                disks: if gait.sees_others() { person.disks.clone() } else { Vec::new() },
                pose: person.pose,
                walker: Walker {
                    mass: person.mass,
                    moment_of_inertia: person.moment_of_inertia,
                    floor_damping: person.floor_damping,
                    angular_damping: person.angular_damping,
                    desired_speed: own.desired_speed.or(wishes.desired_speed).unwrap_or(DEFAULT_SPEED),
                    waypoints: waypoints
                        .iter()
                        .map(|w| Waypoint { x: w.x, y: w.y, radius: w.radius.unwrap_or(DEFAULT_RADIUS) })
                        .collect(),
                },
            })
        });
        let agents = agents.collect::<Result<_, PlanError>>()?;
        // Who sees neither walls nor exits needs no copy of them.
        let seen = gait.sees_others() || !targets.is_empty();
        let walls = walls.filter(|_| seen).map(|wall| wall.iter().map(|at| [at.x, at.y]).collect()).collect();
        let plan =
            Plan { time_step, seed: wishes.seed.unwrap_or(0), walls, gait, targets, agents }.checked()?;
        plan.check_ways()?;
        Ok(plan)
    }

    /// Reads TOML.
    ///
    /// # Errors
    /// Those of [`Wishes::from_toml`], or numbers out of range.
    pub fn from_toml(text: &str) -> Result<Plan, PlanError> {
        toml::from_str::<Plan>(text).map_err(|error| PlanError::Toml(error.to_string()))?.checked()
    }

    /// Returns TOML. Every number is read back as the same double.
    ///
    /// # Errors
    /// The plan cannot be written.
    pub fn to_toml(&self) -> Result<String, PlanError> {
        toml::to_string(self).map_err(|error| PlanError::Toml(error.to_string()))
    }

    /// How many leave in the end.
    pub fn leaving(&self) -> usize {
        (0..self.agents.len()).filter(|agent| self.has_exit(*agent)).count()
    }

    /// The different ways of way-points, at most so many.
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

    /// Whether an agent leaves in the end.
    pub fn has_exit(&self, agent: usize) -> bool {
        match self.agents.get(agent).map(|agent| agent.destination) {
            Some(Destination::NearestExit) => true,
            Some(Destination::Target(k)) => self.targets.get(k).is_some_and(|target| !target.stay),
            _ => false,
        }
    }

    /// The walls as polylines.
    pub fn polylines(&self) -> Vec<Vec<Vec2>> {
        self.walls.iter().map(|wall| wall.iter().map(|&[x, y]| vec2(x, y)).collect()).collect()
    }

    /// The ways to exits and goals; `None` if nobody goes to one.
    ///
    /// # Errors
    /// The area is too large.
    pub fn ways(&self) -> Result<Option<Ways>, PlanError> {
        if self.agents.iter().all(|agent| agent.destination == Destination::None) {
            return Ok(None);
        }
        // After way-points, people are elsewhere.
        let places = self.agents.iter().flat_map(|agent| {
            let own = vec2(agent.pose.x, agent.pose.y);
            let further = agent.walker.waypoints.iter().map(|w| vec2(w.x, w.y));
            std::iter::once(own).chain(further).map(|at| (at, agent.destination))
        });
        Ok(Some(Ways::new(&self.polylines(), &self.targets, places)?))
    }

    /// From where they start, or from their last way-point, all must be able to reach their destination.
    fn check_ways(&self) -> Result<(), PlanError> {
        let Some(ways) = self.ways()? else { return Ok(()) };
        if let Some(shut) = ways.shut().first() {
            return Err(PlanError::Shut { place: self.targets[*shut].named() });
        }
        for agent in self.agents.iter().filter(|agent| agent.destination != Destination::None) {
            let last = agent.walker.waypoints.last().map(|w| vec2(w.x, w.y));
            let from = last.unwrap_or(vec2(agent.pose.x, agent.pose.y));
            if !ways.distance(agent.destination, from).is_finite() {
                let to = match agent.destination {
                    Destination::Target(k) => self.targets[k].named(),
                    _ => {
                        let exits = self.targets.iter().filter(|target| !target.stay);
                        let names: Vec<String> = exits.map(|exit| format!("{:?}", exit.name)).collect();
                        format!("any exit ({})", names.join(", "))
                    }
                };
                let [x, y] = [from.x, from.y].map(|number| format!("{number:.2}"));
                return Err(PlanError::NoWay { agent: agent.id.clone(), x, y, to });
            }
        }
        Ok(())
    }

    fn checked(self) -> Result<Plan, PlanError> {
        if self.agents.is_empty() {
            return Err(PlanError::Empty);
        }
        positive("the plan", "time_step", self.time_step)?;
        self.gait.check()?;
        for corner in self.walls.iter().flatten().flatten() {
            number("a wall", "corner", *corner, |_| true, "finite")?;
        }
        if self.targets.len() > MOST_TARGETS {
            return Err(PlanError::TooManyTargets(self.targets.len()));
        }
        for target in &self.targets {
            let place = target.named();
            for corner in target.corners.iter().flatten() {
                number(&place, "corner", *corner, |_| true, "finite")?;
            }
            if target.corners.len() < 2 {
                return Err(PlanError::LineOrPolygon { place });
            }
            let flat = target.area().is_some_and(|ring| !(ring.area() > 0.0 && ring.is_simple()));
            let point = target.corners.iter().all(|corner| *corner == target.corners[0]);
            if flat || point {
                let must = "a line of some length, or a polygon with an area whose sides do not cross";
                let value = format!("{:?}", target.corners);
                return Err(PlanError::Value { place, key: "corners", value, must });
            }
        }
        for agent in &self.agents {
            let (place, walker, pose) = (format!("agent {:?}", agent.id), &agent.walker, &agent.pose);
            if matches!(agent.destination, Destination::Target(k) if k >= self.targets.len()) {
                let value = format!("{:?}", agent.destination);
                return Err(PlanError::Value {
                    place,
                    key: "destination",
                    value,
                    must: "one of the targets",
                });
            }
            if walker.waypoints.len() > MOST_WAYPOINTS {
                let (agent, count) = (agent.id.clone(), walker.waypoints.len());
                return Err(PlanError::TooManyWaypoints { agent, count });
            }
            for length in agent.disks.iter().flatten() {
                number(&place, "disk", *length, |_| true, "finite")?;
            }
            positive(&place, "mass", walker.mass)?;
            positive(&place, "moment_of_inertia", walker.moment_of_inertia)?;
            not_negative(&place, "floor_damping", walker.floor_damping)?;
            not_negative(&place, "angular_damping", walker.angular_damping)?;
            not_negative(&place, "desired_speed", walker.desired_speed)?;
            for (key, value) in [("x", pose.x), ("y", pose.y), ("theta", pose.theta)] {
                number(&place, key, value, |_| true, "finite")?;
            }
            for (k, waypoint) in walker.waypoints.iter().enumerate() {
                let place = format!("{place}, way-point {k}");
                number(&place, "x", waypoint.x, |_| true, "finite")?;
                number(&place, "y", waypoint.y, |_| true, "finite")?;
                not_negative(&place, "radius", waypoint.radius)?;
            }
        }
        Ok(self)
    }
}

/// Wishes in which everybody goes somewhere: without those of people who are not there, and, where there are several
/// goals and no exits, with the goal that is nearest on foot at the start for each who names none.
///
/// # Errors
/// An exit or a goal is not one, or the area is too large.
pub fn settled(trial: &Trial, wishes: &Wishes) -> Result<Wishes, PlanError> {
    let people = Person::all_of(trial);
    let mut wishes = wishes.without_others(&people).unwrap_or_else(|| wishes.clone());
    for none in [&mut wishes.exits, &mut wishes.goals] {
        none.take_if(|places| places.is_empty());
    }
    let targets = targets_of(&wishes)?;
    if targets.len() < 2 || targets.iter().any(|target| !target.stay) {
        return Ok(wishes);
    }
    let walls: Vec<Vec<Vec2>> = trial.geometry.walls.iter().map(|wall| wall.corners.clone()).collect();
    let at = |person: &Person| vec2(person.pose.x, person.pose.y);
    let all = people
        .iter()
        .flat_map(|person| (0..targets.len()).map(move |target| (at(person), Destination::Target(target))));
    let ways = Ways::new(&walls, &targets, all)?;
    for person in &people {
        let far = |target: usize| ways.distance(Destination::Target(target), at(person));
        let nearest = (0..targets.len()).min_by(|a, b| far(*a).total_cmp(&far(*b)));
        let own = wishes.agents.entry(person.id.clone()).or_default();
        if own.goal.is_none() && own.exit.is_none() {
            own.goal = nearest.map(|target| targets[target].name.clone());
        }
    }
    Ok(wishes)
}

/// The exits, then the goals.
fn targets_of(wishes: &Wishes) -> Result<Vec<Target>, PlanError> {
    let mut targets: Vec<Target> = Vec::new();
    let kinds = [("exit", "exits", &wishes.exits, false), ("goal", "goals", &wishes.goals, true)];
    for (kind, key, wanted, stay) in kinds {
        for (k, WantedTarget { name, line, polygon, share }) in wanted.iter().flatten().enumerate() {
            let place = format!("{key}[{k}]");
            let name = name.clone().unwrap_or_else(|| format!("{kind} {k}"));
            let corners = match (line, polygon) {
                (Some(line), None) => line.to_vec(),
                (None, Some(polygon)) if polygon.len() > 2 => polygon.clone(),
                (None, Some(polygon)) => {
                    let (value, must) = (format!("{polygon:?}"), "three corners or more");
                    return Err(PlanError::Value { place, key: "polygon", value, must });
                }
                _ => return Err(PlanError::LineOrPolygon { place }),
            };
            if let Some(share) = share {
                not_negative(&place, "share", *share)?;
            }
            if targets.iter().any(|other| other.name == name) {
                return Err(PlanError::SameName { place, name });
            }
            targets.push(Target { name, stay, corners });
        }
    }
    Ok(targets)
}

/// Where everybody goes: the own wish; else by the shares of exits; else the nearest exit; else the only goal.
fn destinations(
    people: &[Person],
    wishes: &Wishes,
    targets: &[Target],
) -> Result<Vec<Destination>, PlanError> {
    let exits = targets.iter().filter(|target| !target.stay).count();
    let shared = shared(people, wishes)?;
    let usual = match exits {
        0 if targets.len() == 1 => Destination::Target(0),
        0 => Destination::None,
        _ => Destination::NearestExit,
    };
    let one = |(person, shared): (&Person, Option<usize>)| {
        let own = wishes.agents.get(&person.id);
        let named = |key: &'static str, name: &String, stay: bool| {
            let found = targets.iter().position(|target| target.stay == stay && target.name == *name);
            found.map(Destination::Target).ok_or_else(|| {
                let known: Vec<String> = targets
                    .iter()
                    .filter(|target| target.stay == stay)
                    .map(|target| format!("{:?}", target.name))
                    .collect();
                let known = if known.is_empty() { "none".into() } else { known.join(", ") };
                PlanError::UnknownTarget { agent: person.id.clone(), key, name: name.clone(), known }
            })
        };
        match own.map(|own| (&own.exit, &own.goal)) {
            Some((Some(_), Some(_))) => Err(PlanError::Both(person.id.clone())),
            Some((Some(exit), None)) => named("exit", exit, false),
            Some((None, Some(goal))) => named("goal", goal, true),
            _ => Ok(shared.map_or(usual, Destination::Target)),
        }
    };
    people.iter().zip(shared).map(one).collect()
}

/// The exit of everybody by shares: as many people for each as its share says, chosen by the seed.
fn shared(people: &[Person], wishes: &Wishes) -> Result<Vec<Option<usize>>, PlanError> {
    let exits = wishes.exits.as_deref().unwrap_or_default();
    let shares: Vec<f64> = exits.iter().filter_map(|exit| exit.share).collect();
    if shares.is_empty() {
        return Ok(vec![None; people.len()]);
    }
    let sum: f64 = shares.iter().sum();
    if shares.len() != exits.len() {
        return Err(PlanError::SomeShares);
    }
    positive("exits", "the sum of all shares", sum)?;
    let mut order: Vec<usize> = (0..people.len()).collect();
    let seed = wishes.seed.unwrap_or(0);
    order.sort_by_key(|&i| crate::patience::draw(seed, i as u64, u64::MAX));
    let (mut taken, mut next, mut chosen) = (0.0, 0, vec![None; people.len()]);
    for (k, share) in shares.iter().enumerate() {
        taken += share / sum;
        let end = (taken * people.len() as f64).round() as usize;
        while next < end.min(people.len()) {
            chosen[order[next]] = Some(k);
            next += 1;
        }
    }
    Ok(chosen)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn person(id: &str) -> Person {
        Person {
            id: id.into(),
            mass: 70.1,
            moment_of_inertia: 1.0 / 3.0,
            floor_damping: 2.0,
            angular_damping: 0.1,
            pose: Pose { x: 1e-300, y: -0.0, theta: 3.0 },
            disks: Vec::new(),
        }
    }

    fn plan(wishes: &str) -> Result<Plan, String> {
        let wishes = Wishes::from_toml(wishes).map_err(|error| error.to_string())?;
        Plan::new(&[person("0"), person("two words")], &wishes, 0.05).map_err(|error| error.to_string())
    }

    #[test]
    fn wishes_are_for_everybody_or_for_one() {
        let plan = plan(
            "desired_speed = 1\nwaypoints = [{ x = 1, y = 2.5 }]\n[agents.\"two words\"]\nwaypoints = [{ x = 0, y = 0, radius = 2 }, { x = 3, y = 4 }]",
        )
        .unwrap();
        let walkers = [&plan.agents[0].walker, &plan.agents[1].walker];
        assert_eq!(walkers[0].waypoints, [Waypoint { x: 1.0, y: 2.5, radius: DEFAULT_RADIUS }]);
        assert_eq!(walkers[1].waypoints.len(), 2);
        assert_eq!(walkers[1].waypoints[0].radius, 2.0);
        assert_eq!(walkers.map(|walker| walker.desired_speed), [1.0, 1.0]);
    }

    #[test]
    fn a_plan_reads_back_to_the_last_bit() {
        let plan = plan("waypoints = [{ x = 0.1, y = 1e-320, radius = 0 }]").unwrap();
        assert_eq!(Plan::from_toml(&plan.to_toml().unwrap()).unwrap(), plan);
    }

    #[test]
    fn mistakes_are_named() {
        for (wishes, words) in [
            ("waypoint = []", ["waypoint", "line 1"]),
            ("waypoints = [{ x = 1 }]", ["missing field `y`", "line 1"]),
            ("waypoints = [{ x = 1, y = nan }]", ["way-point 0", "y = NaN"]),
            ("waypoints = [{ x = 1, y = 0, radius = -1 }]", ["radius = -1.0", "at least 0"]),
            ("waypoints = []", ["agent \"0\"", "no way-point"]),
            ("desired_speed = 1.0", ["agent \"0\"", "no way-point"]),
            ("desired_speed = -1.0\nwaypoints = [{ x = 1, y = 0 }]", ["desired_speed = -1.0", "agent \"0\""]),
            ("desired_speed = \"fast\"", ["desired_speed", "line 1"]),
            ("waypoints = [{ x = 1, y = 0 }]\n[agents.9]", ["agents.9", "no agent"]),
            ("waypoints = [", ["line 1", "waypoints"]),
        ] {
            let message = plan(wishes).unwrap_err();
            assert!(words.iter().all(|word| message.contains(word)), "{wishes}: {message}");
        }
        assert_eq!(Plan::from_toml("time_step = 1\nagents = []"), Err(PlanError::Empty));
    }
}
