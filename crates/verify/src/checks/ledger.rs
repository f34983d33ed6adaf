//! Energy balance: all supplied energy is stored, or lost to floor, damping and sliding.

use crate::checks::{Figure, Halved, Result, halved, shortfall};
use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;
use lemons_core::plane::Ring;
use lemons_core::trial::{Ground, Incline};
use std::collections::HashMap;

pub(crate) const FIGURES: &[Figure] = &[
    || remainder(lasting),
    || Ok(shortfall(&remainders(lasting)?, 2.0)),
    || remainder(passing),
    || Ok(shortfall(&remainders(passing)?, 1.0)),
    || remainder(wheels),
    || Ok(shortfall(&remainders(wheels)?, 2.0)),
    || remainder(slope),
    || Ok(shortfall(&remainders(slope)?, 2.0)),
];

/// Makes a world with this mechanical step \[s\].
type Case = fn(f64) -> World;

/// Pressed together and sticking all the time.
pub(crate) fn lasting(mechanical_step: f64) -> World {
    let mut world = pressed_together(mechanical_step);
    world.drive[0].torque = 10.0;
    world.drive[1] = Wrench { force: vec2(-2000.0, 50.0), torque: 5.0 };
    world
}

/// Contacts that begin, slide and end: a pedestrian runs past another, slides along, and both run into a wall.
pub(crate) fn passing(mechanical_step: f64) -> World {
    let first = pedestrian(89.0, 4.5).moving(2.0, 0.1).spinning(0.7);
    let second = pedestrian(60.0, 4.5).at(0.42, 0.22).turned(1.1).moving(-0.5, 0.0);
    let mut world = world(&[first, second], &[&[(0.9, -2.0), (0.8, 2.0)]], BODIES, mechanical_step);
    world.drive = vec![Wrench { force: vec2(400.0, 0.0), torque: 1.0 }; 2];
    world
}

/// Two that stand on wheels, pressed together, sticking, and turning.
fn wheels(mechanical_step: f64) -> World {
    let first = disk(80.0, 0.2).turned(0.4).moving(0.05, 0.0).spinning(2.0).relaxing(2.0, 2.0);
    let second = disk(60.0, 0.25).at(0.449, 0.0).turned(-1.0).spinning(-1.6).relaxing(4.5, 2.0);
    let people = [first.relaxing_across(40.0), second.relaxing_across(0.5)];
    let mut world = world(&people, &[], PairLaw { friction: 5.0, ..BODIES }, mechanical_step);
    world.drive[0] = Wrench { force: vec2(2000.0, 0.0), torque: 10.0 };
    world.drive[1] = Wrench { force: vec2(-2000.0, 50.0), torque: 5.0 };
    world
}

/// The first case on a slope of 25°, of which feet hold a fifth.
fn slope(mechanical_step: f64) -> World {
    let level = lasting(mechanical_step);
    let corners = [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(|(x, y)| vec2(x, y));
    let ground = Ground {
        id: String::new(),
        area: Ring::through(corners.to_vec()).expect("four corners"),
        downhill: 1.0,
        incline: Incline::Slope { angle: 25f64.to_radians(), held: 0.2 },
        speeds: [None; 2],
    };
    let scene = level.scene().clone().with_grounds(&[ground]);
    let mut world = World::new(scene, level.state().clone(), mechanical_step).expect("few bodies");
    world.drive.clone_from(&level.drive);
    world
}

/// Powers \[W\] at an instant: of the drive and of slopes, lost to the floor, lost in the dashpots.
fn powers(world: &World) -> [f64; 3] {
    let scene = world.scene();
    let [mut drive, mut floor, mut damping] = [0.0; 3];
    for ((body, motion), wrench) in scene.bodies.iter().zip(motions(world)).zip(&world.drive) {
        let (v, w) = (motion.twist.velocity, motion.twist.angular_velocity);
        drive += wrench.force.dot(&v) + wrench.torque * w;
        drive += scene.pull(motion.pose.position).dot(&v) * body.mass;
        floor -= body.by_floor(motion.pose.orientation, v).dot(&v) * body.mass;
        floor += body.rotation_rate * body.inertia * w * w;
    }
    for contact in &world.contacts().contacts {
        let law = law_of(scene, contact);
        damping += law.normal_damping * contact.normal_speed.powi(2)
            + law.tangential_damping * rate(law, contact).powi(2);
    }
    [drive, floor, damping]
}

/// \[m/s\] The rate of the elongation; without damping, the tangential speed.
fn rate(law: &PairLaw, contact: &Contact) -> f64 {
    if contact.regime == Regime::Sticking || law.tangential_damping == 0.0 {
        return contact.slip_speed;
    }
    (-contact.tangential_force - law.tangential_stiffness * contact.elongation) / law.tangential_damping
}

/// A key to find the same pair again a step later.
fn key(pair: Pair) -> (u32, u32, u8) {
    match pair {
        Pair::Disks { first, second } => (first.0, second.0, 3),
        Pair::Face { disk, face, part } => (disk.0, face.0, part as u8),
    }
}

/// Computes the unexplained energy of a case over 0.25 s, as a share of what was converted. Every energy is from its
/// own formula, added up once per mechanical step.
///
/// # Errors
/// The world did not advance.
fn unexplained(case: Case, mechanical_step: f64) -> Result<f64> {
    let mut world = case(mechanical_step);
    world.shortlisting = Shortlisting::Off;
    let scene = world.scene().clone();
    let at_first = energy(&world);
    // Work of the drive, ∫ F_p·v + M_p ω; lost to the floor, ∫ λ m v² + λ I ω²; in the dashpots, ∫ γ_n v_n² + γ_t (ds/dt)²;
    // in the sliders, −∫ F_t (v_t − ds/dt); left in springs when a contact ended.
    let (mut work, mut lost) = (0.0, 0.0);
    let mut turnover = kinetic_energy(&world);
    let mut before = powers(&world);
    let mut contacts: HashMap<_, Contact> = HashMap::new();
    contacts.extend(world.contacts().contacts.iter().map(|c| (key(c.pair), *c)));
    let half = 0.5 * mechanical_step;
    for _ in 0..(0.25 / mechanical_step).round() as u32 {
        world.advance(mechanical_step)?;
        let after = powers(&world);
        work += half * (before[0] + after[0]);
        lost += half * (before[1] + after[1] + before[2] + after[2]);
        turnover += half * (before[0].abs() + before[1] + before[2]);
        before = after;
        let mut now: HashMap<_, Contact> = HashMap::new();
        for contact in &world.contacts().contacts {
            if let Some(last) = contacts.remove(&key(contact.pair)) {
                let slip = half * (last.slip_speed + contact.slip_speed);
                let slid = slip - (contact.elongation - last.elongation);
                lost -= 0.5 * (last.tangential_force + contact.tangential_force) * slid;
            } else {
                // Its springs were loaded within the step.
                lost -= stored(&scene, contact)[1];
            }
            now.insert(key(contact.pair), *contact);
        }
        lost += contacts.values().flat_map(|ended| stored(&scene, ended)).sum::<f64>();
        contacts = now;
    }
    Ok((energy(&world) - at_first + lost - work) / turnover)
}

/// Returns mechanical steps \[s\] and remainders, for four halvings.
///
/// # Errors
/// The world did not advance.
pub(crate) fn remainders(case: Case) -> Result<Halved> {
    halved(4e-5, 5, |dt| unexplained(case, dt))
}

fn remainder(case: Case) -> Result<f64> {
    Ok(remainders(case)?[4].1.abs())
}
