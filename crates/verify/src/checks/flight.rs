//! Motion without contact, the shortlist, and saved states.

use crate::checks::ramp::{along_row, flight};
use crate::checks::scenes::*;
use crate::checks::{Figure, Result, ensure, farthest_apart};
use crowd_mechanics::engine::*;

pub(crate) const FIGURES: &[Figure] = &[
    || relaxation(Shortlisting::On),
    || relaxation(Shortlisting::Off),
    row,
    crowd,
    || golden(12, 1000, 1, GOLDEN),
    || golden(34, 300, 1, GOLDEN_OF_BLOCKS),
    || golden(34, 300, 2, GOLDEN_OF_BLOCKS),
    || golden(34, 300, 3, GOLDEN_OF_BLOCKS),
    restored,
];

fn relaxation(shortlisting: Shortlisting) -> Result<f64> {
    let someone = pedestrian(70.0, 0.0).relaxing(4.5, 3.0).moving(1.2, -0.4).spinning(2.0);
    let drive = Wrench { force: vec2(50.0, 20.0), torque: 1.5 };
    flight(shortlisting, &someone, [drive, Wrench::default()], (20, 0.1))
}

/// Standing people with gaps, and one who runs into them. Within one communication step the push travels through bodies
/// that were not near anything moving when the step began.
fn row() -> Result<f64> {
    let worlds = along_row(0.55, 3.0, |_| {})?;
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

/// Returns 1 if the hash of a dense crowd differs from the expected one, else 0.
fn golden(side: u32, steps: u32, threads: usize, expected: u64) -> Result<f64> {
    let mut world = lattice(side, 0.4, 1e-5);
    world.shortlisting = Shortlisting::Off;
    world.set_threads(threads)?;
    ensure!(world.threads() == threads, "there are as many threads as asked for");
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
