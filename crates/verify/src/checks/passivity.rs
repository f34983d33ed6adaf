//! Contacts never make energy: random pairs over materials, inner corners of walls, round rooms. Nobody drives them.

use crate::checks::error::{Error, Result, ensure};
use crate::checks::scenarios::open;
use crate::checks::scenes::*;
use crate::checks::{Check, largest};
use crowd_mechanics::engine::*;
use crowd_mechanics::setup::Setup;
use std::f64::consts::{PI, TAU};

pub(crate) const CHECKS: &[Check] = &[
    Check::new(
        "two pedestrians, γ_t = 1.5e4 kg/s: energy after / before",
        "0.8564: independent integrator",
        "",
        1e-3,
        || Ok((damped_pair(1.5e4)? - 0.8564).abs()),
    ),
    Check::new("the same, γ_t = 1000 kg/s", "0.7727: independent integrator", "", 1e-3, || {
        Ok((damped_pair(1000.0)? - 0.7727).abs())
    }),
    Check::new(
        "500 random pairs, E 1e5–1e7, γ 0–3e4, μ 0–5, longest steps that check lets pass: energy gained",
        "no more than before",
        "",
        1e-2,
        || random_pairs(1.0),
    ),
    Check::new("the same at a tenth of these steps", "no more than before", "", 1e-4, || random_pairs(0.1)),
    Check::new(
        "200 hits at inner corners of 0.1° to 89° and round rooms, no damping: energy gained or lost",
        "none",
        "",
        1e-4,
        || corners(ELASTIC),
    ),
    Check::new(
        "the same with damping and friction: energy gained in a hit",
        "no more than before",
        "",
        1e-4,
        || corners(CONCRETE),
    ),
    Check::new(
        "walls end to end, drawn twice, in parts: slider and rebound",
        "one wall",
        "SI",
        1e-9,
        drawn_in_parts,
    ),
];

/// The law of two equal materials (paper, App. A).
fn law(young: f64, [normal_damping, tangential_damping]: [f64; 2], friction: f64) -> PairLaw {
    let shear = young / 2.2905;
    PairLaw {
        normal_stiffness: 0.5 / ((4.0 * shear - young) / (4.0 * shear * shear)),
        tangential_stiffness: 0.5 / ((6.0 * shear - young) / (8.0 * shear * shear)),
        normal_damping,
        tangential_damping,
        friction,
    }
}

/// \[J\] Kinetic energy, and that of the springs.
fn energy(world: &World) -> f64 {
    let of_springs = |contact: &Contact| stored(world.scene(), contact).iter().sum::<f64>();
    kinetic_energy(world) + world.contacts().contacts.iter().map(of_springs).sum::<f64>()
}

/// Two five-disk bodies that run into each other.
fn damped_pair(tangential_damping: f64) -> Result<f64> {
    let bodies =
        [(30.4, 0.291), (51.6, 0.961)].map(|(mass, inertia)| BodySpec { inertia, ..pedestrian(mass, FREE) });
    let motion = |x: f64, y: f64, orientation, velocity, angular_velocity| {
        (Pose { position: vec2(x, y), orientation }, Twist { velocity, angular_velocity })
    };
    let motions =
        [motion(-0.35, 0.037, 2.9, vec2(2.3, 0.67), 4.3), motion(0.35, 0.0, -0.19, vec2(-1.67, -1.0), 2.1)];
    let law = law(3.6e5, [16.0, tangential_damping], 1.0);
    let mut world = world(&bodies, &[], law, &motions, 1e-5);
    let before = energy(&world);
    for _ in 0..10 {
        world.advance(0.1)?;
    }
    ensure!(world.work().contacts > 100 && world.contacts().contacts.is_empty(), "they met and parted");
    Ok(energy(&world) / before)
}

/// Returns the largest energy gained, as a share of that before, of random pairs of pedestrians; at a share of the
/// longest step without a warning.
fn random_pairs(share_of_longest: f64) -> Result<f64> {
    let (_directory, mut trial) = open("push_agent_agent")?;
    let mut random = Random(16);
    let (mut worst, mut met) = (f64::NEG_INFINITY, 0);
    while met < 500 {
        let powers = |random: &mut Random, low: f64, high: f64| low * (high / low).powf(random.share());
        let young = powers(&mut random, 1e5, 1e7);
        let damping = [(); 2].map(|()| {
            let (none, strength) = (random.share() < 0.15, powers(&mut random, 3.0, 3e4));
            if none { 0.0 } else { strength }
        });
        let friction = if random.share() < 0.1 { 0.0 } else { random.within(0.0, 5.0) };
        let law = law(young, damping, friction);
        let bodies = [(); 2].map(|()| {
            let mass = random.within(20.0, 120.0);
            BodySpec { inertia: mass * random.within(0.008, 0.03), ..pedestrian(mass, FREE) }
        });
        for (agent, body) in trial.agents.iter_mut().zip(&bodies) {
            (agent.mass, agent.moment_of_inertia) = (body.mass, body.inertia);
            let shape = agent.shapes[0].clone();
            agent.shapes = body
                .disks
                .iter()
                .map(|disk| lemons_core::trial::Shape {
                    radius: disk.radius,
                    position: disk.position,
                    ..shape.clone()
                })
                .collect();
        }
        for material in &mut trial.materials.intrinsic {
            (material.young_modulus, material.shear_modulus) = (young, young / 2.2905);
        }
        for contact in &mut trial.materials.binary {
            [contact.gamma_normal, contact.gamma_tangential] = damping;
            contact.kinetic_friction = friction;
        }
        let steps = Setup::of(&trial).steps().ok_or_else(|| Error::Premise("they can touch".to_owned()))?;
        let direction = random.within(0.0, TAU);
        let towards = vec2(-libm::cos(direction), -libm::sin(direction)) * random.within(0.5, 4.0);
        let beside = random.within(-0.25, 0.25);
        let first = at(0.0, 0.0).position;
        let second = vec2(libm::cos(direction), libm::sin(direction)) * 0.7
            + vec2(-libm::sin(direction), libm::cos(direction)) * beside;
        let share = random.share();
        let motions =
            [(first, towards * -share), (second, towards * (1.0 - share))].map(|(position, velocity)| {
                let orientation = random.within(-PI, PI);
                (
                    Pose { position, orientation },
                    Twist { velocity, angular_velocity: random.within(-6.0, 6.0) },
                )
            });
        let dt = share_of_longest * steps.longest();
        let mut world = world(&bodies, &[], law, &motions, dt);
        ensure!(world.contacts().contacts.is_empty(), "they are apart at first");
        let before = energy(&world);
        let mut most = f64::NEG_INFINITY;
        let looks = (1.5 / (5.0 * dt)).ceil() as u32;
        for _ in 0..looks {
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
    let mut fly = |walls: &[WallSpec], motion: (Pose, Twist), time: f64, hits: &mut u32| -> Result<()> {
        let mut world = world(&[disk(80.0, 0.2)], walls, law, &[motion], 1e-5);
        ensure!(world.contacts().contacts.is_empty(), "it is apart at first");
        let (mut before, mut touched) = (energy(&world), 0);
        for _ in 0..(time / 1e-3) as u32 {
            world.advance(1e-3)?;
            let touches = world.work().contacts;
            if world.contacts().contacts.is_empty() && touches > touched {
                let change = energy(&world) / before - 1.0;
                worst = worst.max(if conservative { change.abs() } else { change });
                (before, touched) = (energy(&world), touches);
                *hits += 1;
            }
        }
        Ok(())
    };
    for degrees in [0.1, 1.0, 3.0, 10.0, 19.0, 20.0, 21.0, 30.0, 45.0, 60.0, 75.0, 89.0f64] {
        let turn = degrees.to_radians();
        for _ in 0..12 {
            let end = (3.0 * libm::cos(turn), 3.0 * libm::sin(turn));
            let walls = [wall(&[(-3.0, 0.0), (0.0, 0.0), end])];
            // Towards the place where the disk touches both faces.
            let aim = vec2(-0.2 * libm::tan(0.5 * turn) + random.within(-0.03, 0.03), 0.2);
            let from = random.within(turn + 0.2, PI - 0.2);
            let direction = vec2(libm::cos(from), libm::sin(from));
            let start = aim + direction * 0.3;
            let velocity = direction * -random.within(0.5, 6.0);
            let spin = random.within(-4.0, 4.0);
            let motion = (at(start.x, start.y), Twist { velocity, angular_velocity: spin });
            fly(&walls, motion, 0.9, &mut hits)?;
        }
    }
    for pieces in [18, 72, 300, 1142] {
        let corner = |k: u32| {
            let (sin, cos) = libm::sincos(TAU * f64::from(k % pieces) / f64::from(pieces));
            (cos, sin)
        };
        let walls = [wall(&(0..=pieces).map(corner).collect::<Vec<_>>())];
        for _ in 0..3 {
            let (direction, speed) = (random.within(0.0, TAU), random.within(2.0, 6.0));
            let velocity = vec2(libm::cos(direction), libm::sin(direction)) * speed;
            let start = at(random.within(-0.5, 0.5), random.within(-0.5, 0.5));
            fly(
                &walls,
                (start, Twist { velocity, angular_velocity: random.within(-4.0, 4.0) }),
                3.0,
                &mut hits,
            )?;
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
        let walls: Vec<WallSpec> = way.iter().map(|corners| wall(corners)).collect();
        let motions = [(at(-0.3, 0.1999), moving(0.9, 0.0)), (at(1.0, 0.3), moving(0.4, -2.0))];
        let mut world = world(&[disk(80.0, 0.2), disk(70.0, 0.2)], &walls, CONCRETE, &motions, 1e-5);
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
