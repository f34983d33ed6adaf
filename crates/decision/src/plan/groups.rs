//! Groups: who stays together with whom.

use crate::cells::{Cells, sees};
use crate::config::{DecisionConfig, GroupsConfig};
use crate::error::{MOST_MEMBERS, PlanError, not_negative, number, positive};
use crate::stuck::{draw, share};
use lemons_core::plane::{InPlane, Vec2};
use lemons_core::trial::{Agent, AgentDynamics, Trial, Wall};
use std::collections::{HashMap, HashSet};

/// Relative numbers of groups of two, three and four: those of a Poisson distribution with a mean of 1.
const USUAL_SIZES: [f64; 3] = [12.0, 4.0, 1.0];
/// \[m\] Members of a drawn group are not further from its first one at the start.
const NEAR: f64 = 3.0;
/// Draws of a person that are those of the order in which groups are drawn, and of their sizes.
const ORDER_DRAW: u64 = u64::MAX - 4;
const SIZE_DRAW: u64 = u64::MAX - 5;

/// Returns the groups as places in the order of people: those of the settings, then drawn ones.
pub(super) fn groups(trial: &Trial, config: &DecisionConfig) -> Result<Vec<Vec<usize>>, PlanError> {
    let Some(wanted) = &config.groups else { return Ok(Vec::new()) };
    let people = &trial.agents;
    let mut free = vec![true; people.len()];
    // Who comes later is near nobody.
    let late: HashSet<&String> = config.sources.iter().flat_map(|source| &source.people).collect();
    free.iter_mut().zip(people).for_each(|(free, person)| *free &= !late.contains(&person.id));
    let mut groups = configured(wanted, people, &mut free)?;
    let part = wanted.share.unwrap_or(0.0);
    number("groups", "share", part, |part| (0.0..=1.0).contains(&part), "from 0 to 1")?;
    let sizes = wanted.sizes.as_deref().unwrap_or(&USUAL_SIZES);
    if !(1..MOST_MEMBERS).contains(&sizes.len()) {
        return Err(PlanError::GroupSizes);
    }
    sizes.iter().try_for_each(|size| not_negative("groups", "sizes", *size))?;
    let sum: f64 = sizes.iter().sum();
    positive("groups", "the sum of all sizes", sum)?;

    // Who has a place of their own to go to has it alone.
    for (free, person) in free.iter_mut().zip(people) {
        let own = config.agents.get(&person.id);
        *free &= own.is_none_or(|own| own.exit.is_none() && own.goal.is_none() && own.waypoints.is_none());
    }
    let seed = config.seed.unwrap_or(0);
    let mut left = (part * free.iter().filter(|free| **free).count() as f64).round() as usize;
    let mut order: Vec<usize> = (0..people.len()).collect();
    order.sort_by_key(|&i| draw(seed, i as u64, ORDER_DRAW));
    // Places that are no numbers are refused later.
    let place = |own: &AgentDynamics| Some(own.position).filter(|at| at.is_finite());
    let places: Vec<Option<Vec2>> = trial.dynamics.iter().map(place).collect();
    let faces: Vec<[Vec2; 2]> = trial.geometry.fixed_walls().flat_map(Wall::sides).collect();
    // Nobody is looked for where no group is drawn.
    let around: &[_] = if left < 2 { &[] } else { &places };
    let cells = Cells::new(around, |at| *at, &faces, (NEAR, NEAR), |j, at| (j, *at));
    for i in order {
        if left < 2 {
            break;
        }
        let Some(at) = places[i].filter(|_| free[i]) else { continue };
        let mut drawn = share(seed, i as u64, SIZE_DRAW) * sum;
        let bigger = sizes.iter().take_while(|size| {
            drawn -= **size;
            drawn >= 0.0
        });
        // Also if the last sizes are rounded away.
        let others = (bigger.count() + 1).min(sizes.len()).min(left - 1);
        let (cell, mut near) = (cells.cell(at), Vec::new());
        cells.block(cell, 1, |&(j, place)| {
            let far = (place - at).norm();
            if free[j] && j != i && far <= NEAR {
                near.push((far, j, place));
            }
        });
        near.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let seen = near.into_iter().filter(|(_, _, place)| sees(at, *place, cells.faces(cell)));
        let group: Vec<usize> = std::iter::once(i).chain(seen.map(|(_, j, _)| j).take(others)).collect();
        if group.len() > 1 {
            group.iter().for_each(|&j| free[j] = false);
            left -= group.len();
            groups.push(group);
        }
    }
    Ok(groups)
}

/// Returns the groups of the settings, and takes their members from those who are `free`.
fn configured(
    wanted: &GroupsConfig,
    people: &[Agent],
    free: &mut [bool],
) -> Result<Vec<Vec<usize>>, PlanError> {
    // Of people with the same Id, the first one.
    let places: HashMap<&str, usize> =
        people.iter().enumerate().rev().map(|(i, person)| (&*person.id, i)).collect();
    let place = |(group, id): (usize, &String), free: &mut [bool]| {
        let error = |problem| PlanError::Member { group, id: id.clone(), problem };
        let i = places.get(&**id).copied();
        let i = i.ok_or_else(|| error("there is no agent with this Id"))?;
        if !std::mem::replace(&mut free[i], false) {
            return Err(error("is in a group already, or comes later (`sources`)"));
        }
        Ok(i)
    };
    let mut groups = Vec::new();
    for (k, ids) in wanted.members.iter().flatten().enumerate() {
        groups.push(ids.iter().map(|id| place((k, id), free)).collect::<Result<Vec<_>, _>>()?);
    }
    Ok(groups)
}

/// Returns for each person whose exit, goal and way-points in `[agents.ID]` count: of a group, those of the one who has
/// any.
///
/// # Errors
/// Two members have different ones.
pub(super) fn leads(
    people: &[Agent],
    config: &DecisionConfig,
    groups: &[Vec<usize>],
) -> Result<Vec<usize>, PlanError> {
    let mut leads: Vec<usize> = (0..people.len()).collect();
    for group in groups {
        let own = |i: usize| {
            let own = config.agents.get(&people[i].id)?;
            let own = (&own.exit, &own.goal, &own.waypoints);
            (own != (&None, &None, &None)).then_some(own)
        };
        let first = group.iter().copied().find(|&i| own(i).is_some()).unwrap_or(group[0]);
        if let Some(&other) = group.iter().find(|&&i| own(i).is_some() && own(i) != own(first)) {
            let [one, other] = [first, other].map(|i| people[i].id.clone());
            return Err(PlanError::GroupParts { one, other });
        }
        group.iter().for_each(|&i| leads[i] = first);
    }
    Ok(leads)
}
