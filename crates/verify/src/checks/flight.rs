//! Motion without contact, the shortlist, and saved states.

use crate::checks::error::{Result, ensure};
use crate::checks::scenes::*;
use crate::checks::{Check, farthest_apart, largest};
use crowd_mechanics::engine::*;

pub(crate) const CHECKS: &[Check] = &[
    Check::new("free relaxation of r, v, θ, ω, shortlisted", "closed form", "SI", 1e-10, || {
        relaxation(Shortlisting::On)
    }),
    Check::new("the same, by mechanical steps", "closed form", "SI", 1e-10, || relaxation(Shortlisting::Off)),
    Check::new("a push through a row within one step", "no shortlist", "m", 1e-9, row),
    Check::new("a crowd of 64 with shortlist", "without", "m", 1e-9, crowd),
    Check::new(
        "dense crowd after 1000 steps: bits unlike the golden ones",
        "the same bits on every machine",
        "",
        0.0,
        || golden(12, 1000, 1, GOLDEN),
    ),
    Check::new("1156 people on one thread: bits unlike the golden ones", "the same bits", "", 0.0, || {
        golden(34, 300, 1, GOLDEN_OF_BLOCKS)
    }),
    Check::new("the same on two threads", "the same bits", "", 0.0, || golden(34, 300, 2, GOLDEN_OF_BLOCKS)),
    Check::new("the same on three threads", "the same bits", "", 0.0, || {
        golden(34, 300, 3, GOLDEN_OF_BLOCKS)
    }),
    Check::new("restored in mid-contact and run on: unequal bits", "uninterrupted run", "", 0.0, restored),
];

fn relaxation(shortlisting: Shortlisting) -> Result<f64> {
    let mut body = pedestrian(70.0, 4.5);
    body.rotation_rate = 3.0;
    let start = Twist { velocity: vec2(1.2, -0.4), angular_velocity: 2.0 };
    let mut world = world(std::slice::from_ref(&body), &[], BODIES, &[(at(0.0, 0.0), start)], 1e-5);
    world.shortlisting = shortlisting;
    let drive = Wrench { force: vec2(50.0, 20.0), torque: 1.5 };
    world.drive[0] = drive;
    let mut worst: f64 = 0.0;
    for step in 1..=20 {
        world.advance(0.1)?;
        let t = 0.1 * f64::from(step);
        let (steady, decay) = (drive.force * (1.0 / (70.0 * 4.5)), (-4.5 * t).exp());
        let velocity = steady + (start.velocity - steady) * decay;
        let place = steady * t + (start.velocity - steady) * ((1.0 - decay) / 4.5);
        let (spin, decay) = (drive.torque / (body.inertia * 3.0), (-3.0 * t).exp());
        let omega = spin + (start.angular_velocity - spin) * decay;
        let theta = spin * t + (start.angular_velocity - spin) * (1.0 - decay) / 3.0;
        let (pose, twist) = (world.state().poses[0], world.state().twists[0]);
        worst = largest([
            worst,
            (pose.position - place).norm(),
            (twist.velocity - velocity).norm(),
            (pose.orientation - theta).abs(),
            (twist.angular_velocity - omega).abs(),
        ]);
    }
    ensure!((world.work().shortlisted > 0) == (shortlisting == Shortlisting::On), "not as asked");
    Ok(worst)
}

/// Standing people with gaps, and one who runs into them. Within one communication step the push travels through bodies
/// that were not near anything moving when the step began.
fn row() -> Result<f64> {
    let mut worlds = [Shortlisting::On, Shortlisting::Off].map(|shortlisting| {
        let bodies: Vec<BodySpec> = (0..6).map(|_| disk(70.0, 0.2)).collect();
        let mut motions: Vec<(Pose, Twist)> =
            (0..6).map(|k| (at(0.55 * f64::from(k), 0.0), moving(0.0, 0.0))).collect();
        motions[0].1 = moving(3.0, 0.0);
        let mut world = world(&bodies, &[], ELASTIC, &motions, 1e-5);
        world.shortlisting = shortlisting;
        world
    });
    for world in &mut worlds {
        world.advance(0.5)?;
    }
    // Equal masses: the last one gets the velocity of the first.
    ensure!((worlds[0].state().twists[5].velocity.x - 3.0).abs() < 1e-3, "the push went through");
    Ok(farthest_apart(&worlds))
}

fn crowd() -> Result<f64> {
    let mut worlds = [Shortlisting::On, Shortlisting::Off].map(|shortlisting| {
        let mut world = lattice(8, 0.6, 1e-4);
        world.shortlisting = shortlisting;
        world
    });
    for _ in 0..10 {
        for world in &mut worlds {
            world.advance(0.05)?;
        }
    }
    ensure!(worlds[0].work().shortlisted > 0, "somebody was shortlisted");
    Ok(farthest_apart(&worlds))
}

fn restored() -> Result<f64> {
    let mut world = lattice(6, 0.5, 1e-5);
    while world.contacts().agent_contacts == 0 {
        world.advance(0.001)?;
    }
    let mut other = World::new(world.scene().clone(), world.state().clone(), 1e-5)?;
    let mut unequal = 0;
    for _ in 0..300 {
        world.advance(0.001)?;
        other.advance(0.001)?;
        unequal += u32::from(world.state() != other.state() || world.contacts() != other.contacts());
    }
    Ok(f64::from(unequal))
}

/// Hash of the state of a dense crowd of 144 after 1000 mechanical steps, in debug and release builds, on every
/// machine. If it changes, results change: the CHANGELOG must say by how much.
const GOLDEN: u64 = 0x65ba_a920_4c80_73c6;

/// The same for a crowd of 1156 after 300 steps, whose blocks are shared among threads.
const GOLDEN_OF_BLOCKS: u64 = 0x738d_454e_60cd_4ce7;

/// Whether the hash of a dense crowd differs from the expected one.
fn golden(side: u32, steps: u32, threads: usize, expected: u64) -> Result<f64> {
    let mut world = lattice(side, 0.4, 1e-5);
    world.shortlisting = Shortlisting::Off;
    world.set_threads(threads)?;
    ensure!(world.threads() == threads, "as many threads as asked for");
    world.advance(1e-5 * f64::from(steps))?;
    ensure!(world.work().contacts > 10_000, "it is dense");
    ensure!(world.shared() == u64::from(threads > 1), "threads have shared it");
    let hash = bits(world.state());
    if hash != expected {
        println!("golden bits: {hash:#018x}");
    }
    Ok(f64::from(u8::from(hash != expected)))
}

/// FNV-1a hash of the bits of a state.
fn bits(state: &State) -> u64 {
    let motions = state.poses.iter().zip(&state.twists).flat_map(|(pose, twist)| {
        let (r, v) = (pose.position, twist.velocity);
        [r.x, r.y, pose.orientation, v.x, v.y, twist.angular_velocity]
    });
    let springs = state.disk_springs.iter().map(|s| s.elongation);
    let springs = springs.chain(state.face_springs.iter().map(|s| s.elongation));
    motions.chain(springs).fold(0xcbf2_9ce4_8422_2325_u64, |hash, value| {
        let bytes = value.to_bits().to_le_bytes();
        bytes.iter().fold(hash, |h, byte| (h ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3))
    })
}
