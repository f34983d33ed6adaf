//! Energy balance: all supplied energy is stored, or lost to floor and damping.

use crate::checks::scenes::*;
use crate::checks::{Figure, Halved, Result, ensure, halved, shortfall};
use crowd_mechanics::engine::*;

pub(crate) const FIGURES: &[Figure] =
    &[|| Ok(remainders()?[4].1.abs()), || Ok(shortfall(&remainders()?, 2.0))];

/// Powers \[W\] at an instant: of the drive, F_p·v + M_p ω; lost to the floor, λ m v² + λ I ω², and in the dashpots,
/// γ_n v_n² + γ_t v_t², while all contacts stick.
fn powers(world: &World) -> [f64; 2] {
    let scene = world.scene();
    let [mut drive, mut lost] = [0.0; 2];
    for ((body, twist), wrench) in scene.bodies.iter().zip(&world.state().twists).zip(&world.drive) {
        let (v, w) = (twist.velocity, twist.angular_velocity);
        drive += wrench.force.dot(v) + wrench.torque * w;
        lost +=
            body.translation_rate * body.mass * v.norm_squared() + body.rotation_rate * body.inertia * w * w;
    }
    for contact in &world.contacts().contacts {
        let law = law_of(scene, contact);
        lost += law.normal_damping * contact.normal_speed.powi(2)
            + law.tangential_damping * contact.slip_speed.powi(2);
    }
    [drive, lost]
}

/// Computes the unexplained energy of two disks pressed together over 0.25 s, as a share of what was converted. Every
/// energy is from its own formula, added up once per mechanical step.
fn unexplained(mechanical_step: f64) -> Result<f64> {
    let mut world = pressed_together(mechanical_step);
    world.drive[0].torque = 10.0;
    world.drive[1] = Wrench { force: vec2(-2000.0, 50.0), torque: 5.0 };
    let at_first = energy(&world);
    let (mut work, mut lost, mut turnover) = (0.0, 0.0, kinetic_energy(&world));
    let mut before = powers(&world);
    for _ in 0..(0.25 / mechanical_step).round() as u32 {
        world.advance(mechanical_step)?;
        let after = powers(&world);
        work += 0.5 * mechanical_step * (before[0] + after[0]);
        lost += 0.5 * mechanical_step * (before[1] + after[1]);
        turnover += 0.5 * mechanical_step * (before[0].abs() + before[1]);
        before = after;
    }
    ensure!(world.work().sliding == 0 && world.contacts().agent_contacts == 1, "they stick");
    Ok((energy(&world) - at_first + lost - work) / turnover)
}

/// Returns mechanical steps \[s\] and remainders, for four halvings.
///
/// # Errors
/// The world did not advance.
pub(crate) fn remainders() -> Result<Halved> {
    halved(4e-5, 5, unexplained)
}
