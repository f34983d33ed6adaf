//! Order of the step through the beginning and the end of a contact, compared with closed forms.
//!
//! A disk that does not turn hits a wall obliquely and slides along it. Its contact begins anywhere within a step. The
//! damping force is there at once when it begins, and still there when it ends.

use crate::checks::error::{Result, ensure};
use crate::checks::scenes::*;
use crate::checks::{Check, Oscillator, halved, largest, shortfall};
use crowd_mechanics::engine::*;
use std::f64::consts::PI;

pub(crate) const CHECKS: &[Check] = &[
    Check::new(
        "a damped contact begins within a step: order short of 2",
        "damped oscillator",
        "",
        0.1,
        || short_of_two(Moment::Lasting, DAMPED),
    ),
    Check::new("the same until it has ended", "damped oscillator", "", 0.1, || {
        short_of_two(Moment::Parted, DAMPED)
    }),
    Check::new("with friction, undamped: order short of 2", "μ × normal impulse", "", 0.1, || {
        short_of_two(Moment::Parted, ROUGH)
    }),
    Check::new("with both, begun within a step: order short of 2", "μ × normal impulse", "", 0.1, || {
        short_of_two(Moment::Lasting, BOTH)
    }),
    Check::new("the same until it has ended", "μ × normal impulse", "", 0.1, || {
        short_of_two(Moment::Parted, BOTH)
    }),
    Check::new(
        "the same: largest error of a velocity at dt = 1e-5 s",
        "μ × normal impulse",
        "m/s",
        1e-6,
        || error(Moment::Parted, BOTH, 1e-5),
    ),
    Check::new("the same, sticking: order short of 2", "damped oscillators", "", 0.1, || {
        short_of_two(Moment::Lasting, STICKING)
    }),
    Check::new("a disk runs round inside a polygon: order short of 2", "steps of 1 µs", "", 0.3, inside),
];

/// Damping, and friction so weak that it slides all the time.
const BOTH: PairLaw = PairLaw {
    normal_stiffness: 2.4e6,
    tangential_stiffness: 1.7e6,
    normal_damping: 1230.0,
    tangential_damping: 1230.0,
    friction: 0.1,
};
/// Friction so strong that it never slides.
const STICKING: PairLaw = PairLaw { friction: 1e6, ..BOTH };
const DAMPED: PairLaw = PairLaw { friction: 0.0, ..BOTH };
const ROUGH: PairLaw = PairLaw { normal_damping: 0.0, tangential_damping: 0.0, ..BOTH };

const MASS: f64 = 80.0;
const RADIUS: f64 = 0.2;
/// \[m/s\] Along the wall and towards it.
const START: [f64; 2] = [1.0, 0.6];
/// \[s\] When the contact begins, at the earliest.
const BEGINS: f64 = 1e-3;
/// Number of times within a step at which it begins.
const TIMES: u32 = 16;

/// When velocities are compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Moment {
    /// While the contact lasts.
    Lasting,
    /// When it has ended.
    Parted,
}

impl Moment {
    /// \[s\]
    fn time(self) -> f64 {
        match self {
            Moment::Lasting => 0.004,
            Moment::Parted => 0.032,
        }
    }
}

/// Velocities \[m/s\] along the wall and towards it when the contact has lasted a time \[s\] and sticks.
fn stuck(law: &PairLaw, lasted: f64) -> [f64; 2] {
    let [along, towards] = START;
    let tangential = Oscillator::new(law.tangential_stiffness, law.tangential_damping, MASS);
    let normal = Oscillator::new(law.normal_stiffness, law.normal_damping, MASS);
    [tangential.speed(along, lasted), normal.speed(towards, lasted)]
}

/// The same when it slides, or has ended.
fn slid(law: &PairLaw, lasted: f64) -> [f64; 2] {
    let normal = Oscillator::new(law.normal_stiffness, law.normal_damping, MASS);
    let Oscillator { decay, pulsation } = normal;
    let [along, towards] = START;
    let at = |time: f64| normal.speed(towards, time);
    // The normal force changes its sign where k h + γ h' = 0.
    let slope = law.normal_damping * pulsation / (law.normal_stiffness - law.normal_damping * decay);
    let (pulls, ends) = ((PI - slope.atan()) / pulsation, PI / pulsation);
    let now = lasted.min(ends);
    // Impulse of |F_n| per mass.
    let squeezed = if now < pulls { towards - at(now) } else { towards - 2.0 * at(pulls) + at(now) };
    [along - law.friction * squeezed, at(now)]
}

/// Returns the largest error of a velocity \[m/s\] over contacts that begin at different times within a step.
///
/// # Errors
/// The world did not advance, or the disk stuck where it should slide, or the other way round.
pub fn error(moment: Moment, law: PairLaw, mechanical_step: f64) -> Result<f64> {
    let mut errors = Vec::new();
    for k in 0..TIMES {
        let begins = BEGINS + mechanical_step * (f64::from(k) + 0.5) / f64::from(TIMES);
        let mut body = disk(MASS, RADIUS);
        body.inertia = 1e12;
        let [along, towards] = START;
        let motion = (at(0.0, RADIUS + towards * begins), moving(along, -towards));
        let walls = [wall(&[(-10.0, 0.0), (10.0, 0.0)])];
        let mut world = world(&[body], &walls, law, &[motion], mechanical_step);
        world.shortlisting = Shortlisting::Off;
        world.advance(moment.time())?;
        let (sliding, contacts) = (world.work().sliding, world.work().contacts);
        let exact = if law == STICKING {
            ensure!(sliding == 0, "it slid");
            stuck(&law, moment.time() - begins)
        } else {
            ensure!(sliding + 2 >= contacts, "it stuck");
            slid(&law, moment.time() - begins)
        };
        let velocity = world.state().twists[0].velocity;
        errors.extend([velocity.x - exact[0], -velocity.y - exact[1]].map(f64::abs));
    }
    Ok(largest(errors))
}

/// Returns errors \[m/s\] for the step 8e-5 s and three halvings.
///
/// # Errors
/// Those of [`error`].
pub fn errors(moment: Moment, law: PairLaw) -> Result<Vec<(f64, f64)>> {
    halved(8e-5, 4, |dt| error(moment, law, dt))
}

/// The same with damping and friction, until the contact has ended.
///
/// # Errors
/// Those of [`error`].
pub fn errors_of_hit() -> Result<Vec<(f64, f64)>> {
    errors(Moment::Parted, BOTH)
}

fn short_of_two(moment: Moment, law: PairLaw) -> Result<f64> {
    Ok(shortfall(&errors(moment, law)?, 2.0))
}

/// A disk is pressed outwards while it runs along the inner side of a polygon. At each corner the contact goes on, but
/// its normal turns at once.
fn inside() -> Result<f64> {
    let sides = 36;
    let corner = |k: u32| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(k) / f64::from(sides));
        (cos, sin)
    };
    let corners: Vec<(f64, f64)> = (0..=sides).map(|k| corner(k % sides)).collect();
    let end = |mechanical_step: f64| -> Result<Vec2> {
        let motion = (at(0.0, -0.7955), moving(3.0, 0.0));
        let mut world = world(&[disk(MASS, RADIUS)], &[wall(&corners)], BOTH, &[motion], mechanical_step);
        world.advance(0.25)?;
        Ok(world.state().poses[0].position)
    };
    let exact = end(1e-6)?;
    let error = |step: f64| -> Result<f64> { Ok((end(step)? - exact).norm()) };
    // The corners are met anywhere within a step: means over several steps.
    let mean = |step: f64| -> Result<f64> {
        let errors =
            (0..8).map(|k| error(step * (1.0 - 0.02 * f64::from(k)))).collect::<Result<Vec<f64>>>()?;
        Ok(errors.iter().sum::<f64>() / 8.0)
    };
    let fall = mean(8e-5)? / mean(1e-5)?;
    Ok((2.0 - fall.log2() / 3.0).max(0.0))
}
