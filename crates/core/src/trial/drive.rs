//! A drive file: the propulsion of agents over time.

use crate::files::input;
use crate::files::source::{FileSource, LocalFiles};
use crate::message::{Message, message};
use crate::rule::sentences::*;
use crate::trial::documents::Trial;
use crate::trial::problem::Problems;
use crate::xml::{Problem, decimal, quoted};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::f64::consts::PI;
use std::fmt::{Display, Write as _};
use std::io::Read;
use std::path::{Path, PathBuf};
use uuid::Uuid;

/// Name of the drive file in a Trial directory. An FMU holds it too, for masters that look for it.
pub const DRIVE_FILE: &str = "drive.csv";

/// \[s\] A drive that goes on has a row at this time.
pub const EVER: f64 = 1e6;

/// Fp.x \[N\], Fp.y \[N\], Mp \[N.m\].
pub type DriveValues = [f64; 3];

/// An error of the file, perhaps of a line of it.
fn error(line: Option<u64>, message: impl Into<Message>) -> Problem {
    Problem::of_file(Path::new(""), line.and_then(|line| u32::try_from(line).ok()), message)
}

type Result<T> = std::result::Result<T, Problems>;

/// The forces that drive people.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum DriveChoice {
    /// The Trial's own drive file, if it has one.
    #[default]
    Own,
    /// Only those of AgentDynamics.xml.
    None,
    /// This file.
    File(PathBuf),
}

/// Propulsion over time, from a CSV file with the columns `t,agent,Fp.x,Fp.y,Mp`. For each agent (by Id) it is
/// interpolated linearly between its rows, and is zero before the first and after the last.
#[derive(Debug, Default, Clone)]
pub struct DriveTable {
    agents: HashMap<String, Vec<(f64, DriveValues)>>,
    /// In the file, of the first row of each agent.
    lines: HashMap<String, u64>,
}

const HEAD: &str = "t,agent,Fp.x,Fp.y,Mp\n";

/// Returns a half sine at a share of its duration; `None` before and after.
pub fn half_sine(share: f64) -> Option<f64> {
    (0.0..=1.0).contains(&share).then(|| libm::sin(PI * share))
}

/// Returns where a Trial has its own drive.
pub fn own_drive(trial: &Trial) -> PathBuf {
    trial.directory.join(DRIVE_FILE)
}

impl DriveTable {
    /// Returns the drive of a Trial.
    ///
    /// # Errors
    /// The file has errors, or an agent in it is not in the Trial.
    pub fn of(trial: Option<&Trial>, choice: &DriveChoice) -> Result<DriveTable> {
        match (choice, trial) {
            (DriveChoice::File(path), _) => {
                DriveTable::read(input::open_bounded(path, input::LARGEST_DRIVE), trial, path)
            }
            (DriveChoice::Own, Some(trial)) => DriveTable::own(&LocalFiles, trial),
            (DriveChoice::Own, None) | (DriveChoice::None, _) => Ok(DriveTable::default()),
        }
    }

    /// Returns the drive that a Trial in these files has; empty without one.
    ///
    /// # Errors
    /// Those of [`DriveTable::of`].
    pub fn own(files: &dyn FileSource, trial: &Trial) -> Result<DriveTable> {
        let path = own_drive(trial);
        if files.lacks(&path) {
            return Ok(DriveTable::default());
        }
        let content = files.read(&path, input::LARGEST_DRIVE);
        DriveTable::read(content.as_deref(), Some(trial), &path)
    }

    fn read<E: Display>(
        content: std::result::Result<impl Read, E>,
        trial: Option<&Trial>,
        path: &Path,
    ) -> Result<DriveTable> {
        let read = || match content {
            Ok(content) => {
                let drive = DriveTable::from_csv(content)?;
                drive.check_agents(trial).map(|()| drive)
            }
            Err(unreadable) => Err(error(None, unreadable.to_string()).into()),
        };
        read().map_err(|problems| problems.of_file(path))
    }

    /// Checks that the Trial has all agents that the file names.
    ///
    /// # Errors
    /// It has not; each of them is named.
    pub fn check_agents(&self, trial: Option<&Trial>) -> Result<()> {
        self.check_ids(trial.iter().flat_map(|trial| &trial.agents).map(|agent| &*agent.id))
    }

    /// Checks that all agents that the file names are among these Ids.
    ///
    /// # Errors
    /// Some are not; each of them is named.
    pub fn check_ids<'a>(&self, known: impl Iterator<Item = &'a str>) -> Result<()> {
        let known: HashSet<&str> = known.collect();
        let mut unknown: Vec<_> = self.lines.iter().filter(|(id, _)| !known.contains(id.as_str())).collect();
        unknown.sort_by_key(|(_, line)| **line);
        let mut found = Problems::default();
        for (id, line) in unknown {
            found.push_counted(error(Some(*line), format!("there is no agent {} in Agents.xml", quoted(id))));
        }
        found.or(())
    }

    /// Reads the content of a file.
    ///
    /// # Errors
    /// The content has errors; each message names line, column and value.
    pub fn from_csv(content: impl Read) -> Result<DriveTable> {
        let mut reader =
            csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(content);
        let header = reader.headers().map_err(|wrong| error(None, message_of(wrong)))?.clone();
        let mut found = Problems::default();
        let mut column = |name: &'static str| {
            let named = |column: &str| column.trim_start_matches('\u{feff}') == name;
            let mut places = header.iter().enumerate().filter(|(_, column)| named(column));
            let wrong = match (places.next(), places.next()) {
                (Some((place, _)), None) => return place,
                (None, _) => "is no column",
                (Some(_), Some(_)) => "are two columns",
            };
            let message = format!("there {wrong} {name:?} (expected t,agent,Fp.x,Fp.y,Mp)");
            found.push(error(None, message));
            0
        };
        let (time, agent) = (column("t"), column("agent"));
        let push = [column("Fp.x"), column("Fp.y"), column("Mp")];
        found.or(())?;
        let (mut drive, mut found) = (DriveTable::default(), Problems::default());
        let mut record = csv::StringRecord::new();
        loop {
            match reader.read_record(&mut record) {
                Ok(true) => {}
                Ok(false) => break,
                Err(wrong) => {
                    // After an error of the disk nothing more can be read.
                    let (begin, is_last) = (wrong.position().map(csv::Position::line), wrong.is_io_error());
                    let line = begin.map(|begin| line_of(begin, reader.position().line(), 0));
                    found.push_counted(error(line, message_of(wrong)));
                    if is_last {
                        break;
                    }
                    continue;
                }
            }
            let begin = record.position().map_or(0, csv::Position::line);
            let within = record.as_slice().bytes().filter(|byte| *byte == b'\n').count() as u64;
            let line = line_of(begin, reader.position().line(), within);
            let mut number = |place: usize| {
                let text = &record[place];
                decimal(text).unwrap_or_else(|| {
                    let (column, text) = (quoted(&header[place]), quoted(text));
                    let column = column.trim_matches('"');
                    found.push_counted(error(Some(line), format!("{column}={text}: not a finite number")));
                    f64::NAN
                })
            };
            let row = (number(time), [number(push[0]), number(push[1]), number(push[2])]);
            let id = &record[agent];
            drive.lines.entry(id.to_owned()).or_insert(line);
            let rows = drive.agents.entry(id.to_owned()).or_default();
            if let Some(last) = rows.last().filter(|last| last.0 >= row.0) {
                let message = format!("t={} does not come after t={} of the same agent", row.0, last.0);
                found.push_counted(error(Some(line), message));
            }
            rows.push(row);
        }
        found.or(drive)
    }

    /// Adds an agent's rows, in the order of their times.
    pub fn add(&mut self, agent: &str, rows: Vec<(f64, DriveValues)>) {
        self.lines.insert(agent.to_owned(), self.lines.len() as u64);
        self.agents.insert(agent.to_owned(), rows);
    }

    /// Returns the same without agents who are not in the Trial.
    pub fn of_those(&self, trial: &Trial) -> DriveTable {
        let mut fewer = DriveTable::default();
        let named = trial.agents.iter().filter_map(|agent| Some((&agent.id, self.rows(&agent.id)?)));
        named.for_each(|(agent, rows)| fewer.add(agent, rows.to_vec()));
        fewer
    }

    /// Returns the drive file of those agents whom the Trial has; empty if it names none of them. Numbers are read back as
    /// the same doubles.
    pub fn text_for(&self, trial: &Trial) -> String {
        let mut text = String::new();
        for agent in &trial.agents {
            // With quotes, an Id may have any characters.
            let id = agent.id.replace('"', "\"\"");
            for (time, [x, y, torque]) in self.rows(&agent.id).unwrap_or_default() {
                // Writing to a text cannot fail.
                let _ = writeln!(text, "{time:?},\"{id}\",{x:?},{y:?},{torque:?}");
            }
        }
        if text.is_empty() { text } else { HEAD.to_owned() + &text }
    }

    /// Returns the agents that the file names.
    pub fn agents(&self) -> impl Iterator<Item = &str> {
        self.agents.keys().map(String::as_str)
    }

    /// Returns time \[s\] and push of each row of an agent; `None` if the file does not name it.
    pub fn rows(&self, agent: &str) -> Option<&[(f64, DriveValues)]> {
        self.agents.get(agent).map(Vec::as_slice)
    }

    /// Returns a text that is equal for equal pushes, however the file is written.
    pub fn fingerprint(&self) -> String {
        let sorted: BTreeMap<_, _> = self.agents.iter().collect();
        format!("{:032x}", Uuid::new_v5(&Uuid::NAMESPACE_OID, format!("{sorted:?}").as_bytes()).as_u128())
    }

    /// Returns the time \[s\] of the last row of all agents; `None` without rows.
    pub fn end(&self) -> Option<f64> {
        self.agents.values().flatten().map(|row| row.0).reduce(f64::max)
    }

    /// Returns the drive at a time \[s\] of an agent that is in the file; `None` for other agents.
    pub fn at(&self, agent: &str, time: f64) -> Option<DriveValues> {
        let rows = self.agents.get(agent)?;
        let after = rows.partition_point(|row| row.0 <= time);
        let push = match (after.checked_sub(1).map(|before| rows[before]), rows.get(after)) {
            (Some((t0, a)), Some((t1, b))) => {
                let share = match t1 - t0 {
                    whole if whole.is_finite() => (time - t0) / whole,
                    // Times so far apart that their difference is no number.
                    _ => (0.5 * time - 0.5 * t0) / (0.5 * t1 - 0.5 * t0),
                };
                std::array::from_fn(|k| match b[k] - a[k] {
                    change if change.is_finite() => a[k] + share * change,
                    _ => (1.0 - share) * a[k] + share * b[k],
                })
            }
            // The last row itself still counts.
            (Some((t0, a)), None) if t0 == time => a,
            _ => [0.0; 3],
        };
        Some(push)
    }
}

/// Returns the line of a row. Its reader began to read at one line, perhaps that of a comment before the row, and will go on at
/// another one; so many line ends are within the values.
fn line_of(begin: u64, next: u64, within: u64) -> u64 {
    next.saturating_sub(1 + within).max(begin)
}

/// Returns the text of an error without the words "CSV error" and without its line.
fn message_of(error: csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Io(error) => error.to_string(),
        csv::ErrorKind::Utf8 { .. } => "is not UTF-8 text".to_owned(),
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => {
            format!("has {len} values instead of {expected_len}")
        }
        _ => error.to_string(),
    }
}

impl DriveTable {
    /// Counts the rows after `start` that are not at a communication point, both \[s\], and all rows.
    pub fn between(&self, start: f64, step: f64) -> (usize, usize) {
        let is_between = |time: f64| {
            let steps = (time - start) / step;
            time > start && (steps - steps.round()).abs() > 1e-6
        };
        let rows = self.agents.values().flatten();
        (rows.clone().filter(|(time, _)| is_between(*time)).count(), rows.count())
    }

    /// Says what a run from `start` with a communication step, both \[s\], does not apply: the drive is what it is at the
    /// communication points. `None` unless the push of a row between two of them lies beyond both of theirs by more than
    /// half of the agent's largest one. Rows before the start are not looked at.
    pub fn missed(&self, start: f64, step: f64) -> Option<Message> {
        const COLUMNS: [&str; 3] = ["Fp.x", "Fp.y", "Mp"];
        let (mut rows, mut of, mut shortest) = (0, 0, f64::INFINITY);
        let mut worst: Option<(f64, Message)> = None;
        // In an order that does not change from run to run.
        for (agent, pushes) in self.agents.iter().collect::<BTreeMap<_, _>>() {
            let most = |k: usize| pushes.iter().map(|(_, push)| push[k].abs()).fold(0.0, f64::max);
            let most = [most(0), most(1), most(2)];
            of += pushes.len();
            shortest = pushes.windows(2).map(|rows| rows[1].0 - rows[0].0).fold(shortest, f64::min);
            for (place, (time, push)) in pushes.iter().enumerate().filter(|(_, row)| row.0 >= start) {
                // Between its neighbours a row has a share in what is applied.
                let last = place.checked_sub(1).map(|last| pushes[last].0);
                let next = pushes.get(place + 1).map(|next| next.0);
                let shares = |point: f64| {
                    last.map_or(point >= *time, |last| point > last)
                        && next.map_or(point <= *time, |next| point < next)
                };
                let first = ((last.unwrap_or(*time) - start) / step).floor().max(0.0);
                let unused = !(0..3).any(|k| shares(start + (first + f64::from(k)) * step));
                let before = start + ((time - start) / step).floor() * step;
                let after = before + step;
                let [a, b] = [before, after].map(|point| self.at(agent, point).unwrap_or_default());
                // By how much of the largest one.
                let by = |k: usize| {
                    let (low, high) = (a[k].min(b[k]), a[k].max(b[k]));
                    ((push[k] / most[k] - high / most[k]).max(low / most[k] - push[k] / most[k]), k)
                };
                let found =
                    (0..3).rev().filter(|&k| most[k] > 0.0).map(by).max_by(|a, b| a.0.total_cmp(&b.0));
                let found = found.filter(|(by, _)| *by > 0.5);
                rows += usize::from(unused || found.is_some());
                let Some((by, k)) = found else { continue };
                if worst.as_ref().is_none_or(|(most, _)| by > *most) {
                    let (column, push, first, second) = (COLUMNS[k], push[k], a[k], b[k]);
                    let message =
                        message!(NOT_APPLIED, time, agent, column, push, first, before, second, after);
                    worst = Some((by, message));
                }
            }
        }
        let (_, worst) = worst?;
        let come = if rows == 1 { message!(COMES) } else { message!(COME) };
        let all = shortest.is_finite().then(|| message!(APPLIES_ALL, step = shortest));
        Some(message!(ROWS_MISSED, rows, of, come, step, worst, all))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(text: &str) -> Result<DriveTable> {
        DriveTable::from_csv(text.as_bytes())
    }

    #[test]
    fn interpolates_inside_and_is_zero_outside() {
        let drive = drive("t,agent,Fp.x,Fp.y,Mp\n1,a,0,0,0\n2,a,100,-50,2\n2,b,1,1,1\n").unwrap();
        assert_eq!(drive.at("a", 0.5), Some([0.0; 3]));
        assert_eq!(drive.at("a", 1.25), Some([25.0, -12.5, 0.5]));
        assert_eq!(drive.at("a", 2.0), Some([100.0, -50.0, 2.0]));
        assert_eq!(drive.at("a", 2.1), Some([0.0; 3]));
        assert_eq!(drive.at("c", 1.5), None);
    }

    /// With a TimeStep of 50 s nobody was pushed, and nobody said so.
    #[test]
    fn rows_between_communication_points_are_missed_with_their_numbers() {
        let rows =
            "t,agent,Fp.x,Fp.y,Mp\n0,a,0,0,0\n0.3,a,600,0,0\n0.4,a,-1200,0,9\n0.6,a,0,0,0\n9,b,1,0,0\n";
        let drive = drive(rows).unwrap();
        let missed = drive.missed(0.0, 50.0).unwrap().text;
        let message = "4 of 5 rows come between communication points, which are 50.0 s apart, so they are not applied: at t = 0.4 s \
                    agent \"a\" has Fp.x = -1200.0, but the applied value is 0.0 from t = 0.0 s and 0.0 from t = 50.0 s; \
                    a communication step of 1.000e-1 s applies all rows (TimeStep, --step)";
        assert_eq!(missed, message);
        assert_eq!(drive.missed(0.0, 0.1), None);
        assert_eq!((drive.between(0.0, 0.1), drive.between(0.0, 0.2)), ((0, 5), (1, 5)));
        // A sample somewhere on its way is not the push, but it is applied.
        let missed = drive.missed(0.0, 0.7).unwrap().text;
        assert!(missed.starts_with("4 of 5 rows come between"), "{missed}");
        assert!(missed.contains("at t = 0.4 s agent \"a\""), "{missed}");
        assert_eq!(DriveTable::default().missed(0.0, 50.0), None);
        // Rows nearer to each other than the points are no fault of a slow drive.
        let slow: String = (0..1000).map(|k| format!("{:?},a,{k},0,0\n", 1e-3 * f64::from(k))).collect();
        let slow = self::drive(&format!("t,agent,Fp.x,Fp.y,Mp\n{slow}")).unwrap();
        assert_eq!(slow.missed(0.0, 0.05), None);
    }

    #[test]
    fn the_largest_forces_are_interpolated_too() {
        let rows = "t,agent,Fp.x,Fp.y,Mp\n0,a,-1e308,1e308,0\n1,a,1e308,-1e308,0\n";
        let drive = drive(rows).unwrap();
        assert_eq!(drive.at("a", 0.0), Some([-1e308, 1e308, 0.0]));
        assert_eq!(drive.at("a", 0.5), Some([0.0; 3]));
        assert_eq!(drive.at("a", 0.75), Some([0.75e308 - 0.25e308, 0.25e308 - 0.75e308, 0.0]));
        let drive = self::drive("t,agent,Fp.x,Fp.y,Mp\n-1e308,a,0,0,0\n1e308,a,4,0,0\n").unwrap();
        assert_eq!(drive.at("a", 0.0), Some([2.0, 0.0, 0.0]));
    }

    #[test]
    fn all_errors_are_said_each_with_its_line() {
        let error =
            drive("t,agent,Fp.x,Fp.y,Mp\n0,a,x,0,inf\n# a\n1,a,0\n2,a,0,0,0\n1,a,0,0,0\n").unwrap_err();
        let message = error.of_file(Path::new("T/drive.csv")).to_string();
        let expected = "T/drive.csv:2: Fp.x=\"x\": not a finite number\n\
                        T/drive.csv:2: Mp=\"inf\": not a finite number\n\
                        T/drive.csv:4: has 3 values instead of 5\n\
                        T/drive.csv:6: t=1 does not come after t=2 of the same agent";
        assert_eq!(message, expected);
        let many = format!("t,agent,Fp.x,Fp.y,Mp\n{}", "0,a,x,0,0\n".repeat(32));
        let message = drive(&many).unwrap_err().to_string();
        assert!(message.lines().count() == 21 && message.ends_with("and 43 more errors"), "{message}");
        let message = drive("t,agent,Fp.x,Mp,Mp\n").unwrap_err().to_string();
        assert!(
            message.contains("no column \"Fp.y\"") && message.contains("two columns \"Mp\""),
            "{message}"
        );
    }
}
