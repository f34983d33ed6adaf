//! Compares the mechanics with independent results: closed forms, conservation laws, symmetries, an independent
//! integrator. They form one table, and every row is measured when it is asked for.
//!
//! A [`Check`] measures one figure: the largest difference that it finds. It passes if the figure is within its limit.

pub mod collision;
mod error;
pub mod exposure;
pub mod flight;
pub mod friction;
pub mod interfaces;
pub mod ledger;
pub mod order;
pub mod passivity;
pub mod ramp;
pub mod reference;
pub mod scenarios;
pub mod scenes;
pub mod stability;
pub mod symmetry;
pub mod walls;

use crowd_mechanics::engine::World;
pub use error::{Error, Result};

/// One row of the table.
pub struct Check {
    /// What is checked.
    pub name: &'static str,
    /// What it is compared with.
    pub against: &'static str,
    /// Unit of the figure; "" for a ratio.
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

    /// Returns whether a figure passes.
    pub fn passes(&self, figure: f64) -> bool {
        figure <= self.limit
    }
}

/// Returns all rows, in the order of the table.
pub fn all() -> Vec<Check> {
    let groups = [
        collision::CHECKS,
        friction::CHECKS,
        order::CHECKS,
        walls::CHECKS,
        passivity::CHECKS,
        stability::CHECKS,
        exposure::CHECKS,
        flight::CHECKS,
        ramp::CHECKS,
        ledger::CHECKS,
        symmetry::CHECKS,
        scenarios::CHECKS,
        reference::CHECKS,
    ];
    groups.into_iter().flatten().map(|check| Check { ..*check }).collect()
}

/// Returns the tables behind the rows about order: errors and remainders when a step is halved.
///
/// # Errors
/// A world did not advance.
pub fn tables() -> Result<String> {
    let mut text = String::new();
    let series = [
        (
            "error of overlap and closing speed after 8.192 ms of a damped contact [m]",
            collision::errors_in_contact()?,
        ),
        (
            "the same after 8.192 ms of an oblique contact with friction, sticking [m]",
            collision::errors_in_oblique_contact(&collision::Push::NONE)?,
        ),
        (
            "the same under a force and torque that grow from zero [m]",
            collision::errors_in_oblique_contact(&collision::Push::RAMP)?,
        ),
        (
            "error of velocities after a damped hit with friction, from apart to apart [m/s]",
            order::errors_of_hit()?,
        ),
        ("a growing push in a contact, in one step of 0.1 s and in ten [SI]", ramp::pieces_in_contact()?),
        (
            "error of a push that grows from zero, held over the communication step [m, rad]",
            ramp::errors_of_push(ramp::Between::Held)?,
        ),
        (
            "the same, growing during the communication step [m, rad]",
            ramp::errors_of_push(ramp::Between::Rates)?,
        ),
        ("remainder of the energy ledger, contacts lasting", ledger::remainders(ledger::Case::Lasting)?),
        (
            "remainder of the energy ledger, contacts beginning and ending",
            ledger::remainders(ledger::Case::Passing)?,
        ),
    ];
    for (title, rows) in series {
        text.push_str(&format!("\n{title}\n{:>12}  {:>11}  fell by\n", "step [s]", "found"));
        let mut last = None;
        for (dt, figure) in rows {
            let fall = last.map_or(String::new(), |last: f64| format!("{:7.2}", (last / figure).abs()));
            text.push_str(format!("{dt:>12.3e}  {figure:>11.3e}  {fall}").trim_end());
            text.push('\n');
            last = Some(figure);
        }
    }
    Ok(text)
}

/// \[m\] Largest distance between the positions of the same body in two worlds.
pub(crate) fn farthest_apart([one, other]: &[World; 2]) -> f64 {
    let poses = one.state().poses.iter().zip(&other.state().poses);
    largest(poses.map(|(a, b)| (a.position - b.position).norm()))
}

/// The largest of some differences; NaN if one is not a number.
pub(crate) fn largest(differences: impl IntoIterator<Item = f64>) -> f64 {
    differences.into_iter().fold(0.0, |worst, d| if d.is_nan() || d > worst { d } else { worst })
}
