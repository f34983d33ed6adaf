//! Free motion, and the proof that nothing is missed.

use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;

#[test]
fn people_apart_need_no_mechanical_step() {
    let person =
        |k| pedestrian(70.0, 4.5).at(2.0 * f64::from(k % 10), 2.0 * f64::from(k / 10)).moving(1.0, 0.5);
    let people: Vec<PlacedBody> = (0..100).map(person).collect();
    let mut world = world(&people, &[&[(-5.0, -5.0), (30.0, -5.0)]], BODIES, 1e-5);
    world.advance(0.1).unwrap();
    assert_eq!((world.work().steps, world.work().shortlisted), (0, 100));
}

/// Advances a scene with and without free bodies, which is the same but for rounding; a touch that is missed would show.
/// Returns the work with free bodies.
fn compared(people: &[PlacedBody], walls: &[&[(f64, f64)]], duration: f64) -> Work {
    let [with, without] = [Shortlisting::On, Shortlisting::Off].map(|shortlisting| {
        let mut world = world(people, walls, BODIES, 2e-5);
        world.shortlisting = shortlisting;
        // Few touches: each multiplies what rounding has made different.
        world.advance(duration).unwrap();
        world
    });
    for (a, b) in with.state().poses.iter().zip(&without.state().poses) {
        assert!((a.position - b.position).norm() < 1e-7, "{people:?}: {a:?} {b:?}");
        assert!((a.orientation - b.orientation).abs() < 1e-6, "{people:?}: {a:?} {b:?}");
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
        let people = [0.0, 0.40].map(|x| {
            let person = pedestrian(70.0, 4.5).at(x, 0.2 * random.signed()).turned(1.6 * random.signed());
            let person = person.moving(0.1 * random.signed(), 0.1 * random.signed());
            person.spinning(12.0 * random.signed())
        });
        let work = match case % 2 {
            0 => compared(&people, &[], 0.05),
            _ => compared(&people[..1], &[&[(0.2, -1.0), (0.2, 1.0)]], 0.05),
        };
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
        let mut people = vec![pedestrian(70.0, 0.5).at(-0.28, 0.0).moving(1.0, 0.0)];
        let mut x = 0.0;
        for _ in 1..7 {
            people.push(pedestrian(70.0, 0.5).at(x, 0.0));
            // The middle disks touch at 0.273 m.
            x += 0.27305 + 4e-5 * random.signed();
        }
        let work = compared(&people, &[], 0.02);
        assert!(work.contacts > 0 && work.steps > 0, "{work:?}");
    }
}
