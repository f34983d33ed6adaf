//! Results do not depend on place, direction, mirror image and order.

use crate::checks::scenes::*;
use crate::checks::{Figure, Result, apart, ensure};
use crowd_mechanics::engine::*;
use lemons_core::plane::Motion;

pub(crate) const FIGURES: &[Figure] = &[
    || seen(&Seen { place: |v: Vec2| v + vec2(3.0, -7.0), angle: |a: f64| a, mirror: false }),
    || {
        seen(&Seen {
            place: |v: Vec2| v.rotated(Rotation::by(0.73)),
            angle: |a: f64| a + 0.73,
            mirror: false,
        })
    },
    || seen(&Seen { place: |v: Vec2| vec2(v.x, -v.y), angle: |a: f64| -a, mirror: true }),
    reversed,
];

/// A way to look at a scene: where places and angles are then.
pub struct Seen<P, A> {
    /// Maps places.
    pub place: P,
    /// Maps angles.
    pub angle: A,
    /// True if left is right then.
    pub mirror: bool,
}

impl<P: Fn(Vec2) -> Vec2, A: Fn(f64) -> f64> Seen<P, A> {
    /// Maps a motion.
    pub fn motion(&self, Motion { pose, twist }: Motion) -> Motion {
        let turn = if self.mirror { -1.0 } else { 1.0 };
        Motion {
            pose: Pose { position: (self.place)(pose.position), orientation: (self.angle)(pose.orientation) },
            twist: Twist {
                velocity: (self.place)(twist.velocity) - (self.place)(Vec2::ZERO),
                angular_velocity: turn * twist.angular_velocity,
            },
        }
    }

    /// Maps a body and how it moves: in a mirror, left and right shoulder change places.
    pub fn person(&self, person: &Placed) -> Placed {
        let mut body = person.body.clone();
        if self.mirror {
            body.disks.iter_mut().for_each(|disk| disk.position.y = -disk.position.y);
            body.disks.reverse();
        }
        let Motion { pose, twist } = self.motion(Motion { pose: person.pose, twist: person.twist });
        Placed { body, pose, twist }
    }
}

/// Twenty-five pedestrians shoulder to shoulder in a corner of walls, for 0.15 s: collisions amplify rounding errors of
/// places, here about tenfold in 0.05 s.
fn people() -> Vec<Placed> {
    let person = |k: u32| {
        let (x, y, k) = (0.36 * f64::from(k % 5), 0.46 * f64::from(k / 5), f64::from(k));
        pedestrian(60.0 + 2.0 * k, 4.5).at(x, y).turned(0.2 * k).moving(0.8, -0.5).spinning(0.3)
    };
    (0..25).map(person).collect()
}

const CORNERS: [(f64, f64); 3] = [(-1.0, -0.3), (1.7, -0.3), (1.7, 2.6)];

fn run(people: &[Placed], corners: &[(f64, f64)]) -> Result<Vec<Motion>> {
    let mut world = world(people, &[corners], BODIES, 1e-5);
    for _ in 0..3 {
        world.advance(0.05)?;
    }
    ensure!(world.work().contacts > 1000, "they met");
    Ok(motions(&world))
}

/// Returns the largest difference between the motion of the mapped scene and the mapped motion of the original scene.
fn seen<P: Fn(Vec2) -> Vec2, A: Fn(f64) -> f64>(seen: &Seen<P, A>) -> Result<f64> {
    let corners = CORNERS.map(|(x, y)| (seen.place)(vec2(x, y))).map(|corner| (corner.x, corner.y));
    let there = run(&people().iter().map(|person| seen.person(person)).collect::<Vec<_>>(), &corners)?;
    let here: Vec<Motion> = run(&people(), &CORNERS)?.into_iter().map(|motion| seen.motion(motion)).collect();
    Ok(apart(&here, &there))
}

fn reversed() -> Result<f64> {
    let mut people = people();
    let here = run(&people, &CORNERS)?;
    people.reverse();
    let mut back = run(&people, &CORNERS)?;
    back.reverse();
    Ok(apart(&here, &back))
}
