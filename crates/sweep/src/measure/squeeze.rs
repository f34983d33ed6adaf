//! How long and how hard people are squeezed.

use lemons_core::require;
use lemons_results::measure::{Across, By, Exposed, SPANS, SqueezeOverTime};
use serde::Deserialize;

/// A measure of the squeeze of people over time, by its mean over each communication step.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SqueezeMeasure {
    /// Statistic of it.
    pub squeeze: What,
    /// \[s\] For [`What::LargestMean`]: 0.1, 1 or 10. For [`What::TimeAbove`]: of the means that are compared with
    /// the level; else they are those of communication steps.
    pub over: Option<f64>,
    /// \[N\] For [`What::TimeAbove`].
    pub level: Option<f64>,
    /// Agents or walls that press them; both if it is missing.
    pub by: Option<By>,
    /// Ids of agents in Agents.xml; empty: all agents.
    #[serde(default)]
    pub agents: Vec<String>,
    /// The function over several agents.
    pub across: Option<Across>,
    /// \[s\] From this time on.
    pub from: Option<f64>,
    /// \[s\] Up to this time.
    pub until: Option<f64>,
}

/// Statistic of what somebody was exposed to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum What {
    /// \[s\] In which the mean squeeze over a time, or over a communication step, is above a level.
    TimeAbove,
    /// \[N\] The greatest mean squeeze over a time.
    LargestMean,
    /// \[N\] The greatest squeeze within any step.
    Peak,
    /// \[N s\] The integral of the squeeze over time.
    Impulse,
    /// \[s\] How long they were there.
    Time,
}

impl SqueezeMeasure {
    /// Returns which of [`SPANS`] it is over.
    fn place(&self) -> Option<usize> {
        SPANS.into_iter().position(|span| Some(span) == self.over)
    }

    /// Checks that the measure is complete, but for `across`.
    ///
    /// # Errors
    /// A sentence that names what is missing.
    pub(crate) fn check(&self) -> Result<(), String> {
        let (mean, above) = (self.squeeze == What::LargestMean, self.squeeze == What::TimeAbove);
        let Self { over, level, .. } = self;
        let mistakes = [
            (
                !mean || self.place().is_some(),
                "squeeze = \"largest_mean\" needs over = 0.1, 1 or 10 (seconds)",
            ),
            (mean || above || over.is_none(), "over is for squeeze = \"largest_mean\" and \"time_above\""),
            (
                over.is_none_or(|over| over > 0.0 && over.is_finite()),
                "over must be a positive number of seconds",
            ),
            (!above || level.is_some(), "squeeze = \"time_above\" needs a level (newtons)"),
            (above || level.is_none(), "level is for squeeze = \"time_above\""),
            (
                self.by.is_none() || !matches!(self.squeeze, What::Peak | What::Time),
                "by is not for squeeze = \"peak\" and \"time\"",
            ),
            (
                level.is_none_or(|level| level >= 0.0 && level.is_finite()),
                "level must be a finite number of newtons, not below 0",
            ),
        ];
        mistakes.into_iter().try_for_each(|(holds, why)| require(holds, || why.to_owned()))
    }

    /// Begins to sum up the squeeze of the agents at these places.
    pub(crate) fn begin(&self, agents: Vec<usize>) -> SqueezeOverTime {
        let over = self.over.filter(|_| self.squeeze == What::TimeAbove);
        SqueezeOverTime::of(agents, self.level.as_slice(), over)
    }

    /// Returns the number of the agents; `None` if it is not known of all of them: there is no step, or the
    /// time is too short for a mean over it.
    pub(crate) fn value(&self, seen: &SqueezeOverTime) -> Option<f64> {
        let of = |one: &Exposed| match self.squeeze {
            What::TimeAbove => one.above[0].map(|above| above.time),
            What::LargestMean => one.largest_mean[self.place()?],
            What::Peak => Some(one.peak),
            What::Impulse => Some(one.impulse),
            What::Time => Some(one.time),
        };
        let values: Vec<f64> = seen.finish().ok()?.iter().map(of).collect::<Option<_>>()?;
        self.across.unwrap_or(Across::Max).of(values.into_iter())
    }
}
