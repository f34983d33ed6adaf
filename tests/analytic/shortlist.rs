//! Free motion, and the proof that nothing is missed.

use crate::support::*;
use crowd_mechanics::engine::*;

#[test]
fn relaxation_follows_the_closed_form_shortlisted_or_not() {
    let mut body = pedestrian(70.0, 0.0);
    body.translation_rate = 4.5;
    body.rotation_rate = 3.0;
    for shortlisting in [Shortlisting::On, Shortlisting::Off] {
        let start = Twist { velocity: vec2(1.2, -0.4), angular_velocity: 2.0 };
        let mut world = world(std::slice::from_ref(&body), &[], BODIES, &[(at(0.0, 0.0), start)], 1e-5);
        world.shortlisting = shortlisting;
        world.drive[0] = Wrench { force: vec2(50.0, 20.0), torque: 1.5 };
        let inertia = world.scene().bodies[0].inertia;
        let mut worst: f64 = 0.0;
        for step in 1..=20 {
            world.advance(0.1).unwrap();
            let t = 0.1 * f64::from(step);
            let (steady, decay) = (vec2(50.0, 20.0) * (1.0 / (70.0 * 4.5)), (-4.5 * t).exp());
            let velocity = steady + (start.velocity - steady) * decay;
            let place = steady * t + (start.velocity - steady) * ((1.0 - decay) / 4.5);
            let (spin, decay) = (1.5 / (inertia * 3.0), (-3.0 * t).exp());
            let omega = spin + (2.0 - spin) * decay;
            let theta = spin * t + (2.0 - spin) * (1.0 - decay) / 3.0;
            let (pose, twist) = (world.state().poses[0], world.state().twists[0]);
            for error in [
                (pose.position - place).norm(),
                (twist.velocity - velocity).norm(),
                (pose.orientation - theta).abs(),
                (twist.angular_velocity - omega).abs(),
            ] {
                worst = worst.max(error);
            }
        }
        assert!(worst < 1e-10, "{shortlisting:?}: {worst}");
        let shortlisted = world.work().shortlisted;
        assert_eq!(shortlisted > 0, shortlisting == Shortlisting::On);
    }
}

/// A row of standing people with gaps, and one who runs into it: within one long communication step the
/// push goes through bodies that nothing pointed at when the step began.
fn row(shortlisting: Shortlisting) -> World {
    let bodies: Vec<BodySpec> = (0..6).map(|_| disk(70.0, 0.2)).collect();
    let mut motions: Vec<(Pose, Twist)> =
        (0..6).map(|k| (at(0.55 * f64::from(k), 0.0), moving(0.0, 0.0))).collect();
    motions[0].1 = moving(3.0, 0.0);
    let mut world = world(&bodies, &[], ELASTIC, &motions, 1e-5);
    world.shortlisting = shortlisting;
    world
}

#[test]
fn a_push_through_a_row_within_one_step_is_not_missed() {
    let (mut with, mut without) = (row(Shortlisting::On), row(Shortlisting::Off));
    with.advance(0.5).unwrap();
    without.advance(0.5).unwrap();
    // Equal masses: the last one leaves with the first one's velocity.
    assert!((with.state().twists[5].velocity.x - 3.0).abs() < 1e-3);
    for (a, b) in with.state().poses.iter().zip(&without.state().poses) {
        assert!((a.position - b.position).norm() < 1e-9);
    }
}

#[test]
fn people_apart_need_no_mechanical_step() {
    let bodies: Vec<BodySpec> = (0..100).map(|_| pedestrian(70.0, 4.5)).collect();
    let motions: Vec<(Pose, Twist)> =
        (0..100).map(|k| (at(2.0 * f64::from(k % 10), 2.0 * f64::from(k / 10)), moving(1.0, 0.5))).collect();
    let mut world = world(&bodies, &[wall(&[(-5.0, -5.0), (30.0, -5.0)])], BODIES, &motions, 1e-5);
    world.advance(0.1).unwrap();
    assert_eq!(world.work().steps, 0);
    assert_eq!(world.work().shortlisted, 100);
}

#[test]
fn a_dense_crowd_is_the_same_with_and_without() {
    let mut worlds = [Shortlisting::On, Shortlisting::Off].map(|shortlisting| {
        let bodies: Vec<BodySpec> = (0..64).map(|_| pedestrian(70.0, 4.5)).collect();
        let motions: Vec<(Pose, Twist)> = (0..64)
            .map(|k| {
                let (x, y) = (f64::from(k % 8), f64::from(k / 8));
                let orientation = 0.7 * f64::from(k);
                let pose = Pose { position: vec2(0.6 * x, 0.6 * y), orientation };
                (pose, moving((1.3 * f64::from(k)).sin(), (2.1 * f64::from(k)).cos()))
            })
            .collect();
        let mut world = world(&bodies, &[wall(&[(-1.0, -0.5), (8.0, -0.5)])], BODIES, &motions, 1e-4);
        world.shortlisting = shortlisting;
        world
    });
    for _ in 0..10 {
        for world in &mut worlds {
            world.advance(0.05).unwrap();
        }
    }
    let worst = worlds[0]
        .state()
        .poses
        .iter()
        .zip(&worlds[1].state().poses)
        .map(|(a, b)| (a.position - b.position).norm())
        .fold(0.0, f64::max);
    assert!(worlds[0].work().shortlisted > 0);
    assert!(worst < 1e-9, "{worst}");
}

#[test]
fn restored_in_the_middle_of_a_contact_it_gives_the_same_bits() {
    let mut world = world(
        &[pedestrian(89.0, 4.5), pedestrian(60.0, 4.5)],
        &[wall(&[(0.9, -2.0), (0.9, 2.0)])],
        BODIES,
        &[
            (at(0.0, 0.0), Twist { velocity: vec2(1.5, 0.1), angular_velocity: 0.7 }),
            (Pose { position: vec2(0.4, 0.22), orientation: 1.1 }, moving(-0.5, 0.0)),
        ],
        1e-5,
    );
    while world.contacts().agent_contacts == 0 {
        world.advance(0.001).unwrap();
    }
    let saved = world.state().clone();
    let mut other = World::new(world.scene().clone(), saved.clone(), 1e-5);
    assert_eq!(*other.state(), saved);
    for _ in 0..300 {
        world.advance(0.001).unwrap();
        other.advance(0.001).unwrap();
        assert_eq!(world.state(), other.state());
        assert_eq!(world.contacts(), other.contacts());
    }
}

#[test]
fn a_failed_step_changes_nothing() {
    let mut world = world(
        &[disk(80.0, 0.2), disk(80.0, 0.2)],
        &[],
        BODIES,
        &[(at(0.0, 0.0), moving(0.0, 0.0)), (at(0.3, 0.0), moving(0.0, 0.0))],
        1e-5,
    );
    world.advance(1e-3).unwrap();
    let before = (world.state().clone(), world.contacts().clone());
    world.drive[1].force = vec2(f64::MAX, f64::MAX);
    world.mechanical_step = 1.0;
    assert_eq!(world.advance(1e3), Err(AdvanceError::NotFinite { body: BodyId(1) }));
    assert_eq!((world.state().clone(), world.contacts().clone()), before);
    world.drive[1].force = Vec2::ZERO;
    world.mechanical_step = 1e-5;
    world.advance(1e-3).unwrap();
}
