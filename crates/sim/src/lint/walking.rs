//! Models of walking that are used where they are known to fail; exits and ways that nobody reaches.

use lemons_core::message::{Message, message};
use lemons_core::plane::{Bounds, InPlane, Ring, Vec2, nearest_on_line, segments_cross, vec2};
use lemons_core::rule::sentences::*;
use lemons_core::trial::{Geometry, Rule};
use lemons_decision::Plan;
use lemons_decision::plan::Planned;
use lemons_decision::target::{Target, Ways};
use std::collections::BTreeSet;

/// \[m\] People whose ways are further apart than this do not meet.
const BESIDE: f64 = 1.0;
/// Cosine of the smallest angle between directions that are opposite.
const OPPOSITE: f64 = -0.5;
/// Part of the people who must meet others, in either direction.
const MANY: f64 = 0.1;
/// Of more people, only so many are looked at.
const MOST: usize = 2000;

/// Finds a model where people leave, and where they walk against each other: a warning where results are wrong by a
/// factor, a note where they may be meant so.
pub(super) fn unfit(plan: &Plan) -> Vec<(Rule, Message)> {
    let [leaving, opposite] = plan.walking_model.unfit();
    let leave = leaving.filter(|_| plan.leaving().contains(&true)).map(|rule| (rule, rule.message()));
    let meet = opposite.and_then(|rule| {
        let [one, other] = who_meet(plan)?;
        Some((rule, message!(OF, of = message!(TWO_AGENTS, one, other), finding = rule.message())))
    });
    leave.into_iter().chain(meet).collect()
}

/// \[m\] Walls keep the centre of everybody who walks so far away.
const AT_A_WALL: f64 = 0.2;
/// Pairs of a leg of a way and a piece of a wall that are looked at.
const MOST_PAIRS: usize = 50_000_000;
/// Points across an area that is an exit.
const ACROSS: usize = 24;

/// Finds exits and ways of a decision.toml that bodies do not reach, because of walls that never open.
pub(super) fn out_of_reach(plan: &Plan, geometry: &Geometry) -> Vec<(Rule, Message)> {
    let walls: Vec<Vec<Vec2>> = geometry.fixed_walls().map(|wall| wall.corners.clone()).collect();
    let exits = exits_at_walls(plan, &walls).into_iter().map(|message| (Rule::ExitHidden, message));
    let ways = ways_through_walls(plan, &walls).map(|message| (Rule::WayBlocked, message));
    let points = waypoints_at_walls(plan, &walls).map(|message| (Rule::PointHidden, message));
    exits.chain(ways).chain(points).collect()
}

fn crosses(walls: &[Vec<Vec2>], from: Vec2, to: Vec2) -> bool {
    walls.iter().flat_map(|wall| wall.windows(2)).any(|ends| segments_cross(from, to, ends[0], ends[1]))
}

/// \[m\] Returns the distance to the nearest wall.
fn far(walls: &[Vec<Vec2>], p: Vec2) -> f64 {
    walls.iter().map(|wall| nearest_on_line(wall, p).distance).fold(f64::INFINITY, f64::min)
}

/// Finds exits that lie so near to a wall, all along, that bodies do not reach them, and areas beyond walls.
fn exits_at_walls(plan: &Plan, walls: &[Vec<Vec2>]) -> Vec<Message> {
    let deep = plan.agents.iter().map(|agent| 0.5 * agent.depth()).fold(AT_A_WALL, f64::max);
    let is_line_hidden = |a: Vec2, b: Vec2| {
        let across = (b - a).left().unit(0.0).unwrap_or_default() * deep;
        let at = |share: f64| a + (b - a) * share;
        let behind = |way: Vec2| [0.25, 0.5, 0.75].iter().all(|s| crosses(walls, at(*s), at(*s) + way));
        behind(across) || behind(-across)
    };
    let closed: Vec<Ring> = walls.iter().filter_map(|wall| Ring::of_closed(wall)).collect();
    let held = |p: Vec2| closed.iter().map(|wall| wall.contains(p)).collect::<Vec<bool>>();
    let people = plan.agents.iter().take(MOST).map(|agent| held(agent.pose.position));
    let people: BTreeSet<Vec<bool>> = people.collect();
    // Within the same closed walls as somebody.
    let is_with = |p: Vec2| people.contains(&held(p));
    let is_area_hidden = |corners: &[Vec2]| {
        let Some(area) = Ring::through(corners.to_vec()) else { return false };
        let Bounds { low, high } = area.bounds();
        let share = |k: usize| (k as f64 + 0.5) / ACROSS as f64;
        let mut points = (0..ACROSS * ACROSS).map(|k| {
            let [x, y] = [share(k % ACROSS), share(k / ACROSS)];
            low + vec2((high - low).x * x, (high - low).y * y)
        });
        !points.any(|p| area.contains(p) && is_with(p))
    };
    let exits = plan.targets.iter().filter(|target| !target.stay);
    let doubt = |exit: &Target| {
        let corners: Vec<Vec2> = exit.corners.iter().copied().map(Vec2::from).collect();
        let exit = &exit.name;
        match corners[..] {
            [a, b] => is_line_hidden(a, b)
                .then(|| message!(EXIT_LINE, exit, x = a.x, y = a.y, to_x = b.x, to_y = b.y, deep)),
            [a, ..] => is_area_hidden(&corners).then(|| message!(EXIT_AREA, exit, x = a.x, y = a.y, deep)),
            [] => None,
        }
    };
    exits.filter_map(doubt).collect()
}

/// Finds ways to way-points that cross walls: they are straight.
fn ways_through_walls(plan: &Plan, walls: &[Vec<Vec2>]) -> Option<Message> {
    let leg = |agent: &Planned| {
        let mut from = agent.pose.position;
        agent.walker.waypoints.iter().find_map(|next| {
            let to = vec2(next.x, next.y);
            let leg = [from, to];
            from = to;
            // Within its radius it is reached.
            let way = (to - leg[0]).unit(0.0)?;
            let end = to - way * next.radius.min((to - leg[0]).norm());
            crosses(walls, leg[0], end).then_some(leg)
        })
    };
    let legs: usize = plan.agents.iter().map(|agent| agent.walker.waypoints.len()).sum();
    let pairs = legs.saturating_mul(walls.iter().map(Vec::len).sum());
    let every = plan.agents.len().div_ceil(MOST).max(pairs.div_ceil(MOST_PAIRS)).max(1);
    let looked_at = plan.agents.iter().step_by(every);
    let found: Vec<(&str, [Vec2; 2])> =
        looked_at.filter_map(|agent| Some((&agent.id[..], leg(agent)?))).collect();
    let &(agent, [from, to]) = found.first()?;
    let others = match found.len() - 1 {
        0 => None,
        count if every == 1 => Some(message!(AS_MORE_DO, count)),
        _ => Some(message!(AS_OTHERS_DO)),
    };
    Some(message!(WAY_BLOCKED, agent, x = from.x, y = from.y, to_x = to.x, to_y = to.y, others))
}

/// Finds way-points that are nearer to a wall than anybody gets.
fn waypoints_at_walls(plan: &Plan, walls: &[Vec<Vec2>]) -> Option<Message> {
    let mut looked_at: Vec<[f64; 3]> = Vec::new();
    let all = plan.agents.iter().flat_map(|agent| &agent.walker.waypoints);
    all.map(|next| [next.x, next.y, next.radius]).take(MOST).find_map(|at| {
        if looked_at.contains(&at) {
            return None;
        }
        looked_at.push(at);
        let [x, y, radius] = at;
        let wall = far(walls, vec2(x, y));
        (wall + radius < AT_A_WALL).then(|| message!(POINT_HIDDEN, x, y, radius, wall))
    })
}

/// The first way of somebody.
struct Way<'a> {
    agent: &'a Planned,
    at: Vec2,
    direction: Vec2,
    /// \[m\]
    length: f64,
}

impl<'a> Way<'a> {
    fn of(agent: &'a Planned, ways: Option<&Ways>) -> Option<Way<'a>> {
        let at = agent.pose.position;
        if let Some(first) = agent.walker.waypoints.first() {
            let to = vec2(first.x, first.y) - at;
            return Some(Way { agent, at, direction: to.unit(1e-9)?, length: to.norm() });
        }
        let (to, ways) = (agent.destination, ways?);
        Some(Way { agent, at, direction: ways.leg(to, at, false).direction?, length: ways.distance(to, at) })
    }

    fn same_end(&self, other: &Way) -> bool {
        let [one, two] = [self, other].map(|way| way.agent.walker.waypoints.first());
        one == two && (one.is_some() || self.agent.destination == other.agent.destination)
    }

    /// Returns whether both walk towards each other, and far enough to meet.
    fn meets(&self, other: &Way) -> bool {
        let between = other.at - self.at;
        let ahead = between.dot(&self.direction);
        let aside = (between - self.direction * ahead).norm();
        self.direction.dot(&other.direction) < OPPOSITE
            && aside <= BESIDE
            && (0.0..=self.length + other.length).contains(&ahead)
            && !self.same_end(other)
    }
}

/// Returns two who walk towards each other, if many do. Only the first parts of the ways are looked at.
fn who_meet<'a>(plan: &'a Plan) -> Option<[&'a str; 2]> {
    let ways = plan.ways(plan.chooses()).ok()?;
    let every = plan.agents.len().div_ceil(MOST);
    let looked_at = plan.agents.iter().step_by(every);
    let people: Vec<Way> = looked_at.filter_map(|agent| Way::of(agent, ways.as_ref())).collect();
    let walls = &plan.walls;
    let hidden = |a: Vec2, b: Vec2| {
        walls.iter().any(|wall| wall.windows(2).any(|ends| segments_cross(a, b, ends[0], ends[1])))
    };
    let met = |one: &'_ Way<'a>| {
        let other = people.iter().find(|other| one.meets(other) && !hidden(one.at, other.at))?;
        Some((one.direction, [one, other].map(|way| way.agent.id.as_str())))
    };
    let met: Vec<(Vec2, [&str; 2])> = people.iter().filter_map(met).collect();
    let &(along, first) = met.first()?;
    let with = met.iter().filter(|(direction, _)| direction.dot(&along) > 0.0).count();
    let fewer = with.min(met.len() - with);
    (fewer as f64 >= MANY * people.len() as f64).then_some(first)
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::plane::vec2;
    use lemons_core::trial::{Agent, AgentDynamics, Trial, Wall};
    use lemons_decision::DecisionConfig;

    /// The outside: by hand. Two closed rooms of 5 m by 5 m, side by side, a pillar in the first.
    #[test]
    fn exits_of_all_rooms_with_people_are_reached() {
        let rectangle = |id: &str, [left, low, right, top]: [f64; 4]| {
            let corners = [[left, low], [right, low], [right, top], [left, top], [left, low]];
            Wall::new(id, "concrete", corners.map(Vec2::from).to_vec())
        };
        let rooms = [[0.0, 0.0, 5.0, 5.0], [10.0, 0.0, 15.0, 5.0], [2.0, 2.0, 3.0, 3.0]];
        let walls = ["a", "b", "pillar"].iter().zip(rooms).map(|(id, sides)| rectangle(id, sides)).collect();
        let geometry = Geometry { walls, ..Geometry::default() };
        let person = |x: &f64| {
            let agent = Agent::new(x.to_string(), 80.0, 1.5, [2.0, 4.0]).with_disks(&[[0.0, 0.0, 0.12]]);
            (agent, AgentDynamics { position: vec2(*x, 1.0), ..AgentDynamics::default() })
        };
        // The numbers of the exits that are doubted.
        let doubted = |people: &[f64], exits: &[[f64; 4]]| -> Vec<usize> {
            let exit = |[left, low, right, top]: &[f64; 4]| {
                format!(
                    "{{ polygon = [[{left}, {low}], [{right}, {low}], [{right}, {top}], [{left}, {top}]] }}"
                )
            };
            let config = format!("exits = [{}]", exits.iter().map(exit).collect::<Vec<_>>().join(", "));
            let config = DecisionConfig::from_toml(&config).unwrap();
            let trial = Trial::of(people.iter().map(person), geometry.walls.clone(), 0.05);
            let messages = out_of_reach(&Plan::of(&trial, &config).unwrap(), &geometry);
            let of = |k: &usize| {
                messages.iter().any(|(_, text)| text.starts_with(&format!("exit \"exit {k}\" at")))
            };
            (0..exits.len()).filter(of).collect()
        };
        let [first, second, strip] = [[4.0, 4.0, 5.0, 5.0], [14.0, 4.0, 15.0, 5.0], [14.85, 1.0, 15.0, 4.0]];
        let in_pillar = [2.1, 2.1, 2.9, 2.9];
        assert!(doubted(&[1.0, 11.0], &[first, second, strip]).is_empty());
        // Nobody is in its room, or it is in the pillar.
        assert_eq!(doubted(&[1.0], &[first, second]), [1]);
        assert_eq!(doubted(&[1.0, 11.0], &[in_pillar, first, second]), [0]);
    }
}
