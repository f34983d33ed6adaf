//! Bodies in levels, and what presses them together.

use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;
use lemons_core::trial::{Heights, LOAD_LENGTH};

fn heights(bottom: f64, top: f64) -> Heights {
    Heights { bottom, top }
}

/// The world in which the disks of each body have heights; walls have all, if none are given.
fn in_levels(world: World, bodies: &[Vec<Heights>], walls: &[Heights], chests: &[Option<f64>]) -> World {
    let count = world.scene().wall_faces.len();
    let walls = if walls.is_empty() { vec![Heights::default(); count] } else { walls.to_vec() };
    let levels = Levels::new(LOAD_LENGTH, bodies, walls, chests);
    let scene = world.scene().clone().with_levels(levels);
    let mut of = World::new(scene, world.state().clone(), world.mechanical_step).unwrap();
    of.drive = world.drive.clone();
    of
}

/// A body of disks one above the other.
fn stack(mass: f64, radius: f64, count: usize) -> PlacedBody {
    let mut body = disk(mass, radius);
    body.body.disks = vec![body.body.disks[0].clone(); count];
    body
}

/// Slabs of equal heights from a height on.
fn slabs(from: f64, height: f64, count: usize) -> Vec<Heights> {
    let at = |k: usize| from + height * k as f64 / count as f64;
    (0..count).map(|k| heights(at(k), at(k + 1))).collect()
}

fn difference(one: &World, other: &World) -> f64 {
    let each = motions(one).into_iter().zip(motions(other));
    let apart = |(one, other): (lemons_core::plane::Motion, lemons_core::plane::Motion)| {
        (one.pose.position - other.pose.position).norm() + (one.twist.velocity - other.twist.velocity).norm()
    };
    each.map(apart).fold(0.0, f64::max)
}

/// The outside: the plan, whose law is that over the load length. Two stacks of any slabs of 0.1 m in all are it.
#[test]
fn stacks_are_as_one_disk() {
    let people = |count: usize| {
        let first = stack(80.0, 0.2, count).at(0.0, 0.02).moving(1.0, 0.2).relaxing(1.0, 2.0);
        [first, stack(60.0, 0.25, count).at(0.46, 0.0).spinning(2.0)]
    };
    let wall: &[&[(f64, f64)]] = &[&[(0.75, -1.0), (0.75, 0.0), (0.8, 1.0)]];
    let mut plan = world(&people(1), wall, BODIES, 1e-4);
    for count in [1, 2, 5] {
        let own = vec![slabs(1.0, LOAD_LENGTH, count); 2];
        let mut levels = in_levels(world(&people(count), wall, BODIES, 1e-4), &own, &[], &[None; 2]);
        let mut touched = 0;
        plan.restore(world(&people(1), wall, BODIES, 1e-4).state().clone()).unwrap();
        for _ in 0..60 {
            plan.advance(0.01).unwrap();
            levels.advance(0.01).unwrap();
            assert!(difference(&plan, &levels) < 1e-12, "{count}: {:e}", difference(&plan, &levels));
            touched += usize::from(plan.exposures()[0].mean_force > 0.0);
            for (one, other) in plan.exposures().iter().zip(levels.exposures()) {
                assert!((one.mean_force - other.mean_force).abs() <= 1e-9 * (1.0 + one.mean_force));
                assert!((one.mean_wall_force - other.mean_wall_force).abs() <= 1e-9 * (1.0 + one.mean_force));
            }
        }
        assert!(touched > 3, "they meet, and the wall");
    }
}

/// The outside: the plan with a law that is as many times stiffer.
#[test]
fn the_force_grows_with_the_common_height() {
    for top in [0.9, 1.0, 1.02, 1.1, 1.25, 1.4, 1.5, 2.0] {
        // The other one is from 1 m to 1.4 m.
        let share = ((top - 1.0f64).clamp(0.0, 0.4)) / LOAD_LENGTH;
        let people = || [disk(80.0, 0.2).moving(0.8, 0.1), disk(60.0, 0.2).at(0.41, 0.05)];
        let own = [vec![heights(0.5, top)], vec![heights(1.0, 1.4)]];
        let mut levels = in_levels(world(&people(), &[], BODIES, 1e-5), &own, &[], &[None; 2]);
        let law = PairLaw {
            normal_stiffness: BODIES.normal_stiffness * share,
            tangential_stiffness: BODIES.tangential_stiffness * share,
            normal_damping: BODIES.normal_damping * share,
            tangential_damping: BODIES.tangential_damping * share,
            ..BODIES
        };
        let mut plan = match share > 0.0 {
            true => world(&people(), &[], law, 1e-5),
            false => world(&people()[..1], &[], BODIES, 1e-5),
        };
        for _ in 0..10 {
            plan.advance(0.01).unwrap();
            levels.advance(0.01).unwrap();
            assert!(difference(&plan, &levels) < 1e-12, "{top} m: {:e}", difference(&plan, &levels));
        }
    }
}

/// A barrier of 1.1 m holds hips, not shoulders above it; a rail above heads holds nobody. Where a low wall goes on in a high
/// one, both end for those who touch both.
#[test]
fn walls_have_heights() {
    let walls: &[&[(f64, f64)]] = &[&[(1.0, -1.0), (1.0, 0.0)], &[(1.0, 0.0), (1.0, 1.0)]];
    let high = [heights(0.0, 1.1), heights(0.0, f64::INFINITY)];
    let reached = |own: Heights, y: f64| {
        let person = [disk(80.0, 0.2).at(0.5, y).moving(1.0, 0.0)];
        let mut of = in_levels(world(&person, walls, BODIES, 1e-4), &[vec![own]], &high, &[None]);
        for _ in 0..100 {
            of.advance(0.01).unwrap();
        }
        of.state().poses[0].position.x
    };
    assert!(reached(heights(0.8, 1.0), -0.5) < 0.8, "held by the barrier");
    assert!((reached(heights(1.2, 1.4), -0.5) - 1.5).abs() < 1e-12, "above it");
    assert!(reached(heights(1.2, 1.4), 0.5) < 0.8, "held by the wall");
    // At the end of the wall the barrier below does not cover its corner.
    assert!(reached(heights(1.2, 1.4), -0.05) < 0.8, "held by the corner");
}

/// The outside: conservation, and the dissipation that springs cannot make.
#[test]
fn random_stacks_keep_momentum_and_energy() {
    let mut random = Random(27);
    let mut met = 0;
    for case in 0..500 {
        let mut between = |low: f64, high: f64| random.within(low, high);
        let (mut people, mut own) = (Vec::new(), Vec::new());
        for k in 0..3 {
            let count = 1 + (case + k) % 3;
            let radius = between(0.1, 0.25);
            let mut person = stack(between(20.0, 90.0), radius, count)
                .at(0.5 * k as f64 + between(-0.05, 0.05), between(-0.1, 0.1))
                .moving(1.0 - k as f64 + between(-0.2, 0.2), between(-0.2, 0.2))
                .spinning(between(-2.0, 2.0));
            for disk in &mut person.body.disks {
                (disk.radius, disk.position) = (between(0.1, 0.2), vec2(between(-0.05, 0.05), 0.0));
            }
            people.push(person);
            own.push(slabs(between(0.0, 0.5), between(0.3, 1.2), count));
        }
        let mut of = in_levels(world(&people, &[], ELASTIC, 2e-5), &own, &[], &[None; 3]);
        let momentum = |of: &World| {
            let each = of.scene().bodies.iter().zip(motions(of));
            each.fold((vec2(0.0, 0.0), 0.0), |(sum, spin), (body, motion)| {
                let linear = motion.twist.velocity * body.mass;
                let angular = body.inertia * motion.twist.angular_velocity;
                (sum + linear, spin + angular + motion.pose.position.perp(&linear))
            })
        };
        let (before, start) = (momentum(&of), energy(&of));
        for _ in 0..30 {
            of.advance(0.01).unwrap();
            met += usize::from(of.contacts().agent_contacts > 0);
        }
        let (after, end) = (momentum(&of), energy(&of));
        assert!((after.0 - before.0).norm() < 1e-11 * 200.0, "case {case}");
        assert!((after.1 - before.1).abs() < 1e-11 * 200.0, "case {case}");
        assert!((end / start - 1.0).abs() < 2e-4, "case {case}: {start} -> {end}");
    }
    assert!(met > 500, "{met}");
}

/// The outside: F, of each of two walls; F of a row; of a corner F cos α along each axis.
#[test]
fn compression_has_closed_forms() {
    // Somebody between two walls, with a force towards each of them in turn: the walls press with F/2 more and less.
    let settle = |of: &mut World| (0..400).for_each(|_| of.advance(0.01).unwrap());
    let push = 300.0;
    // A row of three along x towards a wall: the first one has 3 F before and 2 F behind, at the same reach.
    let row: Vec<PlacedBody> =
        (0..3).map(|k| disk(80.0, 0.2).at(0.8 - 0.4 * k as f64, 0.0).relaxing(3.0, 3.0)).collect();
    let mut of = world(&row, &[&[(1.0, -1.0), (1.0, 1.0)]], BODIES, 1e-4);
    of.drive.iter_mut().for_each(|drive| drive.force.x = push);
    settle(&mut of);
    for (b, behind) in [2.0, 1.0, 0.0].into_iter().enumerate() {
        // −Σ r F = r (F before) + r (F behind), over 2 r.
        let expected = 0.5 * ((behind + 1.0) * push + behind * push);
        let found = of.compression(BodyId::from(b));
        assert!((found.front / expected - 1.0).abs() < 1e-3 && found.side.abs() < 1e-6, "{b}: {found:?}");
    }
    // Turned by a quarter, the same row presses the side.
    let turned: Vec<PlacedBody> =
        row.into_iter().map(|person| person.turned(std::f64::consts::FRAC_PI_2)).collect();
    let mut of = world(&turned, &[&[(1.0, -1.0), (1.0, 1.0)]], BODIES, 1e-4);
    of.drive.iter_mut().for_each(|drive| drive.force.x = push);
    settle(&mut of);
    let found = of.compression(BodyId(1));
    assert!((found.side / (1.5 * push) - 1.0).abs() < 1e-3 && found.front.abs() < 1e-6, "{found:?}");
    // In a corner each wall holds its part of the force; nothing is behind, so each counts half.
    let corner: &[&[(f64, f64)]] = &[&[(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]];
    let frictionless = PairLaw { friction: 0.0, ..BODIES };
    let mut of = world(&[disk(80.0, 0.2).at(0.8, 0.8).relaxing(3.0, 3.0)], corner, frictionless, 1e-4);
    of.drive[0].force = vec2(push * 0.6, push * 0.8);
    settle(&mut of);
    let found = of.compression(BodyId(0));
    let [least, most] = found.principal();
    assert!(
        (least / (0.3 * push) - 1.0).abs() < 1e-3 && (most / (0.4 * push) - 1.0).abs() < 1e-3,
        "{found:?}"
    );
}

/// Between two walls the chest has the mean of both forces, in every step, and what is above it does not count.
#[test]
fn a_chest_between_walls_has_their_force() {
    let walls: &[&[(f64, f64)]] = &[&[(0.199, -1.0), (0.199, 1.0)], &[(-0.199, -1.0), (-0.199, 1.0)]];
    let own = [vec![heights(1.0, 1.05), heights(1.05, 1.1)]];
    let person = [stack(80.0, 0.2, 2).relaxing(3.0, 3.0)];
    for (chest, share) in [(1.02, 0.5), (1.08, 0.5), (1.5, 0.0)] {
        let mut of = in_levels(world(&person, walls, CONCRETE, 1e-4), &own, &[], &[Some(chest)]);
        if share == 0.0 {
            assert!(of.chest_exposures().is_empty());
            continue;
        }
        let pressed = 0.001 * CONCRETE.normal_stiffness;
        let check = |found: ChestExposure| {
            let ChestExposure { people_force, wall_force, compression } = found;
            assert!((wall_force / (2.0 * share * pressed) - 1.0).abs() < 1e-9 && people_force == 0.0);
            // The contact points are where the walls are, within the extent of the disk.
            let expected = share * pressed * 0.199 / 0.2;
            assert!((compression.front / expected - 1.0).abs() < 3e-3, "{compression:?} {expected}");
        };
        check(of.chest_exposures()[0]);
        for _ in 0..3 {
            of.advance(0.01).unwrap();
            check(of.chest_exposures()[0]);
        }
        assert!((of.exposures()[0].mean_wall_force / (2.0 * pressed) - 1.0).abs() < 1e-9);
    }
}
