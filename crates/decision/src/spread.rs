//! Numbers that differ from person to person: one for all, or drawn from a distribution.

use crate::error::{PlanError, moderate, number};
use crate::stuck::share;
use serde::{Deserialize, Serialize};

/// A number of everybody.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "must be a number, { min, max } or { mean, sd, min, max }")]
pub enum Spread {
    /// The same number.
    Same(f64),
    /// Drawn from a normal distribution between two bounds.
    Normal(NormalBetween),
    /// Drawn from a uniform distribution.
    Uniform(Between),
}

/// A normal distribution between two bounds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)] // as said
pub struct NormalBetween {
    pub mean: f64,
    pub sd: f64,
    pub min: f64,
    pub max: f64,
}

/// Two bounds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(missing_docs)] // as said
pub struct Between {
    pub min: f64,
    pub max: f64,
}

/// \[standard deviations\] Bounds further from the mean on the same side are refused as a mistake.
const FARTHEST: f64 = 3.0;
/// Halvings of the range in which a quantile is looked for: to the precision of doubles.
const HALVINGS: u32 = 60;

/// Returns the probability that a standard normal variable is below `z`.
fn cumulative(z: f64) -> f64 {
    0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
}

impl NormalBetween {
    /// Returns the value below which the fraction `rank` (0…1) lies, by bisection.
    fn quantile(&self, rank: f64) -> f64 {
        let &NormalBetween { mean, sd, min, max } = self;
        let [from, to] = [min, max].map(|bound| cumulative((bound - mean) / sd));
        let wanted = from + rank * (to - from);
        let (mut low, mut high) = (min, max);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if cumulative((middle - mean) / sd) < wanted { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

impl Spread {
    /// Checks a setting for everybody; numbers are 0 to 1e9.
    pub(crate) fn check(&self, key: &'static str) -> Result<(), PlanError> {
        let place = "everybody";
        let bounds = |min: f64, max: f64| {
            moderate(place, key, min)?;
            moderate(place, key, max)?;
            number(place, key, max, |max| min < max, "more than min, as max")
        };
        match *self {
            Spread::Same(value) => moderate(place, key, value),
            Spread::Uniform(Between { min, max }) => bounds(min, max),
            Spread::Normal(NormalBetween { mean, sd, min, max }) => {
                bounds(min, max)?;
                number(place, key, sd, |sd| sd > 0.0, "a positive standard deviation, as sd")?;
                let near = |mean: f64| mean - FARTHEST * sd < max && min < mean + FARTHEST * sd;
                number(place, key, mean, near, "within three standard deviations of min and max, as mean")
            }
        }
    }

    /// Returns the number of a person: the same for the same seed. `draw` is the number of its draw.
    pub(crate) fn of(&self, seed: u64, person: usize, draw: u64) -> f64 {
        let rank = share(seed, person as u64, draw);
        match self {
            Spread::Same(value) => *value,
            Spread::Uniform(Between { min, max }) => min + (max - min) * rank,
            Spread::Normal(normal) => normal.quantile(rank),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moments(spread: &Spread) -> (f64, f64, [f64; 2]) {
        let all: Vec<f64> = (0..20_000).map(|person| spread.of(5, person, 1 << 40)).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let square: f64 = all.iter().map(|value| (value - mean).powi(2)).sum();
        let ends = [f64::INFINITY, f64::NEG_INFINITY];
        let ends = all.iter().fold(ends, |[low, high], value| [low.min(*value), high.max(*value)]);
        (mean, (square / all.len() as f64).sqrt(), ends)
    }

    #[test]
    fn draws_follow_their_distribution() {
        let (mean, sd, [low, high]) = moments(&Spread::Uniform(Between { min: 10.0, max: 100.0 }));
        assert!((mean - 55.0).abs() < 0.6 && (sd - 90.0 / 12f64.sqrt()).abs() < 0.4, "{mean} {sd}");
        assert!(low >= 10.0 && high <= 100.0 && low < 10.1 && high > 99.9);
        let normal = NormalBetween { mean: 1.34, sd: 0.26, min: 0.56, max: 2.12 };
        let (mean, sd, [low, high]) = moments(&Spread::Normal(normal));
        // Cut at three standard deviations, the standard deviation is 0.9867 times as large.
        assert!((mean - 1.34).abs() < 0.006 && (sd - 0.2565).abs() < 0.004, "{mean} {sd}");
        assert!(low >= 0.56 && high <= 2.12);
        // Half of a normal distribution: its mean is √(2/π) sd above the bound.
        let half = NormalBetween { mean: 5.0, sd: 2.0, min: 5.0, max: 1e3 };
        let (mean, ..) = moments(&Spread::Normal(half));
        assert!((mean - 5.0 - 2.0 * (2.0 / std::f64::consts::PI).sqrt()).abs() < 0.03, "{mean}");
        // Between bounds that are near to each other, it is nearly uniform.
        let narrow = NormalBetween { mean: 0.0, sd: 1e6, min: 0.0, max: 60.0 };
        let (mean, sd, [low, high]) = moments(&Spread::Normal(narrow));
        assert!((mean - 30.0).abs() < 0.4 && (sd - 60.0 / 12f64.sqrt()).abs() < 0.3, "{mean} {sd}");
        assert!(low >= 0.0 && high <= 60.0);
    }
}
