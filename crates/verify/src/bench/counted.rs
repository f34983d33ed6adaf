//! Runs whose instructions are counted (`benches/instructions.sh`): what everybody pays for a mechanical step, and for the
//! decisions between steps.

use crate::bench::{BARE_MARGIN, BARE_STEPS, DENSE, dense, pressed, push, pushing, settled, soft};
use anyhow::{Context, Result, ensure};
use crowd_mechanics::engine::World;
use crowd_mechanics::scenes::bare::BareCrowd;
use crowd_mechanics::scenes::{BODIES, Random, in_a_box};
use lemons_core::plane::vec2;
use lemons_core::trial::{DriveChoice, OpeningTimes, Wall};
use lemons_decision::{DecisionConfig, Plan};
use lemons_master::{DecisionChoice, TrialInput};
use lemons_sim::{Algorithm, Simulation};
use std::path::Path;

/// Number of calls that are counted: ten, so that what is done once per call counts as much as in a run.
pub const CALLS: usize = 10;

/// A call that does the same number of steps each time.
pub type Call = Box<dyn FnMut() -> Result<()>>;

/// A row of the table of instructions.
pub struct CountedRow {
    /// Name in `benches/instructions.csv`.
    pub name: &'static str,
    /// Number of people.
    pub people: usize,
    /// Number of mechanical steps of a call.
    pub steps: u64,
    /// Makes the run; the first call counts, too.
    pub make: fn() -> Result<Call>,
}

/// Number of mechanical steps of a communication step of `resources/Trial_door`.
const DOOR_STEPS: u64 = 2500;

/// Returns all rows.
pub fn rows() -> Vec<CountedRow> {
    let row = |name, people, steps, make| CountedRow { name, people, steps, make };
    vec![
        row("push", 5, 2000, || {
            let mut world = push();
            world.advance(0.3)?;
            Ok(stepping(world, 2000))
        }),
        row("dense_1000", 1000, 200, || Ok(stepping(dense(1000)?, 200))),
        row("dense_1000_bare", 1000, BARE_STEPS, || bare(dense(1000)?)),
        row("pressed_1000", 1000, 200, || Ok(stepping(pressed(1000)?, 200))),
        row("pressed_1000_bare", 1000, BARE_STEPS, || bare(pressed(1000)?)),
        row("soft_1000", 1000, 7, || Ok(stepping(soft(1000)?, 7))),
        row("wheels_1000", 1000, 200, || Ok(stepping(settled(on_wheels(), 0.5)?, 200))),
        row("walkers", 30, DOOR_STEPS, || walking("", false)),
        row("legs", 30, DOOR_STEPS, || walking("balance = \"pendulum\"\n", false)),
        row("doors", 30, DOOR_STEPS, || walking("", true)),
    ]
}

/// Steps of a world.
fn stepping(mut world: World, steps: u64) -> Call {
    let duration = world.mechanical_step * steps as f64;
    Box::new(move || Ok(world.advance(duration)?))
}

/// The same of the bare loop, each call with the crowd and the list of that time.
fn bare(mut world: World) -> Result<Call> {
    let mut crowds = Vec::new();
    for _ in 0..CALLS {
        crowds.push(BareCrowd::of(&world, BARE_MARGIN));
        world.advance(world.mechanical_step * BARE_STEPS as f64)?;
    }
    let mut crowds = crowds.into_iter();
    Ok(Box::new(move || {
        crowds.next().context("one for each call")?.advance(BARE_STEPS);
        Ok(())
    }))
}

/// A dense crowd in which every tenth person has wheels.
fn on_wheels() -> World {
    let mut numbers = Random(30);
    let (mut people, around) = in_a_box(1000, DENSE, 0.5, &mut numbers);
    people.iter_mut().step_by(10).for_each(|person| person.body.across_rate = Some(45.0));
    pushing(BODIES, &people, &around, 800.0, &mut numbers)
}

/// Thirty people who walk to a door (`resources/Trial_door`), from the moment at which they press. A door may close there.
fn walking(more: &str, closes: bool) -> Result<Call> {
    const BEGIN: f64 = 1.5;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../resources/Trial_door");
    let input = TrialInput::find(&path)?.context("resources/Trial_door is there")?;
    let (mut documents, _, decision) = input.documents(&DriveChoice::None, &DecisionChoice::Own)?;
    let decision = std::fs::read_to_string(decision.context("they walk")?)?;
    let config = DecisionConfig::from_toml(&format!("model = \"rotational\"\n{more}{decision}"))?;
    if closes {
        let mut door = Wall::new("door", "concrete", vec![vec2(5.0, 2.05), vec2(5.0, 2.95)]);
        door.open = OpeningTimes::of_numbers(&[0.0, BEGIN + 0.2, BEGIN + 0.4]).ok();
        documents.trial.geometry.walls.push(door);
    }
    documents.plan = Some(Plan::of(&documents.trial, &config)?);
    let step = documents.trial.parameters.time_step;
    let mechanical = documents.trial.parameters.time_step_mechanical;
    ensure!((step / mechanical).round() as u64 == DOOR_STEPS, "{step} s of {mechanical} s");
    let mut simulation = Simulation::new(documents, Algorithm::Jacobi)?;
    simulation.begin(0.0, None)?;
    let mut call = move || Ok(simulation.step_to(simulation.time() + step)?);
    (0..(BEGIN / step) as usize).try_for_each(|_| call())?;
    Ok(Box::new(call))
}
