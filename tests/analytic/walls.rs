//! Nobody walks through a wall.

use crowd_mechanics::engine::*;
use lemons_verify::checks::scenes::*;

/// 80 kg, steady at 1 m/s, rates 2 /s, along y = 5, at a wall x = 2.
fn walker() -> World {
    let mut world = world(
        &[pedestrian(80.0, 2.0)],
        &[wall(&[(2.0, -10.0), (2.0, 10.0)])],
        CONCRETE,
        &[(at(0.0, 5.0), moving(1.0, 0.0))],
        1e-5,
    );
    world.drive[0].force = vec2(160.0, 0.0);
    world
}

/// The contact gives back nine tenths of the speed, so it takes some bounces to come to rest.
#[test]
fn the_walker_comes_to_rest_at_the_wall() {
    let mut world = walker();
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
