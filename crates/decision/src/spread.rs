//! Numbers that differ from person to person: one for all, or drawn from a distribution.

use crate::error::{PlanError, moderate};
use crate::stuck::share;
use lemons_core::distribution::Distribution;
use serde::{Deserialize, Serialize};

/// A number of everybody.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "must be a number, { min, max } or { mean, sd, min, max }")]
pub enum Spread {
    /// The same number.
    Same(f64),
    /// A number of its own for each.
    Drawn(Distribution),
}

impl Spread {
    /// Checks a setting for everybody; numbers are 0 to 1e9.
    ///
    /// # Errors
    /// One is not, or bounds are not in order.
    pub fn check(&self, key: &'static str) -> Result<(), PlanError> {
        match self {
            Spread::Same(value) => moderate("everybody", key, *value),
            Spread::Drawn(from) => {
                from.check().map_err(|problem| PlanError::Distribution { key, problem })?;
                moderate("everybody", key, from.max())
            }
        }
    }

    /// Returns the number of a person: the same for the same seed. `draw` is the number of its draw.
    pub(crate) fn of(&self, seed: u64, person: usize, draw: u64) -> f64 {
        self.at(share(seed, person as u64, draw))
    }

    /// Returns the number at a rank from 0 to 1.
    pub(crate) fn at(&self, rank: f64) -> f64 {
        match self {
            Spread::Same(value) => *value,
            Spread::Drawn(from) => from.quantile(rank),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lemons_core::distribution::{Range, TruncatedNormal};

    fn moments(from: Distribution) -> (f64, f64, [f64; 2]) {
        let spread = Spread::Drawn(from);
        let all: Vec<f64> = (0..20_000).map(|person| spread.of(5, person, 1 << 40)).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let square: f64 = all.iter().map(|value| (value - mean).powi(2)).sum();
        let ends = [f64::INFINITY, f64::NEG_INFINITY];
        let ends = all.iter().fold(ends, |[low, high], value| [low.min(*value), high.max(*value)]);
        (mean, (square / all.len() as f64).sqrt(), ends)
    }

    #[test]
    fn draws_follow_their_distribution() {
        let (mean, sd, [low, high]) = moments(Distribution::Uniform(Range { min: 10.0, max: 100.0 }));
        assert!((mean - 55.0).abs() < 0.6 && (sd - 90.0 / 12f64.sqrt()).abs() < 0.4, "{mean} {sd}");
        assert!(low >= 10.0 && high <= 100.0 && low < 10.1 && high > 99.9);
        let normal = TruncatedNormal { mean: 1.34, sd: 0.26, min: 0.56, max: 2.12 };
        let (mean, sd, [low, high]) = moments(Distribution::Normal(normal));
        // Cut at three standard deviations, the standard deviation is 0.9867 times as large.
        assert!((mean - 1.34).abs() < 0.006 && (sd - 0.2565).abs() < 0.004, "{mean} {sd}");
        assert!(low >= 0.56 && high <= 2.12);
        // Half of a normal distribution: its mean is √(2/π) sd above the bound.
        let half = TruncatedNormal { mean: 5.0, sd: 2.0, min: 5.0, max: 1e3 };
        let (mean, ..) = moments(Distribution::Normal(half));
        assert!((mean - 5.0 - 2.0 * (2.0 / std::f64::consts::PI).sqrt()).abs() < 0.03, "{mean}");
        // Between bounds that are near to each other, it is nearly uniform.
        let narrow = TruncatedNormal { mean: 0.0, sd: 1e6, min: 0.0, max: 60.0 };
        let (mean, sd, [low, high]) = moments(Distribution::Normal(narrow));
        assert!((mean - 30.0).abs() < 0.4 && (sd - 60.0 / 12f64.sqrt()).abs() < 0.3, "{mean} {sd}");
        assert!(low >= 0.0 && high <= 60.0);
    }
}
