//! Quantiles of numbers too many to keep.

use std::collections::BTreeMap;

/// How positive numbers are spread. All that agree to a thousandth are counted together.
#[derive(Default)]
pub struct Spread {
    /// How many, and the largest of them.
    bins: BTreeMap<u64, (u64, f64)>,
    count: u64,
}

impl Spread {
    /// Zeros, what is negative and what is not finite do not count.
    pub fn add(&mut self, value: f64) {
        /// Bits of a number that are left out: what remains grows with it, by ten bits of its mantissa.
        const FINE: u32 = 42;
        if !(value > 0.0 && value.is_finite()) {
            return;
        }
        let (count, largest) = self.bins.entry(value.to_bits() >> FINE).or_insert((0, value));
        *count += 1;
        *largest = largest.max(value);
        self.count += 1;
    }

    /// The quantile by nearest rank, to a thousandth, and whether any is beyond it.
    pub fn quantile(&self, part: f64) -> Option<(f64, bool)> {
        // The rounding of 0.98 · 50 is not a rank.
        let rank = (part * self.count as f64 - 1e-6).ceil().max(1.0) as u64;
        let mut below = 0;
        for (count, largest) in self.bins.values() {
            below += count;
            if below >= rank {
                return Some((*largest, below < self.count));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quantile_is_that_of_the_nearest_rank() {
        let mut spread = Spread::default();
        assert_eq!(spread.quantile(0.98), None);
        [0.0, -3.0, f64::NAN, f64::INFINITY].into_iter().for_each(|value| spread.add(value));
        assert_eq!(spread.quantile(0.98), None);
        (1..=50).rev().for_each(|value| spread.add(f64::from(value)));
        assert_eq!(spread.quantile(0.98), Some((49.0, true)));
        assert_eq!(spread.quantile(1.0), Some((50.0, false)));
        (0..100_000).for_each(|k| spread.add(1e3 + f64::from(k)));
        let (high, beyond) = spread.quantile(0.98).unwrap();
        assert!((high / 99e3 - 1.0).abs() < 1e-3 && beyond && spread.bins.len() < 10_000, "{high}");
    }
}
