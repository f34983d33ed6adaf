//! The slider and the tangential spring.

use crowd_mechanics::engine::*;
use lemons_verify::checks::scenes::*;

/// A disk pressed on the wall y = 0 by 500 N and dragged along it; it does not turn (huge inertia).
fn dragged(force: f64, rate: f64) -> World {
    let mut body = disk(80.0, 0.2);
    body.inertia = 1e12;
    body.translation_rate = rate;
    let rest = 0.2 - 500.0 / BODIES.normal_stiffness;
    let mut world = world(
        &[body],
        &[wall(&[(-100.0, 0.0), (100.0, 0.0)])],
        BODIES,
        &[(at(0.0, rest), moving(0.0, 0.0))],
        1e-5,
    );
    world.drive[0].force = vec2(force, -500.0);
    world
}

#[test]
fn friction_opposes_the_motion_both_ways() {
    for direction in [1.0, -1.0] {
        let mut world = dragged(300.0 * direction, 2.0);
        world.advance(0.5).unwrap();
        let contact = world.contacts().contacts[0];
        let force = contact.normal.perp() * contact.tangential_force;
        assert!(force.x * direction < 0.0);
        assert!(world.state().twists[0].velocity.x * direction > 0.0);
    }
}

#[test]
fn the_law_scales_with_mu() {
    let sliding_force = |friction: f64| {
        let mut body = disk(80.0, 0.2);
        body.inertia = 1e12;
        let law = PairLaw { friction, ..BODIES };
        let rest = 0.2 - 500.0 / law.normal_stiffness;
        let mut world = world(
            &[body],
            &[wall(&[(-100.0, 0.0), (100.0, 0.0)])],
            law,
            &[(at(0.0, rest), moving(1.0, 0.0))],
            1e-5,
        );
        world.drive[0].force = vec2(0.0, -500.0);
        world.advance(0.05).unwrap();
        world.contacts().contacts[0].tangential_force.abs()
    };
    for friction in [0.0, 0.1, 0.4, 0.8] {
        assert!((sliding_force(friction) - friction * 500.0).abs() < 0.5, "μ = {friction}");
    }
}
