//! What is computed for the page: by the engine, from Trials with the shipped materials.

use crowd_mechanics::engine::World;
use crowd_mechanics::setup::Setup;
use lemons_people::{Person, Sex, Shape, TrialSettings, crowd_trial, walls};
use lemons_plane::{Pose, Ring, Rotation, Vec2, vec2};
use lemons_trial::{Geometry, Trial};
use std::f64::consts::PI;

pub type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// \[1/s\] 1/t_transl and 1/t_rot of the shipped Trial.
pub const FLOOR: f64 = 4.5;

/// The person of the page: 49 cm broad, 25 cm deep, 80 kg.
pub fn person() -> Person {
    Person { sex: Sex::Male, breadth: 0.49, depth: 0.25, stature: 1.75, mass: 80.0 }
}

/// Returns a Trial of such people at these poses with these velocities \[m/s\], on a floor with this rate \[1/s\].
pub fn trial(people: &[(Pose, Vec2)], rings: &[Ring], floor: f64) -> Result<Trial> {
    let shape = Shape::of(&person())?;
    let settings = TrialSettings { floor_damping: floor, angular_damping: floor, ..TrialSettings::default() };
    let poses: Vec<Pose> = people.iter().map(|(pose, _)| *pose).collect();
    let count = people.len();
    let geometry = if rings.is_empty() {
        Geometry { dimensions: None, walls: Vec::new() }
    } else {
        walls(rings, "concrete")
    };
    let mut trial =
        crowd_trial("physics", &vec![person(); count], &vec![shape; count], &poses, geometry, &settings)?;
    for (dynamics, (_, velocity)) in trial.dynamics.iter_mut().zip(people) {
        dynamics.velocity = *velocity;
        // Who walks at a steady speed pushes as much as the floor brakes.
        dynamics.fp = *velocity * (person().mass * floor);
    }
    Ok(trial)
}

pub fn at(x: f64, y: f64, orientation: f64) -> Pose {
    Pose { position: vec2(x, y), orientation }
}

/// One instant of a collision.
pub struct Instant {
    /// \[s\]
    pub time: f64,
    /// \[m\] overlap h.
    pub depth: f64,
    /// \[m/s\] v_n
    pub normal_speed: f64,
    /// \[N\] F_n, by the engine.
    pub force: f64,
}

/// A head-on collision.
pub struct Collision {
    /// The instants at which they touch.
    pub instants: Vec<Instant>,
    /// \[m/s\] Speed at which they part.
    pub parting: f64,
    /// \[N\] Peak squeeze.
    pub peak: f64,
    /// \[m\] Deepest overlap.
    pub deepest: f64,
}

/// \[m/s\] Speed at which they meet.
pub const CLOSING: f64 = 1.0;
/// \[s\] Time between two instants of a collision.
pub const APART: f64 = 1e-5;

/// Two people walk into each other, front to front, without a floor. They touch at time zero.
pub fn collision() -> Result<Collision> {
    let shape = Shape::of(&person())?;
    let front = shape.disks.iter().map(|disk| disk.centre.x + disk.radius).fold(0.0, f64::max);
    let half = vec2(0.5 * CLOSING, 0.0);
    let trial = trial(&[(at(-front, 0.0, 0.0), half), (at(front, 0.0, PI), -half)], &[], 0.0)?;
    let mut world = Setup::of(&trial).world()?;
    world.mechanical_step = 1e-6;
    let mut found = Collision { instants: Vec::new(), parting: 0.0, peak: 0.0, deepest: 0.0 };
    for k in 1..=1500 {
        world.advance(APART)?;
        if let [contact] = &world.contacts().contacts[..] {
            found.instants.push(Instant {
                time: APART * f64::from(k),
                depth: contact.depth,
                normal_speed: contact.normal_speed,
                force: contact.normal_force,
            });
        }
        found.peak = found.peak.max(world.exposures()[0].peak_force);
        found.deepest = found.deepest.max(world.largest_overlap());
    }
    let twists = &world.state().twists;
    found.parting = twists[1].velocity.x - twists[0].velocity.x;
    Ok(found)
}

/// \[N\], \[s\] A push, and how long it lasts.
pub const PUSH: (f64, f64) = (482.4, 1.2);

/// Returns times \[s\] and speeds \[m/s\] of a person who is alone, and is pushed from rest.
pub fn pushed() -> Result<Vec<(f64, f64)>> {
    let trial = trial(&[(at(0.0, 0.0, 0.0), Vec2::ZERO)], &[], FLOOR)?;
    let mut world = Setup::of(&trial).world()?;
    let mut speeds = vec![(0.0, 0.0)];
    for k in 1..=240 {
        let time = 0.01 * f64::from(k);
        world.drive[0].force.x = if time <= PUSH.1 + 1e-9 { PUSH.0 } else { 0.0 };
        world.advance(0.01)?;
        speeds.push((time, world.state().twists[0].velocity.x));
    }
    Ok(speeds)
}

/// \[s\] Communication step of [`walkers`].
pub const STEP: f64 = 0.2;

/// \[m\], \[rad\], \[m/s\] Where people in a passage are, and in which direction and how fast they walk.
const WALKERS: [(f64, f64, f64, f64); 13] = [
    (0.55, 2.25, 0.0, 1.3),
    (0.70, 1.00, 0.3, 1.1),
    (1.55, 0.36, 0.1, 1.2),
    (1.80, 1.75, -0.2, 1.4),
    (2.75, 2.25, 0.15, 1.2),
    (2.75, 1.10, 0.0, 1.5),
    (3.55, 1.15, PI, 1.3),
    (3.3, 2.05, 0.5, 0.8),
    (4.45, 2.25, 0.1, 1.3),
    (4.60, 1.35, 2.9, 1.2),
    (4.55, 0.45, -0.1, 1.4),
    (5.50, 1.80, -0.2, 1.3),
    (5.55, 0.85, 0.2, 1.1),
];

/// \[m\] The passage.
pub const PASSAGE: Vec2 = vec2(6.2, 2.7);

/// Somebody in the passage, and the circle that holds him during the communication step if nothing touches him.
pub struct Walker {
    pub pose: Pose,
    pub velocity: Vec2,
    pub centre: Vec2,
    pub radius: f64,
    /// Whether the circle is clear of all others and of the walls.
    pub free: bool,
}

/// \[m\] Circles nearer than this are not clear of each other (the engine's margin).
const CLEAR: f64 = 0.02;

pub fn passage() -> Result<Trial> {
    let people: Vec<(Pose, Vec2)> = WALKERS
        .iter()
        .map(|&(x, y, way, speed)| (at(x, y, way), vec2(speed, 0.0).rotated(Rotation::by(way))))
        .collect();
    let mut trial = trial(&people, &[], FLOOR)?;
    let wall = |id: usize, y: f64| lemons_trial::Wall {
        id: id.to_string(),
        material_id: "concrete".into(),
        corners: vec![vec2(0.0, y), vec2(PASSAGE.x, y)],
    };
    trial.geometry = Geometry { dimensions: Some(PASSAGE), walls: vec![wall(0, 0.0), wall(1, PASSAGE.y)] };
    Ok(trial)
}

/// Returns who is in the passage.
///
/// # Errors
/// The engine shortlists another number of them.
pub fn walkers(trial: &Trial) -> Result<Vec<Walker>> {
    let mut world = Setup::of(trial).world()?;
    let bodies = &world.scene().bodies;
    let mut walkers: Vec<Walker> = trial
        .dynamics
        .iter()
        .zip(bodies)
        .map(|(dynamics, body)| {
            // At a steady speed the path is a straight line.
            let path = dynamics.velocity * STEP;
            Walker {
                pose: Pose { position: dynamics.position, orientation: dynamics.theta },
                velocity: dynamics.velocity,
                centre: dynamics.position + path * 0.5,
                radius: body.bounding_radius + 0.5 * path.norm(),
                free: true,
            }
        })
        .collect();
    for k in 0..walkers.len() {
        let (centre, radius) = (walkers[k].centre, walkers[k].radius);
        let others = walkers.iter().enumerate().filter(|(other, _)| *other != k);
        let clear = others.map(|(_, w)| (w.centre - centre).norm() - w.radius - radius);
        let walls = (centre.y - radius).min(PASSAGE.y - centre.y - radius);
        walkers[k].free = clear.fold(walls, f64::min) > CLEAR;
    }
    let free = walkers.iter().filter(|walker| walker.free).count() as u64;
    advance(&mut world, 1, STEP)?;
    let found = world.work().shortlisted;
    if found != free {
        return Err(format!("{free} circles are clear, but the engine shortlists {found}").into());
    }
    Ok(walkers)
}

pub fn advance(world: &mut World, steps: u32, duration: f64) -> Result<()> {
    for _ in 0..steps {
        world.advance(duration)?;
    }
    Ok(())
}
