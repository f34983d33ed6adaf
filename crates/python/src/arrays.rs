//! Frames of a run as numbers of arrays, and back.

use lemons_results::columns::{ALL, AgentRow, CellType, Effect, Group, QUANTITIES, RecordedQuantity, row_of};
use lemons_results::{Frame, Totals};
use std::sync::LazyLock;

/// Quantities of an agent with their places in the row of a table, in the order of the arrays: poses and velocities are
/// parts of an array, counts come after forces, legs are last.
static ORDER: LazyLock<Vec<(usize, &RecordedQuantity)>> = LazyLock::new(|| {
    let order = |of: &RecordedQuantity| match of.group {
        Group::Motion => ["x", "y", "theta", "vx", "vy", "omega"].iter().position(|name| *name == of.name),
        Group::Active => Some(8),
        Group::Legs => Some(9),
        Group::Totals => None,
        _ => Some(if of.kind() == CellType::Real { 6 } else { 7 }),
    };
    let mut all: Vec<_> = QUANTITIES.iter().enumerate().filter(|(_, of)| order(of).is_some()).collect();
    all.sort_by_key(|(_, of)| order(of));
    all
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
    ORDER.iter().map(|(_, of)| of.name.to_owned()).collect()
}

/// Returns the names of the columns of a table, in their order; those of contacts, `active` and legs among them.
pub fn table() -> Vec<String> {
    ALL.columns().into_iter().map(|column| column.name).collect()
}

/// Appends the numbers of everybody.
pub fn append(frame: &Frame, numbers: &mut Vec<f64>) {
    for agent in 0..frame.agents.len() {
        let row = row_of(frame, agent);
        numbers.extend(ORDER[..numbers_of_each(frame)].iter().map(|(place, _)| row[*place]));
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
        ORDER.iter().zip(own).for_each(|((place, _), number)| row[*place] = *number);
        row
    };
    let rows: Vec<AgentRow> = numbers.chunks_exact(each).map(row).collect();
    let groups = ALL.with(Group::Active, leaving).with(Group::Legs, each == width(true));
    let mut frame = Frame { place: format!("t = {time:?} s"), ..groups.frame_of_rows(time, &rows) };
    let sum = |of| (0..rows.len()).filter_map(|agent| frame.effects.get(of, agent)).sum::<f64>();
    // A contact of two people counts for both.
    frame.totals = Some(Totals {
        agent_contacts: (sum(Effect::AgentContacts) / 2.0) as u32,
        wall_contacts: sum(Effect::WallContacts) as u32,
    });
    frame
}
