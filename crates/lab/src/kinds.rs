//! Kinds of people, as a page shows them: a picture of each from above, and of agents what goes along.

use crate::{Refused, Reply};
use lemons_core::plane::{Disk, Vec2};
use lemons_core::trial::{Agent, Trial};
use lemons_people::{
    Kind, Kinds, Member, PAPER_BICYCLES, PART_MATERIALS, Person, Population, Proportions, Shape, Source,
    people_fitting,
};
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};

/// Returns all kinds that a crowd may have, in the order of their names: an example of each (the first of seed 1; disks x,
/// y, radius \[m\] in its frame), and the sources of its numbers.
///
/// # Errors
/// None: the table is read by a test.
pub fn all() -> Result<Reply, Refused> {
    let kinds = Kinds::built_in()?;
    let shown: Result<Vec<Value>, Refused> = kinds.iter().map(|kind| one(&kinds, kind)).collect();
    Ok(Reply::of(json!(shown?)))
}

fn one(kinds: &Kinds, kind: &Kind) -> Result<Value, Refused> {
    let mix = kinds.mix(&[(kind.name.clone(), 1.0)].into())?;
    let population = Population::new(Source::ansur()?, Proportions::default(), PAPER_BICYCLES)?.mixed(mix);
    let agent = population.agents(1).next();
    let member = agent.as_ref().and_then(|agent| agent.member());
    let disks: Vec<[f64; 3]> =
        member.map_or(Vec::new(), |member| member.disks.iter().map(|part| flat(&part.disk)).collect());
    let things: Vec<Option<&str>> = member
        .map_or(Vec::new(), |member| member.disks.iter().map(|part| part.material.as_deref()).collect());
    Ok(json!({
        "kind": kind.name, "disks": disks, "things": things, "seated": member.and_then(sitting),
        "sources": kind.sources,
    }))
}

fn flat(disk: &Disk) -> [f64; 3] {
    [disk.centre.x, disk.centre.y, disk.radius]
}

/// Of each disk the material of the thing that it is of; null of those of bodies. Null if there are only these.
pub fn things(agent: &Agent) -> Option<Vec<Option<&str>>> {
    let of = |id: &str| PART_MATERIALS.into_iter().find(|part| *part == id);
    let all: Vec<Option<&str>> = agent.shapes.iter().map(|disk| of(&disk.material_id)).collect();
    all.iter().any(Option::is_some).then_some(all)
}

/// Of each kind that somebody is of, and that the table has, the names of what goes along.
pub fn parts(trial: &Trial) -> BTreeMap<String, Vec<String>> {
    let Ok(kinds) = Kinds::built_in() else { return BTreeMap::new() };
    let names: BTreeSet<&String> = trial.agents.iter().filter_map(|agent| agent.kind.as_ref()).collect();
    let named = names.into_iter().filter_map(|name| Some((name, kinds.get(name)?)));
    let parts = |kind: &Kind| {
        let child = kind.companion.map(|_| "child".to_owned());
        kind.parts.iter().map(|part| part.name.clone()).chain(child).collect()
    };
    named.map(|(name, kind)| (name.clone(), parts(kind))).collect()
}

/// The disks of somebody who is seated, which the mechanics has not: where it sits. Of a Trial that is opened they are
/// those of the mean man.
pub fn seated(agent: &Agent, made: Option<&Member>) -> Option<Vec<[f64; 3]>> {
    match made {
        Some(member) => sitting(member),
        None => {
            let (kind, people) = people_fitting(agent)?;
            disks_of(&kind, &people)
        }
    }
}

fn sitting(member: &Member) -> Option<Vec<[f64; 3]>> {
    disks_of(&member.kind, &member.people)
}

fn disks_of(kind: &Kind, people: &[(Person, Vec2)]) -> Option<Vec<[f64; 3]>> {
    let (person, at) = people.first().filter(|_| kind.seated)?;
    let shape = Shape::of(person).ok()?;
    Some(shape.disks.iter().map(|disk| [disk.centre.x + at.x, disk.centre.y + at.y, disk.radius]).collect())
}
