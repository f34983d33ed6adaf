//! The tables of a measurement, as CSV.
//!
//! All files are written always, so that none of an earlier measurement stays beside new ones: of what was not asked for
//! there is only the line with the names of columns.

use super::Arguments;
use super::pass::{Seen, SeenLine};
use crate::output::Output;
use anyhow::{Context, Result};
use lemons_results::measure::{Flow, Passage, SPANS, Way, windows};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Names of the tables.
const TABLES: [&str; 4] = ["flow", "gaps", "density", "people"];

/// Returns what is written into a directory.
pub fn paths(directory: &Path) -> impl Iterator<Item = PathBuf> {
    let tables = TABLES.iter().map(|name| directory.join(format!("{name}.csv")));
    tables.chain([directory.join("summary.json")])
}

/// Returns all tables as CSV, by their names, for people with these Ids.
pub fn of(arguments: &Arguments, ids: &[String], seen: &Seen<'_>) -> Result<Vec<(&'static str, String)>> {
    let all = [flow(arguments, seen), gaps(ids, seen), density(seen), people(arguments, ids, seen)];
    let named = TABLES.into_iter().zip(all);
    named.map(|(name, rows)| Ok((name, csv_of(&rows)?))).collect()
}

/// Writes all files; they do not appear yet.
pub fn written(tables: &[(&str, String)], directory: &Path, json: &str) -> Result<Vec<Output>> {
    std::fs::create_dir_all(directory).with_context(|| format!("cannot write {}", directory.display()))?;
    let mut files = paths(directory).map(|path| Output::claimed(&path)).collect::<Result<Vec<_>>>()?;
    let texts = tables.iter().map(|(_, text)| text.as_str()).chain([json]);
    for (file, text) in files.iter_mut().zip(texts) {
        file.fill(|out| out.write_all(text.as_bytes()))?;
    }
    Ok(files)
}

/// Cells, the names of the columns first.
type Rows = Vec<Vec<String>>;

fn csv_of(rows: &Rows) -> Result<String> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    rows.iter().try_for_each(|row| writer.write_record(row))?;
    Ok(String::from_utf8(writer.into_inner()?)?)
}

fn head(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).to_owned()).collect()
}

/// A number that reads back to the same double.
fn number(value: f64) -> String {
    format!("{value:?}")
}

/// A number, or an empty cell.
fn cell(value: Option<f64>) -> String {
    value.map_or(String::new(), number)
}

/// Each line in each direction, with its first passages.
fn directions<'a>(seen: &'a Seen<'_>) -> impl Iterator<Item = (&'a SeenLine<'a>, Way, Vec<Passage>)> {
    seen.lines.iter().flat_map(|line| Way::ALL.map(|way| (line, way, line.passages.first(way))))
}

/// A row for each window of each line and direction.
fn flow(arguments: &Arguments, seen: &Seen<'_>) -> Rows {
    let mut rows = vec![head(&["line", "direction", "from", "until", "people", "flow", "specific_flow"])];
    let (from, until) = seen.times;
    for (line, way, passages) in directions(seen) {
        for window in windows(&passages, from, until, arguments.window) {
            rows.push(vec![
                line.name.to_owned(),
                way.name().to_owned(),
                number(window.from),
                number(window.until),
                window.count.to_string(),
                number(window.flow()),
                number(window.flow() / line.width),
            ]);
        }
    }
    rows
}

/// A row for each first passage: N(t), and the time gap since the one before.
fn gaps(ids: &[String], seen: &Seen<'_>) -> Rows {
    let mut rows = vec![head(&["line", "direction", "n", "t", "id", "gap"])];
    for (line, way, passages) in directions(seen) {
        let gaps = Flow::of(&passages).gaps.into_iter().map(Some);
        for ((n, passage), gap) in (1..).zip(&passages).zip([None].into_iter().chain(gaps)) {
            rows.push(vec![
                line.name.to_owned(),
                way.name().to_owned(),
                i32::to_string(&n),
                number(passage.time),
                ids[passage.agent].clone(),
                cell(gap),
            ]);
        }
    }
    rows
}

/// A row for each area and frame.
fn density(seen: &Seen<'_>) -> Rows {
    let mut rows = vec![head(&["area", "t", "people", "density", "voronoi_density", "speed"])];
    for area in &seen.areas {
        rows.extend(area.over_time.iter().map(|seen| {
            vec![
                area.name.to_owned(),
                number(seen.time),
                seen.people.to_string(),
                number(seen.density),
                cell(seen.voronoi_density),
                cell(seen.speed),
            ]
        }));
    }
    rows
}

/// A row for each person.
fn people(arguments: &Arguments, ids: &[String], seen: &Seen<'_>) -> Rows {
    let mut names = head(&["id", "time"]);
    let over = arguments.over.map_or(String::new(), |over| format!("_over_{over}"));
    names.extend(arguments.above.iter().map(|level| format!("time_above_{level}{over}")));
    names.extend(SPANS.iter().map(|span| format!("largest_mean_{span}")));
    names.extend(head(&["peak", "impulse"]));
    let mut rows = vec![names];
    for (id, one) in ids.iter().zip(seen.exposed.iter().flatten()) {
        let known = one.above.iter().chain(&one.largest_mean).copied();
        let known = known.chain([one.peak, one.impulse].map(Some)).map(cell);
        rows.push([id.clone(), number(one.time)].into_iter().chain(known).collect());
    }
    rows
}
