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
    let scene = Scene::new(bodies, walls, laws(law));
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

/// Returns poses and twists of all bodies.
pub fn motions(world: &World) -> Vec<(Pose, Twist)> {
    world.state().poses.iter().copied().zip(world.state().twists.iter().copied()).collect()
}

/// Returns the law of a contact.
pub fn law_of<'a>(scene: &'a Scene, contact: &Contact) -> &'a PairLaw {
    let material = |disk: DiskId| scene.disks[disk.index()].material;
    match contact.pair {
        Pair::Disks { first, second } => scene.law(material(first), material(second)),
        Pair::Face { disk, face, .. } => scene.law(material(disk), scene.faces[face.index()].material),
    }
}

/// Returns the energies in the springs of a contact \[J\]: normal, tangential.
pub fn stored(scene: &Scene, contact: &Contact) -> [f64; 2] {
    let law = law_of(scene, contact);
    let (depth, elongation) = (contact.depth, contact.elongation);
    [0.5 * law.normal_stiffness * depth * depth, 0.5 * law.tangential_stiffness * elongation * elongation]
}

/// Returns two disks pressed together, to be twisted well below the limit of sticking.
pub fn pressed_together(mechanical_step: f64) -> World {
    let mut bodies = [disk(80.0, 0.2), disk(60.0, 0.25)];
    for body in &mut bodies {
        (body.translation_rate, body.rotation_rate) = (2.0, 2.0);
    }
    let law = PairLaw { friction: 5.0, ..BODIES };
    let motions = [(at(0.0, 0.0), moving(0.05, 0.0)), (at(0.449, 0.0), moving(0.0, 0.0))];
    let mut world = world(&bodies, &[], law, &motions, mechanical_step);
    world.drive[0].force = vec2(2000.0, 0.0);
    world.drive[1].force = vec2(-2000.0, 0.0);
    world
}

/// Random numbers, the same on every machine (SplitMix64).
pub struct Random(pub u64);

impl Random {
    fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Draws a number from 0 to 1.
    pub fn share(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Draws a number from −1 to 1.
    pub fn signed(&mut self) -> f64 {
        self.bits() as f64 / (1u64 << 63) as f64 - 1.0
    }

    /// Draws a number between two.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }
}

/// Returns pedestrians of different orientations on a square lattice \[m\], running in all directions, and a wall below
/// them.
pub fn lattice(side: u32, spacing: f64, mechanical_step: f64) -> World {
    let below = wall(&[(-1.0, -0.5), (spacing * f64::from(side) + 3.0, -0.5)]);
    crowd_on_lattice(side, spacing, 4.5, &below, BODIES, mechanical_step)
}

/// Returns such a crowd with another relaxation rate, wall and law.
pub fn crowd_on_lattice(
    side: u32,
    spacing: f64,
    rate: f64,
    below: &WallSpec,
    law: PairLaw,
    mechanical_step: f64,
) -> World {
    let bodies: Vec<BodySpec> = (0..side * side).map(|_| pedestrian(70.0, rate)).collect();
    let motions: Vec<(Pose, Twist)> = (0..side * side)
        .map(|k| {
            let (column, row, k) = (f64::from(k % side), f64::from(k / side), f64::from(k));
            let pose = Pose { position: vec2(spacing * column, spacing * row), orientation: 0.7 * k };
            (pose, moving(libm::sin(1.3 * k), libm::cos(2.1 * k)))
        })
        .collect();
    world(&bodies, std::slice::from_ref(below), law, &motions, mechanical_step)
}
