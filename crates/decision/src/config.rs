//! A user's settings: `decision.toml` in a Trial's directory.
//!
//! Way-points, exits and speeds, for all agents or for some agents by their Id:
//!
//! ```toml
//! model = "collision-free-speed"
//! desired_speed = 1.34                               # [m/s]
//! waypoints = [{ x = 6.0, y = 2.5, radius = 0.45 }]  # [m]; radius 0.3 if it is not said
//! exits = [{ name = "door", line = [[8.0, 2.5], [8.0, 3.5]] }]
//!
//! [agents.7]
//! desired_speed = 0.9
//! ```

mod write;

use crate::balance::{BalanceModel, Pendulum, TwoLevel};
use crate::error::PlanError;
use crate::exit_choice::ExitChoice;
use crate::queue::QueueConfig;
use crate::rule::{Motivation, Waypoint};
use crate::source::SourceConfig;
use crate::spread::Spread;
use crate::walking_model::{WalkingModel, WalkingModelName, with_models};
use lemons_core::files::words;
use lemons_core::trial::{Agent, OpeningTimes, Trial};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::{BTreeMap, HashSet};

/// Name of the settings in a Trial directory.
pub const DECISION_FILE: &str = "decision.toml";

/// How people who stand keep their balance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(rename_all = "kebab-case")]
pub enum BalanceName {
    /// Nothing is asked: the ground takes the velocity, as in eq. 1.
    #[default]
    None,
    /// See [`Pendulum`].
    Pendulum,
    /// See [`TwoLevel`].
    TwoLevel,
}

impl BalanceName {
    /// Returns its word in a `decision.toml`.
    pub fn name(self) -> &'static str {
        match self {
            BalanceName::None => "none",
            BalanceName::Pendulum => "pendulum",
            BalanceName::TwoLevel => "two-level",
        }
    }
}

/// Makes the settings, with a table for each walking model that has constants.
macro_rules! decision_config {
    ($($(#[$usual:meta])? $name:ident = $word:literal $(, $constants:ident)?;)*) => {
        /// A user's settings for the FMU.
        #[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
        #[serde(deny_unknown_fields)]
        pub struct DecisionConfig {
            /// How people walk among others; [`WalkingModelName::Straight`] if it is not said.
            pub model: Option<WalkingModelName>,
            /// How people who stand keep their balance.
            pub balance: Option<BalanceName>,
            /// \[m/s\] Desired speed.
            pub desired_speed: Option<Spread>,
            /// \[N\] Greatest force with which people push ahead, or its mean.
            pub push: Option<f64>,
            /// \[N\] Standard deviation of this force.
            pub push_sd: Option<f64>,
            /// Seed of all random choices.
            pub seed: Option<u64>,
            /// \[s\] When people start to walk.
            pub start: Option<Spread>,
            /// Groups that stay together.
            pub groups: Option<GroupsConfig>,
            /// Everybody's way.
            pub waypoints: Option<Vec<Waypoint>>,
            /// Ways with shares.
            pub ways: Option<Vec<WayConfig>>,
            /// How people choose among several exits.
            pub exit_choice: Option<ExitChoice>,
            /// Where people leave.
            pub exits: Option<Vec<TargetConfig>>,
            /// Where people stay.
            pub goals: Option<Vec<TargetConfig>>,
            /// Who comes later.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub sources: Vec<SourceConfig>,
            /// Changes during a run.
            #[serde(default, skip_serializing_if = "Vec::is_empty")]
            pub motivation: Vec<Motivation>,
            /// How people who wait press those in front.
            pub queue: Option<QueueConfig>,
            $($(
                #[doc = concat!("Constants of the model `", $word, "`.")]
                #[serde(rename = $word)]
                pub $constants: Option<crate::walking_model::$name>,
            )?)*
            /// Constants of legs as a pendulum.
            pub pendulum: Option<Pendulum>,
            /// Constants of legs of two levels.
            #[serde(rename = "two-level")]
            pub two_level: Option<TwoLevel>,
            /// Settings of agents, by their Ids.
            #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
            pub agents: BTreeMap<String, AgentConfig>,
        }

        impl DecisionConfig {
            /// Returns the constants of walking models that are given.
            fn constants(&self) -> impl Iterator<Item = WalkingModel> {
                [$($(self.$constants.map(WalkingModel::$name),)?)*].into_iter().flatten()
            }
        }
    };
}

with_models!(decision_config);

/// Settings of one agent; missing ones are those of all agents.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AgentConfig {
    /// \[m/s\]
    pub desired_speed: Option<f64>,
    /// \[s\]
    pub start: Option<f64>,
    /// \[s\]
    pub time_gap: Option<f64>,
    /// \[m\]
    pub standstill_gap: Option<f64>,
    /// \[s\]
    pub reaction_time: Option<f64>,
    /// \[N\]
    pub push: Option<f64>,
    /// Its way.
    pub waypoints: Option<Vec<Waypoint>>,
    /// Name of its exit.
    pub exit: Option<String>,
    /// Name of its goal.
    pub goal: Option<String>,
}

/// One of several ways, and how many people take it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WayConfig {
    /// In this order.
    pub waypoints: Vec<Waypoint>,
    /// Part of the people who take it; the same for all ways if it is not said.
    pub share: Option<f64>,
}

/// Groups of people who stay together.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GroupsConfig {
    /// Ids of the members of each group.
    pub members: Option<Vec<Vec<String>>>,
    /// Part of the people who are in drawn groups.
    pub share: Option<f64>,
    /// Relative numbers of drawn groups of two, of three, and so on.
    pub sizes: Option<Vec<f64>>,
}

/// An exit, where people leave, or a goal, where they stay.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TargetConfig {
    /// As others name it.
    pub name: Option<String>,
    /// \[m\] Ends of a line.
    #[serde(default, deserialize_with = "ends")]
    pub line: Option<[[f64; 2]; 2]>,
    /// \[m\] Corners of an area.
    #[serde(default, deserialize_with = "corners")]
    pub polygon: Option<Vec<[f64; 2]>>,
    /// Part of the people who take it, instead of the nearest.
    pub share: Option<f64>,
    /// When people can leave by it; `None`: always.
    pub open: Option<OpeningTimes>,
    /// So many leave by it, each time that it opens; for others it is closed then.
    pub most: Option<u32>,
    /// Factor of the expected time.
    pub time_factor: Option<f64>,
}

/// Arrays of TOML that are too long would be cut.
fn corners<'de, D: Deserializer<'de>>(from: D) -> Result<Option<Vec<[f64; 2]>>, D::Error> {
    // The lab says null where there is none.
    let Some(points) = Option::<Vec<Vec<f64>>>::deserialize(from)? else { return Ok(None) };
    let wrong = |of: Vec<f64>| D::Error::custom(format!("a point has 2 numbers [x, y], not {}", of.len()));
    points.into_iter().map(|point| point.try_into().map_err(wrong)).collect::<Result<_, _>>().map(Some)
}

fn ends<'de, D: Deserializer<'de>>(from: D) -> Result<Option<[[f64; 2]; 2]>, D::Error> {
    let Some(points) = corners(from)? else { return Ok(None) };
    let wrong = |of: Vec<_>| D::Error::custom(format!("a line has 2 points, not {}", of.len()));
    points.try_into().map(Some).map_err(wrong)
}

impl DecisionConfig {
    /// Reads TOML.
    ///
    /// # Errors
    /// The text is not TOML, or has unknown keys or values of the wrong type; with line and column.
    pub fn from_toml(text: &str) -> Result<DecisionConfig, PlanError> {
        let explained = |error: toml::de::Error| words::explained(&error.to_string(), error.message());
        toml::from_str(text).map_err(|error| PlanError::Toml(explained(error)))
    }

    /// Returns the text of a `decision.toml`, with units. Every number is read back as the same double.
    ///
    /// # Errors
    /// The settings cannot be written.
    pub fn to_toml(&self) -> Result<String, PlanError> {
        write::text(self).map_err(|error| PlanError::Toml(error.to_string()))
    }

    /// Returns the same without settings of those who are not among these people; `None` if there are none of others.
    pub fn without_others(&self, people: &[Agent]) -> Option<DecisionConfig> {
        let mut fewer = self.clone();
        let ids: HashSet<&str> = people.iter().map(|person| &*person.id).collect();
        let is_there = |id: &String| ids.contains(&**id);
        fewer.agents.retain(|id, _| is_there(id));
        fewer.sources.iter_mut().for_each(|source| source.people.retain(is_there));
        if let Some(groups) = fewer.groups.as_mut().and_then(|groups| groups.members.as_mut()) {
            groups.iter_mut().for_each(|group| group.retain(is_there));
            groups.retain(|group| group.len() > 1);
        }
        (fewer != *self).then_some(fewer)
    }

    /// Returns the same with desired speeds \[m/s\] of agents, by their Ids; of those who have one already it stays.
    #[must_use]
    pub fn with_speeds(mut self, speeds: impl IntoIterator<Item = (String, f64)>) -> DecisionConfig {
        for (id, speed) in speeds {
            self.agents.entry(id).or_default().desired_speed.get_or_insert(speed);
        }
        self
    }

    /// Makes settings in which nobody goes anywhere, with legs of a model.
    pub fn standing(balance: BalanceName) -> DecisionConfig {
        DecisionConfig { balance: Some(balance), ..DecisionConfig::default() }
    }

    /// Makes settings in which everybody walks at one speed \[m/s\], on the way whose
    /// first point is nearest. `None` if no way has a point.
    pub fn nearest_of(trial: &Trial, speed: f64, ways: &[Vec<Waypoint>]) -> Option<DecisionConfig> {
        let ways: Vec<&Vec<Waypoint>> = ways.iter().filter(|way| !way.is_empty()).collect();
        let waypoints = Some((*ways.first()?).clone());
        let mut agents = BTreeMap::new();
        for (Agent { id, .. }, own) in trial.agents.iter().zip(&trial.dynamics) {
            let far = |way: &[Waypoint]| libm::hypot(way[0].x - own.position.x, way[0].y - own.position.y);
            let nearest = ways.iter().min_by(|a, b| far(a).total_cmp(&far(b))).map(|way| (*way).clone());
            if nearest != waypoints {
                agents.insert(id.clone(), AgentConfig { waypoints: nearest, ..AgentConfig::default() });
            }
        }
        let desired_speed = Some(Spread::Same(speed));
        Some(DecisionConfig { desired_speed, waypoints, agents, ..DecisionConfig::default() })
    }

    /// Makes settings in which everybody walks at one speed \[m/s\], on one of the ways: by their shares, chosen by the seed.
    pub fn ways_by_shares(
        speed: f64,
        ways: impl IntoIterator<Item = (Vec<Waypoint>, f64)>,
        seed: u64,
    ) -> DecisionConfig {
        let way = |(waypoints, share)| WayConfig { waypoints, share: Some(share) };
        DecisionConfig {
            desired_speed: Some(Spread::Same(speed)),
            seed: Some(seed),
            ways: Some(ways.into_iter().map(way).collect()),
            ..DecisionConfig::default()
        }
    }

    /// Returns whether people who stand have legs.
    pub(crate) fn has_legs(&self) -> bool {
        self.balance.unwrap_or_default() != BalanceName::None
    }

    /// Returns the model of walking with its constants.
    pub(crate) fn walking_model(&self) -> Result<WalkingModel, PlanError> {
        let wanted = self.model.unwrap_or_default();
        match self.constants().find(|given| given.name() != wanted) {
            Some(other) => Err(PlanError::OtherModel { key: other.name().name() }),
            None => Ok(self.constants().next().unwrap_or_else(|| WalkingModel::usual(wanted))),
        }
    }

    /// Returns the model of balance with its constants, if people have legs.
    pub(crate) fn balance(&self) -> Result<Option<BalanceModel>, PlanError> {
        let name = self.balance.unwrap_or_default();
        let sections = [
            ("pendulum", BalanceName::Pendulum, self.pendulum.is_some()),
            ("two-level", BalanceName::TwoLevel, self.two_level.is_some()),
        ];
        if let Some((key, ..)) = sections.into_iter().find(|(_, of, given)| *given && *of != name) {
            return Err(PlanError::OtherBalance { key });
        }
        Ok(match name {
            BalanceName::None => None,
            BalanceName::Pendulum => Some(BalanceModel::Pendulum(self.pendulum.unwrap_or_default())),
            BalanceName::TwoLevel => Some(BalanceModel::TwoLevel(self.two_level.unwrap_or_default())),
        })
    }
}
