//! Frames of a run as numbers of arrays, and back.

use lemons_results::columns::{ALL, AgentRow, Group, Groups, QUANTITIES, row_of};
use lemons_results::{Frame, Totals};
use std::sync::LazyLock;

/// Names of an agent's numbers, in the order of the arrays: poses and velocities are parts of an array, legs are last.
const ORDER: [&str; 20] = [
    "x",
    "y",
    "theta",
    "vx",
    "vy",
    "omega",
    "normal_force",
    "mean_normal_force",
    "peak_normal_force",
    "peak_overlap",
    "mean_wall_force",
    "agent_contacts",
    "wall_contacts",
    "contacting_agents",
    "active",
    "legs_x",
    "legs_y",
    "steps",
    "balanced",
    "fallen",
];

/// Places of these numbers in the row of a table.
static PLACES: LazyLock<[usize; ORDER.len()]> = LazyLock::new(|| {
    ORDER.map(|name| QUANTITIES.iter().position(|of| of.name == name).expect("it is in the table"))
});

/// Returns how many numbers an agent has, with legs or without.
fn width(legs: bool) -> usize {
    if legs { ORDER.len() } else { ORDER.len() - Group::Legs.quantities().count() }
}

/// Returns how many numbers an agent of a frame has.
pub fn numbers_of_each(frame: &Frame) -> usize {
    width(frame.legs.is_some())
}

/// Returns the names of these numbers.
pub fn names() -> Vec<String> {
    ORDER.map(str::to_owned).to_vec()
}

/// Returns the names of the columns of a table, in their order; those of contacts, `active` and legs among them.
pub fn table() -> Vec<String> {
    ALL.columns().into_iter().map(|column| column.name).collect()
}

/// Appends the numbers of everybody.
pub fn append(frame: &Frame, numbers: &mut Vec<f64>) {
    for agent in 0..frame.agents.len() {
        let row = row_of(frame, agent);
        numbers.extend(PLACES[..numbers_of_each(frame)].iter().map(|place| row[*place]));
    }
}

/// Returns whether a frame can have so many numbers of each agent.
pub fn is_width(each: usize) -> bool {
    [width(false), width(true)].contains(&each)
}

/// Makes a frame of the numbers of everybody, so many each, at a time \[s\].
pub fn frame_of(time: f64, numbers: &[f64], each: usize, leaving: bool) -> Frame {
    let row = |own: &[f64]| {
        let mut row = AgentRow::default();
        PLACES.iter().zip(own).for_each(|(place, number)| row[*place] = *number);
        row
    };
    let rows: Vec<AgentRow> = numbers.chunks_exact(each).map(row).collect();
    let groups = Groups { active: leaving, legs: each == width(true), ..ALL };
    let mut frame = Frame { place: format!("t = {time:?} s"), ..groups.frame_of_rows(time, &rows) };
    let observed = || frame.observed.iter().flatten();
    let count = |of: u64| u32::try_from(of).unwrap_or(u32::MAX);
    // A contact of two people counts for both.
    frame.totals = Some(Totals {
        agent_contacts: count(observed().map(|of| u64::from(of.agent_contacts)).sum::<u64>() / 2),
        wall_contacts: count(observed().map(|of| u64::from(of.wall_contacts)).sum()),
    });
    frame
}
