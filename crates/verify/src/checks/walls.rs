//! Nobody passes through a wall, and a wall acts like its line, however it is divided into faces.

use crate::checks::error::{Result, ensure};
use crate::checks::scenes::*;
use crate::checks::{Check, apart, largest};
use crowd_mechanics::engine::*;

pub(crate) const CHECKS: &[Check] = &[
    Check::new("walker at 1 m/s and a wall: farthest, beyond it", "the wall, x = 2 m", "m", 0.0, || {
        walker(1.0, 10.0)
    }),
    Check::new("walker at 20 m/s, TimeStep 0.1 s", "the wall, x = 2 m", "m", 0.0, || walker(20.0, 10.0)),
    Check::new("walker and 200 m of wall", "the wall, x = 2 m", "m", 0.0, || walker(1.0, 100.0)),
    Check::new("a straight wall in two pieces", "the wall in one", "m", 1e-12, pieces),
    Check::new(
        "a disk rolls along 4 m of wall in 400 and 4000 pieces",
        "the wall in one",
        "SI",
        1e-9,
        || in_pieces(&disk(80.0, 0.2), 0.2),
    ),
    Check::new("a five-disk body slides along the same", "the wall in one", "SI", 1e-9, || {
        in_pieces(&pedestrian(80.0, 0.0), 0.15)
    }),
    Check::new("a disk centred on a wall's line: speed along it", "at rest", "m/s", 1e-9, || {
        Ok(released()?.0)
    }),
    Check::new("the same: kinetic energy when it has left", "½ k_n R²", "", 1e-4, || Ok(released()?.1)),
    Check::new("disks on one point, and on a corner: force", "none", "N", 0.0, || Ok(coincident()?.0)),
    Check::new("the same: contacts not counted", "counted and said", "", 0.0, || Ok(coincident()?.1)),
];

/// A walker of 80 kg with the steady speed `speed`, relaxation rates 2 /s, along y = 5, before a wall at x = 2. Returns
/// how far beyond the wall the centre came \[m\].
fn walker(speed: f64, half_wall: f64) -> Result<f64> {
    let walls = [wall(&[(2.0, -half_wall), (2.0, half_wall)])];
    let mut world =
        world(&[pedestrian(80.0, 2.0)], &walls, CONCRETE, &[(at(0.0, 5.0), moving(speed, 0.0))], 1e-5);
    world.drive[0].force = vec2(80.0 * 2.0 * speed, 0.0);
    let mut farthest = f64::NEG_INFINITY;
    for _ in 0..40 {
        world.advance(0.1)?;
        farthest = farthest.max(world.state().poses[0].position.x);
    }
    ensure!(world.work().contacts > 0, "the walker came to the wall");
    Ok((farthest - 2.0).max(0.0))
}

fn pieces() -> Result<f64> {
    let slide = |corners: &[(f64, f64)]| -> Result<Vec2> {
        let law = PairLaw { friction: 0.0, ..CONCRETE };
        let motion = [(at(-0.3, 0.199), moving(0.5, 0.0))];
        let mut world = world(&[disk(80.0, 0.2)], &[wall(corners)], law, &motion, 1e-5);
        world.drive[0].force = vec2(0.0, -500.0);
        world.advance(1.0)?;
        Ok(world.state().poses[0].position)
    };
    let whole = slide(&[(-1.0, 0.0), (1.0, 0.0)])?;
    Ok((whole - slide(&[(-1.0, 0.0), (0.0, 0.0), (1.0, 0.0)])?).norm())
}

/// A body pressed on a wall and thrown along it. Returns the difference of its motion after 3 s when the wall is
/// divided into 400 and 4000 equal faces.
fn in_pieces(body: &BodySpec, half_depth: f64) -> Result<f64> {
    let slide = |pieces: u32| -> Result<(Pose, Twist)> {
        let corners: Vec<(f64, f64)> =
            (0..=pieces).map(|k| (-0.5 + 4.0 * f64::from(k) / f64::from(pieces), 0.0)).collect();
        let motion = [(at(0.0, half_depth - 1e-4), moving(0.9, 0.0))];
        let mut world = world(std::slice::from_ref(body), &[wall(&corners)], CONCRETE, &motion, 2e-5);
        world.drive[0].force = vec2(0.0, -500.0);
        for _ in 0..30 {
            world.advance(0.1)?;
        }
        ensure!(world.work().contacts > 10_000, "it stays at the wall");
        Ok(motions(&world)[0])
    };
    let whole = slide(1)?;
    Ok(largest([apart(&slide(400)?, &whole), apart(&slide(4000)?, &whole)]))
}

/// A body of 80 kg at rest with its centre on a wall's line, except for rounding. Returns the speed \[m/s\] along the
/// wall afterwards, and the difference of its kinetic energy from that of its overlap.
fn released() -> Result<(f64, f64)> {
    let (mut along, mut energy) = (0.0, 0.0);
    let walls = [
        [(-4.7, 0.0), (5.1, 0.0)],
        [(-4.7, -1.3), (5.1, 2.9)],
        [(0.3, -7.0), (0.3, 1.1)],
        [(1.0, 3.0), (-2.0, -0.7)],
    ];
    for [start, end] in walls {
        let (start_, end_) = (vec2(start.0, start.1), vec2(end.0, end.1));
        let direction = (end_ - start_) * (1.0 / (end_ - start_).norm());
        for share in [0.31, 0.51, 0.77] {
            let place = start_ + (end_ - start_) * share;
            let motion = [(at(place.x, place.y), moving(0.0, 0.0))];
            let mut world = world(&[disk(80.0, 0.2)], &[wall(&[start, end])], ELASTIC, &motion, 1e-5);
            for _ in 0..10 {
                world.advance(0.01)?;
            }
            let held = 0.5 * ELASTIC.normal_stiffness * 0.2 * 0.2;
            along = largest([along, world.state().twists[0].velocity.dot(direction).abs()]);
            energy = largest([energy, (kinetic_energy(&world) / held - 1.0).abs()]);
        }
    }
    Ok((along, energy))
}

/// Two disks at one point, except for rounding, and one on a corner. Returns the force \[N\] on them, and how many of
/// the two contacts are not counted or not reported as coincident, in 10 steps.
fn coincident() -> Result<(f64, f64)> {
    let (mut force, mut missing) = (0.0, 0.0);
    for apart in [0.0, 3e-16, 7e-10] {
        let motions =
            [(1.0, 0.7), (1.0 + apart, 0.7), (-2.0, apart)].map(|(x, y)| (at(x, y), moving(0.0, 0.0)));
        let bodies = [disk(80.0, 0.2), disk(60.0, 0.25), disk(80.0, 0.2)];
        let mut world =
            world(&bodies, &[wall(&[(-9.0, 0.0), (-2.0, 0.0), (-2.0, -3.0)])], BODIES, &motions, 1e-4);
        for _ in 0..10 {
            world.advance(1e-3)?;
            let contacts = world.contacts();
            let seen = [contacts.agent_contacts, contacts.wall_contacts].map(f64::from);
            missing =
                largest([missing, 1.0 - seen[0], 1.0 - seen[1], 2.0 - contacts.coincident.len() as f64]);
            let speeds = world.state().twists.iter().map(|twist| twist.velocity.norm());
            force = largest([force, contacts.bodies.iter().map(|body| body.squeeze).sum(), largest(speeds)]);
        }
        ensure!(world.work().coincident > 0, "they are counted while time runs");
    }
    Ok((force, missing))
}
