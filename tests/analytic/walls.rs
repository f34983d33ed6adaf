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

/// A crowd that is pushed about in a room with bends, corners, a round pillar, and a wall that is drawn twice; in steps,
/// and in parts of steps.
#[test]
fn walls_get_what_they_give() {
    let room = [(-0.3, -0.3), (3.0, -0.3), (5.0, 0.1), (5.0, 3.0), (-0.3, 3.0), (-0.3, -0.3)];
    let pillar: Vec<(f64, f64)> =
        polygon(12).into_iter().map(|(x, y)| (2.62 + 0.05 * x, 1.3 + 0.05 * y)).collect();
    let people = on_lattice(8, [0.55, 0.33], 0.4);
    let mut world = world(&people, &[&room, &pillar, &room[..2]], BODIES, 1e-4);
    let (mut on_walls, mut steps) = (0, 0);
    for k in 0..200 {
        for (b, drive) in world.drive.iter_mut().enumerate() {
            let angle = 0.05 * f64::from(k) + 0.3 * b as f64;
            drive.force = vec2(libm::cos(angle), libm::sin(angle)) * 400.0;
        }
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
