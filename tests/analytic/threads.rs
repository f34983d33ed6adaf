//! Bodies by blocks, shared out or not: the same bits, whoever is free, taken in or driven.

use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;

/// A crowd: the first half stands so near that they touch, the others have room, and one runs into those.
fn crowd(people: usize) -> World {
    let half = people / 2;
    let person = |k: usize| {
        let person = pedestrian(70.0, 4.5).turned(0.7 * k as f64);
        if k < half {
            return person.at(0.4 * (k % 20) as f64, 0.4 * (k / 20) as f64);
        }
        person.at(12.0 + 0.9 * ((k - half) % 20) as f64, 0.9 * ((k - half) / 20) as f64)
    };
    let crowd: Vec<PlacedBody> = (0..people).map(person).collect();
    let mut world = world(&crowd, &[&[(-1.0, -0.5), (31.0, -0.5)]], BODIES, 2e-4);
    world.drive[0] = Wrench { force: vec2(300.0, 100.0), torque: 1.0 };
    // He comes through a row of people of two blocks who stand free.
    world.drive[people - 20] = Wrench { force: vec2(6000.0, 0.0), torque: 0.0 };
    world.share_from = 0;
    world
}

#[test]
fn any_number_of_threads_gives_the_same_bits_whatever_the_size() {
    for people in [511, 512, 513, 1024, 1025] {
        for rate in [0.0, 40.0] {
            let mut worlds = [1, 2, 3, usize::MAX].map(|threads| {
                let mut world = crowd(people);
                world.drive_rate[people - 20].force.y = rate;
                world.set_threads(threads).unwrap();
                world
            });
            for _ in 0..4 {
                for world in &mut worlds {
                    world.advance(0.1).unwrap();
                }
            }
            let [one, others @ ..] = &worlds;
            let work = one.work();
            assert!(one.face_exposures()[0].mean_force > 0.0);
            let stepped = u64::try_from(people).unwrap() * 4 - work.shortlisted;
            assert!(work.shortlisted > 0 && work.contacts > 10_000 && stepped > 0, "{work:?}");
            // The runner has pushed somebody who was free when the step began.
            assert!(one.state().twists[people - 19].velocity.norm() > 0.01);
            for other in others {
                assert_eq!(other.shared(), if people > 512 { 4 } else { 0 });
                assert!(other.state() == one.state() && other.contacts() == one.contacts(), "{people}");
                assert!(other.exposures() == one.exposures(), "{people}");
                assert!(other.face_exposures() == one.face_exposures(), "{people}");
            }
            assert_eq!(others[2].threads(), people.div_ceil(512));
        }
    }
}

#[test]
fn a_clone_shares_the_threads_and_may_move_on_elsewhere() {
    let mut world = crowd(1025);
    world.set_threads(2).unwrap();
    let mut clone = world.clone();
    let clone = std::thread::spawn(move || {
        clone.advance(0.05).unwrap();
        clone
    });
    world.advance(0.05).unwrap();
    let clone = clone.join().unwrap();
    assert!(clone.state() == world.state());
    drop(world);
    assert_eq!(clone.threads(), 2);
}
