//! Polygons that meet themselves nowhere.

use crate::plane::{Bounds, InPlane, Ring, Vec2, segments_touch, turn};

type Side = (Vec2, Vec2);

impl Ring {
    /// Returns whether it has three sides or more, and they meet only where one follows the other. A ring with a corner
    /// that is not finite is not simple.
    ///
    /// The time grows as n log n while few sides overlap along the longer side of their bounds; at worst as n².
    pub fn is_simple(&self) -> bool {
        let finite = self.closed().iter().all(|corner| corner.is_finite());
        finite && self.corners().len() >= 3 && sides_that_meet(std::slice::from_ref(self)).is_none()
    }
}

/// Returns two sides, each by its ring and its number, that meet elsewhere than at the corner where one follows the
/// other; `None` if there are none. Corners are finite, and rings have three sides or more.
pub fn sides_that_meet(rings: &[Ring]) -> Option<[(usize, usize); 2]> {
    let of_ring =
        |(ring, of): (usize, &Ring)| of.sides().enumerate().map(move |(k, side)| ((ring, k), side)).collect();
    let (places, sides): (Vec<(usize, usize)>, Vec<Side>) =
        rings.iter().enumerate().flat_map::<Vec<_>, _>(of_ring).unzip();
    let follows = |i: usize, j: usize| {
        let ((ring, side), next) = (places[i], places[j]);
        next == (ring, (side + 1) % rings[ring].corners().len())
    };
    // Who follows shares a corner, and more only if it goes back along the other.
    let back = |i: usize, j: usize| {
        let ((from, over), (_, to)) = (sides[i], sides[j]);
        turn(from, over, to) == 0.0 && (from - over).dot(&(to - over)) > 0.0
    };
    let meet = |i: usize, j: usize| {
        let ((a, b), (c, d)) = (sides[i], sides[j]);
        match (follows(i, j), follows(j, i)) {
            (true, _) => back(i, j),
            (_, true) => back(j, i),
            _ => segments_touch(a, b, c, d),
        }
    };
    first_beside(&sides, meet).map(|pair| pair.map(|side| places[side]))
}

/// Returns the first two sides for which `meet` holds, of those that overlap along the longer side of their bounds. No
/// others can touch.
pub(super) fn first_beside(sides: &[Side], mut meet: impl FnMut(usize, usize) -> bool) -> Option<[usize; 2]> {
    let along = Bounds::of(sides.iter().map(|side| side.0))?.longer();
    let ends = |(k, (a, b)): (usize, &Side)| (along(*a).min(along(*b)), along(*a).max(along(*b)), k);
    let mut ranges: Vec<(f64, f64, usize)> = sides.iter().enumerate().map(ends).collect();
    ranges.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranges.iter().enumerate().find_map(|(place, &(_, high, i))| {
        let mut next = ranges[place + 1..].iter().take_while(|(low, ..)| *low <= high);
        next.find(|&&(_, _, j)| meet(i, j)).map(|&(_, _, j)| [i, j])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::vec2;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;
    use std::f64::consts::TAU;

    fn ring(corners: impl IntoIterator<Item = (f64, f64)>) -> Ring {
        Ring::through(corners.into_iter().map(|(x, y)| vec2(x, y)).collect()).unwrap()
    }

    /// By the definition: all pairs.
    fn meets_itself(ring: &Ring) -> bool {
        let sides: Vec<Side> = ring.sides().collect();
        let n = sides.len();
        let meet = |i: usize, j: usize| {
            let ((a, b), (c, d)) = (sides[i], sides[j]);
            if j == i + 1 || (i == 0 && j + 1 == n) {
                let (from, over, to) = if j == i + 1 { (a, b, d) } else { (c, a, b) };
                turn(from, over, to) == 0.0 && (from - over).dot(&(to - over)) > 0.0
            } else {
                segments_touch(a, b, c, d)
            }
        };
        n < 3 || (0..n).any(|i| (i + 1..n).any(|j| meet(i, j)))
    }

    #[test]
    fn simple_is_what_meets_itself_nowhere() {
        for (corners, simple) in [
            (&[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)][..], true),
            (&[(0.0, 0.0), (1.0, 0.0)], false),
            (&[(0.0, 0.0)], false),
            // Back along a side; a straight corner.
            (&[(0.0, 0.0), (2.0, 0.0), (1.0, 0.0), (1.0, 1.0)], false),
            (&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 1.0)], true),
            (&[(0.0, 0.0), (1.0, 0.0), (f64::NAN, 1.0), (0.0, 1.0)], false),
        ] {
            assert_eq!(ring(corners.iter().copied()).is_simple(), simple, "{corners:?}");
        }
    }

    /// Teeth of a comb along y: `count` times up and down.
    fn comb(count: u32) -> Vec<(f64, f64)> {
        let tooth =
            |k: u32| [(0.0, 0.0), (0.2, 9.0), (0.4, 9.0), (0.6, 0.0)].map(|(x, y)| (x + f64::from(k), y));
        let end = f64::from(count);
        (0..count).flat_map(tooth).chain([(end, 0.0), (end, -1.0), (0.0, -1.0)]).collect()
    }

    #[test]
    fn few_pairs_of_many_sides_are_looked_at() {
        let angle = |k: u32| TAU * f64::from(k) / 10_000.0;
        let circle = (0..10_000).map(|k| (angle(k).cos(), angle(k).sin())).collect();
        let upright = comb(2500);
        let lying = upright.iter().map(|&(x, y)| (y, x)).collect();
        for corners in [circle, upright, lying] {
            let ring = ring(corners);
            let mut pairs = 0;
            let sides: Vec<Side> = ring.sides().collect();
            first_beside(&sides, |_, _| {
                pairs += 1;
                false
            });
            assert!(ring.is_simple() && pairs < 4 * sides.len(), "{pairs} pairs of {} sides", sides.len());
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 4000, rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

        /// On a small lattice corners touch, lie on sides and on each other; nothing is rounded.
        #[test]
        fn rings_on_a_lattice_are_simple_by_all_pairs(
            corners in prop::collection::vec((0i32..6, 0i32..6), 3..9),
        ) {
            let ring = ring(corners.iter().map(|&(x, y)| (f64::from(x), f64::from(y))));
            prop_assert_eq!(ring.is_simple(), !meets_itself(&ring));
        }
    }
}
