//! Small scenes for tests, checks and benchmarks: people who are placed in a world or a Trial, and what is measured of
//! them.

pub mod bare;

use crate::engine::*;
use lemons_core::plane::Motion;
use lemons_core::trial::{Agent, AgentDynamics, ShapeElement, Trial};
use std::f64::consts::TAU;

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

/// \[kg\] Mass of the paper's agent 0 (App. C).
pub const MASS: f64 = 89.0;
/// \[1/s\] A usual relaxation rate.
pub const RATE: f64 = 4.5;

/// A body, and how it moves at first.
#[derive(Debug, Clone)]
#[allow(missing_docs)]
pub struct PlacedBody {
    pub body: BodySpec,
    pub pose: Pose,
    pub twist: Twist,
}

impl PlacedBody {
    /// Puts it at a place \[m\].
    pub fn at(mut self, x: f64, y: f64) -> PlacedBody {
        self.pose.position = vec2(x, y);
        self
    }

    /// Turns its gaze, which else is along +x, to an angle \[rad\].
    pub fn turned(mut self, angle: f64) -> PlacedBody {
        self.pose.orientation = angle;
        self
    }

    /// Gives it a velocity \[m/s\].
    pub fn moving(mut self, x: f64, y: f64) -> PlacedBody {
        self.twist.velocity = vec2(x, y);
        self
    }

    /// Gives it an angular velocity \[rad/s\].
    pub fn spinning(mut self, angular_velocity: f64) -> PlacedBody {
        self.twist.angular_velocity = angular_velocity;
        self
    }

    /// Gives it relaxation rates \[1/s\] of velocity and angular velocity.
    pub fn relaxing(mut self, translation: f64, rotation: f64) -> PlacedBody {
        (self.body.translation_rate, self.body.rotation_rate) = (translation, rotation);
        self
    }

    /// Gives it another relaxation rate \[1/s\] of the velocity across the gaze.
    pub fn relaxing_across(mut self, rate: f64) -> PlacedBody {
        self.body.across_rate = Some(rate);
        self
    }

    /// Gives it another moment of inertia \[kg.m2\].
    pub fn of_inertia(mut self, inertia: f64) -> PlacedBody {
        self.body.inertia = inertia;
        self
    }
}

fn placed(mass: f64, inertia: f64, disks: &[(f64, f64, f64)]) -> PlacedBody {
    let disk = |&(radius, x, y): &(f64, f64, f64)| DiskSpec { radius, position: vec2(x, y), material: 0 };
    let disks = disks.iter().map(disk).collect();
    let body =
        BodySpec { mass, inertia, translation_rate: 0.0, across_rate: None, rotation_rate: 0.0, disks };
    PlacedBody { body, pose: Pose::default(), twist: Twist::default() }
}

/// Returns a round body of one disk at the origin, at rest, without relaxation.
pub fn disk(mass: f64, radius: f64) -> PlacedBody {
    placed(mass, 0.5 * mass * radius * radius, &[(radius, 0.0, 0.0)])
}

/// Returns a body with the five disks of the paper's agent 0 (App. C), and one relaxation rate \[1/s\].
pub fn pedestrian(mass: f64, rate: f64) -> PlacedBody {
    let shape = [
        (0.09495, -0.015458, 0.153544),
        (0.13058, 0.008692, 0.067374),
        (0.1365, 0.013532, 4e-06),
        (0.13058, 0.008692, -0.067376),
        (0.09495, -0.015458, -0.153546),
    ];
    placed(mass, 1.85 * mass / 89.0, &shape).relaxing(rate, rate)
}

/// The paper's body on concrete (App. C).
pub const CONCRETE: PairLaw = PairLaw {
    normal_stiffness: 4_987_000.0,
    tangential_stiffness: 3_530_000.0,
    normal_damping: 1230.0,
    tangential_damping: 1230.0,
    friction: 0.5,
};

/// Returns a world of one material, without drive; its walls run through corners \[m\].
///
/// # Panics
/// Never: every pair has the law, and there are few bodies.
pub fn world(people: &[PlacedBody], walls: &[&[(f64, f64)]], law: PairLaw, mechanical_step: f64) -> World {
    let corner = |&(x, y): &(f64, f64)| vec2(x, y);
    let wall =
        |corners: &&[(f64, f64)]| WallSpec { material: 0, corners: corners.iter().map(corner).collect() };
    let walls: Vec<WallSpec> = walls.iter().map(wall).collect();
    let mut laws = LawTable::new(1);
    laws.set(0, 0, law);
    world_of(people, &walls, laws, mechanical_step)
}

/// Returns a world of several materials.
///
/// # Panics
/// A pair that may touch has no law.
pub fn world_of(people: &[PlacedBody], walls: &[WallSpec], laws: LawTable, mechanical_step: f64) -> World {
    let bodies: Vec<BodySpec> = people.iter().map(|person| person.body.clone()).collect();
    let scene = Scene::new(&bodies, walls, laws);
    let (poses, twists) = people.iter().map(|person| (person.pose, person.twist)).unzip();
    World::new(scene, State::new(poses, twists), mechanical_step).expect("few bodies")
}

/// Returns a closed regular polygon of radius 1 m about the origin.
pub fn polygon(sides: u32) -> Vec<(f64, f64)> {
    let corner = |k: u32| {
        let (sin, cos) = libm::sincos(TAU * f64::from(k % sides) / f64::from(sides));
        (cos, sin)
    };
    (0..=sides).map(corner).collect()
}

/// Puts people into a Trial, each like its first one, of the material of that one's first disk.
pub fn populate(trial: &mut Trial, people: &[PlacedBody]) {
    let (someone, still) = (trial.agents[0].clone(), trial.dynamics[0].clone());
    let shape = |disk: &DiskSpec| ShapeElement {
        radius: disk.radius,
        position: disk.position,
        ..someone.shapes[0].clone()
    };
    let agent = |(k, person): (usize, &PlacedBody)| Agent {
        id: k.to_string(),
        mass: person.body.mass,
        moment_of_inertia: person.body.inertia,
        shapes: person.body.disks.iter().map(shape).collect(),
        ..someone.clone()
    };
    let moving = |person: &PlacedBody| AgentDynamics {
        fp: still.fp,
        mp: still.mp,
        ..AgentDynamics::of(&Motion { pose: person.pose, twist: person.twist })
    };
    trial.agents = people.iter().enumerate().map(agent).collect();
    trial.dynamics = people.iter().map(moving).collect();
}

/// Returns the momentum \[kg.m/s\].
pub fn momentum(world: &World) -> Vec2 {
    let bodies = world.scene().bodies.iter().zip(&world.state().twists);
    bodies.fold(Vec2::zeros(), |sum, (body, twist)| sum + twist.velocity * body.mass)
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
            body.mass * pose.position.perp(&twist.velocity) + body.inertia * twist.angular_velocity
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
pub fn motions(world: &World) -> Vec<Motion> {
    let state = world.state();
    state.poses.iter().zip(&state.twists).map(|(&pose, &twist)| Motion { pose, twist }).collect()
}

/// Returns the motion of these numbers: x, y, orientation, their rates.
pub fn motion(&[x, y, orientation, vx, vy, angular_velocity]: &[f64; 6]) -> Motion {
    Motion {
        pose: Pose { position: vec2(x, y), orientation },
        twist: Twist { velocity: vec2(vx, vy), angular_velocity },
    }
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
    [(law.normal_stiffness, contact.depth), (law.tangential_stiffness, contact.elongation)]
        .map(|(stiffness, length)| 0.5 * scene.share(contact.pair) * stiffness * length.powi(2))
}

/// Returns the kinetic energy and that of all springs \[J\].
pub fn energy(world: &World) -> f64 {
    let contacts = world.contacts().contacts.iter();
    kinetic_energy(world) + contacts.flat_map(|contact| stored(world.scene(), contact)).sum::<f64>()
}

/// Returns two disks pressed together, to be twisted well below the limit of sticking.
pub fn pressed_together(mechanical_step: f64) -> World {
    let first = disk(80.0, 0.2).moving(0.05, 0.0).relaxing(2.0, 2.0);
    let second = disk(60.0, 0.25).at(0.449, 0.0).relaxing(2.0, 2.0);
    let law = PairLaw { friction: 5.0, ..BODIES };
    let mut world = world(&[first, second], &[], law, mechanical_step);
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
    let below = [(-1.0, -0.5), (spacing * f64::from(side) + 3.0, -0.5)];
    world(&on_lattice(side, [spacing; 2], 4.5), &[&below], BODIES, mechanical_step)
}

/// Returns pedestrians of 70 kg with this relaxation rate \[1/s\] on a square lattice, columns and rows so far apart
/// \[m\].
pub fn on_lattice(side: u32, [x, y]: [f64; 2], rate: f64) -> Vec<PlacedBody> {
    let person = |k: u32| {
        let (column, row, k) = (f64::from(k % side), f64::from(k / side), f64::from(k));
        let person = pedestrian(70.0, rate).at(x * column, y * row).turned(0.7 * k);
        person.moving(libm::sin(1.3 * k), libm::cos(2.1 * k))
    };
    (0..side * side).map(person).collect()
}

/// Returns pedestrians on a lattice \[m\] in a closed box, slightly shifted and turned \[rad\], and the corners of the box.
pub fn in_a_box(
    agents: usize,
    spacing: Vec2,
    turned: f64,
    numbers: &mut Random,
) -> (Vec<PlacedBody>, [(f64, f64); 5]) {
    let columns = ((agents as f64 * spacing.y / spacing.x).sqrt().round() as usize).max(1);
    let person = |k: usize| {
        let x = spacing.x * ((k % columns) as f64 + 0.5) + 0.01 * numbers.signed();
        let y = spacing.y * ((k / columns) as f64 + 0.5) + 0.01 * numbers.signed();
        pedestrian(MASS, RATE).at(x, y).turned(turned * numbers.signed())
    };
    let people = (0..agents).map(person).collect();
    let (width, height) = (spacing.x * columns as f64, spacing.y * agents.div_ceil(columns) as f64);
    (people, [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height), (0.0, 0.0)])
}

/// Puts such a crowd into a Trial, each pushing in another direction; materials and all else are those of the Trial.
pub fn crowded(mut trial: Trial, agents: usize, spacing: Vec2) -> Trial {
    let mut numbers = Random(30);
    let (people, around) = in_a_box(agents, spacing, 0.5, &mut numbers);
    "crowd".clone_into(&mut trial.name);
    (trial.parameters.time_step, trial.parameters.time_step_mechanical) = (0.1, 1e-5);
    trial.geometry.walls.truncate(1);
    trial.geometry.walls[0].corners = around.map(|(x, y)| vec2(x, y)).to_vec();
    trial.geometry.dimensions = Some(trial.geometry.walls[0].corners[2]);
    populate(&mut trial, &people);
    for of in &mut trial.dynamics {
        of.fp = vec2(100.0 * numbers.signed(), 100.0 * numbers.signed());
        of.mp = numbers.signed();
    }
    trial
}
