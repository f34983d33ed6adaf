//! The one table of what is recorded of a crowd. Tables, exports, sweeps and pictures take names, units and words from
//! it; `tests/columns.csv` is the same for programs in other languages.

use crate::cell::Cell;
pub use crate::cell::CellType;
use crate::run::{Observed, Totals};
use lemons_core::plane::Motion;

/// A column of the table of a run, which is an output of the FMU.
#[derive(Debug, Clone, Copy)]
pub struct Quantity {
    /// Name of the column, for example `normal_force`.
    pub name: &'static str,
    /// Name of the output. For a quantity of an agent it comes after `agent[i].`.
    pub variable: &'static str,
    /// SI unit as the FMU spells it; `None` for a count.
    pub unit: Option<&'static str>,
    /// What it is, in a few words.
    pub description: &'static str,
    /// Its value in a row.
    pub(crate) field: fn(&mut AgentRow) -> Field<'_>,
}

impl Quantity {
    /// Counts are integers, everything else is a double.
    pub const fn kind(&self) -> CellType {
        if self.unit.is_some() { CellType::Real } else { CellType::Integer }
    }
}

/// One agent at one time: a row of the table. What is not recorded has its default.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct AgentRow {
    pub motion: Motion,
    pub observed: Observed,
    pub active: bool,
    pub totals: Totals,
}

/// A value in a row. Its type says which numbers it can be.
pub(crate) enum Field<'a> {
    /// Finite.
    Real(&'a mut f64),
    /// Finite, not negative.
    Size(&'a mut f64),
    Count(&'a mut u32),
    /// 1 or 0.
    Flag(&'a mut bool),
}

impl Field<'_> {
    /// Sets the value.
    ///
    /// # Errors
    /// What the number must be.
    pub fn set(self, number: f64) -> Result<(), &'static str> {
        match self {
            Field::Real(value) if number.is_finite() => *value = number,
            Field::Size(value) if number.is_finite() && number >= 0.0 => *value = number,
            Field::Count(value) if number == f64::from(number as u32) => *value = number as u32,
            Field::Flag(value) if number == 0.0 || number == 1.0 => *value = number == 1.0,
            Field::Real(_) => return Err("a finite number"),
            Field::Size(_) => return Err("a finite number from 0 on"),
            Field::Count(_) => return Err("a valid number of contacts"),
            Field::Flag(_) => return Err("1 (there) or 0 (left)"),
        }
        Ok(())
    }

    /// Sets the value of an FMU, whose doubles may be anything.
    ///
    /// # Errors
    /// What the number must be.
    pub fn set_any(self, number: f64) -> Result<(), &'static str> {
        match self {
            Field::Real(value) | Field::Size(value) => *value = number,
            other => return other.set(number),
        }
        Ok(())
    }

    /// Returns the value as a cell.
    ///
    /// # Errors
    /// A count that is larger than the integers of tables.
    pub fn cell<'a>(self) -> Result<Cell<'a>, String> {
        match self {
            Field::Real(value) | Field::Size(value) => Ok(Cell::Real(*value)),
            Field::Count(value) => i32::try_from(*value)
                .map(Cell::Integer)
                .map_err(|_| format!("has {value} contacts, which is too many")),
            Field::Flag(value) => Ok(Cell::Integer((*value).into())),
        }
    }
}

const fn quantity(
    name: &'static str,
    variable: &'static str,
    unit: Option<&'static str>,
    description: &'static str,
    field: fn(&mut AgentRow) -> Field<'_>,
) -> Quantity {
    Quantity { name, variable, unit, description, field }
}

/// \[s\] Column of the time of the communication point. Every table begins with it.
pub const TIME: &str = "t";
/// Column of the agent's Id.
pub const ID: &str = "id";

/// Pose and velocity of an agent.
pub const MOTION: [Quantity; 6] = [
    quantity("x", "Position.x", Some("m"), "x of the centre of mass", |row| {
        Field::Real(&mut row.motion.pose.position.x)
    }),
    quantity("y", "Position.y", Some("m"), "y of the centre of mass", |row| {
        Field::Real(&mut row.motion.pose.position.y)
    }),
    quantity("vx", "Velocity.x", Some("m/s"), "velocity along x", |row| {
        Field::Real(&mut row.motion.twist.velocity.x)
    }),
    quantity("vy", "Velocity.y", Some("m/s"), "velocity along y", |row| {
        Field::Real(&mut row.motion.twist.velocity.y)
    }),
    quantity("theta", "Theta", Some("rad"), "orientation: angle from the x axis to the gaze", |row| {
        Field::Real(&mut row.motion.pose.orientation)
    }),
    quantity("omega", "Omega", Some("rad/s"), "angular velocity", |row| {
        Field::Real(&mut row.motion.twist.angular_velocity)
    }),
];

/// What an agent touches at the time.
pub const CONTACTS: [Quantity; 3] = [
    quantity(
        "agent_contacts",
        "AgentContacts",
        None,
        "contacts of the agent's disks with disks of others",
        |row| Field::Count(&mut row.observed.agent_contacts),
    ),
    quantity(
        "wall_contacts",
        "WallContacts",
        None,
        "contacts of the agent's disks with faces of walls",
        |row| Field::Count(&mut row.observed.wall_contacts),
    ),
    quantity("contacting_agents", "ContactingAgents", None, "how many other agents touch the agent", |row| {
        Field::Count(&mut row.observed.contacting_agents)
    }),
];

/// \[N\] Squeeze at the time: sum of |F_n| over the agent's contacts.
pub const SQUEEZE: Quantity = quantity(
    "normal_force",
    "NormalForce",
    Some("N"),
    "squeeze at this time: sum of the normal forces |F_n| of the agent's contacts",
    |row| Field::Size(&mut row.observed.normal_force),
);

/// What an agent's contacts did since the row before: over one communication step, or over N (`--every N`). FMUs of the
/// first versions have none of these outputs.
pub const OF_STEP: [Quantity; 3] = [
    quantity("mean_normal_force", "MeanNormalForce", Some("N"), "mean squeeze since the row before", |row| {
        Field::Size(&mut row.observed.of_step.get_or_insert_default().mean_normal_force)
    }),
    quantity(
        "peak_normal_force",
        "PeakNormalForce",
        Some("N"),
        "largest squeeze since the row before",
        |row| Field::Size(&mut row.observed.of_step.get_or_insert_default().peak_normal_force),
    ),
    quantity(
        "peak_overlap",
        "PeakOverlap",
        Some("m"),
        "deepest overlap of a contact since the row before",
        |row| Field::Size(&mut row.observed.of_step.get_or_insert_default().peak_overlap),
    ),
];

/// 1 if the agent is there, 0 if not: it touches nothing and stands where it was last.
pub const ACTIVE: Quantity = quantity(
    "active",
    "Active",
    None,
    "1 if the agent is there, 0 if it has left and touches nothing",
    |row| Field::Flag(&mut row.active),
);

/// Of the whole crowd at the time; the same in each row of it.
pub const TOTALS: [Quantity; 2] = [
    quantity(
        "total_agent_contacts",
        "AgentContacts",
        None,
        "contacts between disks of the crowd, each pair once",
        |row| Field::Count(&mut row.totals.agent_contacts),
    ),
    quantity(
        "total_wall_contacts",
        "WallContacts",
        None,
        "contacts between disks of the crowd and faces of walls",
        |row| Field::Count(&mut row.totals.wall_contacts),
    ),
];

/// Every quantity of the table of a run.
const ALL: Groups = Groups { contacts: true, of_step: true, active: true, totals: true };

/// Returns the quantity with this name.
pub fn named(name: &str) -> Option<&'static Quantity> {
    ALL.quantities().find(|quantity| quantity.name == name)
}

/// Which columns the table of a crowd has besides time, Id and motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Groups {
    /// [`CONTACTS`] and [`SQUEEZE`].
    pub contacts: bool,
    /// [`OF_STEP`]; only together with the contacts.
    pub of_step: bool,
    /// [`ACTIVE`]: agents may leave.
    pub active: bool,
    /// [`TOTALS`].
    pub totals: bool,
}

impl Groups {
    /// Those of which all columns exist.
    pub fn among(exists: impl Fn(&str) -> bool) -> Groups {
        let all = |group: &[Quantity]| group.iter().all(|quantity| exists(quantity.name));
        let contacts = all(&CONTACTS) && exists(SQUEEZE.name);
        Groups { contacts, of_step: contacts && all(&OF_STEP), active: all(&[ACTIVE]), totals: all(&TOTALS) }
    }

    /// The quantities of an agent, in the order of the columns.
    pub(crate) fn of_agent(self) -> impl Iterator<Item = &'static Quantity> {
        let contacts = CONTACTS.iter().chain([&SQUEEZE]).filter(move |_| self.contacts);
        let of_step = OF_STEP.iter().filter(move |_| self.contacts && self.of_step);
        let active = [&ACTIVE].into_iter().filter(move |_| self.active);
        MOTION.iter().chain(contacts).chain(of_step).chain(active)
    }

    /// The quantities of the whole crowd, which come last.
    pub(crate) fn of_crowd(self) -> impl Iterator<Item = &'static Quantity> {
        TOTALS.iter().filter(move |_| self.totals)
    }

    /// All columns after time and Id, in their order.
    pub(crate) fn quantities(self) -> impl Iterator<Item = &'static Quantity> {
        self.of_agent().chain(self.of_crowd())
    }

    /// Returns the variables of an FMU that these columns are, in their order: of each agent, then of the crowd; with their
    /// types.
    pub fn variables(self, agents: usize) -> Vec<(String, CellType)> {
        // In a table there are numbers.
        let kind = |quantity: &Quantity| {
            if quantity.name == ACTIVE.name { CellType::Boolean } else { quantity.kind() }
        };
        let of_agent = |i: usize| {
            let name = move |quantity: &Quantity| format!("agent[{i}].{}", quantity.variable);
            self.of_agent().map(move |quantity| (name(quantity), kind(quantity)))
        };
        let of_crowd = self.of_crowd().map(|quantity| (quantity.variable.to_owned(), quantity.kind()));
        (0..agents).flat_map(of_agent).chain(of_crowd).collect()
    }

    /// All columns of the table.
    pub fn columns(self) -> Vec<Column> {
        let id = Column {
            name: ID.into(),
            kind: CellType::Text,
            unit: None,
            variable: "agent[i]".into(),
            description: "Id of the agent in Agents.xml; its place i if the FMU holds no Trial".into(),
        };
        let column = |quantity: &Quantity, agent: &str| Column {
            name: quantity.name.into(),
            kind: quantity.kind(),
            unit: quantity.unit.map(str::to_owned),
            variable: format!("{agent}{}", quantity.variable),
            description: quantity.description.into(),
        };
        let mut all = vec![Column::time(), id];
        all.extend(self.of_agent().map(|quantity| column(quantity, "agent[i].")));
        all.extend(self.of_crowd().map(|quantity| column(quantity, "")));
        all
    }
}

/// A column of a table that is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// No two columns of a table have the same name.
    pub name: String,
    /// Type of its values.
    pub kind: CellType,
    /// `None` for counts and texts.
    pub unit: Option<String>,
    /// Name of the FMU's variable, or what it is if it is not a variable.
    pub variable: String,
    /// What it is, in a few words.
    pub description: String,
}

impl Column {
    /// \[s\] The first column of every table.
    pub fn time() -> Column {
        Column {
            name: TIME.into(),
            kind: CellType::Real,
            unit: Some("s".into()),
            variable: "time".into(),
            description: "time of the communication point".into(),
        }
    }
}
