use super::*;
use crate::engine::round_bodies::RoundBody;
use crate::engine::{BodySpec, DiskSpec, LawTable, PairLaw, Pose, Twist, vec2};

/// Two equal and opposite forces that move nobody: their sum of sizes is beyond all numbers.
#[test]
fn a_squeeze_beyond_all_numbers_is_an_error_and_changes_nothing() {
    let scene = RoundBody { mass: 1e300, radius: 1.0, relaxation: 0.0, stiffness: 1e308 }.scene(3);
    let poses = [-1.0, 0.0, 1.0].map(|x| Pose { position: vec2(x, 0.0), orientation: 0.0 });
    let mut world = World::new(scene, State::new(poses.to_vec(), vec![Twist::default(); 3]), 1e-12).unwrap();
    let before = world.state().clone();
    assert_eq!(world.advance(1e-12), Err(AdvanceError::NotFinite { body: BodyId(1) }));
    assert_eq!(*world.state(), before);
}

/// Three thousand grains fly to one point, where there are 4.5 million pairs of them.
#[test]
fn who_come_together_in_thousands_are_an_error_and_change_nothing() {
    let scene = RoundBody { mass: 1e3, radius: 1e-3, relaxation: 0.0, stiffness: 1.0 }.scene(3000);
    let out = |k: i32| crate::engine::rotation(f64::from(k) * 0.002) * vec2(100.0, 0.0);
    let poses = (0..3000).map(|k| Pose { position: out(k), orientation: 0.0 }).collect();
    let twists = (0..3000).map(|k| Twist { velocity: -out(k), angular_velocity: 0.0 }).collect();
    let mut world = World::new(scene, State::new(poses, twists), 0.1).unwrap();
    world.advance(0.5).unwrap();
    let before = world.state().clone();
    let Err(AdvanceError::Crowded(crowded)) = world.advance(0.5) else { panic!("all were held") };
    assert_eq!((crowded.others, crowded.faces, crowded.most), (2999, 0, 2_000_000));
    assert_eq!(*world.state(), before);
    // It goes on as if nothing had been.
    world.advance(0.2).unwrap();
}

/// Pairs are fewer, as many and more than a word has bits, and their
/// lists are made again while some of them touch.
#[test]
fn the_bits_of_touching_pairs_are_those_of_their_springs() {
    let mut seen = Vec::new();
    for count in [2, 32, 33, 34, 66, 600] {
        let mut world = row(count, 0.2001, 0.0);
        // So that all pairs are listed.
        world.shortlisting = Shortlisting::Off;
        for step in 0..12 {
            world.advance(if step == 0 { 1e-4 } else { 0.02 }).unwrap();
            let (marked, pairs) = world.blocks.marked();
            assert!(marked, "{count}");
            seen.push(pairs);
        }
        assert!(world.work().refreshes > 12 && world.work().contacts > 0, "{:?}", world.work());
    }
    assert!([31, 32, 33, 65].iter().all(|pairs| seen.contains(pairs)), "{seen:?}");
}

/// Round bodies of 0.2 m that knock against each other in a row, so far apart \[m\].
fn row(count: usize, apart: f64, relaxation: f64) -> World {
    let scene = RoundBody { mass: 1.0, radius: 0.1, relaxation, stiffness: 1e4 }.scene(count);
    let poses = (0..count).map(|k| Pose { position: vec2(apart * k as f64, 0.0), orientation: 0.0 });
    let speed = |k: usize| if k.is_multiple_of(3) { 2.0 } else { -1.0 };
    let twists = (0..count).map(|k| Twist { velocity: vec2(speed(k), 0.0), angular_velocity: 0.0 });
    World::new(scene, State::new(poses.collect(), twists.collect()), 1e-4).unwrap()
}

/// The outside: a world that never had that body. The last of a row, so that all others have the same numbers.
#[test]
fn who_is_not_there_changes_nothing_for_the_others() {
    for shortlisting in [Shortlisting::On, Shortlisting::Off] {
        let (mut with, mut without) = (row(6, 0.19, 0.5), row(5, 0.19, 0.5));
        let last = BodyId(5);
        with.set_present(last, false);
        with.restore(with.state().clone()).unwrap();
        let start = with.state().poses[5];
        for world in [&mut with, &mut without] {
            (world.shortlisting, world.drive[2].force) = (shortlisting, vec2(300.0, 10.0));
        }
        with.drive[5].force = vec2(1e5, 0.0);
        for _ in 0..20 {
            with.advance(0.01).unwrap();
            without.advance(0.01).unwrap();
        }
        assert_eq!(with.state().poses[..5], without.state().poses);
        assert_eq!(with.state().twists[..5], without.state().twists);
        assert_eq!(with.state().disk_springs, without.state().disk_springs);
        assert_eq!(with.exposures()[..5], *without.exposures());
        assert_eq!(with.contacts().agent_contacts, without.contacts().agent_contacts);
        assert_eq!((with.state().poses[5], with.state().twists[5]), (start, Twist::default()));
        assert_eq!(with.exposures()[5], Exposure::default());
        assert!(without.work().contacts > 0);
    }
}

/// Bodies that fly about, so far apart \[m\].
fn flying(count: u32, spread: f64) -> World {
    let body = RoundBody { mass: 1.0, radius: 0.1, relaxation: 0.5, stiffness: 1e4 };
    let scene = body.scene(count as usize);
    let place = |k: u32| {
        let jitter = 0.05 * libm::sin(7.0 * f64::from(k));
        vec2(spread * f64::from(k % 6) + jitter, spread * f64::from(k / 6))
    };
    let poses = (0..count).map(|k| Pose { position: place(k), orientation: 0.1 }).collect();
    let speed = |k: f64| vec2(libm::sin(5.0 * k), libm::cos(3.0 * k)) * 3.0;
    let twists = (0..count).map(|k| Twist { velocity: speed(f64::from(k)), angular_velocity: 2.0 });
    World::new(scene, State::new(poses, twists.collect()), 1e-4).unwrap()
}

/// Candidates that were listed before, also in a step that failed, change nothing.
#[test]
fn a_restored_world_gives_the_same_bits_where_free_bodies_become_active() {
    for spread in [0.3, 0.4, 0.5, 0.6, 0.8] {
        let mut world = flying(30, spread);
        for step in 0..60 {
            let mut restored = flying(30, spread);
            restored.restore(world.state().clone()).unwrap();
            let drive = std::mem::replace(&mut world.drive[step % 30].force, vec2(f64::INFINITY, 0.0));
            assert!(world.advance(0.1).is_err());
            world.drive[step % 30].force = drive;
            for world in [&mut world, &mut restored] {
                world.advance(0.1).unwrap();
            }
            assert_eq!(world.state(), restored.state(), "{spread} {step}");
        }
        assert!(world.work().shortlisted > 0 && world.work().contacts > 0);
    }
}

/// Of several blocks.
#[test]
fn a_restored_world_of_many_gives_the_same_bits_too() {
    let mut world = flying(1100, 0.6);
    for step in 0..12 {
        let mut restored = flying(1100, 0.6);
        restored.restore(world.state().clone()).unwrap();
        for world in [&mut world, &mut restored] {
            world.advance(0.05).unwrap();
        }
        assert_eq!(world.state(), restored.state(), "{step}");
    }
    assert!(world.work().shortlisted > 0 && world.work().contacts > 0);
}

/// Two who run into a group that rests; the first wakes it while the second is on its way.
#[test]
fn who_runs_into_a_group_that_another_one_woke_is_not_missed() {
    for lag in [0.0, 0.05, 0.1, 0.15, 0.2, 0.25] {
        let [stepped, shortlisted] = [Shortlisting::Off, Shortlisting::On].map(|shortlisting| {
            let scene = RoundBody { mass: 1.0, radius: 0.1, relaxation: 0.0, stiffness: 1e4 }.scene(12);
            let place = |k: usize| match k {
                0 => vec2(-0.45, 0.0),
                1 => vec2(-0.45 - lag, 2.0),
                _ => vec2(0.0, 0.201 * (k - 2) as f64),
            };
            let poses = (0..12).map(|k| Pose { position: place(k), orientation: 0.0 }).collect();
            let speed = |k: usize| if k < 2 { vec2(1.5, 0.0) } else { Vec2::zeros() };
            let twists = (0..12).map(|k| Twist { velocity: speed(k), angular_velocity: 0.0 }).collect();
            let mut world = World::new(scene, State::new(poses, twists), 1e-4).unwrap();
            world.shortlisting = shortlisting;
            world.advance(0.6).unwrap();
            world.state().poses.clone()
        });
        for (k, (one, other)) in stepped.iter().zip(&shortlisted).enumerate() {
            assert!((one.position - other.position).norm() < 1e-7, "{lag} {k}: {one:?} {other:?}");
        }
    }
}

/// Many others move so slowly that lists hold for long, and their margins for longer than it takes to wake somebody. A
/// world that was just made has listed all bodies.
#[test]
fn who_wakes_in_a_world_that_was_just_made_is_not_missed() {
    const SLOW: usize = 100;
    for gap in [0.0201, 0.021, 0.023, 0.025, 0.027] {
        let [stepped, shortlisted] = [Shortlisting::Off, Shortlisting::On].map(|shortlisting| {
            let body = RoundBody { mass: 1.0, radius: 0.1, relaxation: 0.0, stiffness: 1e4 };
            let place = |k: usize| match k {
                0 => vec2(-0.2 - gap, 0.0),
                1 => Vec2::zeros(),
                _ => vec2(50.0 + 0.2 * (k % 2) as f64, (k / 2) as f64),
            };
            let poses = (0..SLOW + 2).map(|k| Pose { position: place(k), orientation: 0.0 }).collect();
            let speed = |k: usize| if k == 0 { vec2(1.5, 0.0) } else { Vec2::zeros() };
            let twists = (0..SLOW + 2).map(|k| Twist { velocity: speed(k), angular_velocity: 0.0 }).collect();
            let mut world = World::new(body.scene(SLOW + 2), State::new(poses, twists), 1e-4).unwrap();
            world.shortlisting = shortlisting;
            world.advance(0.6).unwrap();
            world.state().poses.clone()
        });
        for (k, (one, other)) in stepped.iter().zip(&shortlisted).enumerate() {
            assert!((one.position - other.position).norm() < 1e-7, "{gap} {k}: {one:?} {other:?}");
        }
    }
}

/// Two are pressed together and bounce, while one who passes far away wakes others one by one: who wakes joins lists that
/// were made when the two were elsewhere.
#[test]
fn who_bounce_while_others_wake_are_not_missed() {
    const SPEED: f64 = 0.3;
    const WAY: f64 = 0.01;
    const PASSING: f64 = 0.006;
    const OTHERS: usize = 12;
    let bounced = |others: usize, shift: f64| {
        let count = 3 + others;
        let mut laws = LawTable::new(1);
        let law = PairLaw {
            normal_stiffness: 1e4,
            tangential_stiffness: 1e4,
            normal_damping: 0.0,
            tangential_damping: 0.0,
            friction: 0.0,
        };
        laws.set(0, 0, law);
        let body = |k: usize| BodySpec {
            mass: 1.0,
            inertia: 1.0,
            translation_rate: 0.0,
            across_rate: None,
            rotation_rate: 0.0,
            disks: vec![DiskSpec {
                radius: if k < 3 { 0.02 } else { 0.004 },
                position: Vec2::zeros(),
                material: 0,
            }],
        };
        let scene = Scene::new(&(0..count).map(body).collect::<Vec<_>>(), &[], laws);
        let aside = |k: usize| if k.is_multiple_of(2) { 0.036 } else { -0.036 };
        let place = |k: usize| match k {
            0 => vec2(-0.0205, 0.0),
            1 => vec2(0.0205, 0.0),
            2 => vec2(0.0, 1.0),
            _ => vec2(0.09 + shift + 0.018 * (k - 3) as f64, 1.0 + aside(k)),
        };
        let velocity = |k: usize| vec2([-SPEED, SPEED, PASSING].get(k).copied().unwrap_or(0.0), 0.0);
        let poses = (0..count).map(|k| Pose { position: place(k), orientation: 0.0 }).collect();
        let twists = (0..count).map(|k| Twist { velocity: velocity(k), angular_velocity: 0.0 }).collect();
        let mut world = World::new(scene, State::new(poses, twists), 1e-3).unwrap();
        for (k, towards) in [(0, 1.0), (1, -1.0)] {
            world.drive[k].force = vec2(towards * SPEED * SPEED / (2.0 * WAY), 0.0);
        }
        world.advance(0.3 / PASSING).unwrap();
        assert!(world.work().shortlisted < others.max(1) as u64, "nobody woke");
        world.state().poses[..2].to_vec()
    };
    let alone = bounced(0, 0.0);
    for shift in 0..40 {
        assert_eq!(bounced(OTHERS, 2.5e-4 * f64::from(shift)), alone, "{shift}");
    }
}

/// Who touches somebody is not free, and whether it is looked for free bodies depends on how many these are.
#[test]
fn who_comes_counts_as_in_a_world_that_is_restored() {
    let body = RoundBody { mass: 1.0, radius: 0.1, relaxation: 4.5, stiffness: 1e4 };
    for count in 3..12 {
        let place = |k: usize| vec2(if k == 1 { 0.19 } else { k as f64 }, 0.0);
        let poses = (0..count).map(|k| Pose { position: place(k), orientation: 0.1 }).collect();
        let speed = |k: usize| vec2(0.01 * k as f64, 0.1);
        let twists = (0..count).map(|k| Twist { velocity: speed(k), angular_velocity: 0.3 }).collect();
        let mut world = World::new(body.scene(count), State::new(poses, twists), 1e-3).unwrap();
        world.drive.fill(Wrench { force: vec2(17.0, 3.3), torque: 0.7 });
        world.set_present(BodyId(1), false);
        world.advance(0.008).unwrap();
        world.set_present(BodyId(1), true);
        let mut restored = world.clone();
        restored.restore(world.state().clone()).unwrap();
        for world in [&mut world, &mut restored] {
            world.advance(0.008).unwrap();
        }
        assert_eq!(world.state(), restored.state(), "{count}");
    }
}

/// In the middle of a run. The total momentum of the others changes no more, and the one who comes back begins
/// again with what it touches there.
#[test]
fn who_leaves_lets_go_and_may_come_back() {
    let mut world = row(3, 0.19, 0.5);
    let middle = BodyId(1);
    assert_eq!(world.contacts().bodies[1].touching_bodies, 2);
    world.set_present(middle, false);
    assert_eq!(world.contacts().bodies[1].touching_bodies, 2, "from the next step on");
    world.advance(0.001).unwrap();
    assert_eq!((world.contacts().agent_contacts, world.state().disk_springs.len()), (0, 0));
    assert_eq!(world.state().poses[1].position, vec2(0.19, 0.0));
    world.set_present(middle, true);
    world.advance(0.001).unwrap();
    assert_eq!(world.contacts().bodies[1].touching_bodies, 2);
    // Elongations begin from zero: as in a world that is made from these poses.
    let mut anew = World::new(world.scene().clone(), world.state().clone(), 1e-4).unwrap();
    let state = world.state().clone();
    anew.advance(0.01).unwrap();
    world.restore(state).unwrap();
    world.advance(0.01).unwrap();
    assert_eq!(anew.state(), world.state());
}

#[test]
fn step_counts_are_integers() {
    assert_eq!(step_count(0.02, 1e-5), Ok(2000));
    assert_eq!(step_count(0.099_999_999_999_999_98, 1e-5), Ok(10_000));
    assert_eq!(step_count(0.100_000_000_000_000_03, 1e-5), Ok(10_000));
    assert_eq!(step_count(0.1, 0.03), Ok(4));
    assert_eq!(step_count(1e-7, 1e-5), Ok(1));
    assert!(step_count(0.0, 1e-5).is_err());
    assert!(step_count(-0.1, 1e-5).is_err());
    assert!(step_count(f64::NAN, 1e-5).is_err());
    assert!(step_count(1e300, 1e-5).is_err());
}
