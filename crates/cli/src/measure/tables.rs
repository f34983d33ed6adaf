//! The tables of a measurement, as CSV.
//!
//! All files are written always, so that none of an earlier measurement stays beside new ones: of what was not asked for
//! there is only the line with the names of columns.

use super::Arguments;
use super::summary::{OfArea, OfLine, OfPart, RunSummary, SqueezeSummary};
use anyhow::Result;
use lemons_results::measure::{Above, By, Flow, Kept, Passage, SPANS, Way, windows};
use serde::Serialize;

/// The names of the tables, each with its content for people with these Ids.
pub fn of(
    arguments: &Arguments,
    ids: &[String],
    summary: &RunSummary,
) -> Result<Vec<(&'static str, String)>> {
    let (flow, people) = (flow(arguments.window, summary), people(arguments, ids, summary));
    let breathing = breathing(ids, summary);
    let all =
        [flow, gaps(ids, summary), density(summary), people, walls(summary), panels(summary), breathing];
    NAMES.into_iter().zip(all).map(|(name, table)| Ok((name, table?))).collect()
}

/// Names of the tables.
pub const NAMES: [&str; 7] = ["flow", "gaps", "density", "people", "walls", "panels", "breathing"];

/// The fields of a [`WallLoad`](lemons_results::measure::WallLoad).
const LOADS: [&str; 9] = [
    "length",
    "load_step",
    "load_1",
    "load_1_at",
    "load_10",
    "load_10_at",
    "load_peak",
    "load_peak_at",
    "impulse",
];

/// Returns a table as CSV, the names of its columns first. Its numbers read back to the same doubles; what is not known is
/// an empty cell.
fn csv(names: &[impl AsRef<[u8]>], rows: impl IntoIterator<Item = impl Serialize>) -> Result<String> {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    writer.write_record(names)?;
    rows.into_iter().try_for_each(|row| writer.serialize(row))?;
    Ok(String::from_utf8(writer.into_inner()?)?)
}

/// Each line in each direction, with its first passages.
pub fn directions(summary: &RunSummary) -> impl Iterator<Item = (&OfLine, Way, Vec<Passage>)> {
    summary.lines.iter().flat_map(|line| Way::ALL.map(|way| (line, way, line.passages.first(way))))
}

/// A row for each window \[s\] of each line and direction.
fn flow(window: f64, summary: &RunSummary) -> Result<String> {
    let rows = directions(summary).flat_map(|(line, way, passages)| {
        let windows = windows(&passages, summary.from, summary.until, window).into_iter();
        windows.map(move |window| {
            let flow = window.flow();
            (&line.name, way.name(), window.from, window.until, window.count, flow, flow / line.width)
        })
    });
    csv(&["line", "direction", "from", "until", "people", "flow", "specific_flow"], rows)
}

/// A row for each first passage: N(t), and the time gap since the one before.
fn gaps(ids: &[String], summary: &RunSummary) -> Result<String> {
    let rows = directions(summary).flat_map(|(line, way, passages)| {
        let gaps = [None].into_iter().chain(Flow::of(&passages).gaps.into_iter().map(Some));
        let numbered = (1..).zip(passages).zip(gaps);
        let row = move |((n, Passage { time, agent }), gap): ((u64, Passage), Option<f64>)| {
            (&line.name, way.name(), n, time, &ids[agent], gap)
        };
        numbered.map(row)
    });
    csv(&["line", "direction", "n", "t", "id", "gap"], rows)
}

/// A row for each area and frame.
fn density(summary: &RunSummary) -> Result<String> {
    let rows = summary.areas.iter().flat_map(|area| {
        let OfArea { name, over_time, .. } = area;
        over_time.iter().map(move |seen| (name, seen.time, seen))
    });
    csv(&["area", "t", "people", "density", "voronoi_density", "speed"], rows)
}

/// A row for each person.
fn people(arguments: &Arguments, ids: &[String], summary: &RunSummary) -> Result<String> {
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
    let RunSummary { exposure, balance, .. } = summary;
    let columns = names.len() - 1;
    if balance.is_some() {
        names.extend(["time_unbalanced", "steps", "fallen", "lean"].map(str::to_owned));
    }
    let squeeze = |all: &SqueezeSummary, k: usize| {
        let SqueezeSummary { each, by_people, by_walls, .. } = all;
        let one = &each[k];
        let above = [|above: Above| above.time, |above: Above| above.longest];
        let above = above.into_iter().flat_map(|of| one.above.iter().map(move |one| one.map(of)));
        let part = |part: &Option<OfPart>| {
            let one = part.as_ref().map(|part| &part.each[k]);
            let means = one.map_or([None; SPANS.len()], |one| one.largest_mean);
            means.into_iter().chain([one.map(|one| one.impulse)])
        };
        let numbers = [Some(one.time)].into_iter().chain(above).chain(one.largest_mean);
        let numbers = numbers.chain([Some(one.peak), Some(one.impulse)]);
        numbers.chain(part(by_people)).chain(part(by_walls)).collect()
    };
    let known = exposure.is_some() || balance.is_some();
    let row = ids.iter().enumerate().filter(|_| known).map(|(k, id)| {
        let numbers: Vec<Option<f64>> = exposure.as_ref().map_or(vec![None; columns], |all| squeeze(all, k));
        (id, numbers, balance.iter().map(|balance| &balance.each[k]).collect::<Vec<&Kept>>())
    });
    csv(&names, row)
}

/// A row for each person: the fields of a [`Breathing`](lemons_results::measure::Breathing).
fn breathing(ids: &[String], summary: &RunSummary) -> Result<String> {
    let names = [
        "id",
        "front",
        "side",
        "least",
        "dose",
        "critical_at",
        "critical_x",
        "critical_y",
        "critical_part",
        "above_623",
        "above_1112",
        "above_6227",
    ];
    let each = summary.breathing.iter().flat_map(|of| &of.each);
    csv(&names, ids.iter().zip(each))
}

/// A row for each panel.
fn panels(summary: &RunSummary) -> Result<String> {
    let names = ["panel", "wall", "x1", "y1", "x2", "y2"].into_iter().chain(LOADS).collect::<Vec<_>>();
    csv(&names, summary.panels.iter().flatten().map(|of| (&of.place, &of.load)))
}

/// A row for each wall.
fn walls(summary: &RunSummary) -> Result<String> {
    let names = ["wall"].into_iter().chain(LOADS).collect::<Vec<_>>();
    csv(&names, summary.walls.iter().flatten().map(|of| (&of.wall, &of.load)))
}
