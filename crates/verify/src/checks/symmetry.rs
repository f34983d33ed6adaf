//! Results do not depend on place, direction, mirror image and order.

use crate::checks::error::{Result, ensure};
use crate::checks::scenes::*;
use crate::checks::{Check, apart, largest};
use crowd_mechanics::engine::*;

pub(crate) const CHECKS: &[Check] = &[
    Check::new("scene moved by (3, −7) m", "scene in place", "SI", 1e-9, || {
        seen(|v| v + vec2(3.0, -7.0), |a| a, false)
    }),
    Check::new("scene turned by 0.73 rad", "scene as it was", "SI", 1e-9, || {
        seen(|v| v.rotated(Rotation::by(0.73)), |a| a + 0.73, false)
    }),
    Check::new("scene in a mirror", "scene as it was", "SI", 1e-9, || {
        seen(|v| vec2(v.x, -v.y), |a| -a, true)
    }),
    Check::new("agents in the opposite order", "agents in order", "SI", 1e-9, reversed),
];

/// Twenty-five pedestrians shoulder to shoulder in a corner of walls, for 0.15 s: collisions amplify rounding errors of
/// places, here about tenfold in 0.05 s.
fn bodies() -> Vec<BodySpec> {
    (0..25).map(|k| pedestrian(60.0 + 2.0 * f64::from(k), 4.5)).collect()
}

fn start() -> Vec<(Pose, Twist)> {
    (0..25)
        .map(|k| {
            let (x, y) = (0.36 * f64::from(k % 5), 0.46 * f64::from(k / 5));
            let pose = Pose { position: vec2(x, y), orientation: 0.2 * f64::from(k) };
            (pose, Twist { velocity: vec2(0.8, -0.5), angular_velocity: 0.3 })
        })
        .collect()
}

const CORNERS: [(f64, f64); 3] = [(-1.0, -0.3), (1.7, -0.3), (1.7, 2.6)];

fn run(bodies: &[BodySpec], corners: &[Vec2], motions: &[(Pose, Twist)]) -> Result<World> {
    let corners: Vec<(f64, f64)> = corners.iter().map(|c| (c.x, c.y)).collect();
    let mut world = world(bodies, &[wall(&corners)], BODIES, motions, 1e-5);
    for _ in 0..3 {
        world.advance(0.05)?;
    }
    ensure!(world.work().contacts > 1000, "they met");
    Ok(world)
}

fn as_is() -> Result<World> {
    run(&bodies(), &CORNERS.map(|(x, y)| vec2(x, y)), &start())
}

/// Maps positions and angles of the scene. Returns the largest difference between the motion of the mapped scene and
/// the mapped motion of the original scene.
fn seen(place: fn(Vec2) -> Vec2, angle: fn(f64) -> f64, mirror: bool) -> Result<f64> {
    let origin = place(Vec2::ZERO);
    let direction = |v: Vec2| place(v) - origin;
    let turn = |a: f64| if mirror { -a } else { a };
    let mut bodies = bodies();
    if mirror {
        for disk in bodies.iter_mut().flat_map(|body| &mut body.disks) {
            disk.position.y = -disk.position.y;
        }
        bodies.iter_mut().for_each(|body| body.disks.reverse());
    }
    let mapped = |motions: Vec<(Pose, Twist)>| -> Vec<(Pose, Twist)> {
        let of = |(pose, twist): (Pose, Twist)| {
            let pose = Pose { position: place(pose.position), orientation: angle(pose.orientation) };
            let (velocity, angular_velocity) = (direction(twist.velocity), turn(twist.angular_velocity));
            (pose, Twist { velocity, angular_velocity })
        };
        motions.into_iter().map(of).collect()
    };
    let there = run(&bodies, &CORNERS.map(|(x, y)| place(vec2(x, y))), &mapped(start()))?;
    Ok(farthest(&mapped(motions(&as_is()?)), &motions(&there)))
}

fn farthest(a: &[(Pose, Twist)], b: &[(Pose, Twist)]) -> f64 {
    largest(a.iter().zip(b).map(|(a, b)| apart(a, b)))
}

fn reversed() -> Result<f64> {
    let (mut bodies, mut first) = (bodies(), start());
    bodies.reverse();
    first.reverse();
    let there = run(&bodies, &CORNERS.map(|(x, y)| vec2(x, y)), &first)?;
    let mut back = motions(&there);
    back.reverse();
    Ok(farthest(&motions(&as_is()?), &back))
}
