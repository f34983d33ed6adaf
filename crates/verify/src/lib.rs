//! The mechanics against things it did not produce: closed forms, conservation laws, symmetries, an
//! independent integrator. One table, every row measured when it is asked for.
//!
//! A [`Check`] measures one figure, the largest difference it finds, and passes when that is within its limit.

pub mod collision;
pub mod flight;
pub mod friction;
pub mod interfaces;
pub mod ledger;
pub mod reference;
pub mod scenarios;
pub mod scenes;
pub mod symmetry;
pub mod walls;

use anyhow::Result;

/// One row of the table.
pub struct Check {
    /// What is checked.
    pub name: &'static str,
    /// What it is compared with.
    pub against: &'static str,
    /// Of the figure; "" for a ratio.
    pub unit: &'static str,
    /// The largest figure that passes.
    pub limit: f64,
    /// Measures the figure.
    pub measure: fn() -> Result<f64>,
}

impl Check {
    const fn new(
        name: &'static str,
        against: &'static str,
        unit: &'static str,
        limit: f64,
        measure: fn() -> Result<f64>,
    ) -> Check {
        Check { name, against, unit, limit, measure }
    }

    /// Whether a figure passes.
    pub fn passes(&self, figure: f64) -> bool {
        figure <= self.limit
    }
}

/// Every row, in the order of the table.
pub fn checks() -> Vec<Check> {
    let groups = [
        collision::CHECKS,
        friction::CHECKS,
        walls::CHECKS,
        flight::CHECKS,
        ledger::CHECKS,
        symmetry::CHECKS,
        scenarios::CHECKS,
        reference::CHECKS,
    ];
    groups.into_iter().flatten().map(|check| Check { ..*check }).collect()
}

/// The largest of some differences; not a number if any is not.
pub(crate) fn largest(differences: impl IntoIterator<Item = f64>) -> f64 {
    differences.into_iter().fold(0.0, |worst, d| if d.is_nan() || d > worst { d } else { worst })
}
