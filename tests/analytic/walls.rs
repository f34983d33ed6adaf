//! Forces on walls, and the part of the squeeze that is by walls.

use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;

const FLOOR: &[(f64, f64)] = &[(-2.0, 0.0), (2.0, 0.0)];

fn near(found: f64, expected: f64, relative: f64) {
    assert!((found - expected).abs() <= relative * expected.abs(), "{found} instead of {expected}");
}

#[test]
fn who_is_pressed_on_a_wall_is_pressed_by_the_wall_alone() {
    let mut world = world(&[disk(80.0, 0.2).at(0.0, 0.2).relaxing(4.5, 4.5)], &[FLOOR], BODIES, 1e-5);
    world.drive[0].force = vec2(0.0, -500.0);
    for _ in 0..400 {
        world.advance(0.01).unwrap();
        let of = world.exposures()[0];
        assert_eq!((of.mean_people_force(), of.mean_wall_force), (0.0, of.mean_force));
    }
    let (of, on) = (world.exposures()[0], world.face_exposures()[0]);
    for force in [of.mean_wall_force, on.mean_force, on.peak_force] {
        near(force, 500.0, 1e-8);
    }
}

/// A wall in two pieces: they lean on the first one.
#[test]
fn a_wall_carries_all_who_push_towards_it() {
    let people = [disk(80.0, 0.2).at(-1.0, 0.199), disk(60.0, 0.2).at(-1.0, 0.597)];
    let people = people.map(|person| person.relaxing(4.5, 4.5));
    let wall = [(-2.0, 0.0), (0.0, 0.0), (2.0, 0.0)];
    let mut world = world(&people, &[&wall], BODIES, 1e-5);
    (world.drive[0].force, world.drive[1].force) = (vec2(0.0, -200.0), vec2(0.0, -300.0));
    // At the start as at an instant.
    let (of, on) = (world.exposures(), world.face_exposures());
    assert_eq!((of[0].mean_wall_force, of[1].mean_wall_force), (on[0].mean_force, 0.0));
    assert_eq!(of[0].mean_wall_force, world.contacts().bodies[0].wall_squeeze);
    assert!(of[0].mean_people_force() > 0.0);
    for _ in 0..600 {
        world.advance(0.01).unwrap();
    }
    let (of, on) = (world.exposures(), world.face_exposures());
    near(on[0].mean_force, 500.0, 1e-8);
    near(of[0].mean_wall_force, 500.0, 1e-8);
    near(of[0].mean_people_force(), 300.0, 1e-8);
    near(of[1].mean_people_force(), 300.0, 1e-8);
    assert_eq!((of[1].mean_wall_force, on[1]), (0.0, FaceExposure::default()));
}

/// Within one step. The damped contact pulls a little before it parts, which counts in |F_n|: ζ = 0.018.
#[test]
fn a_bounce_gives_the_impulse_of_its_velocities() {
    let damped = PairLaw { normal_damping: 500.0, ..ELASTIC };
    for (law, tolerance) in [(ELASTIC, 1e-6), (damped, 2e-3)] {
        let mut world = world(&[disk(80.0, 0.2).at(0.0, 0.25).moving(0.0, -1.0)], &[FLOOR], law, 1e-5);
        world.advance(0.2).unwrap();
        let parted = world.state().twists[0].velocity.y;
        let omega = (law.normal_stiffness / 80.0).sqrt();
        let zeta = law.normal_damping / (2.0 * 80.0 * omega);
        near(parted, (-zeta * std::f64::consts::PI / (1.0 - zeta * zeta).sqrt()).exp(), 1e-5);
        near(world.exposures()[0].mean_wall_force * 0.2, 80.0 * (1.0 + parted), tolerance);
        assert_eq!(world.face_exposures()[0].mean_force, world.exposures()[0].mean_wall_force);
    }
}

/// A crowd that is pushed about in a room with bends, corners, a round pillar, and a wall that is drawn twice.
fn pushed_about() -> (World, impl Fn(&mut World, u32)) {
    let room = [(-0.3, -0.3), (3.0, -0.3), (5.0, 0.1), (5.0, 3.0), (-0.3, 3.0), (-0.3, -0.3)];
    let pillar: Vec<(f64, f64)> =
        polygon(12).into_iter().map(|(x, y)| (2.62 + 0.05 * x, 1.3 + 0.05 * y)).collect();
    let people = on_lattice(8, [0.55, 0.33], 0.4);
    let push = |world: &mut World, k| {
        for (b, drive) in world.drive.iter_mut().enumerate() {
            let angle = 0.05 * f64::from(k) + 0.3 * b as f64;
            drive.force = vec2(libm::cos(angle), libm::sin(angle)) * 400.0;
        }
    };
    (world(&people, &[&room, &pillar, &room[..2]], BODIES, 1e-4), push)
}

/// In steps, and in parts of steps.
#[test]
fn walls_get_what_they_give() {
    let (mut world, push) = pushed_about();
    let (mut on_walls, mut steps) = (0, 0);
    for k in 0..200 {
        push(&mut world, k);
        let so_far = 0.01 * f64::from(k % 3);
        world.advance_on(0.01, so_far).unwrap();
        let time = so_far + 0.01;
        let of_people: f64 = world.exposures().iter().map(|of| of.mean_wall_force * time).sum();
        let of_walls: f64 = world.face_exposures().iter().map(|on| on.mean_force * time).sum();
        near(of_walls, of_people, 1e-12);
        assert!(world.exposures().iter().all(|of| of.mean_people_force() >= 0.0));
        assert!(world.face_exposures().iter().all(|on| on.mean_force <= on.peak_force));
        on_walls = on_walls.max(world.face_exposures().iter().filter(|on| on.mean_force > 0.0).count());
        steps += usize::from(of_walls > 0.0);
    }
    assert!(on_walls >= 6 && steps > 150, "{on_walls} {steps}");
}

/// Returns the world with panels, the longest of each wall of so many metres.
fn divided(world: &World, longest: &[Option<f64>], mechanical_step: f64) -> World {
    let mut divided =
        World::new(world.scene().clone().with_panels(longest), world.state().clone(), mechanical_step)
            .unwrap();
    divided.drive.clone_from(&world.drive);
    divided
}

/// The same crowd with panels: the motion has the same bits, and the panels of a face add up to it.
#[test]
fn panels_change_nothing_and_share_what_their_face_gets() {
    let (mut whole, push) = pushed_about();
    let mut world = divided(&whole, &[Some(0.4), None, Some(9.0)], 1e-4);
    // Of the walls' 18 m and the first two pieces again.
    let counts = [9, 6, 8, 14, 9].into_iter().chain([0; 12]).chain([1]).collect::<Vec<usize>>();
    assert_eq!(world.panel_exposures().len(), counts.iter().sum::<usize>());
    let mut pressed = 0;
    for k in 0..200 {
        push(&mut whole, k);
        push(&mut world, k);
        let so_far = 0.01 * f64::from(k % 3);
        whole.advance_on(0.01, so_far).unwrap();
        world.advance_on(0.01, so_far).unwrap();
        assert_eq!((world.state(), world.face_exposures()), (whole.state(), whole.face_exposures()));
        let mut panels = world.panel_exposures().iter();
        for (on, count) in world.face_exposures().iter().zip(&counts).filter(|(_, count)| **count > 0) {
            let own: Vec<&FaceExposure> = panels.by_ref().take(*count).collect();
            near(own.iter().map(|panel| panel.mean_force).sum(), on.mean_force, 1e-12);
            let peaks: f64 = own.iter().map(|panel| panel.peak_force).sum();
            assert!(
                own.iter().all(|panel| panel.peak_force <= on.peak_force)
                    && peaks >= on.peak_force * (1.0 - 1e-12)
            );
            pressed = pressed.max(own.iter().filter(|panel| panel.mean_force > 0.0).count());
        }
    }
    assert!(pressed >= 4, "{pressed}");
}

/// A wall of one piece, of some that are no panels, and of pieces as long as panels: people who push along it press each half
/// metre alike.
#[test]
fn panels_do_not_depend_on_how_a_wall_is_cut() {
    let people: Vec<_> =
        (0..7).map(|k| disk(80.0, 0.2).at(0.45 * f64::from(k) - 1.31, 0.199).relaxing(4.5, 4.5)).collect();
    let cuts: [&[f64]; 4] = [
        &[-2.0, 2.0],
        &[-2.0, 0.5, 2.0],
        &[-2.0, -1.87, 0.13, 0.141, 2.0],
        &[-2.0, -1.5, -1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0],
    ];
    let mut seen = Vec::new();
    for cut in cuts {
        let wall: Vec<(f64, f64)> = cut.iter().map(|x| (*x, 0.0)).collect();
        let whole = world(&people, &[&wall], BODIES, 1e-4);
        let mut world = divided(&whole, &[Some(0.5)], 1e-4);
        for drive in &mut world.drive {
            drive.force = vec2(150.0, -300.0);
        }
        let loads = (0..100).flat_map(|_| {
            world.advance(0.01).unwrap();
            world.panel_exposures().iter().map(|on| on.mean_force).collect::<Vec<_>>()
        });
        seen.push(loads.collect::<Vec<f64>>());
    }
    let [one, others @ ..] = &seen[..] else { panic!() };
    let most = one.iter().copied().fold(0.0, f64::max);
    assert!(most > 300.0 && one.len() == 800);
    for other in others {
        one.iter().zip(other).for_each(|(a, b)| assert!((a - b).abs() <= 1e-9 * most, "{a} {b}"));
    }
}

#[test]
fn panels_get_the_momentum_that_people_lose() {
    // Bounces on a wall of two pieces, without damping: nothing else acts on them.
    let wall = [(-2.0, 0.0), (0.1, 0.0), (2.0, 0.0)];
    let people: Vec<_> = (0..7)
        .map(|k| disk(60.0 + f64::from(k), 0.2).at(0.5 * f64::from(k) - 1.4, 0.21).moving(0.0, -1.0))
        .collect();
    let whole = world(&people, &[&wall], ELASTIC, 1e-5);
    let mut world = divided(&whole, &[Some(0.5)], 1e-5);
    let momentum = |world: &World| -> f64 {
        let bodies = world.scene().bodies.iter().zip(&world.state().twists);
        bodies.map(|(body, twist)| body.mass * twist.velocity.y).sum()
    };
    let (before, mut impulse) = (momentum(&world), 0.0);
    for _ in 0..20 {
        world.advance(0.01).unwrap();
        impulse += world.panel_exposures().iter().map(|on| on.mean_force * 0.01).sum::<f64>();
    }
    assert!(momentum(&world) > 400.0);
    near(impulse, momentum(&world) - before, 1e-12);
}
