//! The one table of what is recorded of a crowd. Tables, exports, sweeps and pictures take names, units and words from
//! it; `tests/columns.csv` is the same for programs in other languages.

pub use crate::cell::CellType;
use Domain::{Count, Flag, Real, Size};

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
    domain: Domain,
}

/// The numbers that a quantity can be, with the unit of those that have one.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Domain {
    /// Finite.
    Real(&'static str),
    /// Finite, not negative.
    Size(&'static str),
    /// A 32-bit integer, not negative.
    Count,
    /// 1 or 0.
    Flag,
}

/// One agent at one time, a number for each of the quantities in their order. What is not recorded is 0.
pub type Row = [f64; 22];

impl Quantity {
    /// Counts are integers, everything else is a double.
    pub const fn kind(&self) -> CellType {
        if self.unit.is_some() { CellType::Real } else { CellType::Integer }
    }

    /// Checks a number. The doubles of an FMU (`any`) may be infinite or not numbers.
    ///
    /// # Errors
    /// What the number must be.
    pub(crate) fn check(&self, number: f64, any: bool) -> Result<(), &'static str> {
        let (good, must) = match self.domain {
            Real(_) => (any || number.is_finite(), "a finite number"),
            Size(_) => (any || number.is_finite() && number >= 0.0, "a finite number from 0 on"),
            Count => (number >= 0.0 && number == f64::from(number as i32), "a valid number"),
            Flag => (number == 0.0 || number == 1.0, "1 or 0"),
        };
        if good { Ok(()) } else { Err(must) }
    }
}

const fn entry(
    name: &'static str,
    variable: &'static str,
    domain: Domain,
    description: &'static str,
) -> Quantity {
    let unit = if let Real(unit) | Size(unit) = domain { Some(unit) } else { None };
    Quantity { name, variable, unit, description, domain }
}

/// \[s\] Column of the time of the communication point. Every table begins with it.
pub const TIME: &str = "t";
/// Column of the agent's Id.
pub const ID: &str = "id";

/// Pose and velocity of an agent.
pub const MOTION: [Quantity; 6] = [
    entry("x", "Position.x", Real("m"), "x of the centre of mass"),
    entry("y", "Position.y", Real("m"), "y of the centre of mass"),
    entry("vx", "Velocity.x", Real("m/s"), "velocity along x"),
    entry("vy", "Velocity.y", Real("m/s"), "velocity along y"),
    entry("theta", "Theta", Real("rad"), "orientation: angle from the x axis to the gaze"),
    entry("omega", "Omega", Real("rad/s"), "angular velocity"),
];

/// What an agent touches at the time.
pub const CONTACTS: [Quantity; 3] = [
    entry("agent_contacts", "AgentContacts", Count, "contacts of the agent's disks with disks of others"),
    entry("wall_contacts", "WallContacts", Count, "contacts of the agent's disks with faces of walls"),
    entry("contacting_agents", "ContactingAgents", Count, "how many other agents touch the agent"),
];

/// \[N\] Squeeze at the time: sum of |F_n| over the agent's contacts.
pub const SQUEEZE: Quantity = entry(
    "normal_force",
    "NormalForce",
    Size("N"),
    "squeeze at this time: sum of the normal forces |F_n| of the agent's contacts",
);

/// What an agent's contacts did since the row before: over one communication step, or over N (`--every N`). FMUs of the
/// first versions have none of these outputs.
pub const OF_STEP: [Quantity; 3] = [
    entry("mean_normal_force", "MeanNormalForce", Size("N"), "mean squeeze since the row before"),
    entry("peak_normal_force", "PeakNormalForce", Size("N"), "largest squeeze since the row before"),
    entry("peak_overlap", "PeakOverlap", Size("m"), "deepest overlap of a contact since the row before"),
];

/// The part of the mean squeeze by walls; the rest is by people. FMUs and tables of earlier versions do not have it.
pub const BY_WALLS: Quantity =
    entry("mean_wall_force", "MeanWallForce", Size("N"), "mean squeeze by walls since the row before");

/// 1 if the agent is there, 0 if not: it touches nothing and stands where it was last.
pub const ACTIVE: Quantity =
    entry("active", "Active", Flag, "1 if the agent is there, 0 if it has left and touches nothing");

/// Legs of an agent, where people have some: outputs of Decision, not of the crowd's FMU.
pub const LEGS: [Quantity; 5] = [
    entry("legs_x", "Legs.x", Real("m"), "x of the middle of the feet"),
    entry("legs_y", "Legs.y", Real("m"), "y of the middle of the feet"),
    entry("steps", "Steps", Count, "how many steps the agent took to keep the balance"),
    entry("balanced", "Balanced", Flag, "1 if the agent needs no step, 0 if it does"),
    entry("fallen", "Fallen", Flag, "1 if the agent could not be saved from a fall, at some time"),
];

/// Quantities of the whole crowd at a time; the same in each row of this time.
pub const TOTALS: [Quantity; 2] = [
    entry(
        "total_agent_contacts",
        "AgentContacts",
        Count,
        "contacts between disks of the crowd, each pair once",
    ),
    entry(
        "total_wall_contacts",
        "WallContacts",
        Count,
        "contacts between disks of the crowd and faces of walls",
    ),
];
/// Place of the first of them in a row.
pub const FIRST_TOTAL: usize = 20;

/// Every quantity of the table of a run.
pub const ALL: Groups =
    Groups { contacts: true, of_step: true, by_walls: true, active: true, legs: true, totals: true };

/// Returns the quantity with this name.
pub fn named(name: &str) -> Option<&'static Quantity> {
    ALL.quantities().map(|(_, quantity)| quantity).find(|quantity| quantity.name == name)
}

/// Which columns the table of a crowd has besides time, Id and motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Groups {
    /// [`CONTACTS`] and [`SQUEEZE`].
    pub contacts: bool,
    /// [`OF_STEP`]; only together with the contacts.
    pub of_step: bool,
    /// [`BY_WALLS`]; only together with those of the step.
    pub by_walls: bool,
    /// [`ACTIVE`]: agents may leave.
    pub active: bool,
    /// [`LEGS`]: agents have legs.
    pub legs: bool,
    /// [`TOTALS`].
    pub totals: bool,
}

impl Groups {
    /// Those of which all columns exist.
    pub fn among(exists: impl Fn(&str) -> bool) -> Groups {
        let all = |group: &[Quantity]| group.iter().all(|quantity| exists(quantity.name));
        let contacts = all(&CONTACTS) && exists(SQUEEZE.name);
        let of_step = contacts && all(&OF_STEP);
        let by_walls = of_step && all(&[BY_WALLS]);
        let (active, legs, totals) = (all(&[ACTIVE]), all(&LEGS), all(&TOTALS));
        Groups { contacts, of_step, by_walls, active, legs, totals }
    }

    /// Returns the quantities in the order of the columns, those of the whole crowd last; with their places in a [`Row`].
    pub(crate) fn quantities(self) -> impl Iterator<Item = (usize, &'static Quantity)> {
        let contacts = CONTACTS.iter().chain([&SQUEEZE]);
        let of_agent = MOTION.iter().chain(contacts).chain(&OF_STEP).chain([&BY_WALLS, &ACTIVE]).chain(&LEGS);
        let all = of_agent.chain(&TOTALS);
        all.enumerate().filter(move |(place, _)| match place {
            0..6 => true,
            6..10 => self.contacts,
            10..13 => self.contacts && self.of_step,
            13 => self.contacts && self.of_step && self.by_walls,
            14 => self.active,
            15..FIRST_TOTAL => self.legs,
            _ => self.totals,
        })
    }

    /// Returns the quantities that are numbers of an FMU with so many agents, in their order: of each agent, then of the
    /// crowd; with the agent.
    pub(crate) fn of_fmu(
        self,
        agents: usize,
    ) -> impl Iterator<Item = (Option<usize>, usize, &'static Quantity)> {
        let part = move |crowd: bool| self.quantities().filter(move |(k, _)| (*k >= FIRST_TOTAL) == crowd);
        let of_agents = (0..agents).flat_map(move |i| part(false).map(move |(k, of)| (Some(i), k, of)));
        of_agents.chain(part(true).map(|(k, of)| (None, k, of)))
    }

    /// Returns the variables of an FMU that these columns are, in their order: of each agent, then of the crowd; with their
    /// types.
    pub fn variables(self, agents: usize) -> Vec<(String, CellType)> {
        let named = |(agent, _, quantity): (Option<usize>, usize, &Quantity)| {
            let name = agent.map_or(String::new(), |i| format!("agent[{i}].")) + quantity.variable;
            // In a table there are numbers.
            (name, if quantity.domain == Flag { CellType::Boolean } else { quantity.kind() })
        };
        self.of_fmu(agents).map(named).collect()
    }

    /// Returns all columns of the table.
    pub fn columns(self) -> Vec<Column> {
        let id = Column {
            name: ID.into(),
            kind: CellType::Text,
            unit: None,
            variable: "agent[i]".into(),
            description: "Id of the agent in Agents.xml; its place i if the FMU holds no Trial".into(),
        };
        let column = |(place, quantity): (usize, &Quantity)| Column {
            name: quantity.name.into(),
            kind: quantity.kind(),
            unit: quantity.unit.map(str::to_owned),
            variable: if place < FIRST_TOTAL { "agent[i]." } else { "" }.to_owned() + quantity.variable,
            description: quantity.description.into(),
        };
        [Column::time(), id].into_iter().chain(self.quantities().map(column)).collect()
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
