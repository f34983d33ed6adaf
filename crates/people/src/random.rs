//! Random numbers: the same for the same seed on every machine.

use crate::normal::inverse;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// The generator behind every draw of this crate.
pub type Generator = rand_chacha::ChaCha8Rng;

/// Returns the generator for a seed.
pub fn generator(seed: u64) -> Generator {
    Generator::seed_from_u64(seed)
}

/// A number evenly distributed between 0 and 1, both excluded: the middle of one of 2⁵² cells.
pub(crate) fn uniform<R: Rng + ?Sized>(rng: &mut R) -> f64 {
    const CELL: f64 = 1.0 / (1u64 << 52) as f64;
    ((rng.next_u64() >> 12) as f64 + 0.5) * CELL
}

/// A standard normal variable.
pub(crate) fn normal<R: Rng + ?Sized>(rng: &mut R) -> f64 {
    inverse(uniform(rng))
}

/// An index below `count`, which is not 0; the bias is below `count`/2⁶⁴.
pub(crate) fn place<R: Rng + ?Sized>(rng: &mut R, count: usize) -> usize {
    ((u128::from(rng.next_u64()) * count as u128) >> 64) as usize
}
