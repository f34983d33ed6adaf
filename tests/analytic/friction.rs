//! The slider and the tangential spring.

use crate::support::*;
use crowd_mechanics::engine::*;

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
fn sticks_below_the_limit() {
    // μ |F_n| = 200 N. Loaded slowly: a sudden load would overshoot the limit.
    let mut world = dragged(0.0, 2.0);
    for step in 1..=400 {
        world.drive[0].force.x = 190.0 * f64::from(step.min(100)) / 100.0;
        world.advance(0.01).unwrap();
    }
    let contact = world.contacts().contacts[0];
    assert_eq!(contact.regime, Regime::Sticking);
    assert!((contact.tangential_force.abs() - 190.0).abs() < 1e-3, "{contact:?}");
    // The spring holds the drive, F = k_t s, and s is how far the disk went.
    let x = world.state().poses[0].position.x;
    assert!((x / (190.0 / BODIES.tangential_stiffness) - 1.0).abs() < 1e-4, "{x} m");
    assert_eq!(world.work().sliding, 0);
}

#[test]
fn slides_above_the_limit_at_mu_times_the_normal_force() {
    let mut world = dragged(300.0, 2.0);
    for step in 0..200 {
        world.advance(0.01).unwrap();
        if step > 10 {
            let contact = world.contacts().contacts[0];
            let ratio = contact.tangential_force.abs() / contact.normal_force.abs();
            assert!((ratio / BODIES.friction - 1.0).abs() < 1e-6, "{ratio}");
        }
    }
    assert!(world.work().sliding > 190_000);
    // The drag left over, 100 N, relaxes towards v = F τ / m.
    let v = world.state().twists[0].velocity.x;
    let expected = 100.0 / (80.0 * 2.0) * (1.0 - (-2.0f64 * 2.0).exp());
    assert!((v / expected - 1.0).abs() < 2e-3, "{v} m/s, expected {expected} m/s");
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

#[test]
fn a_disk_thrown_along_a_wall_ends_rolling() {
    // Without damping of the motion: sliding friction turns the disk until v = ω R (5/… of a disk: v = 2/3 v₀).
    let body = disk(80.0, 0.2);
    let law = PairLaw { friction: 0.4, normal_damping: 2000.0, ..BODIES };
    let rest = 0.2 - 500.0 / law.normal_stiffness;
    let mut world = world(
        &[body],
        &[wall(&[(-1.0, 0.0), (100.0, 0.0)])],
        law,
        &[(at(0.0, rest), moving(0.9, 0.0))],
        1e-5,
    );
    world.drive[0].force = vec2(0.0, -500.0);
    world.advance(1.0).unwrap();
    let twist = world.state().twists[0];
    assert!((twist.velocity.x - 0.6).abs() < 2e-3, "{twist:?}");
    assert!((twist.angular_velocity + twist.velocity.x / 0.2).abs() < 0.02, "{twist:?}");
}
