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

/// A rail before a wall does not hide it: each acts by its own height. Without heights only the deeper one does.
#[test]
fn walls_of_different_heights_act_each_for_itself() {
    let walls: &[&[(f64, f64)]] = &[&[(0.995, -1.0), (0.995, 1.0)], &[(1.0, -1.0), (1.0, 1.0)]];
    let person = [disk(80.0, 0.2).at(0.81, 0.0)];
    let own = [vec![heights(0.95, 1.05)]];
    let high = [heights(1.0, 1.01), heights(0.0, f64::INFINITY)];
    let of = in_levels(world(&person, walls, ELASTIC, 1e-4), &own, &high, &[None]);
    let forces: Vec<f64> = of.contacts().contacts.iter().map(|contact| contact.normal_force).collect();
    let expected = [0.1 * 0.015, 0.010].map(|depth| ELASTIC.normal_stiffness * depth);
    assert!(
        forces.len() == 2 && forces.iter().zip(expected).all(|(found, it)| (found / it - 1.0).abs() < 1e-9)
    );
}
