//! Drives that change linearly during a communication step.

use crate::checks::collision::{Push, errors_in_oblique_contact};
use crate::checks::error::{Result, ensure};
use crate::checks::scenes::*;
use crate::checks::{Check, farthest_apart, largest};
use crowd_mechanics::engine::*;

pub(crate) const CHECKS: &[Check] = &[
    Check::new("free under a ramp, relaxing or not, shortlisted", "closed form", "SI", 1e-10, || {
        free(Shortlisting::On)
    }),
    Check::new("the same, 100 000 mechanical steps in each step", "closed form", "SI", 1e-10, || {
        free(Shortlisting::Off)
    }),
    Check::new("the same, in one step of 0.1 s", "in ten of 0.01 s", "SI", 1e-12, free_in_pieces),
    Check::new(
        "a ramp in a contact, in one step of 0.1 s",
        "in ten of 0.01 s",
        "SI",
        1e-9,
        contact_in_pieces,
    ),
    Check::new("the same: order short of 3", "halving the step four times", "", 0.1, order_in_pieces),
    Check::new(
        "order in an oblique contact under a ramp: |ratio of errors − 4|",
        "Runge–Kutta, fourth order",
        "",
        0.15,
        order,
    ),
    Check::new("a ramp pushes through a row within one step", "no shortlist", "m", 1e-9, row),
    Check::new(
        "a push that grows from zero, by rates, H = 0.1 s",
        "drive set each 12 µs",
        "m, rad",
        1e-6,
        || Ok(errors_of_push(Between::Rates)?[0].1),
    ),
    Check::new(
        "the same, held: |ratio of errors − 2| as H is halved",
        "2: first order",
        "",
        0.2,
        order_of_held,
    ),
];

/// Adds rate × time \[s\] to a drive.
fn later(drive: Wrench, rate: Wrench, time: f64) -> Wrench {
    Wrench { force: drive.force + rate.force * time, torque: drive.torque + rate.torque * time }
}

/// Position and velocity at a time under the acceleration `a + j t` and a relaxation rate, computed from the steady
/// motion to which the velocity relaxes.
fn under_ramp(rate: f64, [r, v, a, j]: [f64; 4], t: f64) -> [f64; 2] {
    if rate == 0.0 {
        return [r + v * t + a * t * t / 2.0 + j * t.powi(3) / 6.0, v + a * t + j * t * t / 2.0];
    }
    let (steady, growth) = (a / rate - j / (rate * rate), j / rate);
    let kept = (-rate * t).exp();
    [
        r + steady * t + growth * t * t / 2.0 + (v - steady) * (1.0 - kept) / rate,
        steady + growth * t + (v - steady) * kept,
    ]
}

/// Two steps of 1 s under the same ramp.
fn free(shortlisting: Shortlisting) -> Result<f64> {
    let mut worst: f64 = 0.0;
    for (rate, turning_rate) in [(FREE, FREE), (4.5, 3.0)] {
        let mut body = pedestrian(70.0, rate);
        body.rotation_rate = turning_rate;
        let start = Twist { velocity: vec2(0.6, -0.4), angular_velocity: 1.0 };
        let mut world = world(std::slice::from_ref(&body), &[], BODIES, &[(at(0.0, 0.0), start)], 1e-5);
        world.shortlisting = shortlisting;
        let drive = Wrench { force: vec2(-50.0, 20.0), torque: 1.5 };
        world.drive_rate[0] = Wrench { force: vec2(40.0, -60.0), torque: -1.2 };
        let ramp = world.drive_rate[0];
        for step in 1..=2 {
            world.drive[0] = later(drive, ramp, f64::from(step - 1));
            world.advance(1.0)?;
            let t = f64::from(step);
            let (pose, twist) = (world.state().poses[0], world.state().twists[0]);
            let lightness = 1.0 / body.mass;
            let [x, vx] =
                under_ramp(rate, [0.0, 0.6, drive.force.x * lightness, ramp.force.x * lightness], t);
            let [y, vy] =
                under_ramp(rate, [0.0, -0.4, drive.force.y * lightness, ramp.force.y * lightness], t);
            let per_inertia = [0.0, 1.0, drive.torque / body.inertia, ramp.torque / body.inertia];
            let [theta, omega] = under_ramp(turning_rate, per_inertia, t);
            worst = largest([
                worst,
                (pose.position - vec2(x, y)).norm(),
                (twist.velocity - vec2(vx, vy)).norm(),
                (pose.orientation - theta).abs(),
                (twist.angular_velocity - omega).abs(),
            ]);
        }
        ensure!((world.work().shortlisted > 0) == (shortlisting == Shortlisting::On), "not as asked");
    }
    Ok(worst)
}

/// Largest difference of poses and velocities between a ramp of 0.1 s in one step and in ten.
fn in_pieces(scene: impl Fn() -> World) -> Result<f64> {
    let (mut whole, mut pieces) = (scene(), scene());
    let (drive, rate) = (whole.drive.clone(), whole.drive_rate.clone());
    ensure!(rate.iter().any(|rate| *rate != Wrench::default()), "it is a ramp");
    whole.advance(0.1)?;
    for piece in 0..10 {
        for (b, rate) in rate.iter().enumerate() {
            pieces.drive[b] = later(drive[b], *rate, 0.01 * f64::from(piece));
        }
        pieces.advance(0.01)?;
    }
    Ok(apart(whole.state(), pieces.state()))
}

/// Largest difference of poses and velocities.
fn apart(a: &State, b: &State) -> f64 {
    let twists = a.twists.iter().zip(&b.twists).flat_map(|(a, b)| {
        [(a.velocity - b.velocity).norm(), (a.angular_velocity - b.angular_velocity).abs()]
    });
    largest(twists.chain([apart_in_pose(a, b)]))
}

fn apart_in_pose(a: &State, b: &State) -> f64 {
    let poses = a.poses.iter().zip(&b.poses);
    largest(
        poses.flat_map(|(a, b)| [(a.position - b.position).norm(), (a.orientation - b.orientation).abs()]),
    )
}

fn free_in_pieces() -> Result<f64> {
    let differences = [Shortlisting::On, Shortlisting::Off].map(|shortlisting| {
        in_pieces(|| {
            let start = Twist { velocity: vec2(1.2, -0.4), angular_velocity: 2.0 };
            let mut world = world(&[pedestrian(70.0, 4.5)], &[], BODIES, &[(at(0.0, 0.0), start)], 1e-5);
            world.shortlisting = shortlisting;
            world.drive[0] = Wrench { force: vec2(50.0, 20.0), torque: 1.5 };
            world.drive_rate[0] = Wrench { force: vec2(4000.0, -900.0), torque: -70.0 };
            world
        })
    });
    let [on, off] = differences;
    Ok(largest([on?, off?]))
}

/// Two disks pressed together with a growing twist, well below the limit of sticking.
fn pressed_together(mechanical_step: f64) -> World {
    let mut bodies = [disk(80.0, 0.2), disk(60.0, 0.25)];
    for body in &mut bodies {
        (body.translation_rate, body.rotation_rate) = (2.0, 2.0);
    }
    let law = PairLaw { friction: 5.0, ..BODIES };
    let motions = [(at(0.0, 0.0), moving(0.05, 0.0)), (at(0.449, 0.0), moving(0.0, 0.0))];
    let mut world = world(&bodies, &[], law, &motions, mechanical_step);
    world.drive[0].force = vec2(2000.0, 0.0);
    world.drive[1].force = vec2(-2000.0, 0.0);
    world.drive_rate = vec![
        Wrench { force: vec2(9000.0, 0.0), torque: 100.0 },
        Wrench { force: vec2(-7000.0, 500.0), torque: 50.0 },
    ];
    world
}

/// Returns mechanical steps \[s\] and differences between one step and ten in a contact, for four halvings.
///
/// # Errors
/// The world did not advance.
pub fn pieces_in_contact() -> Result<Vec<(f64, f64)>> {
    (0..5)
        .map(|halvings| {
            let dt = 4e-5 / f64::from(1 << halvings);
            Ok((dt, in_pieces(|| pressed_together(dt))?))
        })
        .collect()
}

fn contact_in_pieces() -> Result<f64> {
    Ok(pieces_in_contact()?[2].1)
}

/// Every cut costs the error of one mechanical step, which is of third order.
fn order_in_pieces() -> Result<f64> {
    let differences = pieces_in_contact()?;
    let fall = differences[0].1 / differences[4].1;
    Ok((3.0 - fall.log2() / 4.0).max(0.0))
}

fn order() -> Result<f64> {
    let errors = errors_in_oblique_contact(&Push::RAMP)?;
    Ok(largest(errors.windows(2).map(|pair| (pair[0].1 / pair[1].1 - 4.0).abs())))
}

/// Standing people with gaps. The first is pushed with a growing force, another sways on the spot. Within one
/// communication step the push travels through all.
fn row() -> Result<f64> {
    let mut worlds = [Shortlisting::On, Shortlisting::Off].map(|shortlisting| {
        let bodies: Vec<BodySpec> = (0..6).map(|_| disk(70.0, 0.2)).collect();
        let motions: Vec<(Pose, Twist)> =
            (0..6).map(|k| (at(0.45 * f64::from(k), 0.0), moving(0.0, 0.0))).collect();
        let mut world = world(&bodies, &[], ELASTIC, &motions, 1e-5);
        world.shortlisting = shortlisting;
        world.drive_rate[0].force = vec2(4000.0, 0.0);
        world.drive[4].force = vec2(0.0, 10.0);
        world.drive_rate[4].force = vec2(0.0, -40.0);
        world
    });
    for world in &mut worlds {
        world.advance(0.5)?;
    }
    ensure!(worlds[0].state().twists[5].velocity.x > 1.0, "the push went through");
    Ok(farthest_apart(&worlds))
}

/// The drive between two communication points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Between {
    /// It is constant.
    Held,
    /// It changes linearly with its rate.
    Rates,
}

/// \[N/s\] Growth of the push of [`errors_of_push`], from zero.
const GROWTH: f64 = 2000.0;

/// Number of mechanical steps of [`errors_of_push`], 0.4 s in all: halved communication steps are integer multiples of
/// them.
const PUSH_STEPS: u32 = 1 << 15;

/// A person is pushed onto another 2 cm away, for 0.4 s in `steps` communication steps. `drive` returns the force \[N\]
/// at the start of a step; it changes by `rate` \[N/s\] until the next.
fn pushed(steps: u32, drive: impl Fn(f64) -> f64, rate: f64) -> Result<World> {
    let bodies = [pedestrian(89.0, 4.5), pedestrian(60.0, 4.5)];
    let motions = [(at(0.0, 0.0), moving(0.0, 0.0)), (at(0.293, 0.05), moving(0.0, 0.0))];
    let mut world = world(&bodies, &[], BODIES, &motions, 0.4 / f64::from(PUSH_STEPS));
    world.drive_rate[0].force.x = rate;
    let duration = 0.4 / f64::from(steps);
    for step in 0..steps {
        world.drive[0].force.x = drive(duration * f64::from(step));
        world.advance(duration)?;
    }
    ensure!(world.state().twists[1].velocity.x > 0.1, "the other was pushed");
    Ok(world)
}

/// Returns communication steps \[s\] and largest differences of poses \[m, rad\] after 0.4 s of a push that grows from
/// zero. The reference is the same push, constant at its mean value over each mechanical step.
///
/// # Errors
/// The world did not advance.
pub fn errors_of_push(between: Between) -> Result<Vec<(f64, f64)>> {
    let half_step = 0.2 / f64::from(PUSH_STEPS);
    let fine = pushed(PUSH_STEPS, |t| GROWTH * (t + half_step), 0.0)?;
    let rate = if between == Between::Rates { GROWTH } else { 0.0 };
    (2..8)
        .map(|halvings| {
            let steps = 1 << halvings;
            let world = pushed(steps, |t| GROWTH * t, rate)?;
            Ok((0.4 / f64::from(steps), apart_in_pose(world.state(), fine.state())))
        })
        .collect()
}

fn order_of_held() -> Result<f64> {
    let errors = errors_of_push(Between::Held)?;
    Ok(largest(errors.windows(2).map(|pair| (pair[0].1 / pair[1].1 - 2.0).abs())))
}
