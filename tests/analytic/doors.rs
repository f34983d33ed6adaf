//! Walls that open and close.

use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;

/// A room with a gap from (4, 1) to (4, 2).
const ROOM: &[(f64, f64)] = &[(4.0, 2.0), (4.0, 3.0), (0.0, 3.0), (0.0, 0.0), (4.0, 0.0), (4.0, 1.0)];
const DOOR: &[(f64, f64)] = &[(4.0, 1.0), (4.0, 2.0)];

/// Eight people whom a force drives to the door.
fn crowd(walls: &[&[(f64, f64)]]) -> World {
    let mut world = world(&on_lattice(8, [0.55, 0.33], 0.4), walls, BODIES, 1e-4);
    world.drive.iter_mut().for_each(|drive| drive.force = vec2(300.0, 60.0));
    world
}

/// Everything but the wall that is not there in one of both.
fn bits(world: &World) -> (Vec<Pose>, Vec<Twist>, Vec<Exposure>) {
    (world.state().poses.clone(), world.state().twists.clone(), world.exposures().to_vec())
}

/// The outside: a room that never had the door. The door is listed first, so that all faces have other numbers.
#[test]
fn an_open_door_is_no_wall() {
    let (mut open, mut without) = (crowd(&[DOOR, ROOM]), crowd(&[ROOM]));
    open.set_present_walls(&[false, true]).unwrap();
    let mut touched = 0;
    for _ in 0..300 {
        open.advance(0.01).unwrap();
        without.advance(0.01).unwrap();
        assert_eq!(bits(&open), bits(&without));
        assert_eq!(open.face_exposures()[1..], *without.face_exposures());
        touched += open.contacts().wall_contacts;
    }
    assert!(touched > 100 && open.state().poses.iter().any(|pose| pose.position.x > 4.5), "{touched}");
    assert_eq!(open.face_exposures()[0], FaceExposure::default());
}

/// The outside: a room whose door never opened, from the same state on.
#[test]
fn a_door_that_was_closed_again_is_a_wall() {
    let mut world = crowd(&[DOOR, ROOM]);
    let mut never = crowd(&[DOOR, ROOM]);
    world.set_present_walls(&[false, true]).unwrap();
    world.advance(0.1).unwrap();
    assert!(world.is_free(WallId(0), 1.0));
    world.set_present_walls(&[true, true]).unwrap();
    never.restore(world.state().clone()).unwrap();
    for _ in 0..300 {
        world.advance(0.01).unwrap();
        never.advance(0.01).unwrap();
        assert_eq!(bits(&world), bits(&never));
    }
    assert!(world.face_exposures()[0].mean_force > 100.0 && !world.is_free(WallId(0), 1.0));
}

/// Elastic energy \[J\] of the contacts of a world without damping: F²/2k of each.
fn elastic(world: &World) -> f64 {
    let normal = world.contacts().contacts.iter().map(|contact| contact.normal_force.powi(2));
    normal.sum::<f64>() / (2.0 * ELASTIC.normal_stiffness)
}

/// Who leans on the door, or on its frame, loses what the contact holds; nobody gains anything.
#[test]
fn a_door_that_opens_or_closes_gives_no_energy() {
    let people = [disk(80.0, 0.2).at(3.805, 1.5)];
    let mut world = world(&people, &[DOOR, ROOM], ELASTIC, 1e-5);
    let (mut opened, mut waited) = (0, 0);
    for k in 0..4000 {
        let (x, y) = (3.78 + 0.01 * f64::from(k % 40), 0.7 + 0.004 * f64::from(k / 10));
        let pose = Pose { position: vec2(x, y), orientation: 0.0 };
        world.set_present_walls(&[true, true]).unwrap();
        world.restore(State::new(vec![pose], vec![Twist::default()])).unwrap();
        let closed = elastic(&world);
        world.set_present_walls(&[false, true]).unwrap();
        let open = elastic(&world);
        assert!(open <= closed + 1e-12, "{x} {y}: {open} J instead of {closed} J");
        opened += usize::from(open < closed);
        // A door that closes when nobody is in it changes nothing.
        if world.is_free(WallId(0), 1.0) {
            world.set_present_walls(&[true, true]).unwrap();
            assert_eq!(elastic(&world), open, "{x} {y}");
        } else {
            waited += 1;
        }
    }
    assert!(opened > 300 && waited > 1000, "{opened} {waited}");
}

/// The outside: by hand. A body of two disks of 0.1 m, 0.5 m to the left and to the right of its centre, lies across the
/// door at an angle: the door passes between them. It is out of it when both are beyond.
#[test]
fn who_lies_across_a_door_keeps_it_open() {
    let mut across = disk(80.0, 0.1);
    let [left, right] =
        [0.5, -0.5].map(|y| DiskSpec { position: vec2(0.0, y), ..across.body.disks[0].clone() });
    across.body.disks = vec![left, right];
    // Facing up: the disks are at x − 0.5 and x + 0.5.
    let free = |x: f64, y: f64, turn: f64| {
        let people = [across.clone().at(x, y).turned(std::f64::consts::FRAC_PI_2 + turn)];
        world(&people, &[DOOR, ROOM], ELASTIC, 1e-5).is_free(WallId(0), 1.0)
    };
    for turn in [0.0, 0.3, -0.7] {
        for x in [3.7, 4.0, 4.2] {
            assert!(!free(x, 1.5, turn), "{x} {turn}");
        }
        assert!(free(3.39, 1.5, turn) && free(4.61, 1.5, turn), "{turn}");
    }
    // Along the door, before it; above it, on the frame.
    assert!(free(3.89, 1.5, std::f64::consts::FRAC_PI_2) && !free(3.91, 1.5, std::f64::consts::FRAC_PI_2));
    assert!(free(4.0, 2.11, 0.0) && !free(4.0, 2.09, 0.0));
}
