//! What a crowd went through at worst.

use serde::{Deserialize, Serialize};

/// The extremes of a run at its communication points.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Extremes {
    /// \[m\]
    pub largest_overlap: f64,
    /// \[N\]
    pub greatest_squeeze: f64,
    pub most_squeezed: Option<Squeezed>,
}

/// Who was squeezed most.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Squeezed {
    /// Among the agents.
    pub agent: usize,
    /// \[s\]
    pub time: f64,
}
