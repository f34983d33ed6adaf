//! A floor that brakes the motion across the gaze at a rate of its own: wheels.

use crate::checks::ramp::{later, under_ramp};
use crate::checks::{Figure, Halved, Result, apart, ensure, halved, largest, shortfall};
use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;
use lemons_core::plane::Motion;

pub(crate) const FIGURES: &[Figure] = &[in_a_line, || Ok(shortfall(&errors_turning()?, 2.0)), one_rate];

/// \[1/s\] Rates along and across the gaze, and of the rotation.
const ALONG: f64 = 0.8;
const ACROSS: f64 = 30.0;
const TURN: f64 = 1.5;

/// \[rad\] The gaze at first.
const GAZE: f64 = 0.6;

const DRIVE: Wrench = Wrench { force: vec2(-50.0, 200.0), torque: 4.0 };
const GROWTH: Wrench = Wrench { force: vec2(400.0, -60.0), torque: -3.0 };

fn chair() -> PlacedBody {
    pedestrian(95.0, 0.0).turned(GAZE).moving(0.9, -0.7).relaxing(ALONG, TURN).relaxing_across(ACROSS)
}

/// A chair that does not turn, 2 s under a constant drive and under a ramp: the largest difference from the closed form
/// of each direction, however many mechanical steps there are.
fn in_a_line() -> Result<f64> {
    let start = chair();
    let (along, across) = (vec2(1.0, 0.0), vec2(0.0, 1.0));
    let axes = [along, across].map(|axis| rotation(GAZE) * axis);
    let mut worst = 0.0;
    for (growth, step) in [(Vec2::zeros(), 1e-4), (GROWTH.force, 1e-4), (GROWTH.force, 0.5)] {
        let mut world = world(std::slice::from_ref(&start), &[], BODIES, step);
        world.drive[0].force = DRIVE.force;
        world.drive_rate[0].force = growth;
        world.advance(2.0)?;
        ensure!(world.work().shortlisted == 0, "it moves by mechanical steps");
        let mass = start.body.mass;
        let parts = axes.iter().zip([ALONG, ACROSS]).map(|(axis, rate)| {
            let [a, j] = [DRIVE.force, growth].map(|force| force.dot(axis) / mass);
            under_ramp(rate, [0.0, start.twist.velocity.dot(axis), a, j], 2.0).map(|value| *axis * value)
        });
        let [place, velocity] = parts.fold([Vec2::zeros(); 2], |[r, v], [dr, dv]| [r + dr, v + dv]);
        let expected = motion(&[place.x, place.y, GAZE, velocity.x, velocity.y, 0.0]);
        worst = largest([worst, apart(&motions(&world), &[expected])]);
    }
    Ok(worst)
}

/// Rates of x, y, orientation, their rates, at a time, by the equations of motion (docs/guide/physics.md).
fn rates(body: &BodySpec, time: f64, [_, _, gaze, vx, vy, w]: [f64; 6]) -> [f64; 6] {
    let drive = later(DRIVE, GROWTH, time);
    let (sin, cos) = libm::sincos(gaze);
    let (along, across) = (cos * vx + sin * vy, cos * vy - sin * vx);
    let floor = [ALONG * along * cos - ACROSS * across * sin, ALONG * along * sin + ACROSS * across * cos];
    [
        vx,
        vy,
        w,
        drive.force.x / body.mass - floor[0],
        drive.force.y / body.mass - floor[1],
        drive.torque / body.inertia - TURN * w,
    ]
}

/// Integrates the equations of motion by the classical method of Runge and Kutta.
fn integrated(start: &PlacedBody, duration: f64, steps: u32) -> Motion {
    let dt = duration / f64::from(steps);
    let (pose, twist) = (start.pose, start.twist);
    let mut now = [
        pose.position.x,
        pose.position.y,
        pose.orientation,
        twist.velocity.x,
        twist.velocity.y,
        twist.angular_velocity,
    ];
    let moved = |from: [f64; 6], by: [f64; 6], time: f64| std::array::from_fn(|i| from[i] + by[i] * time);
    for step in 0..steps {
        let time = f64::from(step) * dt;
        let first = rates(&start.body, time, now);
        let second = rates(&start.body, time + 0.5 * dt, moved(now, first, 0.5 * dt));
        let third = rates(&start.body, time + 0.5 * dt, moved(now, second, 0.5 * dt));
        let fourth = rates(&start.body, time + dt, moved(now, third, dt));
        now = std::array::from_fn(|i| {
            now[i] + dt / 6.0 * (first[i] + 2.0 * second[i] + 2.0 * third[i] + fourth[i])
        });
    }
    motion(&now)
}

/// Returns mechanical steps \[s\] and errors of place, angle and velocities after 2 s of a chair that turns by some
/// radians, its drives growing.
fn errors_turning() -> Result<Halved> {
    let start = chair().spinning(2.0);
    let exact = integrated(&start, 2.0, 40_000);
    ensure!((exact.pose.orientation - GAZE).abs() > 1.0, "it turns");
    halved(2e-2, 5, |dt| {
        let mut world = world(std::slice::from_ref(&start), &[], BODIES, dt);
        (world.drive[0], world.drive_rate[0]) = (DRIVE, GROWTH);
        world.advance(2.0)?;
        Ok(apart(&motions(&world), &[exact]))
    })
}

/// Counts numbers of a crowd whose rate across is written, and is that along, unlike those of the crowd with one rate.
fn one_rate() -> Result<f64> {
    let people = on_lattice(6, [0.5; 2], 4.5);
    let written: Vec<PlacedBody> = people.iter().map(|person| person.clone().relaxing_across(4.5)).collect();
    let mut both = [people, written].map(|people| world(&people, &[], BODIES, 1e-4));
    for world in &mut both {
        world.advance(0.5)?;
    }
    ensure!(both[0].work().contacts > 0, "people meet");
    let unlike = |(a, b): (&Motion, &Motion)| u8::from(a != b);
    let [one, other] = both.each_ref().map(motions);
    Ok(one.iter().zip(&other).map(|pair| f64::from(unlike(pair))).sum())
}
