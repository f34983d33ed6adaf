//! Tables of other programs, whose first line names the columns: SUMO, Vadere, Viswalk, Pathfinder, crowd:it. Comments
//! may come before it.

use super::text::Lines;
use super::timed::{Timed, excerpt};
use super::{Found, MOST_ROWS, Told};
use crate::error::RecordError;
use csv_core::{ReadRecordResult, Reader, ReaderBuilder};
use lemons_core::plane::Vec2;
use std::fs::File;
use std::path::Path;

/// Largest number of columns.
const MOST_COLUMNS: usize = 1024;
/// \[1/s\] Frame rate of what moves in steps, if nothing else is said.
const RATE_OF_STEPS: f64 = 25.0;
/// Separators that are tried; `None` is white space.
const SEPARATORS: [Option<u8>; 3] = [Some(b';'), Some(b','), None];

/// Meaning of the rows of a table.
#[derive(Clone, Copy, PartialEq)]
enum Rule {
    Positions,
    /// Vehicles are among them, which have a lane, and no edge of their own.
    Fcd {
        lane: &'static str,
        edge: &'static str,
    },
    /// A person goes in a line from the position at the time to that of these columns.
    Steps {
        time: &'static str,
        x: &'static str,
        y: &'static str,
    },
    /// Units may follow the names of columns; the last time may be that of the last person who leaves.
    Units,
}

/// Tables of a program.
pub(super) struct Program {
    pub name: &'static str,
    /// Its files, as [`READ`](super::READ) names them; `None` where it is named already.
    pub files: Option<&'static str>,
    /// Columns, or beginnings of them, that all its tables have, and no table of a run.
    known_by: &'static [&'static str],
    id: &'static str,
    time: &'static str,
    x: &'static str,
    y: &'static str,
    /// Where people look: degrees, clockwise from north.
    angle: Option<&'static str>,
    rule: Rule,
}

/// The first one whose columns are there counts. Where SUMO writes a table itself, people and vehicles have the columns
/// of whoever comes first; its script `xml2csv.py` gives each columns of their own.
pub(super) const PROGRAMS: &[Program] = &[
    Program {
        name: "SUMO",
        files: None,
        known_by: &["timestep_time", "person_"],
        id: "person_id",
        time: "timestep_time",
        x: "person_x",
        y: "person_y",
        angle: Some("person_angle"),
        rule: Rule::Fcd { lane: "person_lane", edge: "person_edge" },
    },
    Program {
        name: "SUMO",
        files: None,
        known_by: &["timestep_time", "vehicle_"],
        id: "vehicle_id",
        time: "timestep_time",
        x: "vehicle_x",
        y: "vehicle_y",
        angle: Some("vehicle_angle"),
        rule: Rule::Fcd { lane: "vehicle_lane", edge: "vehicle_edge" },
    },
    Program {
        name: "Vadere",
        files: Some("postvis.traj"),
        known_by: &["pedestrianId"],
        id: "pedestrianId",
        time: "simTime",
        x: "startX",
        y: "startY",
        angle: None,
        rule: Rule::Steps { time: "endTime", x: "endX", y: "endY" },
    },
    Program {
        name: "Viswalk",
        files: Some(".pp"),
        known_by: &["$PEDESTRIAN:"],
        id: "NO",
        time: "SIMSEC",
        x: "COORDCENTX",
        y: "COORDCENTY",
        angle: None,
        rule: Rule::Positions,
    },
    Program {
        name: "Pathfinder",
        files: Some("CSV"),
        known_by: &["t", "name", "v"],
        id: "id",
        time: "t",
        x: "x",
        y: "y",
        angle: None,
        rule: Rule::Units,
    },
    Program {
        name: "crowd:it",
        files: Some("CSV"),
        known_by: &["pedID", "posX"],
        id: "pedID",
        time: "time",
        x: "posX",
        y: "posY",
        angle: None,
        rule: Rule::Positions,
    },
];

impl Program {
    fn wrote(&self, heads: &[&str]) -> bool {
        let known = |mark: &&str| {
            let begin = mark.ends_with(['_', ':']);
            heads.iter().any(|head| head == mark || begin && head.starts_with(*mark))
        };
        self.known_by.iter().all(known)
    }
}

/// Returns whether a line is a comment of Vadere or Viswalk, or empty.
pub(super) fn is_comment(line: &str) -> bool {
    let line = line.trim();
    line.is_empty() || line.starts_with(['#', '*']) || line.starts_with("$VISION")
}

/// Returns whether a line names the columns of one of the programs.
pub(super) fn is_header(line: &str) -> bool {
    line.starts_with("$VISION") || header(line).is_some()
}

fn header(line: &str) -> Option<(&'static Program, Cells)> {
    SEPARATORS.iter().find_map(|separator| {
        let mut cells = Cells::new(*separator);
        cells.split(line).ok()?;
        let heads: Vec<&str> = cells.all().collect();
        Some((PROGRAMS.iter().find(|program| program.wrote(&heads))?, cells))
    })
}

/// The cells of a line.
struct Cells {
    /// `None`: white space.
    reader: Option<Reader>,
    text: Vec<u8>,
    ends: Vec<usize>,
    count: usize,
}

impl Cells {
    fn new(separator: Option<u8>) -> Cells {
        let reader = separator.map(|byte| ReaderBuilder::new().delimiter(byte).build());
        Cells { reader, text: Vec::new(), ends: vec![0; MOST_COLUMNS], count: 0 }
    }

    fn split(&mut self, line: &str) -> Result<(), String> {
        let line = line.trim_end_matches(['\r', '\n']);
        let too_many = || format!("has more than {MOST_COLUMNS} columns");
        self.text.clear();
        self.count = 0;
        let Some(reader) = &mut self.reader else {
            for word in line.split_whitespace() {
                self.text.extend(word.as_bytes());
                *self.ends.get_mut(self.count).ok_or_else(too_many)? = self.text.len();
                self.count += 1;
            }
            return Ok(());
        };
        self.text.resize(line.len() + 1, 0);
        reader.reset();
        let (result, _, text, ends) = reader.read_record(line.as_bytes(), &mut self.text, &mut self.ends);
        if result == ReadRecordResult::OutputEndsFull || ends == MOST_COLUMNS {
            return Err(too_many());
        }
        // Nothing more: this ends the record.
        let (_, _, _, last) = reader.read_record(&[], &mut self.text[text..], &mut self.ends[ends..]);
        self.count = ends + last;
        Ok(())
    }

    /// Returns a cell; an empty one, if it is not there.
    fn get(&self, k: usize) -> &str {
        let begin = if k == 0 { 0 } else { self.ends[k - 1] };
        let cell = if k < self.count { &self.text[begin..self.ends[k]] } else { &[] };
        std::str::from_utf8(cell).unwrap_or_default().trim()
    }

    fn all(&self) -> impl Iterator<Item = &str> {
        (0..self.count).map(|k| self.get(k).trim_start_matches('\u{feff}'))
    }

    /// Returns the place of a column. Viswalk names the table before the first one, Vadere its processor after most.
    fn place(&self, column: &str) -> Result<Option<usize>, String> {
        let is = |head: &str| {
            let head = head.strip_prefix("$PEDESTRIAN:").unwrap_or(head);
            head == column || head.strip_prefix(column).is_some_and(|end| end.starts_with("-PID"))
        };
        let mut places = self.all().enumerate().filter(|(_, head)| is(head));
        match (places.next(), places.next()) {
            (_, Some(_)) => Err(format!("there are two columns {column:?}")),
            (first, None) => Ok(first.map(|(place, _)| place)),
        }
    }
}

/// A step of a person, of Vadere.
struct Step {
    person: usize,
    n: u64,
    /// Time \[s\] and position \[m\] of begin and end.
    ends: [(f64, Vec2); 2],
}

pub(super) fn read(path: &Path, file: File, told: &Told) -> Result<Found, RecordError> {
    let (mut lines, mut timed) = (Lines::new(path, file), Timed::new(path));
    let (at, program, mut cells) = loop {
        let Some((n, line)) = lines.next()? else {
            return Err(RecordError::wrong(path, "holds no table: it has comments only"));
        };
        if !is_comment(line) {
            match header(line) {
                Some((program, cells)) => break (n, program, cells),
                None => {
                    let message =
                        format!("{}: is not the table of pedestrians ($PEDESTRIAN:…)", excerpt(line.trim()));
                    return Err(timed.rows.wrong(n, message));
                }
            }
        }
    };
    let Program { name, id, time, x, y, angle, rule, .. } = *program;
    let wrong =
        |timed: &Timed, n: u64, message: String| timed.rows.wrong(n, format!("table of {name}: {message}"));
    if told.per_metre.is_some_and(|units| units != 1.0) {
        return Err(wrong(&timed, at, "is in m: --unit is for texts with lines id frame x y z".into()));
    }
    let find = |column: &str| cells.place(column).map_err(|message| wrong(&timed, at, message));
    let need = |column: &str| {
        find(column)?.ok_or_else(|| wrong(&timed, at, format!("there is no column {column:?}")))
    };
    let places = [need(id)?, need(time)?, need(x)?, need(y)?];
    let angle = match angle {
        Some(column) => find(column)?.map(|k| (k, column)),
        None => None,
    };
    let (mut end, mut lane, mut edge) = ([0; 3], None, None);
    match rule {
        Rule::Steps { time, x, y } => end = [need(time)?, need(x)?, need(y)?],
        Rule::Fcd { lane: of_lane, edge: of_edge } => {
            (lane, edge) = (find(of_lane)?, find(of_edge)?);
            if lane.is_none() && edge.is_none() && id == "vehicle_id" {
                let message =
                    format!("without {of_lane:?} or {of_edge:?} people and vehicles cannot be told apart");
                return Err(wrong(&timed, at, message));
            }
        }
        Rule::Positions | Rule::Units => {}
    }
    let untold = matches!(rule, Rule::Fcd { .. }) && lane.is_none() && edge.is_none();
    let columns = cells.count;
    let mut steps: Vec<Step> = Vec::new();
    while let Some((n, line)) = lines.next()? {
        if is_comment(line) {
            continue;
        }
        cells.split(line).map_err(|message| timed.rows.wrong(n, message))?;
        if cells.count != columns {
            let message = format!("has {} columns, the header {columns}", cells.count);
            return Err(timed.rows.wrong(n, message));
        }
        let [own_id, own_time, own_x, own_y] = places.map(|k| cells.get(k));
        if rule == Rule::Units && n == at + 1 && own_time == "s" {
            for (column, unit) in [(x, own_x), (y, own_y)] {
                if unit != "m" {
                    return Err(timed
                        .rows
                        .wrong(n, format!("column {column}: is in {}: must be in m", excerpt(unit))));
                }
            }
            continue;
        }
        let begin = timed.time(n, time, own_time)?;
        if let Rule::Fcd { .. } = rule {
            // Times of vehicles are frames, too.
            timed.frame(n, begin)?;
            let vehicle = lane.is_some_and(|k| !cells.get(k).is_empty());
            if own_id.is_empty() || vehicle || edge.is_some_and(|k| cells.get(k).is_empty()) {
                continue;
            }
        }
        let person = timed.person(n, id, own_id)?;
        let position = timed.position(n, [x, y], [own_x, own_y])?;
        if let Rule::Steps { time, x, y } = rule {
            let [end_time, end_x, end_y] = end.map(|k| cells.get(k));
            let later = timed.time(n, time, end_time)?;
            if later < begin {
                let message = format!(
                    "column {time}: {} s is before {}, its begin",
                    excerpt(end_time),
                    excerpt(own_time)
                );
                return Err(timed.rows.wrong(n, message));
            }
            if steps.len() == MOST_ROWS {
                return Err(timed.rows.wrong(n, format!("there are more than {MOST_ROWS} rows: too many")));
            }
            let end = (later, timed.position(n, [x, y], [end_x, end_y])?);
            steps.push(Step { person, n, ends: [(begin, position), end] });
            continue;
        }
        let orientation = match angle {
            Some((k, column)) => from_north(timed.number(n, column, cells.get(k))?),
            None => f64::NAN,
        };
        timed.add(n, person, begin, position, orientation)?;
    }
    let mut found = match rule {
        Rule::Steps { .. } => along(timed, steps, told.rate)?,
        rule => timed.finish(told.rate, rule == Rule::Units)?,
    };
    if untold {
        found.notes.push("vehicles, if there are any, count as people: it has no lanes and edges".into());
    }
    Ok(found)
}

/// \[rad\] Returns the angle to the x axis for degrees, clockwise from north.
pub(super) fn from_north(degrees: f64) -> f64 {
    let angle = (90.0 - degrees).rem_euclid(360.0);
    (if angle > 180.0 { angle - 360.0 } else { angle }).to_radians()
}

/// Returns the positions at the frames, along steps. Between two steps people stand, or go on to the begin of the next one.
fn along(mut timed: Timed<'_>, mut steps: Vec<Step>, told: Option<f64>) -> Result<Found, RecordError> {
    let path = timed.rows.path;
    let rate = super::rate_of(path, None, Some(told.unwrap_or(RATE_OF_STEPS)))?;
    let (near, mut between) = (1e-9 * rate.max(1.0), 0);
    steps.sort_by(|a, b| a.person.cmp(&b.person).then(a.ends[0].0.total_cmp(&b.ends[0].0)));
    for steps in steps.chunk_by(|a, b| a.person == b.person) {
        if let Some(pair) = steps.windows(2).find(|pair| pair[1].ends[0].0 < pair[0].ends[1].0 - 1e-6) {
            let ([(time, _), _], [_, (end, _)]) = (pair[1].ends, pair[0].ends);
            let message = format!(
                "column simTime: {time:?} s: begins before the step of line {} ends, at {end:?} s",
                pair[0].n
            );
            return Err(timed.rows.wrong(pair[1].n, message));
        }
        let (last, first) = (&steps[steps.len() - 1], &steps[0]);
        // Before they fill the memory.
        if (last.ends[1].0 - first.ends[0].0) * rate > (MOST_ROWS - timed.rows.rows.len()) as f64 {
            let message = format!("there are more than {MOST_ROWS} rows, at {rate} a second: too many");
            return Err(timed.rows.wrong(last.n, message));
        }
        let mut corners = steps.iter().flat_map(|step| step.ends.map(|end| (step.n, end)));
        let Some((_, mut from)) = corners.next() else { continue };
        let mut frame = (from.0 * rate - near).ceil();
        let begin = frame;
        for (n, to) in corners {
            while frame <= to.0 * rate + near {
                let part = (frame / rate - from.0) / (to.0 - from.0);
                let part = if part.is_finite() { part.clamp(0.0, 1.0) } else { 1.0 };
                let position = from.1 + (to.1 - from.1) * part;
                timed.rows.add(n, steps[0].person as i64, frame as i64, position, f64::NAN)?;
                frame += 1.0;
            }
            from = to;
        }
        between += u64::from(frame == begin);
    }
    let mut notes = Vec::new();
    if told.is_none() {
        notes.push(format!("steps: positions are read {rate} times a second (--fps)"));
    }
    if between > 0 {
        notes.push(format!("left out are people who are there between two frames only: {between}"));
    }
    let frames = timed.rows.rows.iter().map(|row| row.frame);
    let ends = frames.clone().min().zip(frames.max());
    // Every frame, even if all people are in every second one.
    let named = ends.map(|(first, last)| super::FrameNumbers { first, last, step: 1 });
    timed.found(rate, named, notes)
}
