//! Exits and goals, and who goes to which, and on which way.

use crate::config::{DecisionConfig, TargetConfig};
use crate::error::{PlanError, not_negative, positive};
use crate::exit_choice::ExitChoice;
use crate::target::{Destination, Target};
use lemons_core::trial::Agent;

/// Draws of a person that are those of the exit and of the way.
const EXIT_DRAW: u64 = u64::MAX;
const WAY_DRAW: u64 = u64::MAX - 3;

/// Returns the exits, then the goals.
pub(super) fn targets_of(config: &DecisionConfig) -> Result<Vec<Target>, PlanError> {
    let mut targets: Vec<Target> = Vec::new();
    let by = config.exit_choice;
    let kinds = [("exit", "exits", &config.exits, false), ("goal", "goals", &config.goals, true)];
    for (kind, key, wanted, stay) in kinds {
        for (k, config) in wanted.iter().flatten().enumerate() {
            let TargetConfig { name, line, polygon, share, open, most, time_factor } = config;
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
            if time_factor.is_some() && by != Some(ExitChoice::Time) {
                return Err(PlanError::NotByTime(k));
            }
            if targets.iter().any(|other| other.name == name) {
                return Err(PlanError::SameName { place, name });
            }
            let (open, time_factor) = (open.clone(), time_factor.unwrap_or(1.0));
            targets.push(Target { name, stay, corners, open, most: *most, time_factor });
        }
    }
    Ok(targets)
}

/// Returns where everybody goes: the own destination; else by the shares of exits; else the nearest exit; else the only goal. Of
/// each person, the settings of one who `leads` count.
pub(super) fn destinations(
    people: &[Agent],
    config: &DecisionConfig,
    targets: &[Target],
    groups: &[Vec<usize>],
    leads: &[usize],
) -> Result<Vec<Destination>, PlanError> {
    let exits = targets.iter().filter(|target| !target.stay).count();
    let shares: Vec<Option<f64>> = config.exits.iter().flatten().map(|exit| exit.share).collect();
    let shares = all_or_none(&shares).ok_or(PlanError::SomeShares)?;
    let shared = if let Some(shares) = shares {
        positive("exits", "the sum of all shares", shares.iter().sum())?;
        by_shares(&shares, people.len(), groups, config.seed.unwrap_or(0), EXIT_DRAW)
            .into_iter()
            .map(Some)
            .collect()
    } else {
        vec![None; people.len()]
    };
    let usual = match exits {
        0 if targets.len() == 1 => Destination::Target(0),
        0 => Destination::None,
        _ => Destination::NearestExit,
    };
    let one = |(lead, shared): (&usize, Option<usize>)| {
        let person = &people[*lead];
        let own = config.agents.get(&person.id);
        let named = |key: &'static str, name: &String, stay: bool| {
            let found = targets.iter().position(|target| target.stay == stay && target.name == *name);
            found.map(Destination::Target).ok_or_else(|| {
                let known = Some(names(targets, stay)).filter(|known| !known.is_empty());
                let known = known.unwrap_or_else(|| "none".into());
                PlanError::UnknownTarget { agent: person.id.clone(), key, name: name.clone(), known }
            })
        };
        match own.map(|own| (&own.exit, &own.goal)) {
            Some((Some(_), Some(_))) => Err(PlanError::Both(person.id.clone())),
            Some((Some(exit), None)) => named("exit", exit, false),
            Some((None, Some(goal))) => named("goal", goal, true),
            // Who has legs, and is said to have no way, stands.
            _ if config.has_legs()
                && own.is_some_and(|own| own.waypoints.as_ref().is_some_and(Vec::is_empty)) =>
            {
                Ok(Destination::None)
            }
            _ => Ok(shared.map_or(usual, Destination::Target)),
        }
    };
    leads.iter().zip(shared).map(one).collect()
}

/// Returns the names of the exits, or of the goals.
pub(super) fn names(targets: &[Target], stay: bool) -> String {
    let names =
        targets.iter().filter(|target| target.stay == stay).map(|target| format!("{:?}", target.name));
    names.collect::<Vec<_>>().join(", ")
}

/// Returns the way of everybody, of several ways: as many people for each as its share says.
pub(super) fn ways(
    people: usize,
    config: &DecisionConfig,
    groups: &[Vec<usize>],
) -> Result<Vec<Option<usize>>, PlanError> {
    let Some(ways) = config.ways.as_ref().filter(|ways| !ways.is_empty()) else {
        return Ok(vec![None; people]);
    };
    if config.waypoints.is_some() {
        return Err(PlanError::WaysAndWaypoints);
    }
    let shares: Vec<Option<f64>> = ways.iter().map(|way| way.share).collect();
    let shares = all_or_none(&shares).ok_or(PlanError::SomeWayShares)?.unwrap_or(vec![1.0; ways.len()]);
    for (k, share) in shares.iter().enumerate() {
        not_negative(&format!("ways[{k}]"), "share", *share)?;
    }
    positive("ways", "the sum of all shares", shares.iter().sum())?;
    let chosen = by_shares(&shares, people, groups, config.seed.unwrap_or(0), WAY_DRAW);
    Ok(chosen.into_iter().map(Some).collect())
}

/// Returns all shares, or `Some(None)` if there is none; `None` if only some are there.
fn all_or_none(shares: &[Option<f64>]) -> Option<Option<Vec<f64>>> {
    if shares.iter().all(Option::is_none) {
        return Some(None);
    }
    shares.iter().copied().collect::<Option<Vec<f64>>>().map(Some)
}

/// Returns the choice of everybody by shares with a sum above 0: as many people for each as its share says, chosen by the
/// seed. A group chooses as one.
fn by_shares(shares: &[f64], people: usize, groups: &[Vec<usize>], seed: u64, count: u64) -> Vec<usize> {
    let sum: f64 = shares.iter().sum();
    let mut taken = 0.0;
    let ends: Vec<usize> = shares
        .iter()
        .map(|share| {
            taken += share / sum;
            (taken * people as f64).round() as usize
        })
        .collect();
    let last = shares.iter().rposition(|share| *share > 0.0).unwrap_or(0);
    let mut order: Vec<usize> = (0..people).collect();
    order.sort_by_key(|&i| crate::stuck::draw(seed, i as u64, count));
    let mut units: Vec<Option<&[usize]>> = vec![None; people];
    for group in groups {
        group.iter().for_each(|&i| units[i] = Some(group));
    }
    let (mut next, mut chosen) = (0, vec![usize::MAX; people]);
    for i in order {
        if chosen[i] == usize::MAX {
            let k = ends.iter().position(|end| next < *end).unwrap_or(last);
            let unit = units[i].unwrap_or(std::slice::from_ref(&i));
            unit.iter().for_each(|&j| chosen[j] = k);
            next += unit.len();
        }
    }
    chosen
}
