//! Drives that change linearly during a communication step.

use crate::checks::collision::{Push, errors_in_oblique_contact};
use crate::checks::error::{Result, ensure};
use crate::checks::scenes::*;
use crate::checks::{Check, apart, apart_in_pose, farthest_apart, halved, largest, off_ratio, shortfall};
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
    let drive = Wrench { force: vec2(-50.0, 20.0), torque: 1.5 };
    let ramp = Wrench { force: vec2(40.0, -60.0), torque: -1.2 };
    let start = Twist { velocity: vec2(0.6, -0.4), angular_velocity: 1.0 };
    flight(shortlisting, &[(FREE, FREE), (4.5, 3.0)], start, [drive, ramp], (2, 1.0))
}

/// The largest error of a free body with these relaxation rates, under a drive and its rate, after each of some steps
/// \[s\].
pub(crate) fn flight(
    shortlisting: Shortlisting,
    rates: &[(f64, f64)],
    start: Twist,
    [drive, ramp]: [Wrench; 2],
    (steps, duration): (u32, f64),
) -> Result<f64> {
    let mut worst: f64 = 0.0;
    for &(rate, turning_rate) in rates {
        let mut body = pedestrian(70.0, rate);
        body.rotation_rate = turning_rate;
        let mut world = world(std::slice::from_ref(&body), &[], BODIES, &[(at(0.0, 0.0), start)], 1e-5);
        world.shortlisting = shortlisting;
        world.drive_rate[0] = ramp;
        for step in 1..=steps {
            world.drive[0] = later(drive, ramp, duration * f64::from(step - 1));
            world.advance(duration)?;
            let t = duration * f64::from(step);
            let lightness = 1.0 / body.mass;
            let [x, vx] = under_ramp(
                rate,
                [0.0, start.velocity.x, drive.force.x * lightness, ramp.force.x * lightness],
                t,
            );
            let [y, vy] = under_ramp(
                rate,
                [0.0, start.velocity.y, drive.force.y * lightness, ramp.force.y * lightness],
                t,
            );
            let per_inertia =
                [0.0, start.angular_velocity, drive.torque / body.inertia, ramp.torque / body.inertia];
            let [orientation, angular_velocity] = under_ramp(turning_rate, per_inertia, t);
            let exact = (
                Pose { position: vec2(x, y), orientation },
                Twist { velocity: vec2(vx, vy), angular_velocity },
            );
            worst = largest([worst, apart(&motions(&world)[0], &exact)]);
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
    Ok(largest(motions(&whole).iter().zip(&motions(&pieces)).map(|(a, b)| apart(a, b))))
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

/// Two disks pressed together with a growing twist.
fn twisted(mechanical_step: f64) -> World {
    let mut world = pressed_together(mechanical_step);
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
    halved(4e-5, 5, |dt| in_pieces(|| twisted(dt)))
}

fn contact_in_pieces() -> Result<f64> {
    Ok(pieces_in_contact()?[2].1)
}

/// Every cut costs the error of one mechanical step, which is of third order.
fn order_in_pieces() -> Result<f64> {
    Ok(shortfall(&pieces_in_contact()?, 3.0))
}

fn order() -> Result<f64> {
    Ok(off_ratio(&errors_in_oblique_contact(&Push::RAMP)?, 4.0))
}

/// Standing people with gaps. The first is pushed with a growing force, another sways on the spot. Within one
/// communication step the push travels through all.
fn row() -> Result<f64> {
    let worlds = along_row(0.45, 0.0, |world| {
        world.drive_rate[0].force = vec2(4000.0, 0.0);
        world.drive[4].force = vec2(0.0, 10.0);
        world.drive_rate[4].force = vec2(0.0, -40.0);
    })?;
    ensure!(worlds[0].state().twists[5].velocity.x > 1.0, "the push went through");
    Ok(farthest_apart(&worlds))
}

/// Six people in a row, so far apart \[m\], of whom the first has a speed \[m/s\], after 0.5 s in one step: shortlisted
/// and not.
pub(crate) fn along_row(spacing: f64, speed: f64, push: impl Fn(&mut World)) -> Result<[World; 2]> {
    let run = |shortlisting| -> Result<World> {
        let bodies: Vec<BodySpec> = (0..6).map(|_| disk(70.0, 0.2)).collect();
        let mut motions: Vec<(Pose, Twist)> =
            (0..6).map(|k| (at(spacing * f64::from(k), 0.0), moving(0.0, 0.0))).collect();
        motions[0].1 = moving(speed, 0.0);
        let mut world = world(&bodies, &[], ELASTIC, &motions, 1e-5);
        world.shortlisting = shortlisting;
        push(&mut world);
        world.advance(0.5)?;
        Ok(world)
    };
    Ok([run(Shortlisting::On)?, run(Shortlisting::Off)?])
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
    halved(0.1, 6, |duration| {
        let world = pushed((0.4 / duration).round() as u32, |t| GROWTH * t, rate)?;
        let poses = world.state().poses.iter().zip(&fine.state().poses);
        Ok(largest(poses.map(|(a, b)| apart_in_pose(a, b))))
    })
}

fn order_of_held() -> Result<f64> {
    Ok(off_ratio(&errors_of_push(Between::Held)?, 2.0))
}
