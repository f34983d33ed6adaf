//! A drive that changes evenly during a communication step.

use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;

#[test]
fn who_ends_at_rest_has_moved() {
    // Pushed and braked by one ramp: 0.83 m further if nobody stands in the way.
    let braked = |shortlisting: Shortlisting, people: &[PlacedBody]| {
        let mut world = world(people, &[], ELASTIC, 1e-5);
        world.shortlisting = shortlisting;
        world.drive[0].force = vec2(1400.0, 0.0);
        world.drive_rate[0].force = vec2(-5600.0, 0.0);
        world.advance(0.5).unwrap();
        world
    };
    let someone = disk(70.0, 0.2);
    let alone = braked(Shortlisting::On, std::slice::from_ref(&someone));
    assert!(alone.state().twists[0].velocity.norm() < 1e-9);
    // 20 m/s2 · (0.5 s)²/2 − 80 m/s3 · (0.5 s)³/6
    assert!((alone.state().poses[0].position - vec2(5.0 / 6.0, 0.0)).norm() < 1e-9);
    let both = [someone.clone(), someone.at(0.7, 0.1)];
    let met = braked(Shortlisting::On, &both);
    assert!(met.work().contacts > 0, "the other stands within the path");
    assert_eq!(met.state(), braked(Shortlisting::Off, &both).state());
}

#[test]
fn a_failed_step_changes_nothing() {
    for (absurd, ramp) in [(f64::MAX, false), (f64::MAX, true), (f64::NAN, true)] {
        let mut world = world(&[disk(80.0, 0.2), disk(80.0, 0.2).at(0.3, 0.0)], &[], BODIES, 1e-5);
        world.advance(1e-3).unwrap();
        let before = (world.state().clone(), world.contacts().clone());
        let drive = if ramp { &mut world.drive_rate } else { &mut world.drive };
        drive[1].force = vec2(absurd, absurd);
        world.mechanical_step = 1.0;
        let error = world.advance(1e3).unwrap_err();
        assert!(ramp || error == AdvanceError::NotFinite { body: BodyId(1) }, "{error}");
        assert!(matches!(error, AdvanceError::NotFinite { .. }), "{error}");
        assert_eq!((world.state().clone(), world.contacts().clone()), before);
        (world.drive[1], world.drive_rate[1]) = Default::default();
        world.mechanical_step = 1e-5;
        world.advance(1e-3).unwrap();
    }
}
