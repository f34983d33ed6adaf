//! The tables of a measurement, as CSV.
//!
//! All files are written always, so that none of an earlier measurement stays beside new ones: of what was not asked for
//! there is only the line with the names of columns.

use super::Arguments;
use super::pass::Passed;
use super::summary::Summary;
use crate::output::Output;
use anyhow::{Context, Result};
use lemons_results::Record;
use lemons_results::measure::{Flow, SPANS, Way, windows};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Names of the tables.
pub const TABLES: [&str; 4] = ["flow", "gaps", "density", "people"];

/// What is written into a directory.
pub fn paths(directory: &Path) -> impl Iterator<Item = PathBuf> {
    let tables = TABLES.iter().map(|name| directory.join(format!("{name}.csv")));
    tables.chain([directory.join("summary.json")])
}

/// A number that reads back to the same double, or an empty cell.
fn cell(value: Option<f64>) -> String {
    value.map_or(String::new(), |value| format!("{value:?}"))
}

/// All tables.
pub fn of(
    arguments: &Arguments,
    record: &Record,
    passed: &Passed,
    summary: &Summary,
) -> [Rows; TABLES.len()] {
    [
        flow(arguments, passed),
        gaps(arguments, record, passed),
        density(arguments, passed),
        people(arguments, record, passed, summary),
    ]
}

/// Writes all files; they do not appear yet.
pub fn written(tables: &[Rows], directory: &Path, json: &str) -> Result<Vec<Output>> {
    std::fs::create_dir_all(directory).with_context(|| format!("cannot write {}", directory.display()))?;
    let mut files = paths(directory).map(|path| Output::claimed(&path)).collect::<Result<Vec<_>>>()?;
    for (file, rows) in files.iter_mut().zip(tables) {
        file.fill(|out| write(out, rows))?;
    }
    files[tables.len()].fill(|out| out.write_all(json.as_bytes()))?;
    Ok(files)
}

/// Cells, the names of the columns first.
pub type Rows = Vec<Vec<String>>;

/// Writes a table as CSV.
pub fn write(out: &mut impl Write, rows: &Rows) -> std::io::Result<()> {
    let mut writer = csv::Writer::from_writer(out);
    rows.iter().try_for_each(|row| writer.write_record(row).map_err(std::io::Error::from))?;
    writer.flush()
}

fn head(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// A row for each window of each line and direction.
fn flow(arguments: &Arguments, passed: &Passed) -> Rows {
    let mut rows = vec![head(&["line", "direction", "from", "until", "people", "flow", "specific_flow"])];
    let (from, until) = passed.times;
    for (k, (line, seen)) in arguments.lines.iter().zip(&passed.lines).enumerate() {
        for way in Way::ALL {
            for window in windows(&seen.first(way), from, until, arguments.window) {
                let specific = window.flow() / arguments.width_of(&line.what);
                let numbers = [window.flow(), specific].map(Some).map(cell);
                let mut row = vec![line.called(k), way.name().to_owned()];
                row.extend([window.from, window.until].map(Some).map(cell));
                row.push(window.count.to_string());
                row.extend(numbers);
                rows.push(row);
            }
        }
    }
    rows
}

/// A row for each first passage: N(t), and the time gap since the one before.
fn gaps(arguments: &Arguments, record: &Record, passed: &Passed) -> Rows {
    let mut rows = vec![head(&["line", "direction", "n", "t", "id", "gap"])];
    for (k, (line, seen)) in arguments.lines.iter().zip(&passed.lines).enumerate() {
        for way in Way::ALL {
            let passages = seen.first(way);
            let gaps = Flow::of(&passages).gaps;
            for (n, passage) in passages.iter().enumerate() {
                rows.push(vec![
                    line.called(k),
                    way.name().to_owned(),
                    (n + 1).to_string(),
                    cell(Some(passage.time)),
                    record.ids()[passage.agent].clone(),
                    cell(n.checked_sub(1).map(|before| gaps[before])),
                ]);
            }
        }
    }
    rows
}

/// A row for each area and frame.
fn density(arguments: &Arguments, passed: &Passed) -> Rows {
    let mut rows = vec![head(&["area", "t", "people", "density", "voronoi_density", "speed"])];
    for (k, (area, seen)) in arguments.areas.iter().zip(&passed.areas).enumerate() {
        for seen in seen {
            rows.push(vec![
                area.called(k),
                cell(Some(seen.time)),
                seen.people.to_string(),
                cell(Some(seen.density)),
                cell(seen.voronoi_density),
                cell(seen.speed),
            ]);
        }
    }
    rows
}

/// A row for each person.
fn people(arguments: &Arguments, record: &Record, passed: &Passed, summary: &Summary) -> Rows {
    let above = &arguments.above;
    let mut names = head(&["id", "time"]);
    let over = arguments.over.map_or(String::new(), |over| format!("_over_{over}"));
    names.extend(above.iter().map(|level| format!("time_above_{level}{over}")));
    names.extend(SPANS.iter().map(|span| format!("largest_mean_{span}")));
    names.extend(head(&["peak", "impulse"]));
    let mut rows = vec![names];
    let exposed = passed.exposed.as_deref().filter(|_| summary.exposure.is_some());
    for (id, one) in record.ids().iter().zip(exposed.unwrap_or_default()) {
        let mut row = vec![id.clone(), cell(Some(one.time))];
        row.extend(one.above.iter().copied().map(cell));
        row.extend(one.largest_mean.map(cell));
        row.extend([one.peak, one.impulse].map(Some).map(cell));
        rows.push(row);
    }
    rows
}
