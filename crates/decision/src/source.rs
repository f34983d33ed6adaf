//! People who are not there at the start: they come, one after the other, where there is room.

use crate::error::{PlanError, moderate, number};
use crate::stuck::share;
use lemons_core::plane::{Pose, Vec2, rotation, vec2};
use lemons_core::trial::Trial;
use serde::{Deserialize, Serialize};
use std::collections::{HashMap, HashSet};

/// \[m/s\] By so much others may become faster, or turn, within the step before somebody comes.
pub(crate) const SPARE_SPEED: f64 = 1.0;
/// People of a source who are asked in a step whether there is room for them.
pub(crate) const ASKED: usize = 20;

/// A source: people who come by one way into the room. One of `rate`, `every` and `times`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SourceConfig {
    /// As messages name it.
    pub name: Option<String>,
    /// Ids of its people, who come in this order if there is room for each.
    pub people: Vec<String>,
    /// \[1/s\] Mean number per time, of independent arrivals.
    pub rate: Option<f64>,
    /// \[s\] Time between two arrivals; the first one is at the start.
    pub every: Option<f64>,
    /// \[s\] When somebody comes, in order.
    pub times: Option<Vec<f64>>,
    /// \[s\] From when on people come, by `rate` or `every`.
    pub start: Option<f64>,
}

/// A source of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// Name.
    pub name: String,
    /// Places of its people in `agents`, and the velocity \[m/s\] with which each comes.
    pub people: Vec<(usize, Vec2)>,
    /// \[s\] When one more is due, in order.
    pub times: Vec<f64>,
    /// \[1/s\] Mean number per time; `None` of a timetable.
    pub rate: Option<f64>,
    /// \[s\] From when on people come at this rate.
    pub start: f64,
}

impl Source {
    /// Returns how many are due at a time \[s\]. A rounding error is not a time.
    pub fn due(&self, time: f64) -> usize {
        self.times.partition_point(|due| *due <= time + 1e-9)
    }

    /// Returns by how much \[s\] its clock is ahead after a step \[s\], if it runs `factor` times as fast since it has begun:
    /// the arrivals of a Poisson process remain one.
    pub(crate) fn ahead(&self, before: f64, factor: f64, time: f64, step: f64) -> f64 {
        let running = time + step - time.max(self.start);
        match self.rate {
            Some(_) if running > 0.0 => (before + (factor - 1.0) * running).min(f64::MAX),
            _ => before,
        }
    }
}

impl SourceConfig {
    /// Returns when so many people are due \[s\], in order; `number_of_it` is the place of the source, for the draws.
    ///
    /// # Errors
    /// It says no time, or several, or one that is out of range.
    pub fn due(
        &self,
        place: &str,
        people: usize,
        seed: u64,
        number_of_it: usize,
    ) -> Result<Vec<f64>, PlanError> {
        let start = self.start.unwrap_or(0.0);
        moderate(place, "start", start)?;
        let mut time = start;
        let all: Vec<f64> = match (self.rate, self.every, &self.times) {
            (Some(rate), None, None) => {
                let must = "from 1e-6 to 1000 people per s";
                number(place, "rate", rate, |rate| (1e-6..=1e3).contains(&rate), must)?;
                let draws = u64::MAX - 16 - number_of_it as u64;
                let next = |k| {
                    time -= libm::log1p(-share(seed, draws, k)) / rate;
                    time
                };
                (0..people as u64).map(next).collect()
            }
            (None, Some(every), None) => {
                number(place, "every", every, |every| (1e-3..=1e6).contains(&every), "from 0.001 to 1e6 s")?;
                (0..people).map(|k| start + k as f64 * every).collect()
            }
            (None, None, Some(times)) if self.start.is_none() => {
                times.iter().try_for_each(|time| moderate(place, "times", *time))?;
                let wrong = |value, must| {
                    Err(PlanError::Value { place: place.to_owned(), key: "times", value, must })
                };
                if let Some(pair) = times.windows(2).find(|pair| pair[1] < pair[0]) {
                    return wrong(format!("{pair:?}"), "in order");
                }
                if times.len() < people {
                    let must = "as many as there are people, or more";
                    return wrong(format!("{} times for {people} people", times.len()), must);
                }
                times[..people].to_vec()
            }
            _ => return Err(PlanError::WhenOfSource { place: place.to_owned() }),
        };
        all.last().map_or(Ok(()), |last| moderate(place, "the last arrival", *last))?;
        Ok(all)
    }
}

/// Returns the sources of a plan for the people of a Trial.
///
/// # Errors
/// Names or people are there twice, or are not known; or times are not possible.
pub(crate) fn sources(trial: &Trial, all: &[SourceConfig], seed: u64) -> Result<Vec<Source>, PlanError> {
    let places: HashMap<&str, usize> =
        trial.agents.iter().enumerate().map(|(i, agent)| (&*agent.id, i)).collect();
    let (mut taken, mut names) = (HashSet::new(), HashSet::new());
    let mut made = Vec::new();
    for (k, config) in all.iter().enumerate() {
        let (place, name) = (format!("sources[{k}]"), config.name.clone().unwrap_or(format!("source {k}")));
        let person = |id: &String| {
            let error = |problem| PlanError::OfSource { place: place.clone(), id: id.clone(), problem };
            let i = *places.get(&**id).ok_or_else(|| error("there is no agent with this Id"))?;
            let own = &trial.dynamics[i];
            taken.insert(i).then_some((i, own.velocity)).ok_or_else(|| error("comes twice"))
        };
        let people = config.people.iter().map(person).collect::<Result<Vec<_>, _>>()?;
        let times = config.due(&place, people.len(), seed, k)?;
        if !names.insert(name.clone()) {
            return Err(PlanError::SameSource { place, name });
        }
        let rate = config.rate.or(config.every.map(|every| 1.0 / every));
        made.push(Source { name, people, times, rate, start: config.start.unwrap_or(0.0) });
    }
    // Who is not there, and of no source, never comes.
    let all = trial.dynamics.iter().enumerate().filter(|(i, own)| own.absent && !taken.contains(i));
    let people: Vec<_> = all.map(|(i, own)| (i, own.velocity)).collect();
    if !people.is_empty() {
        made.push(Source { name: String::new(), people, times: Vec::new(), rate: None, start: 0.0 });
    }
    Ok(made)
}

/// \[m\] Returns how far a body of disks x, y, radius that face along x reaches from its centre of mass.
pub(crate) fn reach(disks: &[[f64; 3]]) -> f64 {
    disks.iter().map(|&[x, y, radius]| vec2(x, y).norm() + radius).fold(0.0, f64::max)
}

/// Returns such disks in a pose, by centres and radii \[m\].
pub(crate) fn placed(disks: &[[f64; 3]], pose: Pose) -> impl Iterator<Item = (Vec2, f64)> {
    let at = move |place: Vec2| pose.position + rotation(pose.orientation) * place;
    disks.iter().map(move |&[x, y, radius]| (at(vec2(x, y)), radius))
}
