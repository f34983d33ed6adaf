//! Nobody walks through a wall.

use crate::support::*;
use crowd_mechanics::engine::*;

/// The paper's body on concrete (App. C).
const CONCRETE: PairLaw = PairLaw {
    normal_stiffness: 4_987_000.0,
    tangential_stiffness: 3_530_000.0,
    normal_damping: 1230.0,
    tangential_damping: 1230.0,
    friction: 0.5,
};

/// The walker of PHYSICS.md: 80 kg, steady at `speed`, rates 2 /s, along y = 5, at a wall x = 2.
fn walker(speed: f64, wall_from: f64, wall_to: f64) -> World {
    let mut world = world(
        &[pedestrian(80.0, 2.0)],
        &[wall(&[(2.0, wall_from), (2.0, wall_to)])],
        CONCRETE,
        &[(at(0.0, 5.0), moving(speed, 0.0))],
        1e-5,
    );
    world.drive[0].force = vec2(80.0 * 2.0 * speed, 0.0);
    world
}

/// The contact gives back nine tenths of the speed, so it takes some bounces to come to rest.
fn assert_stops(mut world: World) {
    for _ in 0..150 {
        world.advance(0.1).unwrap();
        assert!(world.state().poses[0].position.x < 2.0);
    }
    let pose = world.state().poses[0];
    assert!(pose.position.x > 1.7, "stands at the wall: {pose:?}");
    assert!(world.contacts().wall_contacts > 0);
    assert!(world.state().twists[0].velocity.norm() < 0.05);
}

#[test]
fn the_walker_stops() {
    assert_stops(walker(1.0, -10.0, 10.0));
}

#[test]
fn at_twenty_metres_a_second_too() {
    let mut world = walker(20.0, -10.0, 10.0);
    for _ in 0..40 {
        world.advance(0.1).unwrap();
        assert!(world.state().poses[0].position.x < 2.0);
    }
    assert!(world.contacts().wall_contacts > 0);
}

#[test]
fn at_a_wall_two_hundred_metres_long() {
    assert_stops(walker(1.0, -100.0, 100.0));
}

#[test]
fn a_straight_wall_in_two_pieces_acts_like_one() {
    let press = |corners: &[(f64, f64)]| {
        let mut world = world(
            &[disk(80.0, 0.2)],
            &[wall(corners)],
            PairLaw { friction: 0.0, ..CONCRETE },
            &[(at(-0.3, 0.199), moving(0.5, 0.0))],
            1e-5,
        );
        world.drive[0].force = vec2(0.0, -500.0);
        world.advance(1.0).unwrap();
        world.state().poses[0]
    };
    let whole = press(&[(-1.0, 0.0), (1.0, 0.0)]);
    let pieces = press(&[(-1.0, 0.0), (0.0, 0.0), (1.0, 0.0)]);
    assert!((whole.position - pieces.position).norm() < 1e-12);
}

#[test]
fn a_protruding_corner_pushes_once() {
    let mut world = world(
        &[disk(80.0, 0.2)],
        &[wall(&[(-1.0, 0.0), (0.0, 0.0), (0.0, -1.0)])],
        CONCRETE,
        &[(at(0.1, 0.1), moving(0.0, 0.0))],
        1e-5,
    );
    assert_eq!(world.contacts().wall_contacts, 1);
    let contact = world.contacts().contacts[0];
    let diagonal = 0.5f64.sqrt();
    assert!((contact.normal - vec2(diagonal, diagonal)).norm() < 1e-15);
    assert!((contact.depth - (0.2 - 0.1 * 2f64.sqrt())).abs() < 1e-15);
    world.advance(0.1).unwrap();
    let velocity = world.state().twists[0].velocity;
    assert!((velocity.x - velocity.y).abs() < 1e-12 && velocity.x > 0.0);
}

#[test]
fn walls_are_solid_from_both_sides() {
    for side in [1.0, -1.0] {
        let mut world = world(
            &[disk(80.0, 0.2)],
            &[wall(&[(0.0, -1.0), (0.0, 1.0)])],
            CONCRETE,
            &[(at(0.5 * side, 0.0), moving(-2.0 * side, 0.0))],
            1e-5,
        );
        world.advance(1.0).unwrap();
        assert!(world.state().poses[0].position.x * side > 0.2);
    }
}
