//! Collisions, compared with Newton's laws and the damped oscillator.

use crate::checks::scenes::*;
use crate::checks::two_disks::TwoDisks;
use crate::checks::{Figure, Halved, Oscillator, Result, ensure, halved, largest, off_ratio};
use crowd_mechanics::engine::*;
use std::f64::consts::PI;

pub(crate) const FIGURES: &[Figure] = &[
    velocities,
    momentum_of_head_on,
    energy_of_head_on,
    duration,
    restitution,
    || Ok(off_ratio(&errors_in_contact()?, 4.0)),
    || Ok(off_ratio(&errors_in_oblique_contact(NO_PUSH)?, 4.0)),
    || Ok(glancing()?.0),
    || Ok(glancing()?.1),
];

/// The masses \[kg\] and radii \[m\] of two disks, and their reduced mass.
const MASSES: [f64; 2] = [100.0, 50.0];
const RADII: [f64; 2] = [0.25, 0.2];
const REDUCED: f64 = 100.0 * 50.0 / 150.0;

/// The first at 1 m/s meets the second at rest.
fn head_on(law: PairLaw, gap: f64, mechanical_step: f64) -> World {
    let [first, second] = [0, 1].map(|i| disk(MASSES[i], RADII[i]));
    world(&[first.moving(1.0, 0.0), second.at(0.45 + gap, 0.0)], &[], law, mechanical_step)
}

fn velocities() -> Result<f64> {
    let mut world = head_on(ELASTIC, 0.01, 1e-5);
    world.advance(0.1)?;
    let twists = &world.state().twists;
    Ok(largest([(twists[0].velocity.x - 1.0 / 3.0).abs(), (twists[1].velocity.x - 4.0 / 3.0).abs()]))
}

fn momentum_of_head_on() -> Result<f64> {
    let mut world = head_on(ELASTIC, 0.01, 1e-5);
    let mut worst: f64 = 0.0;
    for _ in 0..1000 {
        let before = momentum(&world);
        world.advance(1e-4)?;
        worst = worst.max((momentum(&world) - before).norm() / before.norm());
    }
    Ok(worst)
}

fn energy_of_head_on() -> Result<f64> {
    let mut world = head_on(ELASTIC, 0.01, 1e-5);
    let before = kinetic_energy(&world);
    world.advance(0.1)?;
    Ok((kinetic_energy(&world) / before - 1.0).abs())
}

fn duration() -> Result<f64> {
    let dt = 1e-5;
    let mut world = head_on(ELASTIC, 0.01, dt);
    let mut touching = 0;
    for _ in 0..10_000 {
        world.advance(dt)?;
        touching += world.contacts().agent_contacts;
    }
    let expected = PI / (ELASTIC.normal_stiffness / REDUCED).sqrt();
    Ok((f64::from(touching) * dt / expected - 1.0).abs())
}

fn restitution() -> Result<f64> {
    // Kelvin–Voigt, not clamped: the contact ends when the oscillator returns to h = 0.
    let law = PairLaw { normal_damping: 1500.0, ..ELASTIC };
    let mut world = head_on(law, 0.01, 1e-6);
    world.advance(0.1)?;
    let twists = &world.state().twists;
    let parting = twists[1].velocity.x - twists[0].velocity.x;
    let expected = Oscillator::new(law.normal_stiffness, law.normal_damping, REDUCED).restitution();
    Ok((parting - expected).abs())
}

/// Returns errors of overlap and closing speed \[m\] after 8.192 ms of a lasting damped contact, for the step 1.28e-4 s
/// and five halvings.
pub fn errors_in_contact() -> Result<Halved> {
    let law = PairLaw { normal_damping: 900.0, ..ELASTIC };
    let Oscillator { decay, pulsation } = Oscillator::new(law.normal_stiffness, law.normal_damping, REDUCED);
    let (depth, speed, time) = (1e-4, 1.0, 0.008_192);
    // h'' + 2 decay h' + (k/m*) h = 0, h(0) = depth, h'(0) = speed
    let swing = (speed + decay * depth) / pulsation;
    let (sin, cos) = (pulsation * time).sin_cos();
    let decayed = (-decay * time).exp();
    let exact = decayed * (depth * cos + swing * sin);
    let exact_speed =
        decayed * ((pulsation * swing - decay * depth) * cos - (pulsation * depth + decay * swing) * sin);
    halved(1.28e-4, 6, |dt| {
        let mut world = head_on(law, -depth, dt);
        world.advance(time)?;
        let twists = &world.state().twists;
        let closing = twists[0].velocity.x - twists[1].velocity.x;
        let error_of_depth = world.contacts().largest_overlap - exact;
        Ok(error_of_depth.hypot((closing - exact_speed) / pulsation))
    })
}

/// Forces on the two disks besides the contact: rates at which drives grow from zero \[N/s\], \[N.m/s\], and the
/// relaxation rate \[1/s\].
type Push = ([Wrench; 2], f64);

/// No forces.
pub(crate) const NO_PUSH: Push = ([Wrench { force: Vec2::ZERO, torque: 0.0 }; 2], 0.0);
/// Drives that grow to the size of the contact's forces, and relaxation.
pub(crate) const RAMP: Push =
    ([Wrench { force: vec2(4e5, 2e5), torque: 2e4 }, Wrench { force: vec2(-3e5, 1e5), torque: -1e4 }], 4.5);

/// Returns errors \[m\] of relative position, and of velocity and rim speeds divided by the angular frequency, after
/// 8.192 ms of an oblique sticking contact with forces, for the step 1.28e-4 s and five halvings.
///
/// # Errors
/// The world did not advance, or the contact did not stick.
pub(crate) fn errors_in_oblique_contact((drive_rates, rate): Push) -> Result<Halved> {
    let law = PairLaw { friction: 20.0, normal_damping: 900.0, ..BODIES };
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
