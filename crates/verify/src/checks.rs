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

use crowd_mechanics::engine::{Pose, Twist, World};
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

/// Largest difference of place, angle, velocity and angular velocity of a body.
pub(crate) fn apart(a: &(Pose, Twist), b: &(Pose, Twist)) -> f64 {
    largest([apart_in_pose(&a.0, &b.0), apart_in_twist(&a.1, &b.1)])
}

pub(crate) fn apart_in_pose(a: &Pose, b: &Pose) -> f64 {
    largest([(a.position - b.position).norm(), (a.orientation - b.orientation).abs()])
}

pub(crate) fn apart_in_twist(a: &Twist, b: &Twist) -> f64 {
    largest([(a.velocity - b.velocity).norm(), (a.angular_velocity - b.angular_velocity).abs()])
}

/// Steps \[s\] and figures, from a step on that is halved each time.
type Halved = Vec<(f64, f64)>;

pub(crate) fn halved(first: f64, count: i32, figure: impl Fn(f64) -> Result<f64>) -> Result<Halved> {
    let steps = (0..count).map(|halvings| first / f64::powi(2.0, halvings));
    steps.map(|step| Ok((step, figure(step)?))).collect()
}

/// By how much the order at which figures fall is less than expected.
pub(crate) fn shortfall(figures: &Halved, expected: f64) -> f64 {
    let halvings = figures.len() - 1;
    let fall = (figures[0].1 / figures[halvings].1).abs();
    (expected - fall.log2() / halvings as f64).max(0.0)
}

/// The largest difference of the ratios of figures from an expected one.
pub(crate) fn off_ratio(figures: &Halved, expected: f64) -> f64 {
    largest(figures.windows(2).map(|pair| (pair[0].1 / pair[1].1 - expected).abs()))
}

/// A damped oscillator: x'' + 2 decay x' + (k/m) x = 0.
pub(crate) struct Oscillator {
    /// \[1/s\]
    pub decay: f64,
    /// \[1/s\] Angular frequency.
    pub pulsation: f64,
}

impl Oscillator {
    /// With these stiffness, damping and mass.
    pub fn new(stiffness: f64, damping: f64, mass: f64) -> Oscillator {
        let decay = damping / (2.0 * mass);
        Oscillator { decay, pulsation: (stiffness / mass - decay * decay).sqrt() }
    }

    /// Speed at a time \[s\], from 0 on with another speed.
    pub fn speed(&self, first: f64, time: f64) -> f64 {
        let (sin, cos) = (self.pulsation * time).sin_cos();
        first * (-self.decay * time).exp() * (cos - self.decay / self.pulsation * sin)
    }

    /// Speed when it comes back to 0, divided by that at first.
    pub fn restitution(&self) -> f64 {
        (-std::f64::consts::PI * self.decay / self.pulsation).exp()
    }
}

/// The largest of some differences; NaN if one is not a number.
pub(crate) fn largest(differences: impl IntoIterator<Item = f64>) -> f64 {
    differences.into_iter().fold(0.0, |worst, d| if d.is_nan() || d > worst { d } else { worst })
}
