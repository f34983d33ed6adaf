//! The mean of several runs, and how far from it the true one may be.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// Share of intervals that hold the true mean.
const CONFIDENCE: f64 = 0.95;

/// Mean of values, and half the width of its 95 % interval by Student's t.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanInterval {
    /// The mean.
    pub mean: f64,
    /// Half of the interval; `None`: of one value there is none.
    pub half: Option<f64>,
}

impl MeanInterval {
    /// Makes it of values, which are independent runs; `None` without any.
    pub fn of(values: &[f64]) -> Option<MeanInterval> {
        let count = values.len() as f64;
        let mean = (!values.is_empty()).then(|| values.iter().sum::<f64>() / count)?;
        let half = (values.len() > 1).then(|| {
            let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
            student(values.len() - 1) * (variance / count).sqrt()
        });
        Some(MeanInterval { mean, half })
    }

    /// Returns both ends of the interval.
    pub fn ends(&self) -> Option<[f64; 2]> {
        self.half.map(|half| [-1.0, 1.0].map(|sign| self.mean + sign * half))
    }
}

/// Returns the t within which [`CONFIDENCE`] of Student's distribution lie, for so many degrees of freedom.
fn student(freedom: usize) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    while within(high, freedom) < CONFIDENCE {
        high *= 2.0;
    }
    while high - low > 1e-12 * high {
        let middle = 0.5 * (low + high);
        if within(middle, freedom) < CONFIDENCE { low = middle } else { high = middle }
    }
    high
}

/// Returns the share of Student's distribution within ±t (Abramowitz and Stegun, 26.7.3 and 26.7.4).
fn within(t: f64, freedom: usize) -> f64 {
    let angle = (t / (freedom as f64).sqrt()).atan();
    let (sine, cosine) = angle.sin_cos();
    let odd = freedom % 2 == 1;
    let (mut term, mut sum) = if odd { (cosine, 0.0) } else { (1.0, 0.0) };
    // The powers of the cosine up to ν − 2.
    for power in (if odd { 1 } else { 0 }..freedom.saturating_sub(1)).step_by(2) {
        sum += term;
        term *= cosine * cosine * (power + 1) as f64 / (power + 2) as f64;
    }
    if odd { FRAC_2_PI * (angle.min(FRAC_PI_2) + sine * sum) } else { sine * sum }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tabulated values.
    #[test]
    fn the_quantiles_of_students_distribution() {
        let known = [
            (1, 12.7062047),
            (2, 4.3026527),
            (3, 3.1824463),
            (5, 2.5705818),
            (10, 2.2281389),
            (30, 2.0422725),
            (199, 1.9719565),
        ];
        for (freedom, t) in known {
            assert!((student(freedom) - t).abs() < 1e-6, "{freedom}: {}", student(freedom));
        }
    }
}
