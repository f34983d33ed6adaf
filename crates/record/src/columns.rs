//! The one table of what is recorded of a crowd. Tables, exports, sweeps and pictures take names, units and words from
//! it; `tests/columns.csv` is the same for programs in other languages.

pub use lemons_columns::Kind;

/// Every quantity of the table of a run.
pub(crate) fn all() -> impl Iterator<Item = &'static Quantity> {
    MOTION.iter().chain(&CONTACTS).chain([&SQUEEZE]).chain(&OF_STEP).chain([&ACTIVE]).chain(&TOTALS)
}

/// A column of the table of a run, which is an output of the FMU.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Quantity {
    /// Name of the column, for example `normal_force`.
    pub name: &'static str,
    /// Name of the output. For a quantity of an agent it comes after `agent[i].`.
    pub variable: &'static str,
    /// SI unit as the FMU spells it; `None` for a count.
    pub unit: Option<&'static str>,
    /// What it is, in a few words.
    pub description: &'static str,
}

impl Quantity {
    /// Counts are integers, everything else is a double.
    pub const fn kind(&self) -> Kind {
        if self.unit.is_some() { Kind::Real } else { Kind::Integer }
    }
}

const fn quantity(
    name: &'static str,
    variable: &'static str,
    unit: Option<&'static str>,
    description: &'static str,
) -> Quantity {
    Quantity { name, variable, unit, description }
}

/// \[s\] Column of the time of the communication point. Every table begins with it.
pub const TIME: &str = "t";
/// Column of the agent's Id.
pub const ID: &str = "id";

/// \[m\] x of the centre of mass.
pub const X: Quantity = quantity("x", "Position.x", Some("m"), "x of the centre of mass");
/// \[m\] y of the centre of mass.
pub const Y: Quantity = quantity("y", "Position.y", Some("m"), "y of the centre of mass");
/// \[m/s\] Velocity of the centre of mass along x.
pub const VX: Quantity = quantity("vx", "Velocity.x", Some("m/s"), "velocity along x");
/// \[m/s\] Velocity of the centre of mass along y.
pub const VY: Quantity = quantity("vy", "Velocity.y", Some("m/s"), "velocity along y");
/// \[rad\] Angle from the x axis to the gaze, counter-clockwise.
pub const THETA: Quantity =
    quantity("theta", "Theta", Some("rad"), "orientation: angle from the x axis to the gaze");
/// \[rad/s\] Angular velocity.
pub const OMEGA: Quantity = quantity("omega", "Omega", Some("rad/s"), "angular velocity");
/// Number of contacts of the agent's disks with disks of other agents.
pub const AGENT_CONTACTS: Quantity =
    quantity("agent_contacts", "AgentContacts", None, "contacts of the agent's disks with disks of others");
/// Number of contacts of the agent's disks with faces of walls.
pub const WALL_CONTACTS: Quantity =
    quantity("wall_contacts", "WallContacts", None, "contacts of the agent's disks with faces of walls");
/// Number of other agents that touch the agent.
pub const CONTACTING_AGENTS: Quantity =
    quantity("contacting_agents", "ContactingAgents", None, "how many other agents touch the agent");
/// \[N\] Squeeze at the time: sum of |F_n| over the agent's contacts.
pub const SQUEEZE: Quantity = quantity(
    "normal_force",
    "NormalForce",
    Some("N"),
    "squeeze at this time: sum of the normal forces |F_n| of the agent's contacts",
);
/// \[N\] Time average of the squeeze since the row before: over one communication step, or over N (`--every N`).
pub const MEAN_SQUEEZE: Quantity =
    quantity("mean_normal_force", "MeanNormalForce", Some("N"), "mean squeeze since the row before");
/// \[N\] Largest squeeze since the row before.
pub const PEAK_SQUEEZE: Quantity =
    quantity("peak_normal_force", "PeakNormalForce", Some("N"), "largest squeeze since the row before");
/// \[m\] Deepest overlap since the row before.
pub const PEAK_OVERLAP: Quantity =
    quantity("peak_overlap", "PeakOverlap", Some("m"), "deepest overlap of a contact since the row before");
/// 1 if the agent is there, 0 if not: it touches nothing and stands where it was last.
pub const ACTIVE: Quantity =
    quantity("active", "Active", None, "1 if the agent is there, 0 if it has left and touches nothing");
/// Number of contacts between disks of the crowd, each pair once.
pub const TOTAL_AGENT_CONTACTS: Quantity = quantity(
    "total_agent_contacts",
    "AgentContacts",
    None,
    "contacts between disks of the crowd, each pair once",
);
/// Number of contacts between disks of the crowd and faces of walls.
pub const TOTAL_WALL_CONTACTS: Quantity = quantity(
    "total_wall_contacts",
    "WallContacts",
    None,
    "contacts between disks of the crowd and faces of walls",
);

/// Pose and velocity of an agent.
pub const MOTION: [Quantity; 6] = [X, Y, VX, VY, THETA, OMEGA];
/// What an agent touches at the time.
pub const CONTACTS: [Quantity; 3] = [AGENT_CONTACTS, WALL_CONTACTS, CONTACTING_AGENTS];
/// What an agent's contacts did since the row before. FMUs of the first versions have
/// none of these outputs.
pub const OF_STEP: [Quantity; 3] = [MEAN_SQUEEZE, PEAK_SQUEEZE, PEAK_OVERLAP];
/// Of the whole crowd at the time; the same in each row of it.
pub const TOTALS: [Quantity; 2] = [TOTAL_AGENT_CONTACTS, TOTAL_WALL_CONTACTS];

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
    pub fn of_agent(self) -> impl Iterator<Item = &'static Quantity> {
        let contacts = CONTACTS.iter().chain([&SQUEEZE]).filter(move |_| self.contacts);
        let of_step = OF_STEP.iter().filter(move |_| self.contacts && self.of_step);
        let active = [&ACTIVE].into_iter().filter(move |_| self.active);
        MOTION.iter().chain(contacts).chain(of_step).chain(active)
    }

    /// The quantities of the whole crowd, which come last.
    pub fn of_crowd(self) -> impl Iterator<Item = &'static Quantity> {
        TOTALS.iter().filter(move |_| self.totals)
    }

    /// All columns of the table.
    pub fn columns(self) -> Vec<Column> {
        let id = Column {
            name: ID.into(),
            kind: Kind::Text,
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
    pub kind: Kind,
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
            kind: Kind::Real,
            unit: Some("s".into()),
            variable: "time".into(),
            description: "time of the communication point".into(),
        }
    }
}
