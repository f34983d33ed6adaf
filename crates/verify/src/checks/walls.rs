//! Nobody passes through a wall, and a wall acts like its line, however it is divided into faces.

use crate::checks::{Figure, Result, apart, ensure, largest};
use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;

pub(crate) const FIGURES: &[Figure] = &[
    || walker(1.0, 10.0),
    || walker(20.0, 10.0),
    || walker(1.0, 100.0),
    || in_pieces(disk(80.0, 0.2), 0.2),
    || in_pieces(pedestrian(80.0, 0.0), 0.15),
    || Ok(released()?.0),
    || Ok(released()?.1),
    || Ok(coincident()?.0),
    || Ok(coincident()?.1),
];

/// A walker of 80 kg with the steady speed `speed`, relaxation rates 2 /s, along y = 5, before a wall at x = 2. Returns
/// how far beyond the wall the centre came \[m\].
fn walker(speed: f64, half_wall: f64) -> Result<f64> {
    let person = pedestrian(80.0, 2.0).at(0.0, 5.0).moving(speed, 0.0);
    let mut world = world(&[person], &[&[(2.0, -half_wall), (2.0, half_wall)]], CONCRETE, 1e-5);
    world.drive[0].force = vec2(80.0 * 2.0 * speed, 0.0);
    let mut farthest = f64::NEG_INFINITY;
    for _ in 0..40 {
        world.advance(0.1)?;
        farthest = farthest.max(world.state().poses[0].position.x);
    }
    ensure!(world.work().contacts > 0, "the walker came to the wall");
    Ok((farthest - 2.0).max(0.0))
}

/// A body pressed on a wall and thrown along it. Returns the difference of its motion after 3 s when the wall is
/// divided into 400 and 4000 equal faces.
fn in_pieces(body: PlacedBody, half_depth: f64) -> Result<f64> {
    let body = body.at(0.0, half_depth - 1e-4).moving(0.9, 0.0);
    let slide = |pieces: u32| -> Result<World> {
        let corners: Vec<(f64, f64)> =
            (0..=pieces).map(|k| (-0.5 + 4.0 * f64::from(k) / f64::from(pieces), 0.0)).collect();
        let mut world = world(std::slice::from_ref(&body), &[&corners], CONCRETE, 2e-5);
        world.drive[0].force = vec2(0.0, -500.0);
        for _ in 0..30 {
            world.advance(0.1)?;
        }
        ensure!(world.work().contacts > 10_000, "it stays at the wall");
        Ok(world)
    };
    let whole = motions(&slide(1)?);
    Ok(largest([apart(&motions(&slide(400)?), &whole), apart(&motions(&slide(4000)?), &whole)]))
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
            let body = disk(80.0, 0.2).at(place.x, place.y);
            let mut world = world(&[body], &[&[start, end]], ELASTIC, 1e-5);
            for _ in 0..10 {
                world.advance(0.01)?;
            }
            let held = 0.5 * ELASTIC.normal_stiffness * 0.2 * 0.2;
            along = largest([along, world.state().twists[0].velocity.dot(&direction).abs()]);
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
        let [one, other] = [disk(80.0, 0.2).at(1.0, 0.7), disk(60.0, 0.25).at(1.0 + apart, 0.7)];
        let people = [one, other, disk(80.0, 0.2).at(-2.0, apart)];
        let mut world = world(&people, &[&[(-9.0, 0.0), (-2.0, 0.0), (-2.0, -3.0)]], BODIES, 1e-4);
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
