//! Settings in which everybody has a goal.

use super::checked::check_targets;
use super::destinations::targets_of;
use crate::config::DecisionConfig;
use crate::error::PlanError;
use crate::exit_choice::ExitChoice;
use crate::target::{Destination, Ways};
use lemons_core::plane::Vec2;
use lemons_core::trial::Trial;

/// Returns settings in which everybody goes somewhere: without those of people who are not there, and, where there are several
/// goals and no exits, with the goal that is nearest on foot at the start for each who names none. Of several exits without shares, people choose by
/// the expected time if nothing else is said.
///
/// # Errors
/// An exit or a goal is not one, or the area is too large.
pub fn normalized(trial: &Trial, config: &DecisionConfig) -> Result<DecisionConfig, PlanError> {
    let mut config = config.without_others(&trial.agents).unwrap_or_else(|| config.clone());
    for none in [&mut config.exits, &mut config.goals] {
        none.take_if(|places| places.is_empty());
    }
    let exits = config.exits.as_deref().unwrap_or_default();
    if exits.len() > 1 && exits.iter().all(|exit| exit.share.is_none()) {
        config.exit_choice.get_or_insert(ExitChoice::Time);
    }
    let targets = targets_of(&config)?;
    check_targets(&targets, trial.parameters.time_step)?;
    if targets.len() < 2 || targets.iter().any(|target| !target.stay) {
        return Ok(config);
    }
    let walls: Vec<Vec<Vec2>> = trial.geometry.fixed_walls().map(|wall| wall.corners.clone()).collect();
    let places = || trial.dynamics.iter().map(|own| own.position);
    let all = places().flat_map(|at| (0..targets.len()).map(move |target| (at, Destination::Target(target))));
    let ways = Ways::new(&walls, &trial.geometry.links, &targets, all)?;
    for (person, at) in trial.agents.iter().zip(places()) {
        let far = |target: usize| ways.distance(Destination::Target(target), at);
        let nearest = (0..targets.len()).min_by(|a, b| far(*a).total_cmp(&far(*b)));
        let own = config.agents.entry(person.id.clone()).or_default();
        if own.goal.is_none() && own.exit.is_none() {
            own.goal = nearest.map(|target| targets[target].name.clone());
        }
    }
    Ok(config)
}
