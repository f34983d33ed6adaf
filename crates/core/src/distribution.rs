//! Distributions of one number. Results are the same bits on every machine because it uses `libm`, never the platform's
//! library.

use crate::require;
use serde::{Deserialize, Serialize};

/// The ratio of two polynomials, by Horner's rule; the constant coefficients are the last ones.
fn ratio(coefficients: [[f64; 2]; 8], x: f64) -> f64 {
    let [above, below] =
        coefficients.iter().fold([0.0; 2], |sum, pair| [sum[0] * x + pair[0], sum[1] * x + pair[1]]);
    above / below
}

/// Halves a range so many times: `is_low` holds below the wanted number, and not above it. Returns the ends.
pub fn bisected([mut low, mut high]: [f64; 2], times: u32, is_low: impl Fn(f64) -> bool) -> (f64, f64) {
    for _ in 0..times {
        let middle = 0.5 * (low + high);
        if is_low(middle) { low = middle } else { high = middle }
    }
    (low, high)
}

/// Returns the probability that a standard normal variable is below `z`.
pub fn cumulative(z: f64) -> f64 {
    0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2)
}

/// Inverse of [`cumulative`], relative error about 1e-16: Wichura's algorithm AS 241 (Applied Statistics 37, 1988).
#[allow(clippy::excessive_precision)] // the digits as published
pub fn inverse(p: f64) -> f64 {
    const CENTRE: [[f64; 2]; 8] = [
        [2.509_080_928_730_122_672_7e3, 5.226_495_278_852_854_561e3],
        [3.343_057_558_358_812_810_5e4, 2.872_908_573_572_194_267_4e4],
        [6.726_577_092_700_870_085_3e4, 3.930_789_580_009_271_061e4],
        [4.592_195_393_154_987_145_7e4, 2.121_379_430_158_659_586_7e4],
        [1.373_169_376_550_946_112_5e4, 5.394_196_021_424_751_107_7e3],
        [1.971_590_950_306_551_442_7e3, 6.871_870_074_920_579_083e2],
        [1.331_416_678_917_843_774_5e2, 4.231_333_070_160_091_125_2e1],
        [3.387_132_872_796_366_608, 1.0],
    ];
    const SIDE: [[f64; 2]; 8] = [
        [7.745_450_142_783_414_076_4e-4, 1.050_750_071_644_416_843_24e-9],
        [2.272_384_498_926_918_458_33e-2, 5.475_938_084_995_344_946e-4],
        [2.417_807_251_774_506_117_7e-1, 1.519_866_656_361_645_719_66e-2],
        [1.270_458_252_452_368_382_58, 1.481_039_764_274_800_745_9e-1],
        [3.647_848_324_763_204_605_04, 6.897_673_349_851_000_045_5e-1],
        [5.769_497_221_460_691_405_5, 1.676_384_830_183_803_849_4],
        [4.630_337_846_156_545_295_9, 2.053_191_626_637_758_821_87],
        [1.423_437_110_749_683_577_34, 1.0],
    ];
    const TAIL: [[f64; 2]; 8] = [
        [2.010_334_399_292_288_132_65e-7, 2.044_263_103_389_939_785_64e-15],
        [2.711_555_568_743_487_578_15e-5, 1.421_511_758_316_445_888_7e-7],
        [1.242_660_947_388_078_438_6e-3, 1.846_318_317_510_054_681_8e-5],
        [2.653_218_952_657_612_309_3e-2, 7.868_691_311_456_132_591e-4],
        [2.965_605_718_285_048_912_3e-1, 1.487_536_129_085_061_485_25e-2],
        [1.784_826_539_917_291_335_8, 1.369_298_809_227_358_053_1e-1],
        [5.463_784_911_164_114_369_9, 5.998_322_065_558_879_376_9e-1],
        [6.657_904_643_501_103_777_2, 1.0],
    ];
    if p <= 0.0 || p >= 1.0 {
        return if p <= 0.0 { f64::NEG_INFINITY } else { f64::INFINITY };
    }
    let q = p - 0.5;
    if q.abs() <= 0.425 {
        return q * ratio(CENTRE, 0.180_625 - q * q);
    }
    let r = (-libm::log(if q < 0.0 { p } else { 1.0 - p })).sqrt();
    let z = if r <= 5.0 { ratio(SIDE, r - 1.6) } else { ratio(TAIL, r - 5.0) };
    if q < 0.0 { -z } else { z }
}

/// A normal distribution between two bounds, in the unit of the measure.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TruncatedNormal {
    /// Before truncation.
    pub mean: f64,
    /// Standard deviation before truncation.
    pub sd: f64,
    /// Lower bound.
    pub min: f64,
    /// Upper bound.
    pub max: f64,
}

impl From<[f64; 4]> for TruncatedNormal {
    /// Mean, standard deviation, lower bound, upper bound.
    fn from([mean, sd, min, max]: [f64; 4]) -> TruncatedNormal {
        TruncatedNormal { mean, sd, min, max }
    }
}

/// \[standard deviations\] Bounds further from the mean than this are taken for a mistake: less than one in 10⁹ of the
/// untruncated distribution is there.
const FARTHEST: f64 = 6.0;

impl TruncatedNormal {
    /// Checks that values can be drawn from it. They must not be negative.
    ///
    /// # Errors
    /// A number is not finite; the deviation is not positive; the minimum is negative; min ≥ max; the bounds are too far
    /// from the mean.
    pub fn check(&self) -> Result<(), String> {
        let &TruncatedNormal { mean, sd, min, max } = self;
        for (field, value) in [("mean", mean), ("standard deviation", sd), ("min", min), ("max", max)] {
            require(value.is_finite(), || format!("{field} = {value}: must be a finite number"))?;
        }
        require(sd > 0.0, || format!("the standard deviation = {sd}: must be positive"))?;
        Range { min, max }.check()?;
        require(min <= mean + FARTHEST * sd && max >= mean - FARTHEST * sd, || {
            format!(
                "min = {min}, max = {max}: more than {FARTHEST} standard deviations ({sd}) away from the mean {mean}"
            )
        })
    }

    /// Returns the value below which the fraction `rank` (0…1) of the distribution lies, by exact inversion.
    pub fn quantile(&self, rank: f64) -> f64 {
        let [low, high] = [self.min, self.max].map(|bound| (bound - self.mean) / self.sd);
        // Compute in the nearer tail, where the small probability keeps its digits.
        let within = |from: f64, to: f64, part: f64| {
            let start = cumulative(from);
            start + part * (cumulative(to) - start)
        };
        let below = within(low, high, rank);
        let z = if below < 0.5 { inverse(below) } else { -inverse(within(-high, -low, 1.0 - rank)) };
        // This only corrects rounding.
        (self.mean + self.sd * z).clamp(self.min, self.max)
    }
}

/// The bounds of a uniform distribution.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Range {
    /// Lower bound.
    pub min: f64,
    /// Upper bound.
    pub max: f64,
}

impl Range {
    fn check(&self) -> Result<(), String> {
        let Range { min, max } = self;
        require(min.is_finite() && max.is_finite(), || {
            format!("min = {min}, max = {max}: must be finite numbers")
        })?;
        require(*min >= 0.0, || format!("min = {min}: must not be negative"))?;
        require(min < max, || format!("min = {min}, max = {max}: min must be below max"))
    }
}

/// A distribution of one number.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "must be { mean, sd, min, max } or { min, max }")]
pub enum Distribution {
    /// A normal distribution between two bounds.
    Normal(TruncatedNormal),
    /// Each number between two bounds is as likely.
    Uniform(Range),
}

impl Distribution {
    /// Checks that values can be drawn from it. They must not be negative.
    ///
    /// # Errors
    /// A number is impossible.
    pub fn check(&self) -> Result<(), String> {
        match self {
            Distribution::Normal(normal) => normal.check(),
            Distribution::Uniform(range) => range.check(),
        }
    }

    /// Returns the value below which the fraction `rank` (0…1) lies.
    pub fn quantile(&self, rank: f64) -> f64 {
        match self {
            Distribution::Normal(normal) => normal.quantile(rank),
            Distribution::Uniform(Range { min, max }) => min + rank * (max - min),
        }
    }

    /// Returns the upper bound.
    pub fn max(&self) -> f64 {
        match self {
            Distribution::Normal(TruncatedNormal { max, .. }) | Distribution::Uniform(Range { max, .. }) => {
                *max
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_undoes_the_distribution() {
        for k in -3700..=800 {
            let z = f64::from(k) * 0.01;
            // Near 1 a probability has no digits left: 1e-16 of it is that much of z.
            let rounding = 1e-16 / libm::exp(-0.5 * z * z) * 2.5 * cumulative(z);
            assert!((inverse(cumulative(z)) - z).abs() < 1e-13 * z.abs().max(1.0) + 4.0 * rounding, "{z}");
        }
        // Abramowitz & Stegun, table 26.1 and percentage points of the normal distribution.
        assert!((inverse(0.975) - 1.959_963_984_540_054).abs() < 1e-15);
        assert!((inverse(1e-10) + 6.361_340_902_404_056).abs() < 1e-14);
        assert!((cumulative(1.0) - 0.841_344_746_068_543).abs() < 1e-15);
    }

    #[test]
    fn truncation_moves_mean_and_deviation_as_the_closed_form_says() {
        for (mean, sd, min, max) in [
            (51.0, 2.0, 30.0, 65.0),
            (1.0, 1.0, 1.0, 3.0),
            (1.0, 1.0, 3.0, 9.0),
            (5.0, 1.0, 0.5, 4.0),
            (1.0, 1.0, 6.5, 50.0),
        ] {
            let normal = TruncatedNormal { mean, sd, min, max };
            normal.check().unwrap();
            let (a, b): (f64, f64) = ((min - mean) / sd, (max - mean) / sd);
            let density = |z: f64| (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt();
            let part = if a > 0.0 { cumulative(-a) - cumulative(-b) } else { cumulative(b) - cumulative(a) };
            let shift = (density(a) - density(b)) / part;
            let expected_mean = mean + sd * shift;
            let variance = sd * sd * (1.0 + (a * density(a) - b * density(b)) / part - shift * shift);
            let ranks = 2_000_000;
            let values = (0..ranks).map(|k| normal.quantile((f64::from(k) + 0.5) / f64::from(ranks)));
            let (mut sum, mut squares) = (0.0, 0.0);
            for value in values {
                assert!((min..=max).contains(&value));
                sum += value - expected_mean;
                squares += (value - expected_mean).powi(2);
            }
            let (off, found) = (sum / f64::from(ranks), squares / f64::from(ranks));
            assert!(off.abs() < 1e-5 * sd, "{normal:?}: {off}");
            assert!((found / variance - 1.0).abs() < 1e-4, "{normal:?}: {found} {variance}");
            assert!((normal.quantile(0.0) - min).abs() < 1e-9 && (normal.quantile(1.0) - max).abs() < 1e-9);
        }
    }

    #[test]
    fn bad_parameters_are_named() {
        let right = TruncatedNormal { mean: 51.0, sd: 2.0, min: 30.0, max: 65.0 };
        for (wrong, message) in [
            (TruncatedNormal { sd: 0.0, ..right }, "the standard deviation = 0: must be positive"),
            (TruncatedNormal { min: 65.0, ..right }, "min = 65, max = 65: min must be below max"),
            (TruncatedNormal { min: -1.0, ..right }, "min = -1: must not be negative"),
            (TruncatedNormal { max: f64::INFINITY, ..right }, "max = inf: must be a finite number"),
            (
                TruncatedNormal { mean: 100.0, ..right },
                "min = 30, max = 65: more than 6 standard deviations (2) away from the mean 100",
            ),
        ] {
            assert_eq!(wrong.check().unwrap_err(), message);
        }
        right.check().unwrap();
    }
}
