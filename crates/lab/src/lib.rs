//! The lab: what a page asks for, computed where the page is.
//!
//! The page sends a [`Request`] and, with some, bytes (files, frames). It gets a [`Reply`]: a JSON value and bytes
//! (frames, a file). [`boundary`] carries both through the memory of WebAssembly; a worker of the page calls it, and the
//! page itself while a room is drawn. All lengths are in m, masses in kg, angles in rad, times in s, unless it is said
//! otherwise.
//!
//! A scene is made in one way: [`source`] (an example, a crowd, an upload) -> [`edit`] (by hand) -> [`mechanics`] (materials
//! and steps) -> [`motion`] (what drives people) -> [`run`]. The parts:
//!
//! - [`person`], [`body`]: one person; bodies in three dimensions, and sections
//! - [`kinds`]: kinds of people, and what goes along with them
//! - [`room`], [`crowd`], [`upload`]: where a Trial comes from
//! - [`loaded`]: a Trial, its people, and what drives them
//! - [`scene`]: what a page draws of it
//! - [`frame`]: what it keeps of a run, and asks of it; [`loads`]: on chests and at levels; [`map`]: by place; [`limit`]: time
//!   above a limit
//! - [`files`]: files to keep; [`report`]: the report of a run
//! - `typescript`: types of requests and replies, for the page

pub mod body;
pub mod boundary;
pub mod crowd;
pub mod edit;
pub mod files;
pub mod frame;
pub mod kinds;
pub mod limit;
pub mod loaded;
pub mod loads;
pub mod map;
pub mod mechanics;
pub mod motion;
pub mod person;
mod reply;
pub mod report;
pub mod room;
pub mod run;
pub mod scene;
pub mod source;
#[cfg(feature = "typescript")]
pub mod typescript;
pub mod upload;

use lemons_core::message::Message;
use lemons_core::require;
use lemons_core::trial::{Problem, Rule};
use lemons_people::placing::Watch;
use lemons_sim::lint::{self, Files};
use loaded::UneditedTrial;
use reply::within;
pub use reply::{ALL as SENTENCES, Refused, Reply};
use serde::{Deserialize, Serialize};
use source::TrialSource;
use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

/// A request of a page. `run` is the number of the run that is meant: a page may still ask about one that another has
/// replaced. Places are in m, angles in rad.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
#[serde(tag = "ask", rename_all = "kebab-case", deny_unknown_fields)]
#[allow(missing_docs)] // as said
pub enum Request {
    /// A person's shape.
    Person(person::PersonRequest),
    /// The surface of a person's body.
    Body(person::PersonRequest),
    /// The bicycle that others are drawn around.
    Bicycle {},
    /// The kinds of people that a crowd may have.
    Kinds {},
    /// A crowd, an example or an upload, as it is to be run.
    Show(Box<SceneRequest>),
    /// A room that is drawn.
    Room(room::RoomRequest),
    /// The room in a Geometry.xml or a drawing (the bytes).
    Drawing(room::DrawingRequest),
    /// Whom an agent, by its place in the Trial, would overlap elsewhere.
    Overlaps { run: u32, agent: usize, x: f64, y: f64, theta: f64 },
    /// Further communication steps, at most [`run::MOST_STEPS`].
    Advance { run: u32, steps: u32 },
    /// Forces between people in a frame (the bytes) of a time \[s\].
    Forces { run: u32, time: f64 },
    /// Crossings of a line between successive frames (the bytes).
    Flow { run: u32, line: [[f64; 2]; 2] },
    /// Frames (the bytes) more in the map of a quantity, or in a new one.
    Map { run: u32, of: map::MapQuantity, fresh: bool },
    /// Squeezes (the bytes) more of people who may be above a limit.
    Limit(limit::LimitRequest),
    /// Everybody's section with a plane at this altitude.
    Sections { run: u32, altitude: f64 },
    /// Everybody's surface.
    Bodies { run: u32 },
    /// The report of a run up to a time \[s\], with a limit of the squeeze: \[N\], of means over \[s\].
    Report { run: u32, until: f64, limit: [f64; 2] },
    /// A file of a run's Trial.
    Take { run: u32, wanted: files::FileRequest },
}

/// A scene that is to be run.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS), ts(rename = "Shown"))]
pub struct SceneRequest {
    /// Where it comes from. The bytes are its files.
    pub base: TrialSource,
    /// Path and length of each table of a crowd.
    #[serde(default)]
    #[cfg_attr(feature = "typescript", ts(optional, as = "Option<Vec<(String, usize)>>"))]
    pub tables: Vec<(String, usize)>,
    /// Changes by hand, in order.
    #[serde(default)]
    pub edits: Vec<edit::Edit>,
    /// Whether changes by hand that do not fit are left out; else they are refused, or made.
    #[serde(default)]
    #[cfg_attr(feature = "typescript", ts(optional, as = "Option<bool>"))]
    pub fitting: bool,
    /// Changes of materials, contacts and steps.
    #[serde(default)]
    #[cfg_attr(feature = "typescript", ts(optional))]
    pub mechanics: Option<mechanics::Mechanics>,
    /// The drive of people.
    pub motion: motion::MotionChoice,
}

/// The answer to [`Request::Show`].
#[derive(Serialize)]
#[cfg_attr(feature = "typescript", derive(ts_rs::TS))]
struct Opened {
    scene: scene::Scene,
    #[cfg_attr(feature = "typescript", ts(as = "Vec<reply::MessageShown>"))]
    notes: Vec<Message>,
    made: Option<loaded::PlacedCrowd>,
    /// Changes by hand that do not fit: their places, and why.
    #[cfg_attr(feature = "typescript", ts(as = "Vec<(usize, reply::MessageShown)>"))]
    left_out: Vec<(usize, Message)>,
}

/// The lab of one page.
#[derive(Default)]
pub struct Lab {
    /// The Trial that was shown last, before edits, with a digest of its files: it need not be made again.
    unedited: Option<(TrialSource, u64, UneditedTrial)>,
    open: Option<run::LabRun>,
    /// How many runs there were: the number of the present one.
    runs: u32,
    /// Limits of the squeeze, by their numbers.
    limits: BTreeMap<u32, limit::LimitProgress>,
}

impl Lab {
    /// Answers a request. `watch` gets the progress of placing people, and of computing a table.
    ///
    /// # Errors
    /// The request is impossible; the lab is unchanged.
    pub fn answer(&mut self, request: &Request, bytes: &[u8], watch: &mut Watch) -> Result<Reply, Refused> {
        match request {
            Request::Person(wanted) => person::person(wanted),
            Request::Body(wanted) => body::of_person(&wanted.person()?),
            Request::Bicycle {} => person::bicycle(),
            Request::Kinds {} => kinds::all(),
            Request::Show(shown) => self.show(shown, bytes, watch),
            Request::Room(wanted) => room::drawn(wanted),
            Request::Drawing(wanted) => room::read(wanted, bytes),
            Request::Overlaps { run, agent, x, y, theta } => {
                frame::overlaps(&self.present(*run)?.loaded.trial, *agent, [*x, *y, *theta])
            }
            Request::Advance { run, steps } => self.present(*run)?.advance(*steps),
            Request::Forces { run, time } => self.present(*run)?.forces(bytes, *time),
            Request::Flow { run, line } => {
                let run = self.present(*run)?;
                frame::flow(run.people(), run.links(), *line, bytes)
            }
            Request::Map { run, of, fresh } => {
                let run = self.present(*run)?;
                map::add(&mut run.map, &run.loaded, *of, *fresh, bytes)
            }
            Request::Limit(wanted) => limit::add(&mut self.limits, wanted, bytes),
            Request::Sections { run, altitude } => body::sections(self.present(*run)?, *altitude),
            Request::Bodies { run } => {
                let run = self.present(*run)?;
                body::surfaces(&run.loaded, run.bodies()?)
            }
            Request::Report { run, until, limit } => {
                report::report(self.present(*run)?, *until, *limit, watch)
            }
            Request::Take { run, wanted } => files::file(wanted, self.present(*run)?, bytes, watch),
        }
    }

    fn present(&mut self, run: u32) -> Result<&mut run::LabRun, Refused> {
        let present = self.runs;
        match &mut self.open {
            Some(open) if run == present => Ok(open),
            _ => Err(Refused::from(format!("run {run} is over: the present one is {present}"))),
        }
    }

    fn show(&mut self, shown: &SceneRequest, bytes: &[u8], watch: &mut Watch) -> Result<Reply, Refused> {
        let mut digest = DefaultHasher::new();
        (&shown.tables, bytes).hash(&mut digest);
        let digest = digest.finish();
        let (base, unedited) = match self.unedited.take() {
            Some((base, files, unedited)) if (&base, files) == (&shown.base, digest) => (base, unedited),
            _ => (shown.base.clone(), shown.base.unedited(&shown.tables, bytes, watch)?),
        };
        let (base, _, unedited) = &*self.unedited.insert((base, digest, unedited));
        let before = unedited.loaded.clone();
        let (mut edited, left_out) = match shown.fitting {
            true => edit::fitting(&before, &shown.edits, base.crowd())?,
            false => (edit::edited(before, &shown.edits, base.crowd())?, BTreeMap::new()),
        };
        let of_crowd = base.crowd().is_some();
        let change = |mechanics: &mechanics::Mechanics| mechanics.change(&mut edited.trial, of_crowd);
        let warnings = shown.mechanics.as_ref().map(change).transpose()?;
        let loaded = motion::with_motion(edited, &shown.motion)?;
        let (documents, files) = (loaded.documents(), Files::within(Path::new("")));
        let mut found = lint::of_documents(&documents, &files);
        found.extend(lint::of_step(&documents, documents.trial.parameters.time_step, &files));
        // What the user makes on the page is meant so.
        found
            .retain(|of| of.rule != Rule::DriveAdded || matches!(shown.motion, motion::MotionChoice::Own {}));
        let mut notes = unedited.notes.clone();
        notes.extend(found.iter().map(Problem::told));
        if edit::room_of(&shown.edits).is_some() {
            notes.extend(room::unfit(&unedited.loaded.trial, &loaded.trial));
        }
        let mut run = run::LabRun::begin(loaded)?;
        self.runs += 1;
        let mut scene = scene::of(&run);
        scene.run = self.runs;
        scene.warnings = warnings.unwrap_or_default();
        scene.beyond_doors = base.beyond_doors(&shown.edits, &run.loaded.trial);
        let bytes = run.frame()?;
        self.open = Some(run);
        let (left_out, made) = (left_out.into_iter().collect(), unedited.placing.clone());
        Reply::with(Opened { scene, notes, made, left_out }, bytes)
    }
}
