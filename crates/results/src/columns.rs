//! The one table of what is recorded of a crowd. Tables, exports, sweeps and pictures take names, units and words from
//! it; `tests/columns.csv` is the same for programs in other languages.

pub use crate::cell::CellType;
use crate::run::{Effects, Frame, OfLegs, Totals};
use Domain::{Count, Flag, Real, Size};
use lemons_core::plane::Motion;

/// A column of the table of a run, which is an output of the FMU.
#[derive(Debug, Clone, Copy)]
pub struct RecordedQuantity {
    /// Name of the column, for example `normal_force`.
    pub name: &'static str,
    /// Name of the output. For a quantity of an agent it comes after `agent[i].`.
    pub variable: &'static str,
    /// SI unit as the FMU spells it; `None` for a count.
    pub unit: Option<&'static str>,
    /// Its meaning, in a few words.
    pub description: &'static str,
    /// The columns with which it comes.
    pub group: Group,
    /// Where a frame holds it, if it is an effect of the contacts on an agent, and how several communication steps
    /// become one (`--every`).
    pub effect: Option<(Effect, Merge)>,
    domain: Domain,
    /// Returns it of an agent of a frame; 0 if it is not recorded.
    pub(crate) get: fn(&Frame, usize) -> f64,
    /// Sets it of an agent of a frame that has its group.
    pub(crate) set: fn(&mut Frame, usize, f64),
}

/// Columns that a table has together.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Group {
    /// Pose and velocity of an agent: in every table.
    Motion,
    /// Contacts at the time, and the squeeze.
    Contacts,
    /// Work of an agent's contacts since the row before: over one communication step, or over N (`--every N`). FMUs of
    /// the first versions have none of these outputs.
    OfStep,
    /// Work as that, which FMUs and tables of earlier versions do not have: each column is read if it is there.
    Later,
    /// Load on the agent's chest since the row before, where it is found: each column is read if it is there.
    Chest,
    /// Presence: who is not there touches nothing, and stands where it was last.
    Active,
    /// Legs of an agent, where people have some: outputs of Decision, not of the crowd's FMU.
    Legs,
    /// Quantities of the whole crowd at a time; the same in each row of this time.
    Totals,
}

/// How the numbers of several communication steps become one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Merge {
    /// The last one counts: it is of a time.
    Last,
    /// The time average.
    Mean,
    /// The greatest.
    Max,
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

/// One agent at one time, a number for each of the [`QUANTITIES`]. What is not recorded is 0.
pub type AgentRow = [f64; QUANTITIES.len()];

impl RecordedQuantity {
    /// Counts are integers, everything else is a double.
    pub const fn kind(&self) -> CellType {
        if self.unit.is_some() { CellType::Real } else { CellType::Integer }
    }

    /// Checks a number. The doubles of an FMU (`any`) may be infinite or not numbers.
    ///
    /// # Errors
    /// It says what the number must be.
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

/// \[s\] Column of the time of the communication point. Every table begins with it.
pub const TIME: &str = "t";
/// Column of the agent's Id.
pub const ID: &str = "id";

/// Makes the table, whose rows are, in this order: name, output, domain, group, the field of the group in a frame,
/// description. Those in between are effects: name, output, which is also the name of the effect if no other one is given, domain, group, how
/// several steps become one, description.
macro_rules! quantities {
    ($($name:literal, $variable:literal, $domain:expr, $group:ident, $field:tt, $description:literal;)*
     effects { $($column:literal, $effect:ident $($output_of:literal)?, $range:expr, $with:ident, $merge:ident, $meaning:literal;)* }
     $($last:literal, $output:literal, $of:expr, $among:ident, $place:tt, $words:literal;)*) => {
        /// An effect of the contacts on an agent, with the name of the output.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum Effect { $(#[doc = $meaning] $effect),* }

        impl Effect {
            /// All of them.
            pub const ALL: [Effect; [$(Effect::$effect),*].len()] = [$(Effect::$effect),*];
            /// How many are of whole communication steps.
            pub const OF_STEPS: usize = $(!matches!(Merge::$merge, Merge::Last) as usize +)* 0;
        }

        /// Every quantity, in the order of the columns; those of the whole crowd last.
        pub const QUANTITIES: [RecordedQuantity; [$($name,)* $($column,)* $($last),*].len()] = [
            $(number!(quantity None, $name, $variable, $domain, $group, $field, $description),)*
            $(number!(quantity Some((Effect::$effect, Merge::$merge)), $column, named!($($output_of)? $effect), $range, $with,
                ($effect), $meaning),)*
            $(number!(quantity None, $last, $output, $of, $among, $place, $words),)*
        ];
    };
}

/// The name of an output: that of the effect, if it has no other one.
macro_rules! named {
    ($name:literal $effect:ident) => {
        $name
    };
    ($effect:ident) => {
        stringify!($effect)
    };
}

/// Makes a quantity, gets or sets its number of a frame, which holds it as its group says.
macro_rules! number {
    (quantity $effect:expr, $name:expr, $variable:expr, $domain:expr, $group:ident, $field:tt, $description:expr) => {
        RecordedQuantity {
            name: $name,
            variable: $variable,
            unit: if let Real(unit) | Size(unit) = $domain { Some(unit) } else { None },
            description: $description,
            group: Group::$group,
            effect: $effect,
            domain: $domain,
            get: |frame, agent| number!(get $group frame agent $field),
            set: |frame, agent, value| number!(set $group frame agent value $field),
        }
    };
    (get Motion $f:ident $a:ident ($($field:tt)+)) => { $f.agents[$a].$($field)+ };
    (set Motion $f:ident $a:ident $v:ident ($($field:tt)+)) => { $f.agents[$a].$($field)+ = $v };
    (get Active $f:ident $a:ident ()) => { f64::from($f.is_there($a)) };
    (set Active $f:ident $a:ident $v:ident ()) => {
        if let Some(all) = &mut $f.active {
            all[$a] = $v != 0.0;
        }
    };
    (get Legs $f:ident $a:ident (flag $field:ident)) => { number!(get Legs $f $a ($field)) };
    (get Legs $f:ident $a:ident ($($field:tt)+)) => {
        $f.legs.as_ref().map_or(0.0, |all| all[$a].$($field)+.into())
    };
    (set Legs $f:ident $a:ident $v:ident (flag $field:ident)) => {
        if let Some(all) = &mut $f.legs {
            all[$a].$field = $v != 0.0;
        }
    };
    (set Legs $f:ident $a:ident $v:ident ($($field:tt)+)) => {
        if let Some(all) = &mut $f.legs {
            all[$a].$($field)+ = $v as _;
        }
    };
    (get Totals $f:ident $a:ident ($field:ident)) => {{
        let _ = $a;
        $f.totals.map_or(0.0, |totals| totals.$field.into())
    }};
    (set Totals $f:ident $a:ident $v:ident ($field:ident)) => {{
        let _ = $a;
        if let Some(totals) = &mut $f.totals {
            totals.$field = $v as _;
        }
    }};
    (get $group:ident $f:ident $a:ident ($effect:ident)) => {
        $f.effects.get(Effect::$effect, $a).unwrap_or_default()
    };
    (set $group:ident $f:ident $a:ident $v:ident ($effect:ident)) => {
        if let Some(number) = $f.effects.get_mut(Effect::$effect, $a) {
            *number = $v;
        }
    };
}

quantities! {
    "x", "Position.x", Real("m"), Motion, (pose.position.x), "x of the centre of mass";
    "y", "Position.y", Real("m"), Motion, (pose.position.y), "y of the centre of mass";
    "vx", "Velocity.x", Real("m/s"), Motion, (twist.velocity.x), "velocity along x";
    "vy", "Velocity.y", Real("m/s"), Motion, (twist.velocity.y), "velocity along y";
    "theta", "Theta", Real("rad"), Motion, (pose.orientation), "orientation: angle from the x axis to the gaze";
    "omega", "Omega", Real("rad/s"), Motion, (twist.angular_velocity), "angular velocity";
    effects {
        "agent_contacts", AgentContacts, Count, Contacts, Last, "contacts of the agent's disks with disks of others";
        "wall_contacts", WallContacts, Count, Contacts, Last, "contacts of the agent's disks with faces of walls";
        "contacting_agents", ContactingAgents, Count, Contacts, Last, "how many other agents touch the agent";
        "normal_force", NormalForce, Size("N"), Contacts, Last, "squeeze at this time: sum of the normal forces |F_n| of the agent's contacts";
        "mean_normal_force", MeanNormalForce, Size("N"), OfStep, Mean, "mean squeeze since the row before";
        "peak_normal_force", PeakNormalForce, Size("N"), OfStep, Max, "largest squeeze since the row before";
        "peak_overlap", PeakOverlap, Size("m"), OfStep, Max, "deepest overlap of a contact since the row before";
        "mean_wall_force", MeanWallForce, Size("N"), Later, Mean, "mean squeeze by walls since the row before";
        "chest_force", ChestForce, Size("N"), Chest, Mean, "mean squeeze of the agent's chest since the row before";
        "chest_wall_force", ChestWallForce, Size("N"), Chest, Mean, "the part of it by walls";
        "chest_front", ChestFront "ChestCompression.front", Real("N"), Chest, Mean, "mean force that presses the chest together along the gaze since the row before";
        "chest_side", ChestSide "ChestCompression.side", Real("N"), Chest, Mean, "the same across the gaze";
        "chest_least", ChestLeast "ChestCompression.least", Real("N"), Chest, Mean, "smaller principal part of the same: what presses the chest together from all sides";
    }
    "active", "Active", Flag, Active, (), "1 if the agent is there, 0 if it has left, or has not come yet";
    "legs_x", "Legs.x", Real("m"), Legs, (feet.x), "x of the middle of the feet";
    "legs_y", "Legs.y", Real("m"), Legs, (feet.y), "y of the middle of the feet";
    "steps", "Steps", Count, Legs, (steps), "how many steps the agent took to keep the balance";
    "balanced", "Balanced", Flag, Legs, (flag balanced), "1 if the agent needs no step, 0 if it does";
    "fallen", "Fallen", Flag, Legs, (flag fallen), "1 if the agent could not be saved from a fall, at some time";
    "total_agent_contacts", "AgentContacts", Count, Totals, (agent_contacts), "contacts between disks of the crowd, each pair once";
    "total_wall_contacts", "WallContacts", Count, Totals, (wall_contacts), "contacts between disks of the crowd and faces of walls";
}

/// Every quantity of the table of a run.
pub const ALL: Groups = Groups((1 << QUANTITIES.len()) - 1);

/// Returns the quantity with this name.
pub fn with_name(name: &str) -> Option<&'static RecordedQuantity> {
    QUANTITIES.iter().find(|quantity| quantity.name == name)
}

/// Which columns the table of a crowd has besides time, Id and motion: a bit for each place in [`QUANTITIES`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Groups(u32);

impl Group {
    /// Returns its quantities.
    pub fn quantities(self) -> impl Iterator<Item = &'static RecordedQuantity> {
        QUANTITIES.iter().filter(move |quantity| quantity.group == self)
    }
}

impl Groups {
    fn where_is(has: impl Fn(&RecordedQuantity) -> bool) -> Groups {
        let bits = QUANTITIES.iter().enumerate().map(|(place, quantity)| u32::from(has(quantity)) << place);
        Groups(bits.sum())
    }

    /// Returns those of which all columns exist. Those of the step are only together with the contacts.
    pub fn among(exists: impl Fn(&str) -> bool) -> Groups {
        let all = |group: Group| group.quantities().all(|quantity| exists(quantity.name));
        let contacts = all(Group::Contacts);
        let of_step = contacts && all(Group::OfStep);
        Groups::where_is(|quantity| match quantity.group {
            Group::Contacts => contacts,
            Group::OfStep => of_step,
            Group::Later | Group::Chest => of_step && exists(quantity.name),
            group => all(group),
        })
    }

    /// Returns those that a frame has.
    pub fn of(frame: &Frame) -> Groups {
        Groups::where_is(|quantity| match (quantity.effect, quantity.group) {
            (Some((effect, _)), _) => frame.effects.knows(effect),
            (_, Group::Active) => frame.active.is_some(),
            (_, Group::Legs) => frame.legs.is_some(),
            (_, Group::Totals) => frame.totals.is_some(),
            _ => true,
        })
    }

    /// Returns the same with a group, or without.
    #[must_use]
    pub fn with(self, group: Group, there: bool) -> Groups {
        let of = Groups::where_is(|quantity| quantity.group == group).0;
        Groups(if there { self.0 | of } else { self.0 & !of })
    }

    /// Returns whether a group is there.
    pub fn has(self, group: Group) -> bool {
        self.quantities().any(|(_, quantity)| quantity.group == group)
    }

    /// Returns the quantities in the order of the columns, with their places in a [`AgentRow`].
    pub(crate) fn quantities(self) -> impl Iterator<Item = (usize, &'static RecordedQuantity)> {
        let is = move |place: usize| self.0 & 1 << place != 0;
        let all = QUANTITIES.iter().enumerate();
        all.filter(move |(place, quantity)| quantity.group == Group::Motion || is(*place))
    }

    /// Returns the quantities that are numbers of an FMU with so many agents, in their order: of each agent, then of the
    /// crowd; with the agent.
    pub(crate) fn of_fmu(
        self,
        agents: usize,
    ) -> impl Iterator<Item = (Option<usize>, usize, &'static RecordedQuantity)> {
        let part =
            move |crowd: bool| self.quantities().filter(move |(_, of)| (of.group == Group::Totals) == crowd);
        let of_agents = (0..agents).flat_map(move |i| part(false).map(move |(k, of)| (Some(i), k, of)));
        of_agents.chain(part(true).map(|(k, of)| (None, k, of)))
    }

    /// Returns the variables of an FMU that these columns are, in their order: of each agent, then of the crowd; with their
    /// types.
    pub fn variables(self, agents: usize) -> Vec<(String, CellType)> {
        let named = |(agent, _, quantity): (Option<usize>, usize, &RecordedQuantity)| {
            let name = agent.map_or(String::new(), |i| format!("agent[{i}].")) + quantity.variable;
            // In a table there are numbers.
            (name, if quantity.domain == Flag { CellType::Boolean } else { quantity.kind() })
        };
        self.of_fmu(agents).map(named).collect()
    }

    /// Makes a frame of the values of an FMU at a time \[s\], in the order of [`Groups::variables`].
    ///
    /// # Errors
    /// A sentence with a number that cannot be.
    pub fn frame_of_values(self, time: f64, agents: usize, values: &[f64]) -> Result<Frame, String> {
        let mut frame = self.zeros(agents, time);
        for ((agent, _, quantity), &value) in self.of_fmu(agents).zip(values) {
            quantity
                .check(value, true)
                .map_err(|must| format!("{}: {value:?} is not {must}", quantity.variable))?;
            (quantity.set)(&mut frame, agent.unwrap_or(0), value);
        }
        Ok(Frame { place: format!("t = {time:?} s"), ..frame })
    }

    /// Makes a frame of so many agents, all of whose numbers in these columns are 0.
    pub(crate) fn zeros(self, agents: usize, time: f64) -> Frame {
        let mut effects = Effects::default();
        for (effect, _) in self.quantities().filter_map(|(_, quantity)| quantity.effect) {
            effects.record(effect, (0..agents).map(|_| 0.0));
        }
        Frame {
            time,
            agents: vec![Motion::default(); agents],
            effects,
            active: self.has(Group::Active).then(|| vec![false; agents]),
            legs: self.has(Group::Legs).then(|| vec![OfLegs::default(); agents]),
            totals: (self.has(Group::Totals) && agents > 0).then(Totals::default),
            ..Frame::default()
        }
    }

    /// Makes a frame of the rows of all agents, with these columns.
    pub fn frame_of_rows(self, time: f64, rows: &[AgentRow]) -> Frame {
        let mut frame = self.zeros(rows.len(), time);
        for (agent, row) in rows.iter().enumerate() {
            for (place, quantity) in self.quantities() {
                (quantity.set)(&mut frame, agent, row[place]);
            }
        }
        frame
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
        let column = |(_, quantity): (usize, &RecordedQuantity)| Column {
            name: quantity.name.into(),
            kind: quantity.kind(),
            unit: quantity.unit.map(str::to_owned),
            variable: if quantity.group == Group::Totals { "" } else { "agent[i]." }.to_owned()
                + quantity.variable,
            description: quantity.description.into(),
        };
        [Column::time(), id].into_iter().chain(self.quantities().map(column)).collect()
    }
}

/// Returns the row of an agent of a frame.
pub fn row_of(frame: &Frame, agent: usize) -> AgentRow {
    const ALL: &[RecordedQuantity; QUANTITIES.len()] = &QUANTITIES;
    std::array::from_fn(|place| (ALL[place].get)(frame, agent))
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
    /// Its meaning, in a few words.
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
