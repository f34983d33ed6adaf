//! Drives that change linearly during a communication step.

use crate::checks::collision::{RAMP, errors_in_oblique_contact};
use crate::checks::scenes::*;
use crate::checks::{Figure, Halved, Result};
use crate::checks::{apart, apart_in_pose, ensure, farthest_apart, halved, largest, off_ratio, shortfall};
use crowd_mechanics::engine::*;
use lemons_core::plane::Motion;

pub(crate) const FIGURES: &[Figure] = &[
    || free(Shortlisting::On),
    || free(Shortlisting::Off),
    || Ok(largest([free_in_pieces(Shortlisting::On)?, free_in_pieces(Shortlisting::Off)?])),
    || Ok(pieces_in_contact()?[2].1),
    // Every cut costs the error of one mechanical step, which is of third order.
    || Ok(shortfall(&pieces_in_contact()?, 3.0)),
    || Ok(off_ratio(&errors_in_oblique_contact(RAMP)?, 4.0)),
    row,
    || Ok(errors_of_push(GROWTH)?[0].1),
    || Ok(off_ratio(&errors_of_push(0.0)?, 2.0)),
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
    let ramp = Wrench { force: vec2(40.0, -60.0), torque: -1.2 };
    let drive = [Wrench { force: vec2(-50.0, 20.0), torque: 1.5 }, ramp];
    let someone = pedestrian(70.0, 0.0).moving(0.6, -0.4).spinning(1.0);
    let relaxing = someone.clone().relaxing(4.5, 3.0);
    let still = flight(shortlisting, &someone, drive, (2, 1.0))?;
    Ok(largest([still, flight(shortlisting, &relaxing, drive, (2, 1.0))?]))
}

/// The largest error of a free body under a drive and its rate, after each of some steps \[s\].
pub(crate) fn flight(
    shortlisting: Shortlisting,
    person: &Placed,
    [drive, ramp]: [Wrench; 2],
    (steps, duration): (u32, f64),
) -> Result<f64> {
    let mut worst: f64 = 0.0;
    let Placed { body, pose: _, twist } = person;
    let mut world = world(std::slice::from_ref(person), &[], BODIES, 1e-5);
    world.shortlisting = shortlisting;
    world.drive_rate[0] = ramp;
    for step in 1..=steps {
        world.drive[0] = later(drive, ramp, duration * f64::from(step - 1));
        world.advance(duration)?;
        let t = duration * f64::from(step);
        let moved = |v: f64, force: f64, growth: f64| {
            under_ramp(body.translation_rate, [0.0, v, force / body.mass, growth / body.mass], t)
        };
        let [x, vx] = moved(twist.velocity.x, drive.force.x, ramp.force.x);
        let [y, vy] = moved(twist.velocity.y, drive.force.y, ramp.force.y);
        let turn = [0.0, twist.angular_velocity, drive.torque / body.inertia, ramp.torque / body.inertia];
        let [orientation, angular_velocity] = under_ramp(body.rotation_rate, turn, t);
        let pose = Pose { position: vec2(x, y), orientation };
        let twist = Twist { velocity: vec2(vx, vy), angular_velocity };
        worst = largest([worst, apart(&motions(&world), &[Motion { pose, twist }])]);
    }
    ensure!(
        (world.work().shortlisted > 0) == (shortlisting == Shortlisting::On),
        "it is shortlisted as asked"
    );
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
    Ok(apart(&motions(&whole), &motions(&pieces)))
}

fn free_in_pieces(shortlisting: Shortlisting) -> Result<f64> {
    in_pieces(|| {
        let someone = pedestrian(70.0, 4.5).moving(1.2, -0.4).spinning(2.0);
        let mut world = world(&[someone], &[], BODIES, 1e-5);
        world.shortlisting = shortlisting;
        world.drive[0] = Wrench { force: vec2(50.0, 20.0), torque: 1.5 };
        world.drive_rate[0] = Wrench { force: vec2(4000.0, -900.0), torque: -70.0 };
        world
    })
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
pub(crate) fn pieces_in_contact() -> Result<Halved> {
    halved(4e-5, 5, |dt| in_pieces(|| twisted(dt)))
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
    let mut people: Vec<Placed> = (0..6).map(|k| disk(70.0, 0.2).at(spacing * f64::from(k), 0.0)).collect();
    people[0].twist.velocity.x = speed;
    let mut worlds = [Shortlisting::On, Shortlisting::Off].map(|shortlisting| {
        let mut world = world(&people, &[], ELASTIC, 1e-5);
        world.shortlisting = shortlisting;
        push(&mut world);
        world
    });
    for world in &mut worlds {
        world.advance(0.5)?;
    }
    Ok(worlds)
}

/// \[N/s\] Growth of the push of [`errors_of_push`], from zero.
pub(crate) const GROWTH: f64 = 2000.0;

/// Number of mechanical steps of [`errors_of_push`], 0.4 s in all: halved communication steps are integer multiples of
/// them.
const PUSH_STEPS: u32 = 1 << 15;

/// A person is pushed onto another 2 cm away, for 0.4 s in `steps` communication steps. `drive` returns the force \[N\]
/// at the start of a step; it changes by `rate` \[N/s\] until the next.
fn pushed(steps: u32, drive: impl Fn(f64) -> f64, rate: f64) -> Result<World> {
    let people = [pedestrian(89.0, 4.5), pedestrian(60.0, 4.5).at(0.293, 0.05)];
    let mut world = world(&people, &[], BODIES, 0.4 / f64::from(PUSH_STEPS));
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
/// zero, by this rate \[N/s\] within a step. The reference is the same push, constant at its mean value over each mechanical step.
///
/// # Errors
/// The world did not advance.
pub(crate) fn errors_of_push(rate: f64) -> Result<Halved> {
    let half_step = 0.2 / f64::from(PUSH_STEPS);
    let fine = pushed(PUSH_STEPS, |t| GROWTH * (t + half_step), 0.0)?;
    halved(0.1, 6, |duration| {
        let world = pushed((0.4 / duration).round() as u32, |t| GROWTH * t, rate)?;
        let poses = world.state().poses.iter().zip(&fine.state().poses);
        Ok(largest(poses.map(|(a, b)| apart_in_pose(a, b))))
    })
}
