//! Energy balance: all supplied energy is stored, or lost to floor, damping and sliding.

use crate::checks::error::Result;
use crate::checks::scenes::*;
use crate::checks::{Check, halved, shortfall};
use crowd_mechanics::engine::*;
use std::collections::HashMap;

pub(crate) const CHECKS: &[Check] = &[
    Check::new("energy ledger, contacts lasting: remainder", "energy put in", "", 1e-6, || {
        remainder(Case::Lasting)
    }),
    Check::new("the same: order short of 2", "halving the step four times", "", 0.1, || {
        short_of(Case::Lasting, 2.0)
    }),
    Check::new("energy ledger, contacts beginning and ending: remainder", "energy put in", "", 1e-3, || {
        remainder(Case::Passing)
    }),
    Check::new("the same: order short of 1", "halving the step four times", "", 0.3, || {
        short_of(Case::Passing, 1.0)
    }),
];

/// The kind of contacts in a ledger.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Case {
    /// Pressed together and sticking all the time.
    Lasting,
    /// Contacts that begin, slide and end.
    Passing,
}

/// Energies \[J\], each from its own formula.
#[derive(Debug, Clone, Copy, Default)]
pub struct Ledger {
    /// Gain of kinetic energy.
    pub kinetic: f64,
    /// Gain of ½ k_n h².
    pub normal_springs: f64,
    /// Gain of ½ k_t s².
    pub tangential_springs: f64,
    /// Work of the drive, ∫ F_p·v + M_p ω.
    pub drive: f64,
    /// Lost to the floor, ∫ λ m v² + λ I ω².
    pub floor: f64,
    /// Lost in the dashpots, ∫ γ_n v_n² + γ_t (ds/dt)².
    pub damping: f64,
    /// Lost in the sliders, −∫ F_t (v_t − ds/dt).
    pub sliding: f64,
    /// Energy left in springs when a contact ended.
    pub let_go: f64,
    /// Energy that was converted: the scale of the remainder.
    pub turnover: f64,
}

impl Ledger {
    /// Returns the unexplained energy / turnover.
    pub fn remainder(&self) -> f64 {
        let gained = self.kinetic + self.normal_springs + self.tangential_springs;
        let lost = self.floor + self.damping + self.sliding + self.let_go;
        (gained + lost - self.drive) / self.turnover
    }
}

fn case(case: Case, mechanical_step: f64) -> World {
    match case {
        Case::Lasting => {
            let mut world = pressed_together(mechanical_step);
            world.drive[0].torque = 10.0;
            world.drive[1] = Wrench { force: vec2(-2000.0, 50.0), torque: 5.0 };
            world
        }
        // A pedestrian runs past another, slides along, and both run into a wall.
        Case::Passing => {
            let bodies = [pedestrian(89.0, 4.5), pedestrian(60.0, 4.5)];
            let motions = [
                (at(0.0, 0.0), Twist { velocity: vec2(2.0, 0.1), angular_velocity: 0.7 }),
                (Pose { position: vec2(0.42, 0.22), orientation: 1.1 }, moving(-0.5, 0.0)),
            ];
            let walls = [wall(&[(0.9, -2.0), (0.8, 2.0)])];
            let mut world = world(&bodies, &walls, BODIES, &motions, mechanical_step);
            world.drive = vec![Wrench { force: vec2(400.0, 0.0), torque: 1.0 }; 2];
            world
        }
    }
}

/// Powers \[W\] at an instant.
struct Powers {
    drive: f64,
    floor: f64,
    damping: f64,
}

fn powers(world: &World) -> Powers {
    let scene = world.scene();
    let mut powers = Powers { drive: 0.0, floor: 0.0, damping: 0.0 };
    for ((body, twist), drive) in scene.bodies.iter().zip(&world.state().twists).zip(&world.drive) {
        let (v, w) = (twist.velocity, twist.angular_velocity);
        powers.drive += drive.force.dot(v) + drive.torque * w;
        powers.floor +=
            body.translation_rate * body.mass * v.norm_squared() + body.rotation_rate * body.inertia * w * w;
    }
    for contact in &world.contacts().contacts {
        let law = law_of(scene, contact);
        powers.damping += law.normal_damping * contact.normal_speed.powi(2)
            + law.tangential_damping * rate(law, contact).powi(2);
    }
    powers
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

/// Computes the ledger of a case over 0.25 s, adding up once per mechanical step.
///
/// # Errors
/// The world did not advance.
pub fn ledger(which: Case, mechanical_step: f64) -> Result<Ledger> {
    let mut world = case(which, mechanical_step);
    world.shortlisting = Shortlisting::Off;
    let mut books = Ledger::default();
    let scene = world.scene().clone();
    let first = kinetic_energy(&world);
    let in_springs = |world: &World| {
        let contacts = &world.contacts().contacts;
        contacts.iter().map(|c| stored(&scene, c)).fold([0.0; 2], |sum, e| [sum[0] + e[0], sum[1] + e[1]])
    };
    let springs_at_first = in_springs(&world);
    let steps = (0.25 / mechanical_step).round() as u32;
    let mut before = powers(&world);
    let mut contacts: HashMap<_, Contact> = HashMap::new();
    contacts.extend(world.contacts().contacts.iter().map(|c| (key(c.pair), *c)));
    let half = 0.5 * mechanical_step;
    for _ in 0..steps {
        world.advance(mechanical_step)?;
        let after = powers(&world);
        books.drive += half * (before.drive + after.drive);
        books.floor += half * (before.floor + after.floor);
        books.damping += half * (before.damping + after.damping);
        books.turnover += half * (before.drive.abs() + before.floor + before.damping);
        before = after;
        let mut now: HashMap<_, Contact> = HashMap::new();
        for contact in &world.contacts().contacts {
            if let Some(last) = contacts.remove(&key(contact.pair)) {
                let slip = half * (last.slip_speed + contact.slip_speed);
                let slid = slip - (contact.elongation - last.elongation);
                books.sliding -= 0.5 * (last.tangential_force + contact.tangential_force) * slid;
            } else {
                // Its springs were loaded within the step.
                books.sliding -= stored(&scene, contact)[1];
            }
            now.insert(key(contact.pair), *contact);
        }
        for ended in contacts.values() {
            books.let_go += stored(&scene, ended).iter().sum::<f64>();
        }
        contacts = now;
    }
    let springs = in_springs(&world);
    books.kinetic = kinetic_energy(&world) - first;
    (books.normal_springs, books.tangential_springs) =
        (springs[0] - springs_at_first[0], springs[1] - springs_at_first[1]);
    books.turnover += first;
    Ok(books)
}

/// Returns mechanical steps \[s\] and remainders, for four halvings.
///
/// # Errors
/// The world did not advance.
pub fn remainders(which: Case) -> Result<Vec<(f64, f64)>> {
    halved(4e-5, 5, |dt| Ok(ledger(which, dt)?.remainder()))
}

fn remainder(which: Case) -> Result<f64> {
    Ok(remainders(which)?.last().map_or(f64::NAN, |(_, remainder)| remainder.abs()))
}

/// Returns by how much the order of the remainder over all halvings is less than expected.
fn short_of(which: Case, expected: f64) -> Result<f64> {
    Ok(shortfall(&remainders(which)?, expected))
}
