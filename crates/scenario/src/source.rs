//! Sources: people who come later, where they appear, and what they do.

use crate::error::{Of, Result, impossible, require, within};
use crate::forms::{self, Share, TwoNumbers};
use crate::place::WalkableRoom;
use crate::{MOST_PEOPLE, Scenario};
use lemons_core::plane::{Bounds, Pose, Ring, Vec2, nearest_on_segment, vec2};
use lemons_core::trial::Trial;
use lemons_decision::config::AgentConfig;
use lemons_decision::rule::Waypoint;
use lemons_decision::source::SourceConfig;
use lemons_decision::stuck::{draw, share};
use lemons_decision::{Decision, DecisionConfig, Plan};
use lemons_people::{CrowdMember, Kinds, Population};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Places that are tried for each person.
const TRIES: u64 = 1000;

/// A line or an area on which people appear, one after the other.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields, default)]
pub struct SourceForm {
    /// Name.
    pub name: Option<String>,
    /// \[m\] Ends of a line.
    pub line: Option<Vec<TwoNumbers>>,
    /// \[m\] Corners of an area.
    pub polygon: Option<Vec<TwoNumbers>>,
    /// Number of people; if it is not said, as many as there are times.
    pub number: Option<u32>,
    /// \[1/s\] Mean number of people per time.
    pub rate: Option<f64>,
    /// \[s\] Time between two people.
    pub every: Option<f64>,
    /// \[s\] When somebody comes.
    pub times: Option<Vec<f64>>,
    /// \[s\] From when on people come by `rate` or `every`.
    pub start: Option<f64>,
    /// Shares of kinds of people, instead of the scenario's.
    #[cfg_attr(feature = "typescript", ts(type = "Record<string, number | \"rest\">"))]
    pub mix: BTreeMap<String, Share>,
    /// Way of its people.
    #[cfg_attr(feature = "typescript", ts(type = "Waypoint[] | null"))]
    pub waypoints: Option<Vec<Waypoint>>,
    /// Name of their exit.
    pub exit: Option<String>,
    /// Name of their goal.
    pub goal: Option<String>,
}

impl SourceForm {
    fn corners(&self) -> Vec<Vec2> {
        self.line.iter().chain(&self.polygon).flatten().map(|corner| corner.0.into()).collect()
    }

    /// Returns the number of its people.
    pub fn people(&self) -> usize {
        let times = self.times.as_ref().map_or(0, Vec::len);
        self.number.map_or(times, |number| number as usize)
    }

    /// Returns what decision.toml says of it, of people with these Ids.
    fn config(&self, people: Vec<String>) -> SourceConfig {
        let SourceForm { name, rate, every, times, start, .. } = self.clone();
        SourceConfig { name, people, rate, every, times, start }
    }

    /// Checks the source of a place in the list.
    pub(crate) fn check(&self, k: usize) -> Result<()> {
        let place = format!("`sources`: source {k}");
        let is_one = match (&self.line, &self.polygon) {
            (Some(ends), None) => ends.len() == 2,
            (None, Some(corners)) => corners.len() > 2,
            _ => false,
        };
        require(is_one, || format!("{place}: give a line of two points, or a polygon of three or more"))?;
        require(self.number.is_some() || self.times.is_some(), || format!("{place}: number: is missing"))?;
        within(format_args!("{place}: number"), self.people() as f64, [1.0, f64::from(MOST_PEOPLE)])?;
        let flat = self.polygon.is_some()
            && !Ring::through(self.corners()).is_some_and(|ring| ring.area() > 0.0 && ring.is_simple());
        require(!flat, || format!("{place}: polygon: must have an area, and sides that do not cross"))?;
        self.config(Vec::new()).due("", self.people(), 0, k).map_err(|error| {
            let error = error.to_string();
            impossible(format!("{place}: {}", error.trim_start_matches(": ")))
        })?;
        if !self.mix.is_empty() {
            Kinds::built_in()?.mix(&forms::shares(&self.mix)?).of(format_args!("{place}: mix"))?;
        }
        Ok(())
    }
}

impl Scenario {
    /// Returns a seed of a source: another one for each seed of the scenario, source and use.
    fn seed_of_source(&self, k: usize, of: u64) -> u64 {
        draw(self.seed(), u64::MAX - k as u64, of)
    }

    /// Draws the people of all sources.
    pub(crate) fn arriving(&self, population: &Population) -> Result<Vec<Vec<CrowdMember>>> {
        let draw = |(k, source): (usize, &SourceForm)| {
            let mut own = population.clone();
            if !source.mix.is_empty() {
                own = own.mixed(Kinds::built_in()?.mix(&forms::shares(&source.mix)?)?);
            }
            let seed = self.seed_of_source(k, 0);
            Ok(own.agents(seed).take(source.people()).collect())
        };
        self.sources.iter().enumerate().map(draw).collect()
    }

    /// Finds a place for each of the people of sources: in the room, clear of walls however they turn. Places of several may
    /// overlap: they are not there at once.
    pub(crate) fn entries(
        &self,
        place: &WalkableRoom,
        people: &[Vec<CrowdMember>],
    ) -> Result<Vec<(CrowdMember, Pose)>> {
        let faces: Vec<[Vec2; 2]> = place.geometry.walls.iter().flat_map(|wall| wall.sides()).collect();
        let inside = |at: Vec2| {
            let mut grounds = place.grounds.iter().map(|ground| &ground.free.region);
            place.has_regions || grounds.any(|region| region.is_plane() || region.contains(at))
        };
        let mut placed = Vec::new();
        for (k, (source, people)) in self.sources.iter().zip(people).enumerate() {
            let corners = source.corners();
            let ring = source.polygon.as_ref().and_then(|_| Ring::through(corners.clone()));
            let Some(Bounds { low, high }) = Bounds::of(corners.iter().copied()) else { continue };
            let seed = self.seed_of_source(k, 1);
            for person in people {
                let disks = self.shape_of(person)?.disks;
                let reach = disks.iter().map(|disk| disk.centre.norm() + disk.radius).fold(0.0, f64::max);
                let clear = |[a, b]: &[Vec2; 2], at| (nearest_on_segment(*a, *b, at) - at).norm() > reach;
                let who = placed.len() as u64;
                let drawn = |n| {
                    let [u, v] = [2 * n, 2 * n + 1].map(|n| share(seed, who, n));
                    let at = match &ring {
                        None => corners[0] + (corners[1] - corners[0]) * u,
                        Some(_) => vec2(low.x + (high.x - low.x) * u, low.y + (high.y - low.y) * v),
                    };
                    let within = ring.as_ref().is_none_or(|ring| ring.contains(at)) && inside(at);
                    (within && faces.iter().all(|face| clear(face, at))).then_some(at)
                };
                let at = (0..TRIES).find_map(drawn).ok_or_else(|| {
                    let place = &place.name;
                    impossible(format!(
                        "`sources`: source {k}: it has no place, inside {place} and {reach:.2} m from all walls, for one \
                         of its people"
                    ))
                })?;
                placed.push((person.clone(), Pose { position: at, orientation: 0.0 }));
            }
        }
        Ok(placed)
    }

    /// Adds what its sources say to a decision.toml; their people are the last ones of a Trial.
    pub(crate) fn with_sources(&self, config: &mut DecisionConfig, trial: &Trial) {
        let count: usize = self.sources.iter().map(SourceForm::people).sum();
        let mut ids = trial.agents[trial.agents.len() - count..].iter().map(|agent| agent.id.clone());
        for source in &self.sources {
            let ids: Vec<String> = ids.by_ref().take(source.people()).collect();
            let SourceForm { waypoints, exit, goal, .. } = source;
            let way = (waypoints.clone(), exit.clone(), goal.clone());
            for id in ids.iter().filter(|_| way != (None, None, None)) {
                let own: &mut AgentConfig = config.agents.entry(id.clone()).or_default();
                (own.waypoints, own.exit, own.goal) = way.clone();
            }
            config.sources.push(source.config(ids));
        }
        if !self.sources.is_empty() {
            config.seed.get_or_insert(self.seed());
        }
    }

    /// Lets those who come later of a plan come at a walk, as they would walk alone.
    pub(crate) fn let_walk(trial: &mut Trial, plan: &Plan) -> Result<()> {
        let velocities = Decision::velocities(plan.clone()).map_err(|error| impossible(error.message))?;
        for (i, _) in plan.sources.iter().flat_map(|source| &source.people) {
            let own = &mut trial.dynamics[*i];
            own.absent = true;
            (own.velocity, own.theta) = velocities[*i].unwrap_or((own.velocity, own.theta));
        }
        Ok(())
    }
}
