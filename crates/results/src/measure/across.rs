//! One number of several people.

use crate::measure::quantile;
use serde::Deserialize;

/// Function that makes one number of those of several agents.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Across {
    /// The largest.
    Max,
    /// The smallest.
    Min,
    /// Their mean.
    Mean,
    /// Their median, linear between the two in the middle.
    Median,
    /// Their 90 % quantile, linear between two of them.
    #[serde(rename = "quantile_90")]
    Quantile90,
}

impl Across {
    /// Makes one of values, of which some may be infinite, but none is NaN; `None` without any.
    pub fn of(self, values: impl Iterator<Item = f64>) -> Option<f64> {
        let mut values: Vec<f64> = values.collect();
        let mut part = |part: f64| {
            values.sort_by(f64::total_cmp);
            // Between a finite and an infinite value is no number: the infinite one counts.
            let above = (part * values.len().saturating_sub(1) as f64).ceil() as usize;
            match values.get(above) {
                Some(value) if value.is_infinite() => Some(*value),
                _ => quantile(&values, part),
            }
        };
        match self {
            Across::Max => values.into_iter().reduce(f64::max),
            Across::Min => values.into_iter().reduce(f64::min),
            Across::Mean => {
                let count = values.len() as f64;
                values.into_iter().reduce(|a, b| a + b).map(|sum| sum / count)
            }
            Across::Median => part(0.5),
            Across::Quantile90 => part(0.9),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As numpy says; who never gets there is later than anybody else.
    #[test]
    fn quantiles_are_linear_and_later_than_never_is_never() {
        let of = |across: Across, values: &[f64]| across.of(values.iter().copied());
        let values = [3.0, 1.0, 2.0, 13.0];
        assert_eq!(of(Across::Median, &values), Some(2.5));
        assert!((of(Across::Quantile90, &values).unwrap() - 10.0).abs() < 1e-12);
        assert_eq!((of(Across::Mean, &values), of(Across::Min, &values)), (Some(4.75), Some(1.0)));
        let never = f64::INFINITY;
        assert_eq!(of(Across::Median, &[1.0, 2.0, never]), Some(2.0));
        assert_eq!(of(Across::Median, &[1.0, never]), Some(never));
        assert_eq!(of(Across::Quantile90, &[1.0, 2.0, never]), Some(never));
        assert_eq!(of(Across::Median, &[]), None);
    }
}
