//! Contacts never make energy: random pairs over materials, inner corners of walls, round rooms. Nobody drives them.

use crate::checks::scenarios::open;
use crate::checks::{Figure, Result, ensure, largest};
use anyhow::Context;
use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;
use crowd_mechanics::setup::Setup;
use lemons_core::trial::Trial;
use std::f64::consts::{PI, TAU};

pub(crate) const FIGURES: &[Figure] = &[
    || Ok((damped_pair(1.5e4)? - 0.8564).abs()),
    || Ok((damped_pair(1000.0)? - 0.7727).abs()),
    || random_pairs(500, 1.0),
    || random_pairs(100, 0.1),
    || corners(ELASTIC),
    || corners(CONCRETE),
    drawn_in_parts,
];

/// A Trial of two people of one material.
fn pair(people: &[PlacedBody; 2], young_modulus: f64, damping: [f64; 2], friction: f64) -> Result<Trial> {
    let mut trial = open("push_agent_agent")?;
    populate(&mut trial, people);
    for material in &mut trial.materials.intrinsic {
        (material.young_modulus, material.shear_modulus) = (young_modulus, young_modulus / 2.2905);
    }
    for contact in &mut trial.materials.binary {
        [contact.gamma_normal, contact.gamma_tangential] = damping;
        contact.kinetic_friction = friction;
    }
    Ok(trial)
}

/// Two five-disk bodies that run into each other.
fn damped_pair(tangential_damping: f64) -> Result<f64> {
    let first = pedestrian(30.4, 0.0).of_inertia(0.291).at(-0.35, 0.037).turned(2.9).moving(2.3, 0.67);
    let second = pedestrian(51.6, 0.0).of_inertia(0.961).at(0.35, 0.0).turned(-0.19).moving(-1.67, -1.0);
    let people = [first.spinning(4.3), second.spinning(2.1)];
    let mut world = Setup::of(&pair(&people, 3.6e5, [16.0, tangential_damping], 1.0)?).world()?;
    world.mechanical_step = 1e-5;
    let before = energy(&world);
    for _ in 0..10 {
        world.advance(0.1)?;
    }
    ensure!(world.work().contacts > 100 && world.contacts().contacts.is_empty(), "they met and parted");
    Ok(energy(&world) / before)
}

/// Returns the largest energy gained, as a share of that before, of random pairs of pedestrians; at a share of the
/// longest step without a warning.
fn random_pairs(count: u32, share_of_longest: f64) -> Result<f64> {
    let mut random = Random(16);
    let (mut worst, mut met) = (f64::NEG_INFINITY, 0);
    while met < count {
        let powers = |random: &mut Random, low: f64, high: f64| low * (high / low).powf(random.share());
        let young_modulus = powers(&mut random, 1e5, 1e7);
        let damping = [(); 2].map(|()| {
            let (none, strength) = (random.share() < 0.15, powers(&mut random, 3.0, 3e4));
            if none { 0.0 } else { strength }
        });
        let friction = if random.share() < 0.1 { 0.0 } else { random.within(0.0, 5.0) };
        let mut people = [(); 2].map(|()| {
            let mass = random.within(20.0, 120.0);
            pedestrian(mass, 0.0).of_inertia(mass * random.within(0.008, 0.03))
        });
        let direction = random.within(0.0, TAU);
        let away = vec2(libm::cos(direction), libm::sin(direction));
        let towards = away * -random.within(0.5, 4.0);
        people[1].pose.position = away * 0.7 + away.left() * random.within(-0.25, 0.25);
        let share = random.share();
        for (person, velocity) in people.iter_mut().zip([towards * -share, towards * (1.0 - share)]) {
            person.pose.orientation = random.within(-PI, PI);
            person.twist = Twist { velocity, angular_velocity: random.within(-6.0, 6.0) };
        }
        let trial = pair(&people, young_modulus, damping, friction)?;
        let longest = Setup::of(&trial).steps().context("they can touch")?.longest();
        let mut world = Setup::of(&trial).world()?;
        let dt = share_of_longest * longest;
        world.mechanical_step = dt;
        ensure!(world.contacts().contacts.is_empty(), "they are apart at first");
        let before = energy(&world);
        let mut most = f64::NEG_INFINITY;
        for _ in 0..(1.5 / (5.0 * dt)).ceil() as u32 {
            if world.advance(5.0 * dt).is_err() {
                return Ok(f64::INFINITY);
            }
            // While they touch, the energy of a step of second order oscillates.
            if world.work().contacts > 0 && world.contacts().contacts.is_empty() {
                most = most.max(energy(&world) / before - 1.0);
            }
        }
        if most > f64::NEG_INFINITY {
            met += 1;
            worst = worst.max(most);
        }
    }
    Ok(worst.max(0.0))
}

/// A disk that is thrown into inner corners, and about in round rooms. Returns the largest gain of energy, as a share of
/// that before; without damping and friction also the largest loss. Seen when it touches nothing.
fn corners(law: PairLaw) -> Result<f64> {
    let conservative = law == ELASTIC;
    let (mut worst, mut hits) = (0.0f64, 0);
    let mut random = Random(89);
    let mut fly = |wall: &[(f64, f64)], body: PlacedBody, time: f64| -> Result<()> {
        let mut world = world(&[body], &[wall], law, 1e-5);
        ensure!(world.contacts().contacts.is_empty(), "it is apart at first");
        let (mut before, mut touched) = (energy(&world), 0);
        for _ in 0..(time / 1e-3) as u32 {
            world.advance(1e-3)?;
            let touches = world.work().contacts;
            if world.contacts().contacts.is_empty() && touches > touched {
                let change = energy(&world) / before - 1.0;
                worst = worst.max(if conservative { change.abs() } else { change });
                (before, touched) = (energy(&world), touches);
                hits += 1;
            }
        }
        Ok(())
    };
    for degrees in [0.1, 1.0, 3.0, 10.0, 19.0, 20.0, 21.0, 30.0, 45.0, 60.0, 75.0, 89.0f64] {
        let turn = degrees.to_radians();
        for _ in 0..12 {
            let end = (3.0 * libm::cos(turn), 3.0 * libm::sin(turn));
            // Towards the place where the disk touches both faces.
            let aim = vec2(-0.2 * libm::tan(0.5 * turn) + random.within(-0.03, 0.03), 0.2);
            let from = random.within(turn + 0.2, PI - 0.2);
            let direction = vec2(libm::cos(from), libm::sin(from));
            let start = aim + direction * 0.3;
            let velocity = direction * -random.within(0.5, 6.0);
            let body = disk(80.0, 0.2).at(start.x, start.y).moving(velocity.x, velocity.y);
            fly(&[(-3.0, 0.0), (0.0, 0.0), end], body.spinning(random.within(-4.0, 4.0)), 0.9)?;
        }
    }
    for pieces in [18, 72, 300, 1142] {
        for _ in 0..3 {
            let (direction, speed) = (random.within(0.0, TAU), random.within(2.0, 6.0));
            let [x, y, spin] = [0.5, 0.5, 4.0].map(|most| random.within(-most, most));
            let body =
                disk(80.0, 0.2).at(x, y).moving(speed * libm::cos(direction), speed * libm::sin(direction));
            fly(&polygon(pieces), body.spinning(spin), 3.0)?;
        }
    }
    ensure!(hits >= 200, "there are more than 200 hits: {hits}");
    Ok(worst)
}

/// A disk slides along a wall, and another is thrown against it: the largest difference from one wall of how they
/// move, and of the force on the slider, divided by that force.
fn drawn_in_parts() -> Result<f64> {
    let ways: [&[&[(f64, f64)]]; 5] = [
        &[&[(-3.0, 0.0), (3.0, 0.0)]],
        &[&[(-3.0, 0.0), (0.1, 0.0)], &[(0.1, 0.0), (3.0, 0.0)]],
        &[&[(3.0, 0.0), (0.1, 0.0)], &[(-3.0, 0.0), (0.1, 0.0)]],
        &[&[(-3.0, 0.0), (3.0, 0.0)], &[(3.0, 0.0), (-3.0, 0.0)]],
        &[&[(-3.0, 0.0), (0.2, 0.0)], &[(0.0, 0.0), (3.0, 0.0)], &[(0.1, 0.0), (0.1, -1.0)]],
    ];
    let (mut first, mut worst): (Option<Vec<f64>>, f64) = (None, 0.0);
    for way in ways {
        let slider = disk(80.0, 0.2).at(-0.3, 0.1999).moving(0.9, 0.0);
        let thrown = disk(70.0, 0.2).at(1.0, 0.3).moving(0.4, -2.0);
        let mut world = world(&[slider, thrown], way, CONCRETE, 1e-5);
        world.drive[0].force = vec2(0.0, -500.0);
        let mut seen = Vec::new();
        for _ in 0..100 {
            world.advance(0.01)?;
            for (pose, twist) in world.state().poses.iter().zip(&world.state().twists) {
                seen.extend([pose.position.x, pose.position.y, twist.velocity.x, twist.velocity.y]);
                seen.extend([pose.orientation, twist.angular_velocity]);
            }
            seen.push(world.contacts().bodies[0].squeeze / 500.0);
        }
        let one = first.get_or_insert_with(|| seen.clone());
        worst = largest([worst, largest(one.iter().zip(&seen).map(|(one, other)| (one - other).abs()))]);
    }
    Ok(worst)
}
