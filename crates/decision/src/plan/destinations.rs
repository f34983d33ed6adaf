//! Exits and goals, and who goes to which.

use crate::config::{DecisionConfig, TargetConfig};
use crate::error::{PlanError, not_negative, positive};
use crate::person::Person;
use crate::target::{Destination, Target};

/// Returns the exits, then the goals.
pub(super) fn targets_of(config: &DecisionConfig) -> Result<Vec<Target>, PlanError> {
    let mut targets: Vec<Target> = Vec::new();
    let kinds = [("exit", "exits", &config.exits, false), ("goal", "goals", &config.goals, true)];
    for (kind, key, wanted, stay) in kinds {
        for (k, TargetConfig { name, line, polygon, share }) in wanted.iter().flatten().enumerate() {
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

/// Returns where everybody goes: the own wish; else by the shares of exits; else the nearest exit; else the only goal.
pub(super) fn destinations(
    people: &[Person],
    config: &DecisionConfig,
    targets: &[Target],
) -> Result<Vec<Destination>, PlanError> {
    let exits = targets.iter().filter(|target| !target.stay).count();
    let shared = shared(people, config)?;
    let usual = match exits {
        0 if targets.len() == 1 => Destination::Target(0),
        0 => Destination::None,
        _ => Destination::NearestExit,
    };
    let one = |(person, shared): (&Person, Option<usize>)| {
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
    people.iter().zip(shared).map(one).collect()
}

/// Returns the names of the exits, or of the goals.
pub(super) fn names(targets: &[Target], stay: bool) -> String {
    let names =
        targets.iter().filter(|target| target.stay == stay).map(|target| format!("{:?}", target.name));
    names.collect::<Vec<_>>().join(", ")
}

/// Returns the exit of everybody by shares: as many people for each as its share says, chosen by the seed.
fn shared(people: &[Person], config: &DecisionConfig) -> Result<Vec<Option<usize>>, PlanError> {
    let exits = config.exits.as_deref().unwrap_or_default();
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
    let seed = config.seed.unwrap_or(0);
    order.sort_by_key(|&i| crate::stuck::draw(seed, i as u64, u64::MAX));
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
