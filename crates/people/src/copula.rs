//! The Gaussian copula: draws measures with given rank correlations (Spearman's), whatever the distribution of each.

use crate::error::{Result, require};
use crate::random::Random;
use lemons_core::distribution::{bisected, cumulative};
use nalgebra::{Matrix4, Vector4};

/// Number of correlated measures: those of [`crate::BodyMeasure::ALL`].
const N: usize = 4;

/// A symmetric matrix of correlations in the order of [`crate::BodyMeasure::ALL`].
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
    const PIVOT: f64 = 1e-12;
    let lower = matrix.cholesky()?.unpack();
    lower.diagonal().iter().all(|root| root * root > PIVOT).then_some(lower)
}

/// Multiplies all correlations between two different measures by `part`.
fn weakened(matrix: &Matrix4<f64>, part: f64) -> Matrix4<f64> {
    let mut weakened = matrix * part;
    weakened.fill_diagonal(1.0);
    weakened
}

impl Copula {
    /// Makes a copula with Spearman's rank correlations ρ. Two normal variables have them if their Pearson correlation
    /// is 2 sin(π ρ/6) (Pearson 1907). Where no four normal variables can have all of those, all correlations are
    /// weakened by one common factor, as little as possible.
    pub(crate) fn new(spearman: &Correlations) -> Result<Copula> {
        for (row, column) in (0..N).flat_map(|row| (0..N).map(move |column| (row, column))) {
            let (value, mirror) = (spearman[row][column], spearman[column][row]);
            let right = if row == column { value == 1.0 } else { (-1.0..=1.0).contains(&value) };
            let must = if !right {
                "be within −1…1, and 1 on the diagonal".to_owned()
            } else {
                format!("be equal to ({column}, {row}), which is {mirror}")
            };
            require(right && value == mirror, || {
                format!("correlation ({row}, {column}) = {value}: must {must}")
            })?;
        }
        let normal =
            |rho: f64| if rho == 1.0 { 1.0 } else { 2.0 * libm::sin(std::f64::consts::PI * rho / 6.0) };
        let pearson = Matrix4::from(*spearman).map(normal);
        if let Some(lower) = cholesky(pearson) {
            return Ok(Copula { lower });
        }
        let (part, _) = bisected([0.0, 1.0], 50, |part| cholesky(weakened(&pearson, part)).is_some());
        let lower = cholesky(weakened(&pearson, part));
        // No correlations are always possible.
        Ok(Copula { lower: lower.unwrap_or_else(Matrix4::identity) })
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

    /// Only one lower triangle with a positive diagonal does.
    #[test]
    fn the_factor_gives_the_matrix_back() {
        let spearman = matrix([0.7581, 0.3001, 0.8771, 0.2049, 0.8538, 0.448]);
        let lower = Copula::new(&spearman).unwrap().lower;
        for row in 0..N {
            assert!(lower[(row, row)] > 0.0 && (row + 1..N).all(|above| lower[(row, above)] == 0.0));
            for column in 0..N {
                let pearson: f64 = (0..N).map(|k| lower[(row, k)] * lower[(column, k)]).sum();
                let back = libm::asin(pearson / 2.0) * 6.0 / std::f64::consts::PI;
                assert!((back - spearman[row][column]).abs() < 1e-14, "{row} {column}");
            }
        }
    }

    #[test]
    fn an_impossible_matrix_is_weakened_no_more_than_it_must() {
        // Three measures cannot all be opposed to each other: at most −1/2.
        let copula = Copula::new(&matrix([-0.9, -0.9, 0.0, -0.9, 0.0, 0.0])).unwrap();
        let pearson: f64 = (0..N).map(|k| copula.lower[(1, k)] * copula.lower[(0, k)]).sum();
        assert!((pearson + 0.5).abs() < 1e-9, "{pearson}");
        assert!((pearson - copula.lower[(1, 0)]).abs() < 1e-15);
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
