use super::super::vec2;
use super::*;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn scene(walls: &[&[(f64, f64)]]) -> Scene {
    let corners = |wall: &[(f64, f64)]| wall.iter().map(|&(x, y)| vec2(x, y)).collect();
    let walls: Vec<WallSpec> =
        walls.iter().map(|wall| WallSpec { material: 0, corners: corners(wall) }).collect();
    Scene::new(&[], &walls, LawTable::new(1))
}

fn lines(scene: &Scene) -> Vec<usize> {
    scene.faces.iter().map(|face| face.line.index()).collect()
}

#[test]
fn faces_of_a_wall_share_corners_and_straight_ones_are_of_one_line() {
    let closed = scene(&[&[(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (-0.0, 0.0)]]);
    assert_eq!(closed.corners.len(), 3);
    assert_eq!(closed.corners[0].faces, vec![FaceId(0), FaceId(2)]);
    let (sin, cos) = 19.99f64.to_radians().sin_cos();
    let (sine, cosine) = 20.01f64.to_radians().sin_cos();
    type Case<'a> = (&'a [(f64, f64)], &'a [usize]);
    let cases: [Case<'_>; 8] = [
        (&[(0.0, 0.0), (1.0, 0.0), (2.5, 0.0), (2.5, 1.0), (2.5, 7.0)], &[0, 0, 2, 2]),
        // Closed in the middle of a side.
        (&[(0.5, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.0, 0.0), (0.5, 0.0)], &[0, 1, 2, 3, 0]),
        // Up to 20° faces are one line.
        (&[(0.0, 0.0), (1.0, 0.0), (1.0 + cos, sin)], &[0, 0]),
        (&[(0.0, 0.0), (1.0, 0.0), (1.0 + cos, -sin)], &[0, 0]),
        (&[(0.0, 0.0), (1.0, 0.0), (1.0 + cosine, sine)], &[0, 1]),
        (&[(0.0, 0.0), (1.0, 0.0), (1.0 + cosine, -sine)], &[0, 1]),
        // There and back is one face; so is the third one, drawn backwards. The fourth meets them.
        (&[(0.0, 0.0), (1.0, 0.0), (0.0, 0.0)], &[0, 0]),
        (&[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (1.0, 0.0), (1.0, 1.0)], &[0, 0, 0, 3]),
    ];
    for (corners, expected) in cases {
        assert_eq!(lines(&scene(&[corners])), expected, "{corners:?}");
    }
}

#[test]
fn walls_that_meet_or_lie_on_each_other_are_one() {
    // End to end, the second one drawn towards the first, with a rounding error; then one that turns.
    let met =
        scene(&[&[(0.0, 0.0), (1.0, 0.0)], &[(2.0, 0.0), (1.0 + 1e-16, 3e-17)], &[(2.0, 0.0), (2.0, 1.0)]]);
    assert_eq!(lines(&met), [0, 0, 2]);
    assert_eq!((met.corners.len(), met.doubled.len()), (4, 0));
    assert_eq!(met.faces[1].after, Continuation::Straight);
    // The same twice, backwards; a part of it; and one that overlaps it.
    let doubled = scene(&[
        &[(0.0, 0.0), (3.0, 0.0)],
        &[(3.0, 0.0), (0.0, 0.0)],
        &[(1.0, 0.0), (2.0, 0.0)],
        &[(2.5, 0.0), (4.0, 0.0)],
    ]);
    assert_eq!(lines(&doubled), [0, 0, 0, 0]);
    let pairs: Vec<_> = doubled.doubled.iter().map(|(one, other)| (one.index(), other.index())).collect();
    assert_eq!(pairs, [(0, 1), (0, 2), (0, 3), (1, 3)]);
    // One that ends on another, without lying on it.
    let tee = scene(&[&[(0.0, 0.0), (2.0, 0.0)], &[(1.0, 0.0), (1.0, 1.0)]]);
    assert_eq!((lines(&tee), tee.doubled.len()), (vec![0, 1], 0));
    assert!(tee.corners[2].covered && !tee.corners[3].covered);
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(5), ..ProptestConfig::default() })]

    /// The outside: all pairs that overlap, one by one. A disk that touches both touches faces that join them.
    #[test]
    fn a_few_pairs_join_all_that_lie_on_each_other(
        all in prop::collection::vec((0..12i32, 1..7i32, any::<bool>()), 1..16),
        angle in prop::sample::select(vec![0.0, 0.7, 1.5, 2.9]),
    ) {
        let place = |x: i32| (f64::from(x) * f64::cos(angle), f64::from(x) * f64::sin(angle));
        let ends = |&(from, length, back): &(i32, i32, bool)| {
            let ends = [place(from), place(from + length)];
            if back { [ends[1], ends[0]] } else { ends }
        };
        let walls: Vec<[(f64, f64); 2]> = all.iter().map(ends).collect();
        let scene = scene(&walls.iter().map(|wall| &wall[..]).collect::<Vec<_>>());
        prop_assert!(scene.doubled.len() <= 3 * all.len());
        for quarter in 0..76 {
            // In quarters: so far the disk reaches.
            let touched = |k: usize| {
                let (from, length, _) = all[k];
                4 * from <= quarter + 1 && 4 * (from + length) >= quarter - 1
            };
            for first in (0..all.len()).filter(|k| touched(*k)) {
                let mut reached = vec![first];
                let mut next = 0;
                while let Some(&face) = reached.get(next) {
                    next += 1;
                    for other in scene.joined[face].iter().map(|other| other.index()) {
                        if touched(other) && !reached.contains(&other) {
                            reached.push(other);
                        }
                    }
                }
                let (from, length, _) = all[first];
                for other in (0..all.len()).filter(|k| touched(*k)) {
                    let overlap = from < all[other].0 + all[other].1 && all[other].0 < from + length;
                    prop_assert!(!overlap || reached.contains(&other), "{first} and {other} at {quarter}");
                }
            }
        }
    }
}

/// Rounding of the nearest points of two faces that lie on each other would choose between their materials.
#[test]
fn the_first_of_doubled_faces_gives_the_material() {
    let ends = vec![vec2(0.1, 0.0), vec2(3.7, 1.3)];
    let back = ends.iter().rev().copied().collect();
    let specs = [WallSpec { material: 1, corners: ends }, WallSpec { material: 0, corners: back }];
    let scene = Scene::new(&[], &specs, LawTable::new(2));
    assert_eq!([scene.faces[0].material, scene.faces[1].material], [1, 1]);
}
