//! Order of the step through the beginning and the end of a contact, compared with closed forms.
//!
//! A disk that does not turn hits a wall obliquely and slides along it. Its contact begins anywhere within a step. The
//! damping force is there at once when it begins, and still there when it ends.

use crate::checks::{Figure, Halved, Oscillator, Result, ensure, halved, largest, shortfall};
use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;
use std::f64::consts::PI;

pub(crate) const FIGURES: &[Figure] = &[
    || short_of_two(LASTING, BOTH),
    || short_of_two(PARTED, BOTH),
    || error(PARTED, BOTH, 1e-5),
    || short_of_two(PARTED, ROUGH),
    || short_of_two(LASTING, STICKING),
    inside,
];

/// Damping, and friction so weak that it slides all the time.
pub(crate) const BOTH: PairLaw = PairLaw {
    normal_stiffness: 2.4e6,
    tangential_stiffness: 1.7e6,
    normal_damping: 1230.0,
    tangential_damping: 1230.0,
    friction: 0.1,
};
/// Friction so strong that it never slides.
const STICKING: PairLaw = PairLaw { friction: 1e6, ..BOTH };
const ROUGH: PairLaw = PairLaw { normal_damping: 0.0, tangential_damping: 0.0, ..BOTH };

const MASS: f64 = 80.0;
const RADIUS: f64 = 0.2;
/// \[m/s\] Along the wall and towards it.
const START: [f64; 2] = [1.0, 0.6];
/// \[s\] When the contact begins, at the earliest.
const BEGINS: f64 = 1e-3;
/// Number of times within a step at which it begins.
const TIMES: u32 = 16;

/// \[s\] When velocities are compared: while the contact lasts, and when it has ended.
const LASTING: f64 = 0.004;
pub(crate) const PARTED: f64 = 0.032;

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

/// Returns the largest error of a velocity \[m/s\] at a time over contacts that begin at different times within a step.
///
/// # Errors
/// The world did not advance, or the disk stuck where it should slide, or the other way round.
fn error(time: f64, law: PairLaw, mechanical_step: f64) -> Result<f64> {
    let mut errors = Vec::new();
    for k in 0..TIMES {
        let begins = BEGINS + mechanical_step * (f64::from(k) + 0.5) / f64::from(TIMES);
        let [along, towards] = START;
        let body =
            disk(MASS, RADIUS).of_inertia(1e12).at(0.0, RADIUS + towards * begins).moving(along, -towards);
        let mut world = world(&[body], &[&[(-10.0, 0.0), (10.0, 0.0)]], law, mechanical_step);
        world.shortlisting = Shortlisting::Off;
        world.advance(time)?;
        let (sliding, contacts) = (world.work().sliding, world.work().contacts);
        let exact = if law == STICKING {
            ensure!(sliding == 0, "it sticks");
            stuck(&law, time - begins)
        } else {
            ensure!(sliding + 2 >= contacts, "it slides");
            slid(&law, time - begins)
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
pub(crate) fn errors(time: f64, law: PairLaw) -> Result<Halved> {
    halved(8e-5, 4, |dt| error(time, law, dt))
}

fn short_of_two(time: f64, law: PairLaw) -> Result<f64> {
    Ok(shortfall(&errors(time, law)?, 2.0))
}

/// A disk is pressed outwards while it runs along the inner side of a polygon. At each corner the contact goes on, but
/// its normal turns at once.
fn inside() -> Result<f64> {
    let end = |mechanical_step: f64| -> Result<Vec2> {
        let runner = disk(MASS, RADIUS).at(0.0, -0.7955).moving(3.0, 0.0);
        let mut world = world(&[runner], &[&polygon(36)], BOTH, mechanical_step);
        world.advance(0.25)?;
        Ok(world.state().poses[0].position)
    };
    let exact = end(1e-6)?;
    // The corners are met anywhere within a step: means over several steps.
    let mean = |step: f64| -> Result<f64> {
        let errors = (0..8).map(|k| Ok((end(step * (1.0 - 0.02 * f64::from(k)))? - exact).norm()));
        Ok(errors.sum::<Result<f64>>()? / 8.0)
    };
    let fall = mean(8e-5)? / mean(1e-5)?;
    Ok((2.0 - fall.log2() / 3.0).max(0.0))
}
