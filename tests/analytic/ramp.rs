//! A drive that changes evenly during a communication step.

use crowd_mechanics::engine::*;
use lemons_verify::checks::scenes::*;

/// Somebody pushed and braked by one ramp, who ends at rest 0.83 m further if nobody stands in the way.
fn pushed_and_braked(shortlisting: Shortlisting, others: &[Pose]) -> World {
    let motions: Vec<(Pose, Twist)> =
        [at(0.0, 0.0)].iter().chain(others).map(|pose| (*pose, moving(0.0, 0.0))).collect();
    let mut world = world(&vec![disk(70.0, 0.2); motions.len()], &[], ELASTIC, &motions, 1e-5);
    world.shortlisting = shortlisting;
    world.drive[0].force = vec2(1400.0, 0.0);
    world.drive_rate[0].force = vec2(-5600.0, 0.0);
    world.advance(0.5).unwrap();
    world
}

#[test]
fn who_ends_at_rest_has_moved() {
    let alone = pushed_and_braked(Shortlisting::On, &[]);
    assert!(alone.state().twists[0].velocity.norm() < 1e-9);
    // 20 m/s2 · (0.5 s)²/2 − 80 m/s3 · (0.5 s)³/6
    assert!((alone.state().poses[0].position - vec2(5.0 / 6.0, 0.0)).norm() < 1e-9);
    let met = pushed_and_braked(Shortlisting::On, &[at(0.7, 0.1)]);
    assert!(met.work().contacts > 0, "the other stands within the path");
    assert_eq!(met.state(), pushed_and_braked(Shortlisting::Off, &[at(0.7, 0.1)]).state());
}

#[test]
fn a_rate_stays_until_it_is_set_back() {
    let mut world = world(&[disk(80.0, 0.2)], &[], BODIES, &[(at(0.0, 0.0), moving(0.0, 0.0))], 1e-5);
    let drive = Wrench { force: vec2(8.0, 0.0), torque: 0.1 };
    let rate = Wrench { force: vec2(16.0, -8.0), torque: 0.2 };
    (world.drive[0], world.drive_rate[0]) = (drive, rate);
    world.advance(0.5).unwrap();
    assert_eq!((world.drive[0], world.drive_rate[0]), (drive, rate));
    // 80 kg: 0.1 m/s2 · 0.5 s + 0.2 m/s3 · (0.5 s)²/2
    assert!((world.state().twists[0].velocity - vec2(0.075, -0.0125)).norm() < 1e-15);
    world.advance(0.5).unwrap();
    assert!((world.state().twists[0].velocity - vec2(0.15, -0.025)).norm() < 1e-15, "the same again");
}

#[test]
fn a_step_that_fails_under_a_ramp_changes_nothing() {
    for absurd in [f64::MAX, f64::NAN] {
        let motions = [(at(0.0, 0.0), moving(0.0, 0.0)), (at(0.3, 0.0), moving(0.0, 0.0))];
        let mut world = world(&[disk(80.0, 0.2), disk(80.0, 0.2)], &[], BODIES, &motions, 1e-5);
        world.advance(1e-3).unwrap();
        let before = (world.state().clone(), world.contacts().clone(), world.drive.clone());
        world.drive_rate[1].force = vec2(absurd, absurd);
        world.mechanical_step = 1.0;
        assert!(matches!(world.advance(1e3), Err(AdvanceError::NotFinite { .. })), "{absurd}");
        assert_eq!((world.state().clone(), world.contacts().clone(), world.drive.clone()), before);
        world.drive_rate[1] = Wrench::default();
        world.mechanical_step = 1e-5;
        world.advance(1e-3).unwrap();
    }
}
