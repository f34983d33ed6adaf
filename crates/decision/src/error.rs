//! Errors of a `decision.toml` and of its plan.

use lemons_core::message::Message;
use lemons_core::plane::Vec2;
use lemons_core::trial::FARTHEST;
use thiserror::Error;

/// Each needs a field of distances in memory.
pub(crate) const MOST_TARGETS: usize = 50;
/// Largest number of way-points of an agent: each is some variables of the FMU.
pub(crate) const MOST_WAYPOINTS: usize = 10_000;
/// Largest number of members of a group: each looks at all others.
pub(crate) const MOST_MEMBERS: usize = 20;
/// Greatest speed or strength: products of a few of them are finite.
const GREATEST: f64 = 1e9;

/// Error in a `decision.toml` or its plan. The messages do not name the file.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[allow(missing_docs)] // the messages say it
pub enum PlanError {
    #[error("{0}")]
    Impossible(Message),
    #[error("{0}")]
    Toml(String),
    #[error("{place}: {key} = {value}: must be {must}")]
    Value { place: String, key: &'static str, value: String, must: &'static str },
    #[error("agents.{0}: there is no agent with this Id")]
    UnknownAgent(String),
    #[error(
        "agent {0:?} has no way-point and no exit: give `waypoints` or `exits` for all agents, or in [agents.{0}] (with \
         `balance`, `waypoints = []` there says that it stands)"
    )]
    NoWaypoint(String),
    #[error("[{key}]: the model is another one: say `model = \"{key}\"`, or leave this section out")]
    OtherModel { key: &'static str },
    #[error("[{key}]: the balance is another one: say `balance = \"{key}\"`, or leave this section out")]
    OtherBalance { key: &'static str },
    #[error("everybody: {key}: {problem}")]
    Distribution { key: &'static str, problem: String },
    #[error("push_sd: give the mean as `push`, too")]
    NoPush,
    #[error("{place}: give a `line` or a `polygon`, one of the two")]
    LineOrPolygon { place: String },
    #[error("{place}: the name {name:?} is that of another exit or goal")]
    SameName { place: String, name: String },
    #[error("agents.{agent}: {key} = {name:?}: there is no {key} with this name; there are {known}")]
    UnknownTarget { agent: String, key: &'static str, name: String, known: String },
    #[error("agents.{0}: has an exit and a goal; give one of the two")]
    Both(String),
    #[error("exits: give a `share` for each or for none")]
    SomeShares,
    #[error(
        "exits[{0}]: time_factor: has an effect only with `exit_choice = \"time\"`: say so, or leave it out"
    )]
    NotByTime(usize),
    #[error(
        "{place}: open = {value}: must not be shorter than the time step of {step} s: it may never be open"
    )]
    ShortOpen { place: String, value: String, step: String },
    #[error("{place}: {key}: only exits have it: nobody leaves by a goal")]
    OpenGoal { place: String, key: &'static str },
    #[error("ways: give `ways` or `waypoints` for everybody, one of the two")]
    WaysAndWaypoints,
    #[error("ways: give a `share` for each or for none")]
    SomeWayShares,
    #[error("{place}: give `rate`, `every` or `times`, one of the three; `start` is not for `times`")]
    WhenOfSource { place: String },
    #[error("{place}: people: {id:?}: {problem}")]
    OfSource { place: String, id: String, problem: &'static str },
    #[error("{place}: the name {name:?} is that of another source")]
    SameSource { place: String, name: String },
    #[error("groups: members[{group}]: {id:?}: {problem}")]
    Member { group: usize, id: String, problem: &'static str },
    #[error("groups: members[{group}] has {count} members; a group has 2 to {MOST_MEMBERS}")]
    GroupSize { group: usize, count: usize },
    #[error("groups: sizes: give 1 to {most} numbers: of groups of two, of three, and so on", most = MOST_MEMBERS - 1)]
    GroupSizes,
    #[error(
        "agents.{one} and agents.{other} are in one group, and have different exits, goals or way-points: give one of \
         the two"
    )]
    GroupParts { one: String, other: String },
    #[error("{0} exits and goals; at most {MOST_TARGETS} are allowed")]
    TooManyTargets(usize),
    #[error("agent {agent:?}: {count} way-points; at most {MOST_WAYPOINTS} are allowed")]
    TooManyWaypoints { agent: String, count: usize },
    #[error(
        "the walls, people, exits and goals lie in an area of {0} m: too large to find ways in it; are they in metres?"
    )]
    TooLarge(String),
}

lemons_core::sentences! {
    EMPTY "plan.empty" "there are no agents";
    SHUT "plan.shut" "{place}: lies on walls, or is shut in by them: nobody can reach it from anywhere";
    NO_WAY "plan.no-way" "agent {agent:?} at ({x:.2}, {y:.2}) m: no way leads to {to}: walls are between";
    EXIT "plan.exit" "exit {name:?}";
    GOAL "plan.goal" "goal {name:?}";
    ANY_EXIT "plan.any-exit" "any exit ({names})";
}

impl PlanError {
    /// The walls, people, exits and goals take an area of this width and height \[m\]: so large that doors would be missed
    /// on a grid of a size that can be kept in memory.
    pub(crate) fn of_area(size: Vec2) -> PlanError {
        PlanError::TooLarge(format!("{:.0} x {:.0}", size.x, size.y))
    }
}

/// Checks a number of a `decision.toml` or of a plan.
pub(crate) fn number(
    place: &str,
    key: &'static str,
    value: f64,
    good: impl Fn(f64) -> bool,
    must: &'static str,
) -> Result<(), PlanError> {
    if value.is_finite() && good(value) {
        return Ok(());
    }
    Err(PlanError::Value { place: place.to_owned(), key, value: format!("{value:?}"), must })
}

pub(crate) fn positive(place: &str, key: &'static str, value: f64) -> Result<(), PlanError> {
    number(place, key, value, |value| value > 0.0, "positive and finite")
}

pub(crate) fn not_negative(place: &str, key: &'static str, value: f64) -> Result<(), PlanError> {
    number(place, key, value, |value| value >= 0.0, "finite and at least 0")
}

/// Checks a speed or a strength.
pub(crate) fn moderate(place: &str, key: &'static str, value: f64) -> Result<(), PlanError> {
    number(place, key, value, |value| (0.0..=GREATEST).contains(&value), "from 0 to 1e9")
}

/// Checks a coordinate \[m\].
pub(crate) fn coordinate(place: &str, key: &'static str, value: f64) -> Result<(), PlanError> {
    number(place, key, value, |value| value.abs() <= FARTHEST, "from -1e9 to 1e9 m")
}
