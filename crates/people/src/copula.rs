//! The Gaussian copula: draws measures with given rank correlations (Spearman's), whatever the distribution of each.

use crate::error::{Result, require};
use crate::normal::cumulative;
use crate::random::Random;
use nalgebra::{Cholesky, Matrix4, Vector4};

/// Number of correlated measures: those of [`crate::Measure::ALL`].
const N: usize = 4;

/// A symmetric matrix of correlations in the order of [`crate::Measure::ALL`].
pub type Correlations = [[f64; N]; N];

/// Draws correlated ranks.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Copula {
    /// Cholesky factor of the Pearson correlations of the normal variables.
    lower: Matrix4<f64>,
}

/// Returns the lower triangle L with L·Lᵀ = `matrix`, or `None` if it is not positive definite.
fn cholesky(matrix: Matrix4<f64>) -> Option<Matrix4<f64>> {
    // Smaller pivots are rounding errors. A measure that follows from the others gets a standard deviation of 1e-6.
    const PIVOT: f64 = 1e-6;
    let lower = Cholesky::new(matrix)?.l();
    (lower.diagonal().min() > PIVOT).then_some(lower)
}

/// Multiplies all correlations between two different measures by `part`.
fn weakened(matrix: &Matrix4<f64>, part: f64) -> Matrix4<f64> {
    let mut weak = matrix * part;
    weak.fill_diagonal(1.0);
    weak
}

impl Copula {
    /// Makes a copula with Spearman's rank correlations ρ. Two normal variables have them if their Pearson correlation
    /// is 2 sin(π ρ/6) (Pearson 1907). Where no four normal variables can have all of those, all correlations are
    /// weakened by one common factor, as little as possible.
    pub(crate) fn new(spearman: &Correlations) -> Result<Copula> {
        for (row, values) in spearman.iter().enumerate() {
            for (column, &value) in values.iter().enumerate() {
                let right = if row == column { value == 1.0 } else { (-1.0..=1.0).contains(&value) };
                require(right, || {
                    format!(
                        "correlation ({row}, {column}) = {value}: must be within −1…1, and 1 on the diagonal"
                    )
                })?;
                let mirror = spearman[column][row];
                require(value == mirror, || {
                    format!(
                        "correlation ({row}, {column}) = {value}: must be equal to ({column}, {row}), which is {mirror}"
                    )
                })?;
            }
        }
        let pearson = Matrix4::from_fn(|row, column| match spearman[row][column] {
            1.0 => 1.0,
            value => 2.0 * libm::sin(std::f64::consts::PI * value / 6.0),
        });
        if let Some(lower) = cholesky(pearson) {
            return Ok(Copula { lower });
        }
        let mut lower = Matrix4::identity();
        let (mut least, mut most) = (0.0, 1.0);
        for _ in 0..50 {
            let part = 0.5 * (least + most);
            match cholesky(weakened(&pearson, part)) {
                Some(factor) => (least, lower) = (part, factor),
                None => most = part,
            }
        }
        Ok(Copula { lower })
    }

    /// Draws the ranks of one person, each evenly distributed between 0 and 1.
    pub(crate) fn ranks(&self, random: &mut Random) -> [f64; N] {
        let free = Vector4::from_fn(|_, _| random.normal());
        (self.lower * free).map(cumulative).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    /// All correlations between two measures are these, in the order bd bs bm ds dm sm.
    fn matrix(values: [f64; 6]) -> Correlations {
        let [bd, bs, bm, ds, dm, sm] = values;
        [[1.0, bd, bs, bm], [bd, 1.0, ds, dm], [bs, ds, 1.0, sm], [bm, dm, sm, 1.0]]
    }

    #[test]
    fn the_factor_gives_the_matrix_back() {
        let spearman = matrix([0.7581, 0.3001, 0.8771, 0.2049, 0.8538, 0.448]);
        let lower = Copula::new(&spearman).unwrap().lower;
        let pearson = lower * lower.transpose();
        for row in 0..N {
            for column in 0..N {
                let back = libm::asin(pearson[(row, column)] / 2.0) * 6.0 / std::f64::consts::PI;
                assert!((back - spearman[row][column]).abs() < 1e-14, "{row} {column}");
            }
        }
    }

    #[test]
    fn an_impossible_matrix_is_weakened_no_more_than_it_must() {
        // Three measures cannot all be opposed to each other: at most −1/2.
        let copula = Copula::new(&matrix([-0.9, -0.9, 0.0, -0.9, 0.0, 0.0])).unwrap();
        let pearson = copula.lower[(1, 0)];
        assert!(copula.lower[(0, 0)] == 1.0 && (pearson + 0.5).abs() < 1e-9, "{pearson}");
        // Measures that are one and the same.
        let copula = Copula::new(&matrix([1.0; 6])).unwrap();
        let ranks = copula.ranks(&mut Random::new(1));
        assert!(ranks.iter().all(|rank| (rank - ranks[0]).abs() < 1e-4), "{ranks:?}");
    }

    #[test]
    fn no_correlations_are_refused() {
        let mut spearman = matrix([0.5; 6]);
        spearman[2][1] = 0.4;
        let message = Copula::new(&spearman).unwrap_err().to_string();
        assert_eq!(message, "correlation (1, 2) = 0.5: must be equal to (2, 1), which is 0.4");
        for bad in [1.5, f64::NAN] {
            let message = Copula::new(&matrix([bad; 6])).unwrap_err().to_string();
            assert!(message.starts_with("correlation (0, 1) = "), "{message}");
        }
    }
}
