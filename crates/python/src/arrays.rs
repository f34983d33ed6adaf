//! Frames of a run as numbers of arrays, and back.

use lemons_results::columns::{ALL, AgentRow, CellType, Effect, Group, QUANTITIES, RecordedQuantity, row_of};
use lemons_results::{Frame, Totals};
use std::sync::LazyLock;

/// Quantities of an agent with their places in the row of a table, in the order of the arrays: poses and velocities are
/// parts of an array, counts come after forces, legs and then chests are last.
static ORDER: LazyLock<Vec<(usize, &RecordedQuantity)>> = LazyLock::new(|| {
    let order = |of: &RecordedQuantity| match of.group {
        Group::Motion => ["x", "y", "theta", "vx", "vy", "omega"].iter().position(|name| *name == of.name),
        Group::Active => Some(8),
        Group::Legs => Some(9),
        Group::Chest => Some(10),
        Group::Totals => None,
        _ => Some(if of.kind() == CellType::Real { 6 } else { 7 }),
    };
    let mut all: Vec<_> = QUANTITIES.iter().enumerate().filter(|(_, of)| order(of).is_some()).collect();
    all.sort_by_key(|(_, of)| order(of));
    all
});

/// Returns how many numbers an agent has: without legs, with legs, with legs and a chest.
fn widths() -> [usize; 3] {
    let before = |group: Group| ORDER.iter().position(|(_, of)| of.group == group).unwrap_or_default();
    [before(Group::Legs), before(Group::Chest), ORDER.len()]
}

/// Returns how many numbers an agent of a frame has.
pub fn numbers_of_each(frame: &Frame) -> usize {
    let has_chests = frame.effects.knows(Effect::ChestForce);
    widths()[if has_chests { 2 } else { frame.legs.is_some().into() }]
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
        let missing = |of: &RecordedQuantity| of.group == Group::Legs && frame.legs.is_none();
        let number =
            |(place, of): &(usize, &RecordedQuantity)| if missing(of) { f64::NAN } else { row[*place] };
        numbers.extend(ORDER[..numbers_of_each(frame)].iter().map(number));
    }
}

/// Returns whether a frame can have so many numbers of each agent.
pub fn is_width(each: usize) -> bool {
    widths().contains(&each)
}

/// Makes a frame of the numbers of everybody, so many each, at a time \[s\].
pub fn frame_of(time: f64, numbers: &[f64], each: usize, leaving: bool) -> Frame {
    let row = |own: &[f64]| {
        let mut row = AgentRow::default();
        ORDER.iter().zip(own).for_each(|((place, _), number)| row[*place] = *number);
        row
    };
    let rows: Vec<AgentRow> = numbers.chunks_exact(each).map(row).collect();
    let [base, with_legs, _] = widths();
    let has_legs = each > base && numbers.chunks_exact(each).any(|own| !own[base].is_nan());
    let groups = ALL.with(Group::Active, leaving).with(Group::Legs, has_legs);
    let groups = groups.with(Group::Chest, each > with_legs);
    let mut frame = Frame { place: format!("t = {time:?} s"), ..groups.frame_of_rows(time, &rows) };
    let sum = |of| (0..rows.len()).filter_map(|agent| frame.effects.get(of, agent)).sum::<f64>();
    // A contact of two people counts for both.
    frame.totals = Some(Totals {
        agent_contacts: (sum(Effect::AgentContacts) / 2.0) as u32,
        wall_contacts: sum(Effect::WallContacts) as u32,
    });
    frame
}
