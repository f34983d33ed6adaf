//! The range of values of an axis, and round tick values.

use crate::text::{round_above, short, text_of};

/// The range of values of an axis.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Range {
    pub low: f64,
    pub high: f64,
}

impl Range {
    /// The range of all values. If `reaches_zero`, it is extended to zero if that is near.
    pub fn around(values: impl Iterator<Item = f64>, reaches_zero: bool) -> Range {
        let (mut low, mut high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        if reaches_zero && low > 0.0 && low < 0.6 * high {
            low = 0.0;
        }
        if high / 2.0 - low / 2.0 <= (1e-12 * high.abs().max(low.abs())).max(1e-250) {
            let grow = if high.abs() < 1e-250 { 1.0 } else { 0.1 * high.abs() };
            if low == 0.0 && reaches_zero {
                high = grow;
            } else {
                (low, high) = (low - grow, high + grow);
            }
        }
        Range { low: low.max(-1e307), high: high.min(1e307) }
    }

    /// Adds space beyond the curves, but not below zero.
    pub fn airy(self) -> Range {
        let air = 0.05 * (self.high - self.low);
        let low = if self.low == 0.0 { 0.0 } else { self.low - air };
        Range { low, high: self.high + air }
    }

    pub fn part(self, v: f64) -> f64 {
        ((v - self.low) / (self.high - self.low)).clamp(-0.1, 1.1)
    }

    /// Returns about `about` round numbers with their labels; integers only if `whole`.
    pub fn ticks(self, about: f64, whole: bool) -> Vec<(f64, String)> {
        let mut step = round_above((self.high - self.low) / about);
        if whole {
            step = step.max(1.0);
        }
        let first = (self.low / step).ceil();
        let decimals = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
        let plain = (1e-4..1e6).contains(&step) && self.high.abs().max(self.low.abs()) < 1e6;
        (0..100)
            .map(|k| first + f64::from(k))
            .map(|k| k * step)
            .take_while(|v| *v <= self.high * (1.0 + 1e-12 * self.high.signum()))
            .map(|v| (v, if plain { text_of(v, decimals) } else { short(v) }))
            .collect()
    }
}
