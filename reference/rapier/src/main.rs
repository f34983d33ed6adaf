//! Runs Rapier for rapier.py: a task as JSON comes in, states and the processor time of the steps \[s\] go out.

use cpu_time::ProcessTime;
use rapier2d::prelude::*;
use serde::Deserialize;
use serde_json::json;
use std::error::Error;
use std::f32::consts::{PI, TAU};
use std::io::{stdin, stdout};

#[derive(Deserialize)]
struct Task {
    bodies: Vec<Body>,
    /// Both ends of each wall.
    walls: Vec<[f32; 4]>,
    wall_friction: f32,
    phases: Vec<Phase>,
}

#[derive(Deserialize)]
struct Phase {
    steps: usize,
    dt: f32,
    /// Of each body: force and torque.
    drives: Vec<[f32; 3]>,
}

#[derive(Deserialize)]
struct Body {
    /// x, y, theta, vx, vy, omega
    start: [f32; 6],
    mass: f32,
    inertia: f32,
    along: f32,
    angular: f32,
    disks: Vec<Disk>,
}

#[derive(Deserialize)]
struct Disk {
    x: f32,
    y: f32,
    radius: f32,
    restitution: f32,
    friction: f32,
}

/// Friction of two is the product: disks have the root of theirs, and walls what makes their own of it.
fn rules(collider: ColliderBuilder, friction: f32, restitution: f32) -> ColliderBuilder {
    collider
        .friction(friction)
        .friction_combine_rule(CoefficientCombineRule::Multiply)
        .restitution(restitution)
        .restitution_combine_rule(CoefficientCombineRule::Max)
}

fn main() -> Result<(), Box<dyn Error>> {
    let task: Task = serde_json::from_reader(stdin().lock())?;
    let mut world = PhysicsWorld { gravity: Vector::ZERO, ..PhysicsWorld::new() };
    let still = world.insert_body(RigidBodyBuilder::fixed());
    let mut walls = Vec::new();
    for &[ax, ay, bx, by] in &task.walls {
        let segment = ColliderBuilder::segment(Vector::new(ax, ay), Vector::new(bx, by));
        walls.push(world.insert_collider(rules(segment, task.wall_friction, 0.0), Some(still)));
    }
    let mut bodies = Vec::new();
    for body in &task.bodies {
        let [x, y, theta, vx, vy, omega] = body.start;
        let builder = RigidBodyBuilder::dynamic()
            .translation(Vector::new(x, y))
            .linvel(Vector::new(vx, vy))
            .angvel(omega)
            .linear_damping(body.along)
            .angular_damping(body.angular)
            .can_sleep(false)
            .additional_mass_properties(MassProperties::new(Vector::ZERO, body.mass, body.inertia));
        let handle = world.insert_body(builder);
        let mut disks = Vec::new();
        for disk in &body.disks {
            let ball =
                ColliderBuilder::ball(disk.radius).translation(Vector::new(disk.x, disk.y)).density(0.0);
            disks.push(world.insert_collider(rules(ball, disk.friction, disk.restitution), Some(handle)));
        }
        bodies.push((handle, disks, theta, 0.0));
    }
    let before = ProcessTime::now();
    for phase in &task.phases {
        world.integration_parameters.dt = phase.dt;
        for ((handle, ..), [x, y, torque]) in bodies.iter().zip(&phase.drives) {
            let body = &mut world.bodies[*handle];
            body.reset_forces(true);
            body.reset_torques(true);
            body.add_force(Vector::new(*x, *y), true);
            body.add_torque(*torque, true);
        }
        for _ in 0..phase.steps {
            world.step();
            for (handle, _, theta, last) in &mut bodies {
                // Its angle counts from the start, and jumps after half a turn.
                let angle = world.bodies[*handle].rotation().angle();
                *theta += (angle - *last + PI).rem_euclid(TAU) - PI;
                *last = angle;
            }
        }
    }
    let cost = before.elapsed();
    let states: Vec<_> = bodies
        .iter()
        .map(|(handle, disks, theta, _)| {
            let pairs = disks.iter().flat_map(|disk| walls.iter().map(|wall| (*disk, *wall)));
            let impulse: f32 =
                pairs.filter_map(|(disk, wall)| Some(world.contact_pair(disk, wall)?.total_impulse_magnitude())).sum();
            let body = &world.bodies[*handle];
            let (at, v) = (body.translation(), body.linvel());
            json!({"x": at.x, "y": at.y, "theta": theta, "vx": v.x, "vy": v.y, "omega": body.angvel(), "wall": impulse / world.integration_parameters.dt})
        })
        .collect();
    serde_json::to_writer(stdout(), &json!({"bodies": states, "cost": cost.as_secs_f64()}))?;
    Ok(())
}
