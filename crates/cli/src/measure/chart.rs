//! The picture of a measurement: everything over time.

use super::Arguments;
use super::pass::{OVER, QUANTILES, Seen};
use lemons_picture::{Chart, ChartPanel, ChartStyle, Line, chart_svg};
use lemons_results::measure::{Density, Passage, Way, windows};

/// \[px\]
pub const WIDTH: u32 = 800;

/// Lines with these names share colours in all panels; what has another name has another colour.
#[derive(Default)]
struct Colours(Vec<String>);

impl Colours {
    fn line(&mut self, name: String, points: Vec<(f64, f64)>) -> Line {
        let known = self.0.iter().position(|known| *known == name);
        let group = known.unwrap_or_else(|| {
            self.0.push(name.clone());
            self.0.len() - 1
        });
        Line { name, points, group, dashed: false }
    }
}

fn panel(y: &str, lines: Vec<Line>, steps: bool) -> ChartPanel {
    ChartPanel { y: y.to_owned(), lines, steps }
}

/// Returns it as SVG. A panel without anything to show is left out.
pub fn svg(arguments: &Arguments, seen: &Seen<'_>) -> String {
    let mut colours = Colours::default();
    let (from, until) = seen.times;
    // A direction in which nobody crosses is left out.
    let crossed = seen.lines.iter().flat_map(|line| {
        Way::ALL.map(|way| (format!("{}, to the {}", line.name, way.name()), line.passages.first(way)))
    });
    let crossed: Vec<(String, Vec<Passage>)> = crossed.filter(|(_, passages)| !passages.is_empty()).collect();
    let counts = crossed.iter().map(|(name, passages)| {
        let mut points = vec![(from, 0.0)];
        points.extend(passages.iter().enumerate().map(|(n, passage)| (passage.time, (n + 1) as f64)));
        points.push((until, passages.len() as f64));
        colours.line(name.clone(), points)
    });
    let counts = counts.collect();
    let flows = crossed.iter().map(|(name, passages)| {
        let windows = windows(passages, from, until, arguments.window);
        let points = windows.iter().map(|window| (0.5 * (window.from + window.until), window.flow()));
        colours.line(name.clone(), points.collect())
    });
    let flows = flows.collect();
    let over = |value: fn(&Density) -> Option<f64>, colours: &mut Colours| -> Vec<Line> {
        let lines = seen.areas.iter().map(|area| {
            let points = area.over_time.iter().map(|seen| (seen.time, value(seen).unwrap_or(f64::NAN)));
            colours.line(format!("area {}", area.name), points.collect())
        });
        lines.collect()
    };
    let densities = over(|seen| seen.voronoi_density, &mut colours);
    let speeds = over(|seen| seen.speed, &mut colours);
    let squeezes = QUANTILES.iter().enumerate().map(|(k, part)| {
        let name = match part {
            0.5 => "median".to_owned(),
            1.0 => "greatest".to_owned(),
            part => format!("{} %", 100.0 * part),
        };
        let points = seen.spread.iter().map(|(time, at)| (*time, at[k])).collect();
        colours.line(name, points)
    });
    let squeezes = squeezes.collect();
    let panels = [
        panel("people across", counts, true),
        panel("flow (1/s)", flows, false),
        panel("Voronoi density (1/m²)", densities, false),
        panel("speed (m/s)", speeds, false),
        panel(&format!("mean squeeze over {OVER} s (N)"), squeezes, false),
    ];
    let shown = |panel: &ChartPanel| panel.lines.iter().any(|line| !line.points.is_empty());
    let chart = Chart {
        x: "time (s)".to_owned(),
        panels: panels.into_iter().filter(shown).collect(),
        noun: String::new(),
    };
    chart_svg(&chart, &ChartStyle { width: f64::from(WIDTH), ..ChartStyle::default() })
}
