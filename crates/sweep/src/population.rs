//! `[population]` of a `sweep.toml`: each point has a crowd of its own, drawn and placed as `lemons crowd --box --door --leave`
//! does it, from the same seed the same one.

use crate::error::{Error, Place, Result};
use crate::points::Points;
use lemons_core::plane::{Pose, Vec2};
use lemons_core::trial::{DriveTable, TIMES};
use lemons_decision::{DEFAULT_SPEED, DecisionConfig, Plan, Spread, WalkingModelName};
use lemons_master::ensure;
use lemons_people::placing::{Method, Orientation, Region, Settings, within_area};
use lemons_people::{
    Agent, Door, Kinds, PAPER_BICYCLES, Proportions, Shape, Source, TrialSettings, closed_walls, crowd_trial,
    cut_doors, heading, walls,
};
use lemons_sim::Documents;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use std::collections::BTreeMap;
use std::ops::ControlFlow;

/// Prefix of the parameters that are keys of the population.
pub(crate) const PREFIX: &str = "population.";
/// Largest number of people.
const MOST: u32 = 1_000_000;

/// Crowd and its room.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Population {
    number: u32,
    /// \[m\] Of the room, whose lower left corner is the origin.
    #[serde(rename = "box", deserialize_with = "two")]
    sides: [f64; 2],
    /// \[m\] x, y and width of each, then the times \[s\] from and to which it is open; with doors, everybody leaves.
    #[serde(default)]
    doors: Vec<Vec<f64>>,
    #[serde(default = "first_seed")]
    seed: u64,
    /// Share of men.
    #[serde(default = "half")]
    men: f64,
    /// Shares of kinds.
    #[serde(default)]
    mix: BTreeMap<String, Share>,
    /// \[°\] Where people look at first; without it, anywhere.
    direction: Option<f64>,
    #[serde(default = "skin")]
    material: String,
    /// \[m/s\] Everybody's desired speed; without it that of each kind.
    speed: Option<f64>,
    #[serde(default = "usual_model")]
    model: WalkingModelName,
    /// \[s\] When people start to walk.
    start: Option<Spread>,
    /// Part of the people who are in groups.
    groups: Option<f64>,
}

/// The share of a kind.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged, expecting = "expected a number, or \"rest\": what the others leave of 100")]
enum Share {
    Number(f64),
    Rest(Rest),
}

#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Rest {
    Rest,
}

/// An array of TOML that is too long would be cut.
fn two<'de, D: Deserializer<'de>>(from: D) -> Result<[f64; 2], D::Error> {
    let numbers = Vec::<f64>::deserialize(from)?;
    let count = numbers.len();
    numbers.try_into().map_err(|_| D::Error::custom(format!("must be two numbers, not {count}")))
}

fn first_seed() -> u64 {
    1
}

fn half() -> f64 {
    0.5
}

fn skin() -> String {
    lemons_people::SKINS[0].to_owned()
}

fn usual_model() -> WalkingModelName {
    WalkingModelName::Rotational
}

impl Population {
    /// Returns of each parameter whether it is a key of the population.
    ///
    /// # Errors
    /// There is no such key, or a value cannot be read.
    pub fn choosers(&self, points: &Points) -> Result<Vec<bool>> {
        let parameter = |parameter: &crate::points::Parameter| {
            let Some(key) = parameter.name.strip_prefix(PREFIX) else { return Ok(false) };
            let set = |value: &String| self.clone().set(key, value).map(|_| true);
            parameter.values().iter().try_fold(true, |_, value| set(value)).place(|| parameter.name.clone())
        };
        points.parameters.iter().map(parameter).collect()
    }

    /// Returns the population of a point.
    ///
    /// # Errors
    /// A value is not possible with the others of the point.
    pub fn at(&self, points: &Points, point: usize) -> Result<Population> {
        let keys = points.parameters.iter().filter_map(|of| Some((of, of.name.strip_prefix(PREFIX)?)));
        let mut own = self.clone();
        for (parameter, key) in keys {
            own = own.set(key, parameter.at(point)).place(|| parameter.name.clone())?;
        }
        own.check()?;
        Ok(own)
    }

    /// Sets a key to a value that is only read, not checked: other keys of a point may make it possible.
    fn set(mut self, key: &str, value: &str) -> Result<Population> {
        let number = || value.parse::<f64>().ok().filter(|number| number.is_finite());
        let number = || number().ok_or_else(|| Error::Spec(format!("{value:?}: must be a finite number")));
        let whole =
            || value.parse::<u64>().map_err(|_| Error::Spec(format!("{value:?}: must be a whole number")));
        match key {
            "number" => self.number = u32::try_from(whole()?).unwrap_or(u32::MAX),
            "seed" => self.seed = whole()?,
            "men" => self.men = number()?,
            "speed" => self.speed = Some(number()?),
            "width" => {
                ensure(!self.doors.is_empty(), || "there are no doors to have a width")?;
                let width = number()?;
                self.doors.iter_mut().filter_map(|door| door.get_mut(2)).for_each(|own| *own = width);
            }
            "groups" => self.groups = Some(number()?),
            "start" => self.start = Some(Spread::Same(number()?)),
            _ => match key.strip_prefix("mix.") {
                Some(kind) => drop(self.mix.insert(kind.to_owned(), Share::Number(number()?))),
                None => {
                    return Err(
                        "there is no such parameter of a population; they are number, seed, men, speed, \
                                start, groups, width (of all doors) and mix.KIND"
                            .into(),
                    );
                }
            },
        }
        Ok(self)
    }

    /// Checks keys and values.
    ///
    /// # Errors
    /// One is not possible: key, value and why.
    pub fn check(&self) -> Result<()> {
        let Population { number, sides, doors, men, speed, direction, start, groups, .. } = self;
        ensure((1..=MOST).contains(number), || format!("number = {number}: must be from 1 to {MOST}"))?;
        let [width, height] = sides;
        let good = sides.iter().all(|side| (0.1..=1e4).contains(side));
        ensure(good, || format!("box = [{width}, {height}]: must be from 0.1 to 10000 m"))?;
        for numbers in doors {
            let door = Door::of_numbers(numbers);
            let good = door.is_some_and(|Door { at, width, .. }| {
                [at.x, at.y].iter().all(|at| at.abs() <= 1e4) && (0.01..=1e4).contains(&width)
            });
            ensure(good, || {
                format!(
                    "doors: {numbers:?}: must be x, y and a width of at least 0.01, in m, up to 10000; then, if it \
                     opens and closes, {TIMES}"
                )
            })?;
        }
        let set = [("start", start.is_some()), ("groups", groups.is_some())];
        if let Some((key, _)) = set.iter().find(|(_, set)| *set && doors.is_empty()) {
            return Err(Error::Spec(format!("{key}: without doors, nobody walks")));
        }
        let known = start.map_or(Ok(()), |start| start.check("start"));
        known.map_err(|error| Error::Spec(error.to_string()))?;
        ensure(groups.is_none_or(|share| (0.0..=1.0).contains(&share)), || {
            format!("groups = {}: must be from 0 to 1", groups.unwrap_or_default())
        })?;
        ensure((0.0..=1.0).contains(men), || format!("men = {men}: must be from 0 to 1"))?;
        let known = lemons_people::SKINS;
        ensure(known.contains(&&*self.material), || {
            format!("material = {:?}: must be one of {}", self.material, known.join(", "))
        })?;
        for (key, value, [low, high]) in
            [("speed", speed, [0.0, 20.0]), ("direction", direction, [-360.0, 360.0])]
        {
            let good = value.is_none_or(|value| (low..=high).contains(&value));
            ensure(good, || format!("{key} = {}: must be from {low} to {high}", value.unwrap_or_default()))?;
        }
        self.shares().map(drop)
    }

    /// The kinds with their shares; none: adults with nothing.
    fn shares(&self) -> Result<Vec<(std::sync::Arc<lemons_people::Kind>, f64)>> {
        if self.mix.is_empty() {
            return Ok(Vec::new());
        }
        let numbers = self.mix.values().filter_map(|share| match share {
            Share::Number(share) => Some(share),
            Share::Rest(_) => None,
        });
        let (sum, count) = (numbers.clone().sum::<f64>(), numbers.count());
        ensure(
            count + 1 >= self.mix.len(),
            || "mix: \"rest\" is there twice: only one kind can be the rest",
        )?;
        let rest = 100.0 - sum;
        ensure(count == self.mix.len() || rest >= 0.0, || {
            format!("mix: the others have {sum} together: nothing of 100 is left for the \"rest\"")
        })?;
        let share = |(name, share): (&String, &Share)| {
            let share = if let Share::Number(share) = share { *share } else { rest };
            (name.clone(), share)
        };
        let mix = Kinds::built_in().and_then(|kinds| kinds.mix(&self.mix.iter().map(share).collect()));
        mix.map_err(|error| Error::Spec(error.to_string())).place(|| "mix".into())
    }

    /// Draws and places the people, and makes the documents of their Trial.
    ///
    /// # Errors
    /// They do not fit, or cannot leave.
    pub fn documents(&self) -> Result<Documents> {
        let wrong = |error: lemons_people::PeopleError| Error::Spec(error.to_string());
        let region = Region::rectangle(Vec2::zeros(), self.sides.into()).map_err(wrong)?;
        let uncut = walls(region.rings(), "concrete");
        let closed = closed_walls(&uncut);
        let doors: Vec<Door> = self.doors.iter().filter_map(|numbers| Door::of_numbers(numbers)).collect();
        let geometry = cut_doors(uncut, &doors).map_err(wrong)?;
        let proportions = Proportions { men: self.men, ..Proportions::default() };
        let source = Source::ansur().map_err(wrong)?;
        let population =
            lemons_people::Population::new(source, proportions, PAPER_BICYCLES).map_err(wrong)?;
        let population = population.mixed(self.shares()?);
        let agents: Vec<Agent> = population.agents(self.seed).take(self.number as usize).collect();
        let shapes = agents.iter().map(Agent::shape).collect::<Result<Vec<Shape>, _>>().map_err(wrong)?;
        let orientation =
            self.direction.map_or(Orientation::Free, |angle| Orientation::Towards(angle.to_radians()));
        let settings = Settings { orientation, seed: self.seed, ..Settings::default() };
        let mut watch = |_: &_| ControlFlow::Continue(());
        let tried = within_area(&shapes, &region);
        let packing = Method::Dense.place(tried, &region, &settings, &mut watch).map_err(wrong)?;
        ensure(packing.complete && tried.len() == shapes.len(), || {
            let Population { number, sides: [width, height], .. } = self;
            let about = (packing.clear_density * width * height).floor();
            format!(
                "number = {number}: so many people do not fit into box = [{width}, {height}]; about {about} of them do"
            )
        })?;
        let crowd: Vec<(Agent, Pose)> = agents.iter().cloned().zip(packing.poses).collect();
        let leaves = !doors.is_empty();
        let pushed = self.speed.filter(|_| !leaves).unwrap_or(0.0);
        let settings = TrialSettings {
            desired_velocity: heading(self.direction.unwrap_or(0.0)) * pushed,
            people: self.material.clone(),
            ..TrialSettings::default()
        };
        let trial = crowd_trial("crowd", &crowd, geometry, &settings).map_err(wrong)?;
        let people = crowd.iter().map(|(_, pose)| pose.position);
        let lines =
            doors.iter().filter_map(|door| Some((door.exit(&closed, people.clone())?, door.exit_times())));
        let exits =
            lines.enumerate().map(|(k, (line, open))| (format!("door {k}"), line.map(Into::into), open));
        let own =
            agents.iter().enumerate().filter_map(|(id, agent)| Some((id.to_string(), agent.member()?.speed)));
        let own: Vec<(String, f64)> = own.filter(|_| self.speed.is_none()).collect();
        let wishes = DecisionConfig::leaving(self.model, self.speed.unwrap_or(DEFAULT_SPEED), exits)
            .with_starts_and_groups(self.start, self.groups, self.seed)
            .with_speeds(own);
        let plan = leaves.then(|| Plan::of(&trial, &wishes)).transpose();
        let plan = plan.map_err(|error| Error::Spec(format!("people cannot leave: {error}")))?;
        Ok(Documents { trial, drive: DriveTable::default(), plan })
    }
}
