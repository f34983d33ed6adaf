//! Collisions, compared with Newton's laws and the damped oscillator.

use crate::checks::error::{Result, ensure};
use crate::checks::scenes::*;
use crate::checks::{Check, Oscillator, halved, largest, off_ratio};
use crowd_mechanics::engine::*;
use std::f64::consts::PI;

pub(crate) const CHECKS: &[Check] = &[
    Check::new("head-on collision, 100 kg on 50 kg: velocities", "1/3 and 4/3 m/s", "m/s", 1e-6, velocities),
    Check::new("the same: momentum, per step", "conservation", "", 1e-12, momentum_of_head_on),
    Check::new("the same: energy", "conservation", "", 1e-6, energy_of_head_on),
    Check::new("duration of a contact", "π √(m*/k_n)", "", 1e-3, duration),
    Check::new("restitution of a damped collision", "damped oscillator", "", 1e-4, restitution),
    Check::new("order of the step in a contact: |ratio of errors − 4|", "damped oscillator", "", 0.1, order),
    Check::new(
        "the same in an oblique contact that sticks",
        "Runge–Kutta, fourth order",
        "",
        0.15,
        oblique_order,
    ),
    Check::new("glancing, rotating pedestrians: momentum", "conservation", "", 1e-12, glancing_momentum),
    Check::new("the same: angular momentum", "conservation", "", 1e-9, glancing_angular_momentum),
];

/// The reduced mass of [`head_on`].
const REDUCED: f64 = 100.0 * 50.0 / 150.0;

/// A body of 100 kg at 1 m/s meets one of 50 kg at rest.
fn head_on(law: PairLaw, gap: f64, mechanical_step: f64) -> World {
    world(
        &[disk(100.0, 0.25), disk(50.0, 0.2)],
        &[],
        law,
        &[(at(0.0, 0.0), moving(1.0, 0.0)), (at(0.45 + gap, 0.0), moving(0.0, 0.0))],
        mechanical_step,
    )
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
pub fn errors_in_contact() -> Result<Vec<(f64, f64)>> {
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

fn order() -> Result<f64> {
    Ok(off_ratio(&errors_in_contact()?, 4.0))
}

/// Two disks that meet obliquely and stick: radii, law and initial values.
const OBLIQUE_RADII: [f64; 2] = [0.25, 0.2];
const OBLIQUE_MASSES: [f64; 2] = [100.0, 50.0];
const OBLIQUE_LAW: PairLaw = PairLaw { friction: 20.0, normal_damping: 900.0, ..BODIES };
/// The first relative to the second: position \[m\], just inside the contact; velocity \[m/s\].
const OBLIQUE_START: [f64; 4] = [-0.4499, 0.0, 1.0, 0.3];

/// Forces on the two disks besides the contact.
#[derive(Debug, Clone, Copy)]
pub struct Push {
    /// \[N/s\], \[N.m/s\] Rates at which the drives grow from zero.
    drive_rates: [Wrench; 2],
    /// \[1/s\] Relaxation rate of velocity and angular velocity.
    relaxation_rate: f64,
}

impl Push {
    /// No forces.
    pub const NONE: Push =
        Push { drive_rates: [Wrench { force: Vec2::ZERO, torque: 0.0 }; 2], relaxation_rate: FREE };
    /// Drives that grow to the size of the contact's forces, and relaxation.
    pub const RAMP: Push = Push {
        drive_rates: [
            Wrench { force: vec2(4e5, 2e5), torque: 2e4 },
            Wrench { force: vec2(-3e5, 1e5), torque: -1e4 },
        ],
        relaxation_rate: 4.5,
    };
}

/// Rates of change, at a time \[s\], of relative position and velocity, both angular velocities and the spring of the
/// sticking contact.
fn oblique_rates(time: f64, [rx, ry, vx, vy, w1, w2, s]: [f64; 7], push: &Push) -> [f64; 7] {
    let inertia = [0, 1].map(|i| 0.5 * OBLIQUE_MASSES[i] * OBLIQUE_RADII[i].powi(2));
    let distance = rx.hypot(ry);
    let depth = OBLIQUE_RADII[0] + OBLIQUE_RADII[1] - distance;
    let (nx, ny) = (rx / distance, ry / distance);
    let (tx, ty) = (-ny, nx);
    let arms = OBLIQUE_RADII.map(|radius| radius - 0.5 * depth);
    let slip = vx * tx + vy * ty - w1 * arms[0] - w2 * arms[1];
    let law = OBLIQUE_LAW;
    let normal = law.normal_stiffness * depth - law.normal_damping * (vx * nx + vy * ny);
    let tangential = -law.tangential_stiffness * s - law.tangential_damping * slip;
    let lightness = 1.0 / OBLIQUE_MASSES[0] + 1.0 / OBLIQUE_MASSES[1];
    let (fx, fy) = (normal * nx + tangential * tx, normal * ny + tangential * ty);
    let driven = [0, 1].map(|i| push.drive_rates[i].force * (time / OBLIQUE_MASSES[i]));
    let ax = fx * lightness + driven[0].x - driven[1].x - push.relaxation_rate * vx;
    let ay = fy * lightness + driven[0].y - driven[1].y - push.relaxation_rate * vy;
    let spin = [(0, w1), (1, w2)].map(|(i, w)| {
        (push.drive_rates[i].torque * time - arms[i] * tangential) / inertia[i] - push.relaxation_rate * w
    });
    [vx, vy, ax, ay, spin[0], spin[1], slip]
}

/// Returns errors \[m\] of relative position, and of velocity and rim speeds divided by the angular frequency, after
/// 8.192 ms of an oblique sticking contact with forces, for the step 1.28e-4 s and five halvings.
///
/// # Errors
/// The world did not advance, or the contact did not stick.
pub fn errors_in_oblique_contact(push: &Push) -> Result<Vec<(f64, f64)>> {
    let time = 0.008_192;
    let [x, y, vx, vy] = OBLIQUE_START;
    // Runge–Kutta with steps of 1 µs: exact to 1e-14 here.
    let mut exact = [x, y, vx, vy, 0.0, 0.0, 0.0];
    let h = 1e-6;
    let moved = |state: [f64; 7], rates: [f64; 7], by: f64| -> [f64; 7] {
        std::array::from_fn(|k| state[k] + by * rates[k])
    };
    for step in 0..8192 {
        let t = f64::from(step) * h;
        let k1 = oblique_rates(t, exact, push);
        let k2 = oblique_rates(t + 0.5 * h, moved(exact, k1, 0.5 * h), push);
        let k3 = oblique_rates(t + 0.5 * h, moved(exact, k2, 0.5 * h), push);
        let k4 = oblique_rates(t + h, moved(exact, k3, h), push);
        exact = std::array::from_fn(|k| exact[k] + h / 6.0 * (k1[k] + 2.0 * k2[k] + 2.0 * k3[k] + k4[k]));
    }
    let pulsation = (OBLIQUE_LAW.normal_stiffness / REDUCED).sqrt();
    halved(1.28e-4, 6, |dt| {
        let bodies = [0, 1].map(|i| BodySpec {
            translation_rate: push.relaxation_rate,
            rotation_rate: push.relaxation_rate,
            ..disk(OBLIQUE_MASSES[i], OBLIQUE_RADII[i])
        });
        let motions = [(at(x, y), moving(vx, vy)), (at(0.0, 0.0), moving(0.0, 0.0))];
        let mut world = world(&bodies, &[], OBLIQUE_LAW, &motions, dt);
        world.drive_rate = push.drive_rates.to_vec();
        world.advance(time)?;
        ensure!(world.work().sliding == 0, "it slid");
        let (poses, twists) = (&world.state().poses, &world.state().twists);
        let place = poses[0].position - poses[1].position - vec2(exact[0], exact[1]);
        let velocity = twists[0].velocity - twists[1].velocity - vec2(exact[2], exact[3]);
        let rims = [0, 1].map(|i| (twists[i].angular_velocity - exact[4 + i]) * OBLIQUE_RADII[i]);
        let speeds = (velocity.norm_squared() + rims[0] * rims[0] + rims[1] * rims[1]).sqrt();
        Ok(place.norm().hypot(speeds / pulsation))
    })
}

fn oblique_order() -> Result<f64> {
    Ok(off_ratio(&errors_in_oblique_contact(&Push::NONE)?, 4.0))
}

/// Returns the largest relative drifts of momentum and angular momentum.
fn glancing() -> Result<(f64, f64)> {
    let mut world = world(
        &[pedestrian(89.0, FREE), pedestrian(60.0, FREE)],
        &[],
        BODIES,
        &[
            (at(0.0, 0.0), Twist { velocity: vec2(1.5, 0.1), angular_velocity: 0.7 }),
            (Pose { position: vec2(0.4, 0.22), orientation: 1.1 }, moving(-0.5, 0.0)),
        ],
        1e-5,
    );
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

fn glancing_momentum() -> Result<f64> {
    Ok(glancing()?.0)
}

fn glancing_angular_momentum() -> Result<f64> {
    Ok(glancing()?.1)
}
