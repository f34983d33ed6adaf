//! Whether a plan can be carried out.

use super::Plan;
use super::destinations::names;
use crate::error::{
    ANY_EXIT, EMPTY, MOST_MEMBERS, MOST_TARGETS, MOST_WAYPOINTS, NO_WAY, PlanError, SHUT, coordinate,
    moderate, not_negative, number, positive,
};
use crate::target::{Destination, Target};
use lemons_core::message::message;
use lemons_core::plane::vec2;

impl Plan {
    /// Checks that, from where they start, or from their last way-point, all must be able to reach their destination.
    pub(super) fn check_ways(&self) -> Result<(), PlanError> {
        let Some(ways) = self.ways(self.chooses())? else { return Ok(()) };
        if let Some(shut) = ways.shut().first() {
            return Err(PlanError::Impossible(message!(SHUT, place = self.targets[*shut].label())));
        }
        for agent in self.agents.iter().filter(|agent| agent.destination != Destination::None) {
            let last = agent.walker.waypoints.last().map(|w| vec2(w.x, w.y));
            let from = last.unwrap_or(agent.pose.position);
            if !ways.distance(agent.destination, from).is_finite() {
                let to = match agent.destination {
                    Destination::Target(k) => self.targets[k].label(),
                    _ => message!(ANY_EXIT, names = names(&self.targets, false)),
                };
                let message = message!(NO_WAY, agent = &agent.id, x = from.x, y = from.y, to);
                return Err(PlanError::Impossible(message));
            }
        }
        Ok(())
    }

    pub(super) fn checked(self) -> Result<Plan, PlanError> {
        if self.agents.is_empty() {
            return Err(PlanError::Impossible(message!(EMPTY)));
        }
        positive("the plan", "time_step", self.time_step)?;
        self.walking_model.check()?;
        self.balance.map_or(Ok(()), |balance| balance.check())?;
        let doors = self.doors.iter().map(|door| &door.corners);
        for corner in self.walls.iter().chain(doors).flatten() {
            corner.iter().try_for_each(|of| coordinate("a wall", "corner", *of))?;
        }
        for (k, motivation) in self.motivation.iter().enumerate() {
            let place = format!("motivation {k}");
            positive(&place, "time", motivation.time)?;
            motivation.desired_speed.map_or(Ok(()), |value| moderate(&place, "desired_speed", value))?;
            if let Some(factor) = motivation.speed_factor {
                let (valid, must) = (|value: f64| (0.0..=10.0).contains(&value), "from 0 to 10");
                number(&place, "speed_factor", factor, valid, must)?;
            }
            motivation.time_gap.map_or(Ok(()), |value| positive(&place, "time_gap", value))?;
            motivation
                .standstill_gap
                .map_or(Ok(()), |value| not_negative(&place, "standstill_gap", value))?;
            motivation.push.map_or(Ok(()), |value| not_negative(&place, "push", value))?;
        }
        check_targets(&self.targets, self.time_step)?;
        for (k, group) in self.groups.iter().enumerate() {
            if !(2..=MOST_MEMBERS).contains(&group.len()) {
                return Err(PlanError::GroupSize { group: k, count: group.len() });
            }
        }
        for agent in &self.agents {
            let (place, walker, pose) = (format!("agent {:?}", agent.id), &agent.walker, &agent.pose);
            if walker.waypoints.len() > MOST_WAYPOINTS {
                let (agent, count) = (agent.id.clone(), walker.waypoints.len());
                return Err(PlanError::TooManyWaypoints { agent, count });
            }
            for length in agent.disks.iter().flatten() {
                number(&place, "disk", *length, |_| true, "finite")?;
            }
            positive(&place, "mass", walker.mass)?;
            positive(&place, "moment_of_inertia", walker.moment_of_inertia)?;
            not_negative(&place, "floor_damping", walker.floor_damping)?;
            not_negative(&place, "angular_damping", walker.angular_damping)?;
            moderate(&place, "desired_speed", walker.desired_speed)?;
            positive(&place, "time_gap", walker.time_gap)?;
            not_negative(&place, "standstill_gap", walker.standstill_gap)?;
            not_negative(&place, "reaction_time", walker.reaction_time)?;
            moderate(&place, "start", walker.start)?;
            not_negative(&place, "push", walker.push)?;
            number(
                &place,
                "stature",
                walker.stature,
                |stature| (0.1..=10.0).contains(&stature),
                "from 0.1 to 10 m",
            )?;
            coordinate(&place, "x", pose.position.x)?;
            coordinate(&place, "y", pose.position.y)?;
            number(&place, "theta", pose.orientation, |_| true, "finite")?;
            for (k, waypoint) in walker.waypoints.iter().enumerate() {
                let place = format!("{place}, way-point {k}");
                coordinate(&place, "x", waypoint.x)?;
                coordinate(&place, "y", waypoint.y)?;
                not_negative(&place, "radius", waypoint.radius)?;
                moderate(&place, "wait", waypoint.wait)?;
            }
        }
        Ok(self)
    }
}

/// Checks that each is a line or an area, and the times of exits: people leave at communication points only, a time step
/// \[s\] apart.
pub(super) fn check_targets(targets: &[Target], time_step: f64) -> Result<(), PlanError> {
    if targets.len() > MOST_TARGETS {
        return Err(PlanError::TooManyTargets(targets.len()));
    }
    for target in targets {
        let place = target.label().text;
        for corner in target.corners.iter().flatten() {
            coordinate(&place, "corner", *corner)?;
        }
        if target.corners.len() < 2 {
            return Err(PlanError::LineOrPolygon { place });
        }
        if target.stay && (target.open.is_some() || target.most.is_some()) {
            let key = if target.open.is_some() { "open" } else { "most" };
            return Err(PlanError::OpenGoal { place, key });
        }
        if let Some(value) = target.open.as_ref().and_then(|open| open.shorter_than(time_step)) {
            let (value, step) = (format!("{value:?}"), time_step.to_string());
            return Err(PlanError::ShortOpen { place, value, step });
        }
        positive(&place, "time_factor", target.time_factor)?;
        let flat = target.area().is_some_and(|ring| !(ring.area() > 0.0 && ring.is_simple()));
        let point = target.corners.iter().all(|corner| *corner == target.corners[0]);
        if flat || point {
            let must = "a line of some length, or a polygon with an area whose sides do not cross";
            let value = format!("{:?}", target.corners);
            return Err(PlanError::Value { place, key: "corners", value, must });
        }
    }
    Ok(())
}
