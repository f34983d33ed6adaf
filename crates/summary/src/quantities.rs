//! The variables of the FMU: one table. Exits, doors, areas and panels have slots, each with the same rows; a Trial fills as many
//! slots as it has such things. Names are identifiers of C, which every importer takes.

use lemons_fmi::variables::types::*;
use lemons_fmi::variables::{Domain, Role, Variable, VariableType, row};

/// What a variable tells, or changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)] // the table says it
pub enum What {
    ExitLeft,
    ExitFlow,
    ExitQueue,
    ExitOpen,
    DoorOpen,
    AreaDensity,
    AreaSqueezeMean,
    AreaSqueeze95,
    AreaSqueezeMax,
    AreaAbove,
    BarrierLoad,
    PeopleLeft,
    PeopleInside,
    PeopleFallen,
    SpeedFactor,
    Push,
    Arrivals,
    Stop,
}

/// A variable: what it is about, and of which slot, from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SummaryQuantity {
    /// What it tells, or changes.
    pub what: What,
    /// Its slot; 0 of what is of the whole crowd.
    pub slot: usize,
}

/// \[s\] Flow is counted over this time.
pub const FLOW_OVER: f64 = 10.0;
/// \[m\] Who queues is this near to an exit, or nearer,
pub const QUEUE_NEAR: f64 = 10.0;
/// \[m/s\] and is slower than this.
pub const QUEUE_SLOW: f64 = 0.3;

/// Greatest factor of desired speeds: who walks with 1.3 m/s would run faster than anybody.
const FASTEST: u32 = 10;
/// \[N\] Greatest push: more than somebody can, whose feet slip before; more would be a mistake in the unit.
const HARDEST: u32 = 2000;

/// A row of each slot.
struct Row {
    /// By slot.
    names: &'static [&'static str],
    of: Variable<What>,
}

const fn of(what: What, names: &'static [&'static str], kind: VariableType) -> Row {
    Row { names, of: row(what, "", &[], kind) }
}

impl Row {
    const fn output(self, description: &'static str) -> Row {
        Row { of: self.of.calculated(description), ..self }
    }

    const fn input(self, description: &'static str) -> Row {
        let of = self.of.input(description);
        let domain = if matches!(of.kind, VariableType::Real(_)) { Domain::NonNegative } else { of.domain };
        Row { of: Variable { domain, ..of }, ..self }
    }

    const fn up_to(self, most: u32) -> Row {
        Row { of: Variable { domain: Domain::UpTo(most), ..self.of }, ..self }
    }
}

macro_rules! slots {
    ($thing:literal [$($slot:literal)*] $what:literal) => { &[$(concat!($thing, $slot, "_", $what)),*] };
}
macro_rules! exit { ($what:literal) => { slots!("exit" ["1" "2" "3" "4"] $what) } }
macro_rules! area { ($what:literal) => { slots!("area" ["1" "2" "3"] $what) } }

/// The rows, slot after slot of each group.
const GROUPS: [&[Row]; 6] = {
    use VariableType::*;
    use What::*;
    [
        &[
            of(ExitLeft, exit!("left"), Integer).output("people who have left by it"),
            of(ExitFlow, exit!("flow"), Real(FLOW))
                .output("people who have left by it in the last 10 s, or since the start, over this time"),
            of(ExitQueue, exit!("queue"), Integer).output(
                "people who want to leave by it, are at most 10 m away from it in a straight line, and slower than 0.3 m/s",
            ),
            of(ExitOpen, exit!("open"), Boolean)
                .input("whether it may be open; its times of the plan count, too"),
        ],
        &[of(DoorOpen, slots!("door" ["1" "2" "3" "4"] "open"), Boolean)
            .input("whether it may be open; its times of the Trial count, too")],
        &[
            of(AreaDensity, area!("density"), Real(DENSITY))
                .output("people whose centre of mass is in it, over its area"),
            of(AreaSqueezeMean, area!("squeeze_mean"), Real(NORMAL_FORCE))
                .output("mean of the squeezes of the people in it, each over the last 1 s; 0 before"),
            of(AreaSqueeze95, area!("squeeze_95"), Real(NORMAL_FORCE))
                .output("squeeze that 95 % of the people in it do not exceed, each over the last 1 s; 0 before"),
            of(AreaSqueezeMax, area!("squeeze_max"), Real(NORMAL_FORCE))
                .output("greatest squeeze of the people in it, each over the last 1 s; 0 before"),
            of(AreaAbove, area!("above"), Integer)
                .output("people in it whose squeeze over the last 1 s is above the limit"),
        ],
        &[of(BarrierLoad, slots!("barrier" ["1" "2" "3" "4"] "load"), Real(LINE_LOAD))
            .output("mean load over the last step: normal forces of people on it, over its length")],
        &[
            of(PeopleLeft, &["people_left"], Integer).output("people who have left"),
            of(PeopleInside, &["people_inside"], Integer).output("people who are there"),
            of(PeopleFallen, &["people_fallen"], Integer)
                .output("people who could not be saved from a fall, at some time"),
        ],
        &[
            of(SpeedFactor, &["speed_factor"], Real(FACTOR))
                .input("factor of everybody's desired speed")
                .up_to(FASTEST),
            of(Push, &["push"], Real(PUSH))
                .input(
                    "with this force, everybody who wants to get on pushes in addition, in the direction in which they want to walk",
                )
                .up_to(HARDEST),
            of(Arrivals, &["arrivals"], Real(FLOW)).input(
                "mean number of people who come per time, by all sources that have a rate, as long as there are any more",
            ),
            of(Stop, &["stop"], Boolean).input("whether everybody wants to stand"),
        ],
    ]
};

const COUNT: usize = {
    let (mut count, mut group) = (0, 0);
    while group < GROUPS.len() {
        count += GROUPS[group].len() * GROUPS[group][0].names.len();
        group += 1;
    }
    count
};

/// The table.
pub static QUANTITIES: [Variable<SummaryQuantity>; COUNT] = {
    let nothing = SummaryQuantity { what: What::Stop, slot: 0 };
    let mut all = [row(nothing, "", &[], VariableType::Boolean); COUNT];
    let (mut place, mut group) = (0, 0);
    while group < GROUPS.len() {
        let rows = GROUPS[group];
        let mut slot = 0;
        while slot < rows[0].names.len() {
            let mut k = 0;
            while k < rows.len() {
                let Row { names, of } = &rows[k];
                let Variable { quantity: what, kind, role, domain, description, .. } = *of;
                let begun = row(SummaryQuantity { what, slot }, names[slot], &[], kind);
                all[place] = Variable { role, domain, description, ..begun };
                (place, k) = (place + 1, k + 1);
            }
            slot += 1;
        }
        group += 1;
    }
    all
};

impl What {
    /// Returns how many slots it has.
    pub fn slots(self) -> usize {
        QUANTITIES.iter().filter(|row| row.quantity.what == self).count()
    }
}

impl SummaryQuantity {
    /// Returns its place in the table.
    pub(crate) fn place(self) -> usize {
        QUANTITIES.iter().position(|row| row.quantity == self).unwrap_or_default()
    }

    /// Returns whether importers set it.
    pub(crate) fn is_input(self) -> bool {
        QUANTITIES[self.place()].role == Role::Input
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_are_few_and_their_names_are_identifiers() {
        assert!(QUANTITIES.len() <= 50, "{}", QUANTITIES.len());
        for (k, row) in QUANTITIES.iter().enumerate() {
            let mut letters = row.name.chars();
            assert!(letters.next().is_some_and(|first| first.is_ascii_alphabetic()), "{}", row.name);
            assert!(letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_'), "{}", row.name);
            assert!(QUANTITIES[..k].iter().all(|other| other.name != row.name), "{}", row.name);
            assert_eq!(row.quantity.place(), k);
        }
        let named = |name: &str| QUANTITIES.iter().find(|row| row.name == name).unwrap().quantity;
        assert_eq!(named("exit4_queue"), SummaryQuantity { what: What::ExitQueue, slot: 3 });
        assert_eq!((What::ExitLeft.slots(), What::AreaAbove.slots(), What::Stop.slots()), (4, 3, 1));
    }

    #[test]
    fn descriptions_have_the_numbers_of_the_rules() {
        let of = |name: &str| QUANTITIES.iter().find(|row| row.name == name).unwrap().description;
        assert!(of("exit1_flow").contains(&format!("{FLOW_OVER} s")));
        let queue = of("exit1_queue");
        assert!(queue.contains(&format!("{QUEUE_NEAR} m")) && queue.contains(&format!("{QUEUE_SLOW} m/s")));
        let (_, over) = lemons_results::measure::LIMIT;
        assert!(of("area1_squeeze_95").contains(&format!("{over} s")));
    }
}
