//! The tables of a measurement, as CSV.
//!
//! All files are written always, so that none of an earlier measurement stays beside new ones: of what was not asked for
//! there is only the line with the names of columns.

use super::Arguments;
use super::pass::{Seen, SeenLine};
use super::summary::{Piece, Summary};
use anyhow::Result;
use lemons_results::measure::{Above, By, Flow, Kept, Passage, SPANS, Way, windows};
use serde::Serialize;

/// The names of the tables, each with its content for people with these Ids.
pub fn of(
    arguments: &Arguments,
    ids: &[String],
    summary: &Summary,
    seen: &Seen<'_>,
) -> Result<Vec<(&'static str, String)>> {
    let people = people(arguments, ids, seen);
    let all = [flow(arguments, seen), gaps(ids, seen), density(seen), people, walls(summary)];
    NAMES.into_iter().zip(all).map(|(name, table)| Ok((name, table?))).collect()
}

/// Names of the tables.
pub const NAMES: [&str; 5] = ["flow", "gaps", "density", "people", "walls"];

/// Returns a table as CSV, the names of its columns first. Its numbers read back to the same doubles; what is not known is
/// an empty cell.
fn csv(names: &[impl AsRef<[u8]>], rows: impl IntoIterator<Item = impl Serialize>) -> Result<String> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    writer.write_record(names)?;
    rows.into_iter().try_for_each(|row| writer.serialize(row))?;
    Ok(String::from_utf8(writer.into_inner()?)?)
}

/// Each line in each direction, with its first passages.
pub fn directions<'a>(seen: &'a Seen<'_>) -> impl Iterator<Item = (&'a SeenLine<'a>, Way, Vec<Passage>)> {
    seen.lines.iter().flat_map(|line| Way::ALL.map(|way| (line, way, line.passages.first(way))))
}

/// A row for each window of each line and direction.
fn flow(arguments: &Arguments, seen: &Seen<'_>) -> Result<String> {
    let (from, until) = seen.times;
    let rows = directions(seen).flat_map(|(line, way, passages)| {
        let windows = windows(&passages, from, until, arguments.window).into_iter();
        windows.map(move |window| {
            let flow = window.flow();
            (line.name, way.name(), window.from, window.until, window.count, flow, flow / line.width)
        })
    });
    csv(&["line", "direction", "from", "until", "people", "flow", "specific_flow"], rows)
}

/// A row for each first passage: N(t), and the time gap since the one before.
fn gaps(ids: &[String], seen: &Seen<'_>) -> Result<String> {
    let rows = directions(seen).flat_map(|(line, way, passages)| {
        let gaps = [None].into_iter().chain(Flow::of(&passages).gaps.into_iter().map(Some));
        let numbered = (1..).zip(passages).zip(gaps);
        let row = move |((n, Passage { time, agent }), gap): ((u64, Passage), Option<f64>)| {
            (line.name, way.name(), n, time, &ids[agent], gap)
        };
        numbered.map(row)
    });
    csv(&["line", "direction", "n", "t", "id", "gap"], rows)
}

/// A row for each area and frame.
fn density(seen: &Seen<'_>) -> Result<String> {
    let rows = seen.areas.iter().flat_map(|area| {
        area.over_time
            .iter()
            .map(|at| (area.name, at.time, at.people, at.density, at.voronoi_density, at.speed))
    });
    csv(&["area", "t", "people", "density", "voronoi_density", "speed"], rows)
}

/// A row for each person.
fn people(arguments: &Arguments, ids: &[String], seen: &Seen<'_>) -> Result<String> {
    let over = arguments.over.map_or(String::new(), |over| format!("_over_{over}"));
    let mut names = vec!["id".to_owned(), "time".to_owned()];
    for what in ["time", "longest"] {
        names.extend(arguments.above.iter().map(|level| format!("{what}_above_{level}{over}")));
    }
    names.extend(SPANS.map(|span| format!("largest_mean_{span}")));
    names.extend(["peak", "impulse"].map(str::to_owned));
    for by in By::ALL.map(By::name) {
        names.extend(SPANS.map(|span| format!("largest_mean_{span}_by_{by}")));
        names.push(format!("impulse_by_{by}"));
    }
    if seen.balance.is_some() {
        names.extend(["time_unbalanced", "steps", "fallen", "lean"].map(str::to_owned));
    }
    let part = |by: usize, k: usize| {
        let one = seen.exposed_by.as_ref().map(|parts| &parts[by][k]);
        (one.map_or([None; SPANS.len()], |one| one.largest_mean), one.map(|one| one.impulse))
    };
    let known = seen.exposed.is_ok() || seen.balance.is_some();
    let row = ids.iter().enumerate().filter(|_| known).map(|(k, id)| {
        let one = seen.exposed.as_ref().ok().map(|all| &all[k]);
        let above = one.map_or(vec![None; arguments.above.len()], |one| one.above.clone());
        let above: Vec<_> = [|above: Above| above.time, |above: Above| above.longest]
            .iter()
            .flat_map(|of| above.iter().map(move |one| one.map(of)))
            .collect();
        let largest_mean = one.map_or([None; SPANS.len()], |one| one.largest_mean);
        let numbers = one.map(|one| (one.peak, one.impulse)).unzip();
        let all = (id, one.map(|one| one.time), above, largest_mean, numbers);
        let kept = seen.balance.iter().map(|kept| {
            let Kept { time_unbalanced, steps, fallen, lean } = kept[k];
            (time_unbalanced, steps, u8::from(fallen), lean)
        });
        (all, part(0, k), part(1, k), kept.collect::<Vec<_>>())
    });
    csv(&names, row)
}

/// A row for each straight piece of a wall.
fn walls(summary: &Summary) -> Result<String> {
    let names =
        ["segment", "wall", "x1", "y1", "x2", "y2", "largest_mean_step", "largest_mean_1", "peak", "impulse"];
    let row = |piece: &Piece| {
        let Piece { segment, from, to, largest_mean_step, largest_mean_1, peak, impulse, .. } = piece;
        (*segment, piece.wall.clone(), *from, *to, *largest_mean_step, *largest_mean_1, *peak, *impulse)
    };
    csv(&names, summary.walls.iter().flatten().map(row))
}
