//! Changes by hand: people are moved, copied, taken away.

use crate::base::Driven;
use crate::{Refused, require, within};
use lemons_core::plane::{Vec2, vec2};
use lemons_core::trial::{Agent, AgentDynamics, Interactions};
use serde::Deserialize;

/// Most changes of a Trial.
const MOST: usize = 10_000;

/// A change of one person: whom it is, and to where \[m, rad\].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs)] // as said
pub enum Edit {
    /// Elsewhere, or turned.
    Move { id: String, x: f64, y: f64, theta: f64 },
    /// Another one with the same shape, at rest, with an Id of its own.
    Copy { id: String, r#as: String, x: f64, y: f64, theta: f64 },
    /// Away.
    Delete { id: String },
}

/// Makes the changes one after the other. Contacts that the Trial remembers are forgotten if there are any.
///
/// # Errors
/// There is nobody with an Id, an Id is there already, nobody would be left, or a number is not finite.
pub fn edited(mut driven: Driven, edits: &[Edit]) -> Result<Driven, Refused> {
    require(edits.len() <= MOST, || format!("{} changes by hand: at most {MOST}", edits.len()))?;
    for edit in edits {
        let (Edit::Move { id, .. } | Edit::Copy { id, .. } | Edit::Delete { id }) = edit;
        let place = driven.trial.agents.iter().position(|agent| agent.id == *id);
        let place = place.ok_or_else(|| Refused(format!("there is nobody with the Id {id:?}")))?;
        change(&mut driven, place, edit)?;
        driven.trial.interactions = Interactions::default();
    }
    require(!driven.trial.agents.is_empty(), || "nobody would be left".into())?;
    Ok(driven)
}

fn change(driven: &mut Driven, place: usize, edit: &Edit) -> Result<(), Refused> {
    let (trial, people) = (&mut driven.trial, &mut driven.people);
    match edit {
        Edit::Move { x, y, theta, .. } => {
            let here = &mut trial.dynamics[place];
            (here.position, here.theta) = pose(*x, *y, *theta)?;
        }
        Edit::Copy { r#as: to, x, y, theta, .. } => {
            let odd = to.trim().is_empty() || to.len() > 100 || to.chars().any(char::is_control);
            let taken = trial.agents.iter().any(|agent| agent.id == *to);
            require(!odd && !taken, || format!("the Id {to:?} is no short text, or there already"))?;
            let (position, theta) = pose(*x, *y, *theta)?;
            trial.agents.push(Agent { id: to.clone(), ..trial.agents[place].clone() });
            let still = AgentDynamics { velocity: Vec2::ZERO, omega: 0.0, ..trial.dynamics[place].clone() };
            trial.dynamics.push(AgentDynamics { position, theta, ..still });
            if let Some(people) = people {
                people.push(people[place]);
            }
        }
        Edit::Delete { .. } => {
            trial.agents.remove(place);
            trial.dynamics.remove(place);
            if let Some(people) = people {
                people.remove(place);
            }
        }
    }
    Ok(())
}

fn pose(x: f64, y: f64, theta: f64) -> Result<(Vec2, f64), Refused> {
    for (what, value) in [("x [m]", x), ("y [m]", y), ("the angle [rad]", theta)] {
        within(what, value, [-1e6, 1e6])?;
    }
    Ok((vec2(x, y), theta))
}
