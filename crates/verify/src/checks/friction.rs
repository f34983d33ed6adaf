//! The tangential spring and sliding friction.

use crate::checks::{Figure, Result, ensure, largest};
use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;

pub(crate) const FIGURES: &[Figure] = &[
    sticks,
    || Ok(slides()?.1),
    // 100 N remain, and relax.
    || Ok((slides()?.0 / (100.0 / (80.0 * 2.0) * (1.0 - (-2.0f64 * 2.0).exp())) - 1.0).abs()),
    rolls,
];

/// A disk pressed on the wall y = 0 by 500 N, so deep that it rests.
fn pressed(disk: PlacedBody, law: PairLaw) -> World {
    let rest = 0.2 - 500.0 / law.normal_stiffness;
    let mut world = world(&[disk.at(0.0, rest)], &[&[(-100.0, 0.0), (100.0, 0.0)]], law, 1e-5);
    world.drive[0].force = vec2(0.0, -500.0);
    world
}

/// A disk that does not turn, for its inertia.
fn block() -> PlacedBody {
    disk(80.0, 0.2).of_inertia(1e12).relaxing(2.0, 0.0)
}

fn sticks() -> Result<f64> {
    // μ |F_n| = 200 N. The load grows slowly, because a sudden one would overshoot the limit.
    let mut world = pressed(block(), BODIES);
    for step in 1..=400 {
        world.drive[0].force.x = 190.0 * f64::from(step.min(100)) / 100.0;
        world.advance(0.01)?;
    }
    ensure!(world.work().sliding == 0, "it sticks");
    Ok((world.state().poses[0].position.x / (190.0 / BODIES.tangential_stiffness) - 1.0).abs())
}

/// Pulled by 300 N: returns the speed at the end and the largest deviation of the force ratio from μ.
fn slides() -> Result<(f64, f64)> {
    let mut world = pressed(block(), BODIES);
    world.drive[0].force.x = 300.0;
    let mut worst: f64 = 0.0;
    for step in 0..200 {
        world.advance(0.01)?;
        if step > 10 {
            let contact = world.contacts().contacts[0];
            let ratio = contact.tangential_force.abs() / contact.normal_force.abs();
            worst = worst.max((ratio / BODIES.friction - 1.0).abs());
        }
    }
    Ok((world.state().twists[0].velocity.x, worst))
}

fn rolls() -> Result<f64> {
    let law = PairLaw { normal_damping: 2000.0, ..BODIES };
    let mut world = pressed(disk(80.0, 0.2).moving(0.9, 0.0), law);
    world.advance(1.0)?;
    let twist = world.state().twists[0];
    // It rolls: v = −ω R.
    Ok(largest([(twist.velocity.x / 0.6 - 1.0).abs(), (twist.angular_velocity * 0.2 / -0.6 - 1.0).abs()]))
}
