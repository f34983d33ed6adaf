//! Trajectories that are not of our runs, of experiments and of other simulators: positions of people at a constant frame
//! rate, without bodies and forces. People may appear and vanish.

mod columns;
mod fcd;
#[cfg(feature = "sqlite")]
mod sqlite;
mod text;
mod timed;

use crate::error::RecordError;
use crate::record::{Each, Record, Trajectories};
use crate::run::Frame;
use crate::shapes::FARTHEST;
use lemons_core::files::input;
use lemons_core::plane::{Motion, Pose, Twist, Vec2, vec2};
use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::Path;
use std::sync::LazyLock;

/// Beginning of a database of SQLite.
const SQLITE: &[u8; 16] = b"SQLite format 3\0";
/// Largest number of rows: 1.3 GB of memory.
const MOST_ROWS: usize = 20_000_000;
/// Largest number of a frame: its time is a double, too.
const LAST_FRAME: i64 = 1_000_000_000_000;
/// Largest number of frames.
const MOST_FRAMES: u64 = 10_000_000;
/// Largest number of frames times people: each frame has a place for everybody.
const MOST_PLACES: u64 = 100_000_000;
/// A velocity that is not known.
const UNKNOWN: Vec2 = vec2(f64::NAN, f64::NAN);
/// \[1/s\] Less and more are a mistake.
const RATES: std::ops::RangeInclusive<f64> = 1e-6..=1e6;

/// Information that a file of trajectories may lack, and how velocities are computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Told {
    /// How many units of a text are a metre: 1, or 100 of centimetres; `None`: the text says it.
    pub per_metre: Option<f64>,
    /// \[1/s\] Frames per second; `None`: the file says it.
    pub rate: Option<f64>,
    /// \[s\] Time between the two positions whose difference is the velocity between them.
    pub velocity_over: f64,
}

/// \[s\] [`Told::velocity_over`], if nothing else is said: a stride takes about so long.
pub const VELOCITY_OVER: f64 = 0.4;

impl Default for Told {
    fn default() -> Told {
        Told { per_metre: None, rate: None, velocity_over: VELOCITY_OVER }
    }
}

/// A person in a frame.
#[derive(Debug, Clone, Copy)]
struct Row {
    /// Number of the frame in the file; later its place among all.
    frame: i64,
    id: i64,
    /// Place of the person among all.
    person: u32,
    /// Number of the line or row in the file.
    n: u32,
    /// \[m\]
    position: Vec2,
    /// \[rad\] Not a number where the file does not say it.
    orientation: f64,
    /// \[m/s\]
    velocity: Vec2,
}

/// Content that a reader finds in a file.
struct Found {
    /// Unit of its length: lines or rows.
    what: &'static str,
    rows: Vec<Row>,
    /// \[1/s\]
    rate: f64,
    /// Frames that the file names, also those without anybody.
    frames: Option<FrameNumbers>,
    oriented: bool,
    geometry: Vec<String>,
    /// Names of people, whose Ids in rows are places among them; `None`: the Ids are their names.
    names: Option<Vec<String>>,
    notes: Vec<String>,
}

/// Frames that a file names.
struct FrameNumbers {
    first: i64,
    last: i64,
    /// Greatest common divisor of the differences between them.
    step: i64,
}

/// Takes rows of a file, and checks them.
struct Rows<'a> {
    path: &'a Path,
    /// Unit of the file's length: lines or rows.
    what: &'static str,
    rows: Vec<Row>,
}

impl<'a> Rows<'a> {
    fn new(path: &'a Path, what: &'static str) -> Rows<'a> {
        Rows { path, what, rows: Vec::new() }
    }

    fn wrong(&self, n: u64, message: impl std::fmt::Display) -> RecordError {
        RecordError::wrong(self.path, format!("{} {n}: {message}", self.what))
    }

    /// Adds a row: number in the file, Id, frame, position \[m\], orientation \[rad\].
    fn add(&mut self, n: u64, id: i64, frame: i64, p: Vec2, orientation: f64) -> Result<(), RecordError> {
        for (name, value) in [("id", id), ("frame", frame)] {
            if value < 0 {
                return Err(self.wrong(n, format!("column {name}: {value} is below 0")));
            }
        }
        if frame > LAST_FRAME {
            return Err(self.wrong(n, format!("column frame: {frame} is above {LAST_FRAME:e}")));
        }
        for (name, value) in [("x", p.x), ("y", p.y)] {
            if !(-FARTHEST..=FARTHEST).contains(&value) {
                return Err(self.wrong(
                    n,
                    format!(
                        "column {name}: {value:?} m is not a number up to {FARTHEST:e} m from the origin"
                    ),
                ));
            }
        }
        if self.rows.len() == MOST_ROWS {
            return Err(self.wrong(n, format!("there are more than {MOST_ROWS} rows: too many")));
        }
        if self.rows.try_reserve(1).is_err() {
            return Err(self.wrong(n, "there are more rows than the memory holds"));
        }
        let n = u32::try_from(n).unwrap_or(u32::MAX);
        self.rows.push(Row { frame, id, person: 0, n, position: p, orientation, velocity: UNKNOWN });
        Ok(())
    }
}

/// Checks a frame rate \[1/s\].
fn check_rate(rate: f64) -> Result<f64, String> {
    if RATES.contains(&rate) {
        Ok(rate)
    } else {
        Err(format!("{rate:?} frames per second: must be from 1e-6 to 1e6"))
    }
}

/// Returns the frame rate that a file says \[1/s\], or else the one that is told.
fn rate_of(path: &Path, own: Option<f64>, told: Option<f64>) -> Result<f64, RecordError> {
    let rate = match (own, told) {
        (Some(own), Some(told)) if own != told => {
            Err(format!("says {own:?} frames per second, not {told:?}, which is told (--fps)"))
        }
        (Some(rate), _) | (None, Some(rate)) => check_rate(rate),
        (None, None) => {
            Err("does not say how many frames per second it has (framerate, fps): tell it (--fps)".into())
        }
    };
    rate.map_err(|message| RecordError::wrong(path, message))
}

/// \[B\] So much of a file says what it is: SUMO writes the options of its run first.
const HEAD: u64 = 65_536;

/// Formats that can be read.
pub static READ: LazyLock<String> = LazyLock::new(|| {
    let own = ["SQLite of JuPedSim", "text with lines \"id frame x y z\"", "FCD of SUMO (XML, CSV)"];
    let of_programs = columns::PROGRAMS.iter();
    let of_programs = of_programs.filter_map(|of| Some(format!("{} of {}", of.files?, of.name)));
    own.map(str::to_owned).into_iter().chain(of_programs).collect::<Vec<_>>().join(", ")
});

/// Format of a file of trajectories.
#[derive(Clone, Copy)]
enum Kind {
    Database,
    /// Lines `id frame x y z`.
    Text,
    /// A table with a header.
    Table,
    Fcd,
}

/// Opens a file, and returns what it begins as; `None` if it holds no trajectories: a table of a run has the names of its
/// own columns in the first line that is no comment.
fn kind_of(path: &Path) -> Result<(File, Option<Kind>), RecordError> {
    let cannot = |error: io::Error| RecordError::Read { path: path.to_owned(), error };
    let mut file = input::open(path).map_err(cannot)?;
    let mut begin = Vec::new();
    let length = file.by_ref().take(HEAD).read_to_end(&mut begin).map_err(cannot)?;
    file.rewind().map_err(cannot)?;
    let begin = begin.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&begin);
    if begin.starts_with(SQLITE) {
        return Ok((file, Some(Kind::Database)));
    }
    if begin.trim_ascii_start().starts_with(b"<") {
        let fcd = begin.windows(11).any(|bytes| bytes == b"<fcd-export");
        return Ok((file, fcd.then_some(Kind::Fcd)));
    }
    let lines = begin.split(|byte| *byte == b'\n').map(String::from_utf8_lossy);
    let mut lines = lines.map(|line| line.trim_ascii_start().to_owned()).filter(|line| !line.is_empty());
    let kind = match lines.find(|line| line.starts_with("$VISION") || !columns::is_comment(line)) {
        Some(line) if line.starts_with(|c| matches!(c, '0'..='9' | '-' | '+' | '.')) => Some(Kind::Text),
        Some(line) => columns::is_header(&line).then_some(Kind::Table),
        // Long comments.
        None => (length as u64 == HEAD).then_some(Kind::Text),
    };
    Ok((file, kind))
}

/// Returns whether a file begins as one of trajectories that are not of our runs: [`READ`].
///
/// # Errors
/// The file cannot be read.
pub fn holds_trajectories(path: &Path) -> Result<bool, RecordError> {
    Ok(kind_of(path)?.1.is_some())
}

impl Record {
    /// Opens trajectories of an experiment or of another simulator, as [`holds_trajectories`] finds them: they are read
    /// into memory. Velocities are differences of positions; where nobody was seen long enough they are not numbers, as
    /// are orientations that the file does not have. Who is not in a frame is not active in it.
    ///
    /// # Errors
    /// The file cannot be read, is none of [`READ`], does not say its frame rate or unit, or something in it is wrong; the
    /// message names line or row, column and value.
    pub fn of_others(path: &Path, told: &Told) -> Result<Record, RecordError> {
        Record::of_others_in(path, path, told)
    }

    /// Opens trajectories as [`Record::of_others`]; `held` is the file that is read in the place of the one that is named.
    ///
    /// # Errors
    /// As there.
    pub fn of_others_in(path: &Path, held: &Path, told: &Told) -> Result<Record, RecordError> {
        let found = match kind_of(held)? {
            (file, Some(Kind::Text)) => text::read(path, file, told)?,
            (file, Some(Kind::Table)) => columns::read(path, file, told)?,
            (file, Some(Kind::Fcd)) => fcd::read(path, file, told)?,
            #[cfg(feature = "sqlite")]
            (_, Some(Kind::Database)) => sqlite::read(path, held, told)?,
            #[cfg(not(feature = "sqlite"))]
            (_, Some(Kind::Database)) => {
                return Err(RecordError::wrong(
                    path,
                    "this build has no SQLite: build with --features sqlite",
                ));
            }
            (_, None) => {
                return Err(RecordError::wrong(
                    path,
                    format!("holds no trajectories that are read: {}", *READ),
                ));
            }
        };
        of_found(path, found, told.velocity_over)
    }
}

/// Makes a record of what was found.
fn of_found(path: &Path, found: Found, velocity_over: f64) -> Result<Record, RecordError> {
    let Found { what, mut rows, rate, frames, oriented, geometry, names, notes } = found;
    let wrong = |message: String| RecordError::wrong(path, message);
    rows.sort_unstable_by_key(|row| (row.id, row.frame, row.n));
    if let Some(pair) =
        rows.windows(2).find(|pair| (pair[0].id, pair[0].frame) == (pair[1].id, pair[1].frame))
    {
        let (Row { id, frame, n, .. }, before) = (pair[1], pair[0].n);
        return Err(wrong(format!(
            "{what} {n}: id {id} stands twice in frame {frame}, also in {what} {before}"
        )));
    }
    let (Some(first), Some(last)) =
        (rows.iter().map(|row| row.frame).min(), rows.iter().map(|row| row.frame).max())
    else {
        return Err(wrong("holds no row: nobody is in it".into()));
    };
    let named = frames.unwrap_or(FrameNumbers { first, last, step: 0 });
    let (first, last) = (named.first.min(first), named.last.max(last));
    // A file may have every n-th frame only.
    let of_named = [named.first - first, last - first, named.step];
    let step = rows.iter().map(|row| row.frame - first).chain(of_named).fold(0, gcd).max(1);
    let mut ids: Vec<i64> = Vec::new();
    for row in &mut rows {
        if ids.last() != Some(&row.id) {
            ids.push(row.id);
        }
        row.person = ids.len() as u32 - 1;
        row.frame = (row.frame - first) / step;
    }
    let count = ((last - first) / step) as u64 + 1;
    if count > MOST_FRAMES || count * ids.len() as u64 > MOST_PLACES {
        return Err(wrong(format!(
            "from frame {first} to {last} there are {count} frames, with places for {} people: there may be 1e7 frames, \
             and 1e8 frames times people",
            ids.len()
        )));
    }
    let rate = rate / step as f64;
    let velocity_frames = ((0.5 * velocity_over * rate).round().max(1.0) as usize).min(MOST_ROWS);
    differentiate(&mut rows, velocity_frames, rate);
    // Before they appear, people stand where they will.
    let mut agents = vec![Motion::default(); ids.len()];
    for row in rows.iter().rev() {
        agents[row.person as usize] = standing(row);
    }
    let appear = rows.len() as u64 != count * ids.len() as u64;
    rows.sort_unstable_by_key(|row| (row.frame, row.person));
    let name_of = |id: &i64| match &names {
        Some(names) => names[*id as usize].clone(),
        None => id.to_string(),
    };
    let (start, ids): (f64, Vec<String>) = (first as f64 / step as f64, ids.iter().map(name_of).collect());
    let pass = move |each: &mut Each<'_>| {
        let (mut agents, mut rows) = (agents.clone(), rows.as_slice());
        let mut active = vec![false; ids.len()];
        for k in 0..count as i64 {
            let (seen, later) = rows.split_at(rows.partition_point(|row| row.frame == k));
            rows = later;
            for (agent, _) in agents.iter_mut().zip(&active).filter(|(_, was)| **was) {
                agent.twist = Twist::default();
            }
            active.fill(false);
            for row in seen {
                let twist = Twist { velocity: row.velocity, angular_velocity: f64::NAN };
                agents[row.person as usize] = Motion { twist, ..standing(row) };
                active[row.person as usize] = true;
            }
            each(Frame {
                time: (start + k as f64) / rate,
                agents: agents.clone(),
                active: appear.then(|| active.clone()),
                place: format!("frame {}", first + k * step),
                ..Frame::default()
            })?;
        }
        Ok(ids.clone())
    };
    let about = Trajectories { rate, velocity_frames, oriented, geometry, notes };
    Ok(Record::new(path, pass)?.of_trajectories(about))
}

fn gcd(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

fn standing(row: &Row) -> Motion {
    let pose = Pose { position: row.position, orientation: row.orientation };
    Motion { pose, twist: Twist::default() }
}

/// Sets velocities of rows that are sorted by person and frame: of each stretch of frames without a gap, the difference of
/// the positions so many frames before and after; where one of them is missing, of the position in between and the other.
fn differentiate(rows: &mut [Row], frames: usize, rate: f64) {
    let next = |a: &Row, b: &Row| a.person == b.person && b.frame == a.frame + 1;
    for stretch in rows.chunk_by_mut(next) {
        for k in 0..stretch.len() {
            let before = k.checked_sub(frames).unwrap_or(k);
            let after = if k + frames < stretch.len() { k + frames } else { k };
            if after > before {
                let (way, time) =
                    (stretch[after].position - stretch[before].position, (after - before) as f64 / rate);
                stretch[k].velocity = way * (1.0 / time);
            }
        }
    }
}
