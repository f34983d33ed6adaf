//! The longest stable mechanical step, and the warnings of `lemons check` about it.

use crate::checks::scenarios::open;
use crate::checks::{Figure, Result, ensure, largest};
use anyhow::Context;
use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;
use crowd_mechanics::setup::Setup;
use lemons_core::trial::Trial;
use std::f64::consts::PI;

pub(crate) const FIGURES: &[Figure] = &[
    || Ok(largest([0.0, 0.1, 1.0, 10.0, 1e3].into_iter().map(limit_apart).collect::<Result<Vec<_>>>()?)),
    gain_apart,
    sweep,
    unsaid,
    hits_as_accurate_as_wished,
    pressed,
];

/// A disk of 80 kg pressed on a wall.
fn at_wall(law: PairLaw, dt: f64, speed: Vec2) -> World {
    let pressed = 2e4;
    let body = disk(80.0, 0.2).at(pressed / law.normal_stiffness - 0.2, 0.0).moving(speed.x, speed.y);
    let mut world = world(&[body], &[&[(0.0, -9.0), (0.0, 9.0)]], law, dt);
    world.drive[0].force = vec2(pressed, 0.0);
    world
}

/// Returns the relative difference between the step from which on a contact diverges and its theoretical value, for a
/// damping in units of the angular frequency.
fn limit_apart(damping: f64) -> Result<f64> {
    let stiffness = CONCRETE.normal_stiffness;
    let pulsation = (stiffness / 80.0).sqrt();
    let law = PairLaw { normal_damping: damping * pulsation * 80.0, friction: 0.0, ..CONCRETE };
    let theory = 2.0 / (pulsation * (damping + (damping * damping + 1.0).sqrt()));
    let grows = |dt: f64| -> Result<bool> {
        let speed = 1e-3;
        let mut world = at_wall(law, dt, vec2(speed, 0.0));
        // Several at once: velocities are corrected between communication steps, which damps a divergence.
        // Once it leaves the wall at times, it no longer grows; so every step counts.
        let rest = world.largest_overlap();
        for _ in 0..5 {
            if world.advance(1000.0 * dt).is_err() || world.largest_overlap() > rest + 30.0 * speed * dt {
                return Ok(true);
            }
        }
        Ok(false)
    };
    let (mut stable, mut unstable) = (0.7 * theory, 1.4 * theory);
    ensure!(!grows(stable)? && grows(unstable)?, "the limit is within these");
    for _ in 0..10 {
        let middle = 0.5 * (stable + unstable);
        *(if grows(middle)? { &mut unstable } else { &mut stable }) = middle;
    }
    Ok((stable / theory - 1.0).abs())
}

fn gain_apart() -> Result<f64> {
    let law = PairLaw { tangential_damping: 0.0, friction: 20.0, ..CONCRETE };
    // 1/m* of a round disk that may roll.
    let lightness = 3.0 / 80.0;
    let dt = 4e-4;
    let mut world = at_wall(law, dt, vec2(0.0, 0.1));
    let energy = |world: &World| -> Result<f64> {
        let contact = world.contacts().contacts.first();
        let Contact { slip_speed: slip, elongation: stretch, .. } = *contact.context("it is pressed on")?;
        Ok(slip * slip / lightness + law.tangential_stiffness * stretch * stretch)
    };
    world.advance(dt)?;
    let (before, steps) = (energy(&world)?, 4000);
    world.advance(f64::from(steps) * dt)?;
    ensure!(world.work().sliding == 0, "it sticks");
    let gain = (energy(&world)? / before).ln() / 2.0 / f64::from(steps);
    let turn = dt * dt * law.tangential_stiffness * lightness;
    Ok((gain / (turn * turn / 8.0) - 1.0).abs())
}

/// Returns whether `lemons check` warns of the mechanical step.
fn warned(trial: &Trial) -> bool {
    Setup::of(trial).advice_as_edited().iter().map(ToString::to_string).any(|line| {
        let of_contacts = ["contact of", "contacts like that of"].iter().any(|words| line.contains(words));
        line.contains("TimeStepMechanical") && of_contacts
    })
}

/// The scenario's disk of 80 kg and 0.2 m with another mass and stiffness, about to touch the wall.
fn bouncing(trial: &Trial, mass: f64, hardness: f64, damping: [f64; 2], dt: f64) -> Trial {
    let mut trial = trial.clone();
    (trial.agents[0].mass, trial.agents[0].moment_of_inertia) = (mass, 0.02 * mass);
    for material in &mut trial.materials.intrinsic {
        material.young_modulus *= hardness;
        material.shear_modulus *= hardness;
    }
    for contact in &mut trial.materials.binary {
        [contact.gamma_normal, contact.gamma_tangential] = damping;
    }
    trial.dynamics[0].velocity = vec2(1.0, 0.5);
    trial.dynamics[0].omega = 3.0;
    // The wall is at 0.21 m.
    trial.dynamics[0].position.x = 0.01 - 0.37 * dt;
    (trial.parameters.time_step_mechanical, trial.parameters.time_step) = (dt, 100.0 * dt);
    trial
}

/// Returns by what fraction its largest speed exceeds the first one.
fn gained(trial: &Trial) -> Result<f64> {
    let mut world = Setup::of(trial).world()?;
    let before = kinetic_energy(&world);
    let mut most = before;
    for _ in 0..60 {
        if world.advance(5.0 * world.mechanical_step).is_err() {
            return Ok(f64::INFINITY);
        }
        most = most.max(kinetic_energy(&world));
    }
    Ok((most / before).sqrt() - 1.0)
}

fn sweep() -> Result<f64> {
    let trial = open("push_agent_wall")?;
    let (mut worst, mut passed, mut unstable) = (0.0f64, 0, 0);
    let dampings = [0.0, 1e2, 1e3, 1e4, 1e5, 1e6].into_iter().flat_map(|d| [[d, d], [d, 0.0], [0.0, d]]);
    let steps = [1e-6, 5e-6, 2e-5, 1e-4, 3e-4, 1e-3];
    let steps = dampings.flat_map(|damping| steps.map(|step| (damping, step)));
    for (mass, hardness) in masses_and_hardnesses(&[0.01, 1.0, 20.0, 80.0, 1000.0]) {
        for (damping, dt) in steps.clone() {
            let case = bouncing(&trial, mass, hardness, damping, dt);
            if warned(&case) {
                unstable += usize::from(gained(&case)? > 0.1);
            } else {
                worst = worst.max(gained(&case)?);
                passed += 1;
            }
        }
    }
    ensure!(
        passed > 300 && unstable > 100,
        "more than 300 cases pass, and more than 100 of those warned of are unstable: {passed} and {unstable}"
    );
    Ok(worst)
}

fn masses_and_hardnesses(masses: &[f64]) -> impl Iterator<Item = (f64, f64)> {
    masses.iter().flat_map(|mass| [0.01, 1.0, 100.0].map(|hardness| (*mass, hardness)))
}

/// \[m\] Place of the bouncing disk a time \[s\] after it has touched the wall at 0.21 m with 1 m/s.
fn place_after_hit(mass: f64, law: &PairLaw, time: f64) -> f64 {
    let (decay, stiffness) = (law.normal_damping / (2.0 * mass), law.normal_stiffness / mass);
    let touching = 0.01;
    let discriminant = stiffness - decay * decay;
    if discriminant < 0.0 {
        // h = (e^(−a t) − e^(−b t)) / (b − a); a b = k/m, without a difference of nearly equal numbers.
        let b = decay + (-discriminant).sqrt();
        let a = stiffness / b;
        return touching + ((-a * time).exp() - (-b * time).exp()) / (b - a);
    }
    let pulsation = discriminant.sqrt();
    let parted = parted_after(mass, law);
    if time < parted {
        touching + (-decay * time).exp() * (pulsation * time).sin() / pulsation
    } else {
        touching - (-decay * parted).exp() * (time - parted)
    }
}

/// \[s\] Time for which such a hit lasts; NaN if it is overdamped, and lasts for ever.
fn parted_after(mass: f64, law: &PairLaw) -> f64 {
    let decay = law.normal_damping / (2.0 * mass);
    PI / (law.normal_stiffness / mass - decay * decay).sqrt()
}

/// Returns the largest error, divided by the accuracy that its step was chosen for.
fn hits_as_accurate_as_wished() -> Result<f64> {
    let trial = open("push_agent_wall")?;
    let mut worst = 0.0f64;
    for (mass, hardness) in masses_and_hardnesses(&[1.0, 20.0, 80.0, 1000.0]) {
        for damping in [0.0, 1e2, 1e3, 1e4, 1e5] {
            let mut case = bouncing(&trial, mass, hardness, [damping, damping], 1e-5);
            case.dynamics[0].velocity = vec2(1.0, 0.0);
            case.dynamics[0].omega = 0.0;
            // 12.345 678 mm from the wall, so that it touches at any time within a step.
            let gap = 0.012_345_678;
            case.dynamics[0].position.x = 0.01 - gap;
            for accuracy in [1e-3, 1e-4, 1e-6] {
                let step = Setup::of(&case).steps().and_then(|steps| steps.accurate_to(accuracy));
                let mut world = Setup::of(&case).world()?;
                world.mechanical_step = step.context("there is a step")?;
                let law = *world.scene().law(0, 1);
                // When it has parted, it flies on without a force: that needs no steps. An overdamped hit does not end.
                let parted = parted_after(mass, &law);
                let (stepped, time) = if parted < 0.9 { (1.1 * parted, 1.0) } else { (0.1, 0.1) };
                world.advance(gap + stepped)?;
                let (pose, twist) = (world.state().poses[0], world.state().twists[0]);
                let place = pose.position.x + twist.velocity.x * (time - stepped);
                worst = worst.max((place - place_after_hit(mass, &law, time)).abs() / accuracy);
            }
        }
    }
    Ok(worst)
}

fn unsaid() -> Result<f64> {
    let trial = open("push_agent_wall")?;
    let case = bouncing(&trial, 80.0, 1.0, [2e6, 0.0], 1e-4);
    let gained = gained(&case)?;
    ensure!(gained > 0.2, "it parts faster than it came: {gained}");
    Ok(f64::from(u8::from(!warned(&case))))
}

/// Pedestrians side by side in a box that is too small for them; all contacts have this damping.
fn crowd(trial: &Trial, damping: f64) -> Trial {
    let mut trial = trial.clone();
    let (side, x, y) = (7, 0.255, 0.47);
    let mut people = on_lattice(side, [x, y], 0.0);
    for person in &mut people {
        *person = pedestrian(60.0, 0.0)
            .at(person.pose.position.x, person.pose.position.y)
            .moving(0.3 * person.twist.velocity.x, 0.3 * person.twist.velocity.y);
    }
    populate(&mut trial, &people);
    let [[left, right], [bottom, top]] =
        [x, y].map(|spacing| [-0.5, f64::from(side) - 0.5].map(|k| k * spacing));
    trial.geometry.walls[0].corners =
        [(left, bottom), (right, bottom), (right, top), (left, top), (left, bottom)]
            .map(|(x, y)| vec2(x, y))
            .to_vec();
    for contact in &mut trial.materials.binary {
        (contact.gamma_normal, contact.gamma_tangential) = (damping, damping);
    }
    trial
}

fn pressed() -> Result<f64> {
    let trial = open("push_agent_wall")?;
    let mut worst = 0.0f64;
    for damping in [0.0, 700.0, 3e4, 3e5] {
        let mut trial = crowd(&trial, damping);
        trial.parameters.time_step = 1.0;
        let (mut passes, mut warned_of) = (1e-8, 1e-2);
        for _ in 0..16 {
            let middle = f64::sqrt(passes * warned_of);
            trial.parameters.time_step_mechanical = middle;
            *(if warned(&trial) { &mut warned_of } else { &mut passes }) = middle;
        }
        trial.parameters.time_step_mechanical = passes;
        let mut world = Setup::of(&trial).world()?;
        let energy = energy(&world);
        ensure!(world.contacts().contacts.len() > 200, "they are pressed");
        for _ in 0..15 {
            world.advance(100.0 * passes)?;
            worst = worst.max(kinetic_energy(&world) / energy);
        }
    }
    Ok(worst)
}
