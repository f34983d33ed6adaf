//! Bodies in levels, and what presses them together.

use crate::checks::{Figure, Result, apart, ensure, largest};
use crowd_mechanics::engine::*;
use crowd_mechanics::scenes::*;
use lemons_core::trial::{Heights, LOAD_LENGTH};

pub(crate) const FIGURES: &[Figure] =
    &[stacks, ramp_of_heights, || random_stacks(momentum_lost), || random_stacks(energy_gained), row, corner];

/// Slabs of equal heights, from one height \[m\] to another.
fn slabs(bottom: f64, top: f64, count: usize) -> Vec<Heights> {
    let at = |k: usize| bottom + (top - bottom) * k as f64 / count as f64;
    (0..count).map(|k| Heights { bottom: at(k), top: at(k + 1) }).collect()
}

/// A round body of equal disks, one above the other.
fn stack(mass: f64, radius: f64, count: usize) -> PlacedBody {
    let mut body = disk(mass, radius);
    body.body.disks = vec![body.body.disks[0].clone(); count];
    body
}

fn in_levels(world: &World, bodies: &[Vec<Heights>]) -> Result<World> {
    let walls = vec![Heights::default(); world.scene().wall_faces.len()];
    let levels = Levels::new(LOAD_LENGTH, bodies, walls, &vec![None; bodies.len()]);
    let scene = world.scene().clone().with_levels(levels);
    Ok(World::new(scene, world.state().clone(), world.mechanical_step)?)
}

/// Two stacks of 0.1 m that hit each other and a wall: as one disk in the plan.
fn stacks() -> Result<f64> {
    let people = |count: usize| {
        let first = stack(80.0, 0.2, count).at(0.0, 0.02).moving(1.0, 0.2).relaxing(1.0, 2.0);
        [first, stack(60.0, 0.25, count).at(0.46, 0.0).spinning(2.0)]
    };
    let wall: &[&[(f64, f64)]] = &[&[(0.75, -1.0), (0.75, 0.0), (0.8, 1.0)]];
    let mut worst = 0.0;
    for count in [1, 2, 5] {
        let mut plan = world(&people(1), wall, BODIES, 1e-4);
        let own = vec![slabs(1.0, 1.0 + LOAD_LENGTH, count); 2];
        let mut levels = in_levels(&world(&people(count), wall, BODIES, 1e-4), &own)?;
        let mut touched = [0.0f64; 2];
        for _ in 0..60 {
            plan.advance(0.01)?;
            levels.advance(0.01)?;
            let [one, other] = [&plan, &levels].map(|world| world.exposures()[1]);
            let squeeze = (one.mean_force - other.mean_force).abs() / one.mean_force.max(1.0);
            worst = largest([worst, apart(&motions(&plan), &motions(&levels)), squeeze]);
            touched = [touched[0].max(one.mean_people_force()), touched[1].max(one.mean_wall_force)];
        }
        ensure!(touched.iter().all(|force| *force > 0.0), "they meet, and the wall");
    }
    Ok(worst)
}

/// A disk from 1 m to 1.4 m, and others up to several heights: as in the plan, with a law that is as many times stiffer.
fn ramp_of_heights() -> Result<f64> {
    let people = [disk(80.0, 0.2).moving(0.8, 0.1), disk(60.0, 0.2).at(0.41, 0.05)];
    let mut worst = 0.0;
    for top in [0.9, 1.0, 1.02, 1.1, 1.25, 1.4, 2.0f64] {
        let share = (top - 1.0).clamp(0.0, 0.4) / LOAD_LENGTH;
        let own = [slabs(0.5, top, 1), slabs(1.0, 1.4, 1)];
        let mut levels = in_levels(&world(&people, &[], BODIES, 1e-5), &own)?;
        let law = PairLaw {
            normal_stiffness: BODIES.normal_stiffness * share,
            tangential_stiffness: BODIES.tangential_stiffness * share,
            normal_damping: BODIES.normal_damping * share,
            tangential_damping: BODIES.tangential_damping * share,
            ..BODIES
        };
        let mut plan = world(&people[..if share > 0.0 { 2 } else { 1 }], &[], law, 1e-5);
        for _ in 0..10 {
            plan.advance(0.01)?;
            levels.advance(0.01)?;
            let there = motions(&plan);
            worst = largest([worst, apart(&there, &motions(&levels)[..there.len()])]);
        }
    }
    Ok(worst)
}

/// The worst of a figure over 500 hits of three stacks of random disks and heights, without damping and friction.
fn random_stacks(figure: fn(&World, &World) -> f64) -> Result<f64> {
    let mut random = Random(27);
    let (mut worst, mut met) = (0.0, 0);
    for case in 0..500 {
        let (mut people, mut own) = (Vec::new(), Vec::new());
        for k in 0..3 {
            let count = 1 + (case + k) % 3;
            let mut within = |low: f64, high: f64| random.within(low, high);
            let mut person = stack(within(20.0, 90.0), within(0.1, 0.25), count)
                .at(0.5 * k as f64 + within(-0.05, 0.05), within(-0.1, 0.1))
                .moving(1.0 - k as f64 + within(-0.2, 0.2), within(-0.2, 0.2))
                .spinning(within(-2.0, 2.0));
            for disk in &mut person.body.disks {
                (disk.radius, disk.position) = (within(0.1, 0.2), vec2(within(-0.05, 0.05), 0.0));
            }
            people.push(person);
            let bottom = within(0.0, 0.5);
            own.push(slabs(bottom, bottom + within(0.3, 1.2), count));
        }
        let start = in_levels(&world(&people, &[], ELASTIC, 2e-5), &own)?;
        let mut end = start.clone();
        for _ in 0..30 {
            end.advance(0.01)?;
            met += usize::from(end.contacts().agent_contacts > 0);
        }
        worst = largest([worst, figure(&start, &end)]);
    }
    ensure!(met > 500, "they met in {met} steps only");
    Ok(worst)
}

/// Momentum and angular momentum that were lost, over those that all bodies have without signs.
fn momentum_lost(start: &World, end: &World) -> f64 {
    let sums = [start, end].map(|world| {
        let bodies = world.scene().bodies.iter().zip(motions(world));
        bodies.fold((Vec2::zeros(), 0.0, 0.0), |(sum, spin, all), (body, motion)| {
            let linear = motion.twist.velocity * body.mass;
            let angular = body.inertia * motion.twist.angular_velocity;
            (sum + linear, spin + angular + motion.pose.position.perp(&linear), all + linear.norm())
        })
    });
    let [(one, spin, all), (other, other_spin, _)] = sums;
    ((one - other).norm() + (spin - other_spin).abs()) / all
}

fn energy_gained(start: &World, end: &World) -> f64 {
    (energy(end) / energy(start) - 1.0).abs()
}

/// Three in a row who push a wall, their gaze along the row or across it: the forces before and behind each, over twice
/// the extent.
fn row() -> Result<f64> {
    const PUSH: f64 = 300.0;
    let mut worst = 0.0;
    for gaze in [0.0, std::f64::consts::FRAC_PI_2] {
        let person =
            |k: u8| disk(80.0, 0.2).at(0.8 - 0.4 * f64::from(k), 0.0).turned(gaze).relaxing(3.0, 3.0);
        let mut of = world(&[person(0), person(1), person(2)], &[&[(1.0, -1.0), (1.0, 1.0)]], BODIES, 1e-4);
        of.drive.iter_mut().for_each(|drive| drive.force.x = PUSH);
        of.advance(4.0)?;
        for (b, behind) in [2.0, 1.0, 0.0].into_iter().enumerate() {
            let found = of.compressions()[b];
            let expected = 0.5 * PUSH * (2.0 * behind + 1.0);
            let [along, across] =
                if gaze == 0.0 { [found.front, found.side] } else { [found.side, found.front] };
            worst = largest([worst, (along / expected - 1.0).abs(), across.abs() / PUSH]);
        }
    }
    Ok(worst)
}

/// Somebody who is pushed into a corner without friction: each wall holds its part, and nothing is behind.
fn corner() -> Result<f64> {
    let walls: &[&[(f64, f64)]] = &[&[(1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]];
    let law = PairLaw { friction: 0.0, ..BODIES };
    let mut of = world(&[disk(80.0, 0.2).at(0.8, 0.8).turned(0.7).relaxing(3.0, 3.0)], walls, law, 1e-4);
    of.drive[0].force = vec2(180.0, 240.0);
    of.advance(4.0)?;
    let parts = of.compressions()[0].principal().into_iter().zip([90.0, 120.0]);
    Ok(largest(parts.map(|(found, expected)| (found / expected - 1.0).abs())))
}
