//! The drive of people: as the Trial says, nothing, pushes, ways to walk, or exits and goals. Those who walk and are of a
//! kind have the desired speed of their kind.

use crate::loaded::LoadedTrial;
use crate::reply::NO_WAY;
use crate::{Refused, require, within};
use lemons_core::message::message;
use lemons_core::plane::Vec2;
use lemons_core::trial::Trial;
use lemons_decision::rule::Waypoint;
use lemons_decision::{BalanceName, DecisionConfig, plan};
use lemons_scenario::Push;
use serde::Deserialize;

/// The drive of people.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(rename = "Motion"))]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs)] // as said
pub enum MotionChoice {
    /// The Trial's own files do.
    Own {},
    /// Nothing does.
    None {},
    /// Pulses do, and nothing else: whoever walks ahead is no part of a push.
    Push {
        pushes: Vec<Push>,
        /// Whether they have legs, and of which model.
        #[serde(default)]
        balance: BalanceName,
    },
    /// They walk (the paper's eq. 4) at a speed \[m/s\], everybody on the way whose first point is nearest; or on ways with
    /// shares, of which the seed chooses one for each.
    Walk {
        speed: f64,
        ways: Vec<Vec<Waypoint>>,
        #[serde(default)]
        shares: Option<Vec<f64>>,
        #[serde(default)]
        seed: u64,
    },
    /// They walk around walls, to the exits and goals of a decision.toml. Without exits, everybody goes to the nearest of
    /// several goals.
    Go {
        #[cfg_attr(feature = "typescript", ts(type = "DecisionConfig"))]
        decision: Box<DecisionConfig>,
    },
}

/// Replaces what drives the people.
///
/// # Errors
/// A number is out of range, nobody is in a circle, or there is no way.
pub fn with_motion(mut loaded: LoadedTrial, motion: &MotionChoice) -> Result<LoadedTrial, Refused> {
    if !matches!(motion, MotionChoice::Own {}) {
        loaded = LoadedTrial::alone(loaded.trial, loaded.people);
        for here in &mut loaded.trial.dynamics {
            (here.fp, here.mp) = (Vec2::zeros(), 0.0);
        }
    }
    let config = match motion {
        MotionChoice::Own {} => {
            // The files of a Trial must not name people who are not there any more.
            if loaded.table.check_agents(Some(&loaded.trial)).is_err() {
                loaded.push(loaded.table.of_those(&loaded.trial));
            }
            let text = loaded.decision.clone();
            let config = (!text.is_empty()).then(|| DecisionConfig::from_toml(&text)).transpose()?;
            let fewer = config.as_ref().and_then(|config| config.without_others(&loaded.trial.agents));
            if fewer.is_none() {
                return Ok(LoadedTrial { decision: text, ..loaded.decided(config)? });
            }
            fewer
        }
        MotionChoice::None {} => None,
        MotionChoice::Push { pushes, balance } => {
            loaded.push(lemons_scenario::drive(&loaded.trial, pushes)?);
            (*balance != BalanceName::None).then(|| DecisionConfig::standing(*balance))
        }
        MotionChoice::Walk { speed, ways, shares, seed } => {
            let shares = shares.as_deref().map(|shares| (shares, *seed));
            Some(config_of_ways(&loaded.trial, *speed, ways, shares)?.with_speeds(own_speeds(&loaded)))
        }
        MotionChoice::Go { decision } => {
            let decision = decision.as_ref().clone().with_speeds(own_speeds(&loaded));
            Some(plan::normalized(&loaded.trial, &decision)?)
        }
    };
    loaded.decided(config)
}

/// As [`lemons_scenario::own_speeds`], if people are known.
fn own_speeds(of: &LoadedTrial) -> Vec<(String, f64)> {
    of.people.as_ref().map_or_else(Vec::new, |people| lemons_scenario::own_speeds(people, &of.trial))
}

/// decision.toml: the ways of everybody; with shares and their seed, if there are some.
fn config_of_ways(
    trial: &Trial,
    speed: f64,
    ways: &[Vec<Waypoint>],
    shares: Option<(&[f64], u64)>,
) -> Result<DecisionConfig, Refused> {
    within("desired speed [m/s]", speed, [0.0, 20.0])?;
    for Waypoint { x, y, radius, .. } in ways.iter().flatten() {
        within("x of a way-point [m]", *x, [-1e4, 1e4])?;
        within("y of a way-point [m]", *y, [-1e4, 1e4])?;
        within("radius of a way-point [m]", *radius, [0.01, 1000.0])?;
    }
    if let Some((shares, seed)) = shares {
        require(shares.len() == ways.len(), || format!("{} shares of {} ways", shares.len(), ways.len()))?;
        return Ok(DecisionConfig::ways_by_shares(
            speed,
            ways.iter().cloned().zip(shares.iter().copied()),
            seed,
        ));
    }
    let decision = DecisionConfig::nearest_of(trial, speed, ways);
    decision.ok_or_else(|| Refused(message!(NO_WAY)))
}
