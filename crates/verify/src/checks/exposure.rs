//! Forces on bodies and their deepest overlaps during a communication step.

use crate::checks::{Figure, Result, ensure, largest};
use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;

pub(crate) const FIGURES: &[Figure] = &[
    impulse,
    || off(SPEED * (ELASTIC.normal_stiffness * REDUCED).sqrt(), |of| of.peak_force),
    || off(SPEED * (REDUCED / ELASTIC.normal_stiffness).sqrt(), |of| of.peak_overlap),
    pressed,
    || Ok(crowd()?.0),
    || Ok(crowd()?.1),
    || Ok(crowd()?.2),
];

const SPEED: f64 = 1.3;

/// 80 kg on 50 kg head-on, within one communication step of 0.2 s, in mechanical steps of 2 µs.
fn collision() -> Result<World> {
    let people = [disk(80.0, 0.2).moving(SPEED, 0.0), disk(50.0, 0.2).at(0.45, 0.0)];
    let mut world = world(&people, &[], ELASTIC, 2e-6);
    world.advance(0.2)?;
    ensure!(world.contacts().contacts.is_empty(), "they have parted");
    Ok(world)
}

/// \[kg\] Effective mass of both.
const REDUCED: f64 = 80.0 * 50.0 / 130.0;

fn impulse() -> Result<f64> {
    let world = collision()?;
    let change = 80.0 * (SPEED - world.state().twists[0].velocity.x);
    ensure!((change / (2.0 * REDUCED * SPEED) - 1.0).abs() < 1e-6, "it is elastic");
    Ok(largest(world.exposures().iter().map(|of| (of.mean_force * 0.2 / change - 1.0).abs())))
}

/// Relative difference of a figure of that collision from an expected one.
fn off(expected: f64, figure: fn(&Exposure) -> f64) -> Result<f64> {
    Ok(largest(collision()?.exposures().iter().map(|of| (figure(of) / expected - 1.0).abs())))
}

fn pressed() -> Result<f64> {
    let rest = 0.2 - 500.0 / BODIES.normal_stiffness;
    let mut world = world(&[disk(80.0, 0.2).at(0.0, rest)], &[&[(-1.0, 0.0), (1.0, 0.0)]], BODIES, 1e-5);
    world.drive[0].force = vec2(0.0, -500.0);
    world.advance(0.01)?;
    let Exposure { mean_force, peak_force, .. } = world.exposures()[0];
    Ok(largest([(mean_force / 500.0 - 1.0).abs(), (peak_force / 500.0 - 1.0).abs()]))
}

/// Returns relative differences over 0.1 s of the largest peak, the means and the deepest overlap. The forces do not
/// depend on velocities, so that the motion does not depend on the communication step.
fn crowd() -> Result<(f64, f64, f64)> {
    let dt = 1e-4;
    let people = on_lattice(6, [0.33; 2], 0.0);
    let mut whole = world(&people, &[&[(-1.0, -0.5), (3.0, -0.5)]], ELASTIC, dt);
    let mut stepped = whole.clone();
    whole.advance(0.1)?;
    let (mut peaks, mut depths) = ([0.0f64; 36], [0.0f64; 36]);
    let mut means = [0.0; 36];
    for _ in 0..1000 {
        stepped.advance(dt)?;
        for (b, of) in stepped.exposures().iter().enumerate() {
            peaks[b] = peaks[b].max(of.peak_force);
            depths[b] = depths[b].max(of.peak_overlap);
            means[b] += of.mean_force / 1000.0;
        }
    }
    let relative = |own: f64, other: f64| if own == other { 0.0 } else { (own / other - 1.0).abs() };
    let of_all = |figure: fn(&Exposure) -> f64, stepped: &[f64]| {
        largest(whole.exposures().iter().zip(stepped).map(|(of, other)| relative(figure(of), *other)))
    };
    ensure!(peaks.iter().all(|peak| *peak > 0.0), "everybody was touched");
    Ok((
        of_all(|of| of.peak_force, &peaks),
        of_all(|of| of.mean_force, &means),
        of_all(|of| of.peak_overlap, &depths),
    ))
}
