//! Decisions of people: the `decision.toml` of a scenario.

use crate::Scenario;
use crate::error::{Result, fits, impossible};
use crate::place::{NO_WAY_OUT, WalkableRoom};
use lemons_core::trial::Trial;
use lemons_decision::exit_choice::ExitChoice;
use lemons_decision::rule::{WAYPOINT_RADIUS, Waypoint};
use lemons_decision::{AgentConfig, DEFAULT_SPEED, DecisionConfig, Spread, TargetConfig, WalkingModelName};
use lemons_people::CrowdMember;
use lemons_people::drawing::{self, Read};

impl Scenario {
    /// Returns whether somebody walks without `leave`.
    fn walks(&self) -> bool {
        let DecisionConfig { waypoints, ways, exits, goals, agents, .. } = &self.decision;
        let comes = self.sources.iter().any(|source| source.waypoints.is_some());
        let own = |own: &AgentConfig| own.waypoints.is_some() || own.exit.is_some() || own.goal.is_some();
        let all = waypoints.is_some() || ways.is_some() || exits.is_some() || goals.is_some();
        all || comes || agents.values().any(own)
    }

    /// Checks what is said of people who leave.
    pub(crate) fn check_leaving(&self) -> Result<()> {
        let DecisionConfig { model, start, push, groups, balance, .. } = &self.decision;
        let walks = self.leave || self.walks();
        for (key, given) in [
            ("model", model.is_some()),
            ("push", push.is_some()),
            ("groups", groups.is_some()),
            ("start", start.is_some()),
            ("sources", !self.sources.is_empty()),
        ] {
            fits(!given || walks, || format!("`{key}`: nobody walks without `leave`"))?;
        }
        if let Some(start) = start {
            start.check("start").map_err(impossible)?;
        }
        let pushed = self.speed.is_some() && !self.leave;
        fits(!pushed || balance.is_none(), || {
            "`speed`: with `balance` and without `leave`, people stand: leave out one of the two".into()
        })?;
        fits(!pushed || !walks, || {
            "`speed`: without `leave`, it pushes people; who walks has the `desired_speed` of `decision`"
                .into()
        })?;
        // A drawing may have exits.
        fits(self.ways_out() > 0 || self.drawing_file().is_some(), || NO_WAY_OUT.into())
    }

    /// Returns how many doors and exits are given; 1 if nobody leaves, for whom none is needed.
    pub(crate) fn ways_out(&self) -> usize {
        let of_room = self.room.as_ref().map_or(0, |room| room.doors.len());
        let exits = self.decision.exits.as_ref().map_or(0, Vec::len);
        if self.leave { self.doors.len() + of_room + exits } else { 1 }
    }

    /// Returns the settings of Decision; `None` if nobody walks or stands by them. People leave by doors, with lines
    /// behind them, and by exits. `speed` is everybody's; without it, those of kinds have that of their kind. The seed
    /// chooses who starts when and who is in a group. Notes tell what was chosen.
    pub(crate) fn decision(
        &self,
        agents: &[CrowdMember],
        trial: &Trial,
        place: &WalkableRoom,
        notes: &mut Vec<String>,
    ) -> Option<DecisionConfig> {
        let mut config = self.decision.clone();
        let shares = config.exits.iter().flatten().any(|exit| exit.share.is_some());
        let drawn = matches!(config.desired_speed, Some(Spread::Drawn(_)));
        if config.start.is_some() || config.groups.is_some() || config.ways.is_some() || shares || drawn {
            config.seed.get_or_insert(self.seed());
        }
        if !self.leave {
            if self.walks() {
                config = config.with_speeds(own_speeds(agents, trial));
            }
            return (config != DecisionConfig::default()).then_some(config);
        }
        if config.balance.is_some() {
            notes.push(
                "note: `balance`: legs act on those who stand, before they start or at a goal; who walks cannot fall"
                    .into(),
            );
        }
        config.model.get_or_insert(WalkingModelName::Rotational);
        config.desired_speed =
            self.speed.map(Spread::Same).or(config.desired_speed).or(Some(Spread::Same(DEFAULT_SPEED)));
        let plan = place.drawn.as_ref().map(|Read { plan, .. }| plan);
        if config.waypoints.is_none() && config.ways.is_none() {
            config.waypoints = plan.and_then(|plan| way(plan, notes));
        }
        let given = config.exits.take().unwrap_or_default();
        let drawn = plan.filter(|_| given.is_empty()).map_or(&[][..], |plan| &plan.exits);
        let people = trial.dynamics.iter().map(|here| here.position);
        let behind = place.doors.iter().enumerate().filter_map(|(k, door)| {
            let line = door.exit(&place.lines, people.clone())?;
            Some(TargetConfig {
                name: Some(format!("door {k}")),
                line: Some(line.map(Into::into)),
                open: door.exit_times(),
                ..TargetConfig::default()
            })
        });
        let exits: Vec<TargetConfig> = behind.chain(given).chain(drawn.iter().map(drawn_exit)).collect();
        if exits.len() > 1 {
            config.exit_choice.get_or_insert(ExitChoice::Time);
        }
        config.exits = Some(exits);
        if self.speed.is_none() {
            config = config.with_speeds(own_speeds(agents, trial));
        }
        Some(config)
    }
}

/// Returns Ids and desired speeds \[m/s\] of those who are of a kind.
pub fn own_speeds(agents: &[CrowdMember], trial: &Trial) -> Vec<(String, f64)> {
    let people = agents.iter().zip(&trial.agents);
    people.filter_map(|(agent, body)| Some((body.id.clone(), agent.member()?.speed))).collect()
}

fn drawn_exit(drawing::NamedPlace { name, corners }: &drawing::NamedPlace) -> TargetConfig {
    let (name, corners): (_, Vec<[f64; 2]>) =
        (Some(name.clone()), corners.iter().map(|&corner| corner.into()).collect());
    match <[[f64; 2]; 2]>::try_from(corners) {
        Ok(line) => TargetConfig { name, line: Some(line), ..TargetConfig::default() },
        Err(polygon) => TargetConfig { name, polygon: Some(polygon), ..TargetConfig::default() },
    }
}

/// The way-points of a drawing, if their names say their order.
fn way(plan: &drawing::FloorPlan, notes: &mut Vec<String>) -> Option<Vec<Waypoint>> {
    let Some(way) = plan.way() else {
        if !plan.waypoints.is_empty() {
            notes.push(
                "note: way-points of the drawing are not used: their names end in no numbers that say an order"
                    .into(),
            );
        }
        return None;
    };
    notes.push(format!("note: everybody goes to the {} way-points of the drawing first", way.len()));
    let point = |place: &drawing::NamedPlace| {
        let (middle, radius) = place.middle();
        Waypoint { x: middle.x, y: middle.y, radius: radius.unwrap_or(WAYPOINT_RADIUS), wait: 0.0 }
    };
    Some(way.into_iter().map(point).collect())
}
