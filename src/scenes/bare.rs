//! The bare loop of a crowd: the contact law of the paper over a list of pairs that is given, and nothing else. It says what
//! is left to win.
//!
//! Missing are lists that are kept valid, contacts that begin or end within a step, corners of walls, exposures, blocks,
//! threads and free bodies. The step is symplectic, of first order.

use crate::engine::{BodyId, ContactDisk, DiskId, FreeFlight, PairLaw, Rotation, Vec2, World, Wrench, vec2};
use lemons_core::plane::{InPlane, rotation, turned_by};

/// The crowd of a world at one time.
pub struct BareCrowd {
    bodies: Vec<Body>,
    pairs: Vec<DiskPair>,
    faces: Vec<FacePair>,
    law: PairLaw,
    /// \[s\]
    step: f64,
    /// Of everybody, translation and rotation alike.
    flight: FreeFlight,
}

#[derive(Clone, Copy)]
struct Body {
    position: Vec2,
    orientation: f64,
    turn: Rotation,
    velocity: Vec2,
    angular_velocity: f64,
    load: Wrench,
    inverse_mass: f64,
    inverse_inertia: f64,
    /// \[m/s2\], \[rad/s2\]
    drive: Wrench,
}

struct DiskPair {
    bodies: [BodyId; 2],
    offsets: [Vec2; 2],
    radii: [f64; 2],
    elongation: f64,
}

struct FacePair {
    body: BodyId,
    offset: Vec2,
    radius: f64,
    start: Vec2,
    normal: Vec2,
    elongation: f64,
}

impl BareCrowd {
    /// Takes the crowd of a world, and the pairs that are nearer than a margin \[m\]. All have the law and the relaxation
    /// rate of the first one.
    pub fn of(world: &World, margin: f64) -> BareCrowd {
        let (scene, state) = (world.scene(), world.state());
        let body = |(b, of): (usize, &crate::engine::Body)| Body {
            position: state.poses[b].position,
            orientation: state.poses[b].orientation,
            turn: rotation(state.poses[b].orientation),
            velocity: state.twists[b].velocity,
            angular_velocity: state.twists[b].angular_velocity,
            load: Wrench::default(),
            inverse_mass: of.inverse_mass,
            inverse_inertia: of.inverse_inertia,
            drive: Wrench {
                force: world.drive[b].force * of.inverse_mass,
                torque: world.drive[b].torque * of.inverse_inertia,
            },
        };
        let mut crowd = BareCrowd {
            bodies: scene.bodies.iter().enumerate().map(body).collect(),
            pairs: Vec::new(),
            faces: Vec::new(),
            law: *scene.law(0, 0),
            step: world.mechanical_step,
            flight: FreeFlight::over(scene.bodies[0].translation_rate, world.mechanical_step),
        };
        let centres: Vec<Vec2> =
            (0..scene.disks.len()).map(|d| scene.centre(DiskId::from(d), &state.poses)).collect();
        for [first, second] in near(&centres, &scene.disks, margin) {
            let (one, other) = (&scene.disks[first], &scene.disks[second]);
            if one.body != other.body {
                crowd.pairs.push(DiskPair {
                    bodies: [one.body, other.body],
                    offsets: [one.offset, other.offset],
                    radii: [one.radius, other.radius],
                    elongation: 0.0,
                });
            }
        }
        for (first, one) in scene.disks.iter().enumerate() {
            for face in &scene.faces {
                if (centres[first] - face.start).dot(&face.normal).abs() < one.radius + margin {
                    let (start, normal) = (face.start, face.normal);
                    let (body, offset, radius) = (one.body, one.offset, one.radius);
                    crowd.faces.push(FacePair { body, offset, radius, start, normal, elongation: 0.0 });
                }
            }
        }
        crowd
    }

    /// Number of pairs, with those at walls.
    pub fn pairs(&self) -> usize {
        self.pairs.len() + self.faces.len()
    }

    /// \[m\] Where the bodies are.
    pub fn positions(&self) -> impl Iterator<Item = Vec2> {
        self.bodies.iter().map(|body| body.position)
    }

    /// Does some mechanical steps, and returns the number of contacts in all of them.
    #[inline(never)]
    pub fn advance(&mut self, steps: u64) -> u64 {
        (0..steps).map(|_| self.step()).sum()
    }

    #[inline(always)]
    fn step(&mut self) -> u64 {
        let BareCrowd { bodies, pairs, faces, law, step, flight } = self;
        let mut contacts = 0;
        for pair in pairs {
            let [i, j] = pair.bodies.map(BodyId::index);
            let (one, other) = (bodies[i], bodies[j]);
            let [arm, other_arm] = [one.turn * pair.offsets[0], other.turn * pair.offsets[1]];
            let between = (one.position + arm) - (other.position + other_arm);
            let (squared, reach) = (between.norm_squared(), pair.radii[0] + pair.radii[1]);
            if squared >= reach * reach {
                pair.elongation = 0.0;
                continue;
            }
            let distance = squared.sqrt();
            let (depth, normal) = (reach - distance, between * (1.0 / distance));
            let arm = arm + normal * (0.5 * depth - pair.radii[0]);
            let other_arm = other_arm - normal * (0.5 * depth - pair.radii[1]);
            let velocity = (one.velocity + arm.left() * one.angular_velocity)
                - (other.velocity + other_arm.left() * other.angular_velocity);
            let force = force(law, depth, normal, velocity, *step, &mut pair.elongation);
            bodies[i].load.force += force;
            bodies[i].load.torque += arm.perp(&force);
            bodies[j].load.force -= force;
            bodies[j].load.torque -= other_arm.perp(&force);
            contacts += 1;
        }
        for pair in faces {
            let body = &mut bodies[pair.body.index()];
            let arm = body.turn * pair.offset;
            let offset = (body.position + arm - pair.start).dot(&pair.normal);
            let (depth, normal) =
                (pair.radius - offset.abs(), if offset < 0.0 { -pair.normal } else { pair.normal });
            if depth <= 0.0 {
                pair.elongation = 0.0;
                continue;
            }
            let arm = arm + normal * (0.5 * depth - pair.radius);
            let velocity = body.velocity + arm.left() * body.angular_velocity;
            let force = force(law, depth, normal, velocity, *step, &mut pair.elongation);
            body.load.force += force;
            body.load.torque += arm.perp(&force);
            contacts += 1;
        }
        for body in bodies {
            let velocity = body.velocity + body.load.force * (body.inverse_mass * *step);
            let angular_velocity = body.angular_velocity + body.load.torque * (body.inverse_inertia * *step);
            let turned = angular_velocity * flight.velocity_time + body.drive.torque * flight.drive_time;
            body.position += velocity * flight.velocity_time + body.drive.force * flight.drive_time;
            body.orientation += turned;
            body.turn = turned_by(body.turn, turned);
            body.velocity = velocity * flight.kept + body.drive.force * flight.velocity_time;
            body.angular_velocity = angular_velocity * flight.kept + body.drive.torque * flight.velocity_time;
            body.load = Wrench { force: vec2(0.0, 0.0), torque: 0.0 };
        }
        contacts
    }
}

/// Returns the pairs of disks that are nearer than a margin \[m\], by their indices, sorted.
fn near(centres: &[Vec2], disks: &[ContactDisk], margin: f64) -> Vec<[usize; 2]> {
    let mut by_x: Vec<usize> = (0..centres.len()).collect();
    by_x.sort_by(|&a, &b| centres[a].x.total_cmp(&centres[b].x));
    let widest = disks.iter().map(|disk| disk.radius).fold(0.0, f64::max);
    let mut pairs = Vec::new();
    for (k, &one) in by_x.iter().enumerate() {
        for &other in &by_x[k + 1..] {
            let between = centres[other] - centres[one];
            if between.x > 2.0 * widest + margin {
                break;
            }
            if between.norm() < disks[one].radius + disks[other].radius + margin {
                pairs.push([one.min(other), one.max(other)]);
            }
        }
    }
    pairs.sort_unstable();
    pairs
}

/// \[N\] Returns the force on the first of a contact, and advances its spring.
#[inline(always)]
fn force(law: &PairLaw, depth: f64, normal: Vec2, velocity: Vec2, step: f64, elongation: &mut f64) -> Vec2 {
    let slip = velocity.dot(&normal.left());
    let pressure = law.normal_stiffness * depth - law.normal_damping * velocity.dot(&normal);
    *elongation += slip * step;
    let trial = -law.tangential_stiffness * *elongation - law.tangential_damping * slip;
    let limit = law.friction * pressure.abs();
    let tangential = if trial.abs() > limit {
        let sliding = limit.copysign(trial);
        *elongation = -(sliding + law.tangential_damping * slip) / law.tangential_stiffness;
        sliding
    } else {
        trial
    };
    normal * pressure + normal.left() * tangential
}
