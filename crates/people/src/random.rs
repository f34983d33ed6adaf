//! Random numbers: the same for the same seed on every machine.

use chacha20::ChaCha8Rng;
use chacha20::rand_core::{Rng, SeedableRng};
use lemons_core::distribution::inverse;
use lemons_core::plane::{Vec2, vec2};

/// The generator behind every draw of this crate: ChaCha8.
pub(crate) struct Random(ChaCha8Rng);

impl Random {
    pub(crate) fn new(seed: u64) -> Random {
        Random(ChaCha8Rng::seed_from_u64(seed))
    }

    /// A number evenly distributed between 0 and 1, both excluded: the middle of one of 2⁵² cells.
    pub(crate) fn inside_unit(&mut self) -> f64 {
        const CELL: f64 = 1.0 / (1u64 << 52) as f64;
        ((self.0.next_u64() >> 12) as f64 + 0.5) * CELL
    }

    /// A standard normal variable.
    pub(crate) fn normal(&mut self) -> f64 {
        inverse(self.inside_unit())
    }

    /// An index below `count`, which is not 0; the bias is below `count`/2⁶⁴.
    pub(crate) fn index(&mut self, count: usize) -> usize {
        ((u128::from(self.0.next_u64()) * count as u128) >> 64) as usize
    }

    /// A number in \[0, 1), a multiple of 2⁻⁵³.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// A number in \[−size, size).
    pub(crate) fn within(&mut self, size: f64) -> f64 {
        (2.0 * self.unit() - 1.0) * size
    }

    /// A vector in a square of this half width.
    pub(crate) fn vector(&mut self, size: f64) -> Vec2 {
        let (x, y) = (self.within(size), self.within(size));
        vec2(x, y)
    }

    /// An integer in 0..count. The bias of 2⁻⁵³ `count` does not matter for placing.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// A random order of 0..count (Fisher and Yates).
    pub(crate) fn order(&mut self, count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..count).collect();
        for k in (1..count).rev() {
            order.swap(k, self.below(k + 1));
        }
        order
    }
}
