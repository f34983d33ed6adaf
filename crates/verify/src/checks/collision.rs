//! Collisions, compared with conservation laws, the damped oscillator and another integrator.

use crate::checks::two_disks::TwoDisks;
use crate::checks::{Figure, Halved, Oscillator, Result, ensure, halved, largest, off_ratio};
use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;

pub(crate) const FIGURES: &[Figure] = &[
    velocities,
    restitution,
    || Ok(off_ratio(&errors_in_oblique_contact()?, 4.0)),
    || Ok(glancing()?.0),
    || Ok(glancing()?.1),
];

/// The masses \[kg\] and radii \[m\] of two disks, and their reduced mass.
const MASSES: [f64; 2] = [100.0, 50.0];
const RADII: [f64; 2] = [0.25, 0.2];
const REDUCED: f64 = 100.0 * 50.0 / 150.0;

/// The first at 1 m/s meets the second at rest. Returns their velocities \[m/s\] after 0.1 s.
fn head_on(law: PairLaw, mechanical_step: f64) -> Result<[f64; 2]> {
    let [first, second] = [0, 1].map(|i| disk(MASSES[i], RADII[i]));
    let mut world = world(&[first.moving(1.0, 0.0), second.at(0.46, 0.0)], &[], law, mechanical_step);
    world.advance(0.1)?;
    Ok([0, 1].map(|i| world.state().twists[i].velocity.x))
}

fn velocities() -> Result<f64> {
    let [first, second] = head_on(ELASTIC, 1e-5)?;
    Ok(largest([(first - 1.0 / 3.0).abs(), (second - 4.0 / 3.0).abs()]))
}

fn restitution() -> Result<f64> {
    // Kelvin–Voigt, not clamped: the contact ends when the oscillator returns to h = 0.
    let law = PairLaw { normal_damping: 1500.0, ..ELASTIC };
    let [first, second] = head_on(law, 1e-6)?;
    let expected = Oscillator::new(law.normal_stiffness, law.normal_damping, REDUCED).restitution();
    Ok((second - first - expected).abs())
}

/// Returns errors \[m\] of relative position, and of velocity and rim speeds divided by the angular frequency, after
/// 8.192 ms of an oblique sticking contact, for the step 1.28e-4 s and five halvings. Drives grow from zero to the size
/// of the contact's forces.
///
/// # Errors
/// The world did not advance, or the contact did not stick.
pub(crate) fn errors_in_oblique_contact() -> Result<Halved> {
    let law = PairLaw { friction: 20.0, normal_damping: 900.0, ..BODIES };
    let drive_rates =
        [Wrench { force: vec2(4e5, 2e5), torque: 2e4 }, Wrench { force: vec2(-3e5, 1e5), torque: -1e4 }];
    let rate = 4.5;
    let bodies = [0, 1].map(|i| disk(MASSES[i], RADII[i]).relaxing(rate, rate));
    let inertias = bodies.each_ref().map(|placed| placed.body.inertia);
    let [first, second] = bodies;
    // Just inside the contact.
    let people = [first.at(-0.4499, 0.0).moving(1.0, 0.3), second];
    let disks = TwoDisks { masses: MASSES, inertias, radii: RADII, law, drive_rates, relaxation_rate: rate };
    // Steps of 1 µs: exact to 1e-14 here.
    let exact = disks.after([-0.4499, 0.0, 1.0, 0.3, 0.0, 0.0, 0.0], 8192, 1e-6);
    let pulsation = (law.normal_stiffness / REDUCED).sqrt();
    halved(1.28e-4, 6, |dt| {
        let mut world = world(&people, &[], law, dt);
        world.drive_rate = drive_rates.to_vec();
        world.advance(0.008_192)?;
        ensure!(world.work().sliding == 0, "it sticks");
        let (poses, twists) = (&world.state().poses, &world.state().twists);
        let place = poses[0].position - poses[1].position - vec2(exact[0], exact[1]);
        let velocity = twists[0].velocity - twists[1].velocity - vec2(exact[2], exact[3]);
        let rims = [0, 1].map(|i| (twists[i].angular_velocity - exact[4 + i]) * RADII[i]);
        let speeds = (velocity.norm_squared() + rims[0] * rims[0] + rims[1] * rims[1]).sqrt();
        Ok(place.norm().hypot(speeds / pulsation))
    })
}

/// Returns the largest relative drifts of momentum and angular momentum.
fn glancing() -> Result<(f64, f64)> {
    let first = pedestrian(89.0, 0.0).moving(1.5, 0.1).spinning(0.7);
    let second = pedestrian(60.0, 0.0).at(0.4, 0.22).turned(1.1).moving(-0.5, 0.0);
    let mut world = world(&[first, second], &[], BODIES, 1e-5);
    let (p, l) = (momentum(&world), angular_momentum(&world));
    let mut worst: (f64, f64) = (0.0, 0.0);
    for _ in 0..50 {
        world.advance(0.01)?;
        worst.0 = worst.0.max((momentum(&world) - p).norm() / p.norm());
        worst.1 = worst.1.max((angular_momentum(&world) - l).abs() / l.abs());
    }
    ensure!(world.work().contacts > 0 && world.contacts().agent_contacts == 0, "they met and parted");
    Ok(worst)
}
