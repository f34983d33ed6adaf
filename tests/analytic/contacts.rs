//! Friction and walls.

use crowd_mechanics::engine::*;
use lemons_verify::checks::friction::{block, pressed};
use lemons_verify::checks::scenes::*;

#[test]
fn friction_opposes_the_motion_and_scales_with_mu() {
    for (friction, direction) in [(0.0, 1.0), (0.1, 1.0), (0.4, 1.0), (0.8, 1.0), (0.4, -1.0)] {
        let mut world = pressed(block().moving(direction, 0.0), PairLaw { friction, ..BODIES });
        world.advance(0.05).unwrap();
        let contact = world.contacts().contacts[0];
        let force = contact.normal.perp() * contact.tangential_force;
        assert!((force.x * direction + friction * 500.0).abs() < 0.5, "μ = {friction}: {force:?}");
    }
}

#[test]
fn a_protruding_corner_pushes_once() {
    let corner = [(-1.0, 0.0), (0.0, 0.0), (0.0, -1.0)];
    let mut world = world(&[disk(80.0, 0.2).at(0.1, 0.1)], &[&corner], CONCRETE, 1e-5);
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
        let thrown = disk(80.0, 0.2).at(0.5 * side, 0.0).moving(-2.0 * side, 0.0);
        let mut world = world(&[thrown], &[&[(0.0, -1.0), (0.0, 1.0)]], CONCRETE, 1e-5);
        world.advance(1.0).unwrap();
        assert!(world.state().poses[0].position.x * side > 0.2);
    }
}
