//! Collisions without friction.

use crate::support::*;
use crowd_mechanics::engine::*;
use std::f64::consts::PI;

/// 100 kg at 1 m/s on 50 kg at rest, head on, elastic.
fn head_on(law: PairLaw, mechanical_step: f64) -> World {
    world(
        &[disk(100.0, 0.25), disk(50.0, 0.2)],
        &[],
        law,
        &[(at(0.0, 0.0), moving(1.0, 0.0)), (at(0.46, 0.0), moving(0.0, 0.0))],
        mechanical_step,
    )
}

#[test]
fn head_on_collision_keeps_momentum_and_energy() {
    let mut world = head_on(ELASTIC, 1e-5);
    for _ in 0..10 {
        let before = momentum(&world);
        world.advance(0.01).unwrap();
        assert!((momentum(&world) - before).norm() <= 1e-12 * before.norm());
    }
    let velocities: Vec<f64> = world.state().twists.iter().map(|twist| twist.velocity.x).collect();
    assert!((velocities[0] - 1.0 / 3.0).abs() < 1e-6, "{velocities:?}");
    assert!((velocities[1] - 4.0 / 3.0).abs() < 1e-6, "{velocities:?}");
    assert!(world.work().contacts > 0);
}

#[test]
fn contact_lasts_half_a_period_of_the_spring() {
    let dt = 1e-5;
    let mut world = head_on(ELASTIC, dt);
    let reduced = 100.0 * 50.0 / 150.0;
    let expected = PI / (ELASTIC.normal_stiffness / reduced).sqrt();
    let touching = (0..10_000)
        .filter(|_| {
            world.advance(dt).unwrap();
            world.contacts().agent_contacts == 1
        })
        .count();
    let duration = touching as f64 * dt;
    assert!((duration / expected - 1.0).abs() < 1e-3, "{duration} s, expected {expected} s");
}

#[test]
fn damped_collision_has_the_restitution_of_the_oscillator() {
    // Kelvin–Voigt, unclamped: the contact ends where the damped oscillator comes back to h = 0.
    let law = PairLaw { normal_damping: 1500.0, ..ELASTIC };
    let mut world = head_on(law, 1e-6);
    world.advance(0.1).unwrap();
    let reduced = 100.0 * 50.0 / 150.0;
    let decay = law.normal_damping / (2.0 * reduced);
    let pulsation = (law.normal_stiffness / reduced - decay * decay).sqrt();
    let restitution = (-decay * PI / pulsation).exp();
    let twists = &world.state().twists;
    let parting = twists[1].velocity.x - twists[0].velocity.x;
    assert!((parting - restitution).abs() < 1e-4, "{parting} m/s, expected {restitution} m/s");
}

#[test]
fn glancing_collision_of_pedestrians_keeps_momentum_and_angular_momentum() {
    let mut world = world(
        &[pedestrian(89.0, FREE), pedestrian(60.0, FREE)],
        &[],
        BODIES,
        &[
            (at(0.0, 0.0), Twist { velocity: vec2(1.5, 0.1), angular_velocity: 0.7 }),
            (Pose { position: vec2(0.4, 0.22), orientation: 1.1 }, moving(-0.5, 0.0)),
        ],
        1e-5,
    );
    let (p, l) = (momentum(&world), angular_momentum(&world));
    let mut touched = false;
    for _ in 0..50 {
        world.advance(0.01).unwrap();
        touched |= world.contacts().agent_contacts > 0;
        assert!((momentum(&world) - p).norm() <= 1e-12 * p.norm());
        assert!((angular_momentum(&world) - l).abs() <= 1e-9 * l.abs());
    }
    assert!(touched && world.contacts().agent_contacts == 0);
}

#[test]
fn mechanical_step_is_second_order_while_a_contact_lasts() {
    // Damped, from just inside the contact to well before its end; the exact motion is the damped
    // oscillator's. The same table without damping has the same order.
    let law = PairLaw { normal_damping: 900.0, ..ELASTIC };
    let reduced = 100.0 * 50.0 / 150.0;
    let decay = law.normal_damping / (2.0 * reduced);
    let pulsation = (law.normal_stiffness / reduced - decay * decay).sqrt();
    let (depth, speed, time) = (1e-4, 1.0, 0.008_192);
    let (sin, cos) = (pulsation * time).sin_cos();
    // h'' + 2 decay h' + (k/m*) h = 0, h(0) = depth, h'(0) = speed
    let swing = (speed + decay * depth) / pulsation;
    let decayed = (-decay * time).exp();
    let exact = decayed * (depth * cos + swing * sin);
    let exact_speed =
        decayed * ((pulsation * swing - decay * depth) * cos - (pulsation * depth + decay * swing) * sin);
    println!("    dt [s]  error of h, h'/pulsation [m]   ratio");
    let mut last: Option<f64> = None;
    for halvings in 0..6 {
        let dt = 1.28e-4 / f64::from(1 << halvings);
        let mut world = world(
            &[disk(100.0, 0.25), disk(50.0, 0.2)],
            &[],
            law,
            &[(at(0.0, 0.0), moving(speed, 0.0)), (at(0.45 - depth, 0.0), moving(0.0, 0.0))],
            dt,
        );
        world.advance(time).unwrap();
        let twists = &world.state().twists;
        let closing = twists[0].velocity.x - twists[1].velocity.x;
        let error = (world.contacts().largest_overlap() - exact).hypot((closing - exact_speed) / pulsation);
        match last {
            Some(last) => println!("{dt:10.3e} {error:14.4e} {:9.3}", last / error),
            None => println!("{dt:10.3e} {error:14.4e}"),
        }
        if let Some(last) = last {
            let ratio: f64 = last / error;
            assert!((3.6..4.4).contains(&ratio), "error fell by {ratio}");
        }
        last = Some(error);
    }
}

#[test]
fn elastic_energy_comes_back_to_second_order() {
    let lost = |dt: f64| {
        let mut world = head_on(ELASTIC, dt);
        world.advance(0.1).unwrap();
        (kinetic_energy(&world) / 50.0 - 1.0).abs()
    };
    assert!(lost(1e-5) < 1e-6);
    assert!(lost(1e-4) < 1e-4);
}

#[test]
fn coincident_centres_push_nobody_and_are_counted() {
    let mut world = world(
        &[disk(80.0, 0.2), disk(80.0, 0.2)],
        &[],
        ELASTIC,
        &[(at(0.0, 0.0), moving(0.0, 0.0)), (at(0.0, 0.0), moving(0.0, 0.0))],
        1e-5,
    );
    world.advance(1e-3).unwrap();
    assert_eq!(world.work().coincident, 101); // once at the first instant, once each step
    assert!(world.state().poses.iter().all(|pose| pose.position == Vec2::ZERO));
}
