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

/// Advances a scene with and without free bodies, which is the same but for rounding; a touch that is missed would show.
/// Returns the work with free bodies.
fn compared(bodies: &[BodySpec], walls: &[WallSpec], motions: &[(Pose, Twist)], duration: f64) -> Work {
    let [with, without] = [Shortlisting::On, Shortlisting::Off].map(|shortlisting| {
        let mut world = world(bodies, walls, BODIES, motions, 2e-5);
        world.shortlisting = shortlisting;
        // Few touches: each multiplies what rounding has made different.
        world.advance(duration).unwrap();
        world
    });
    for (a, b) in with.state().poses.iter().zip(&without.state().poses) {
        assert!((a.position - b.position).norm() < 1e-7, "{motions:?}: {a:?} {b:?}");
        assert!((a.orientation - b.orientation).abs() < 1e-6, "{motions:?}: {a:?} {b:?}");
    }
    *with.work()
}

/// Two people beside each other, or one beside a wall, who turn and hardly move: a circle that only follows the centre of
/// mass would miss the shoulders.
#[test]
fn a_touch_by_turning_is_not_missed() {
    let mut random = Random(7);
    let (mut free, mut touching) = (0, 0);
    for case in 0..400 {
        let mut motions: Vec<(Pose, Twist)> = [0.0, 0.40]
            .into_iter()
            .map(|x| {
                let pose =
                    Pose { position: vec2(x, 0.2 * random.signed()), orientation: 1.6 * random.signed() };
                let velocity = vec2(0.1 * random.signed(), 0.1 * random.signed());
                (pose, Twist { velocity, angular_velocity: 12.0 * random.signed() })
            })
            .collect();
        let beside = wall(&[(0.2, -1.0), (0.2, 1.0)]);
        let walls = if case % 2 == 0 { &[][..] } else { std::slice::from_ref(&beside) };
        motions.truncate(2 - walls.len());
        let bodies: Vec<BodySpec> = motions.iter().map(|_| pedestrian(70.0, 4.5)).collect();
        let work = compared(&bodies, walls, &motions, 0.05);
        free += u32::from(work.shortlisted > 0);
        touching += u32::from(work.contacts > 0);
    }
    assert!(free > 50 && touching > 50, "{free} {touching}");
}

/// A row of people with hardly a gap, and one who runs into it and cannot reach the third: within one communication
/// step, and before lists are made again, the push reaches people who were free at its start.
#[test]
fn a_push_through_a_row_of_people_is_not_missed() {
    let mut random = Random(7);
    for _ in 0..20 {
        let mut x = -0.28;
        let mut motions = vec![(at(x, 0.0), moving(1.0, 0.0))];
        for person in 1..7 {
            // The middle disks touch at 0.273 m.
            x += if person == 1 { 0.28 } else { 0.27305 + 4e-5 * random.signed() };
            motions.push((at(x, 0.0), moving(0.0, 0.0)));
        }
        let bodies: Vec<BodySpec> = motions.iter().map(|_| pedestrian(70.0, 0.5)).collect();
        let work = compared(&bodies, &[], &motions, 0.02);
        assert!(work.contacts > 0 && work.steps > 0, "{work:?}");
    }
}
