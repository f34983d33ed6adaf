//! The picture of a measurement: everything over time.

use super::Arguments;
use super::pass::OVER;
use super::summary::{QUANTILES, RunSummary};
use super::tables::directions;
use lemons_picture::{Chart, ChartPanel, ChartStyle, Curve, chart_svg};
use lemons_results::measure::{Density, Passage, windows};

/// \[px\]
pub const WIDTH: u32 = 800;

/// Returns it as SVG. A panel without anything to show is left out.
pub fn svg(arguments: &Arguments, summary: &RunSummary) -> String {
    // Lines with the same name share a colour in all panels.
    let mut names: Vec<String> = Vec::new();
    let mut line = |name: String, points: Vec<(f64, f64)>| {
        let group = names.iter().position(|known| *known == name).unwrap_or(names.len());
        if group == names.len() {
            names.push(name.clone());
        }
        Curve { name, points, group, dashed: false }
    };
    let RunSummary { from, until, .. } = *summary;
    // A direction in which nobody crosses is left out.
    let crossed = directions(summary).filter(|(.., passages)| !passages.is_empty());
    let crossed: Vec<(String, Vec<Passage>)> = crossed
        .map(|(of, way, passages)| (format!("{}, to the {}", of.name, way.name()), passages))
        .collect();
    let counts = crossed.iter().map(|(name, passages)| {
        let rises = passages.iter().enumerate().map(|(n, passage)| (passage.time, (n + 1) as f64));
        let end = (until, passages.len() as f64);
        line(name.clone(), [(from, 0.0)].into_iter().chain(rises).chain([end]).collect())
    });
    let counts = counts.collect();
    let flows = crossed.iter().map(|(name, passages)| {
        let windows = windows(passages, from, until, arguments.window);
        let points = windows.iter().map(|window| (0.5 * (window.from + window.until), window.flow()));
        line(name.clone(), points.collect())
    });
    let flows = flows.collect();
    let mut over = |value: fn(&Density) -> Option<f64>| -> Vec<Curve> {
        let lines = summary.areas.iter().map(|area| {
            let points = area.over_time.iter().map(|seen| (seen.time, value(seen).unwrap_or(f64::NAN)));
            line(format!("area {}", area.name), points.collect())
        });
        lines.collect()
    };
    let (densities, speeds) = (over(|seen| seen.voronoi_density), over(|seen| seen.speed));
    let squeezes = QUANTILES.iter().enumerate().map(|(k, part)| {
        let name = match part {
            0.5 => "median".to_owned(),
            1.0 => "greatest".to_owned(),
            part => format!("{} %", 100.0 * part),
        };
        line(name, summary.spread.iter().map(|(time, at)| (*time, at[k])).collect())
    });
    let panels: [(String, Vec<Curve>); 5] = [
        ("people across".to_owned(), counts),
        ("flow (1/s)".to_owned(), flows),
        ("Voronoi density (1/m²)".to_owned(), densities),
        ("speed (m/s)".to_owned(), speeds),
        (format!("mean squeeze over {OVER} s (N)"), squeezes.collect()),
    ];
    let shown = panels
        .into_iter()
        .enumerate()
        .filter(|(_, (_, lines))| lines.iter().any(|line| !line.points.is_empty()));
    let panels = shown.map(|(place, (y, lines))| ChartPanel { y, lines, steps: place == 0 }).collect();
    let chart = Chart { x: "time (s)".to_owned(), panels, noun: String::new() };
    chart_svg(&chart, &ChartStyle { width: f64::from(WIDTH), ..ChartStyle::default() })
}
