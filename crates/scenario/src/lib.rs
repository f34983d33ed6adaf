//! Scenarios: a room with doors, who is in it, how they are placed, and what they do, in one document. A Trial, its
//! `decision.toml` and its drive are [made](Scenario::documents) of it.
//!
//! Command, sweep, lab and Python fill a [`Scenario`] and make it here, so that the same one gives the same bytes.
//! `docs/reference/scenario.md` describes the keys. SI units; angles in degrees, counter-clockwise from the x axis.

mod error;
mod forms;
mod leave;
mod people;
mod place;
mod push;
mod source;

pub use error::{ALL as SENTENCES, Result, ScenarioError, with_names};
pub use forms::{
    DoorForm, DrawingForm, GroundForm, LevelsForm, LinkForm, OrientationName, RegionForm, Share, TwoNumbers,
};
pub use leave::own_speeds;
pub use people::{Crowd, Four, People, Ready, round};
pub use place::{StandingArea, WalkableRoom};
pub use push::{Push, drive};
pub use source::SourceForm;

use error::{Of, ROUND, fits, impossible, require, within};
use lemons_core::files::source::FileSource;
use lemons_core::files::{input, words};
use lemons_core::message::message;
use lemons_core::plane::Vec2;
use lemons_core::trial::{DRIVE_FILE, DriveTable, FARTHEST, Trial};
use lemons_decision::{DECISION_FILE, DecisionConfig, Plan};
use lemons_people::placing::{Method, Watch};
use lemons_people::room::Room;
use lemons_people::{CrowdMember, Kinds, SKINS};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Largest number of people.
pub const MOST_PEOPLE: u32 = 1_000_000;
/// Most doors, regions and pushes.
const MOST_PARTS: usize = 1000;
/// Most corners of room and regions.
const MOST_CORNERS: usize = 10_000;
/// Ranges of numbers, and what a scenario has there.
type NumberRow = (&'static str, [f64; 2], fn(&Scenario) -> Option<f64>);
const RANGES: &[NumberRow] = &[
    ("box", [0.1, 1e4], |of| Some(of.sides?.0[0])),
    ("box", [0.1, 1e4], |of| Some(of.sides?.0[1])),
    ("number", [1.0, MOST_PEOPLE as f64], |of| of.number.map(f64::from)),
    ("density", [1e-6, 100.0], |of| of.density),
    ("men", [0.0, 1.0], |of| of.men),
    ("pedestrians", [0.0, 1.0], |of| of.pedestrians),
    ("direction", [-360.0, 360.0], |of| of.direction),
    ("speed", [0.0, 20.0], |of| of.speed),
    ("friction", [0.0, 2.0], |of| of.friction),
    ("time_step", [1e-6, 1.0], |of| of.time_step),
    ("panel_length", [0.01, 1e4], |of| of.panel_length),
    ("groups", [0.0, 1.0], |of| of.decision.groups.as_ref()?.share),
];
/// The material of walls that are made.
pub const WALLS: &str = "concrete";

/// A scenario. Without `box`, `geometry` and `room`, people stand in the open.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(deny_unknown_fields, default)]
pub struct Scenario {
    /// \[m\] Width and height of a room whose lower left corner is the origin.
    #[serde(rename = "box")]
    pub sides: Option<TwoNumbers>,
    /// A Geometry.xml or a drawing.
    pub geometry: Option<PathBuf>,
    /// Reading of the drawing.
    pub drawing: DrawingForm,
    /// Corners of a room, with its doors.
    pub room: Option<Room>,
    /// \[m\], \[s\] Doors that are cut into closed walls: x, y, width, and the times at which they open and close.
    #[cfg_attr(feature = "typescript", ts(as = "Vec<Vec<f64>>"))]
    pub doors: Vec<DoorForm>,
    /// Places where people stand; without one, in the whole room, or on the distributions of a drawing.
    pub regions: Vec<RegionForm>,
    /// Slopes and stairs.
    pub grounds: Vec<GroundForm>,
    /// Lines that are one: of floors that lie beside each other.
    pub links: Vec<LinkForm>,
    /// People who come later.
    pub sources: Vec<SourceForm>,
    /// Number of people.
    pub number: Option<u32>,
    /// \[1/m²\] Density of people, instead of their number.
    pub density: Option<f64>,
    /// The same seed gives the same crowd. If it is not said, 1.
    pub seed: Option<u64>,
    /// Source of the people.
    pub people: People,
    /// Probability that an adult is a man; if it is not said, 0.5, or what the statistics say.
    pub men: Option<f64>,
    /// Probability that somebody is a pedestrian; the others are of the kind "bicycle".
    pub pedestrians: Option<f64>,
    /// Shares of kinds of people; empty: those of the statistics, else adults with nothing.
    #[cfg_attr(feature = "typescript", ts(type = "Record<string, number | \"rest\">"))]
    pub mix: BTreeMap<String, Share>,
    /// Packing algorithm.
    pub packing: Method,
    /// Orientation of people; if it is not said, any way, or `towards` the direction if there is one.
    pub orientation: Option<OrientationName>,
    /// \[°\] Direction.
    pub direction: Option<f64>,
    /// True if people may overlap at the start.
    pub allow_overlap: bool,
    /// Material of everybody: one of [`SKINS`]; if it is not said, the first.
    pub material: Option<String>,
    /// Kinetic friction of people with each other and with walls, instead of the material's.
    pub friction: Option<f64>,
    /// True if each body is one disk, of the same area.
    pub round: bool,
    /// Number of levels in which people have disks, or their heights \[m\]; if it is not said, the plan.
    pub levels: Option<LevelsForm>,
    /// \[s\] Communication step. If it is not said, 0.01.
    pub time_step: Option<f64>,
    /// \[m\] Length of the longest panel of the walls, whose loads are outputs. If it is not said, walls have none.
    pub panel_length: Option<f64>,
    /// \[m/s\] Desired speed of everybody who leaves, instead of the usual one and those of kinds; or the speed that
    /// everybody would reach alone, pushing along the direction.
    pub speed: Option<f64>,
    /// True if everybody leaves, by doors, by the exits of `decision`, or by those of the drawing.
    pub leave: bool,
    /// Pushes.
    pub pushes: Vec<Push>,
    /// Further keys of what people do, as in `decision.toml`.
    #[cfg_attr(feature = "typescript", ts(type = "DecisionConfig"))]
    pub decision: DecisionConfig,
}

/// Documents that were made of a scenario.
#[derive(Debug)]
pub struct ScenarioDocuments {
    /// The Trial.
    pub trial: Trial,
    /// Everybody, in the order of the Trial.
    pub agents: Vec<CrowdMember>,
    /// Placing of the people.
    pub crowd: Crowd,
    /// The room.
    pub place: WalkableRoom,
    /// Its drive; empty without pushes.
    pub drive: DriveTable,
    /// Its decision.toml, and what it becomes.
    pub decision: Option<(DecisionConfig, Plan)>,
    /// Notes of what is probably not meant, and of what was chosen.
    pub notes: Vec<String>,
}

impl ScenarioDocuments {
    /// Returns names and texts of the files that are beside those of all Trials.
    ///
    /// # Errors
    /// A number is too large for TOML.
    pub fn beside(&self) -> Result<Vec<(&'static str, String)>> {
        let decision = self.decision.as_ref().map(|(config, _)| config.to_toml());
        let decision = decision.transpose().map_err(impossible)?.unwrap_or_default();
        let all = [(DECISION_FILE, decision), (DRIVE_FILE, self.drive.text_for(&self.trial))];
        Ok(all.into_iter().filter(|(_, text)| !text.is_empty()).collect())
    }
}

impl Scenario {
    /// Reads a file. Paths in it are relative to its directory.
    ///
    /// # Errors
    /// The file cannot be read, is not TOML, or has unknown keys or values of another type.
    pub fn read(files: &dyn FileSource, path: &Path) -> Result<Scenario> {
        let mut read = Scenario::read_as_it_is(files, path)?;
        let directory = path.parent().unwrap_or(Path::new(""));
        read.each_path(|path| *path = directory.join(&*path));
        Ok(read)
    }

    /// Reads a file as [`Scenario::read`] does, but leaves the paths in it as they are.
    ///
    /// # Errors
    /// Those of [`Scenario::read`].
    pub fn read_as_it_is(files: &dyn FileSource, path: &Path) -> Result<Scenario> {
        let named = |why: String| ScenarioError::Toml(format!("{}: {why}", path.display()));
        let text = files.read_text(path, input::LARGEST_SETTINGS);
        let text = text.map_err(|error| named(error.to_string()))?;
        Scenario::from_toml(&text).map_err(|error| named(error.to_string()))
    }

    /// Reads TOML.
    ///
    /// # Errors
    /// The text is not TOML, or has unknown keys or values of another type; with line and column.
    pub fn from_toml(text: &str) -> Result<Scenario> {
        toml::from_str(text).map_err(|error| ScenarioError::Toml(explained(&error)))
    }

    /// Reads keys and values.
    ///
    /// # Errors
    /// There are unknown keys, or values of another type.
    pub fn from_table(table: toml::Table) -> Result<Scenario> {
        // The key is on a line of its own.
        let line = |error| explained(&error).trim_end().replace('\n', " ");
        table.try_into().map_err(|error| ScenarioError::Toml(line(error)))
    }

    /// Returns TOML, without keys that have their usual value.
    ///
    /// # Errors
    /// A number is too large for TOML.
    pub fn to_toml(&self) -> Result<String> {
        let (mut own, usual) = (self.table()?, Scenario::default().table()?);
        own.retain(|key, value| usual.get(key) != Some(value));
        toml::to_string(&own).map_err(impossible)
    }

    fn table(&self) -> Result<toml::Table> {
        toml::Table::try_from(self).map_err(impossible)
    }

    /// Returns whether a key, as messages call it, has another value than in another scenario.
    pub fn differs(&self, other: &Scenario, key: &str) -> bool {
        // As text: what is no number is not equal to itself.
        let value = |of: &Scenario| -> Option<String> {
            let table = of.table().ok()?;
            let mut names = key.split('.');
            let first = names.next()?;
            let value = table.get(first).or_else(|| table.get("decision")?.get(first))?;
            names.try_fold(value, |value, name| value.get(name)).map(ToString::to_string)
        };
        value(self) != value(other)
    }

    /// Changes the paths of files.
    pub fn each_path(&mut self, mut change: impl FnMut(&mut PathBuf)) {
        self.geometry.iter_mut().for_each(&mut change);
        match &mut self.people {
            People::Custom { file } => change(file),
            People::Tables { male, female } => male.iter_mut().chain(female).for_each(change),
            People::Survey {} | People::Statistics { .. } | People::Fixed { .. } => {}
        }
    }

    /// Returns the same with another value of a key, written as in TOML; `mix.child` is a key of a table.
    ///
    /// # Errors
    /// There is no such key, or it has no such value. Whether the value fits to others is not checked.
    pub fn with(&self, key: &str, value: &str) -> Result<Scenario> {
        let number = || value.parse::<f64>().ok().filter(|number| number.is_finite()).map(toml::Value::Float);
        let text = || toml::Value::String(value.to_owned());
        let value = match value.parse::<toml::Value>().ok().or_else(number).unwrap_or_else(text) {
            // A range of a sweep has 2.0 for 2.
            toml::Value::Float(number) if number.fract() == 0.0 && number.abs() < 1e15 => {
                toml::Value::Integer(number as i64)
            }
            value => value,
        };
        let bare = !key.contains(['\n', '\r']);
        let path = bare.then(|| toml::from_str(&format!("{key} = true")).ok()).flatten().unwrap_or_default();
        let mut table = self.table()?;
        set(&mut table, path, value)
            .map_err(|why| impossible(why.unwrap_or_else(|| format!("{key}: must be a key, as in TOML"))))?;
        Scenario::from_table(table)
    }

    /// Draws and places people, at most so many, and makes the documents of their Trial. `watch` gets the progress of the
    /// placing.
    ///
    /// # Errors
    /// A value is not possible, people do not fit or cannot leave, or `watch` stopped the placing.
    pub fn documents(
        &self,
        name: &str,
        most: u32,
        files: &dyn FileSource,
        watch: &mut Watch,
    ) -> Result<ScenarioDocuments> {
        self.check()?;
        let population = self.population(files)?;
        let place = self.place(files, self.drawn(files)?)?;
        let ready = self.ready(&population, place, most)?;
        let crowd = ready.crowd(watch)?;
        ready.into_documents(name, crowd)
    }

    /// Returns the seed of who the people are and where they stand.
    pub fn seed(&self) -> u64 {
        self.seed.unwrap_or(1)
    }

    fn material(&self) -> &str {
        self.material.as_deref().unwrap_or(SKINS[0])
    }

    /// Checks what can be known before files are read.
    ///
    /// # Errors
    /// A value is not possible, or does not fit to others; keys are between backticks.
    pub fn check(&self) -> Result<()> {
        let Scenario { sides, geometry, room, doors, regions, grounds, links, sources, pushes, .. } = self;
        let rooms = [("box", sides.is_some()), ("geometry", geometry.is_some()), ("room", room.is_some())];
        let given: Vec<_> = rooms.iter().filter(|(_, given)| *given).map(|(key, _)| key).collect();
        fits(given.len() < 2, || format!("`{}` and `{}`: a scenario has one room", given[0], given[1]))?;
        for (key, range, value) in RANGES {
            value(self).map_or(Ok(()), |value| within(format_args!("`{key}`"), value, *range))?;
        }
        self.drawing.check()?;
        doors.iter().try_for_each(DoorForm::check)?;
        regions.iter().enumerate().try_for_each(|(k, region)| region.check(k))?;
        sources.iter().enumerate().try_for_each(|(k, source)| source.check(k))?;
        require(SKINS.contains(&self.material()), || {
            format!("`material` = {:?}: must be one of {}", self.material(), SKINS.join(", "))
        })?;
        require(!self.round || self.mix.is_empty(), || message!(ROUND))?;
        self.slabs()?;
        fits(!self.round || self.levels.is_none(), || {
            "`levels` and `round`: a round body is of all heights".to_owned()
        })?;
        for (key, count) in [
            ("doors", doors.len()),
            ("regions", regions.len()),
            ("grounds", grounds.len()),
            ("links", links.len()),
            ("sources", sources.len()),
            ("pushes", pushes.len()),
        ] {
            require(count <= MOST_PARTS, || format!("`{key}`: {count} are more than {MOST_PARTS}"))?;
        }
        let of_room = room.iter().flat_map(Room::every_corner).copied();
        let of_grounds = grounds.iter().flat_map(|of| &of.corners).map(|corner| Vec2::from(corner.0));
        let of_regions = regions.iter().flat_map(RegionForm::corners);
        let of_links = links.iter().flat_map(|of| [of.here, of.there].concat()).map(|end| Vec2::from(end.0));
        let corners: Vec<Vec2> = of_regions.chain(of_room).chain(of_grounds).chain(of_links).collect();
        require(corners.len() <= MOST_CORNERS, || {
            format!(
                "`room`, `regions`, `grounds`, `links`: {} corners are more than {MOST_CORNERS}",
                corners.len()
            )
        })?;
        let near = |corner: &Vec2| [corner.x, corner.y].iter().all(|x| x.abs() <= FARTHEST);
        require(corners.iter().all(near), || {
            format!(
                "`room`, `regions`, `grounds`, `links`: corners must be from -{FARTHEST:e} to {FARTHEST:e} m"
            )
        })?;
        grounds.iter().enumerate().try_for_each(|(k, ground)| ground.ground(k).map(drop))?;
        links.iter().enumerate().try_for_each(|(k, link)| link.link(k).map(drop))?;
        pushes.iter().try_for_each(Push::check)?;
        // TOML holds no larger ones.
        require(i64::try_from(self.seed()).is_ok(), || {
            format!("`seed` = {}: must be at most {}", self.seed(), i64::MAX)
        })?;
        self.people.check()?;
        self.check_leaving()?;
        let shares = forms::shares(&self.mix)?;
        // A file of statistics may have kinds of its own.
        if !shares.is_empty() && !matches!(self.people, People::Custom { .. }) {
            Kinds::built_in()?.mix(&shares).of("`mix`")?;
        }
        Ok(())
    }
}

/// Returns the range of a number.
///
/// # Panics
/// The key has none.
pub fn range(key: &str) -> [f64; 2] {
    RANGES.iter().find(|(known, ..)| *known == key).expect("a key with a range").1
}

fn explained(error: &toml::de::Error) -> String {
    words::explained(&error.to_string(), error.message())
}

/// Sets the value at the end of a path, in which each table has one key. An error says why not; `None`: it is no path.
fn set(table: &mut toml::Table, path: toml::Table, value: toml::Value) -> Result<(), Option<String>> {
    match path.into_iter().next().ok_or(None)? {
        (name, toml::Value::Table(path)) => {
            let place = table.entry(&name).or_insert_with(|| toml::Table::new().into());
            set(place.as_table_mut().ok_or_else(|| Some(format!("{name} is no table")))?, path, value)
        }
        (name, toml::Value::Boolean(true)) => {
            table.insert(name, value);
            Ok(())
        }
        _ => Err(None),
    }
}
