//! Results do not depend on place, direction, mirror image and order.

use crate::checks::{Figure, Result, apart, ensure};
use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;
use lemons_core::plane::Motion;

pub(crate) const FIGURES: &[Figure] = &[
    || seen(&Seen { shift: vec2(3.0, -7.0), ..Seen::default() }),
    || seen(&Seen { turn: 0.73, ..Seen::default() }),
    || seen(&Seen { mirror: true, ..Seen::default() }),
    reversed,
];

/// A way to look at a scene: in a mirror, then turned by an angle \[rad\], then shifted \[m\].
#[derive(Default)]
struct Seen {
    mirror: bool,
    turn: f64,
    shift: Vec2,
}

impl Seen {
    fn vector(&self, v: Vec2) -> Vec2 {
        rotation(self.turn) * vec2(v.x, self.hand() * v.y)
    }

    fn place(&self, place: Vec2) -> Vec2 {
        self.vector(place) + self.shift
    }

    fn hand(&self) -> f64 {
        if self.mirror { -1.0 } else { 1.0 }
    }

    fn motion(&self, Motion { pose, twist }: Motion) -> Motion {
        Motion {
            pose: Pose {
                position: self.place(pose.position),
                orientation: self.hand() * pose.orientation + self.turn,
            },
            twist: Twist {
                velocity: self.vector(twist.velocity),
                angular_velocity: self.hand() * twist.angular_velocity,
            },
        }
    }

    /// Maps a body and how it moves: in a mirror, left and right shoulder change places.
    fn person(&self, person: &PlacedBody) -> PlacedBody {
        let mut body = person.body.clone();
        if self.mirror {
            body.disks.iter_mut().for_each(|disk| disk.position.y = -disk.position.y);
            body.disks.reverse();
        }
        let Motion { pose, twist } = self.motion(Motion { pose: person.pose, twist: person.twist });
        PlacedBody { body, pose, twist }
    }
}

/// Twenty-five pedestrians of two materials shoulder to shoulder in a corner of walls, for 0.15 s: collisions amplify
/// rounding errors of places, here about tenfold in 0.05 s.
struct Case {
    people: Vec<PlacedBody>,
    walls: Vec<WallSpec>,
    /// Laws of two of the first material, of both, and of two of the second.
    laws: [PairLaw; 3],
}

impl Case {
    fn new() -> Case {
        let person = |k: u32| {
            let (x, y, material, k) = (0.36 * f64::from(k % 5), 0.46 * f64::from(k / 5), k % 2, f64::from(k));
            let mut person = pedestrian(60.0 + 2.0 * k, 4.5).at(x, y).turned(0.2 * k).moving(0.8, -0.5);
            person.body.disks.iter_mut().for_each(|disk| disk.material = material as usize);
            person.spinning(0.3)
        };
        let walls = [[vec2(-1.0, -0.3), vec2(1.7, -0.3)], [vec2(1.7, -0.3), vec2(1.7, 2.6)]];
        let wall =
            |(material, corners): (usize, &[Vec2; 2])| WallSpec { material, corners: corners.to_vec() };
        Case {
            people: (0..25).map(person).collect(),
            walls: walls.iter().enumerate().map(wall).collect(),
            laws: [0.4, 0.1, 0.7].map(|friction| PairLaw { friction, ..BODIES }),
        }
    }

    fn run(&self) -> Result<Vec<Motion>> {
        let mut laws = LawTable::new(2);
        for (pair, law) in [(0, 0), (0, 1), (1, 1)].into_iter().zip(self.laws) {
            laws.set(pair.0, pair.1, law);
        }
        let mut world = world_of(&self.people, &self.walls, laws, 1e-5);
        for _ in 0..3 {
            world.advance(0.05)?;
        }
        ensure!(world.work().contacts > 1000, "they met");
        Ok(motions(&world))
    }
}

/// Returns the largest difference between the motion of the mapped scene and the mapped motion of the original scene.
fn seen(seen: &Seen) -> Result<f64> {
    let mut case = Case::new();
    let here: Vec<Motion> = case.run()?.into_iter().map(|motion| seen.motion(motion)).collect();
    case.people.iter_mut().for_each(|person| *person = seen.person(person));
    for corner in case.walls.iter_mut().flat_map(|wall| &mut wall.corners) {
        *corner = seen.place(*corner);
    }
    Ok(apart(&here, &case.run()?))
}

/// Returns the largest difference if the order of agents, walls and materials is reversed.
fn reversed() -> Result<f64> {
    let mut case = Case::new();
    let here = case.run()?;
    case.people.reverse();
    case.walls.reverse();
    case.laws.reverse();
    let disks = case.people.iter_mut().flat_map(|person| &mut person.body.disks);
    let materials =
        disks.map(|disk| &mut disk.material).chain(case.walls.iter_mut().map(|wall| &mut wall.material));
    materials.for_each(|material| *material = 1 - *material);
    let mut back = case.run()?;
    back.reverse();
    Ok(apart(&here, &back))
}
