//! The laws know no place, direction, hand or order: random scenes, shrunk when they fail.

use crowd_mechanics::engine::*;
use lemons_core::plane::Motion;
use lemons_verify::checks::scenes::*;
use lemons_verify::checks::symmetry::Seen;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

/// A random scene: people on a jittered lattice between walls, of two materials.
#[derive(Debug, Clone)]
struct Case {
    people: Vec<Placed>,
    walls: Vec<WallSpec>,
    laws: [PairLaw; 3],
}

fn law(friction: f64) -> PairLaw {
    // Softer than a body, so that steps may be longer.
    PairLaw { normal_stiffness: 3e5, tangential_stiffness: 2e5, friction, ..BODIES }
}

prop_compose! {
    fn case()(
        people in prop::collection::vec(
            (40.0..110.0f64, 0.0..std::f64::consts::TAU, -0.04..0.04f64, -0.04..0.04f64, -1.0..1.0f64, -1.0..1.0f64, -2.0..2.0f64, 0..2usize),
            2..7,
        ),
        frictions in prop::array::uniform3(0.0..0.8f64),
    ) -> Case {
        let person = |(k, (mass, orientation, dx, dy, vx, vy, spin, material))| {
            let k: usize = k;
            let mut person = pedestrian(mass, 2.0).turned(orientation).moving(vx, vy).spinning(spin);
            person.body.disks.iter_mut().for_each(|disk| disk.material = material);
            person.at(0.45 * (k % 3) as f64 + dx, 0.45 * (k / 3) as f64 + dy)
        };
        let walls = [&[(-0.4, -0.4), (1.3, -0.35), (1.3, 1.0)][..], &[(-0.4, 1.0), (-0.4, -0.3)]];
        let wall = |corners: &[(f64, f64)]| {
            WallSpec { material: 0, corners: corners.iter().map(|&(x, y)| vec2(x, y)).collect() }
        };
        Case {
            people: people.into_iter().enumerate().map(person).collect(),
            walls: walls.map(wall).to_vec(),
            laws: frictions.map(law),
        }
    }
}

fn run(case: &Case) -> Vec<Motion> {
    let mut laws = LawTable::new(2);
    laws.set(0, 0, case.laws[0]);
    laws.set(0, 1, case.laws[1]);
    laws.set(1, 1, case.laws[2]);
    let bodies: Vec<BodySpec> = case.people.iter().map(|person| person.body.clone()).collect();
    let scene = Scene::new(&bodies, &case.walls, laws);
    let (poses, twists) = case.people.iter().map(|person| (person.pose, person.twist)).unzip();
    let mut world = World::new(scene, State::new(poses, twists), 5e-5).unwrap();
    for _ in 0..4 {
        world.advance(0.05).unwrap();
    }
    motions(&world)
}

fn apart(a: &[Motion], b: &[Motion]) -> f64 {
    let both = a.iter().map(|a| a.pose).zip(b.iter().map(|b| b.pose));
    both.map(|(a, b)| (a.position - b.position).norm().max((a.orientation - b.orientation).abs()))
        .fold(0.0, f64::max)
}

fn maps_back(case: &Case, place: impl Fn(Vec2) -> Vec2, angle: impl Fn(f64) -> f64, mirror: bool) -> f64 {
    let seen = Seen { place, angle, mirror };
    let mut there = case.clone();
    there.people.iter_mut().for_each(|person| *person = seen.person(person));
    for corner in there.walls.iter_mut().flat_map(|wall| &mut wall.corners) {
        *corner = (seen.place)(*corner);
    }
    let here: Vec<Motion> = run(case).into_iter().map(|motion| seen.motion(motion)).collect();
    apart(&here, &run(&there))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, failure_persistence: None, rng_seed: RngSeed::Fixed(7), ..ProptestConfig::default() })]

    #[test]
    fn of_place_direction_and_hand(case in case(), x in -9.0..9.0f64, y in -9.0..9.0f64, by in -3.0..3.0f64) {
        prop_assert!(maps_back(&case, |v| v + vec2(x, y), |a| a, false) < 1e-9, "place");
        prop_assert!(maps_back(&case, |v| v.rotated(Rotation::by(by)), |a| a + by, false) < 1e-9, "direction");
        prop_assert!(maps_back(&case, |v| vec2(v.x, -v.y), |a| -a, true) < 1e-9, "hand");
    }

    #[test]
    fn of_order(case in case()) {
        let here = run(&case);
        let mut other = case.clone();
        other.people.reverse();
        let mut there = run(&other);
        there.reverse();
        prop_assert!(apart(&here, &there) < 1e-9, "agents");
        let mut other = case.clone();
        other.walls.reverse();
        prop_assert!(apart(&here, &run(&other)) < 1e-9, "walls");
        let mut other = case.clone();
        for disk in other.people.iter_mut().flat_map(|person| &mut person.body.disks) {
            disk.material = 1 - disk.material;
        }
        other.walls.iter_mut().for_each(|wall| wall.material = 1 - wall.material);
        other.laws.reverse();
        prop_assert!(apart(&here, &run(&other)) < 1e-9, "materials");
    }
}
