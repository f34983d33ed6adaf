//! Models of walking that are used where they are known to fail.

use super::{NOTE, WARNING};
use lemons_core::plane::{InPlane, Ring, Vec2, segments_cross, vec2};
use lemons_core::trial::Geometry;
use lemons_decision::Plan;
use lemons_decision::plan::Planned;
use lemons_decision::rule::UNLIMITED;
use lemons_decision::target::{Target, Ways};
use lemons_decision::walking_model::WalkingModel;
use lemons_people::closed_walls;

/// \[m\] People whose ways are further apart than this do not meet.
const BESIDE: f64 = 1.0;
/// Cosine of the smallest angle between directions that are opposite.
const OPPOSITE: f64 = -0.5;
/// Part of the people who must meet others, in either direction.
const MANY: f64 = 0.1;
/// Of more people, only so many are looked at.
const MOST: usize = 2000;

/// Doubts a model where people leave, and where they walk against each other: a warning where results are wrong by a
/// factor, a note where they may be meant so.
pub fn doubts(plan: &Plan) -> Vec<(&'static str, String)> {
    let (leaving, opposite) = match plan.walking_model {
        WalkingModel::CollisionFreeSpeed(_) => (
            (
                NOTE,
                "in the model \"collision-free-speed\" flows through doors are about half of what people reach in \
                 experiments",
            ),
            (WARNING, "in the model \"collision-free-speed\" they nearly stand still"),
        ),
        WalkingModel::SocialForce(_) => (
            (
                WARNING,
                "in the model \"social-force\" flows through doors are two to four times what people reach in \
                 experiments",
            ),
            (WARNING, "for this, the model \"social-force\" has not been compared with experiments"),
        ),
        WalkingModel::Straight => (
            (
                WARNING,
                "in the model \"straight\" people do not see each other: in front of an exit they push without end",
            ),
            // A push may be meant.
            (NOTE, "in the model \"straight\" they do not see each other, and push"),
        ),
        WalkingModel::Rotational(_) => return Vec::new(),
    };
    let leave = plan.leaving().contains(&true).then(|| (leaving.0, leaving.1.to_owned()));
    let meet = meeting(plan).map(|[one, other]| {
        let who = format!("people walk against each other, as agents {one:?} and {other:?}");
        (opposite.0, format!("{who}: {}", opposite.1))
    });
    let doubts = leave.into_iter().chain(meet);
    let advised = |(kind, text)| {
        (kind, format!("{text} (model = \"rotational\" is for doors, corridors and counterflow)"))
    };
    doubts.map(advised).collect()
}

/// Returns what a limit of pushes does in this plan, if somebody has one.
pub fn flat_push(plan: &Plan) -> Option<&'static str> {
    let changed = || plan.motivation.iter().any(|change| change.push.is_some());
    let limited = || plan.agents.iter().any(|agent| agent.walker.push < UNLIMITED);
    plan.flat_push().filter(|_| limited() || changed())
}

/// \[m\] Walls keep the centre of everybody who walks so far away.
const AT_A_WALL: f64 = 0.2;

/// Doubts exits whose line lies so near before a wall, all along, that bodies do not reach it.
pub fn exits_at_walls(plan: &Plan) -> Vec<String> {
    let deep = plan.agents.iter().map(|agent| 0.5 * agent.depth()).fold(AT_A_WALL, f64::max);
    let walls = plan.polylines();
    let hidden = |from: Vec2, way: Vec2| {
        walls
            .iter()
            .flat_map(|wall| wall.windows(2))
            .any(|ends| segments_cross(from, from + way, ends[0], ends[1]))
    };
    let exits = plan.targets.iter().filter(|target| !target.stay && target.corners.len() == 2);
    let doubt = |exit: &Target| {
        let [a, b] = [0, 1].map(|k| Vec2::from(exit.corners[k]));
        let across = (b - a).left().unit(0.0)? * deep;
        let behind = |way: Vec2| [0.25, 0.5, 0.75].iter().all(|share| hidden(a + (b - a) * *share, way));
        (behind(across) || behind(-across)).then(|| {
            format!(
                "exit {:?} from ({:.2}, {:.2}) to ({:.2}, {:.2}) m lies less than {deep:.2} m before a wall: not everybody gets so \
                 near, and who does not reach the line does not leave",
                exit.name, a.x, a.y, b.x, b.y
            )
        })
    };
    exits.filter_map(doubt).collect()
}

/// Doubts way-points that closed walls keep people from.
pub fn waypoints_behind_walls(plan: &Plan, geometry: &Geometry) -> Option<String> {
    let walls = closed_walls(geometry);
    let behind = |agent: &Planned| {
        let at = vec2(agent.pose.x, agent.pose.y);
        let is_between = |wall: &Ring, to: Vec2, radius: f64| {
            wall.contains(at) != wall.contains(to) && wall.nearest(to).distance > radius
        };
        let ways = agent.walker.waypoints.iter().map(|next| (vec2(next.x, next.y), next.radius));
        ways.into_iter().find(|(to, radius)| walls.iter().any(|wall| is_between(wall, *to, *radius)))
    };
    let all = || plan.agents.iter().filter_map(|agent| Some((&agent.id, behind(agent)?.0)));
    let (first, at) = all().next()?;
    let others = match all().count() - 1 {
        0 => String::new(),
        others => format!(", as ways of {others} more do"),
    };
    Some(format!(
        "the way of agent {first:?} leads to ({:.2}, {:.2}) m, behind a closed wall{others}: nobody gets there",
        at.x, at.y
    ))
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
        let at = vec2(agent.pose.x, agent.pose.y);
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
fn meeting<'a>(plan: &'a Plan) -> Option<[&'a str; 2]> {
    let ways = plan.ways().ok()?;
    let every = plan.agents.len().div_ceil(MOST);
    let looked_at = plan.agents.iter().step_by(every);
    let people: Vec<Way> = looked_at.filter_map(|agent| Way::of(agent, ways.as_ref())).collect();
    let walls = plan.polylines();
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
