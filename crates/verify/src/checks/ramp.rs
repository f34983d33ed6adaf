//! Free motion, the shortlist, and drives that change linearly during a communication step.

use crate::checks::{Figure, Halved, Result};
use crate::checks::{apart, apart_in_pose, ensure, farthest_apart, halved, largest, off_ratio, shortfall};
use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;

pub(crate) const FIGURES: &[Figure] = &[
    || free(Shortlisting::On),
    || free(Shortlisting::Off),
    || Ok(pieces_in_contact()?[2].1),
    // Every cut costs the error of one mechanical step, which is of third order.
    || Ok(shortfall(&pieces_in_contact()?, 3.0)),
    row,
    crowd,
    || Ok(errors_of_push(GROWTH)?[0].1),
    || Ok(off_ratio(&errors_of_push(0.0)?, 2.0)),
];

/// Adds rate × time \[s\] to a drive.
pub(crate) fn later(drive: Wrench, rate: Wrench, time: f64) -> Wrench {
    Wrench { force: drive.force + rate.force * time, torque: drive.torque + rate.torque * time }
}

/// Position and velocity at a time under the acceleration `a + j t` and a relaxation rate, computed from the steady
/// motion to which the velocity relaxes.
pub(crate) fn under_ramp(rate: f64, [r, v, a, j]: [f64; 4], t: f64) -> [f64; 2] {
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

/// Two steps of 1 s under a constant drive and under a ramp, relaxing or not: the largest difference from the closed
/// form after each of them.
fn free(shortlisting: Shortlisting) -> Result<f64> {
    let drive = Wrench { force: vec2(-50.0, 20.0), torque: 1.5 };
    let ramp = Wrench { force: vec2(40.0, -60.0), torque: -1.2 };
    let someone = pedestrian(70.0, 0.0).moving(0.6, -0.4).spinning(1.0);
    let relaxing = someone.clone().relaxing(4.5, 3.0);
    let mut worst: f64 = 0.0;
    for (person, ramp) in [(&someone, ramp), (&relaxing, Wrench::default()), (&relaxing, ramp)] {
        let PlacedBody { body, pose: _, twist } = person;
        let mut world = world(std::slice::from_ref(person), &[], BODIES, 1e-5);
        world.shortlisting = shortlisting;
        world.drive_rate[0] = ramp;
        for t in [1.0, 2.0] {
            world.drive[0] = later(drive, ramp, t - 1.0);
            world.advance(1.0)?;
            let moved = |v: f64, force: f64, growth: f64| {
                under_ramp(body.translation_rate, [0.0, v, force / body.mass, growth / body.mass], t)
            };
            let [x, vx] = moved(twist.velocity.x, drive.force.x, ramp.force.x);
            let [y, vy] = moved(twist.velocity.y, drive.force.y, ramp.force.y);
            let turn = [0.0, twist.angular_velocity, drive.torque / body.inertia, ramp.torque / body.inertia];
            let [orientation, angular_velocity] = under_ramp(body.rotation_rate, turn, t);
            worst = largest([
                worst,
                apart(&motions(&world), &[motion(&[x, y, orientation, vx, vy, angular_velocity])]),
            ]);
        }
        let shortlisted = world.work().shortlisted > 0;
        ensure!(shortlisted == (shortlisting == Shortlisting::On), "it is shortlisted as asked");
    }
    Ok(worst)
}

/// Returns mechanical steps \[s\] and largest differences of poses and velocities of two disks pressed together, between
/// a growing twist of 0.1 s in one step and in ten, for four halvings.
///
/// # Errors
/// The world did not advance.
pub(crate) fn pieces_in_contact() -> Result<Halved> {
    let rate = [
        Wrench { force: vec2(9000.0, 0.0), torque: 100.0 },
        Wrench { force: vec2(-7000.0, 500.0), torque: 50.0 },
    ];
    halved(4e-5, 5, |dt| {
        let mut whole = pressed_together(dt);
        whole.drive_rate = rate.to_vec();
        let (mut pieces, drive) = (whole.clone(), whole.drive.clone());
        whole.advance(0.1)?;
        for piece in 0..10 {
            let now =
                drive.iter().zip(rate).map(|(drive, rate)| later(*drive, rate, 0.01 * f64::from(piece)));
            pieces.drive = now.collect();
            pieces.advance(0.01)?;
        }
        Ok(apart(&motions(&whole), &motions(&pieces)))
    })
}

/// Six standing people with gaps. The first is pushed with a growing force, another sways on the spot. Within one
/// communication step the push travels through bodies that were not near anything moving when the step began.
fn row() -> Result<f64> {
    let people: Vec<PlacedBody> = (0..6).map(|k| disk(70.0, 0.2).at(0.45 * f64::from(k), 0.0)).collect();
    let mut worlds = [Shortlisting::On, Shortlisting::Off].map(|shortlisting| {
        let mut world = world(&people, &[], ELASTIC, 1e-5);
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

/// A crowd of 64, shortlisted and not.
fn crowd() -> Result<f64> {
    let mut worlds = [Shortlisting::On, Shortlisting::Off].map(|shortlisting| {
        let mut world = lattice(8, 0.6, 1e-4);
        world.shortlisting = shortlisting;
        world
    });
    for _ in 0..10 {
        for world in &mut worlds {
            world.advance(0.05)?;
        }
    }
    ensure!(worlds[0].work().shortlisted > 0, "somebody was shortlisted");
    Ok(farthest_apart(&worlds))
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
