//! Free motion, and the proof that nothing is missed.

use crowd_mechanics::engine::*;
use lemons_verify::checks::scenes::*;

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

/// People who turn and run a few centimetres from each other and from a pillar: bodies are free up to the moment when
/// a disk of another one comes near. A touch that is missed would show, because both ways of moving are the same but
/// for rounding.
#[test]
fn a_touch_of_free_bodies_is_never_missed() {
    let mut random = Random(7);
    let (mut free, mut contacts, mut steps) = (0, 0, 0);
    for case in 0..60 {
        let spacing = 0.3 + 0.005 * f64::from(case);
        let bodies: Vec<BodySpec> = (0..9).map(|_| pedestrian(70.0, 4.5)).collect();
        let motions: Vec<(Pose, Twist)> = (0..9)
            .map(|k| {
                let position = vec2(f64::from(k % 3), f64::from(k / 3)) * (1.5 * spacing);
                let pose = Pose { position, orientation: random.within(3.2) };
                let velocity = vec2(random.within(1.5), random.within(1.5));
                (pose, Twist { velocity, angular_velocity: random.within(8.0) })
            })
            .collect();
        let beside = 3.0 * spacing + 0.3;
        let pillar = wall(&[(beside, 0.0), (beside + 0.2, 0.1), (beside, 0.2), (beside, 0.0)]);
        let drives: Vec<Wrench> = (0..9)
            .map(|_| Wrench {
                force: vec2(random.within(500.0), random.within(500.0)),
                torque: random.within(60.0),
            })
            .collect();
        let [with, without] = [Shortlisting::On, Shortlisting::Off].map(|shortlisting| {
            let mut world = world(&bodies, std::slice::from_ref(&pillar), BODIES, &motions, 2e-5);
            world.shortlisting = shortlisting;
            world.drive.copy_from_slice(&drives);
            // Few touches: each multiplies what rounding has made different.
            world.advance(0.1).unwrap();
            world
        });
        for (a, b) in with.state().poses.iter().zip(&without.state().poses) {
            assert!((a.position - b.position).norm() < 1e-7, "{case}: {a:?} {b:?}");
            assert!((a.orientation - b.orientation).abs() < 1e-6, "{case}: {a:?} {b:?}");
        }
        free += with.work().shortlisted;
        contacts += with.work().contacts;
        steps += with.work().steps;
    }
    assert!(free > 50 && contacts > 10_000 && steps > 100_000, "{free} {contacts} {steps}");
}

/// Numbers that look random, the same on every machine.
struct Random(u64);

impl Random {
    /// Returns a number between `-most` and `most`.
    fn within(&mut self, most: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        most * (2.0 * ((self.0 >> 11) as f64 / (1u64 << 53) as f64) - 1.0)
    }
}
