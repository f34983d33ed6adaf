//! Kinds of people, as a page shows them: a picture of each from above, and of agents what goes along.

use crate::{Refused, Reply};
use lemons_core::plane::{Disk, Vec2};
use lemons_core::trial::{Agent, Trial};
use lemons_people::{
    Kinds, Member, PART_MATERIALS, Person, PersonKind, Population, PopulationSource, Shape, people_fitting,
};
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// A kind of people, with somebody of it as an example.
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
pub(crate) struct KindShown {
    kind: String,
    disks: Vec<[f64; 3]>,
    things: Things,
    /// The disks of who sits in a wheelchair: they are drawn, and nothing of the mechanics.
    seated: Option<Vec<[f64; 3]>>,
    /// Where the numbers of the kind are from.
    sources: Vec<String>,
}

/// Of each disk the material of the thing that it is of; `None` where it is of a body.
pub(crate) type Things = Vec<Option<String>>;

/// Returns all kinds that a crowd may have, in the order of their names: an example of each (the first of seed 1; disks x,
/// y, radius \[m\] in its frame), and the sources of its numbers.
///
/// # Errors
/// None: the table is read by a test.
pub fn all() -> Result<Reply, Refused> {
    let kinds = Kinds::built_in()?;
    let shown: Result<Vec<KindShown>, Refused> = kinds.iter().map(|kind| one(&kinds, kind)).collect();
    Reply::of(shown?)
}

fn one(kinds: &Kinds, kind: &PersonKind) -> Result<KindShown, Refused> {
    let mix = kinds.mix(&[(kind.name.clone(), 1.0)].into())?;
    let population = Population::new(PopulationSource::ansur()?, 0.5)?.mixed(mix);
    let agent = population.agents(1).next();
    let member = agent.as_ref().and_then(|agent| agent.member());
    let disks: Vec<[f64; 3]> =
        member.map_or(Vec::new(), |member| member.disks.iter().map(|part| flat(&part.disk)).collect());
    let things =
        member.map_or(Vec::new(), |member| member.disks.iter().map(|part| part.material.clone()).collect());
    let (kind, sources) = (kind.name.clone(), kind.sources.clone());
    Ok(KindShown { kind, disks, things, seated: member.and_then(sitting), sources })
}

fn flat(disk: &Disk) -> [f64; 3] {
    [disk.centre.x, disk.centre.y, disk.radius]
}

/// Of each disk the material of the thing that it is of. `None` if there are only disks of bodies.
pub(crate) fn things(agent: &Agent) -> Option<Things> {
    let of = |id: &String| PART_MATERIALS.contains(&&**id).then(|| id.clone());
    let all: Things = agent.shapes.iter().map(|disk| of(&disk.material_id)).collect();
    all.iter().any(Option::is_some).then_some(all)
}

/// Of each kind that somebody is of, and that the table has, the names of what goes along.
pub fn parts(trial: &Trial) -> BTreeMap<String, Vec<String>> {
    let Ok(kinds) = Kinds::built_in() else { return BTreeMap::new() };
    let names: BTreeSet<&String> = trial.agents.iter().filter_map(|agent| agent.kind.as_ref()).collect();
    let named = names.into_iter().filter_map(|name| Some((name, kinds.get(name)?)));
    let parts = |kind: &PersonKind| {
        let child = kind.companion.map(|_| "child".to_owned());
        let bicycle = kind.bicycle.then(|| "bicycle".to_owned());
        kind.parts.iter().map(|part| part.name.clone()).chain(bicycle).chain(child).collect()
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

fn disks_of(kind: &PersonKind, people: &[(Person, Vec2)]) -> Option<Vec<[f64; 3]>> {
    let (person, at) = people.first().filter(|_| kind.seated)?;
    let shape = Shape::of(person).ok()?;
    Some(shape.disks.iter().map(|disk| [disk.centre.x + at.x, disk.centre.y + at.y, disk.radius]).collect())
}
