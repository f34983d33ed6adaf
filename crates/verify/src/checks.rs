//! Compares the mechanics with independent results: closed forms, conservation laws, symmetries, an independent
//! integrator. They form one table, and every row is measured when it is asked for.
//!
//! A [`Check`] measures one figure: the largest difference that it finds. It passes if the figure is within its limit.

mod across;
mod collision;
mod exposure;
mod friction;
mod golden;
mod ledger;
mod legs;
mod levels;
mod order;
mod passivity;
mod ramp;
pub(crate) mod reference;
pub(crate) mod scenarios;
mod stability;
mod symmetry;
mod two_disks;
mod walls;

pub use anyhow::Result;
use crowd_mechanics::engine::World;
use lemons_core::plane::{Motion, Pose, Twist};

/// The rows, in sections of the modules that measure them: name, what it is compared with, unit, limit. Then the titles
/// of the tables behind rows about order.
static TABLE: &str = include_str!("checks/table.txt");

/// A measurement of one figure. It fails if something cannot be run, or is not what it is made to be.
type Figure = fn() -> Result<f64>;

/// One row of the table.
pub struct Check {
    /// Name of what is checked.
    pub name: &'static str,
    /// Name of what it is compared with.
    pub against: &'static str,
    /// Unit of the figure; "" for a ratio.
    pub unit: &'static str,
    /// The largest figure that passes.
    pub limit: f64,
    /// Measures the figure.
    pub measure: Figure,
}

impl Check {
    /// Returns whether a figure passes.
    pub fn passes(&self, figure: f64) -> bool {
        figure <= self.limit
    }
}

/// Returns all rows, in the order of the table.
pub fn all() -> Vec<Check> {
    let measures = [
        collision::FIGURES,
        friction::FIGURES,
        order::FIGURES,
        walls::FIGURES,
        passivity::FIGURES,
        stability::FIGURES,
        exposure::FIGURES,
        golden::FIGURES,
        ramp::FIGURES,
        across::FIGURES,
        ledger::FIGURES,
        legs::FIGURES,
        levels::FIGURES,
        symmetry::FIGURES,
        scenarios::FIGURES,
        reference::FIGURES,
    ];
    let rows = rows().map(|row| row.split(" | ").collect::<Vec<_>>());
    let checks = rows.zip(measures.into_iter().flatten()).map(|(cells, &measure)| Check {
        name: cells[0],
        against: cells[1],
        unit: cells[2],
        limit: cells[3].parse().unwrap_or(f64::NAN),
        measure,
    });
    checks.collect()
}

fn rows() -> impl Iterator<Item = &'static str> {
    TABLE.lines().take_while(|line| *line != "[tables]").filter(|line| !line.starts_with('['))
}

/// Returns the tables behind the rows about order: errors and remainders when a step is halved.
///
/// # Errors
/// A world did not advance.
pub fn tables() -> Result<String> {
    let series: [fn() -> Result<Halved>; 7] = [
        collision::errors_in_oblique_contact,
        || order::errors(order::PARTED, order::BOTH),
        ramp::pieces_in_contact,
        || ramp::errors_of_push(0.0),
        || ramp::errors_of_push(ramp::GROWTH),
        || ledger::remainders(ledger::lasting),
        || ledger::remainders(ledger::passing),
    ];
    let titles = TABLE.lines().skip_while(|line| *line != "[tables]").skip(1);
    let mut text = String::new();
    for (title, rows) in titles.zip(series) {
        text.push_str(&format!("\n{title}\n{:>12}  {:>11}  fell by\n", "step [s]", "found"));
        let mut last = None;
        for (dt, figure) in rows()? {
            let fall = last.map_or(String::new(), |last: f64| format!("{:7.2}", (last / figure).abs()));
            text.push_str(format!("{dt:>12.3e}  {figure:>11.3e}  {fall}").trim_end());
            text.push('\n');
            last = Some(figure);
        }
    }
    Ok(text)
}

/// Returns an error if a case is not what it is made to be: its figure would say nothing.
macro_rules! ensure {
    ($so:expr, $($text:tt)*) => {
        anyhow::ensure!($so, "is not so: {}", format_args!($($text)*))
    };
}
pub(crate) use ensure;

/// \[m\] Largest distance between the positions of the same body in two worlds.
pub(crate) fn farthest_apart([one, other]: &[World; 2]) -> f64 {
    let poses = one.state().poses.iter().zip(&other.state().poses);
    largest(poses.map(|(a, b)| (a.position - b.position).norm()))
}

/// Largest difference of place, angle, velocity and angular velocity of the same body.
pub(crate) fn apart(one: &[Motion], other: &[Motion]) -> f64 {
    let both = one.iter().zip(other);
    largest(both.flat_map(|(a, b)| [apart_in_pose(&a.pose, &b.pose), apart_in_twist(&a.twist, &b.twist)]))
}

pub(crate) fn apart_in_pose(a: &Pose, b: &Pose) -> f64 {
    largest([(a.position - b.position).norm(), (a.orientation - b.orientation).abs()])
}

pub(crate) fn apart_in_twist(a: &Twist, b: &Twist) -> f64 {
    largest([(a.velocity - b.velocity).norm(), (a.angular_velocity - b.angular_velocity).abs()])
}

/// Steps \[s\] and figures, from a step on that is halved each time.
pub type Halved = Vec<(f64, f64)>;

pub(crate) fn halved(first: f64, count: i32, figure: impl Fn(f64) -> Result<f64>) -> Result<Halved> {
    let steps = (0..count).map(|halvings| first / f64::powi(2.0, halvings));
    steps.map(|step| Ok((step, figure(step)?))).collect()
}

/// Returns the amount by which the order at which figures fall is less than expected.
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
    /// Makes one of this stiffness, damping and mass.
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

#[cfg(test)]
mod tests {
    #[test]
    fn each_row_has_a_measure() {
        assert_eq!(super::rows().count(), super::all().len());
        assert!(super::all().iter().all(|check| check.limit.is_finite()));
    }
}
