//! Measures of a run: who crosses a line and when ([`CountingLine`], [`Passages`], [`Flow`]), how dense a crowd is in an
//! area ([`VoronoiRoom`], [`MeasuringArea`]), how long and how hard people are squeezed ([`SqueezeOverTime`], [`MovingMeans`]) and where
//! ([`SqueezeMap`]), how people keep their balance ([`BalanceOverTime`]), how long trunks are pressed ([`BreathingOverTime`]), how hard
//! walls are pressed ([`LoadsOverTime`]).
//!
//! Frames are given one after the other, in the order of time; nothing here keeps them. docs/measure.md defines each
//! number. SI units.

mod across;
mod balance;
mod breathing;
mod by_place;
mod crossing;
mod density;
mod departures;
mod exposure;
mod flow;
mod impulses;
mod interval;
mod leaving;
mod loads;
mod passages;
mod quantile;
mod summary;
mod voronoi;

pub use across::Across;
pub use balance::{BalanceOverTime, Kept};
pub use breathing::{Breathing, BreathingOverTime, LOADS as BREATHING_LOADS};
pub use by_place::SqueezeMap;
pub use crossing::{CountingLine, Way};
pub use density::{Density, MeasuringArea};
pub use departures::{Departures, Left};
pub use exposure::{Above, Exposed, SPANS, SqueezeOverTime};
pub use flow::{Flow, Window, windows};
pub use impulses::MovingMeans;
pub use interval::MeanInterval;
pub use leaving::{LATEST, Leaving, OUTSIDE, Over, WAITING, Wait};
pub use loads::{LoadsOverTime, Panel, WallLoad, WallLoads};
pub use passages::{Passage, Passages};
pub use quantile::quantile;
pub use summary::{Crossings, MeanMax};
pub use voronoi::VoronoiRoom;

use crate::Frame;
use crate::columns::Effect;
use lemons_core::plane::{InPlane, Motion};
use serde::Deserialize;

/// \[N\] and \[s\] Usual limit of the squeeze, and of which mean: docs/guide/squeeze.md says whose it is.
pub const LIMIT: (f64, f64) = (623.0, 1.0);
/// \[s\] Times are sums of steps: rounding does not leave a frame out.
const ROUNDING: f64 = 1e-9;

/// Returns whether a time lies between two, where they are given; all \[s\].
pub fn within(time: f64, from: Option<f64>, until: Option<f64>) -> bool {
    from.is_none_or(|from| time >= from - ROUNDING) && until.is_none_or(|until| time <= until + ROUNDING)
}

/// Returns where a person is and how it moves; `None` if the person is not in the frame, or has left.
pub fn present(frame: &Frame, agent: usize) -> Option<&Motion> {
    let motion = frame.agents.get(agent).filter(|_| frame.is_there(agent));
    motion.filter(|motion| motion.pose.position.is_finite())
}

/// Agents or walls that press a person.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum By {
    /// Other people.
    People,
    /// Walls.
    Walls,
}

impl By {
    /// Both.
    pub const ALL: [By; 2] = [By::People, By::Walls];

    /// Returns the name.
    pub fn name(self) -> &'static str {
        if self == By::People { "people" } else { "walls" }
    }
}

/// Returns mean and peak squeeze \[N\] of a person over the communication step that ends at a frame; `None` as
/// [`present`], or if the frame does not say. With `by`, it is the part of the mean by people or by walls, and again in the
/// place of the peak, which is not split.
pub fn squeeze(frame: &Frame, agent: usize, by: Option<By>) -> Option<(f64, f64)> {
    present(frame, agent)?;
    let effect = |effect| frame.effects.get(effect, agent);
    let mean = effect(Effect::MeanNormalForce)?;
    let Some(by) = by else { return Some((mean, effect(Effect::PeakNormalForce)?)) };
    let walls = effect(Effect::MeanWallForce)?;
    // A table of rounded numbers may have a little less in all than by walls.
    let part = if by == By::Walls { walls } else { (mean - walls).max(0.0) };
    Some((part, part))
}
