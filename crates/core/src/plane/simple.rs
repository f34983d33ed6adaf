//! Polygons that meet themselves nowhere.

use crate::plane::{Ring, Vec2, segments_touch, turn};

type Side = (Vec2, Vec2);

impl Ring {
    /// Returns whether it has three sides or more, and they meet only where one follows the other. A ring with a corner
    /// that is not finite is not simple.
    ///
    /// The time grows as n log n while few sides overlap along x; at worst as n².
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
        turn(from, over, to) == 0.0 && (from - over).dot(to - over) > 0.0
    };
    let meet = |i: usize, j: usize| {
        let ((a, b), (c, d)) = (sides[i], sides[j]);
        match (follows(i, j), follows(j, i)) {
            (true, _) => back(i, j),
            (_, true) => back(j, i),
            _ => segments_touch(a, b, c, d),
        }
    };
    // Only sides that overlap along x can touch.
    let low = |k: usize| sides[k].0.x.min(sides[k].1.x);
    let mut order: Vec<usize> = (0..sides.len()).collect();
    order.sort_by(|&i, &j| low(i).total_cmp(&low(j)));
    order.iter().enumerate().find_map(|(place, &i)| {
        let high = sides[i].0.x.max(sides[i].1.x);
        let mut next = order[place + 1..].iter().take_while(|&&j| low(j) <= high);
        next.find(|&&j| meet(i, j)).map(|&j| [places[i], places[j]])
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::vec2;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

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
                turn(from, over, to) == 0.0 && (from - over).dot(to - over) > 0.0
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
