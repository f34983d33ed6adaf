//! The tangential spring and sliding friction.

use crate::checks::error::{Result, ensure};
use crate::checks::scenes::*;
use crate::checks::{Check, largest};
use crowd_mechanics::engine::*;

pub(crate) const CHECKS: &[Check] = &[
    Check::new("sticking: displacement of a disk dragged below μ", "F/k_t", "", 1e-4, sticks),
    Check::new("sliding: tangential force", "μ |F_n|", "", 1e-6, sliding_force),
    Check::new("sliding: speed after 2 s", "relaxation under F − μ |F_n|", "", 2e-3, sliding_speed),
    Check::new("a disk thrown along a wall: final speed", "2/3 of the first", "", 5e-3, rolls),
];

/// A disk pressed on the wall y = 0 by 500 N; it does not turn (huge inertia).
fn pressed() -> World {
    let mut body = disk(80.0, 0.2);
    body.inertia = 1e12;
    body.translation_rate = 2.0;
    let rest = 0.2 - 500.0 / BODIES.normal_stiffness;
    let walls = [wall(&[(-100.0, 0.0), (100.0, 0.0)])];
    let mut world = world(&[body], &walls, BODIES, &[(at(0.0, rest), moving(0.0, 0.0))], 1e-5);
    world.drive[0].force = vec2(0.0, -500.0);
    world
}

fn sticks() -> Result<f64> {
    // μ |F_n| = 200 N. The load grows slowly, because a sudden one would overshoot the limit.
    let mut world = pressed();
    for step in 1..=400 {
        world.drive[0].force.x = 190.0 * f64::from(step.min(100)) / 100.0;
        world.advance(0.01)?;
    }
    ensure!(world.work().sliding == 0, "it slid");
    Ok((world.state().poses[0].position.x / (190.0 / BODIES.tangential_stiffness) - 1.0).abs())
}

/// Pulled by 300 N: returns the speed at the end and the largest deviation of the force ratio from μ.
fn slides() -> Result<(f64, f64)> {
    let mut world = pressed();
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

fn sliding_force() -> Result<f64> {
    Ok(slides()?.1)
}

fn sliding_speed() -> Result<f64> {
    let expected = 100.0 / (80.0 * 2.0) * (1.0 - (-2.0f64 * 2.0).exp());
    Ok((slides()?.0 / expected - 1.0).abs())
}

fn rolls() -> Result<f64> {
    let law = PairLaw { normal_damping: 2000.0, ..BODIES };
    let rest = 0.2 - 500.0 / law.normal_stiffness;
    let walls = [wall(&[(-1.0, 0.0), (100.0, 0.0)])];
    let mut world = world(&[disk(80.0, 0.2)], &walls, law, &[(at(0.0, rest), moving(0.9, 0.0))], 1e-5);
    world.drive[0].force = vec2(0.0, -500.0);
    world.advance(1.0)?;
    let twist = world.state().twists[0];
    // It rolls: v = −ω R.
    Ok(largest([(twist.velocity.x / 0.6 - 1.0).abs(), (twist.angular_velocity * 0.2 / -0.6 - 1.0).abs()]))
}
