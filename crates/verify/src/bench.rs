//! Crowds for benchmarks of the engine, and their measurement.
//!
//! The crowds are generated from the paper's agent 0 with seeded positions and drives, and need no files. A case is
//! measured in processor time of the thread, which other load on the machine hardly changes: the median of several
//! runs.

pub mod accuracy;
pub mod counted;
pub mod fmu;

use anyhow::{Result, ensure};
use cpu_time::ThreadTime;
use crowd_mechanics::engine::{PairLaw, Shortlisting, World, Wrench};
use crowd_mechanics::scenes::bare::BareCrowd;
use crowd_mechanics::scenes::{BODIES, MASS, PlacedBody, RATE, Random, in_a_box, pedestrian, world};
use lemons_core::plane::{Vec2, vec2};
use std::time::Instant;

/// \[s\] Mechanical step of all crowds except the push.
const MECHANICAL_STEP: f64 = 1e-5;

/// Times of other engines for a crowd of this kind \[ns\] per agent and mechanical step. They were measured once, on
/// one core of a similar machine, 2026.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Others {
    /// The published C++ engine as shipped.
    pub published: f64,
    /// The same, with the best compiler flags.
    pub published_best: f64,
    /// LAMMPS 2025-07-22, rigid/small and gran/hooke/history, if it was measured.
    pub lammps: Option<f64>,
}

/// A crowd to be measured.
pub struct Case {
    /// Kind of crowd.
    pub name: &'static str,
    /// Number of agents.
    pub agents: usize,
    /// Makes the crowd.
    pub make: fn(usize) -> Result<World>,
    /// Number of mechanical steps of one measurement.
    pub steps: u64,
    /// Whether it is the bare loop ([`BareCrowd`]) that is measured, instead of the engine.
    pub bare: bool,
    /// Times of other engines, if there are any.
    pub others: Option<Others>,
}

/// Returns all cases, small crowds first.
pub fn cases() -> Vec<Case> {
    let others = |published, published_best, lammps| Some(Others { published, published_best, lammps });
    let case = |name, agents, make, steps, others| Case { name, agents, make, steps, bare: false, others };
    let bare = |name, make| Case { bare: true, ..case(name, 1_000, make, 1_000, None) };
    vec![
        case("push, step 2e-6 s", 5, |_| Ok(push()), 200_000, others(10_000.0, 1_600.0, None)),
        case("dense", 10, dense, 20_000, None),
        case("dense", 100, dense, 10_000, others(120_000.0, 34_000.0, Some(720.0))),
        case("dense", 1_000, dense, 1_000, others(180_000.0, 72_000.0, Some(750.0))),
        bare("dense, bare loop", dense),
        case("dense", 10_000, dense, 1_000, None),
        case("dense", 100_000, dense, 200, None),
        case("sparse", 1_000, sparse, 2_000, others(5_500.0, 1_200.0, Some(590.0))),
        case("sparse, all stepped", 1_000, all_stepped, 2_000, others(5_500.0, 1_200.0, Some(590.0))),
        case("pressed on a wall", 1_000, pressed, 1_000, None),
        bare("pressed, bare loop", pressed),
    ]
}

/// Pedestrians on a lattice \[m\] in a closed box, slightly turned and shifted; each pushes in another direction.
fn crowd(agents: usize, spacing: Vec2, turned: f64, push: f64) -> World {
    let mut numbers = Random(30);
    let (people, around) = in_a_box(agents, spacing, turned, &mut numbers);
    pushing(BODIES, &people, &around, push, &mut numbers)
}

/// People in a room, of whom each pushes with at most so much \[N\] along x and y.
fn pushing(
    law: PairLaw,
    people: &[PlacedBody],
    around: &[(f64, f64)],
    push: f64,
    numbers: &mut Random,
) -> World {
    let mut world = world(people, &[around], law, MECHANICAL_STEP);
    for drive in &mut world.drive {
        *drive = Wrench {
            force: vec2(push * numbers.signed(), push * numbers.signed()),
            torque: 0.02 * push * numbers.signed(),
        };
    }
    world
}

/// Lets a crowd settle into contact, with coarse steps.
fn settled(mut world: World, duration: f64) -> Result<World> {
    world.mechanical_step = 1e-4;
    for _ in 0..5 {
        world.advance(duration / 5.0)?;
    }
    world.mechanical_step = MECHANICAL_STEP;
    Ok(world)
}

/// \[m\] Spacing of six people per square metre; some touch.
const DENSE: Vec2 = vec2(0.32, 0.521);

/// Makes a crowd of six people per square metre who push in all directions.
fn dense(agents: usize) -> Result<World> {
    settled(crowd(agents, DENSE, 0.5, 800.0), 0.5)
}

/// \[s\] A seventh of a frame of 1/60 s: in the crowd of `reference/speed.py`, which is like [`soft`], the longest step that
/// keeps everybody right to 1 mm.
const SOFT_STEP: f64 = 1.0 / 420.0;

/// Makes the same crowd with the stiffness of the material `human_soft`.
fn soft(agents: usize) -> Result<World> {
    let mut numbers = Random(30);
    let (people, around) = in_a_box(agents, DENSE, 0.5, &mut numbers);
    let share = 29e3 / 4e6;
    let law = PairLaw {
        normal_stiffness: share * BODIES.normal_stiffness,
        tangential_stiffness: share * BODIES.tangential_stiffness,
        normal_damping: 600.0,
        tangential_damping: 600.0,
        friction: 0.4,
    };
    let mut world = pushing(law, &people, &around, 350.0, &mut numbers);
    world.mechanical_step = SOFT_STEP;
    (0..30).try_for_each(|_| world.advance(7.0 * SOFT_STEP))?;
    Ok(world)
}

/// Makes a crowd of one person per 2 m² who walk at about 1 m/s in all directions; some have met.
fn sparse(agents: usize) -> Result<World> {
    settled(crowd(agents, vec2(1.4, 1.4), 3.0, 700.0), 2.0)
}

/// Makes the same crowd, but no person is moved by the closed form.
fn all_stepped(agents: usize) -> Result<World> {
    let mut world = sparse(agents)?;
    world.shortlisting = Shortlisting::Off;
    Ok(world)
}

/// Makes a crowd in which all push towards one wall.
fn pressed(agents: usize) -> Result<World> {
    let mut world = crowd(agents, vec2(0.276, 0.505), 0.1, 0.0);
    world.drive.fill(Wrench { force: vec2(-200.0, 0.0), torque: 0.0 });
    settled(world, 1.0)
}

/// The paper's five people in a row, the first pushed with 700 N.
fn push() -> World {
    let people: Vec<PlacedBody> =
        (0..5).map(|k| pedestrian(MASS, RATE).at(0.28 * f64::from(k), 0.0)).collect();
    let mut world = world(&people, &[], BODIES, 2e-6);
    world.drive[0].force.x = 700.0;
    world
}

/// The measured figures of a case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Figures {
    /// \[ns\] Processor time per agent and mechanical step of one thread: the median of the runs.
    pub nanoseconds: f64,
    /// Tested pairs per agent and step.
    pub pairs: f64,
    /// Contacts per agent and step.
    pub contacts: f64,
    /// How often an agent had moved so far, in a thousand steps, that its candidates were listed anew.
    pub listed: f64,
    /// Number of near-pair lists made from them in a thousand steps.
    pub refreshes: f64,
    /// Speed-up by more threads, from elapsed times measured in turns; `None` if the work was not shared.
    pub speed_up: Option<f64>,
}

/// Measures a case. Each measurement is one communication step with all its mechanical steps. It is also run on
/// `threads` threads.
///
/// # Errors
/// The simulation diverges, no threads can be started, or the results depend on their number.
pub fn measure(case: &Case, runs: usize, threads: usize) -> Result<Figures> {
    let mut world = (case.make)(case.agents)?;
    let step = world.mechanical_step * case.steps as f64;
    world.advance(step)?;
    if case.bare {
        return measure_bare(case, runs, world);
    }
    let mut shared = world.clone();
    shared.set_threads(threads)?;
    let before = *world.work();
    let (mut times, mut alone, mut together) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..runs {
        let (start, wall) = (ThreadTime::now(), Instant::now());
        world.advance(step)?;
        times.push(start.elapsed().as_secs_f64());
        alone.push(wall.elapsed().as_secs_f64());
        if shared.threads() > 1 {
            let wall = Instant::now();
            shared.advance(step)?;
            together.push(wall.elapsed().as_secs_f64());
        }
    }
    let was_shared = shared.shared() > 0;
    let same = !was_shared || world.state() == shared.state();
    ensure!(same, "{} {}: results differ with threads", case.name, case.agents);
    let (steps, work) = ((case.steps * runs as u64) as f64, world.work());
    let each = case.agents as f64 * steps;
    Ok(Figures {
        nanoseconds: median(&mut times) * 1e9 / (case.agents as f64 * case.steps as f64),
        pairs: (work.pairs - before.pairs) as f64 / each,
        contacts: (work.contacts - before.contacts) as f64 / each,
        listed: (work.listed - before.listed) as f64 * 1000.0 / each,
        refreshes: (work.refreshes - before.refreshes) as f64 * 1000.0 / steps,
        speed_up: was_shared.then(|| median(&mut alone) / median(&mut together)),
    })
}

/// Number of mechanical steps for which the bare loop keeps its list of pairs, and \[m\] the margin of these. The engine
/// makes such a list anew every 40 steps, for the fastest disk of the crowd.
const BARE_STEPS: u64 = 40;
const BARE_MARGIN: f64 = 2e-3;

/// Measures the bare loop on what the crowd passes through, in pieces that are so short that its list of pairs holds.
fn measure_bare(case: &Case, runs: usize, mut world: World) -> Result<Figures> {
    let pieces = case.steps / BARE_STEPS;
    let (mut times, mut pairs, mut contacts) = (Vec::new(), 0, 0);
    for _ in 0..runs {
        let mut time = 0.0;
        for _ in 0..pieces {
            let mut crowd = BareCrowd::of(&world, BARE_MARGIN);
            let start = ThreadTime::now();
            contacts += crowd.advance(BARE_STEPS);
            time += start.elapsed().as_secs_f64();
            pairs += crowd.pairs() as u64 * BARE_STEPS;
            world.advance(world.mechanical_step * BARE_STEPS as f64)?;
        }
        times.push(time);
    }
    let of_run = case.agents as f64 * (pieces * BARE_STEPS) as f64;
    Ok(Figures {
        nanoseconds: median(&mut times) * 1e9 / of_run,
        pairs: pairs as f64 / (of_run * runs as f64),
        contacts: contacts as f64 / (of_run * runs as f64),
        listed: 0.0,
        refreshes: 0.0,
        speed_up: None,
    })
}

/// The median of at least one number.
fn median(numbers: &mut [f64]) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Over a short time the bare loop moves people as the engine does, but for an order of the step.
    #[test]
    fn the_bare_loop_moves_people_as_the_engine_does() {
        for make in [dense, pressed] {
            let mut world = make(100).unwrap();
            let mut bare = BareCrowd::of(&world, 1e-3);
            let start = world.state().clone();
            world.advance(20.0 * world.mechanical_step).unwrap();
            assert!(bare.advance(20) > 200);
            let places = world.state().poses.iter().zip(&start.poses).zip(bare.positions());
            let (mut moved, mut apart) = (0.0f64, 0.0f64);
            for ((pose, before), bare) in places {
                moved = moved.max((pose.position - before.position).norm());
                apart = apart.max((pose.position - bare).norm());
            }
            assert!(apart < 0.02 * moved, "{apart:e} of {moved:e}");
        }
    }

    /// A body alone moves as in the engine, whatever drives it.
    #[test]
    fn the_bare_loop_flies_as_the_engine_does() {
        let mut world = world(&[pedestrian(80.0, RATE)], &[], BODIES, 1e-2);
        world.drive[0] = Wrench { force: vec2(160.0, 80.0), torque: 0.0 };
        let mut bare = BareCrowd::of(&world, 0.0);
        world.advance(1.0).unwrap();
        assert_eq!(bare.advance(100), 0);
        let (place, bare) = (world.state().poses[0].position, bare.positions().next().unwrap());
        assert!(place.norm() > 0.2 && (bare - place).norm() < 1e-9, "{bare} {place}");
    }

    /// Crowds are what they are called, and they cost the work that they should; counts, never times.
    #[test]
    fn crowds_are_what_they_are_called() {
        for case in cases().into_iter().filter(|case| case.agents <= 1_000) {
            let figures = measure(&Case { steps: 500, ..case }, 1, 2).unwrap();
            let (pairs, contacts) = match case.name {
                "dense" | "dense, bare loop" => (0.7..2.5, 0.3..2.0),
                "pressed on a wall" | "pressed, bare loop" => (1.5..3.5, 1.0..4.0),
                "sparse" => (0.0..0.3, 0.01..0.2),
                "sparse, all stepped" => (0.0..0.3, 0.01..0.2),
                _ => (0.0..2.0, 0.0..2.0),
            };
            let name = format!("{} {}: {figures:?}", case.name, case.agents);
            assert!(pairs.contains(&figures.pairs) && contacts.contains(&figures.contacts), "{name}");
            // A list holds for hundreds of steps: its margin is millimetres, a step some micrometres.
            assert!(figures.listed <= 2.0 && figures.refreshes <= 40.0, "{name}");
            assert_eq!(
                figures.speed_up.is_some(),
                (case.name, case.agents) == ("dense", 1_000) || case.name == "pressed on a wall",
                "{name}"
            );
        }
    }
}
