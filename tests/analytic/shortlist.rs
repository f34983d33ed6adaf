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
