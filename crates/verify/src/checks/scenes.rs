//! Small scenes for checks and tests.

use crowd_mechanics::engine::*;

/// \[1/s\] Relaxation rate zero.
pub const FREE: f64 = 0.0;

/// Returns a table of one material with this law.
pub fn laws(law: PairLaw) -> LawTable {
    let mut laws = LawTable::new(1);
    laws.set(0, 0, law);
    laws
}

/// Springs only.
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

/// Returns a round body of one disk.
pub fn disk(mass: f64, radius: f64) -> BodySpec {
    BodySpec {
        mass,
        inertia: 0.5 * mass * radius * radius,
        translation_rate: FREE,
        rotation_rate: FREE,
        disks: vec![DiskSpec { radius, position: Vec2::ZERO, material: 0 }],
    }
}

/// Returns a body with the five disks of the paper's agent 0 (App. C), gaze along +x.
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

/// The paper's body on concrete (App. C).
pub const CONCRETE: PairLaw = PairLaw {
    normal_stiffness: 4_987_000.0,
    tangential_stiffness: 3_530_000.0,
    normal_damping: 1230.0,
    tangential_damping: 1230.0,
    friction: 0.5,
};

/// Returns a pose with the gaze along +x.
pub fn at(x: f64, y: f64) -> Pose {
    Pose { position: vec2(x, y), orientation: 0.0 }
}

/// Returns a motion without rotation.
pub fn moving(x: f64, y: f64) -> Twist {
    Twist { velocity: vec2(x, y), angular_velocity: 0.0 }
}

/// Returns a wall through corners \[m\].
pub fn wall(corners: &[(f64, f64)]) -> WallSpec {
    WallSpec { material: 0, corners: corners.iter().map(|&(x, y)| vec2(x, y)).collect() }
}

/// Returns a world of one material, without drive.
///
/// # Panics
/// Never: every pair has the law, and there are few bodies.
pub fn world(
    bodies: &[BodySpec],
    walls: &[WallSpec],
    law: PairLaw,
    motions: &[(Pose, Twist)],
    mechanical_step: f64,
) -> World {
    let scene = Scene::new(bodies, walls, &laws(law)).expect("every pair has the law");
    let (poses, twists) = motions.iter().copied().unzip();
    World::new(scene, State::new(poses, twists), mechanical_step).expect("few bodies")
}

/// Returns the momentum \[kg.m/s\].
pub fn momentum(world: &World) -> Vec2 {
    let bodies = world.scene().bodies.iter().zip(&world.state().twists);
    bodies.fold(Vec2::ZERO, |sum, (body, twist)| sum + twist.velocity * body.mass)
}

/// Returns the angular momentum about the origin \[kg.m2/s\].
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

/// Returns the kinetic energy \[J\].
pub fn kinetic_energy(world: &World) -> f64 {
    let bodies = world.scene().bodies.iter().zip(&world.state().twists);
    bodies
        .map(|(body, twist)| {
            0.5 * body.mass * twist.velocity.norm_squared()
                + 0.5 * body.inertia * twist.angular_velocity * twist.angular_velocity
        })
        .sum()
}

/// Returns pedestrians of different orientations on a square lattice \[m\], running in all directions, and a wall below
/// them.
pub fn lattice(side: u32, spacing: f64, mechanical_step: f64) -> World {
    let bodies: Vec<BodySpec> = (0..side * side).map(|_| pedestrian(70.0, 4.5)).collect();
    let motions: Vec<(Pose, Twist)> = (0..side * side)
        .map(|k| {
            let (column, row, k) = (f64::from(k % side), f64::from(k / side), f64::from(k));
            let pose = Pose { position: vec2(spacing * column, spacing * row), orientation: 0.7 * k };
            (pose, moving(libm::sin(1.3 * k), libm::cos(2.1 * k)))
        })
        .collect();
    let below = wall(&[(-1.0, -0.5), (spacing * f64::from(side) + 3.0, -0.5)]);
    world(&bodies, &[below], BODIES, &motions, mechanical_step)
}
