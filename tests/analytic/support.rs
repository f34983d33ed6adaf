//! Small scenes.

use crowd_mechanics::engine::*;

pub const FREE: f64 = 0.0;

/// One material, one law.
pub fn laws(law: PairLaw) -> LawTable {
    let mut laws = LawTable::new(1);
    laws.set(0, 0, law);
    laws
}

pub const ELASTIC: PairLaw = PairLaw {
    normal_stiffness: 2.5e6,
    tangential_stiffness: 1.8e6,
    normal_damping: 0.0,
    tangential_damping: 0.0,
    friction: 0.0,
};

/// The paper's body–body contact (App. C, human_naked on human_naked).
pub const BODIES: PairLaw = PairLaw {
    normal_stiffness: 2_507_883.0,
    tangential_stiffness: 1_779_785.0,
    normal_damping: 700.0,
    tangential_damping: 700.0,
    friction: 0.4,
};

/// A round body of one disk.
pub fn disk(mass: f64, radius: f64) -> BodySpec {
    BodySpec {
        mass,
        inertia: 0.5 * mass * radius * radius,
        translation_rate: FREE,
        rotation_rate: FREE,
        disks: vec![DiskSpec { radius, position: Vec2::ZERO, material: 0 }],
    }
}

/// The five disks of the paper's agent 0 (App. C), gaze along +x.
pub fn pedestrian(mass: f64, rate: f64) -> BodySpec {
    let shape = [
        (0.09495, -0.015458, 0.153544),
        (0.13058, 0.008692, 0.067374),
        (0.1365, 0.013532, 4e-06),
        (0.13058, 0.008692, -0.067376),
        (0.09495, -0.015458, -0.153546),
    ];
    BodySpec {
        mass,
        inertia: 1.85 * mass / 89.0,
        translation_rate: rate,
        rotation_rate: rate,
        disks: shape
            .iter()
            .map(|&(radius, x, y)| DiskSpec { radius, position: vec2(x, y), material: 0 })
            .collect(),
    }
}

pub fn at(x: f64, y: f64) -> Pose {
    Pose { position: vec2(x, y), orientation: 0.0 }
}

pub fn moving(x: f64, y: f64) -> Twist {
    Twist { velocity: vec2(x, y), angular_velocity: 0.0 }
}

pub fn wall(corners: &[(f64, f64)]) -> WallSpec {
    WallSpec { material: 0, corners: corners.iter().map(|&(x, y)| vec2(x, y)).collect() }
}

pub fn world(
    bodies: &[BodySpec],
    walls: &[WallSpec],
    law: PairLaw,
    motions: &[(Pose, Twist)],
    mechanical_step: f64,
) -> World {
    let scene = Scene::new(bodies, walls, &laws(law)).expect("every pair has the law");
    let (poses, twists) = motions.iter().copied().unzip();
    World::new(scene, State::new(poses, twists), mechanical_step)
}

pub fn momentum(world: &World) -> Vec2 {
    let bodies = world.scene().bodies.iter().zip(&world.state().twists);
    bodies.fold(Vec2::ZERO, |sum, (body, twist)| sum + twist.velocity * body.mass)
}

pub fn angular_momentum(world: &World) -> f64 {
    let state = world.state();
    let motions = state.poses.iter().zip(&state.twists);
    world
        .scene()
        .bodies
        .iter()
        .zip(motions)
        .map(|(body, (pose, twist))| {
            body.mass * pose.position.cross(twist.velocity) + body.inertia * twist.angular_velocity
        })
        .sum()
}

pub fn kinetic_energy(world: &World) -> f64 {
    let bodies = world.scene().bodies.iter().zip(&world.state().twists);
    bodies
        .map(|(body, twist)| {
            0.5 * body.mass * twist.velocity.norm_squared()
                + 0.5 * body.inertia * twist.angular_velocity * twist.angular_velocity
        })
        .sum()
}
