//! Bits that are the same on every machine, for any number of threads.

use crate::checks::{Figure, Result, ensure};
use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;

pub(crate) const FIGURES: &[Figure] =
    &[|| golden(12, 1000, &[1], GOLDEN), || golden(34, 300, &[1, 2, 3], GOLDEN_OF_BLOCKS)];

/// Hash of the state of a dense crowd of 144 after 1000 mechanical steps, in debug and release builds, on every
/// machine. If it changes, results change: the CHANGELOG must say by how much.
const GOLDEN: u64 = 0x65ba_a920_4c80_73c6;

/// The same for a crowd of 1156 after 300 steps, whose blocks are shared among threads.
const GOLDEN_OF_BLOCKS: u64 = 0x738d_454e_60cd_4ce7;

/// Returns the number of thread counts for which the hash of a dense crowd differs from the expected one.
fn golden(side: u32, steps: u32, threads: &[usize], expected: u64) -> Result<f64> {
    let mut unlike = 0;
    for &threads in threads {
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
        unlike += u32::from(hash != expected);
    }
    Ok(f64::from(unlike))
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
